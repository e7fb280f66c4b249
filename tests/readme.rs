//! The README, followed to the letter: its example, its picture, its links.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::Path;

use common::pneuval;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn readme() -> String {
    std::fs::read_to_string(root().join("README.md")).unwrap()
}

/// The fenced blocks of a language, in order.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    text.split(&fence).skip(1).map(|rest| rest.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_worked_example_works_as_written() {
    let text = readme();
    let (csv, toml) = (blocks(&text, "csv"), blocks(&text, "toml"));
    assert_eq!((csv.len(), toml.len()), (2, 2), "a log and an FEA table, an actuator and its bounds");
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("my-finger");
    std::fs::create_dir(&mine).unwrap();
    std::fs::write(mine.join("log.csv"), &csv[0]).unwrap();
    assert_eq!(pneuval(folder.path(), &["init", "my-finger", "--actuator", "my-finger"]).code, 0);
    let said = pneuval(folder.path(), &["validate", "my-finger", "--out", "first"]);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(folder.path().join("first/my-finger.html").is_file());
    std::fs::write(mine.join("fea.csv"), &csv[1]).unwrap();
    std::fs::write(mine.join("actuator.toml"), &toml[0]).unwrap();
    std::fs::write(mine.join("bounds.toml"), &toml[1]).unwrap();
    let validate = || pneuval(folder.path(), &["validate", "my-finger", "--out", "my-report"]);
    let said = validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("1 comparison · 1 pass"), "{}", said.out);
    assert_eq!(pneuval(folder.path(), &["gate", "my-report"]).code, 0);
    // The mistake the page shows, made.
    std::fs::write(mine.join("fea.csv"), csv[1].replace("20.5", "\"20,5\"")).unwrap();
    let said = validate();
    assert_eq!(said.code, 2);
    let shown = blocks(&text, "text").into_iter().find(|b| b.starts_with("error: my-finger")).unwrap();
    assert_eq!(said.err, shown);
}

/// The reference of every file is one folder that works.
#[test]
fn the_reference_of_files_is_a_folder_that_validates() {
    let text = std::fs::read_to_string(root().join("docs/files.md")).unwrap();
    let (csv, toml) = (blocks(&text, "csv"), blocks(&text, "toml"));
    let folder = tempfile::tempdir().unwrap();
    let files = ["session.toml", "rig.toml", "actuator.toml", "bounds.toml"];
    for (name, text) in files.iter().zip(&toml).chain(["log.csv", "fea.csv"].iter().zip(&csv)) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    std::fs::write(folder.path().join("sim.txt"), &blocks(&text, "sim")[0]).unwrap();
    assert_eq!((toml.len(), csv.len()), (4, 2));
    let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
    // The tip passes; the force has no model, the way of the tip no bound, and both stay open.
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(
        said.out.contains("1 pass") && said.out.contains("2 open") && said.out.contains("1 not counted"),
        "{}",
        said.out
    );
}

#[test]
fn the_rows_shown_are_the_rows_printed() {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["validate", "--out", "report"]);
    let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let printed: Vec<String> = said.out.lines().map(squeezed).collect();
    let shown = blocks(&readme(), "text").into_iter().find(|b| b.starts_with("$ pneuval validate")).unwrap();
    for line in shown.lines().filter(|l| !l.starts_with('$') && !l.starts_with('…')) {
        assert!(printed.contains(&squeezed(line)), "not printed: {line}\n{}", said.out);
    }
}

#[test]
fn the_picture_is_what_is_drawn_today() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(pneuval(folder.path(), &["validate", "--out", "report"]).code, 0);
    let drawn = folder.path().join("report/results/figures/internal-support_outer-diameter_response.png");
    let open = |path: &Path| image::open(path).unwrap().to_rgb8();
    let (committed, drawn) = (open(&root().join("docs/outer-diameter.png")), open(&drawn));
    assert_eq!(committed.dimensions(), drawn.dimensions());
    let differ =
        committed.pixels().zip(drawn.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 64));
    // Another machine's sine may move a line by a fraction of a pixel, never by its width.
    assert!(differ.count() < 200, "copy the new figure to docs/outer-diameter.png");
}

#[test]
fn every_link_of_the_documents_leads_somewhere() {
    for document in
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "datasets/README.md", "docs/files.md"]
    {
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        for target in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let local = !target.starts_with("http") && !target.starts_with('#');
            assert!(!local || root().join(document).parent().unwrap().join(target).exists(), "{document}: {target}");
        }
        // Paths named in code marks of the maps exist too.
        for path in text
            .split('`')
            .skip(1)
            .step_by(2)
            .filter(|p| p.contains('/') && Path::new(p).extension().is_some_and(|e| e == "rs") && !p.contains('<'))
        {
            assert!(root().join(path).exists(), "{document} names {path}");
        }
    }
}
