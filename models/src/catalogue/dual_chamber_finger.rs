//! The forms of the dual-chamber finger: its tip, the readings of its root, and their sum.

use std::f64::consts::PI;

use super::{Check, Entry, FormKind, Inputs, Model, Parameter};
use crate::ModelError;
use crate::actuators::dual_chamber_finger::{Layer, Root, RootReading, RootStress, Section, Sheet, Tip, TipReading};
use crate::materials::Yeoh;
use crate::solve::Branch;

const WIDTH: Parameter = Parameter { name: "width", si_unit: "m", meaning: "w, finger width" };
const STRAIGHT: Parameter =
    Parameter { name: "chamber_straight_height", si_unit: "m", meaning: "k, straight part of the chamber height" };
const CONSTRAINT: Parameter =
    Parameter { name: "constraint_thickness", si_unit: "m", meaning: "z, strain restriction layer" };
const CHAMBER_LENGTH: Parameter = Parameter { name: "chamber_length", si_unit: "m", meaning: "u, chamber length" };
const OUTER_RADIUS: Parameter = Parameter { name: "outer_radius", si_unit: "m", meaning: "R, outer radius" };
const CHAMBER_WIDTH: Parameter = Parameter { name: "chamber_width", si_unit: "m", meaning: "s, chamber width" };
const CHAMBER_RADIUS: Parameter = Parameter { name: "chamber_radius", si_unit: "m", meaning: "r1, chamber radius" };
const RADIAL_WALL: Parameter = Parameter { name: "radial_wall", si_unit: "m", meaning: "g, radial wall" };
const TIP_WALL: Parameter = Parameter { name: "tip_wall", si_unit: "m", meaning: "e, expansion wall of the tip" };
const TIP_AIRBAGS: Parameter = Parameter { name: "tip_airbags", si_unit: "1", meaning: "n, airbags of the tip" };
const ROOT_LENGTH: Parameter = Parameter { name: "root_length", si_unit: "m", meaning: "a, root length" };
const SHEET_THICKNESS: Parameter = Parameter { name: "sheet_thickness", si_unit: "m", meaning: "t, steel sheet" };
const SHEET_WIDTH: Parameter =
    Parameter { name: "sheet_width", si_unit: "m", meaning: "width of the steel sheet (not printed)" };
const SHEET_MODULUS: Parameter =
    Parameter { name: "sheet_modulus", si_unit: "Pa", meaning: "E, Young's modulus of the sheet" };
const C10: Parameter = Parameter { name: "C10", si_unit: "Pa", meaning: "C10, first Yeoh constant" };
const C20: Parameter = Parameter { name: "C20", si_unit: "Pa", meaning: "C20, second Yeoh constant" };

const TIP_PARAMETERS: &[Parameter] = &[
    WIDTH,
    STRAIGHT,
    CONSTRAINT,
    CHAMBER_LENGTH,
    OUTER_RADIUS,
    CHAMBER_WIDTH,
    CHAMBER_RADIUS,
    RADIAL_WALL,
    TIP_WALL,
    TIP_AIRBAGS,
    C10,
    C20,
];
const ROOT_PARAMETERS: &[Parameter] = &[
    WIDTH,
    STRAIGHT,
    CONSTRAINT,
    CHAMBER_LENGTH,
    OUTER_RADIUS,
    CHAMBER_WIDTH,
    CHAMBER_RADIUS,
    RADIAL_WALL,
    SHEET_THICKNESS,
    C10,
    C20,
];
const SHEET_PARAMETERS: &[Parameter] = &[
    WIDTH,
    STRAIGHT,
    CONSTRAINT,
    CHAMBER_LENGTH,
    OUTER_RADIUS,
    CHAMBER_WIDTH,
    CHAMBER_RADIUS,
    RADIAL_WALL,
    SHEET_THICKNESS,
    SHEET_MODULUS,
    C10,
    C20,
];
const STRIP_PARAMETERS: &[Parameter] = &[
    WIDTH,
    STRAIGHT,
    CONSTRAINT,
    CHAMBER_LENGTH,
    OUTER_RADIUS,
    CHAMBER_WIDTH,
    CHAMBER_RADIUS,
    RADIAL_WALL,
    SHEET_THICKNESS,
    SHEET_MODULUS,
    ROOT_LENGTH,
    SHEET_WIDTH,
    C10,
    C20,
];
const TOTAL_PARAMETERS: &[Parameter] = &[
    WIDTH,
    STRAIGHT,
    CONSTRAINT,
    CHAMBER_LENGTH,
    OUTER_RADIUS,
    CHAMBER_WIDTH,
    CHAMBER_RADIUS,
    RADIAL_WALL,
    TIP_WALL,
    TIP_AIRBAGS,
    SHEET_THICKNESS,
    C10,
    C20,
];

const TIP_SOURCE: &str = "dual-chamber-finger, Eq. 7 to 13";
const ROOT_SOURCE: &str = "dual-chamber-finger, Eq. 14 to 24";
const ROOT_EQUATION: &str = "P [s k²/2 + 2r1³/3 + π k r1²/2] = σ1 [g k² + 2(R³-r1³)/3 + π k(R²-r1²)/2 + w k2²/2 + c w k2(3/2 k2 + t)] + M3;  angle = θ";
const K2_NOT_PRINTED: &str = "k2 is not printed: 0.85 = (z - t)/2, 1.7 = z - t and 1.0 mm = z/2 are readings";

/// The reading that reaches the paper's total: no sheet, k2 1.7 mm, c 1.
const NO_SHEET: fn(&Inputs) -> Result<RootReading, ModelError> =
    |i| reading(i, Layer::OneSide, 1.0, RootStress::Linear, Sheet::None);

/// What the tip's forms share.
const TIP: Entry = Entry {
    actuator: "dual-chamber-finger",
    quantity: "tip-angle",
    quantity_si_unit: "rad",
    components: &[],
    form: "",
    kind: FormKind::Reading,
    title: "",
    equation: "",
    source: TIP_SOURCE,
    range: "0 <= θ <= 3 rad",
    misprints: &[],
    chambers: &["tip"],
    parameters: TIP_PARAMETERS,
    conditions: &[],
    checks: &[],
    stated: stated_inputs,
    builder: |i| Model::single(tip(i, TipReading::Printed)?),
};

/// What the root's readings share.
const ROOT: Entry = Entry {
    quantity: "root-angle",
    equation: ROOT_EQUATION,
    source: ROOT_SOURCE,
    chambers: &["root"],
    parameters: ROOT_PARAMETERS,
    builder: |i| root(i, NO_SHEET(i)?),
    ..TIP
};

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        form: "printed",
        kind: FormKind::Printed,
        title: "printed, Eq. 12",
        equation: "P = (Vr/V1) 2λ(1 - λ⁻⁴)[C10 + 2C20(λ - 1/λ)²], λ = θ/sin θ;  angle = n θ",
        misprints: &[
            "Eq. 9 prints V1(1 + λ) for V1 λ: the derivative, all that Eq. 12 uses, is the same",
            "Eq. 5, last line, prints (λ² - λ⁻²) for (λ - 1/λ); Eq. 12 follows the line above it",
        ],
        checks: &[
            volume_check("V1", 3_723.132_560, || stated_tip_mm3(Tip::airbag_volume_m3)),
            volume_check("V2", 1_480.778_684, || stated_tip_mm3(Tip::air_volume_m3)),
            volume_check("Vr = V1 - V2", 2_242.353_876, || stated_tip_mm3(Tip::silicone_volume_m3)),
            angle_check("10 kPa", 97.094_884, || tip_deg("printed", 10e3)),
            angle_check("20 kPa", 138.238_536, || tip_deg("printed", 20e3)),
            angle_check("30 kPa", 170.333_495, || tip_deg("printed", 30e3)),
            angle_check("40 kPa", 197.724_703, || tip_deg("printed", 40e3)),
        ],
        builder: |i| Model::single(tip(i, TipReading::Printed)?),
        ..TIP
    },
    Entry {
        form: "consistent",
        kind: FormKind::Consistent,
        title: "consistent, 2θ per airbag",
        equation: "as printed;  angle = 2 n θ",
        source: "re-derived from dual-chamber-finger, Eq. 7 to 13",
        misprints: &[
            "departs from print: λ = θ/sin θ is arc over chord with θ half the central angle, so one airbag bends by 2θ; the paper takes θ",
        ],
        checks: &[Check {
            statement: "40 kPa: twice the printed form",
            expected: 2.0 * 197.724_703,
            tolerance: 1e-6,
            unit: "deg",
            compute: || tip_deg("consistent", 40e3),
        }],
        builder: |i| Model::single(tip(i, TipReading::Consistent)?),
        ..TIP
    },
    Entry {
        form: "eq-5-last-line",
        title: "Eq. 5, last line",
        equation: "P = (Vr/V1) dW/dλ, W = C10(λ² - λ⁻²)² + C20(λ² - λ⁻²)⁴;  angle = n θ",
        source: "dual-chamber-finger, Eq. 5, last line",
        misprints: &["the misprint itself: Eq. 5, last line, does not equal the line above it"],
        checks: &[Check {
            statement: "40 kPa",
            expected: 96.98,
            tolerance: 5e-3,
            unit: "deg",
            compute: || tip_deg("eq-5-last-line", 40e3),
        }],
        builder: |i| Model::single(tip(i, TipReading::Eq5LastLine)?),
        ..TIP
    },
    Entry {
        form: "printed",
        kind: FormKind::Printed,
        title: "printed, β = λE (Eq. 21)",
        range: "no pressure below 551 MPa has a solution",
        misprints: &[
            "Eq. 21, β = λE, puts E = 193 GPa on an unbent sheet: the undeformed state already needs 551 MPa",
            K2_NOT_PRINTED,
            "Eq. 20 keeps an integral over θ that Eq. 23 drops (c = π or 1)",
        ],
        checks: &[Check {
            statement: "pressure that the undeformed state already needs (E w t (k2 + t/2) over the driving torque)",
            expected: 551.2,
            tolerance: 5e-2,
            unit: "MPa",
            compute: || match stated("root-angle", "printed")?.predict_scalar(&[50e3]) {
                Err(ModelError::BelowStart { start_gauge_pa, .. }) => Ok(start_gauge_pa * 1e-6),
                other => other,
            },
        }],
        builder: |i| {
            root(
                i,
                reading(
                    i,
                    Layer::TwoEqual,
                    1.0,
                    RootStress::Linear,
                    Sheet::Printed { modulus_pa: i.require(SHEET_MODULUS)? },
                )?,
            )
        },
        parameters: SHEET_PARAMETERS,
        ..ROOT
    },
    Entry {
        form: "sheet-strain",
        title: "β = (λ-1)E",
        misprints: &["departs from print: Eq. 21 with the strain λ - 1 for λ", K2_NOT_PRINTED],
        checks: &[Check {
            statement: "50 kPa: about 1 deg, k2 0.85",
            expected: 1.336,
            tolerance: 0.0005,
            unit: "deg",
            compute: || root_deg("sheet-strain", 50e3),
        }],
        builder: |i| {
            root(
                i,
                reading(
                    i,
                    Layer::TwoEqual,
                    1.0,
                    RootStress::Linear,
                    Sheet::Strain { modulus_pa: i.require(SHEET_MODULUS)? },
                )?,
            )
        },
        parameters: SHEET_PARAMETERS,
        ..ROOT
    },
    Entry {
        form: "elastic-strip",
        title: "elastic strip",
        misprints: &[
            "not in the paper: the sheet as an elastic strip bent over the root, M3 = E w t³/12 · θ/a, its width an assumed input",
            K2_NOT_PRINTED,
        ],
        parameters: STRIP_PARAMETERS,
        checks: &[Check {
            statement: "50 kPa: about 21 deg, k2 0.85",
            expected: 21.496,
            tolerance: 0.0005,
            unit: "deg",
            compute: || root_deg("elastic-strip", 50e3),
        }],
        builder: |i| root(i, reading(i, Layer::TwoEqual, 1.0, RootStress::Linear, strip(i, 1.0)?)?),
        ..ROOT
    },
    Entry {
        form: "elastic-strip-1000x-soft",
        title: "elastic strip, E/1000",
        misprints: &["not in the paper: as elastic-strip with E taken as 193 MPa, a GPa/MPa slip", K2_NOT_PRINTED],
        parameters: STRIP_PARAMETERS,
        checks: &[Check {
            statement: "50 kPa, k2 1.7: within 0.1 deg of leaving the sheet out",
            expected: 46.36,
            tolerance: 0.1,
            unit: "deg",
            compute: || root_deg("elastic-strip-1000x-soft", 50e3),
        }],
        builder: |i| root(i, reading(i, Layer::OneSide, 1.0, RootStress::Linear, strip(i, 1e-3)?)?),
        ..ROOT
    },
    Entry {
        form: "no-sheet-k2-1.7-c-1",
        title: "no sheet, k2 1.7, c 1",
        misprints: &[
            "leaves the sheet out; with it the total of 244 deg that the paper's 5.74 % implies is out of reach",
            K2_NOT_PRINTED,
        ],
        checks: &[
            angle_check("10 kPa", 21.389_539, || root_deg("no-sheet-k2-1.7-c-1", 10e3)),
            angle_check("20 kPa", 30.007_525, || root_deg("no-sheet-k2-1.7-c-1", 20e3)),
            angle_check("30 kPa", 36.463_191, || root_deg("no-sheet-k2-1.7-c-1", 30e3)),
            angle_check("40 kPa", 41.779_711, || root_deg("no-sheet-k2-1.7-c-1", 40e3)),
            angle_check("50 kPa", 46.357_709, || root_deg("no-sheet-k2-1.7-c-1", 50e3)),
            Check {
                statement: "total with the printed tip at 40 and 50 kPa",
                expected: 244.082,
                tolerance: 0.0005,
                unit: "deg",
                compute: || total_deg("no-sheet-k2-1.7-c-1", 50e3),
            },
        ],
        builder: |i| root(i, NO_SHEET(i)?),
        ..ROOT
    },
    Entry {
        form: "no-sheet-k2-1.0-c-pi",
        title: "no sheet, k2 1.0, c π",
        misprints: &["leaves the sheet out; keeps the outer integral of Eq. 20", K2_NOT_PRINTED],
        checks: &[Check {
            statement: "total with the printed tip at 40 and 50 kPa",
            expected: 244.140,
            tolerance: 0.0005,
            unit: "deg",
            compute: || total_deg("no-sheet-k2-1.0-c-pi", 50e3),
        }],
        builder: |i| root(i, reading(i, Layer::Half, PI, RootStress::Linear, Sheet::None)?),
        ..ROOT
    },
    Entry {
        form: "no-sheet-k2-0.85-c-1",
        title: "no sheet, k2 0.85, c 1",
        misprints: &["leaves the sheet out; k2 = (z - t)/2"],
        checks: &[
            Check {
                statement: "50 kPa",
                expected: 48.436,
                tolerance: 0.0005,
                unit: "deg",
                compute: || root_deg("no-sheet-k2-0.85-c-1", 50e3),
            },
            Check {
                statement: "total with the printed tip at 40 and 50 kPa",
                expected: 246.16,
                tolerance: 0.005,
                unit: "deg",
                compute: || total_deg("no-sheet-k2-0.85-c-1", 50e3),
            },
        ],
        builder: |i| root(i, reading(i, Layer::TwoEqual, 1.0, RootStress::Linear, Sheet::None)?),
        ..ROOT
    },
    Entry {
        form: "no-sheet-k2-0.85-c-pi",
        title: "no sheet, k2 0.85, c π",
        misprints: &["leaves the sheet out; k2 = (z - t)/2; keeps the outer integral of Eq. 20"],
        checks: &[
            Check {
                statement: "50 kPa",
                expected: 47.106,
                tolerance: 0.0005,
                unit: "deg",
                compute: || root_deg("no-sheet-k2-0.85-c-pi", 50e3),
            },
            Check {
                statement: "total with the printed tip at 40 and 50 kPa",
                expected: 244.83,
                tolerance: 0.005,
                unit: "deg",
                compute: || total_deg("no-sheet-k2-0.85-c-pi", 50e3),
            },
        ],
        builder: |i| root(i, reading(i, Layer::TwoEqual, PI, RootStress::Linear, Sheet::None)?),
        ..ROOT
    },
    Entry {
        form: "no-sheet-full-stress-k2-1.7-c-1",
        title: "no sheet, full Eq. 14",
        misprints: &["leaves the sheet out; the full stress of Eq. 14 for the linear one of Eq. 15", K2_NOT_PRINTED],
        checks: &[
            Check {
                statement: "50 kPa",
                expected: 49.889,
                tolerance: 0.0005,
                unit: "deg",
                compute: || root_deg("no-sheet-full-stress-k2-1.7-c-1", 50e3),
            },
            Check {
                statement: "total with the printed tip at 40 and 50 kPa",
                expected: 247.61,
                tolerance: 0.005,
                unit: "deg",
                compute: || total_deg("no-sheet-full-stress-k2-1.7-c-1", 50e3),
            },
        ],
        builder: |i| root(i, reading(i, Layer::OneSide, 1.0, RootStress::Full, Sheet::None)?),
        ..ROOT
    },
    Entry {
        quantity: "total-angle",
        form: "printed-no-sheet",
        title: "printed tip, root without sheet",
        equation: "ω = root angle + n θ of the tip (Eq. 25); root: no sheet, k2 1.7, c 1",
        source: "dual-chamber-finger, Eq. 25",
        range: "as its parts",
        misprints: &[
            "Eq. 21 as printed has no solution, so the printed total cannot be formed; the root is read without the sheet",
        ],
        chambers: &["tip", "root"],
        parameters: TOTAL_PARAMETERS,
        checks: &[Check {
            statement: "tip 40 kPa, root 50 kPa (the paper's 5.74 % against 230 deg implies 244)",
            expected: 244.082,
            tolerance: 5e-4,
            unit: "deg",
            compute: || Ok(stated("total-angle", "printed-no-sheet")?.predict_scalar(&[40e3, 50e3])?.to_degrees()),
        }],
        builder: |i| {
            let tip = Branch::trace(Box::new(tip(i, TipReading::Printed)?))?;
            let root = Branch::trace(Box::new(Root::new(section(i)?, law(i)?, NO_SHEET(i)?)?))?;
            Ok(Model::Sum(vec![tip, root]))
        },
        ..TIP
    },
];

fn section(i: &Inputs) -> Result<Section, ModelError> {
    Section {
        width_m: i.require(WIDTH)?,
        chamber_straight_height_m: i.require(STRAIGHT)?,
        constraint_thickness_m: i.require(CONSTRAINT)?,
        chamber_length_m: i.require(CHAMBER_LENGTH)?,
        outer_radius_m: i.require(OUTER_RADIUS)?,
        chamber_width_m: i.require(CHAMBER_WIDTH)?,
        chamber_radius_m: i.require(CHAMBER_RADIUS)?,
        radial_wall_m: i.require(RADIAL_WALL)?,
    }
    .checked()
}

fn law(i: &Inputs) -> Result<Yeoh, ModelError> {
    Yeoh::new(i.require(C10)?, i.require(C20)?, 0.0)
}

fn tip(i: &Inputs, reading: TipReading) -> Result<Tip, ModelError> {
    Tip::new(section(i)?, i.require(TIP_WALL)?, i.require(TIP_AIRBAGS)?, law(i)?, reading)
}

fn reading(
    i: &Inputs,
    layer: Layer,
    layer_factor: f64,
    stress: RootStress,
    sheet: Sheet,
) -> Result<RootReading, ModelError> {
    Ok(RootReading { layer, layer_factor, stress, sheet, sheet_thickness_m: i.require(SHEET_THICKNESS)? })
}

/// The sheet as an elastic strip, its modulus multiplied by a factor.
fn strip(i: &Inputs, factor: f64) -> Result<Sheet, ModelError> {
    Ok(Sheet::ElasticStrip {
        modulus_pa: factor * i.require(SHEET_MODULUS)?,
        root_length_m: i.require(ROOT_LENGTH)?,
        sheet_width_m: i.require(SHEET_WIDTH)?,
    })
}

fn root(i: &Inputs, reading: RootReading) -> Result<Model, ModelError> {
    Model::single(Root::new(section(i)?, law(i)?, reading)?)
}

/// The paper's dimensions and material (Table 1, sections 3.1 and 4.1), on which the check values rest.
fn stated_inputs() -> Inputs {
    [
        ("width", 28e-3),
        ("chamber_straight_height", 6e-3),
        ("constraint_thickness", 2e-3),
        ("chamber_length", 4e-3),
        ("outer_radius", 14e-3),
        ("chamber_width", 24e-3),
        ("chamber_radius", 12e-3),
        ("radial_wall", 2e-3),
        ("tip_wall", 1.5e-3),
        ("tip_airbags", 5.0),
        ("root_length", 38e-3),
        ("sheet_thickness", 0.3e-3),
        ("sheet_width", 28e-3),
        ("sheet_modulus", 193e9),
        ("C10", 0.11e6),
        ("C20", 0.02e6),
    ]
    .into_iter()
    .collect()
}

fn stated(quantity: &str, form: &str) -> Result<Model, ModelError> {
    let entry = ENTRIES.iter().find(|e| e.quantity == quantity && e.form == form);
    entry
        .ok_or(ModelError::MissingParameter { name: "form", meaning: "a form of this catalogue" })?
        .build(&stated_inputs())
}

fn tip_deg(form: &str, pressure_gauge_pa: f64) -> Result<f64, ModelError> {
    Ok(stated("tip-angle", form)?.predict_scalar(&[pressure_gauge_pa])?.to_degrees())
}

fn root_deg(form: &str, pressure_gauge_pa: f64) -> Result<f64, ModelError> {
    Ok(stated("root-angle", form)?.predict_scalar(&[pressure_gauge_pa])?.to_degrees())
}

fn total_deg(form: &str, root_pressure_gauge_pa: f64) -> Result<f64, ModelError> {
    Ok(tip_deg("printed", 40e3)? + root_deg(form, root_pressure_gauge_pa)?)
}

const fn angle_check(statement: &'static str, expected: f64, compute: fn() -> Result<f64, ModelError>) -> Check {
    Check { statement, expected, tolerance: 5e-7, unit: "deg", compute }
}

const fn volume_check(statement: &'static str, expected: f64, compute: fn() -> Result<f64, ModelError>) -> Check {
    Check { statement, expected, tolerance: 5e-7, unit: "mm³", compute }
}

fn stated_tip_mm3(volume_m3: fn(&Tip) -> f64) -> Result<f64, ModelError> {
    Ok(1e9 * volume_m3(&tip(&stated_inputs(), TipReading::Printed)?))
}
