//! Pages: templates filled in with what [`super::view`] prepares. Every page is one file that needs no other.

use std::collections::BTreeMap;

use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, Value, escape_formatter};
use serde::Serialize;

use super::figures::Figure;
use super::view;
use crate::AnalysisError;
use crate::audit::{Audited, Outcome};
use crate::format::visible;
use crate::results::Results;

/// A page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// File name.
    pub name: String,
    /// Content.
    pub html: String,
}

/// The index and one page per actuator. Photographs, by their path in the results folder, are set within the pages; without them pages
/// name their files. Every dataset is shown in detail, or at most twelve of an actuator.
///
/// # Errors
/// [`AnalysisError::Page`] if a template asks for what is not there.
pub fn pages(
    results: &Results,
    figures: &[Figure],
    photographs: Option<&BTreeMap<String, Vec<u8>>>,
    every: bool,
) -> Result<Vec<Page>, AnalysisError> {
    let mut environment = environment();
    for (name, source) in [
        ("base.html", include_str!("templates/base.html")),
        ("index.html", include_str!("templates/index.html")),
        ("actuator.html", include_str!("templates/actuator.html")),
    ] {
        environment.add_template(name, source).map_err(|e| failed(name, &e))?;
    }
    let render = |name: String, template: &str, content: Content| {
        let all = Everything {
            style: include_str!("templates/style.css"),
            font: &base64(REGULAR),
            font_semibold: &base64(SEMIBOLD),
            head: view::head(results),
            content,
        };
        let html = environment.get_template(template).and_then(|t| t.render(Value::from(Serde(all))));
        html.map(|html| Page { name: name.clone(), html }).map_err(|e| failed(&name, &e))
    };
    let mut pages = vec![render("index.html".to_owned(), "index.html", Content::Index(view::index(results)))?];
    for record in &results.actuators {
        let page = view::actuator_page(results, record, figures, photographs, every);
        pages.push(render(format!("{}.html", record.id), "actuator.html", Content::Actuator(Box::new(page)))?);
    }
    Ok(pages)
}

/// The page of an audit: the claims of every paper with their recomputation.
///
/// # Errors
/// [`AnalysisError::Page`] if the template asks for what is not there.
pub fn audit_page(audited: &[Audited]) -> Result<Page, AnalysisError> {
    #[derive(Serialize)]
    struct Seen<'a> {
        font: String,
        font_semibold: String,
        papers: Vec<Paper<'a>>,
        program: &'static str,
    }
    #[derive(Serialize)]
    struct Paper<'a> {
        audited: &'a Audited,
        counts: Vec<(&'static str, usize)>,
    }
    const OUTCOMES: [Outcome; 4] =
        [Outcome::Reproduced, Outcome::ReproducedByRounding, Outcome::Contradicted, Outcome::NotCheckable];
    let mut environment = environment();
    let name = "audit.html";
    for (name, source) in
        [(name, include_str!("templates/audit.html")), ("style.css", include_str!("templates/style.css"))]
    {
        environment.add_template(name, source).map_err(|e| failed(name, &e))?;
    }
    let counts = |a: &Audited| OUTCOMES.map(|outcome| (outcome.id(), a.count(outcome))).to_vec();
    let papers = audited.iter().map(|audited| Paper { audited, counts: counts(audited) }).collect();
    let program = concat!("pneuval ", env!("CARGO_PKG_VERSION"));
    let seen = Seen { font: base64(REGULAR), font_semibold: base64(SEMIBOLD), papers, program };
    let html = environment.get_template(name).and_then(|t| t.render(Value::from(Serde(seen))));
    html.map(|html| Page { name: "index.html".to_owned(), html }).map_err(|e| failed(name, &e))
}

/// What every page is made in.
fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Text of files and users: nothing in it turns the direction of the page, or is there unseen.
    environment.set_formatter(|out, state, value| match value.as_str() {
        Some(text) if !value.is_safe() => escape_formatter(out, state, &Value::from(visible(text))),
        _ => escape_formatter(out, state, value),
    });
    environment
}

/// What a template sees.
#[derive(Serialize)]
struct Everything<'a> {
    style: &'a str,
    font: &'a str,
    font_semibold: &'a str,
    head: view::Head,
    content: Content<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Content<'a> {
    Index(view::Index),
    Actuator(Box<view::ActuatorPage<'a>>),
}

/// The embedded typeface, so that a page looks the same on a machine with no fonts.
const REGULAR: &[u8] = include_bytes!("../../assets/pneuval-sans-regular.woff2");
const SEMIBOLD: &[u8] = include_bytes!("../../assets/pneuval-sans-semibold.woff2");

fn base64(bytes: &[u8]) -> String {
    use base64::Engine as _;
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

fn failed(page: &str, error: &minijinja::Error) -> AnalysisError {
    AnalysisError::Page { page: page.to_owned(), message: format!("{error:#}") }
}
