//! `JUnit` XML as Jenkins, GitLab and others read it: a suite an actuator, a case a comparison.
//!
//! | standing | case |
//! |---|---|
//! | as expected | passed |
//! | differs from what was expected | failure |
//! | open: inconclusive, without a bound | error |
//! | not counted: a calibration, or judged by nobody on purpose | skipped |
//!
//! Lost data are an error of their own. So a document has a failure or an error if, and only if, the exit code is not 0; where nothing was
//! judged at all, that is an error too. Of a run that only reports, whose exit code is 0, what would fail is skipped, with its reason.

use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use quick_xml::writer::Writer;

use super::{name, numbers};
use crate::AnalysisError;
use crate::baseline::Move;
use crate::format::visible;
use crate::report::text;
use crate::results::{Comparison, Results, Standing};

/// What becomes of a case.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Passed,
    Failure,
    Error,
    Skipped,
}

/// A case of a suite.
struct Case {
    name: String,
    fate: Fate,
    /// The verdict, in a word.
    kind: &'static str,
    message: String,
    numbers: String,
}

/// A suite.
struct Suite {
    name: String,
    cases: Vec<Case>,
}

impl Suite {
    fn count(&self, fate: Fate) -> usize {
        self.cases.iter().filter(|case| case.fate == fate).count()
    }
}

/// The document, with what moved since a baseline.
///
/// # Errors
/// [`AnalysisError::Results`] if it cannot be written, which writing to memory rules out.
pub fn junit(results: &Results, moves: &[Move]) -> Result<String, AnalysisError> {
    written(results, &suites(results, moves)).map_err(|error| AnalysisError::Results {
        path: "junit.xml".into(),
        problem: error.to_string(),
        next: "report this as a bug".to_owned(),
    })
}

fn suites(results: &Results, moves: &[Move]) -> Vec<Suite> {
    let mut suites: Vec<Suite> = vec![];
    for actuator in &results.actuators {
        let mine = results.comparisons.iter().filter(|c| c.actuator == actuator.id);
        suites.push(Suite { name: actuator.id.clone(), cases: mine.map(case).collect() });
    }
    let losses = results.losses();
    let nothing = results.comparisons.iter().all(|c| c.standing() == Standing::NotCounted);
    let open = |name: &str, message: String| Case {
        name: name.to_owned(),
        fate: Fate::Error,
        kind: "open",
        message,
        numbers: String::new(),
    };
    let mut data: Vec<Case> = losses.into_iter().map(|loss| open("data", loss)).collect();
    if nothing {
        data.push(open("verdicts", text::decision(results).headline));
    }
    if !data.is_empty() {
        suites.push(Suite { name: "all".to_owned(), cases: data });
    }
    let moved = |m: &Move| Case {
        name: match m.metric {
            Some(metric) => format!("{} {}", m.id, metric.id()),
            None => m.id.clone(),
        },
        fate: if m.counts { Fate::Failure } else { Fate::Passed },
        kind: m.moved.name(),
        message: m.sentence.clone(),
        numbers: String::new(),
    };
    if !moves.is_empty() {
        suites.push(Suite { name: "baseline".to_owned(), cases: moves.iter().map(moved).collect() });
    }
    if results.report_only {
        for case in suites.iter_mut().flat_map(|suite| &mut suite.cases) {
            if matches!(case.fate, Fate::Failure | Fate::Error) {
                case.fate = Fate::Skipped;
                case.message = format!("only reported: {}", case.message);
            }
        }
    }
    suites
}

fn case(c: &Comparison) -> Case {
    let fate = match c.standing() {
        Standing::AsExpected => Fate::Passed,
        Standing::Unexpected => Fate::Failure,
        Standing::Open => Fate::Error,
        Standing::NotCounted => Fate::Skipped,
    };
    Case { name: name(c), fate, kind: c.verdict.name(), message: c.sentence.clone(), numbers: numbers(c) }
}

fn written(results: &Results, suites: &[Suite]) -> std::io::Result<String> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let sum = |of: fn(&Suite) -> usize| suites.iter().map(of).sum::<usize>().to_string();
    let (tests, failures, errors) =
        (sum(|s| s.cases.len()), sum(|s| s.count(Fate::Failure)), sum(|s| s.count(Fate::Error)));
    let all = [("name", "pneuval"), ("tests", &tests), ("failures", &failures), ("errors", &errors)];
    writer.write_event(Event::Start(element("testsuites", &all)))?;
    for suite in suites {
        let number = |n: usize| n.to_string();
        let (tests, failures) = (number(suite.cases.len()), number(suite.count(Fate::Failure)));
        let (errors, skipped) = (number(suite.count(Fate::Error)), number(suite.count(Fate::Skipped)));
        writer.write_event(Event::Start(element(
            "testsuite",
            &[
                ("name", &suite.name),
                ("tests", &tests),
                ("failures", &failures),
                ("errors", &errors),
                ("skipped", &skipped),
                ("package", &results.program),
            ],
        )))?;
        for case in &suite.cases {
            write_case(&mut writer, &suite.name, case)?;
        }
        writer.write_event(Event::End(BytesEnd::new("testsuite")))?;
    }
    writer.write_event(Event::End(BytesEnd::new("testsuites")))?;
    let mut text = String::from_utf8_lossy(&writer.into_inner()).into_owned();
    text.push('\n');
    Ok(text)
}

fn write_case(writer: &mut Writer<Vec<u8>>, suite: &str, case: &Case) -> std::io::Result<()> {
    let classname = format!("pneuval.{suite}");
    writer.write_event(Event::Start(element("testcase", &[("name", &case.name), ("classname", &classname)])))?;
    let said = format!("{}: {}", case.kind, case.message);
    let out = match case.fate {
        Fate::Passed => format!("{said}\n{}", case.numbers).trim_end().to_owned(),
        _ => case.numbers.clone(),
    };
    let reason = [("type", case.kind), ("message", case.message.as_str())];
    match case.fate {
        Fate::Passed => {}
        Fate::Failure => writer.write_event(Event::Empty(element("failure", &reason)))?,
        Fate::Error => writer.write_event(Event::Empty(element("error", &reason)))?,
        // Older schemas know no attributes of it.
        Fate::Skipped => write_text(writer, "skipped", &said)?,
    }
    if !out.is_empty() {
        write_text(writer, "system-out", &out)?;
    }
    writer.write_event(Event::End(BytesEnd::new("testcase")))
}

fn write_text(writer: &mut Writer<Vec<u8>>, name: &str, text: &str) -> std::io::Result<()> {
    writer.write_event(Event::Start(BytesStart::new(name)))?;
    writer.write_event(Event::Text(BytesText::new(&visible(text))))?;
    writer.write_event(Event::End(BytesEnd::new(name)))
}

/// An element whose attributes hold text only: what XML cannot hold is shown as an escape.
fn element<'a>(name: &'a str, attributes: &[(&'a str, &str)]) -> BytesStart<'a> {
    let mut element = BytesStart::new(name);
    for (key, value) in attributes {
        element.push_attribute((*key, visible(value).as_str()));
    }
    element
}
