//! Data nobody expects: degenerate tables, enormous numbers, markup in names, several datasets of one actuator.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Lab, datasets, pneuval};

#[test]
fn degenerate_tables_are_reported_not_crashed_on() {
    for (rows, code) in [
        // No row at all, only the reference, one point, equal values, a vacuum.
        ("", 3),
        ("0,10,10\n", 3),
        ("10,10,10\n", 0),
        ("10,5,5\n20,5,5\n", 0),
        ("-10,9,9\n10,11,11\n", 0),
        // Too large to square, too small to see, of different size.
        ("10,1e300,1\n20,1,1e300\n", 3),
        ("10,1e-300,2e-300\n20,2e-300,1e-300\n", 0),
        ("10,1e12,1e-12\n", 1),
        ("1e9,10,10\n", 0),
        ("1e-9,10,10\n2e-9,10,10\n", 0),
    ] {
        let lab = Lab::new();
        lab.write("size.csv", &format!("p,model,measured\nkPa,mm,mm\n{rows}"));
        lab.bound("rmse", 1e6, "mm", "pass");
        let said = lab.validate();
        assert_eq!(said.code, code, "{rows:?}: {}{}", said.out, said.err);
        assert!(lab.path().join("report/index.html").is_file(), "{rows:?}");
    }
}

#[test]
fn a_table_longer_than_print_is_refused() {
    let lab = Lab::new();
    let rows: Vec<String> = (0..10_001).map(|i| format!("{i},10,10")).collect();
    lab.write("size.csv", &format!("p,model,measured\nkPa,mm,mm\n{}\n", rows.join("\n")));
    let said = lab.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("size.csv:10003") && said.err.contains("at most 10000 rows"), "{}", said.err);
}

#[test]
fn markup_in_names_is_text_on_the_page() {
    let lab = Lab::new();
    let hostile = "<script>alert(1)</script> & \\\"x\\\"";
    lab.change("dataset.toml", "A made-up paper", hostile);
    lab.change("dataset.toml", "title = \"Size\"", &format!("title = \"{hostile}\""));
    lab.change("actuator.toml", "title = \"Balloon\"", &format!("title = \"{hostile}\""));
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    for page in ["index.html", "balloon.html"] {
        let html = std::fs::read_to_string(lab.path().join("report").join(page)).unwrap();
        assert!(!html.contains("<script") && html.contains("&lt;script&gt;"), "{page}");
    }
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let lab = Lab::new();
    lab.change("size.csv", "21.000000", "2\u{1b}[31m1");
    let said = lab.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("\\u{1b}") && !said.err.contains('\u{1b}'), "{:?}", said.err);
    lab.change("dataset.toml", "id = \"balloon\"", "id = \"a\\u001b[31m\"");
    assert!(!lab.validate().err.contains('\u{1b}'));
}

#[test]
fn an_id_cannot_take_the_place_of_the_first_page() {
    let lab = Lab::new();
    lab.change("actuator.toml", "id = \"balloon\"", "id = \"index\"");
    lab.change("dataset.toml", "actuator = \"balloon\"", "actuator = \"index\"");
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("not `index`"), "{}", said.err);
}

#[test]
fn two_datasets_of_one_actuator_stay_apart() {
    let folder = tempfile::tempdir().unwrap();
    let published = datasets().join("published/internal-support");
    for (name, from, to) in [("first", "41.45", "41.45"), ("second", "41.45", "51.45")] {
        let mine = folder.path().join(name);
        std::fs::create_dir(&mine).unwrap();
        let text = std::fs::read_to_string(published.join("dataset.toml")).unwrap();
        std::fs::write(
            mine.join("dataset.toml"),
            text.replace("id = \"internal-support\"", &format!("id = \"{name}\"")),
        )
        .unwrap();
        let table = std::fs::read_to_string(published.join("outer_diameter.csv")).unwrap();
        std::fs::write(mine.join("outer_diameter.csv"), table.replace(from, to)).unwrap();
    }
    let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
    // The second measures 10 mm more at full pressure: the same predictions now fail.
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(
        said.out.contains("fail first/") || said.out.contains("fail second/outer-diameter/published-theory"),
        "{}",
        said.out
    );
    assert!(!said.out.contains("fail first/"), "{}", said.out);
    for name in ["first", "second"] {
        assert!(folder.path().join(format!("report/results/figures/{name}_outer-diameter_response.png")).is_file());
    }
    let page = std::fs::read_to_string(folder.path().join("report/internal-support.html")).unwrap();
    assert!(page.contains("Outer diameter (first)") && page.contains("Outer diameter (second)"));
}

#[test]
fn shared_bounds_may_hold_rows_for_others_and_say_so() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    let text = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap();
    let row = text.strip_prefix("schema = 1\n").unwrap();
    let other = row.replace("balloon", "stranger");
    let more = row.replace("\"model\"", "\"other-model\"");
    std::fs::write(lab.path().join("lab.toml"), format!("{text}{other}{more}")).unwrap();
    let said = pneuval(lab.path(), &["validate", ".", "--out", "report", "--bounds", "lab.toml"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.err.contains("stranger") && said.err.contains("other-model"), "{}", said.err);
    let page = std::fs::read_to_string(lab.path().join("report/index.html")).unwrap();
    assert!(page.contains("other-model met no comparison"));
}
