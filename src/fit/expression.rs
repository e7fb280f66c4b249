//! `pneuval fit expression`.

use std::fmt::Write as _;

use serde::Serialize;

use pneuval_analysis::fit::certified::{Agreement, Certified};
use pneuval_analysis::fit::expression::{Fitted, Task, fit, sides};
use pneuval_ingest::formats::{self, Options};
use pneuval_ingest::limits;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::Keep;

use super::arguments::FitExpression;
use super::words;
use crate::exit::{Failure, Outcome};
use crate::output;

/// A text this long is no certified dataset.
const CERTIFIED_BYTES_MAX: u64 = 1 << 20;

/// What `--json` prints.
#[derive(Serialize)]
struct Told<'a> {
    file: &'a str,
    sha256: &'a str,
    #[serde(flatten)]
    fitted: &'a Fitted,
    certified: Option<&'a Agreement>,
}

pub fn run(arguments: &FitExpression) -> Result<Outcome, Failure> {
    let file = arguments.file.display().to_string();
    let raw = RawFile::open(&arguments.file, &file, limits::LOG_BYTES_MAX)?;
    let certified = certified(&raw)?;
    let mut columns = match &certified {
        Some(certified) => certified.columns.clone(),
        None => columns(&raw)?,
    };
    if let Some(names) = &arguments.columns {
        rename(&mut columns, names)?;
    }
    let start = start(arguments, certified.as_ref())?;
    let first = columns.first().map(|(name, _)| name.clone());
    let has_y = columns.iter().any(|(name, _)| name == "y");
    let response = arguments.response.as_deref().or(if has_y { Some("y") } else { first.as_deref() });
    let (response, formula) = sides(&arguments.formula, response)?;
    let std = match &arguments.std {
        None => None,
        Some(name) => {
            let column = columns.iter().find(|(known, _)| known == name);
            let known: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
            let wrong = || Failure::Flag {
                flag: "--std",
                found: format!("`{name}`"),
                expected: format!("a column: {}", known.join(", ")),
                next: "correct the name".to_owned(),
            };
            Some(column.ok_or_else(wrong)?.1.clone())
        }
    };
    let starts = arguments.search.starts(49);
    let task = Task { response, formula, columns, std, start, starts, confidence: arguments.search.confidence };
    let fitted = fit(&task)?;
    let agreement = certified.map(|certified| certified.agreement(&fitted));
    if arguments.json {
        let sha256 = raw.sha256()?;
        output::print_json(&Told { file: &file, sha256: &sha256, fitted: &fitted, certified: agreement.as_ref() })?;
    } else {
        output::print(&text(&file, &fitted, agreement.as_ref()))?;
    }
    Ok(if fitted.converged { Outcome::Expected } else { Outcome::Open })
}

/// A file of NIST's, if it is one.
fn certified(raw: &RawFile) -> Result<Option<Certified>, Failure> {
    if raw.len() > CERTIFIED_BYTES_MAX {
        return Ok(None);
    }
    let bytes = raw.head(CERTIFIED_BYTES_MAX)?;
    Ok(std::str::from_utf8(&bytes).ok().and_then(Certified::read))
}

/// The columns of numbers of the first table of a file.
fn columns(raw: &RawFile) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let recording = formats::read(raw, &Options::default(), Keep::All)?;
    let table = recording.tables.iter().max_by_key(|table| table.rows);
    let numbers = table.into_iter().flat_map(|table| &table.columns);
    Ok(numbers.filter_map(|column| Some((column.name.clone(), column.cells.numbers()?.to_vec()))).collect())
}

/// Names from the left, in place of those of the file.
fn rename(columns: &mut [(String, Vec<f64>)], names: &str) -> Result<(), Failure> {
    let names: Vec<&str> = names.split(',').map(str::trim).collect();
    if names.len() > columns.len() || names.iter().any(|name| name.is_empty()) {
        return Err(Failure::Flag {
            flag: "--columns",
            found: format!("{} names", names.len()),
            expected: format!("at most {}, one a column of numbers, separated by commas", columns.len()),
            next: "name the columns from the left".to_owned(),
        });
    }
    columns.iter_mut().zip(names).for_each(|((name, _), new)| new.clone_into(name));
    Ok(())
}

/// Start values as written, or those of a certified dataset.
fn start(arguments: &FitExpression, certified: Option<&Certified>) -> Result<Vec<(String, f64)>, Failure> {
    let wrong = |found: &str, next: &str| Failure::Flag {
        flag: "--start",
        found: found.to_owned(),
        expected: "a start value for every parameter, such as \"b1=250, b2=0.0005\"".to_owned(),
        next: next.to_owned(),
    };
    let text = arguments.start.as_deref().map(str::trim);
    if let (Some(certified), None | Some("1" | "2")) = (certified, text) {
        // The second start is the nearer one.
        let which = usize::from(text != Some("1"));
        return Ok(certified.parameters.iter().map(|p| (p.name.clone(), p.starts[which])).collect());
    }
    let Some(text) = text else { return Err(wrong("nothing", "add --start")) };
    let mut values: Vec<(String, f64)> = Vec::new();
    for part in text.split([',', ';']).map(str::trim).filter(|part| !part.is_empty()) {
        let Some((name, value)) = part.split_once('=') else { return Err(wrong(part, "write NAME=VALUE")) };
        let name = name.trim();
        let value = value.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let Some(value) = value else { return Err(wrong(part, "write a finite number behind `=`")) };
        if values.iter().any(|(known, _)| known == name) {
            return Err(wrong(&format!("`{name}` twice"), "remove one"));
        }
        values.push((name.to_owned(), value));
    }
    if values.is_empty() { Err(wrong("nothing", "write NAME=VALUE")) } else { Ok(values) }
}

fn text(file: &str, fitted: &Fitted, agreement: Option<&Agreement>) -> String {
    let mut out = format!("{} = {}\n", fitted.response, fitted.formula);
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "fitted to {} of {} rows of {file}, {}\n",
        fitted.rows_used, fitted.rows_available, fitted.weighting
    );
    if !fitted.converged {
        out += "NOT CONVERGED: no minimum that determines every parameter was found; the numbers below are where the search ended\n\n";
    }
    out += &words::estimates(&fitted.estimates, &[]);
    if !fitted.linear_in.is_empty() {
        let _ = writeln!(out, "linear in     {}: solved for from every start", fitted.linear_in.join(", "));
    }
    if let Some(agreement) = agreement {
        let std = agreement.std_digits.map_or("none".to_owned(), |digits| format!("{digits:.1}"));
        let _ = writeln!(
            out,
            "certified     {}: fewest correct digits of 11: parameters {:.1}, standard deviations {std}, sum of squares {:.1}",
            agreement.dataset, agreement.parameter_digits, agreement.sum_of_squares_digits
        );
    }
    out
}
