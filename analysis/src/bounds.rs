//! `bounds.toml`: what error is acceptable, and why.
//!
//! A bound comes from a paper's stated claim or an application need, quoted in its `reason`; never from a number this
//! program computed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use pneuval_ingest::IngestError;
use pneuval_ingest::document::{Document, parse_unit};
use pneuval_ingest::error::{Place, suggestion};
use pneuval_ingest::units::{Dimension, Unit};

use crate::metrics::Metric;

/// What a row of bounds expects of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Expect {
    /// The metric stays within the bound.
    #[default]
    Pass,
    /// The metric exceeds the bound: a known failure, kept in sight. If it passes one day, that is news, and exit 1.
    Exceed,
}

/// An acceptance limit on one metric of one comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// The metric.
    pub metric: Metric,
    /// The largest acceptable absolute value, in SI units or as a share.
    pub max: f64,
    /// The largest acceptable half-width of the metric's interval: wider is inconclusive.
    pub max_uncertainty: Option<f64>,
    /// Why this bound.
    pub reason: String,
    /// What is expected.
    pub expect: Expect,
    /// Whether a session with one repeat may be judged by its instruments' uncertainty alone.
    pub allow_single_repeat: bool,
}

/// A bound with the comparison it applies to and the place it was written.
#[derive(Debug, Clone)]
struct Row {
    actuator: String,
    quantity: String,
    form: String,
    dimension: Dimension,
    place: Place,
    bound: Bound,
}

/// The rows of a bounds file.
#[derive(Debug, Clone, Default)]
pub struct Bounds {
    rows: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    #[serde(default)]
    bound: Vec<RawBound>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBound {
    actuator: Spanned<String>,
    quantity: Spanned<String>,
    model: Spanned<OneOrMany>,
    metric: Spanned<String>,
    max: Limit,
    max_uncertainty: Option<Limit>,
    reason: Spanned<String>,
    #[serde(default)]
    expect: Expect,
    #[serde(default)]
    allow_single_repeat: bool,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a model in quotes, or several in brackets")]
enum OneOrMany {
    One(String),
    Many(Vec<String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Limit {
    value: Spanned<f64>,
    unit: Spanned<String>,
}

impl Limit {
    /// The limit in SI units, and what it measures.
    fn checked(&self, document: &Document) -> Result<(f64, Unit), IngestError> {
        let unit = parse_unit(document, &self.unit)?;
        let value = *self.value.get_ref();
        if value.is_finite() && value >= 0.0 {
            Ok((unit.to_si(value), unit))
        } else {
            Err(document.malformed(self.value.span(), "a finite number >= 0", value.to_string(), "correct the number"))
        }
    }
}

impl Bounds {
    /// Reads a bounds file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key: unknown keys, metrics and units, an empty reason, a metric that has no
    /// upper bound, or two rows for one actuator, quantity, model and metric.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        if *raw.schema.get_ref() != 1 {
            let found = raw.schema.get_ref().to_string();
            let next = "use a program version that knows this schema";
            return Err(document.malformed(raw.schema.span(), "schema = 1", found, next));
        }
        let mut rows: Vec<Row> = Vec::new();
        for raw in &raw.bound {
            let (bound, dimension) = raw.checked(&document)?;
            let models = match raw.model.get_ref() {
                OneOrMany::One(model) => std::slice::from_ref(model),
                OneOrMany::Many(models) => models,
            };
            if models.is_empty() {
                return Err(document.malformed(raw.model.span(), "at least one model", "none", "name it"));
            }
            for model in models {
                let row = Row {
                    actuator: raw.actuator.get_ref().clone(),
                    quantity: raw.quantity.get_ref().clone(),
                    form: model.clone(),
                    dimension,
                    place: Place::new(file, Some(document.line_of(raw.model.span().start)), None),
                    bound: bound.clone(),
                };
                if let Some(other) = rows
                    .iter()
                    .find(|r| r.is_for(&row.actuator, &row.quantity, model) && r.bound.metric == bound.metric)
                {
                    let found = format!(
                        "a second bound on {} of {} {} {model}, the first at line {}",
                        bound.metric.id(),
                        row.actuator,
                        row.quantity,
                        other.place.line.unwrap_or(0)
                    );
                    return Err(document.malformed(raw.model.span(), "one bound per metric", found, "remove one"));
                }
                rows.push(row);
            }
        }
        Ok(Self { rows })
    }

    /// The actuators that rows name, perhaps several times.
    pub fn actuators(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().map(|row| row.actuator.as_str())
    }

    /// The bounds on a comparison, in the order of the file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] if a bound's unit does not measure the quantity.
    pub fn of(
        &self,
        actuator: &str,
        quantity: &str,
        form: &str,
        dimension: Dimension,
    ) -> Result<Vec<Bound>, IngestError> {
        self.rows
            .iter()
            .filter(|row| row.is_for(actuator, quantity, form))
            .map(|row| {
                if row.bound.metric.is_ratio() || row.dimension == dimension {
                    return Ok(row.bound.clone());
                }
                let mut place = row.place.clone();
                place.item = Some("key `max`".to_owned());
                Err(IngestError::Malformed {
                    place,
                    expected: format!("{} for {} of {quantity}", dimension.name(), row.bound.metric.id()),
                    found: row.dimension.name().to_owned(),
                    next: "correct the unit".to_owned(),
                })
            })
            .collect()
    }

    /// Rows for an actuator that meet none of its comparisons (quantity and form).
    fn unmet<'a>(&'a self, actuator: &'a str, comparisons: &'a [(String, String)]) -> impl Iterator<Item = &'a Row> {
        let met = move |row: &Row| comparisons.iter().any(|(q, f)| row.is_for(actuator, q, f));
        self.rows.iter().filter(move |row| row.actuator == actuator && !met(row))
    }

    /// The first row for an actuator that meets none of its comparisons (quantity and form), as an error that names the nearest.
    pub fn unused(&self, actuator: &str, comparisons: &[(String, String)]) -> Option<IngestError> {
        let row = self.unmet(actuator, comparisons).next()?;
        let known_quantity = comparisons.iter().any(|(q, _)| *q == row.quantity);
        let (key, word, candidates): (_, _, Vec<&str>) = if known_quantity {
            let forms = comparisons.iter().filter(|(q, _)| *q == row.quantity).map(|(_, f)| f.as_str());
            ("model", &row.form, forms.collect())
        } else {
            ("quantity", &row.quantity, comparisons.iter().map(|(q, _)| q.as_str()).collect())
        };
        let mut place = row.place.clone();
        place.item = Some(format!("key `{key}`"));
        Some(IngestError::Malformed {
            place,
            expected: format!("a comparison of {actuator}"),
            found: format!("`{word}`, which nothing here compares"),
            next: suggestion(word, candidates),
        })
    }

    /// Rows for an actuator that meet none of its comparisons, in words.
    pub fn unused_rows(&self, actuator: &str, comparisons: &[(String, String)]) -> Vec<String> {
        self.unmet(actuator, comparisons)
            .map(|row| {
                format!(
                    "the bound on {} of {} {} {} met no comparison",
                    row.bound.metric.id(),
                    actuator,
                    row.quantity,
                    row.form
                )
            })
            .collect()
    }
}

impl Row {
    fn is_for(&self, actuator: &str, quantity: &str, form: &str) -> bool {
        self.actuator == actuator && self.quantity == quantity && self.form == form
    }
}

impl RawBound {
    fn checked(&self, document: &Document) -> Result<(Bound, Dimension), IngestError> {
        let id = self.metric.get_ref();
        let Some(metric) = Metric::parse(id) else {
            let next = suggestion(id, Metric::ALL.iter().filter(|m| m.is_boundable()).map(|m| m.id()));
            return Err(document.malformed(self.metric.span(), "a metric", format!("`{id}`"), next));
        };
        if !metric.is_boundable() {
            let next = "bound rmse or relative_to_range_rmse instead";
            return Err(document.malformed(
                self.metric.span(),
                "a metric with an upper bound",
                format!("`{id}`"),
                next,
            ));
        }
        if self.reason.get_ref().trim().is_empty() {
            let next = "quote the claim or the need it comes from";
            return Err(document.malformed(self.reason.span(), "the reason of the bound", "nothing", next));
        }
        let (max, unit) = self.max.checked(document)?;
        if metric.is_ratio() && unit.dimension != Dimension::Ratio {
            let found = format!("unit `{}`", unit.symbol);
            return Err(document.malformed(self.max.unit.span(), Dimension::Ratio.name(), found, "correct the unit"));
        }
        let max_uncertainty = match &self.max_uncertainty {
            None => None,
            Some(limit) => {
                let (value, limit_unit) = limit.checked(document)?;
                if limit_unit.dimension != unit.dimension {
                    let found = format!("unit `{}`", limit_unit.symbol);
                    let expected = format!("{}, as `max`", unit.dimension.name());
                    return Err(document.malformed(limit.unit.span(), expected, found, "correct the unit"));
                }
                Some(value)
            }
        };
        let bound = Bound {
            metric,
            max,
            max_uncertainty,
            reason: self.reason.get_ref().clone(),
            expect: self.expect,
            allow_single_repeat: self.allow_single_repeat,
        };
        Ok((bound, unit.dimension))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "schema = 1\n[[bound]]\nactuator = \"a\"\nquantity = \"q\"\nmodel = \"m\"\nmetric = \"rmse\"\n\
                        max = { value = 2.5, unit = \"mm\" }\nreason = \"need\"\n";

    fn error(text: &str) -> String {
        Bounds::read("bounds.toml", text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn a_row_reads_in_si() {
        let bounds = Bounds::read("b", GOOD.as_bytes()).unwrap();
        let found = bounds.of("a", "q", "m", Dimension::Length).unwrap();
        assert!((found[0].max - 2.5e-3).abs() < 1e-18 && found[0].expect == Expect::Pass);
        assert!(bounds.of("a", "q", "other", Dimension::Length).unwrap().is_empty());
    }

    #[test]
    fn mistakes_are_named_by_line_and_key() {
        for (from, to, line, word) in [
            ("metric = \"rmse\"", "metric = \"rsme\"", 6, "did you mean `rmse`?"),
            ("metric = \"rmse\"", "metric = \"r2\"", 6, "relative_to_range_rmse"),
            ("unit = \"mm\"", "unit = \"milli\"", 7, "a known unit"),
            ("value = 2.5", "value = nan", 7, "a finite number >= 0"),
            ("value = 2.5", "value = \"two\"", 7, "a number"),
            ("reason = \"need\"", "reason = \" \"", 8, "the reason of the bound"),
            ("reason = \"need\"", "raeson = \"need\"", 8, "did you mean `reason`?"),
            ("reason = \"need\"", "reason = \"need\"\nexpect = \"excede\"", 9, "did you mean `exceed`?"),
            ("schema = 1", "schema = 2", 1, "schema = 1"),
            ("model = \"m\"", "model = []", 5, "at least one model"),
            ("metric = \"rmse\"", "metric = \"relative_to_measured_max\"", 7, "a number or share"),
        ] {
            let message = error(&GOOD.replace(from, to));
            assert!(message.starts_with(&format!("bounds.toml:{line}: key")), "{to}: {message}");
            assert!(message.contains(word), "{to}: {message}");
        }
        let message = error(&GOOD.replace("reason = \"need\"\n", ""));
        assert!(message.contains("expected: key `reason`"), "{message}");
    }

    #[test]
    fn a_second_bound_on_one_metric_is_refused() {
        let twice = format!("{GOOD}{}", GOOD.strip_prefix("schema = 1\n").unwrap());
        let message = error(&twice);
        assert!(
            message.starts_with("bounds.toml:12: key `model`") && message.contains("the first at line 5"),
            "{message}"
        );
    }

    #[test]
    fn a_bound_in_the_wrong_unit_for_its_quantity_is_refused() {
        let bounds = Bounds::read("bounds.toml", GOOD.as_bytes()).unwrap();
        let message = bounds.of("a", "q", "m", Dimension::Angle).unwrap_err().to_string();
        assert!(message.contains("bounds.toml:5: key `max`") && message.contains("an angle"), "{message}");
    }

    #[test]
    fn a_row_that_meets_no_comparison_is_told() {
        let bounds = Bounds::read("bounds.toml", GOOD.as_bytes()).unwrap();
        let comparisons = [("q".to_owned(), "mm".to_owned())];
        let message = bounds.unused("a", &comparisons).unwrap().to_string();
        assert!(
            message.contains("`m`, which nothing here compares") && message.contains("did you mean `mm`?"),
            "{message}"
        );
        assert!(bounds.unused("another", &comparisons).is_none());
        assert_eq!(bounds.unused_rows("a", &comparisons), ["the bound on rmse of a q m met no comparison"]);
    }
}
