//! The forms of the internal-support gripper.

use super::{Check, Entry, FormKind, Inputs, Model, Parameter};
use crate::ModelError;
use crate::actuators::internal_support::{Consistent, Geometry, Printed};
use crate::materials::Yeoh;
use crate::solve::Curve;

const OUTER_DIAMETER: Parameter =
    Parameter { name: "outer_diameter", si_unit: "m", meaning: "D, outer diameter at rest" };
const CHAMBER_DIAMETER: Parameter =
    Parameter { name: "chamber_diameter", si_unit: "m", meaning: "d2, air chamber diameter" };
const CHAMBER_HEIGHT: Parameter = Parameter { name: "chamber_height", si_unit: "m", meaning: "h2, air chamber height" };
const C10: Parameter = Parameter { name: "C10", si_unit: "Pa", meaning: "C10, first Yeoh constant" };
const C20: Parameter = Parameter { name: "C20", si_unit: "Pa", meaning: "C20, second Yeoh constant" };
const PARAMETERS: &[Parameter] = &[OUTER_DIAMETER, CHAMBER_DIAMETER, CHAMBER_HEIGHT, C10, C20];

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        actuator: "internal-support",
        quantity: "outer-diameter",
        quantity_si_unit: "m",
        components: &[],
        form: "printed",
        kind: FormKind::Printed,
        title: "printed",
        equation: "p(θ) = 3cos³(θ/2) π(r1²-r2²) h dW/dθ / (6π r1² cos(θ/2) + 4r1³ + 12θ tan(θ/2) r1³);  L(θ) = 2r1(1 + 1/cos(θ/2))",
        source: "internal-support, section Theoretical Model for Actuator Expansion, p(θ) and L(θ) (not numbered)",
        range: "0 <= θ <= 3 rad; no positive pressure has a solution",
        misprints: &[
            "sign: r1² - r2² makes every pressure negative",
            "units: 6π r1² stands beside 4 r1³; the derivative of the printed volume has 3π r1³ and 6θ tan(θ/2) r1³",
            "L(0) = 4 r1 = 56 mm, where the actuator measures 30 mm",
            "the hoop stretch is left out although the diameter grows by 38 %",
        ],
        chambers: &["chamber"],
        parameters: PARAMETERS,
        conditions: &[],
        checks: &[
            Check {
                statement: "p(θ = 0.5) as printed, C10 0.05, C20 0.005 MPa",
                expected: -1.059_969_8e-3,
                tolerance: 5e-11,
                unit: "MPa",
                compute: || Ok(stated_printed()?.pressure_gauge_pa(0.5) * 1e-6),
            },
            Check {
                statement: "p(θ = 0.5) from the derivative of the printed volume, r2² - r1²",
                expected: 5.214_189_3e-4,
                tolerance: 5e-12,
                unit: "MPa",
                compute: || Ok(stated_printed()?.pressure_from_printed_volume_pa(0.5) * 1e-6),
            },
            Check {
                statement: "L(θ = 0)",
                expected: 56.0,
                tolerance: 1e-12,
                unit: "mm",
                compute: || Ok(stated_printed()?.quantity(0.0) * 1e3),
            },
        ],
        stated: stated_inputs,
        builder: |inputs| Model::single(Printed::new(geometry(inputs)?, law(inputs)?)),
    },
    Entry {
        actuator: "internal-support",
        quantity: "outer-diameter",
        quantity_si_unit: "m",
        components: &[],
        form: "consistent",
        kind: FormKind::Consistent,
        title: "consistent",
        equation: "p(t) = (dU/dt)/(dV/dt) of a wall of revolution, meridian = arc of half-angle t over h;  L(t) = D + h tan(t/2)",
        source: "re-derived from internal-support, section Theoretical Model for Actuator Expansion",
        range: "0 <= t <= 2.2 rad; membrane wall, rigid end plates; L overstated by d1 (1 - λ_r), 0.34 mm at L = 40.9 mm; past t = π/2 the arc overhangs the end plates",
        misprints: &["departs from print: energy and volume of one shape, hoop stretch kept, L(0) = D"],
        chambers: &["chamber"],
        parameters: PARAMETERS,
        conditions: &[],
        checks: &[
            length_check("L(t = 0.1)", 31.401_168, || soft()?.quantity_mm(0.1)),
            pressure_check("p(t = 0.1), C10 0.05, C20 0.005 MPa", 1.067_962_04e-3, 5e-12, || soft()?.pressure_mpa(0.1)),
            length_check("L(t = 0.5)", 37.149_574, || soft()?.quantity_mm(0.5)),
            pressure_check("p(t = 0.5), C10 0.05, C20 0.005 MPa", 4.993_250_10e-3, 5e-12, || soft()?.pressure_mpa(0.5)),
            length_check("L(t = 0.9)", 43.525_542, || soft()?.quantity_mm(0.9)),
            pressure_check("p(t = 0.9), C10 0.05, C20 0.005 MPa", 8.769_806_97e-3, 5e-12, || soft()?.pressure_mpa(0.9)),
            pressure_check("p(t = 0.5), C10 0.342, C20 0.104 MPa", 3.650_755_29e-2, 5e-11, || {
                stiff()?.pressure_mpa(0.5)
            }),
            pressure_check("p(t = 0.9), C10 0.342, C20 0.104 MPa", 7.330_150_77e-2, 5e-11, || {
                stiff()?.pressure_mpa(0.9)
            }),
            Check {
                statement: "L at 10 kPa, C10 0.05, C20 0.005 MPa (the paper prints 31.86 to 33.44 mm)",
                expected: 45.88,
                tolerance: 5e-3,
                unit: "mm",
                compute: || Ok(Model::single(soft()?.0)?.predict_scalar(&[10e3])? * 1e3),
            },
        ],
        stated: stated_inputs,
        builder: |inputs| Model::single(Consistent::new(geometry(inputs)?, law(inputs)?)),
    },
];

const fn length_check(statement: &'static str, expected: f64, compute: fn() -> Result<f64, ModelError>) -> Check {
    Check { statement, expected, tolerance: 5e-7, unit: "mm", compute }
}

const fn pressure_check(
    statement: &'static str,
    expected: f64,
    tolerance: f64,
    compute: fn() -> Result<f64, ModelError>,
) -> Check {
    Check { statement, expected, tolerance, unit: "MPa", compute }
}

fn geometry(inputs: &Inputs) -> Result<Geometry, ModelError> {
    Geometry::new(inputs.require(OUTER_DIAMETER)?, inputs.require(CHAMBER_DIAMETER)?, inputs.require(CHAMBER_HEIGHT)?)
}

fn law(inputs: &Inputs) -> Result<Yeoh, ModelError> {
    Yeoh::new(inputs.require(C10)?, inputs.require(C20)?, 0.0)
}

/// The paper's dimensions, in mm.
fn printed_geometry() -> Result<Geometry, ModelError> {
    Geometry::new(30e-3, 28e-3, 28e-3)
}

fn stated_printed() -> Result<Printed, ModelError> {
    Ok(Printed::new(printed_geometry()?, Yeoh::new(0.05e6, 0.005e6, 0.0)?))
}

/// The consistent form in the units of its check values.
struct InPaperUnits(Consistent);

impl InPaperUnits {
    // `Result` so that a check reads as one chain.
    #[allow(clippy::unnecessary_wraps)]
    fn pressure_mpa(&self, t: f64) -> Result<f64, ModelError> {
        Ok(self.0.pressure_gauge_pa(t) * 1e-6)
    }

    #[allow(clippy::unnecessary_wraps)]
    fn quantity_mm(&self, t: f64) -> Result<f64, ModelError> {
        Ok(self.0.quantity(t) * 1e3)
    }
}

fn soft() -> Result<InPaperUnits, ModelError> {
    Ok(InPaperUnits(Consistent::new(printed_geometry()?, Yeoh::new(0.05e6, 0.005e6, 0.0)?)))
}

fn stiff() -> Result<InPaperUnits, ModelError> {
    Ok(InPaperUnits(Consistent::new(printed_geometry()?, Yeoh::new(0.342e6, 0.104e6, 0.0)?)))
}

fn stated_inputs() -> Inputs {
    [
        (OUTER_DIAMETER.name, 30e-3),
        (CHAMBER_DIAMETER.name, 28e-3),
        (CHAMBER_HEIGHT.name, 28e-3),
        (C10.name, 0.05e6),
        (C20.name, 0.005e6),
    ]
    .into_iter()
    .collect()
}
