//! Data nobody expects: degenerate tables, enormous numbers, markup in names, several datasets of one actuator.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::sitting::{LOG, Sitting};
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
        ("-20,9,9\n-40,8,8\n", 0),
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
fn what_cannot_be_seen_is_shown_and_nothing_ends_where_it_should_not() {
    let lab = Lab::new();
    let hostile = format!("a\\u001b[31m\\u202eb]]>c|d`e\\nf::g%0Ah {}", "long".repeat(2500));
    lab.change("dataset.toml", "A made-up paper", &hostile);
    lab.change("dataset.toml", "title = \"Size\"", &format!("title = \"{hostile}\""));
    lab.change("actuator.toml", "title = \"Balloon\"", &format!("title = \"{hostile}\""));
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let read = |name: &str| std::fs::read_to_string(lab.path().join("report").join(name)).unwrap();
    for name in ["index.html", "balloon.html", "results/junit.xml", "results/summary.md", "results/points.csv"] {
        let text = read(name);
        let unseen = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!text.contains(unseen), "{name}: {:?}", text.chars().find(|c| unseen(*c)));
    }
    assert!(read("balloon.html").contains("a\\u{1b}[31m\\u{202e}b]]"), "shown as escapes");
    for format in ["table", "junit", "markdown", "github"] {
        let said = pneuval(lab.path(), &["gate", "report", "--format", format]);
        assert!(said.code == 0 && !said.out.contains(['\u{1b}', '\u{202e}']), "{format}: {}", said.out);
        assert!(format != "github" || said.out.lines().all(|line| line.starts_with("::")), "{}", said.out);
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

#[test]
fn what_was_written_can_be_drawn_again_byte_for_byte() {
    for rows in ["10,1e300,1\n20,1,1e300\n", "0,10,10\n", "10,NaN,1\n20,,2\n", "10,5,5\n20,5,5\n"] {
        let lab = Lab::new();
        lab.write("size.csv", &format!("p,model,measured\nkPa,mm,mm\n{rows}"));
        lab.bound("rmse", 1e6, "mm", "pass");
        lab.validate();
        assert_eq!(pneuval(lab.path(), &["report", "report", "--out", "again"]).code, 0, "{rows:?}");
        for page in ["index.html", "balloon.html", "results/results.json"] {
            let read = |out: &str| std::fs::read(lab.path().join(out).join(page)).unwrap();
            assert!(read("report") == read("again"), "{rows:?}: {page}");
        }
        // In place, from the report's own folder and from inside it.
        assert_eq!(pneuval(&lab.path().join("report"), &["report", "."]).code, 0);
        assert_eq!(pneuval(&lab.path().join("report"), &["report", "results"]).code, 0);
    }
}

#[test]
fn fits_that_cannot_be_made_say_so() {
    for (fit, word) in [
        ("{ to = \"measured\", parameters = [\"C10\", \"C10\"] }", "every parameter once"),
        ("{ to = \"measured\", parameters = [\"C11\"] }", "C10"),
        ("{ to = \"measured\", parameters = [] }", "at least one parameter"),
        ("{ to = \"nothing\", parameters = [\"C10\"] }", "a column of the table"),
        ("{ to = \"measured\", parameters = [\"C10\", \"C20\"] }", "not finite|finite"),
    ] {
        let lab = Lab::new();
        lab.write(
            "actuator.toml",
            &std::fs::read_to_string(datasets().join("actuators/internal-support.toml")).unwrap(),
        );
        lab.write("size.csv", "p,measured\nkPa,mm\n10,NaN\n20,34\n30,35\n");
        lab.change("dataset.toml", "actuator = \"balloon\"", "actuator = \"internal-support\"");
        lab.change("dataset.toml", "id = \"size\"", "id = \"outer-diameter\"");
        lab.change("dataset.toml", "chamber = \"air\"", "chamber = \"chamber\"");
        lab.change("dataset.toml", "predicted = [{ column = \"model\", form = \"model\", title = \"model\" }]\n", "");
        let new = format!("quantity = \"outer-diameter\"\nform = \"f\"\nmodel = \"consistent\"\nfit = {fit}");
        lab.change("dataset.toml", "quantity = \"size\"\nform = \"model\"", &new);
        let said = lab.validate();
        assert_eq!(said.code, 2, "{fit}: {}", said.out);
        assert!(word.split('|').any(|w| said.err.contains(w)), "{fit}: {}", said.err);
    }
}

#[test]
fn stored_results_that_lead_elsewhere_are_refused() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let file = lab.path().join("report/results/results.json");
    let text = std::fs::read_to_string(&file).unwrap();
    for (from, to) in [
        ("\"id\":\"balloon\"", "\"id\":\"../evil\""),
        ("\"dataset\":\"balloon\"", "\"dataset\":\"/tmp/evil\""),
        ("\"n_without_prediction\":0", "\"n_without_prediction\":18446744073709551615"),
        ("\"chambers\":[\"air\"", "\"chambers\":[\"air\",\"b\""),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        for command in [&["report", "report", "--out", "x/o"][..], &["gate", "report"]] {
            let said = pneuval(lab.path(), command);
            assert_eq!(said.code, 2, "{to}: {}", said.err);
        }
        assert!(!lab.path().join("x").exists() && !lab.path().join("evil.html").exists());
    }
}

#[test]
fn stored_points_of_another_width_are_refused() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let file = lab.path().join("report/results/results.json");
    let results: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    for (key, value) in [
        ("predicted", serde_json::json!([0.01, 0.02])),
        ("measured", serde_json::json!([])),
        ("measured_half_width", serde_json::json!([])),
        ("predicted_half_width", serde_json::json!([0.0, 0.0])),
        ("conditions_si", serde_json::json!([1.0])),
        ("predicted", serde_json::json!(0.01)),
    ] {
        let mut damaged = results.clone();
        damaged["comparisons"][0]["points"][0][key] = value;
        std::fs::write(&file, damaged.to_string()).unwrap();
        for command in [["report", "report"], ["gate", "report"]] {
            let said = pneuval(lab.path(), &command);
            assert_eq!(said.code, 2, "{key}: {}", said.err);
        }
    }
}

#[test]
fn a_remark_is_placeholders_and_not_a_programme() {
    let lab = Lab::new();
    let heavy = "{% for i in range(100000) %}{% for j in range(100000) %}x{% endfor %}{% endfor %}";
    lab.change("dataset.toml", "form = \"model\"\n", &format!("form = \"model\"\nremark = \"{heavy}\"\n"));
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("placeholders"), "{}", said.err);
}

#[cfg(unix)]
#[test]
fn pipes_and_links_that_lead_outside_are_refused() {
    let lab = Lab::new();
    let outside = tempfile::NamedTempFile::new().unwrap();
    std::fs::remove_file(lab.path().join("size.csv")).unwrap();
    std::os::unix::fs::symlink(outside.path(), lab.path().join("size.csv")).unwrap();
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("leads out of its folder"), "{}", said.err);
    std::fs::remove_file(lab.path().join("size.csv")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(lab.path().join("size.csv")).status().unwrap().success());
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("not a file"), "{}", said.err);
}

#[cfg(unix)]
#[test]
fn out_may_be_a_link_and_keeps_empty_folders_of_others() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    std::fs::create_dir(lab.path().join("there")).unwrap();
    std::os::unix::fs::symlink("there", lab.path().join("report")).unwrap();
    assert_eq!(lab.validate().code, 0);
    assert!(lab.path().join("there/index.html").is_file());
    std::fs::create_dir_all(lab.path().join("there/mine/empty")).unwrap();
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("mine"), "{}", said.err);
}

#[test]
fn the_parents_are_the_same_from_wherever_a_folder_is_named() {
    let lab = Lab::new();
    let (inner, other) = (lab.path().join("lab/mine"), lab.path().join("lab/cwd"));
    std::fs::create_dir_all(&inner).unwrap();
    std::fs::create_dir_all(&other).unwrap();
    for file in ["dataset.toml", "size.csv", "actuator.toml"] {
        std::fs::rename(lab.path().join(file), inner.join(file)).unwrap();
    }
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    // Bounds of a folder that is no parent, and too strict: they must not be found.
    let strict = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap().replace("3.1", "0.1");
    std::fs::write(other.join("bounds.toml"), strict).unwrap();
    let first = pneuval(lab.path(), &["validate", "lab/mine", "--out", "out"]);
    let second = pneuval(&other, &["validate", "../mine", "--out", "../../out2"]);
    assert_eq!((first.code, second.code), (0, 0), "{}{}", first.err, second.out);
    let read = |out: &str| std::fs::read(lab.path().join(out).join("results/results.json")).unwrap();
    assert!(read("out") == read("out2"));
}

#[test]
fn embedded_bounds_say_nothing_of_the_papers_to_somebody_elses_dataset() {
    let lab = Lab::new();
    lab.write("actuator.toml", &std::fs::read_to_string(datasets().join("actuators/internal-support.toml")).unwrap());
    lab.change("dataset.toml", "actuator = \"balloon\"", "actuator = \"internal-support\"");
    let said = lab.validate();
    assert_eq!((said.code, said.err.as_str()), (3, ""), "{}", said.out);
}

#[test]
fn names_of_channels_operators_and_files_are_text_everywhere() {
    // As a name in TOML and in the header of a log; the longest that a file may have is shorter.
    let column = format!("<script>alert(1)</script> 'q' ]]> \u{202e}x|`%0A::error:: {} [mm]", "long".repeat(2500));
    let file = "<script>x<\u{202e}script> 'q' ]]> \u{7} &amp; ${x} ::error::.csv";
    let operator = format!("</title><script>alert(2)</script>\\u0007\\u001b[31m]]>\\u202e{}", "long".repeat(2500));
    let sitting = Sitting::new();
    std::fs::remove_file(sitting.path().join("log.csv")).unwrap();
    let rows = LOG.lines().skip(1).enumerate().map(|(i, row)| format!("{i};{row}\n"));
    sitting.write(file, &format!("t (s);pressure (kPa);{column}\n{}5;x;1\n", rows.collect::<String>()));
    let quoted = |text: &str| format!("{text:?}").replace("\\u{202e}", "\\u202e").replace("\\u{7}", "\\u0007");
    sitting.change("session.toml", "\"stroke [mm]\"", &quoted(&column));
    sitting.change("session.toml", "\"log.csv\"", &quoted(file));
    let head = format!("actuator = \"my-bellows\"\noperator = \"{operator}\"\n\n[clock]\ncolumn = \"t (s)\"\n");
    sitting.change("session.toml", "actuator = \"my-bellows\"\n", &head);
    sitting.bound(100.0, "allow_single_repeat = true\n");
    let said = sitting.validate();
    assert!(said.code < 2 || said.code == 3, "{}", said.err);
    let unseen = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    assert!(!said.err.contains(unseen) && !said.out.contains(unseen), "{}", said.err);
    let acts = |line: &str| line.trim_start().starts_with("::");
    assert!(!said.err.lines().any(acts), "{}", said.err);
    let read = |name: &str| std::fs::read_to_string(sitting.path().join("report").join(name)).unwrap();
    for name in ["index.html", "my-bellows.html", "results/junit.xml", "results/summary.md", "results/points.csv"] {
        let text = read(name);
        assert!(!text.contains(unseen), "{name}: {:?}", text.chars().find(|c| unseen(*c)));
        assert!(!text.contains("<script>") || !name.ends_with("html"), "{name}");
    }
    let page = read("my-bellows.html");
    // Shown, not left out; and the log is drawn over time with what was found in it.
    assert!(
        page.contains("&lt;script&gt;alert(2)") && page.contains("\\u{202e}") && page.contains("channels over time")
    );
    assert!(page.matches("]]&gt;").count() >= 2, "quoted in page");
    let results = sitting.results();
    assert!(
        results["findings"].as_array().unwrap().iter().any(|f| f["file"].as_str().is_some_and(|name| name == file))
    );
}
