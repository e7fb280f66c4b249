//! What a terminal shows: colour where it is wanted, nothing that acts on a CI server, completions and man pages.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::Path;
use std::process::Command;

use common::{Lab, Said, pneuval};

fn painted(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_pneuval"))
        .current_dir(folder)
        .args(arguments)
        .env_remove("NO_COLOR")
        .envs(environment.iter().copied())
        .output()
        .unwrap();
    Said {
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

#[test]
fn colour_is_for_terminals_and_for_those_who_ask_and_changes_no_word() {
    let lab = Lab::new();
    lab.bound("rmse", 1.0, "mm", "pass");
    let plain = painted(lab.path(), &["validate", "--no-report", "."], &[]);
    assert_eq!(plain.code, 1, "{}", plain.err);
    // A pipe is no terminal.
    assert!(!plain.out.contains('\u{1b}') && !plain.err.contains('\u{1b}'));
    let forced = painted(lab.path(), &["validate", "--no-report", "."], &[("CLICOLOR_FORCE", "1")]);
    assert!(forced.out.contains("\u{1b}[1m\u{1b}[31mfail, expected to pass\u{1b}[0m"), "{:?}", forced.out);
    assert_eq!(anstream::adapter::strip_str(&forced.out).to_string(), plain.out);
    let refused = painted(lab.path(), &["validate", "--no-report", "."], &[("NO_COLOR", "1"), ("TERM", "xterm")]);
    assert_eq!(refused.out, plain.out);
    let wrong = painted(lab.path(), &["validate", "nowhere"], &[("CLICOLOR_FORCE", "1")]);
    assert!(wrong.code == 2 && wrong.err.starts_with("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m nowhere"), "{:?}", wrong.err);
}

#[test]
fn a_name_with_a_line_break_is_no_command_of_a_ci_server() {
    let lab = Lab::new();
    for name in ["a\n::error::x", "a\n  ##[error]x", "a\n##vso[task.complete]x"] {
        let said = pneuval(lab.path(), &["validate", name]);
        let acts =
            said.err.lines().any(|line| line.trim_start().starts_with("::") || line.trim_start().starts_with("##"));
        assert!(said.code == 2 && !acts && said.err.contains("a\\u{a}"), "{}", said.err);
    }
}

#[test]
fn no_progress_is_told_where_nobody_watches() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    let said = lab.validate();
    assert!(said.code == 0 && said.err.is_empty(), "{}", said.err);
}

#[test]
fn every_command_has_its_completion_and_its_page() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = pneuval(folder.path(), &["completions", shell]);
        assert!(said.code == 0 && said.out.contains("report-only") && said.out.contains("rehearse"), "{shell}");
    }
    // What bash makes of it, asked as bash asks.
    let script = pneuval(folder.path(), &["completions", "bash"]).out;
    let ask = "COMP_WORDS=(pneuval va); COMP_CWORD=1; _pneuval pneuval va pneuval; echo \"${COMPREPLY[@]}\"";
    let asked = Command::new("bash").arg("-c").arg(format!("{script}\n{ask}")).output().unwrap();
    assert_eq!(String::from_utf8(asked.stdout).unwrap().trim(), "validate");
    let said = pneuval(folder.path(), &["man", "--out", "pages"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let page = |name: &str| std::fs::read_to_string(folder.path().join("pages").join(name)).unwrap();
    assert!(page("pneuval.1").contains("Exit codes"));
    assert!(page("pneuval-validate.1").contains("report\\-only"));
    let help = pneuval(folder.path(), &["--help"]).out;
    let commands = help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let named = commands.take_while(|line| line.starts_with("  ")).filter(|line| !line.starts_with("   "));
    let named: Vec<&str> =
        named.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert!(named.len() >= 16, "{named:?}");
    for name in named {
        assert!(folder.path().join(format!("pages/pneuval-{name}.1")).is_file(), "{name}");
    }
}
