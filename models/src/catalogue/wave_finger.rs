//! The forms of the wave-contour finger, and its equations that cannot be evaluated.

use std::f64::consts::PI;

use super::{Check, Entry, FormKind, Inputs, Model, Parameter, Unevaluable, component, evaluate};
use crate::ModelError;
use crate::actuators::wave_finger::LinearAngle;
use crate::kinematics::constant_curvature::Bent;

const FULL_PRESSURE: Parameter = Parameter {
    name: "linear_full_pressure",
    si_unit: "Pa",
    meaning: "p_full, gauge pressure of the far point of the assumed line",
};
const FULL_ANGLE: Parameter = Parameter {
    name: "linear_full_angle",
    si_unit: "rad",
    meaning: "θ_full, bending angle at p_full on the assumed line",
};
const LENGTH: Parameter = Parameter { name: "finger_length", si_unit: "m", meaning: "l0, length of the finger" };
const ANGLE: Parameter =
    Parameter { name: "bending_angle", si_unit: "rad", meaning: "θ = kl, measured bending angle of the tip" };

const BENDING_LINEAR: (&str, &str, &str) = ("wave-finger", "bending-angle", "linear");
const TIP_LINEAR: (&str, &str, &str) = ("wave-finger", "tip-position", "constant-curvature-linear");
const TIP_MEASURED: (&str, &str, &str) = ("wave-finger", "tip-position", "constant-curvature");

const LINE: &str = "the paper says \"linearly\" (section 2.2.3) and \"linear trend\" (section 4.2) and prints no coefficient: the line through (0, 0) and (26 kPa, 180 deg) is chosen; 180 deg at 26 kPa is the finite element result, which the abstract calls experimental";
const FRAME: &str = "the text puts x along the finger; Eq. 8 puts z along it and x sideways, as here";
const INEXTENSIBLE: &str = "the axis keeps its length: Eq. 12 lets it grow by e θ; e is not printed";

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        actuator: BENDING_LINEAR.0,
        quantity: BENDING_LINEAR.1,
        quantity_si_unit: "rad",
        components: &[],
        form: BENDING_LINEAR.2,
        kind: FormKind::Assumed,
        title: "linear through 180 deg at 26 kPa",
        equation: "θ = p θ_full / p_full",
        source: "assumed; wave-finger, sections 2.2.3 (\"linearly\") and 4.2 (\"linear trend\"), and section 3.3 (180 deg at 26 kPa)",
        range: "0 to 26 kPa, 0 to 180 deg; beyond, and below zero, the line is extrapolated",
        misprints: &[LINE],
        chambers: &["chamber"],
        parameters: &[FULL_PRESSURE, FULL_ANGLE],
        conditions: &[],
        checks: &[
            Check {
                statement: "26 kPa: exactly the far point of the line",
                expected: 180.0,
                tolerance: 0.0,
                unit: "deg",
                compute: || Ok(component(&evaluate(BENDING_LINEAR, &[], &[26e3])?, 0)?.to_degrees()),
            },
            Check {
                statement: "13 kPa: half of it",
                expected: 90.0,
                tolerance: 1e-13,
                unit: "deg",
                compute: || Ok(component(&evaluate(BENDING_LINEAR, &[], &[13e3])?, 0)?.to_degrees()),
            },
        ],
        stated: stated_inputs,
        builder: |i| {
            let law = line(i)?;
            Ok(Model::explicit(move |p| Ok(vec![law.bending_angle_rad(p)?])))
        },
    },
    Entry {
        actuator: TIP_LINEAR.0,
        quantity: TIP_LINEAR.1,
        quantity_si_unit: "m",
        components: &["x", "z"],
        form: TIP_LINEAR.2,
        kind: FormKind::Assumed,
        title: "constant curvature, linear angle",
        equation: "x = (1 - cos kl)/k, z = sin(kl)/k, kl = p θ_full / p_full",
        source: "wave-finger, Eq. 5 to 8; the angle assumed, sections 2.2.3 (\"linearly\") and 4.2 (\"linear trend\")",
        range: "0 to 26 kPa; free tip, no gravity; beyond, and below zero, the line is extrapolated",
        misprints: &[LINE, FRAME, INEXTENSIBLE],
        chambers: &["chamber"],
        parameters: &[LENGTH, FULL_PRESSURE, FULL_ANGLE],
        conditions: &[],
        checks: &[
            Check {
                statement: "x at 26 kPa, 180 deg, l0 115 mm",
                expected: 73.211_273_8,
                tolerance: 5e-8,
                unit: "mm",
                compute: || millimetres(TIP_LINEAR, &[], 26e3, 0),
            },
            Check {
                statement: "z at 26 kPa, 180 deg, l0 115 mm",
                expected: 0.0,
                tolerance: 1e-12,
                unit: "mm",
                compute: || millimetres(TIP_LINEAR, &[], 26e3, 1),
            },
            Check {
                statement: "z at 13 kPa, 90 deg, l0 115 mm (there x = z)",
                expected: 73.211_273_8,
                tolerance: 5e-8,
                unit: "mm",
                compute: || millimetres(TIP_LINEAR, &[], 13e3, 1),
            },
        ],
        stated: stated_inputs,
        builder: |i| {
            let (law, length_m) = (line(i)?, i.require(LENGTH)?);
            Bent::new(0.0, length_m)?;
            Ok(Model::explicit(move |p| Ok(Bent::new(law.bending_angle_rad(p)?, length_m)?.tip_position_m().to_vec())))
        },
    },
    Entry {
        actuator: TIP_MEASURED.0,
        quantity: TIP_MEASURED.1,
        quantity_si_unit: "m",
        components: &["x", "z"],
        form: TIP_MEASURED.2,
        kind: FormKind::Printed,
        title: "constant curvature, measured angle",
        equation: "x = (1 - cos kl)/k, z = sin(kl)/k, kl the measured bending angle",
        source: "wave-finger, Eq. 5 to 8",
        range: "free tip, no gravity, an axis that keeps its length; any angle, in the paper 0 to 168 deg; does not depend on the pressure",
        misprints: &[
            "Eq. 8 holds as printed; Table 2, from which it is built, prints d2 = 2 sin(kl/2)/2 for 2 sin(kl/2)/k",
            FRAME,
        ],
        chambers: &["chamber"],
        parameters: &[LENGTH],
        conditions: &[ANGLE],
        checks: &[
            Check {
                statement: "x at 180 deg, l0 115 mm",
                expected: 73.211_273_8,
                tolerance: 5e-8,
                unit: "mm",
                compute: || millimetres(TIP_MEASURED, &[(ANGLE, PI)], 26e3, 0),
            },
            Check {
                statement: "z at 180 deg, l0 115 mm",
                expected: 0.0,
                tolerance: 1e-12,
                unit: "mm",
                compute: || millimetres(TIP_MEASURED, &[(ANGLE, PI)], 26e3, 1),
            },
            Check {
                statement: "x at 168 deg, l0 115 mm",
                expected: 77.583_592_3,
                tolerance: 5e-8,
                unit: "mm",
                compute: || millimetres(TIP_MEASURED, &[], 26e3, 0),
            },
            Check {
                statement: "z at 168 deg, l0 115 mm",
                expected: 8.154_364_1,
                tolerance: 5e-8,
                unit: "mm",
                compute: || millimetres(TIP_MEASURED, &[], 26e3, 1),
            },
        ],
        stated: stated_inputs,
        builder: |i| {
            let tip = Bent::new(i.require(ANGLE)?, i.require(LENGTH)?)?.tip_position_m();
            Ok(Model::explicit(move |_| Ok(tip.to_vec())))
        },
    },
];

pub(super) const UNEVALUABLE: &[Unevaluable] = &[
    Unevaluable {
        actuator: "wave-finger",
        equations: "Eq. 1 to 4 (bending stiffness)",
        why: &[
            "Eq. 1 prints l/r = |M|/(EI): a pure number on the left, one over a length on the right; the left must be 1/r",
            "neither M nor E nor I is given a number",
        ],
        source: "wave-finger, section 2.1.2",
    },
    Unevaluable {
        actuator: "wave-finger",
        equations: "Eq. 11 to 21 (pressure from bending angle)",
        why: &[
            "B, H, r, e1 and e2 are given no number, and none can be taken from the dimensions that are printed",
            "Eq. 17 and 18 add squared lengths to lengths and to pure numbers",
            "the energy in Eq. 19 to 21 is that of Eq. 9, which squares both terms, (I1-3)²: Yeoh's first is linear",
            "Eq. 19 and 20 add the work of the pressure to the energy stored and set the sum to zero: both rise with bending, so the pressure would be negative",
        ],
        source: "wave-finger, sections 2.2.2 and 2.2.3",
    },
];

fn line(i: &Inputs) -> Result<LinearAngle, ModelError> {
    LinearAngle::new(i.require(FULL_PRESSURE)?, i.require(FULL_ANGLE)?)
}

fn millimetres(
    form: (&str, &str, &str),
    changed: &[(Parameter, f64)],
    pressure_gauge_pa: f64,
    index: usize,
) -> Result<f64, ModelError> {
    Ok(component(&evaluate(form, changed, &[pressure_gauge_pa])?, index)? * 1e3)
}

/// Table 1, the assumed line, and the largest measured angle.
fn stated_inputs() -> Inputs {
    [(FULL_PRESSURE.name, 26e3), (FULL_ANGLE.name, PI), (LENGTH.name, 115e-3), (ANGLE.name, 168_f64.to_radians())]
        .into_iter()
        .collect()
}
