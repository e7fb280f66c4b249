//! The forms of any actuator that bends with constant curvature: laws that nobody printed, for a user's own.

use super::{Check, Entry, FormKind, Inputs, Model, Parameter, component, evaluate};
use crate::ModelError;
use crate::actuators::constant_curvature::{Bender, Bending};
use crate::domain::finite;
use crate::kinematics::constant_curvature::{bending_angle_from_polar_rad, polar_angle_rad};

const REST_LENGTH: Parameter =
    Parameter { name: "rest_length", si_unit: "m", meaning: "l0, length of the axis at rest" };
const ELONGATION: Parameter = Parameter {
    name: "elongation",
    si_unit: "m/Pa",
    meaning: "e, growth of the axis per gauge pressure; 0 if it does not stretch",
};
const CURVATURE: Parameter =
    Parameter { name: "curvature_per_pressure", si_unit: "1/(m Pa)", meaning: "k1, curvature per gauge pressure" };
const ANGLE: Parameter =
    Parameter { name: "angle_per_pressure", si_unit: "rad/Pa", meaning: "a, bending angle per gauge pressure" };
const BENDING_ANGLE: Parameter =
    Parameter { name: "bending_angle", si_unit: "rad", meaning: "θ, measured rotation of the tip" };
const POLAR_ANGLE: Parameter =
    Parameter { name: "polar_angle", si_unit: "rad", meaning: "θ/2, measured angle of the tip seen from the base" };

const ACTUATOR: &str = "constant-curvature";
const LINEAR_CURVATURE: &str = "linear-curvature";
const LINEAR_ANGLE: &str = "linear-angle";
const FROM_ANGLE: &str = "from-angle";
const FROM_POLAR: &str = "from-polar-angle";
const CURVATURE_INPUTS: &[Parameter] = &[REST_LENGTH, ELONGATION, CURVATURE];
const ANGLE_INPUTS: &[Parameter] = &[REST_LENGTH, ELONGATION, ANGLE];
const AXIS_INPUTS: &[Parameter] = &[REST_LENGTH, ELONGATION];

const CHOSEN: &str = "chosen, not printed: the smallest law with physical meaning; curvature or angle is proportional to pressure, and so is the growth of the length";
const GEOMETRY_ONLY: &str =
    "no law of pressure and angle: constant curvature and elongation only, the angle is measured";

/// What the forms share.
const FORM: Entry = Entry {
    actuator: ACTUATOR,
    quantity: "bending-angle",
    quantity_si_unit: "rad",
    components: &[],
    form: LINEAR_CURVATURE,
    kind: FormKind::Assumed,
    title: "curvature linear in pressure",
    equation: "θ = k1 p l, l = l0 + e p",
    source: "assumed; geometry: wave-finger, Eq. 5 to 8",
    range: "free tip, no gravity; pressure of either sign as long as l > 0",
    misprints: &[CHOSEN],
    chambers: &["chamber"],
    parameters: CURVATURE_INPUTS,
    conditions: &[],
    checks: &[],
    stated: stated_inputs,
    builder: |_| Err(ModelError::MissingParameter { name: "form", meaning: "a form of this catalogue" }),
};

const POLAR: Entry = Entry {
    quantity: "polar-angle",
    equation: "θ/2, θ = k1 p l, l = l0 + e p: what atan2(x, z) of the tip gives",
    range: "free tip, no gravity; -2π < θ < 2π, and l > 0",
    ..FORM
};

const POSITION: Entry = Entry {
    quantity: "tip-position",
    quantity_si_unit: "m",
    components: &["x", "z"],
    equation: "x = l (1 - cos θ)/θ, z = l sin θ/θ, θ = k1 p l, l = l0 + e p;  x sideways, z along the axis at rest",
    ..FORM
};

const DISPLACEMENT: Entry = Entry {
    quantity: "tip-displacement",
    components: &["along", "sideways"],
    equation: "along = z - l0, sideways = x of the tip position",
    ..POSITION
};

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        checks: &[check("θ at 50 kPa: 15/m on 105 mm", 1.575, 1e-14, "rad", || {
            at("bending-angle", LINEAR_CURVATURE, 0)
        })],
        builder: |i| {
            let bender = bender(i, curvature(i)?)?;
            Ok(Model::explicit(move |p| Ok(vec![bender.at(p)?.bending_angle_rad])))
        },
        ..FORM
    },
    Entry {
        form: LINEAR_ANGLE,
        title: "angle linear in pressure",
        equation: "θ = a p",
        range: "pressure of either sign",
        parameters: &[ANGLE],
        checks: &[check("θ at 50 kPa", 1.0, 1e-15, "rad", || at("bending-angle", LINEAR_ANGLE, 0))],
        builder: |i| {
            let per_pressure = finite(ANGLE.name, i.require(ANGLE)?)?;
            Ok(Model::explicit(move |p| Ok(vec![per_pressure * p])))
        },
        ..FORM
    },
    Entry {
        checks: &[check("θ/2 at 50 kPa", 0.787_5, 1e-14, "rad", || at("polar-angle", LINEAR_CURVATURE, 0))],
        builder: |i| {
            let bender = bender(i, curvature(i)?)?;
            Ok(Model::explicit(move |p| Ok(vec![polar_angle_rad(bender.at(p)?.bending_angle_rad)?])))
        },
        ..POLAR
    },
    Entry {
        form: LINEAR_ANGLE,
        title: "angle linear in pressure",
        equation: "θ/2, θ = a p: what atan2(x, z) of the tip gives",
        range: "-2π < θ < 2π",
        parameters: &[ANGLE],
        checks: &[check("θ/2 at 50 kPa", 0.5, 1e-15, "rad", || at("polar-angle", LINEAR_ANGLE, 0))],
        builder: |i| {
            let per_pressure = finite(ANGLE.name, i.require(ANGLE)?)?;
            Ok(Model::explicit(move |p| Ok(vec![polar_angle_rad(per_pressure * p)?])))
        },
        ..POLAR
    },
    Entry {
        checks: &[
            check("x at 50 kPa", 66.946_910_72, 5e-9, "mm", || at("tip-position", LINEAR_CURVATURE, 0)),
            check("z at 50 kPa", 66.666_077_64, 5e-9, "mm", || at("tip-position", LINEAR_CURVATURE, 1)),
        ],
        builder: |i| position(bender(i, curvature(i)?)?),
        ..POSITION
    },
    Entry {
        form: LINEAR_ANGLE,
        title: "angle linear in pressure",
        equation: "x = l (1 - cos θ)/θ, z = l sin θ/θ, θ = a p, l = l0 + e p;  x sideways, z along the axis at rest",
        parameters: ANGLE_INPUTS,
        checks: &[
            check("x at 50 kPa", 48.268_257_88, 5e-9, "mm", || at("tip-position", LINEAR_ANGLE, 0)),
            check("z at 50 kPa", 88.354_453_40, 5e-9, "mm", || at("tip-position", LINEAR_ANGLE, 1)),
        ],
        builder: |i| position(bender(i, Bending::Angle(i.require(ANGLE)?))?),
        ..POSITION
    },
    Entry {
        form: FROM_ANGLE,
        title: "from the measured angle",
        equation: "x = l (1 - cos θ)/θ, z = l sin θ/θ, θ measured, l = l0 + e p;  x sideways, z along the axis at rest",
        misprints: &[GEOMETRY_ONLY],
        parameters: AXIS_INPUTS,
        conditions: &[BENDING_ANGLE],
        checks: &[
            check("x at 50 kPa, 1 rad", 48.268_257_88, 5e-9, "mm", || at("tip-position", FROM_ANGLE, 0)),
            check("z at 50 kPa, 1 rad", 88.354_453_40, 5e-9, "mm", || at("tip-position", FROM_ANGLE, 1)),
        ],
        builder: |i| position(bender(i, Bending::Held(i.require(BENDING_ANGLE)?))?),
        ..POSITION
    },
    Entry {
        checks: &[
            check("along at 50 kPa", -33.333_922_36, 5e-9, "mm", || at("tip-displacement", LINEAR_CURVATURE, 0)),
            check("sideways at 50 kPa", 66.946_910_72, 5e-9, "mm", || at("tip-displacement", LINEAR_CURVATURE, 1)),
        ],
        builder: |i| displacement(bender(i, curvature(i)?)?),
        ..DISPLACEMENT
    },
    Entry {
        form: LINEAR_ANGLE,
        title: "angle linear in pressure",
        parameters: ANGLE_INPUTS,
        checks: &[
            check("along at 50 kPa", -11.645_546_60, 5e-9, "mm", || at("tip-displacement", LINEAR_ANGLE, 0)),
            check("sideways at 50 kPa", 48.268_257_88, 5e-9, "mm", || at("tip-displacement", LINEAR_ANGLE, 1)),
        ],
        builder: |i| displacement(bender(i, Bending::Angle(i.require(ANGLE)?))?),
        ..DISPLACEMENT
    },
    Entry {
        form: FROM_ANGLE,
        title: "from the measured angle",
        misprints: &[GEOMETRY_ONLY],
        parameters: AXIS_INPUTS,
        conditions: &[BENDING_ANGLE],
        checks: &[
            check("along at 50 kPa, 1 rad", -11.645_546_60, 5e-9, "mm", || at("tip-displacement", FROM_ANGLE, 0)),
            check("sideways at 50 kPa, 1 rad", 48.268_257_88, 5e-9, "mm", || at("tip-displacement", FROM_ANGLE, 1)),
        ],
        builder: |i| displacement(bender(i, Bending::Held(i.require(BENDING_ANGLE)?))?),
        ..DISPLACEMENT
    },
    Entry {
        form: FROM_POLAR,
        title: "from the measured polar angle",
        equation: "along = z - l0, sideways = x of the tip position at θ = 2 × polar angle",
        range: "free tip, no gravity; -π < polar angle < π, and l > 0",
        misprints: &[GEOMETRY_ONLY],
        parameters: AXIS_INPUTS,
        conditions: &[POLAR_ANGLE],
        checks: &[
            check("along at 50 kPa, 0.5 rad", -11.645_546_60, 5e-9, "mm", || at("tip-displacement", FROM_POLAR, 0)),
            check("sideways at 50 kPa, 0.5 rad", 48.268_257_88, 5e-9, "mm", || at("tip-displacement", FROM_POLAR, 1)),
        ],
        builder: |i| displacement(bender(i, Bending::Held(bending_angle_from_polar_rad(i.require(POLAR_ANGLE)?)?))?),
        ..DISPLACEMENT
    },
];

const fn check(
    statement: &'static str,
    expected: f64,
    tolerance: f64,
    unit: &'static str,
    compute: fn() -> Result<f64, ModelError>,
) -> Check {
    Check { statement, expected, tolerance, unit, compute }
}

fn curvature(i: &Inputs) -> Result<Bending, ModelError> {
    Ok(Bending::Curvature(i.require(CURVATURE)?))
}

fn bender(i: &Inputs, bending: Bending) -> Result<Bender, ModelError> {
    Bender::new(i.require(REST_LENGTH)?, i.require(ELONGATION)?, bending)
}

// `Result` so that a builder reads as one chain.
#[allow(clippy::unnecessary_wraps)]
fn position(bender: Bender) -> Result<Model, ModelError> {
    Ok(Model::explicit(move |p| Ok(bender.at(p)?.tip_position_m().to_vec())))
}

#[allow(clippy::unnecessary_wraps)]
fn displacement(bender: Bender) -> Result<Model, ModelError> {
    Ok(Model::explicit(move |p| Ok(bender.tip_displacement_m(p)?.to_vec())))
}

/// One component at 50 kPa and the stated inputs: an angle in rad, a length in mm.
fn at(quantity: &str, form: &str, index: usize) -> Result<f64, ModelError> {
    let value = component(&evaluate((ACTUATOR, quantity, form), &[], &[50e3])?, index)?;
    Ok(if quantity.ends_with("angle") { value } else { value * 1e3 })
}

/// An example, not a paper's: 100 mm that grow by 5 mm at 50 kPa.
fn stated_inputs() -> Inputs {
    [
        (REST_LENGTH.name, 0.1),
        (ELONGATION.name, 1e-7),
        (CURVATURE.name, 3e-4),
        (ANGLE.name, 2e-5),
        (BENDING_ANGLE.name, 1.0),
        (POLAR_ANGLE.name, 0.5),
    ]
    .into_iter()
    .collect()
}
