//! The cross-section of an actuator, to scale, from the dimensions that are known.
//!
//! What is published is drawn solid and carries its value. What is assumed or calibrated is dashed and says so, and what nobody
//! published is dashed and labelled "not published": its size on the drawing means nothing.

mod types;

use crate::format;
use crate::report::chart::{Key, WIDTH_PX};
use crate::report::scene::{Anchor, Element, Px, Scene, Tint};
use crate::results::InputRecord;

pub(super) use types::section;

/// Room around the drawing for dimensions, in px.
const LEFT_PX: f64 = 120.0;
const RIGHT_PX: f64 = 215.0;
const ABOVE_PX: f64 = 46.0;
const BELOW_PX: f64 = 52.0;
/// What is drawn is at most so high.
const HEIGHT_MAX_PX: f64 = 300.0;
/// Between what is measured and its dimension line.
const ASIDE_PX: f64 = 18.0;
/// Half the tick that ends a dimension line.
const TICK_PX: f64 = 4.0;

/// A drawing with what it says.
pub(in crate::report) struct Section {
    pub scene: Scene,
    pub legend: Vec<Key>,
    pub caption: String,
}

/// The inputs of an actuator file.
#[derive(Clone, Copy)]
struct Inputs<'a>(&'a [InputRecord]);

/// A dimension that is known.
#[derive(Debug, Clone, PartialEq)]
struct Known {
    /// In mm.
    mm: f64,
    /// Its value, and where it comes from if not from print.
    label: String,
    /// It is in print or was measured.
    is_solid: bool,
}

impl Inputs<'_> {
    /// A length in mm.
    fn length(self, name: &str) -> Option<Known> {
        let input = self.0.iter().find(|i| i.name == name)?;
        let mm = 1e3 * input.value_si;
        let is_solid = matches!(input.origin.as_str(), "published" | "measured");
        let origin = if is_solid { String::new() } else { format!(", {}", input.origin) };
        // Nothing can be drawn of a length that is none, or of one of another world.
        (1e-6..1e6).contains(&mm).then(|| Known { mm, label: format!("{} mm{origin}", format::short(mm)), is_solid })
    }

    /// A number without unit, or an angle in rad.
    fn number(self, name: &str) -> Option<f64> {
        self.0.iter().find(|i| i.name == name).map(|i| i.value_si).filter(|v| v.is_finite() && *v > 0.0)
    }
}

/// A drawing in mm, x to the right and y up, from the left lower corner.
struct Sketch {
    scene: Scene,
    px_per_mm: f64,
    height_mm: f64,
}

impl Sketch {
    /// Of what is so wide and high, in mm.
    fn new(width_mm: f64, height_mm: f64) -> Self {
        let px_per_mm = ((WIDTH_PX - LEFT_PX - RIGHT_PX) / width_mm).min(HEIGHT_MAX_PX / height_mm);
        let scene = Scene::new((WIDTH_PX, ABOVE_PX + px_per_mm * height_mm + BELOW_PX));
        Self { scene, px_per_mm, height_mm }
    }

    fn at(&self, (x, y): (f64, f64)) -> Px {
        (LEFT_PX + self.px_per_mm * x, ABOVE_PX + self.px_per_mm * (self.height_mm - y))
    }

    fn outline(&mut self, corners: &[(f64, f64)], fill: Option<Tint>, is_dashed: bool) {
        let mut points: Vec<Px> = corners.iter().map(|p| self.at(*p)).collect();
        if let Some(tint) = fill {
            self.scene.elements.push(Element::Area { corners: points.clone(), tint });
        }
        points.extend(points.first().copied());
        let tint = if is_dashed { Tint::Muted } else { Tint::Ink };
        self.scene.elements.push(Element::Line { points, tint, width: 1.4, is_dashed });
    }

    /// Material; its outline is solid if every dimension that makes it is.
    fn solid(&mut self, corners: &[(f64, f64)], by: &[&Known]) {
        self.outline(corners, Some(Tint::Solid), !by.iter().all(|known| known.is_solid));
    }

    /// Air, likewise.
    fn air(&mut self, corners: &[(f64, f64)], by: &[&Known]) {
        self.outline(corners, Some(Tint::Paper), !by.iter().all(|known| known.is_solid));
    }

    /// An outline that nobody published.
    fn unknown(&mut self, corners: &[(f64, f64)]) {
        self.outline(corners, None, true);
    }

    /// A line that nobody published.
    fn unknown_line(&mut self, points: &[(f64, f64)]) {
        let points = points.iter().map(|p| self.at(*p)).collect();
        self.scene.elements.push(Element::Line { points, tint: Tint::Muted, width: 1.4, is_dashed: true });
    }

    /// A horizontal dimension above (or, with a negative row, below) a height.
    fn across(&mut self, span: (f64, f64), y: f64, row: f64, label: &str) {
        self.across_at(span, 0.5, y, row, label);
    }

    /// The same with its label at a share of its length.
    fn across_at(&mut self, (from, to): (f64, f64), share: f64, y: f64, row: f64, label: &str) {
        let (a, b) = (self.at((from, y)), self.at((to, y)));
        let level = a.1 - row * ASIDE_PX;
        self.dimension([(a.0, level), (b.0, level)], [(0.0, TICK_PX), (0.0, -TICK_PX)]);
        let beside = if row > 0.0 { level - 11.0 } else { level + 12.0 };
        self.scene.words((a.0 + share * (b.0 - a.0), beside), label, Anchor::Middle, Tint::Ink);
    }

    /// A vertical dimension to the right (or, with a negative column, to the left) of a place.
    fn along(&mut self, (from, to): (f64, f64), x: f64, column: f64, label: &str) {
        let (a, b) = (self.at((x, from)), self.at((x, to)));
        let level = a.0 + column * ASIDE_PX;
        self.dimension([(level, a.1), (level, b.1)], [(TICK_PX, 0.0), (-TICK_PX, 0.0)]);
        let (beside, anchor) = if column >= 0.0 { (level + 8.0, Anchor::Start) } else { (level - 8.0, Anchor::End) };
        self.scene.words((beside, 0.5 * (a.1 + b.1)), label, anchor, Tint::Ink);
    }

    fn dimension(&mut self, ends: [Px; 2], tick: [Px; 2]) {
        let mut all = vec![ends];
        all.extend(ends.map(|end| tick.map(|t| (end.0 + t.0, end.1 + t.1))));
        self.scene.elements.push(Element::Segments { ends: all, tint: Tint::Muted, width: 1.0 });
    }

    /// A line from a place to words so many px to the right and down of it.
    fn pointer(&mut self, place: (f64, f64), by: Px, label: &str) {
        let from = self.at(place);
        let to = (from.0 + by.0, from.1 + by.1);
        self.scene.elements.push(Element::Segments { ends: vec![[from, to]], tint: Tint::Muted, width: 1.0 });
        let (beside, anchor) = if by.0 >= 0.0 { (5.0, Anchor::Start) } else { (-5.0, Anchor::End) };
        self.scene.words((to.0 + beside, to.1), label, anchor, Tint::Ink);
    }

    /// The drawing, if its parts fit into one another: what does not is no cross-section.
    fn done(self, caption: &str, of: &[(&str, &Known)]) -> Option<Section> {
        let (low, high) =
            (self.at((0.0, self.height_mm)), (WIDTH_PX - RIGHT_PX, ABOVE_PX + self.px_per_mm * self.height_mm));
        let inside =
            |p: &Px| (low.0 - 1.0..=high.0 + 1.0).contains(&p.0) && (low.1 - 1.0..=high.1 + 1.0).contains(&p.1);
        let fits = self.scene.elements.iter().all(|element| match element {
            Element::Area { corners, .. } => corners.iter().all(inside),
            Element::Line { points, .. } => points.iter().all(inside),
            _ => true,
        });
        let has_dashes = self.scene.elements.iter().any(|e| matches!(e, Element::Line { is_dashed: true, .. }));
        let mut legend = vec![Key::solid("material")];
        if has_dashes {
            legend.push(Key::dashed("not published, or assumed"));
        }
        let named = |solid: bool| {
            let names: Vec<&str> =
                of.iter().filter(|(_, known)| known.is_solid == solid).map(|(name, _)| *name).collect();
            names.join(", ")
        };
        let mut caption = caption.to_owned();
        for (solid, what) in [(true, "Published or measured"), (false, "Assumed or calibrated")] {
            if !named(solid).is_empty() {
                caption.push_str(&[" ", what, ": ", &named(solid), "."].concat());
            }
        }
        fits.then_some(Section { scene: self.scene, legend, caption })
    }
}

/// Corners of a rectangle.
fn rectangle((x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> [(f64, f64); 4] {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
}

/// Places along an arc around a middle, angles in rad against the x axis.
fn arc(middle: (f64, f64), radius: f64, (from, to): (f64, f64)) -> Vec<(f64, f64)> {
    const STEPS: i32 = 60;
    let place = |i: i32| {
        let (sin, cos) = (from + (to - from) * f64::from(i) / f64::from(STEPS)).sin_cos();
        (middle.0 + radius * cos, middle.1 + radius * sin)
    };
    (0..=STEPS).map(place).collect()
}
