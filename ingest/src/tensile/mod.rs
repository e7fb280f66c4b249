//! Tests of material strips: force over displacement, or stress over strain, to nominal stress over stretch.
//!
//! | a column says | what becomes of it |
//! |---|---|
//! | stretch l | l |
//! | engineering strain e (1 or %) | l = 1 + e |
//! | true strain | l = exp(e) |
//! | displacement u, gauge length L | l = 1 + u/L |
//! | engineering stress P | P |
//! | true stress | P = true stress / l, uniaxial: the material keeps its volume |
//! | force F, section A at rest | P = F/A |
//!
//! Where a table holds both, engineering columns are used and true ones are checked against them. What is odd is found and told:
//! see [`defects`].

mod columns;
pub mod defects;

use crate::IngestError;
use crate::error::Place;
use crate::finding::Finding;
use crate::formats::{self, Options};
use crate::raw::RawFile;
use crate::recording::Keep;

pub use columns::Named;

/// A strip at rest, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Specimen {
    /// Length between the grips or marks.
    pub length_m: Option<f64>,
    /// Section across the load.
    pub area_m2: Option<f64>,
}

/// What a user says of a test file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Asked {
    /// Names of the columns from the left, where the file has none or others: `stress/MPa`.
    pub columns: Vec<Named>,
    /// The strip; what is absent is looked for in the file's own words.
    pub specimen: Specimen,
    /// Turn the sign of forces and stresses, of a machine that counts tension as negative.
    pub negate: bool,
    /// Which loading of several is used, from 1; the last where nothing is said.
    pub loading: Option<usize>,
    /// Stretches below this are left out.
    pub stretch_min: Option<f64>,
    /// Stretches above this are left out.
    pub stretch_max: Option<f64>,
}

/// A test: nominal stress over stretch, both as long as the file has samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// The file, as the user named it.
    pub file: String,
    /// SHA-256 of it.
    pub sha256: String,
    /// Length over length at rest.
    pub stretch: Vec<f64>,
    /// Force over section at rest.
    pub nominal_stress_pa: Vec<f64>,
    /// Which samples are used.
    pub used: Vec<bool>,
    /// How each was found out, one sentence each.
    pub reasons: Vec<String>,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// The specimen, as far as known.
    pub specimen: Specimen,
}

impl Test {
    /// Stretch and stress of the samples that are used.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let all = self.stretch.iter().zip(&self.nominal_stress_pa).zip(&self.used);
        all.filter(|(_, used)| **used).map(|((stretch, stress), _)| (*stretch, *stress))
    }
}

/// Reads a test.
///
/// # Errors
/// As [`formats::read`]; [`IngestError::Malformed`] where columns or the specimen are not known, [`IngestError::Unusable`] for a file in
/// which load has the wrong sign or fewer than two samples can be used.
pub fn read(raw: &RawFile, asked: &Asked) -> Result<Test, IngestError> {
    let recording = formats::read(raw, &Options::default(), Keep::All)?;
    let Some(table) = recording.tables.iter().max_by_key(|table| table.rows) else {
        return Err(unusable(raw, "a table of numbers", "none", "is this the file of a test?"));
    };
    let specimen = columns::specimen(&recording.metadata, asked.specimen);
    let meant = columns::meant(raw.name(), table, &asked.columns)?;
    let (stretch, said_stretch) = meant.stretch(raw.name(), specimen)?;
    let (stress, said_stress) = meant.stress(raw.name(), specimen, &stretch)?;
    let sign = if asked.negate { -1.0 } else { 1.0 };
    let stress: Vec<f64> = stress.iter().map(|s| sign * s).collect();
    let mut findings: Vec<Finding> = recording.findings;
    let mut used = vec![true; stretch.len()];
    let mut reasons = vec![said_stretch, said_stress];
    findings.extend(meant.contradictions(raw.name(), &stretch, &stress, sign, &table.lines));
    let curve = defects::Curve { file: raw.name(), stretch: &stretch, stress_pa: &stress, lines: &table.lines };
    if let Some(found) = curve.wrong_sign() {
        let found = format!("stress of the other sign in {found} of the samples");
        let next = "turn it with --negate if the machine counts tension as negative, or look at the wiring";
        return Err(unusable(raw, "tension where the strip gets longer, pressure where it gets shorter", &found, next));
    }
    curve.no_numbers(&mut used, &mut findings);
    if let Some(time) = &meant.time {
        curve.clock(time, &mut findings);
    }
    reasons.extend(curve.loadings(asked.loading, &mut used, &mut findings));
    curve.rupture(&mut used, &mut findings);
    curve.slippage(&used, &mut findings);
    curve.slack(&used, &mut findings);
    curve.stiffness(&used, &mut findings);
    let (min, max) = (asked.stretch_min.unwrap_or(0.0), asked.stretch_max.unwrap_or(f64::INFINITY));
    let outside = |i: usize| used[i] && !(min..=max).contains(&stretch[i]);
    let left_out = (0..used.len()).filter(|i| outside(*i)).count();
    for i in 0..used.len() {
        used[i] = used[i] && (min..=max).contains(&stretch[i]);
    }
    if left_out > 0 {
        reasons.push(format!("{left_out} samples lie outside the stretches asked for and are left out"));
    }
    if used.iter().filter(|used| **used).count() < 2 {
        return Err(unusable(
            raw,
            "two samples at least that can be used",
            "fewer",
            "look at the findings of `pneuval inspect`",
        ));
    }
    let sha256 = raw.sha256()?;
    Ok(Test {
        file: raw.name().to_owned(),
        sha256,
        stretch,
        nominal_stress_pa: stress,
        used,
        reasons,
        findings,
        specimen,
    })
}

fn unusable(raw: &RawFile, expected: &str, found: &str, next: &str) -> IngestError {
    IngestError::Unusable {
        place: Place::new(raw.name(), None, None),
        expected: expected.to_owned(),
        found: found.to_owned(),
        next: next.to_owned(),
    }
}
