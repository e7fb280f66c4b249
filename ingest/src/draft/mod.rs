//! A first `session.toml` from logs that nobody has described yet: what a reader finds out, what can be guessed, and what only
//! the user knows.
//!
//! Every guess is marked as one in a comment. The drafts read as they are, but for the actuator's id.

mod parts;
mod text;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use parts::{Part, bare, parts, seems_pressure, take_clock, take_pressure};
use text::{ACTUATOR, COMPARISONS, bounds, one_line, quoted, rig, slug, titled, unique};

use crate::formats::lvm;
use crate::manifest::TO_FILL_IN;
use crate::recording::{Cells, Column, Recording, guessed_unit};
use crate::units::{Dimension, Unit};

/// Values of a text column that may name runs: fewer is one run, more is something else.
const RUNS_MAX: usize = 200;
/// Samples beyond which a log without a clock is no list of steady states.
const STATES_MAX: usize = 20_000;

/// The files of a first description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draft {
    /// `session.toml`.
    pub session: String,
    /// `rig.toml`.
    pub rig: String,
    /// `actuator.toml`.
    pub actuator: String,
    /// `bounds.toml`.
    pub bounds: String,
    /// What was guessed, for the terminal.
    pub guesses: Vec<String>,
}

/// Drafts the description of logs of one layout; `None` if they hold fewer than two columns of numbers beside the time.
///
/// `logs` are file names and contents, `actuator` the id if the user has said it, `chamber` its chamber if that is known.
pub fn draft(id: &str, logs: &[(String, Recording)], actuator: Option<&str>, chamber: Option<&str>) -> Option<Draft> {
    let (_, first) = logs.first()?;
    let mut guesses = Vec::new();
    let recordings: Vec<&Recording> = logs.iter().map(|(_, log)| log).collect();
    let mut parts = parts(&recordings, &mut guesses);
    let clock = take_clock(&mut parts, &mut guesses);
    if parts.len() < 2 {
        return None;
    }
    let pressure = take_pressure(&mut parts, &mut guesses);
    let samples: usize = logs.iter().flat_map(|(_, log)| &log.tables).map(|table| table.rows).sum();
    let rig_needed = pressure.unit.is_some_and(|unit| unit.dimension != Dimension::Pressure);

    let mut out = String::from("schema = 1\n");
    // Writing to a String cannot fail.
    let _ = writeln!(out, "id = {}", quoted(id));
    let _ = writeln!(
        out,
        "actuator = {}  # the id of an embedded actuator (`pneuval models`), or of your own actuator.toml",
        quoted(actuator.unwrap_or(TO_FILL_IN))
    );
    let hash = if rig_needed { "" } else { "# " };
    let _ = writeln!(out, "{hash}rig = \"bench\"  # the id of a rig.toml, if channels name instruments");
    out += "# date = \"2026-01-31\"\n# operator = \"\"\n# specimen = { serial = \"\", material_batch = \"\", cure = \"\", cycles_before = 0 }\n";
    let _ = writeln!(
        out,
        "\n# How the logs were read: {}. To override: [reader] with format, and for text delimiter, decimal, header, skip_lines or\n# comment.",
        first.format
    );
    for reason in &first.reasons {
        let _ = writeln!(out, "#   {}", one_line(reason));
    }
    let own_clock = pressure.table.clock.is_some();
    write_clock(&mut out, clock.as_ref(), &pressure, samples, &mut guesses);
    write_pressure(&mut out, &pressure, &mut guesses);
    write_channels(&mut out, &parts, &mut guesses);
    write_runs(&mut out, logs, &mut guesses);
    write_responses(
        &mut out,
        &pressure,
        &parts,
        own_clock || clock.is_some() || samples > STATES_MAX,
        chamber.unwrap_or("chamber"),
    );
    out += COMPARISONS;
    Some(Draft {
        session: out,
        rig: rig(rig_needed.then_some(&pressure)),
        actuator: ACTUATOR.to_owned(),
        bounds: bounds(actuator, &parts),
        guesses,
    })
}

/// How a session would name what a file holds: its clock, channels and run. `inspect` shows it.
pub fn block(file: &str, recording: &Recording) -> String {
    let mut guesses = Vec::new();
    let mut parts = parts(&[recording], &mut guesses);
    let clock = take_clock(&mut parts, &mut guesses);
    let mut out = String::new();
    if let Some(clock) = &clock {
        write_clock(&mut out, Some(clock), clock, 0, &mut guesses);
    }
    if seems_pressure(&parts).is_some() {
        let pressure = take_pressure(&mut parts, &mut guesses);
        write_pressure(&mut out, &pressure, &mut guesses);
    }
    write_channels(&mut out, &parts, &mut guesses);
    // Writing to a String cannot fail.
    let _ = writeln!(out, "\n[[run]]\nfile = {}", quoted(file));
    out.trim_start().to_owned()
}

fn write_clock(out: &mut String, clock: Option<&Part>, pressure: &Part, samples: usize, guesses: &mut Vec<String>) {
    out.push('\n');
    let Some(clock) = clock else {
        if let Some(own) = pressure.table.clock.and_then(|own| pressure.table.columns.get(own)) {
            let name = one_line(&pressure.table.full_name(&own.name));
            let _ = writeln!(
                out,
                "# The clock of each table is its own, as {name} is. [clock] takes `stamp` (header, publish, log), `column` or `rate`."
            );
        } else if samples > STATES_MAX {
            *out += "# No column of time was found. GUESS: say the true rate.\n[clock]\nrate = { value = 100, unit = \"Hz\" }\n";
            guesses.push("no column of time: 100 samples per second are assumed".to_owned());
        } else {
            *out += "# No column of time was found: every line is a steady state. [clock] takes `column` and `unit`, or `rate`.\n";
        }
        return;
    };
    let unit = clock.unit.filter(|unit| unit.dimension == Dimension::Time);
    let _ = writeln!(out, "[clock]\ncolumn = {}", clock.reference());
    if let Some(unit) = unit {
        let _ = writeln!(out, "unit = {}", quoted(unit.symbol));
    } else {
        let (guess, why) =
            clock.stamp_and_step().map_or((Unit::SECOND, "the log does not say".to_owned()), |(t, step)| {
                (guessed_unit(t, step), format!("from stamps as {t} and the usual step of {step}"))
            });
        let _ = writeln!(out, "unit = {}  # GUESS: {why}", quoted(guess.symbol));
        guesses.push(format!("the time is taken to be in {}", guess.symbol));
    }
}

fn write_pressure(out: &mut String, pressure: &Part, guesses: &mut Vec<String>) {
    *out += "\n[[channel]]\nid = \"pressure\"\n";
    let _ = writeln!(out, "column = {}", pressure.reference());
    match pressure.unit {
        Some(unit) if unit.dimension == Dimension::Pressure => {
            let _ = writeln!(out, "unit = {}", quoted(unit.symbol));
        }
        Some(_) => {
            *out += "instrument = \"pressure\"  # of rig.toml, where its calibration is to be filled in\n";
            guesses.push("the pressure is logged raw: fill in its calibration in rig.toml".to_owned());
        }
        None => {
            let _ = writeln!(out, "unit = \"kPa\"  # GUESS: {}", pressure.why_no_unit());
            guesses.push(format!("{} is taken to be in kPa", pressure.full_name()));
        }
    }
    *out += "reference = \"gauge\"  # GUESS: or \"absolute\", with `atmosphere` in every run\n";
    *out += "# commanded = true  # if it was asked of a regulator, not measured\n";
}

fn write_channels(out: &mut String, parts: &[Part], guesses: &mut Vec<String>) {
    for part in parts {
        let _ = writeln!(out, "\n[[channel]]\nid = {}\ncolumn = {}", quoted(&part.id), part.reference());
        if let Some(unit) = part.unit {
            let _ = writeln!(out, "unit = {}", quoted(unit.symbol));
            if unit.dimension == Dimension::Pressure {
                *out += "reference = \"gauge\"  # GUESS\n";
            }
        } else {
            let _ = writeln!(out, "unit = \"1\"  # GUESS: {}", part.why_no_unit());
            guesses.push(format!("{} is taken to be a plain number", part.full_name()));
        }
    }
}

fn write_runs(out: &mut String, logs: &[(String, Recording)], guesses: &mut Vec<String>) {
    *out += "\n# Runs of one session are repeats on one specimen: points at equal pressure are averaged. What is no repeat is a session\n# of its own.\n";
    let mut ids = BTreeSet::new();
    for (file, log) in logs {
        // What was noted while it ran names no runs.
        let mut columns = log.tables.iter().flat_map(|table| &table.columns).filter(|c| c.name != lvm::COMMENT);
        let names = columns.find_map(|column| Some((column, run_names(column)?)));
        let Some((column, names)) = names else {
            let _ = writeln!(out, "[[run]]\nfile = {}\n", quoted(file));
            continue;
        };
        guesses.push(format!("each text of `{}` in {file} is taken for a run", one_line(&column.name)));
        for (i, name) in names.iter().enumerate() {
            let id = unique(&slug(name, i + 1), &mut ids);
            let _ = writeln!(
                out,
                "[[run]]\nid = {}\nfile = {}\nrows = {{ column = {}, equals = {} }}  # GUESS\n",
                quoted(&id),
                quoted(file),
                quoted(&column.name),
                quoted(name)
            );
        }
    }
}

/// The texts of a column that seem to name runs, in the order of the log.
fn run_names(column: &Column) -> Option<Vec<&str>> {
    let Cells::Text(cells) = &column.cells else { return None };
    let mut names: Vec<&str> = Vec::new();
    let mut seen = BTreeSet::new();
    for cell in cells {
        if seen.insert(cell.as_str()) {
            names.push(cell);
        }
        if names.len() > RUNS_MAX {
            return None;
        }
    }
    let enough = names.len() >= 2 && names.len() * 2 <= cells.len() && names.iter().all(|name| !name.is_empty());
    enough.then_some(names)
}

fn write_responses(out: &mut String, pressure: &Part, parts: &[Part], plateaus: bool, chamber: &str) {
    *out += "# What is measured against pressure. Keep what has a model, or what you want to see.\n";
    let (here, elsewhere): (Vec<&Part>, Vec<&Part>) =
        parts.iter().partition(|part| std::ptr::eq(part.table, pressure.table));
    if let [first, ..] = elsewhere[..] {
        let _ = writeln!(
            out,
            "# {} from other topics than the pressure, {} for one, whose clocks are their own: declare\n# [[sync]] for events that both recorded, or clocks = \"one\", to measure them against it.",
            if elsewhere.len() == 1 {
                "1 channel comes".to_owned()
            } else {
                format!("{} channels come", elsewhere.len())
            },
            one_line(&first.table.name)
        );
    }
    for part in here {
        let unit = part.unit.map_or("1", |unit| unit.symbol);
        let _ = writeln!(
            out,
            "[[response]]\nquantity = {{ id = {}, title = {}, unit = {} }}\npressure = [{{ channel = \"pressure\", chamber = {} }}]\nmeasured = {{ channel = {}, method = \"\" }}",
            quoted(&part.id.replace('_', "-")),
            quoted(&titled(bare(part.column))),
            quoted(unit),
            quoted(chamber),
            quoted(&part.id)
        );
        if plateaus {
            let tolerance = pressure.tolerance();
            let _ = writeln!(
                out,
                "# GUESS: where the pressure stays within the tolerance for the hold, the mean over the window is a point.\npoints = {{ from = \"plateaus\", tolerance = {{ value = {tolerance}, unit = {} }}, hold = {{ value = 1, unit = \"s\" }}, window = {{ value = 0.5, unit = \"s\" }} }}",
                quoted(pressure.unit.filter(|u| u.dimension == Dimension::Pressure).map_or("kPa", |u| u.symbol))
            );
        } else {
            *out += "points = { from = \"samples\" }  # every line is a point; or from = \"plateaus\", which needs a clock\n";
        }
        out.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::csv::{CsvOptions, read};
    use crate::manifest::{ClockSpec, ColumnRef, PointRule, SessionManifest};

    fn drafted(text: &str) -> (SessionManifest, Draft) {
        let log = read("log.csv", text.as_bytes(), &CsvOptions::default()).unwrap();
        let draft = draft("monday", &[("log.csv".to_owned(), log.into())], Some("finger"), None).unwrap();
        let manifest = SessionManifest::read("session.toml", draft.session.as_bytes());
        (manifest.unwrap_or_else(|error| panic!("{error}\n{}", draft.session)), draft)
    }

    #[test]
    fn names_and_units_of_the_header_become_channels() {
        let (manifest, draft) = drafted("pressure (kPa),tip angle [deg],Force\n0,0,0\n10,5,0.1\n20,9,0.3\n");
        let ids: Vec<&str> = manifest.channels.iter().map(|c| c.id.as_str()).collect();
        assert_eq!(ids[0], "pressure");
        assert_eq!(manifest.channels[0].unit.map(|u| u.symbol), Some("kPa"));
        assert_eq!(manifest.channels[1].unit.map(|u| u.symbol), Some("deg"));
        assert_eq!(manifest.channels[2].unit.map(|u| u.symbol), Some("1"));
        assert_eq!(manifest.responses.len(), 2);
        assert_eq!(manifest.responses[0].points, PointRule::Samples { same_within_pa: 0.0 });
        assert!(draft.guesses.iter().any(|g| g.contains("Force")), "{:?}", draft.guesses);
    }

    #[test]
    fn a_log_without_a_pressure_is_shown_without_one() {
        let log =
            |text: &str| -> Recording { read("log.csv", text.as_bytes(), &CsvOptions::default()).unwrap().into() };
        let shown = block("gauge.csv", &log("t [s],force [N],No.\n0,0.1,1\n0.1,0.2,2\n0.2,0.3,3\n"));
        assert!(!shown.contains("pressure") && shown.contains("column = \"force [N]\"\nunit = \"N\""), "{shown}");
        // A draft needs one to set things against: what may be one is taken, and a force is none.
        let (manifest, _) = drafted("force [N],x\n0.1,1\n0.2,2\n0.3,3\n");
        assert_eq!(manifest.channels[0].column, ColumnRef::Name("x".to_owned()));
    }

    #[test]
    fn a_log_without_header_gets_numbers_a_clock_and_plateaus() {
        let rows: Vec<String> = (0..100).map(|i| format!("{}\t{}\t{}", 10 * i, i / 20, i % 7)).collect();
        let (manifest, _) = drafted(&rows.join("\r\n"));
        assert!(
            matches!(&manifest.clock, Some(ClockSpec::Column { column: ColumnRef::Number(1), unit: Some(unit), .. }) if unit.symbol == "ms")
        );
        assert_eq!(manifest.channels[0].column, ColumnRef::Number(2));
        assert!(matches!(manifest.responses[0].points, PointRule::Plateaus { .. }));
    }

    #[test]
    fn a_text_column_names_runs_and_odd_names_are_quoted() {
        let (manifest, _) = drafted("config;p;\"a \"\"b\"\" \\c\"\nX-1;0;1\nX-1;1;2\nY 2;0;3\nY 2;1;4\n");
        let runs: Vec<(&str, &str)> =
            manifest.runs.iter().map(|r| (r.id.as_str(), r.rows.as_ref().unwrap().1.as_str())).collect();
        assert_eq!(runs, [("x-1", "X-1"), ("y-2", "Y 2")]);
        assert_eq!(manifest.channels[1].column, ColumnRef::Name("a \"b\" \\c".to_owned()));
    }

    #[test]
    fn a_pressure_in_volts_asks_for_its_calibration() {
        let (manifest, draft) = drafted("t [s],pressure [V],laser [V]\n0,1,2\n0.1,1.5,2\n0.2,2,2.5\n");
        assert_eq!(manifest.channels[0].instrument.as_deref(), Some("pressure"));
        let rig = crate::manifest::Rig::read("rig.toml", draft.rig.as_bytes()).unwrap();
        assert_eq!(rig.instruments["pressure"].input.symbol, "V");
    }

    #[test]
    fn a_column_without_a_number_is_told_and_not_proposed() {
        let (manifest, draft) = drafted("p [kPa],empty [mm],d [mm]\n0,,0\n1,,1\n2,NaN,2\n");
        let ids: Vec<&str> = manifest.channels.iter().map(|c| c.id.as_str()).collect();
        assert_eq!(ids, ["pressure", "d"]);
        assert_eq!(manifest.responses.len(), 1);
        assert!(draft.guesses.iter().any(|g| g == "empty [mm] is left out: it holds no number in any log"));
        // A number in one of several logs is enough.
        let log =
            |text: &str| -> Recording { read("log.csv", text.as_bytes(), &CsvOptions::default()).unwrap().into() };
        let logs =
            [("a.csv".to_owned(), log("p,d,e\n0,0,\n1,1,\n")), ("b.csv".to_owned(), log("p,d,e\n0,0,5\n1,1,6\n"))];
        assert!(super::draft("x", &logs, None, None).unwrap().session.contains("id = \"e\""));
        assert!(super::draft("x", &[("a.csv".to_owned(), log("p,d\n0,\n1,\n"))], None, None).is_none());
    }

    #[test]
    fn equal_names_and_long_names_get_ids_of_their_own() {
        let long = "n".repeat(70);
        let header: Vec<String> = (0..30).map(|i| format!("{long}{i}")).collect();
        let cells = |value: usize| vec![value.to_string(); 30].join(",");
        let (manifest, _) =
            drafted(&format!("p,{}\n0,{}\n1,{}\n2,{}\n", header.join(","), cells(0), cells(1), cells(2)));
        let ids: BTreeSet<&str> = manifest.channels.iter().map(|c| c.id.as_str()).collect();
        assert_eq!(ids.len(), 31);
        assert!(ids.contains(format!("{}-30", "n".repeat(57)).as_str()), "{ids:?}");
        // Neither of the free ids of a pressure is one that the log has already.
        let (manifest, _) = drafted("Druck [kPa],Pressure,Pressure 2\n0,1,2\n1,2,3\n2,3,4\n");
        let ids: Vec<&str> = manifest.channels.iter().map(|c| c.id.as_str()).collect();
        assert_eq!(ids, ["pressure", "pressure-3", "pressure-2"]);
        let (manifest, _) = drafted("config,p,x\nA 1,0,0\nA 1,1,2\na-1,0,0\na-1,1,3\n");
        let ids: Vec<&str> = manifest.runs.iter().map(|r| r.id.as_str()).collect();
        assert_eq!(ids, ["a-1", "a-1-2"]);
    }

    #[test]
    fn stubs_read_and_one_column_is_no_session() {
        let (_, draft) = drafted("p,d\n0,1\n1,2\n");
        crate::manifest::Rig::read("rig.toml", draft.rig.as_bytes()).unwrap();
        let nothing =
            |_: &str| Err(crate::IngestError::read(std::path::Path::new("x"), std::io::ErrorKind::NotFound.into()));
        let actuator =
            crate::manifest::Actuator::read("actuator.toml", draft.actuator.as_bytes(), "finger", &nothing).unwrap();
        assert!(actuator.draft && actuator.id == "finger");
        let log = read("log.csv", b"d\n1\n2\n", &CsvOptions::default()).unwrap();
        assert!(super::draft("x", &[("log.csv".to_owned(), log.into())], None, None).is_none());
    }
}
