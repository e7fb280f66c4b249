//! The forms of the expanding wall: displacement of a strip in two readings of the material, and the contact force.

use super::{Check, Entry, FormKind, Inputs, Model, Parameter, component, evaluate};
use crate::ModelError;
use crate::actuators::pdms_wall::{Constants, Strip, contact_force_n};
use crate::solve::Curve;

const CHORD: Parameter =
    Parameter { name: "chord", si_unit: "m", meaning: "h, chamber height: width of the wall between its clamps" };
const MU1: Parameter = Parameter { name: "mu1", si_unit: "Pa", meaning: "μ1, first Mooney-Rivlin constant of Eq. 1" };
const MU2: Parameter = Parameter { name: "mu2", si_unit: "Pa", meaning: "μ2, second Mooney-Rivlin constant of Eq. 1" };
const WALL: Parameter =
    Parameter { name: "wall_thickness", si_unit: "m", meaning: "t_d, thickness of the expanding wall at rest" };
const CONTACT_PRESSURE: Parameter =
    Parameter { name: "contact_pressure", si_unit: "Pa", meaning: "P_c, contact pressure (from COMSOL in the paper)" };
const CONTACT_AREA: Parameter =
    Parameter { name: "contact_area", si_unit: "m2", meaning: "A_c, contact area (imprint of paint)" };

const AS_PRINTED: &str = "strip-as-printed";
const MU_IS_MODULUS: &str = "strip-mu-is-modulus";
const NOT_THE_PAPERS: &str =
    "not the paper's model, which is a COMSOL simulation: a long flat strip, clamped and without bending stiffness";

/// What the strip's readings share.
const STRIP: Entry = Entry {
    actuator: "pdms-wall",
    quantity: "wall-displacement",
    quantity_si_unit: "m",
    components: &[],
    form: AS_PRINTED,
    kind: FormKind::Consistent,
    title: "strip, Eq. 1 as printed",
    equation: "p = t_d h c 2(l - l⁻³)(dl/dt)/(dA/dt), l = t/sin t, c = (μ1 + μ2)/2;  δ = (h/2) tan(t/2)",
    source: "ours; material: pdms-wall, section 2.3 and Eq. 1",
    range: "0 <= t <= 3 rad; plane strain, membrane, no contact; past t = π/2 the arc overhangs its clamps",
    misprints: &[
        NOT_THE_PAPERS,
        "with W = μ1/2 (I1-3) + μ2/2 (I2-3) and μ = 2(μ1 + μ2) the law's initial shear modulus is μ/2, not μ",
    ],
    chambers: &["chamber"],
    parameters: &[CHORD, MU1, MU2],
    conditions: &[WALL],
    checks: &[],
    stated: stated_inputs,
    builder: |i| Model::single(strip(i, Constants::AsPrinted)?),
};

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        checks: &[
            Check {
                statement: "p(t = 0.6), t_d 2 mm, c 0.16675 MPa",
                expected: 8.631_811_18e-3,
                tolerance: 5e-12,
                unit: "MPa",
                compute: || Ok(strip(&stated_inputs(), Constants::AsPrinted)?.pressure_gauge_pa(0.6) * 1e-6),
            },
            displacement_check("34.47 kPa, t_d 1.5 mm", 6.456_938, 5e-7, || displacement_mm(AS_PRINTED, 1.5e-3)),
            displacement_check("34.47 kPa, t_d 2 mm", 5.559_623, 5e-7, || displacement_mm(AS_PRINTED, 2e-3)),
            displacement_check("34.47 kPa, t_d 2.5 mm", 4.999_073, 5e-7, || displacement_mm(AS_PRINTED, 2.5e-3)),
        ],
        ..STRIP
    },
    Entry {
        form: MU_IS_MODULUS,
        kind: FormKind::Reading,
        title: "strip, μ the modulus",
        equation: "as strip-as-printed with c = μ1 + μ2",
        misprints: &[
            NOT_THE_PAPERS,
            "departs from print: W = μ1 (I1-3) + μ2 (I2-3), whose initial shear modulus 2(μ1 + μ2) is the paper's μ",
        ],
        checks: &[
            displacement_check("34.47 kPa, t_d 1.5 mm", 4.60, 5e-3, || displacement_mm(MU_IS_MODULUS, 1.5e-3)),
            displacement_check("34.47 kPa, t_d 2 mm", 4.07, 5e-3, || displacement_mm(MU_IS_MODULUS, 2e-3)),
            displacement_check("34.47 kPa, t_d 2.5 mm", 3.72, 5e-3, || displacement_mm(MU_IS_MODULUS, 2.5e-3)),
        ],
        builder: |i| Model::single(strip(i, Constants::MuIsModulus)?),
        ..STRIP
    },
    Entry {
        actuator: "pdms-wall",
        quantity: "contact-force",
        quantity_si_unit: "N",
        components: &[],
        form: "printed",
        kind: FormKind::Printed,
        title: "P_c A_c",
        equation: "F_c = P_c A_c",
        source: "pdms-wall, Eq. 3",
        range: "P_c comes from COMSOL at 34.47 kPa in the chamber: the form itself does not depend on the chamber's pressure",
        misprints: &[],
        chambers: &["chamber"],
        parameters: &[],
        conditions: &[CONTACT_PRESSURE, CONTACT_AREA],
        checks: &[
            // Half a unit of the last digit of the force, plus what half a unit of pressure and of area do to the product.
            force_check("Table 2, 37 kPa on 424.4 mm² (tolerance: last digits of all three)", 15.7, 0.264, || {
                force_n(37e3, 424.4e-6)
            }),
            force_check("Table 2, 36.8 kPa on 498.5 mm² (tolerance: last digits of all three)", 18.4, 0.0768, || {
                force_n(36.8e3, 498.5e-6)
            }),
            force_check("Table 2, 35.5 kPa on 542.3 mm² (tolerance: last digits of all three)", 19.3, 0.0789, || {
                force_n(35.5e3, 542.3e-6)
            }),
            force_check("36.8 kPa on 498.5 mm², in full", 18.344_8, 1e-12, || force_n(36.8e3, 498.5e-6)),
        ],
        stated: stated_inputs,
        builder: |i| {
            let force = contact_force_n(i.require(CONTACT_PRESSURE)?, i.require(CONTACT_AREA)?)?;
            Ok(Model::explicit(move |_| Ok(vec![force])))
        },
    },
];

const fn displacement_check(
    statement: &'static str,
    expected: f64,
    tolerance: f64,
    compute: fn() -> Result<f64, ModelError>,
) -> Check {
    Check { statement, expected, tolerance, unit: "mm", compute }
}

const fn force_check(
    statement: &'static str,
    expected: f64,
    tolerance: f64,
    compute: fn() -> Result<f64, ModelError>,
) -> Check {
    Check { statement, expected, tolerance, unit: "N", compute }
}

fn strip(i: &Inputs, constants: Constants) -> Result<Strip, ModelError> {
    Strip::new(i.require(CHORD)?, i.require(WALL)?, i.require(MU1)?, i.require(MU2)?, constants)
}

fn displacement_mm(form: &str, wall_thickness_m: f64) -> Result<f64, ModelError> {
    let values = evaluate(("pdms-wall", "wall-displacement", form), &[(WALL, wall_thickness_m)], &[34.47e3])?;
    Ok(component(&values, 0)? * 1e3)
}

fn force_n(contact_pressure_pa: f64, contact_area_m2: f64) -> Result<f64, ModelError> {
    let changed = [(CONTACT_PRESSURE, contact_pressure_pa), (CONTACT_AREA, contact_area_m2)];
    component(&evaluate(("pdms-wall", "contact-force", "printed"), &changed, &[34.47e3])?, 0)
}

/// The wall of 2 mm of section 4: h = 20 mm, μ = 6.67e5 Pa, and its row of Table 2.
fn stated_inputs() -> Inputs {
    [
        (CHORD.name, 20e-3),
        (MU1.name, 6.67e5 * 7.0 / 16.0),
        (MU2.name, 6.67e5 / 16.0),
        (WALL.name, 2e-3),
        (CONTACT_PRESSURE.name, 36.8e3),
        (CONTACT_AREA.name, 498.5e-6),
    ]
    .into_iter()
    .collect()
}
