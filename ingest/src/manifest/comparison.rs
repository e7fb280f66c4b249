//! `[[comparison]]` and the quantity it is about: the same in `dataset.toml` and `session.toml`.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::check_id;
use crate::document::{Document, parse_unit};
use crate::error::{IngestError, shown, suggestion};
use crate::units::Unit;

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its id, as in the model catalogue.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// The unit it is shown in.
    pub unit: Unit,
    /// Names of the components of a position; empty for a plain number.
    pub components: Vec<String>,
}

impl Quantity {
    /// How many numbers one value has.
    pub fn width(&self) -> usize {
        self.components.len().max(1)
    }
}

/// One row of `validate`: a prediction against the measured values of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonSpec {
    /// The quantity.
    pub quantity: String,
    /// Id of the prediction: a printed column, a catalogue form, an imported model, or a fitted variant of one.
    pub form: String,
    /// The form it evaluates, where `form` names a variant.
    pub model: Option<String>,
    /// Name in legends and tables; the model's where absent.
    pub title: Option<String>,
    /// Parameters calibrated first.
    pub fit: Option<FitSpec>,
    /// What of the prediction is moved onto the measurement first.
    pub align: Align,
    /// Why this comparison is shown but not judged.
    pub not_judged: Option<String>,
    /// A sentence for the page, with `{{ }}` placeholders for computed numbers.
    pub remark: Option<String>,
    /// Where in the file it stands, for errors of whoever evaluates it.
    pub line: usize,
}

/// How a prediction is moved onto the measurement before the two are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Align {
    /// Not at all: both stand in one frame.
    #[default]
    None,
    /// Shifted, so that the first points meet.
    Origin,
    /// Turned and shifted, as the least squares of the distances want it; never scaled, never mirrored.
    Rigid,
}

/// A calibration before a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSpec {
    /// The column that is fitted: a printed prediction's form id, or `measured`.
    pub to: String,
    /// The parameters that move.
    pub parameters: Vec<String>,
    /// Which points the fit does not see, so that they can judge it.
    pub hold_out: HoldOut,
}

/// Which measured points a fit does not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HoldOut {
    /// None: fitted to all of them, which is calibration where they are the measured ones.
    #[default]
    None,
    /// One pressure at a time: each is predicted by a fit to the others.
    OnePressure,
    /// Every second pressure: fitted on the even-numbered ones by rising pressure, the lowest being number 0, and judged on the
    /// odd-numbered ones.
    OddPressures,
}

impl HoldOut {
    /// What a page says about it, before the parameters; nothing where nothing is held out.
    pub fn label(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::OnePressure => {
                Some("each pressure is predicted by a fit to the others, and the fit to all of them is")
            }
            Self::OddPressures => Some("only the even-numbered pressures, judged on the odd-numbered"),
        }
    }
}

/// A quantity as a user writes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawQuantity {
    /// Its id.
    pub id: Spanned<String>,
    title: String,
    unit: Spanned<String>,
    components: Option<Spanned<Vec<String>>>,
}

impl RawQuantity {
    /// The quantity.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] for what is no id or no unit, and for components that are one or not told apart.
    pub fn checked(&self, document: &Document) -> Result<Quantity, IngestError> {
        if let Some(components) = &self.components {
            let names = components.get_ref();
            if names.iter().enumerate().any(|(i, name)| name.is_empty() || names[..i].contains(name)) {
                let found = names.join(", ");
                return Err(document.malformed(components.span(), "every component named once", found, "rename one"));
            }
            if names.len() < 2 {
                let next = "leave `components` out for a plain number";
                let found = names.len().to_string();
                return Err(document.malformed(components.span(), "at least two components", found, next));
            }
        }
        Ok(Quantity {
            id: check_id(document, &self.id)?,
            title: self.title.clone(),
            unit: parse_unit(document, &self.unit)?,
            components: self.components.as_ref().map(|c| c.get_ref().clone()).unwrap_or_default(),
        })
    }
}

/// One column, or one per component.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "a column name in quotes, or one per component in brackets")]
pub(super) enum OneOrMany {
    One(String),
    Many(Vec<String>),
}

impl OneOrMany {
    pub fn names(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Many(names) => names,
        }
    }
}

/// As many columns as the quantity has components.
pub(super) fn check_width(
    document: &Document,
    columns: &Spanned<OneOrMany>,
    quantity: &Quantity,
) -> Result<(), IngestError> {
    check_count(document, columns.span(), columns.get_ref().names().len(), quantity)
}

/// So many columns are as many as the quantity has components.
pub(super) fn check_count(
    document: &Document,
    span: Range<usize>,
    found: usize,
    quantity: &Quantity,
) -> Result<(), IngestError> {
    if found == quantity.width() {
        return Ok(());
    }
    let expected = if quantity.components.is_empty() {
        format!("one for `{}`", quantity.id)
    } else {
        format!("{} for `{}`: {}", quantity.width(), quantity.id, quantity.components.join(", "))
    };
    Err(document.malformed(span, expected, found.to_string(), "name one per component"))
}

/// A comparison as a user writes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawComparison {
    quantity: Spanned<String>,
    form: Spanned<String>,
    model: Option<Spanned<String>>,
    title: Option<String>,
    fit: Option<RawFit>,
    align: Option<Spanned<Align>>,
    judge: Option<Spanned<bool>>,
    reason: Option<String>,
    remark: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFit {
    to: Spanned<String>,
    parameters: Spanned<Vec<String>>,
    hold_out: Option<Spanned<HoldOut>>,
}

/// A measured quantity and the ids of the predictions that stand beside it in its source.
pub struct Comparable<'a> {
    /// Id of the quantity.
    pub quantity: &'a str,
    /// How many numbers one value has.
    pub width: usize,
    /// Ids of the predictions.
    pub columns: Vec<&'a str>,
}

/// The comparisons of a file, each about one of its quantities.
///
/// # Errors
/// [`IngestError::Malformed`] with line and key.
pub fn comparisons(
    document: &Document,
    raw: &[RawComparison],
    measured: &[Comparable],
) -> Result<Vec<ComparisonSpec>, IngestError> {
    let mut specs: Vec<ComparisonSpec> = Vec::new();
    for r in raw {
        let quantity = r.quantity.get_ref();
        let Some(source) = measured.iter().find(|m| m.quantity == quantity) else {
            let next = suggestion(quantity, measured.iter().map(|m| m.quantity));
            return Err(document.malformed(r.quantity.span(), "a quantity of this file", shown(quantity), next));
        };
        let form = check_id(document, &r.form)?;
        if specs.iter().any(|s| &s.quantity == quantity && s.form == form) {
            let found = format!("`{form}` of `{quantity}` twice");
            return Err(document.malformed(r.form.span(), "every comparison once", found, "remove one"));
        }
        let unused = r.model.as_ref().map(Spanned::span).or(r.fit.as_ref().map(|fit| fit.to.span()));
        if let Some(span) = unused.filter(|_| source.columns.contains(&form.as_str())) {
            let found = format!("`{form}`, which is printed in the table");
            let expected = "`model` and `fit` only for a form that is computed";
            return Err(document.malformed(span, expected, found, "remove them"));
        }
        if let Some(align) =
            r.align.as_ref().filter(|a| *a.get_ref() == Align::Rigid && !(2..=3).contains(&source.width))
        {
            let found = format!(
                "`{quantity}`, which has {} component{}",
                source.width,
                if source.width == 1 { "" } else { "s" }
            );
            let next = "remove it, or say align = \"origin\"";
            return Err(document.malformed(align.span(), "a position in 2 or 3 components to turn", found, next));
        }
        specs.push(ComparisonSpec {
            quantity: quantity.clone(),
            form,
            model: r.model.as_ref().map(|m| m.get_ref().clone()),
            title: r.title.clone(),
            fit: r.fit.as_ref().map(|fit| fit.checked(document, source)).transpose()?,
            align: r.align.as_ref().map(|align| *align.get_ref()).unwrap_or_default(),
            not_judged: not_judged(document, &r.form, r.judge.as_ref(), r.reason.as_deref())?,
            remark: r.remark.clone(),
            line: document.line_of(r.form.span().start),
        });
    }
    Ok(specs)
}

impl RawFit {
    fn checked(&self, document: &Document, source: &Comparable) -> Result<FitSpec, IngestError> {
        let to = self.to.get_ref();
        let known = source.columns.iter().copied().chain(["measured"]);
        if !known.clone().any(|k| k == to) {
            let next = suggestion(to, known);
            return Err(document.malformed(self.to.span(), "a column of the table", shown(to), next));
        }
        let names = self.parameters.get_ref();
        if names.iter().enumerate().any(|(i, name)| names[..i].contains(name)) {
            return Err(document.malformed(self.parameters.span(), "every parameter once", "one twice", "remove one"));
        }
        if names.is_empty() {
            return Err(document.malformed(self.parameters.span(), "at least one parameter", "none", "name it"));
        }
        if let Some(hold_out) = self.hold_out.as_ref().filter(|_| to != "measured") {
            let next = "remove `hold_out`: a fit to a printed prediction is judged on every measured point";
            return Err(document.malformed(hold_out.span(), "to = \"measured\" beside it", shown(to), next));
        }
        let hold_out = self.hold_out.as_ref().map(|h| *h.get_ref()).unwrap_or_default();
        Ok(FitSpec { to: to.clone(), parameters: names.clone(), hold_out })
    }
}

/// `judge = false` and its reason, which stand together or not at all.
pub(super) fn not_judged(
    document: &Document,
    form: &Spanned<String>,
    judge: Option<&Spanned<bool>>,
    reason: Option<&str>,
) -> Result<Option<String>, IngestError> {
    match (judge, reason) {
        (Some(judge), reason) if !judge.get_ref() => match reason {
            Some(reason) if !reason.trim().is_empty() => Ok(Some(reason.to_owned())),
            _ => {
                let next = "say why this comparison is not judged";
                Err(document.malformed(judge.span(), "key `reason` beside judge = false", "nothing", next))
            }
        },
        (_, Some(_)) => {
            let next = "add judge = false, or move the reason to the bound";
            Err(document.malformed(form.span(), "`reason` only beside judge = false", "`reason`", next))
        }
        _ => Ok(None),
    }
}
