//! The tensile machine: force over displacement of strips, from a material's law.
//!
//! `F = P(1 + u/L) A`, P the nominal stress of the law in uniaxial tension, L gauge length, A the undeformed section. Pulled at a constant
//! speed to the largest stretch. Machines write time, displacement and force; the strip's size stands above them.

use std::fmt::Write as _;

use serde::Serialize;

use pneuval_ingest::IngestError;
use pneuval_ingest::digest;
use pneuval_ingest::error::{Place, suggestion};
use pneuval_ingest::manifest::Actuator;
use pneuval_models::catalogue;
use pneuval_models::materials::LoadCase;

use super::Sink;
use super::plan::{Plan, Tensile};
use super::random::Normal;

/// What really was the case, `tensile/truth.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Record {
    schema: u32,
    synthetic: bool,
    plan: String,
    seed: u64,
    tests: Vec<Test>,
}

/// The strips of one material.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Test {
    material: String,
    law: String,
    /// Constants in SI units.
    constants: Vec<(String, f64)>,
    length_m: f64,
    area_m2: f64,
    stretch_max: f64,
    strips: Vec<Strip>,
}

/// One strip.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Strip {
    file: String,
    sha256: String,
    /// What this strip makes of every stress.
    factor: f64,
    samples: usize,
}

/// Writes the tests of a plan, if it has any.
///
/// # Errors
/// [`IngestError::Malformed`] for a material that the actuator does not have, or a law that has no stress so far; as the sink.
pub fn write(plan: &Plan, actuator: &Actuator, seed: u64, note: &str, sink: Sink) -> Result<(), IngestError> {
    if plan.tensile.is_empty() {
        return Ok(());
    }
    let mut tests = Vec::new();
    for tensile in &plan.tensile {
        let wrong = |expected: &str, found: String, next: String| IngestError::Malformed {
            place: Place::new(&plan.file, Some(tensile.line), Some(format!("tensile test of `{}`", tensile.material))),
            expected: expected.to_owned(),
            found,
            next,
        };
        let Some(material) = actuator.materials.get(&tensile.material) else {
            let next = suggestion(&tensile.material, actuator.materials.keys().map(String::as_str));
            return Err(wrong("a material of the actuator", format!("`{}`", tensile.material), next));
        };
        let value = |name: &str| Some(actuator.values.get(material.constants.get(name)?)?.si);
        let refused = |error: &dyn std::fmt::Display| {
            wrong("a law that can be evaluated", error.to_string(), "correct the material, or the stretch".to_owned())
        };
        let entry = catalogue::find_law(&material.law).ok_or_else(|| refused(&format!("`{}`", material.law)))?;
        let law = entry.build(&value).map_err(|error| refused(&error))?;
        let constants = material.constants.keys().filter_map(|name| Some((name.clone(), value(name)?))).collect();
        let stress = |stretch: f64| law.nominal_stress_pa(LoadCase::Uniaxial, stretch).map_err(|error| refused(&error));
        let mut strips = Vec::new();
        for number in 1..=tensile.strips {
            let purpose = format!("tensile {} {number}", tensile.material);
            let factor = 1.0 + tensile.spread * Normal::new(seed, &format!("{purpose} strip")).next();
            let (text, samples) = strip(tensile, factor, &stress, Normal::new(seed, &purpose), note)?;
            let file = format!("{}-{number}.csv", tensile.material);
            sink(&format!("tensile/{file}"), text.as_bytes())?;
            strips.push(Strip { sha256: digest::sha256(text.as_bytes()), file, factor, samples });
        }
        tests.push(Test {
            material: tensile.material.clone(),
            law: material.law.clone(),
            constants,
            length_m: tensile.length_m,
            area_m2: tensile.width_m * tensile.thickness_m,
            stretch_max: tensile.stretch_max,
            strips,
        });
    }
    let record = Record { schema: 1, synthetic: true, plan: plan.id.clone(), seed, tests };
    let mut json = serde_json::to_string_pretty(&record)
        .map_err(|source| IngestError::write("truth.json".as_ref(), source.into()))?;
    json.push('\n');
    sink("tensile/truth.json", json.as_bytes())
}

/// The file of one strip, and its samples.
fn strip(
    tensile: &Tensile,
    factor: f64,
    stress_pa: &dyn Fn(f64) -> Result<f64, IngestError>,
    mut noise: Normal,
    note: &str,
) -> Result<(String, usize), IngestError> {
    let Tensile { length_m, width_m, thickness_m, speed_m_per_s, stretch_max, rate_hz, .. } = tensile;
    let mut text = format!(
        "# {note}\n# strip: length {} mm, width {} mm, thickness {} mm, pulled at {:.3} mm/min\n\
         time,displacement,force\ns,mm,N\n",
        length_m * 1e3,
        width_m * 1e3,
        thickness_m * 1e3,
        speed_m_per_s * 60e3
    );
    let mut samples = 0;
    loop {
        let seconds = samples as f64 / rate_hz;
        let displacement_m = speed_m_per_s * seconds;
        let stretch = 1.0 + displacement_m / length_m;
        if stretch > *stretch_max {
            return Ok((text, samples));
        }
        let force = factor * stress_pa(stretch)? * width_m * thickness_m + tensile.force_noise_n * noise.next();
        let displacement_mm = 1e3 * (displacement_m + tensile.displacement_noise_m * noise.next());
        // Writing to a string does not fail. No negative zero: nobody logs one.
        let round = |value: f64| (value * 1e4).round() / 1e4 + 0.0;
        let _ = writeln!(text, "{:.3},{},{}", seconds, round(displacement_mm), round(force));
        samples += 1;
    }
}
