//! The five published types.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Inputs, Section, Sketch, arc, rectangle};
use crate::format;
use crate::report::scene::Tint;
use crate::results::ActuatorRecord;

/// The cross-section of a type that has one, if the dimensions it stands on are there.
pub(in crate::report::figures) fn section(record: &ActuatorRecord) -> Option<Section> {
    let inputs = Inputs(&record.inputs);
    match record.kind.as_str() {
        "internal-support" => internal_support(inputs),
        "wave-finger" => wave_finger(inputs),
        "fruit-finger" => fruit_finger(inputs),
        "dual-chamber-finger" => dual_chamber_finger(inputs),
        "pdms-wall" => pdms_wall(inputs),
        _ => None,
    }
}

/// A cylinder cut along its axis.
fn internal_support(inputs: Inputs) -> Option<Section> {
    let [outer, height, chamber, bore, side, end] =
        ["outer_diameter", "total_height", "chamber_height", "chamber_diameter", "side_wall", "end_wall"]
            .map(|name| inputs.length(name));
    let (outer, height, chamber, bore, side, end) = (outer?, height?, chamber?, bore?, side?, end?);
    let mut sketch = Sketch::new(outer.mm, height.mm);
    sketch.solid(&rectangle((0.0, 0.0), (outer.mm, height.mm)), &[&outer, &height]);
    let (left, right) = (0.5 * (outer.mm - bore.mm), 0.5 * (outer.mm + bore.mm));
    let closes = [end.mm, 2.0 * end.mm].into_iter().any(|ends| (ends + chamber.mm - height.mm).abs() < 0.5);
    let bottom = if closes { end.mm } else { 0.5 * (height.mm - chamber.mm) };
    let top = bottom + chamber.mm;
    let room = rectangle((left, bottom), (right, top));
    if closes {
        sketch.air(&room, &[&bore, &chamber]);
    } else {
        sketch.outline(&room, Some(Tint::Paper), true);
    }
    sketch.across((0.0, outer.mm), height.mm, 1.2, &outer.label);
    sketch.across((left, right), bottom + 0.5 * chamber.mm, -0.4, &bore.label);
    sketch.along((0.0, height.mm), 0.0, -1.2, &height.label);
    sketch.along((bottom, top), outer.mm, 1.2, &chamber.label);
    let side_at = (0.5 * (right + outer.mm), bottom + 0.8 * chamber.mm);
    sketch.pointer(side_at, (40.0, -34.0), &format!("wall {}", side.label));
    let position = if closes {
        String::new()
    } else {
        sketch.pointer((0.5 * outer.mm, bottom), (90.0, 36.0), "place not known");
        format!(
            " Where along the body the chamber lies is not known: end walls of {} do not close with {} and {}; it is drawn in the middle.",
            end.label, chamber.label, height.label
        )
    };
    let of = [
        ("outer diameter", &outer),
        ("height", &height),
        ("chamber height", &chamber),
        ("chamber diameter", &bore),
        ("side wall", &side),
    ];
    sketch.done(&format!("Cut along the axis, at rest.{position}"), &of)
}

/// A finger cut along: constraint layer below, chambers above.
fn wave_finger(inputs: Inputs) -> Option<Section> {
    let (length, constraint, wall) =
        (inputs.length("finger_length")?, inputs.length("constraint_thickness")?, inputs.length("wall")?);
    let chambers = inputs.number("chambers")?;
    // A height to draw it with; it is labelled as unknown.
    let height = 0.17 * length.mm;
    let mut sketch = Sketch::new(length.mm, height);
    sketch.solid(&rectangle((0.0, 0.0), (length.mm, constraint.mm)), &[&length, &constraint]);
    let n = shown(chambers)?;
    let pitch = length.mm / (f64::from(n) + 1.7);
    for i in 0..=n {
        let (from, to) = (f64::from(i) * pitch, (f64::from(i) + if i == n { 1.7 } else { 1.0 }) * pitch);
        // Side walls carry waves, of a profile that is not printed.
        let wave = |x: f64, y: f64| x + 0.08 * pitch * (4.0 * PI * y / height).sin();
        let levels = (0..=24).map(|k| constraint.mm + (height - constraint.mm) * f64::from(k) / 24.0);
        let up: Vec<(f64, f64)> = levels.clone().map(|y| (wave(from + 0.12 * pitch, y), y)).collect();
        let down = levels.rev().map(|y| (wave(to - 0.12 * pitch, y), y));
        sketch.unknown_line(&up.into_iter().chain(down).collect::<Vec<_>>());
    }
    sketch.across((0.0, length.mm), 0.0, -1.2, &length.label);
    sketch.along((0.0, constraint.mm), 0.0, -0.8, &constraint.label);
    sketch.along((constraint.mm, height), length.mm, 0.8, "not published");
    sketch.pointer((pitch, height), (30.0, -24.0), &format!("wall {}", wall.label));
    let caption = format!(
        "Cut along the finger, at rest: {n} chambers and a larger one at the end on a constraint layer. Pitch, wave profile, height and \
         width are not published; the chambers are drawn to show their order."
    );
    sketch.done(&caption, &[("length", &length), ("constraint layer", &constraint), ("wall", &wall)])
}

/// A finger cut along: constraint layer below, chambers above.
fn fruit_finger(inputs: Inputs) -> Option<Section> {
    let (gap, wall, constraint) =
        (inputs.length("chamber_gap")?, inputs.length("wall")?, inputs.length("constraint_thickness")?);
    let (radius, length, chambers) =
        (inputs.length("chamber_radius")?, inputs.length("finger_length")?, inputs.number("chambers")?);
    let height = constraint.mm + radius.mm + wall.mm;
    let mut sketch = Sketch::new(length.mm, height);
    let n = shown(chambers)?;
    // Walls and gaps that leave no room for a chamber are no finger.
    let room = (length.mm - 2.0 * wall.mm - (f64::from(n) - 1.0) * gap.mm) / f64::from(n);
    let pitch = Some(room).filter(|room| *room > 0.0)? + gap.mm;
    sketch.solid(&rectangle((0.0, 0.0), (length.mm, height)), &[&length, &constraint, &radius, &wall]);
    for i in 0..n {
        let from = wall.mm + f64::from(i) * pitch;
        let chamber = rectangle((from, constraint.mm), (from + room, constraint.mm + radius.mm));
        sketch.air(&chamber, &[&length, &radius, &wall, &gap]);
    }
    sketch.across((0.0, length.mm), 0.0, -1.2, &length.label);
    let gap_from = wall.mm + room;
    sketch.across((gap_from, gap_from + gap.mm), height, 0.9, &format!("gap {}", gap.label));
    sketch.along((0.0, constraint.mm), 0.0, -0.8, &constraint.label);
    let wall_at = (length.mm - 0.4 * wall.mm, height - 0.5 * wall.mm);
    sketch.pointer(wall_at, (34.0, -26.0), &format!("wall {}", wall.label));
    sketch.along((constraint.mm, constraint.mm + radius.mm), length.mm, 0.8, &radius.label);
    let caption = format!(
        "Cut along the finger, at rest: {n} chambers, whose length follows from that of the finger. Its width is not published."
    );
    let of = [
        ("wall", &wall),
        ("gap", &gap),
        ("constraint layer", &constraint),
        ("chamber radius", &radius),
        ("length", &length),
    ];
    sketch.done(&caption, &of)
}

/// A finger cut across a chamber.
fn dual_chamber_finger(inputs: Inputs) -> Option<Section> {
    let [width, height, inner_width, inner_height, straight] =
        ["width", "height", "chamber_width", "chamber_height", "chamber_straight_height"]
            .map(|name| inputs.length(name));
    let [outer, inner, base, sheet, sheet_width] =
        ["outer_radius", "chamber_radius", "constraint_thickness", "sheet_thickness", "sheet_width"]
            .map(|name| inputs.length(name));
    let (width, height, inner_width, inner_height, straight) =
        (width?, height?, inner_width?, inner_height?, straight?);
    let (outer, inner, base, sheet, sheet_width) = (outer?, inner?, base?, sheet?, sheet_width?);
    let mut sketch = Sketch::new(width.mm, height.mm);
    let middle = 0.5 * width.mm;
    let spring = base.mm + straight.mm;
    let mut body = vec![(0.0, 0.0), (width.mm, 0.0), (width.mm, spring)];
    body.extend(arc((middle, spring), outer.mm, (0.0, PI)));
    sketch.solid(&body, &[&width, &height, &straight, &outer, &base]);
    let (left, right) = (middle - 0.5 * inner_width.mm, middle + 0.5 * inner_width.mm);
    let mut chamber = vec![(left, base.mm), (right, base.mm)];
    chamber.extend(arc((middle, spring), inner.mm, (0.0, PI)));
    sketch.air(&chamber, &[&inner_width, &straight, &inner, &base]);
    let steel = rectangle(
        (middle - 0.5 * sheet_width.mm, 0.5 * (base.mm - sheet.mm)),
        (middle + 0.5 * sheet_width.mm, 0.5 * (base.mm + sheet.mm)),
    );
    sketch.outline(&steel, None, !(sheet.is_solid && sheet_width.is_solid));
    sketch.across((0.0, width.mm), 0.0, -1.2, &width.label);
    sketch.across_at((left, right), 0.25, base.mm, 0.8, &inner_width.label);
    sketch.along((0.0, height.mm), 0.0, -1.2, &height.label);
    sketch.along((base.mm, base.mm + inner_height.mm), middle, 0.0, &inner_height.label);
    sketch.along((0.0, base.mm), width.mm, 0.8, &base.label);
    let crown = |radius: f64, angle: f64| (middle + radius * angle.cos(), spring + radius * angle.sin());
    sketch.pointer(crown(outer.mm, 0.3 * PI), (46.0, -12.0), &format!("R {}", outer.label));
    sketch.pointer(crown(inner.mm, 0.15 * PI), (62.0, -6.0), &format!("r {}", inner.label));
    let steel_end = (middle + 0.5 * sheet_width.mm, 0.5 * base.mm);
    sketch.pointer(steel_end, (40.0, 34.0), &format!("steel {}", sheet.label));
    let of = [
        ("width", &width),
        ("height", &height),
        ("chamber width", &inner_width),
        ("chamber height", &inner_height),
        ("radii", if outer.is_solid { &inner } else { &outer }),
        ("constraint layer", &base),
        ("steel sheet's thickness", &sheet),
        ("steel sheet's width", &sheet_width),
    ];
    let caption = "Cut across a chamber of the root, at rest; the tip is the same without the sheet. Where in the constraint layer the \
                   steel sheet lies is not published: it is drawn in the middle.";
    sketch.done(caption, &of)
}

/// The ring cut across: one wall of three.
fn pdms_wall(inputs: Inputs) -> Option<Section> {
    let (chord, angle) =
        (inputs.length("chord")?, inputs.number("arc_angle").filter(|angle| (0.1..3.0).contains(angle))?);
    let walls: Vec<_> =
        ["wall_thin", "wall_medium", "wall_thick"].iter().filter_map(|name| inputs.length(name)).collect();
    let wall = walls.get(walls.len() / 2)?;
    let half = 0.5 * angle;
    // The inner wall, concave towards the middle of the ring, which lies below.
    let radius = 0.5 * chord.mm / half.sin();
    let depth = 0.3 * chord.mm;
    // A wall as thick as its chord is no wall.
    if wall.mm > 0.5 * chord.mm {
        return None;
    }
    let width = 2.0 * (radius + wall.mm + depth) * half.sin();
    let height = radius + wall.mm + depth - radius * half.cos();
    let mut sketch = Sketch::new(width, height);
    let middle = (0.5 * width, -radius * half.cos());
    let span = (FRAC_PI_2 + half, FRAC_PI_2 - half);
    let ring = |inner: f64, outer: f64| {
        let mut corners = arc(middle, inner, span);
        corners.extend(arc(middle, outer, (span.1, span.0)));
        corners
    };
    sketch.unknown(&ring(radius + wall.mm, radius + wall.mm + depth));
    sketch.solid(&ring(radius, radius + wall.mm), &[&chord, wall]);
    let end = 0.5 * (width - chord.mm);
    sketch.across((end, end + chord.mm), 0.0, -0.9, &format!("chord {}", chord.label));
    let degrees = format::short(angle.to_degrees());
    let on = |radius: f64, at: f64| (middle.0 + radius * at.cos(), middle.1 + radius * at.sin());
    let said: Vec<String> = walls.iter().map(|w| w.label.replace(" mm", "")).collect();
    let edge = FRAC_PI_2 - 0.8 * half;
    sketch.pointer(on(radius + 0.5 * wall.mm, edge), (70.0, 14.0), &format!("wall {} mm", said.join(", ")));
    sketch.pointer(on(radius + wall.mm + 0.6 * depth, edge), (62.0, -24.0), "not published");
    sketch.pointer(on(radius + wall.mm, FRAC_PI_2), (0.0, -26.0), &format!("arc {degrees}°"));
    let caption = format!(
        "Cut across the ring, at rest: one of three walls, {} thick here, which bulges downwards, towards the middle of the ring. The \
         chamber's depth, its outer wall and the ring are not published; that the arc stands on the chord is the strip model's reading.",
        wall.label
    );
    sketch.done(&caption, &[("chord", &chord), ("wall", wall)])
}

/// A number of chambers that can be drawn.
fn shown(chambers: f64) -> Option<u8> {
    // Between 1 and 40.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    (1.0..=40.0).contains(&chambers).then(|| chambers.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scene::{Element, Scene};
    use crate::results::InputRecord;

    fn record(kind: &str, inputs: &[(&str, f64, &str)]) -> ActuatorRecord {
        let input = |(name, mm, origin): &(&str, f64, &str)| InputRecord {
            name: (*name).to_owned(),
            value_si: 1e-3 * mm,
            std_si: None,
            unit: "mm".to_owned(),
            origin: (*origin).to_owned(),
            place: None,
        };
        ActuatorRecord {
            id: kind.to_owned(),
            kind: kind.to_owned(),
            title: String::new(),
            summary: String::new(),
            inputs: inputs.iter().map(input).collect(),
            materials: vec![],
            datasets: vec![],
        }
    }

    const CYLINDER: [(&str, f64, &str); 6] = [
        ("outer_diameter", 30.0, "published"),
        ("total_height", 63.0, "published"),
        ("chamber_height", 28.0, "published"),
        ("chamber_diameter", 28.0, "published"),
        ("side_wall", 1.0, "published"),
        ("end_wall", 30.0, "published"),
    ];

    fn said(scene: &Scene) -> Vec<&str> {
        scene
            .elements
            .iter()
            .filter_map(|e| if let Element::Words(words) = e { Some(words.text.as_str()) } else { None })
            .collect()
    }

    #[test]
    fn a_body_is_to_scale_and_what_does_not_close_is_said() {
        let section = section(&record("internal-support", &CYLINDER)).unwrap();
        let area = section
            .scene
            .elements
            .iter()
            .find_map(|e| if let Element::Area { corners, .. } = e { Some(corners) } else { None });
        let body = area.unwrap();
        let (width, height) = (body[1].0 - body[0].0, body[0].1 - body[2].1);
        assert!((height / width - 63.0 / 30.0).abs() < 1e-12, "{width} x {height}");
        assert!(section.caption.contains("do not close"), "{}", section.caption);
        assert!(said(&section.scene).contains(&"place not known"));
        // End walls that close with the chamber leave nothing open.
        let mut closed = CYLINDER;
        closed[5].1 = 17.5;
        let closed = super::section(&record("internal-support", &closed)).unwrap();
        assert!(!closed.caption.contains("not known") && closed.legend.len() == 1);
    }

    #[test]
    fn what_is_not_published_is_dashed_and_what_is_missing_is_not_drawn() {
        let mut assumed = CYLINDER;
        assumed[3].2 = "assumed";
        let assumed = section(&record("internal-support", &assumed)).unwrap();
        assert!(said(&assumed.scene).contains(&"28 mm, assumed"));
        assert!(section(&record("internal-support", &CYLINDER[1..])).is_none());
        let mut none = CYLINDER;
        for impossible in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            none[0].1 = impossible;
            assert!(section(&record("internal-support", &none)).is_none(), "{impossible}");
        }
        // Parts that do not fit into one another are no cross-section.
        let mut tall = CYLINDER;
        tall[2].1 = 200.0;
        assert!(section(&record("internal-support", &tall)).is_none());
        let all = CYLINDER.map(|(name, mm, _)| (name, mm, "assumed"));
        let assumed = section(&record("internal-support", &all)).unwrap();
        let dashed = |e: &&Element| matches!(e, Element::Line { is_dashed: true, .. });
        assert_eq!(assumed.scene.elements.iter().filter(dashed).count(), 2);
        assert!(
            assumed.caption.contains("Assumed or calibrated: outer diameter") && !assumed.caption.contains("Published")
        );
        assert!(section(&record("bellows", &CYLINDER)).is_none());
    }
}
