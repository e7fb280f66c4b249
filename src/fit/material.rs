//! `pneuval fit material`.

use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use pneuval_analysis::fit::estimate::{Estimates, Identified};
use pneuval_analysis::fit::material::{FittedLaw, Measured, Refused, Weighting, eq_28_line, fit};
use pneuval_ingest::IngestError;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::finding::Finding;
use pneuval_ingest::limits;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::tensile::{self, Asked, Named, Specimen, Test};
use pneuval_ingest::units::{Dimension, Unit};
use pneuval_models::materials::{Family, LoadCase};

use super::arguments::{FitMaterial, WeightArgument};
use super::words;
use crate::exit::{Failure, Outcome};
use crate::predict::amount;
use crate::{output, table};

/// The method of wave-finger's Eq. 28.
const EQ_28: &str = "eq-28";

/// What `--json` prints, in SI units.
#[derive(Serialize)]
struct Told {
    tests: Vec<TestTold>,
    weighting: &'static str,
    laws: Vec<FittedLaw>,
    eq_28: Option<LineTold>,
    refused: Vec<Refused>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct TestTold {
    file: String,
    sha256: String,
    load_case: &'static str,
    samples_used: usize,
    samples_available: usize,
    stretch_min: f64,
    stretch_max: f64,
    length_m: Option<f64>,
    area_m2: Option<f64>,
    how: Vec<String>,
    findings: Vec<Finding>,
}

#[derive(Serialize)]
struct LineTold {
    estimates: Estimates,
    samples_used: usize,
}

pub fn run(arguments: &FitMaterial) -> Result<Outcome, Failure> {
    let (families, line) = families(&arguments.law)?;
    if arguments.write.is_some() && families.len() + usize::from(line) != 1 {
        return Err(Failure::Flag {
            flag: "--write",
            found: format!("{} laws", families.len() + usize::from(line)),
            expected: "one law, whose constants are written".to_owned(),
            next: "name it with --law".to_owned(),
        });
    }
    let asked = asked(arguments)?;
    let mut tests: Vec<(LoadCase, Test)> = Vec::new();
    for (case, files) in [
        (LoadCase::Uniaxial, &arguments.uniaxial),
        (LoadCase::Planar, &arguments.planar),
        (LoadCase::Equibiaxial, &arguments.equibiaxial),
    ] {
        for path in files {
            let raw = RawFile::open(path, &path.display().to_string(), limits::LOG_BYTES_MAX)?;
            tests.push((case, tensile::read(&raw, &asked)?));
        }
    }
    let measured: Vec<Measured> = tests
        .iter()
        .map(|(case, test)| Measured { label: test.file.clone(), case: *case, points: test.points().collect() })
        .collect();
    let weighting = match arguments.weight {
        WeightArgument::Samples => Weighting::Samples,
        WeightArgument::Tests => Weighting::Tests,
        WeightArgument::Relative => Weighting::Relative,
    };
    let fitted: Vec<Result<FittedLaw, Refused>> = families
        .par_iter()
        .map(|family| {
            fit(*family, &measured, weighting, arguments.confidence)
                .map_err(|error| Refused { id: family.id().to_owned(), why: error.to_string() })
        })
        .collect();
    let mut told = Told {
        tests: tests.iter().map(|(case, test)| test_told(*case, test)).collect(),
        weighting: weighting.words(),
        laws: vec![],
        eq_28: None,
        refused: vec![],
        warnings: vec![],
    };
    for law in fitted {
        match law {
            Ok(law) => told.laws.push(law),
            Err(refused) => told.refused.push(refused),
        }
    }
    if line && measured.iter().any(|test| test.case == LoadCase::Uniaxial) {
        match eq_28_line(&measured, arguments.confidence) {
            Ok((estimates, samples_used)) => told.eq_28 = Some(LineTold { estimates, samples_used }),
            Err(error) => told.refused.push(Refused { id: EQ_28.to_owned(), why: error.to_string() }),
        }
    }
    told.warnings = warnings(&measured, &told.laws);
    if let Some(path) = &arguments.write {
        write(path, &told)?;
    }
    if arguments.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told))?;
    }
    let sound = |law: &FittedLaw| {
        law.no_material.is_none() && law.estimates.parameters.iter().all(|p| p.identified != Identified::Not)
    };
    // Of all laws some always are more than the data determine: only what was asked for by name decides.
    let open = !arguments.law.is_empty() && (!told.refused.is_empty() || !told.laws.iter().all(sound));
    Ok(if open || told.laws.is_empty() && told.eq_28.is_none() { Outcome::Open } else { Outcome::Expected })
}

/// The families asked for, and whether the line of Eq. 28 is.
fn families(asked: &[String]) -> Result<(Vec<Family>, bool), Failure> {
    if asked.is_empty() {
        return Ok((Family::ALL.to_vec(), true));
    }
    let mut families = Vec::new();
    for id in asked.iter().filter(|id| *id != EQ_28) {
        let known = || Family::ALL.iter().map(|family| family.id()).chain([EQ_28]);
        let family = Family::find(id).ok_or_else(|| Failure::Flag {
            flag: "--law",
            found: format!("`{id}`"),
            expected: known().collect::<Vec<_>>().join(", "),
            next: suggestion(id, known()),
        })?;
        if !families.contains(&family) {
            families.push(family);
        }
    }
    Ok((families, asked.iter().any(|id| id == EQ_28)))
}

/// What the flags say of the files.
fn asked(arguments: &FitMaterial) -> Result<Asked, Failure> {
    let size = |flag: &'static str, text: &Option<String>, dimension: Dimension| -> Result<Option<f64>, Failure> {
        let Some(text) = text else { return Ok(None) };
        let wrong = |next: String| Failure::Flag {
            flag,
            found: format!("`{text}`"),
            expected: format!("{} above zero, with its unit", dimension.name()),
            next,
        };
        let (value, symbol) = amount(text.trim()).ok_or_else(|| wrong("write a number and a unit".to_owned()))?;
        let unit = Unit::parse(symbol).filter(|unit| unit.dimension == dimension);
        let unit = unit.ok_or_else(|| wrong(Unit::suggestion(symbol)))?;
        if value > 0.0 { Ok(Some(unit.to_si(value))) } else { Err(wrong("correct the number".to_owned())) }
    };
    let width = size("--width", &arguments.width, Dimension::Length)?;
    let thickness = size("--thickness", &arguments.thickness, Dimension::Length)?;
    let area = size("--area", &arguments.area, Dimension::Area)?.or(width.zip(thickness).map(|(w, t)| w * t));
    let named = |text: &str| {
        let (name, unit) = text.split_once('/').map_or((text, None), |(name, unit)| (name, Some(unit.trim())));
        Named { name: name.trim().to_owned(), unit: unit.map(str::to_owned) }
    };
    let columns = arguments.columns.as_deref().map(|text| text.split(',').map(named).collect()).unwrap_or_default();
    Ok(Asked {
        columns,
        specimen: Specimen { length_m: size("--length", &arguments.length, Dimension::Length)?, area_m2: area },
        negate: arguments.negate,
        loading: arguments.loading.map(usize::from),
        stretch_min: arguments.stretch_min,
        stretch_max: arguments.stretch_max,
    })
}

fn test_told(case: LoadCase, test: &Test) -> TestTold {
    let stretches = || test.points().map(|point| point.0);
    TestTold {
        file: test.file.clone(),
        sha256: test.sha256.clone(),
        load_case: case.name(),
        samples_used: test.points().count(),
        samples_available: test.stretch.len(),
        stretch_min: stretches().fold(f64::INFINITY, f64::min),
        stretch_max: stretches().fold(0.0, f64::max),
        length_m: test.specimen.length_m,
        area_m2: test.specimen.area_m2,
        how: test.reasons.clone(),
        findings: test.findings.clone(),
    }
}

/// What a reader must know of all laws together.
fn warnings(tests: &[Measured], laws: &[FittedLaw]) -> Vec<String> {
    const ALIKE: f64 = 0.05;
    let mut warnings = Vec::new();
    let measured: Vec<LoadCase> =
        LoadCase::ALL.into_iter().filter(|case| tests.iter().any(|t| t.case == *case)).collect();
    if let [only] = measured.as_slice() {
        let far = tests.iter().flat_map(|test| &test.points).map(|p| p.0).fold(1.0, f64::max);
        // Halfway in strain: the far end of one load case is out of reach in another.
        let stretch = 1.0 + 0.5 * (far - 1.0);
        // Laws that fit the measured case alike may say very different things of the others.
        let best = laws.iter().map(|law| law.relative_rmse).fold(f64::INFINITY, f64::min);
        let good =
            || laws.iter().filter(|law| law.relative_rmse <= (2.0 * best).max(ALIKE) && law.no_material.is_none());
        let mut spread = Vec::new();
        for case in LoadCase::ALL.into_iter().filter(|case| case != only) {
            let stresses: Vec<f64> = good().filter_map(|law| stress(law, case, stretch)).collect();
            let low = stresses.iter().copied().fold(f64::INFINITY, f64::min);
            let high = stresses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if stresses.len() > 1 {
                let range =
                    format!("{} to {} kPa {}", table::number(1e-3 * low), table::number(1e-3 * high), case.name());
                spread.push(range);
            }
        }
        let told = if spread.is_empty() {
            String::new()
        } else {
            format!("; at stretch {} the laws that fit alike say {}", table::number(stretch), spread.join(", "))
        };
        warnings.push(format!(
            "only {} tests: every other load case is extrapolated, and no fit here says how well{told}; measure planar or equibiaxial tension before using the constants in a bulging wall",
            only.name()
        ));
    }
    if let Some(law) = laws
        .iter()
        .filter(|law| law.neighbours.is_some_and(|r| r > 0.5))
        .min_by(|a, b| a.relative_rmse.total_cmp(&b.relative_rmse))
    {
        let r = law.neighbours.unwrap_or_default();
        let factor = ((1.0 + r) / (1.0 - r).max(1e-3)).sqrt();
        warnings.push(format!(
            "neighbouring residuals correlate (by {} even for {}): they are misfit of the law, not scatter, so standard errors and intervals are too short, by about a factor of {} for that law and more for the others",
            table::number(r),
            law.id,
            table::number((10.0 * factor).round() / 10.0)
        ));
    }
    warnings
}

/// What a fitted law says.
fn stress(law: &FittedLaw, case: LoadCase, stretch: f64) -> Option<f64> {
    let family = Family::find(&law.id)?;
    let constants: Vec<f64> = law.estimates.parameters.iter().map(|p| p.value).collect();
    let mut slopes = vec![0.0; constants.len()];
    family.nominal_stress_pa(&constants, case, stretch, &mut slopes).ok().filter(|s| s.is_finite())
}

/// Units in which constants are shown.
const UNITS: [(&str, &str, f64); 13] = [
    ("C10", "MPa", 1e6),
    ("C20", "MPa", 1e6),
    ("C30", "MPa", 1e6),
    ("c1", "MPa", 1e6),
    ("c2", "MPa", 1e6),
    ("mu", "MPa", 1e6),
    ("Jm", "1", 1.0),
    ("mu1", "MPa", 1e6),
    ("mu2", "MPa", 1e6),
    ("mu3", "MPa", 1e6),
    ("alpha1", "1", 1.0),
    ("alpha2", "1", 1.0),
    ("alpha3", "1", 1.0),
];

fn text(told: &Told) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail, here and below.
    for test in &told.tests {
        let _ = writeln!(
            out,
            "{} test {}: {} of {} samples, stretch {} to {}",
            test.load_case,
            test.file,
            test.samples_used,
            test.samples_available,
            table::number(test.stretch_min),
            table::number(test.stretch_max)
        );
        for how in &test.how {
            let _ = writeln!(out, "  {how}");
        }
        for finding in &test.findings {
            let _ = writeln!(out, "  {}: {}", finding.severity.id(), finding.text);
        }
    }
    let _ = writeln!(out, "residuals: law - measured, {}\n", told.weighting);
    if told.laws.len() > 1 {
        out += &ranking(told);
    }
    for law in &told.laws {
        out += &law_text(law);
    }
    if let Some(line) = &told.eq_28 {
        let _ = writeln!(
            out,
            "{EQ_28}: wave-finger's straight line, t1/(2(l - l^-2)) over 2(l^2 + 2/l), {} samples, every sample of the line alike: weights samples near stretch 1 up",
            line.samples_used
        );
        let _ = writeln!(out, "{}", words::estimates(&line.estimates, &UNITS));
    }
    for refused in &told.refused {
        let _ = writeln!(out, "{}: {}", refused.id, refused.why);
    }
    for warning in &told.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// The laws beside each other.
fn ranking(told: &Told) -> String {
    let headers =
        ["law", "constants", "RMSE", "of largest", "AICc", "left-out load case, worst", "stable where fitted"];
    let mut rows = table::plain(&headers, &[1, 2, 3, 4]);
    let best = told.laws.iter().filter_map(|law| law.aicc).fold(f64::INFINITY, f64::min);
    for law in &told.laws {
        let worst = law
            .left_out
            .iter()
            .max_by(|a, b| a.relative.unwrap_or(f64::INFINITY).total_cmp(&b.relative.unwrap_or(f64::INFINITY)));
        let worst = worst.map_or("–".to_owned(), |out| match out.relative {
            Some(relative) => format!("{} {} %", out.load_case, table::number(round(100.0 * relative))),
            None => format!("{} not determined", out.load_case),
        });
        let unstable: Vec<&str> = law.stability.iter().filter(|s| !s.inside).map(|s| s.load_case).collect();
        let stable = match &law.no_material {
            Some(_) => "no material".to_owned(),
            None if unstable.is_empty() => "yes".to_owned(),
            None => format!("not {}", unstable.join(", ")),
        };
        let largest_kpa = 1e-3 * law.estimates.rmse;
        rows.add_row(vec![
            law.id.clone(),
            law.estimates.parameters.len().to_string(),
            if told.weighting == Weighting::Relative.words() {
                "–".to_owned()
            } else {
                format!("{} kPa", table::number(round(largest_kpa)))
            },
            format!("{} %", table::number(round(100.0 * law.relative_rmse))),
            law.aicc.map_or("–".to_owned(), |aicc| format!("+{}", table::number(round(aicc - best)))),
            worst,
            stable,
        ]);
    }
    table::fit(&mut rows);
    format!("{}\n\n", rows.trim_fmt())
}

/// Three digits are enough to compare.
fn round(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn law_text(law: &FittedLaw) -> String {
    let mut out = format!("{}\n", law.id);
    out += &words::estimates(&law.estimates, &UNITS);
    for case in &law.stability {
        let ends = match (case.unstable_below, case.unstable_above) {
            (None, None) => continue,
            (Some(below), None) => format!("below stretch {}", table::number(below)),
            (None, Some(above)) => format!("from stretch {} on", table::number(above)),
            (Some(below), Some(above)) => {
                format!("below stretch {} and from {} on", table::number(below), table::number(above))
            }
        };
        let _ = writeln!(
            out,
            "unstable      {} {ends}: {}",
            case.load_case,
            if case.inside { "beyond what was fitted" } else { "inside what was fitted" }
        );
    }
    if let Some(why) = &law.no_material {
        let _ = writeln!(out, "no material   {why}");
    }
    for case in &law.left_out {
        let told = match (case.rmse_pa, case.relative, &case.why) {
            (Some(rmse), Some(relative), _) => {
                format!(
                    "RMSE {} kPa, {} % of its largest stress",
                    table::number(round(1e-3 * rmse)),
                    table::number(round(100.0 * relative))
                )
            }
            (_, _, Some(why)) => why.clone(),
            _ => continue,
        };
        let _ = writeln!(out, "left out      {} predicted by a fit to the others: {told}", case.load_case);
    }
    out + "\n"
}

/// The constants as a material of an actuator file.
fn write(path: &Path, told: &Told) -> Result<(), Failure> {
    let (law, estimates) = match (told.laws.first(), &told.eq_28) {
        (Some(law), _) => (law.law.as_str(), &law.estimates),
        (None, Some(line)) => ("yeoh", &line.estimates),
        (None, None) => return Ok(()),
    };
    if let Some(why) = told.laws.first().and_then(|law| law.no_material.as_ref()) {
        return Err(Failure::Flag {
            flag: "--write",
            found: why.clone(),
            expected: "constants that are a material".to_owned(),
            next: "fit another law, or look at the findings of the tests".to_owned(),
        });
    }
    let files: Vec<String> =
        told.tests.iter().map(|test| format!("{} (SHA-256 {})", test.file, &test.sha256[..12])).collect();
    let place = format!(
        "pneuval fit material, {}: {}",
        told.tests.iter().map(|t| t.load_case).collect::<Vec<_>>().join(", "),
        files.join("; ")
    );
    let mut out = format!("[material.silicone]\nlaw = \"{law}\"\n\n[material.silicone.constants]\n");
    for p in &estimates.parameters {
        let (symbol, factor) = UNITS.iter().find(|u| u.0 == p.name).map_or(("1", 1.0), |u| (u.1, u.2));
        let std = p.std.map_or(String::new(), |std| format!(", std = {:e}", std / factor));
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{} = {{ value = {:e}{std}, unit = \"{symbol}\", source = \"calibrated\", place = {} }}",
            p.name,
            p.value / factor,
            toml_text(&place)
        );
    }
    std::fs::write(path, out).map_err(|source| IngestError::write(path, source))?;
    output::tell(&format!("wrote {}", path.display()));
    Ok(())
}

/// A text as TOML has it.
pub fn toml_text(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => {
                // Writing to a String cannot fail.
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
