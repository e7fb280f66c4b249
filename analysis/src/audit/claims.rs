//! `claims.toml`: statements, the numbers they rest on, and how they are recomputed.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use pneuval_ingest::IngestError;
use pneuval_ingest::digest;
use pneuval_ingest::document::Document;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::check_schema;
use pneuval_ingest::number;
use pneuval_models::expression::{Expression, ParseError, Relation};

use super::Outcome;
use super::dimension::{self, Composite};

/// A claims file.
#[derive(Debug, Clone, PartialEq)]
pub struct Claims {
    /// Id of the paper.
    pub id: String,
    /// Its title.
    pub title: String,
    /// The file, as the user named it.
    pub file: String,
    /// SHA-256 of it.
    pub sha256: String,
    /// The statements.
    pub claims: Vec<Claim>,
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    pub id: String,
    pub place: String,
    pub statement: String,
    pub remark: Option<String>,
    pub expect: Option<Outcome>,
    pub method: Method,
    pub numbers: Vec<Number>,
}

/// How a statement is checked.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Relations that must all hold.
    Check(Vec<Relation>),
    /// Several readings, each of relations that must all hold.
    Readings(Vec<Reading>),
    /// Whether whole counts can have the printed shares.
    Possible {
        /// The shares.
        share: String,
        /// Of how many.
        out_of: String,
    },
    /// Whether a largest error and an RMSE can be of one series.
    Spread {
        /// The largest.
        max: String,
        /// The RMSE.
        rmse: String,
        /// Of how many samples, if that is printed.
        n: Option<String>,
    },
    /// Whether a model has a solution.
    Exists(String),
    /// Nothing can be checked, and why.
    NotCheckable(String),
}

/// One way to read a statement.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    pub name: String,
    pub relations: Vec<Relation>,
    pub numbers: Vec<Number>,
}

/// A number of a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    pub name: String,
    pub source: Source,
    pub unit: Option<Composite>,
    pub symbol: String,
    pub place: Option<String>,
    /// The step to which the paper may have rounded it before going on, SI.
    pub rounded_to: Option<f64>,
}

/// Where a number comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Printed: text, value and half a unit of the last digit, in its unit.
    Printed(Vec<(String, f64, f64)>),
    /// Exact: a count, a definition.
    Exact(Vec<f64>),
    /// A model of the catalogue: `actuator/quantity/form`, at pressures, with inputs.
    Model { path: [String; 3], at: Vec<String>, with: BTreeMap<String, String> },
    /// Computed from other numbers.
    Formula(Expression),
    /// Only its unit is known.
    Symbol,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    schema: Spanned<i64>,
    id: Spanned<String>,
    title: String,
    #[serde(default)]
    claim: Vec<Spanned<RawClaim>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawClaim {
    id: Spanned<String>,
    place: String,
    statement: String,
    remark: Option<String>,
    expect: Option<Spanned<String>>,
    check: Option<Spanned<OneOrMany<String>>>,
    #[serde(default)]
    reading: Vec<RawReading>,
    possible: Option<RawPossible>,
    spread: Option<RawSpread>,
    exists: Option<Spanned<String>>,
    not_checkable: Option<String>,
    #[serde(default)]
    numbers: BTreeMap<Spanned<String>, RawNumber>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawReading {
    name: String,
    check: Spanned<OneOrMany<String>>,
    #[serde(default)]
    numbers: BTreeMap<Spanned<String>, RawNumber>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPossible {
    share: Spanned<String>,
    out_of: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpread {
    max: Spanned<String>,
    rmse: Spanned<String>,
    n: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawNumber {
    printed: Option<Spanned<OneOrMany<String>>>,
    exact: Option<Spanned<OneOrMany<f64>>>,
    model: Option<Spanned<String>>,
    #[serde(default)]
    at: OneOrMany<String>,
    #[serde(default)]
    with: BTreeMap<String, String>,
    formula: Option<Spanned<String>>,
    unit: Option<Spanned<String>>,
    rounded_to: Option<Spanned<String>>,
    place: Option<String>,
}

/// A value, or a list of them.
#[derive(Deserialize, Clone)]
#[serde(untagged)]
enum OneOrMany<T> {
    One(T),
    Many(Vec<T>),
}

impl<T> Default for OneOrMany<T> {
    fn default() -> Self {
        Self::Many(vec![])
    }
}

impl<T: Clone> OneOrMany<T> {
    fn list(&self) -> Vec<T> {
        match self {
            Self::One(one) => vec![one.clone()],
            Self::Many(many) => many.clone(),
        }
    }
}

impl Claims {
    /// Reads a claims file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: RawFile = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let mut ids = BTreeSet::new();
        let mut claims = Vec::new();
        for claim in raw.claim {
            let span = claim.span();
            let claim = claim.into_inner();
            if !ids.insert(claim.id.get_ref().clone()) {
                let found = format!("`{}` twice", claim.id.get_ref());
                return Err(document.malformed(claim.id.span(), "every id once", found, "rename one"));
            }
            claims.push(read_claim(&document, claim, span)?);
        }
        let (id, title) = (raw.id.into_inner(), raw.title);
        Ok(Self { id, title, file: file.to_owned(), sha256: digest::sha256(bytes), claims })
    }
}

fn read_claim(document: &Document, raw: RawClaim, span: Range<usize>) -> Result<Claim, IngestError> {
    const METHODS: &str = "one of check, reading, possible, spread, exists, not_checkable";
    let numbers = read_numbers(document, raw.numbers)?;
    let known =
        |more: &[Number]| -> Vec<String> { numbers.iter().chain(more).map(|number| number.name.clone()).collect() };
    let mut methods: Vec<Method> = Vec::new();
    if let Some(check) = &raw.check {
        methods.push(Method::Check(relations(document, check, &known(&[]))?));
    }
    if !raw.reading.is_empty() {
        let mut readings = Vec::new();
        for reading in raw.reading {
            let more = read_numbers(document, reading.numbers)?;
            let relations = relations(document, &reading.check, &known(&more))?;
            readings.push(Reading { name: reading.name, relations, numbers: more });
        }
        methods.push(Method::Readings(readings));
    }
    let named = |name: &Spanned<String>| {
        if known(&[]).contains(name.get_ref()) {
            return Ok(name.get_ref().clone());
        }
        let next = suggestion(name.get_ref(), numbers.iter().map(|n| n.name.as_str()));
        Err(document.malformed(name.span(), "a number of this claim", format!("`{}`", name.get_ref()), next))
    };
    if let Some(possible) = &raw.possible {
        methods.push(Method::Possible { share: named(&possible.share)?, out_of: named(&possible.out_of)? });
    }
    if let Some(spread) = &raw.spread {
        let n = spread.n.as_ref().map(&named).transpose()?;
        methods.push(Method::Spread { max: named(&spread.max)?, rmse: named(&spread.rmse)?, n });
    }
    if let Some(exists) = &raw.exists {
        methods.push(Method::Exists(named(exists)?));
    }
    methods.extend(raw.not_checkable.map(Method::NotCheckable));
    let mut methods = methods.into_iter();
    let (Some(method), None) = (methods.next(), methods.next()) else {
        let line = document.line_of(span.start);
        return Err(document.malformed_at(line, METHODS, "none, or several", "say how the statement is checked"));
    };
    let expect = match &raw.expect {
        None => None,
        Some(word) => Some(Outcome::find(word.get_ref()).ok_or_else(|| {
            let ids = ["reproduced", "reproduced-by-rounding", "contradicted", "not-checkable"];
            let next = suggestion(word.get_ref(), ids);
            document.malformed(word.span(), ids.join(", "), format!("`{}`", word.get_ref()), next)
        })?),
    };
    Ok(Claim {
        id: raw.id.into_inner(),
        place: raw.place,
        statement: raw.statement,
        remark: raw.remark,
        expect,
        method,
        numbers,
    })
}

fn relations(
    document: &Document,
    texts: &Spanned<OneOrMany<String>>,
    known: &[String],
) -> Result<Vec<Relation>, IngestError> {
    let mut relations = Vec::new();
    for text in texts.get_ref().list() {
        let relation = Relation::parse(&text).map_err(|error| formula_error(document, texts.span(), &error))?;
        for symbol in relation.left.symbols().iter().chain(relation.right.symbols()) {
            if !known.contains(symbol) {
                let next = suggestion(symbol, known.iter().map(String::as_str));
                return Err(document.malformed(texts.span(), "numbers of this claim", format!("`{symbol}`"), next));
            }
        }
        relations.push(relation);
    }
    if relations.is_empty() {
        return Err(document.malformed(texts.span(), "a relation", "none", "write one, such as \"a + b = total\""));
    }
    Ok(relations)
}

fn formula_error(document: &Document, span: Range<usize>, error: &ParseError) -> IngestError {
    let found = format!("{} in `{}`, letter {}", error.found, error.text, error.at);
    document.malformed(span, error.expected.clone(), found, error.next.clone())
}

fn read_numbers(document: &Document, raw: BTreeMap<Spanned<String>, RawNumber>) -> Result<Vec<Number>, IngestError> {
    let mut numbers = Vec::new();
    for (name, raw) in raw {
        let malformed = |expected: &str, found: String, next: &str| {
            Err(document.malformed(name.span(), expected, found, next.to_owned()))
        };
        let is_name = Expression::parse(name.get_ref()).is_ok_and(|e| e.symbols().first() == Some(name.get_ref()));
        if !is_name {
            let found = format!("`{}`", name.get_ref());
            return malformed("a name of letters, digits and `_`, that is no function", found, "rename it");
        }
        let unit = match &raw.unit {
            None => None,
            Some(text) => Some(dimension::parse(text.get_ref()).ok_or_else(|| {
                let found = format!("`{}`", text.get_ref());
                document.malformed(text.span(), "a unit, or a product or quotient of units", found, "such as `N/mm^2`")
            })?),
        };
        let count = [raw.printed.is_some(), raw.exact.is_some(), raw.model.is_some(), raw.formula.is_some()];
        let source = match count.iter().filter(|is| **is).count() {
            0 if raw.unit.is_some() => Source::Symbol,
            1 => source(document, &raw)?,
            _ => {
                return malformed(
                    "one of printed, exact, model, formula; or a unit alone",
                    "none, or several".to_owned(),
                    "say where the number comes from",
                );
            }
        };
        let factor = unit.map_or(1.0, |unit: Composite| unit.factor);
        let rounded_to = match &raw.rounded_to {
            None => None,
            Some(step) => {
                let value = step.get_ref().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
                let Some(value) = value else {
                    return Err(document.malformed(
                        step.span(),
                        "a step above zero, such as \"0.1\"",
                        format!("`{}`", step.get_ref()),
                        "correct it",
                    ));
                };
                Some(value * factor)
            }
        };
        numbers.push(Number {
            name: name.get_ref().clone(),
            source,
            unit,
            symbol: raw.unit.map_or(String::new(), Spanned::into_inner),
            place: raw.place,
            rounded_to,
        });
    }
    Ok(numbers)
}

fn source(document: &Document, raw: &RawNumber) -> Result<Source, IngestError> {
    if let Some(printed) = &raw.printed {
        let mut values = Vec::new();
        for text in printed.get_ref().list() {
            let Some((value, half)) = number::parse(text.trim()).filter(|(value, _)| value.is_finite()) else {
                let found = format!("`{text}`");
                return Err(document.malformed(
                    printed.span(),
                    "a number as printed, with a point",
                    found,
                    "correct it",
                ));
            };
            values.push((text.trim().to_owned(), value, half));
        }
        if values.is_empty() {
            return Err(document.malformed(printed.span(), "a number at least", "none", "write what is printed"));
        }
        return Ok(Source::Printed(values));
    }
    if let Some(exact) = &raw.exact {
        let values = exact.get_ref().list();
        if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
            return Err(document.malformed(exact.span(), "finite numbers", "others, or none", "correct them"));
        }
        return Ok(Source::Exact(values));
    }
    if let Some(formula) = &raw.formula {
        let parsed = Expression::parse(formula.get_ref());
        return Ok(Source::Formula(parsed.map_err(|error| formula_error(document, formula.span(), &error))?));
    }
    // What is left is a model.
    let model = raw.model.as_ref().map(|model| (model.get_ref().clone(), model.span()));
    let (model, span) = model.unwrap_or_default();
    let parts: Vec<String> = model.split('/').map(str::to_owned).collect();
    match <[String; 3]>::try_from(parts) {
        Ok(path) if !raw.at.list().is_empty() => Ok(Source::Model { path, at: raw.at.list(), with: raw.with.clone() }),
        Ok(_) => {
            Err(document.malformed(span, "key `at`: pressures, such as [\"40 kPa, 50 kPa\"]", "nothing", "add `at`"))
        }
        Err(_) => {
            Err(document.malformed(span, "actuator/quantity/form", format!("`{model}`"), "`pneuval models` lists them"))
        }
    }
}
