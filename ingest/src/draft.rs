//! A first `session.toml` from logs that nobody has described yet: what a reader finds out, what can be guessed, and what only
//! the user knows.
//!
//! Every guess is marked as one in a comment. The drafts read as they are, but for the actuator's id.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::finding::median_step;
use crate::formats::csv::TextLog;
use crate::manifest::TO_FILL_IN;
use crate::recording::{Cells, Column};
use crate::units::{Dimension, Unit};

/// Values of a text column that may name runs: fewer is one run, more is something else.
const RUNS_MAX: usize = 200;
/// Samples beyond which a log without a clock is no list of steady states.
const STATES_MAX: usize = 20_000;
/// Letters of an id: room is left for what a user adds.
const ID_LETTERS_MAX: usize = 60;
/// Names of pressures and of time, by which columns are told.
const PRESSURES: [&str; 6] = ["p", "pressure", "press", "druck", "kpa", "bar"];
const TIMES: [&str; 8] = ["t", "time", "timestamp", "stamp", "seconds", "elapsed", "zeit", "millis"];

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

/// A column with the part it seems to play.
struct Part<'a> {
    column: &'a Column,
    /// From 1.
    number: usize,
    /// A channel's id.
    id: String,
    unit: Option<Unit>,
}

impl Part<'_> {
    /// How the manifest names the column: by number where the header has no name of its own.
    fn reference(&self) -> String {
        if self.column.name == format!("column {}", self.number) {
            self.number.to_string()
        } else {
            quoted(&self.column.name)
        }
    }
}

/// Drafts the description of logs of one layout; `None` if they hold fewer than two columns of numbers beside the time.
///
/// `logs` are file names and contents, `actuator` the id if the user has said it, `chamber` its chamber if that is known.
pub fn draft(id: &str, logs: &[(String, TextLog)], actuator: Option<&str>, chamber: Option<&str>) -> Option<Draft> {
    let (_, first) = logs.first()?;
    let mut guesses = Vec::new();
    let mut parts = parts(logs, &mut guesses);
    let clock = take_clock(&mut parts, first, &mut guesses);
    if parts.len() < 2 {
        return None;
    }
    let pressure = take_pressure(&mut parts, &mut guesses);
    let samples: usize = logs.iter().map(|(_, log)| log.rows).sum();
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
    let layout = &first.layout;
    out +=
        "\n# How the logs were read. To override: [reader] with delimiter, decimal, header, skip_lines or comment.\n";
    for reason in &layout.reasons {
        let _ = writeln!(out, "#   {}", one_line(reason));
    }
    write_clock(&mut out, clock.as_ref(), samples, &mut guesses);
    write_channels(&mut out, &pressure, &parts, &mut guesses);
    write_runs(&mut out, logs, &mut guesses);
    write_responses(
        &mut out,
        &pressure,
        &parts,
        clock.is_some() || samples > STATES_MAX,
        logs,
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

/// The columns of numbers; one without any number in all logs is told and left out.
fn parts<'a>(logs: &'a [(String, TextLog)], guesses: &mut Vec<String>) -> Vec<Part<'a>> {
    let (mut ids, mut parts) = (BTreeSet::new(), Vec::new());
    let columns = logs.first().map_or(&[][..], |(_, log)| &log.columns);
    for (i, column) in columns.iter().enumerate().filter(|(_, column)| column.cells.numbers().is_some()) {
        if !numbers_of(logs, i).any(f64::is_finite) {
            guesses.push(format!("{} is left out: it holds no number in any log", one_line(&column.name)));
            continue;
        }
        let unit = column.unit.as_deref().and_then(Unit::parse_loose).map(|(unit, _)| unit);
        let id = unique(&slug(bare(column), i + 1), &mut ids);
        parts.push(Part { column, number: i + 1, id, unit });
    }
    parts
}

/// The cells of a column in all logs.
fn numbers_of(logs: &[(String, TextLog)], column: usize) -> impl Iterator<Item = f64> {
    logs.iter().filter_map(move |(_, log)| log.columns.get(column)?.cells.numbers()).flatten().copied()
}

/// The id, or where it is taken, the first free of `-2`, `-3` and so on behind it, cut to fit.
fn unique(id: &str, taken: &mut BTreeSet<String>) -> String {
    let (mut free, mut copy) = (id.to_owned(), 1);
    while !taken.insert(free.clone()) {
        copy += 1;
        let ending = format!("-{copy}");
        let room = id.len().min(ID_LETTERS_MAX - ending.len());
        // Ids are ASCII.
        free = format!("{}{ending}", id.get(..room).unwrap_or(id).trim_end_matches('-'));
    }
    free
}

/// The name of a column without the unit behind it: in brackets, or after `_` or `/`.
fn bare(column: &Column) -> &str {
    let name = column.name.trim();
    let cut = |open: char| name.rsplit_once(open).map(|(head, _)| head.trim());
    let head = match (&column.unit, name.chars().last()) {
        (Some(_), Some(')')) => cut('('),
        (Some(_), Some(']')) => cut('['),
        (Some(unit), _) => name.strip_suffix(unit.as_str()).and_then(|head| {
            let head = head.trim_end();
            head.strip_suffix('_').or_else(|| head.strip_suffix('/')).map(str::trim)
        }),
        _ => None,
    };
    head.filter(|head| !head.is_empty()).unwrap_or(name)
}

/// A name as a title: its first letter is a capital.
fn titled(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Words of a name in lower case.
fn words(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

fn named(part: &Part, names: &[&str]) -> bool {
    words(&part.column.name).iter().any(|word| names.contains(&word.as_str()))
}

/// Takes the column of stamps out of the parts: by unit, by name, or the first if it only rises.
fn take_clock<'a>(parts: &mut Vec<Part<'a>>, log: &TextLog, guesses: &mut Vec<String>) -> Option<Part<'a>> {
    let rises = |part: &Part| {
        let numbers = part.column.cells.numbers().unwrap_or_default();
        numbers.len() > 20 && numbers.windows(2).all(|pair| pair[1] > pair[0])
    };
    let by_unit = |part: &Part| part.unit.is_some_and(|unit| unit.dimension == Dimension::Time);
    let unnamed = log.layout.names.is_none();
    let i = parts
        .iter()
        .position(by_unit)
        .or_else(|| parts.iter().position(|p| p.unit.is_none() && named(p, &TIMES)))
        .or_else(|| parts.iter().position(|p| unnamed && p.number == 1 && rises(p)))?;
    let part = parts.remove(i);
    guesses.push(format!("{} is taken for the time", part.column.name));
    Some(part)
}

/// Takes the pressure out of the parts: by unit, by name, or the first.
fn take_pressure<'a>(parts: &mut Vec<Part<'a>>, guesses: &mut Vec<String>) -> Part<'a> {
    let by_unit = |part: &Part| part.unit.is_some_and(|unit| unit.dimension == Dimension::Pressure);
    let found = parts
        .iter()
        .position(|p| by_unit(p) && named(p, &PRESSURES))
        .or_else(|| parts.iter().position(by_unit))
        .or_else(|| parts.iter().position(|p| named(p, &PRESSURES)));
    let mut part = parts.remove(found.unwrap_or(0));
    if found.is_none() {
        guesses.push(format!("{} is taken for the pressure: no column is named so", part.column.name));
    }
    "pressure".clone_into(&mut part.id);
    let mut taken: BTreeSet<String> = parts.iter().map(|other| other.id.clone()).chain([part.id.clone()]).collect();
    if let Some(other) = parts.iter_mut().find(|other| other.id == part.id) {
        other.id = unique(&other.id, &mut taken);
    }
    part
}

fn write_clock(out: &mut String, clock: Option<&Part>, samples: usize, guesses: &mut Vec<String>) {
    out.push('\n');
    let Some(clock) = clock else {
        if samples > STATES_MAX {
            *out += "# No column of time was found. GUESS: say the true rate.\n[clock]\nrate = { value = 100, unit = \"Hz\" }\n";
            guesses.push("no column of time: 100 samples per second are assumed".to_owned());
        } else {
            *out += "# No column of time was found: every line is a steady state. [clock] takes `column` and `unit`, or `rate`.\n";
        }
        return;
    };
    let unit = clock.unit.filter(|unit| unit.dimension == Dimension::Time);
    let step = clock.column.cells.numbers().and_then(median_step).unwrap_or(1.0);
    // Rigs log faster than once a second, so steps of one and more are milliseconds.
    let guess = if step >= 1.0 { "ms" } else { "s" };
    let _ = writeln!(out, "[clock]\ncolumn = {}", clock.reference());
    if let Some(unit) = unit {
        let _ = writeln!(out, "unit = {}", quoted(unit.symbol));
    } else {
        let _ = writeln!(out, "unit = {}  # GUESS, from the usual step of {step}", quoted(guess));
        guesses.push(format!("the time is taken to be in {guess}"));
    }
}

fn write_channels(out: &mut String, pressure: &Part, parts: &[Part], guesses: &mut Vec<String>) {
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
            *out += "unit = \"kPa\"  # GUESS: the log does not say\n";
            guesses.push(format!("{} is taken to be in kPa", pressure.column.name));
        }
    }
    *out += "reference = \"gauge\"  # GUESS: or \"absolute\", with `atmosphere` in every run\n";
    *out += "# commanded = true  # if it was asked of a regulator, not measured\n";
    for part in parts {
        let _ = writeln!(out, "\n[[channel]]\nid = {}\ncolumn = {}", quoted(&part.id), part.reference());
        if let Some(unit) = part.unit {
            let _ = writeln!(out, "unit = {}", quoted(unit.symbol));
            if unit.dimension == Dimension::Pressure {
                *out += "reference = \"gauge\"  # GUESS\n";
            }
        } else {
            *out += "unit = \"1\"  # GUESS: the log does not say\n";
            guesses.push(format!("{} is taken to be a plain number", part.column.name));
        }
    }
}

fn write_runs(out: &mut String, logs: &[(String, TextLog)], guesses: &mut Vec<String>) {
    *out += "\n# Runs of one session are repeats on one specimen: points at equal pressure are averaged. What is no repeat is a session\n# of its own.\n";
    let mut ids = BTreeSet::new();
    for (file, log) in logs {
        let names = log.columns.iter().find_map(|column| Some((column, run_names(column)?)));
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

fn write_responses(
    out: &mut String,
    pressure: &Part,
    parts: &[Part],
    plateaus: bool,
    logs: &[(String, TextLog)],
    chamber: &str,
) {
    *out += "# What is measured against pressure. Keep what has a model, or what you want to see.\n";
    for part in parts {
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
            let tolerance = tolerance(pressure, logs);
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

/// A hundredth of the pressure's range, as two digits.
fn tolerance(pressure: &Part, logs: &[(String, TextLog)]) -> String {
    let finite = numbers_of(logs, pressure.number - 1).filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let tolerance = 0.01 * (high - low);
    if tolerance > 0.0 && tolerance.is_finite() { format!("{tolerance:.1e}") } else { "1".to_owned() }
}

/// Text on one line, fit for a comment.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// An id from a name: lower-case words joined by `-`; `channel-3` where nothing of it is left.
fn slug(name: &str, number: usize) -> String {
    let ascii = |word: &String| word.chars().filter(char::is_ascii_alphanumeric).collect::<String>();
    let words: Vec<String> = words(name).iter().map(ascii).filter(|word| !word.is_empty()).collect();
    let mut id = words.join("-");
    id.truncate(ID_LETTERS_MAX);
    let id = id.trim_matches('-').to_owned();
    match id.as_str() {
        "" | "index" | "measured" | "none" => format!("channel-{number}"),
        _ => id,
    }
}

const COMPARISONS: &str = "\
# Without [[comparison]] every model of a response is compared with it: the catalogue's, and those of actuator.toml.
# [[comparison]]
# quantity = \"…\"
# form = \"…\"
";

const ACTUATOR: &str = "\
schema = 1
# id = \"…\"  # while absent, this file describes the actuator of the session beside it
# type = \"…\"  # an embedded type, whose models then apply (`pneuval models`)
# title = \"…\"
# summary = \"…\"

# A model as a table, such as an export of a finite-element program: a name row, a unit row, pressures that rise.
# [[model]]
# kind = \"imported\"
# form = \"fea\"
# quantity = { id = \"…\", title = \"…\", unit = \"mm\" }
# file = \"fea.csv\"
# pressure = { column = \"pressure\", chamber = \"chamber\", reference = \"gauge\" }
# predicted = \"displacement\"
# std = \"displacement_std\"
# source = \"which program, which mesh\"

# [geometry]
# length = { value = 100, unit = \"mm\", source = \"measured\" }
";

fn rig(pressure: Option<&Part>) -> String {
    let input = pressure.and_then(|part| part.unit).map_or("V", |unit| unit.symbol);
    let hash = if pressure.is_some() { "" } else { "# " };
    format!(
        "schema = 1\nid = \"bench\"\n\n# Instruments: what they log (input), what that means (output), how sure it is.\n\
         {hash}[instrument.pressure]\n{hash}input = {}\n{hash}output = \"kPa\"\n\
         {hash}calibration = {{ kind = \"line\", slope = 1, offset = 0 }}  # FILL IN: output per input, output at zero\n\
         # range = {{ min = 0, max = 100 }}\n# std = 0.1  # standard uncertainty, in kPa\n# certificate = \"calibrated on …\"\n",
        quoted(input)
    )
}

fn bounds(actuator: Option<&str>, parts: &[Part]) -> String {
    let quantity = parts.first().map_or("…".to_owned(), |part| part.id.replace('_', "-"));
    format!(
        "schema = 1\n\n# What error is acceptable, and why: from an application need or a claim, never from a computed value.\n\
         # [[bound]]\n# actuator = {}\n# quantity = {}\n# model = \"fea\"\n# metric = \"rmse\"\n\
         # max = {{ value = 1, unit = \"mm\" }}\n# allow_single_repeat = true  # judge one repeat by its instruments' uncertainty\n# reason = \"…\"\n",
        quoted(actuator.unwrap_or("…")),
        quoted(&quantity)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::csv::{CsvOptions, read};
    use crate::manifest::{ClockSpec, ColumnRef, PointRule, SessionManifest};

    fn drafted(text: &str) -> (SessionManifest, Draft) {
        let log = read("log.csv", text.as_bytes(), &CsvOptions::default()).unwrap();
        let draft = draft("monday", &[("log.csv".to_owned(), log)], Some("finger"), None).unwrap();
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
        let log = |text: &str| read("log.csv", text.as_bytes(), &CsvOptions::default()).unwrap();
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
        assert!(super::draft("x", &[("log.csv".to_owned(), log)], None, None).is_none());
    }
}
