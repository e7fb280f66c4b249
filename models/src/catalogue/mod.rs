//! Every model form that can be evaluated, with its source, range, misprints and executed check values.
//!
//! An [`Entry`] is what a user sees in `pneuval models`, and what builds a [`Model`] from named inputs. Forms whose print
//! cannot be evaluated at all are not entries. A test runs every [`Check`] of every entry.

mod dual_chamber_finger;
mod internal_support;
mod model;

pub use model::Model;

use std::collections::BTreeMap;

use crate::ModelError;

/// How a form relates to the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FormKind {
    /// The equation exactly as printed.
    Printed,
    /// Re-derived so that units, sign and the undeformed limit are right.
    Consistent,
    /// One way to read what the paper leaves open, or a variant named as such.
    Reading,
}

impl FormKind {
    /// The kind in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Consistent => "consistent",
            Self::Reading => "reading",
        }
    }
}

/// A named input of a form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Its name in the actuator file.
    pub name: &'static str,
    /// Its SI unit: `m`, `Pa` or `1`.
    pub si_unit: &'static str,
    /// Symbol and meaning.
    pub meaning: &'static str,
}

/// A number that the form must reproduce.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// What is computed, with its inputs.
    pub statement: &'static str,
    /// The number.
    pub expected: f64,
    /// How far the computed number may be from it: half a unit of the last digit, unless the statement says otherwise.
    pub tolerance: f64,
    /// Its unit.
    pub unit: &'static str,
    /// The computation.
    pub compute: fn() -> Result<f64, ModelError>,
}

/// One model form.
pub struct Entry {
    /// The actuator type it describes.
    pub actuator: &'static str,
    /// The quantity it predicts.
    pub quantity: &'static str,
    /// SI unit of the quantity.
    pub quantity_si_unit: &'static str,
    /// Its id, unique within actuator and quantity.
    pub form: &'static str,
    /// How it relates to the paper.
    pub kind: FormKind,
    /// A short name for legends and tables.
    pub title: &'static str,
    /// The equation, in plain text.
    pub equation: &'static str,
    /// Paper and place.
    pub source: &'static str,
    /// Where it holds.
    pub range: &'static str,
    /// Of a printed form, what fails in print; of another, where it departs and what the paper leaves open.
    pub misprints: &'static [&'static str],
    /// The chambers whose gauge pressures it takes, in order.
    pub chambers: &'static [&'static str],
    /// The inputs it needs.
    pub parameters: &'static [Parameter],
    /// Numbers it must reproduce.
    pub checks: &'static [Check],
    stated: fn() -> Inputs,
    builder: fn(&Inputs) -> Result<Model, ModelError>,
}

impl Entry {
    /// The inputs the paper states, on which the check values rest.
    /// What it leaves open (the width of a steel sheet) is assumed as in the embedded actuator file.
    pub fn stated_inputs(&self) -> Inputs {
        (self.stated)()
    }

    /// The model for given inputs.
    ///
    /// # Errors
    /// [`ModelError::MissingParameter`], or [`ModelError::OutOfDomain`] for an input the equation refuses.
    pub fn build(&self, inputs: &Inputs) -> Result<Model, ModelError> {
        (self.builder)(inputs)
    }
}

/// Named input values in SI units.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inputs(BTreeMap<String, f64>);

impl Inputs {
    /// Sets a value, replacing an earlier one.
    pub fn set(&mut self, name: impl Into<String>, value_si: f64) {
        self.0.insert(name.into(), value_si);
    }

    /// A value by name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    fn require(&self, parameter: Parameter) -> Result<f64, ModelError> {
        self.get(parameter.name)
            .ok_or(ModelError::MissingParameter { name: parameter.name, meaning: parameter.meaning })
    }
}

impl<S: Into<String>> FromIterator<(S, f64)> for Inputs {
    fn from_iter<I: IntoIterator<Item = (S, f64)>>(iter: I) -> Self {
        Self(iter.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }
}

/// Every entry, by actuator, quantity and form in the order in which they are reported.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    internal_support::ENTRIES.iter().chain(dual_chamber_finger::ENTRIES)
}

/// The entry of an actuator type, quantity and form.
pub fn find(actuator: &str, quantity: &str, form: &str) -> Option<&'static Entry> {
    entries().find(|e| e.actuator == actuator && e.quantity == quantity && e.form == form)
}
