//! Every model form that can be evaluated, with its source, range, misprints and executed check values.
//!
//! An [`Entry`] is what a user sees in `pneuval models`, and what builds a [`Model`] from named inputs. Equations whose print
//! cannot be evaluated at all are not entries: [`unevaluable`] lists them. A test runs every [`Check`] of every entry. A [`LawEntry`] is
//! the same for a hyperelastic law.

mod constant_curvature;
mod dual_chamber_finger;
mod fruit_finger;
mod internal_support;
mod laws;
mod model;
mod pdms_wall;
mod wave_finger;

pub use laws::{LAWS, LawEntry, find_law};
pub use model::{Explicit, Model};

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
    /// A law that nobody printed: chosen, and said so.
    Assumed,
}

impl FormKind {
    /// The kind in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Consistent => "consistent",
            Self::Reading => "reading",
            Self::Assumed => "assumed",
        }
    }
}

/// A named input of a form, or a named constant of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Its name in the actuator file, or beside the pressures of a table.
    pub name: &'static str,
    /// Its SI unit: `m`, `m2`, `Pa`, `rad`, `N`, `1`, or a quotient: `m/Pa`, `rad/Pa`, `1/(m Pa)`.
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
    /// The names of its components in order, `["x", "z"]` of a tip position; empty for a scalar.
    pub components: &'static [&'static str],
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
    /// The inputs it needs of the actuator.
    pub parameters: &'static [Parameter],
    /// The inputs that are no property of the actuator: they stand beside the pressure at each point of a table (the angle at
    /// which a finger is held, a wall's thickness, a measured angle).
    pub conditions: &'static [Parameter],
    /// Numbers it must reproduce.
    pub checks: &'static [Check],
    stated: fn() -> Inputs,
    builder: fn(&Inputs) -> Result<Model, ModelError>,
}

impl Entry {
    /// The inputs the paper states, on which the check values rest, and a representative value of each condition.
    /// What the paper leaves open (the width of a steel sheet) is assumed.
    pub fn stated_inputs(&self) -> Inputs {
        (self.stated)()
    }

    /// Everything [`Entry::build`] asks for: parameters, then conditions.
    pub fn inputs(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.parameters.iter().chain(self.conditions)
    }

    /// The model for given inputs, parameters and conditions alike.
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

/// Printed equations that cannot be evaluated at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unevaluable {
    /// The actuator type they describe.
    pub actuator: &'static str,
    /// Which equations.
    pub equations: &'static str,
    /// Every reason.
    pub why: &'static [&'static str],
    /// Paper and place.
    pub source: &'static str,
}

/// What is printed and cannot be evaluated, and why: nothing is invented to fill it.
pub fn unevaluable() -> &'static [Unevaluable] {
    wave_finger::UNEVALUABLE
}

/// Every entry, by actuator, quantity and form in the order in which they are reported.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    internal_support::ENTRIES
        .iter()
        .chain(dual_chamber_finger::ENTRIES)
        .chain(wave_finger::ENTRIES)
        .chain(fruit_finger::ENTRIES)
        .chain(pdms_wall::ENTRIES)
        .chain(constant_curvature::ENTRIES)
}

/// The entry of an actuator type, quantity and form.
pub fn find(actuator: &str, quantity: &str, form: &str) -> Option<&'static Entry> {
    entries().find(|e| e.actuator == actuator && e.quantity == quantity && e.form == form)
}

/// A form at its stated inputs, some of them changed, at gauge pressures: what checks evaluate.
fn evaluate(
    (actuator, quantity, form): (&str, &str, &str),
    changed: &[(Parameter, f64)],
    pressures_gauge_pa: &[f64],
) -> Result<Vec<f64>, ModelError> {
    let entry = find(actuator, quantity, form)
        .ok_or(ModelError::MissingParameter { name: "form", meaning: "a form of this catalogue" })?;
    let mut inputs = entry.stated_inputs();
    for (parameter, value_si) in changed {
        inputs.set(parameter.name, *value_si);
    }
    entry.build(&inputs)?.predict(pressures_gauge_pa)
}

/// One component of it.
fn component(values: &[f64], index: usize) -> Result<f64, ModelError> {
    values.get(index).copied().ok_or(ModelError::NotScalar { components: values.len() })
}
