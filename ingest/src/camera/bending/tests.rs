//! Fingers whose centreline is known: arcs and clothoids, with round and flat ends, blur, light and noise.

use super::*;
use crate::camera::picture::Pixels;
use crate::camera::testing::shares;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

const SIZE: (usize, usize) = (640, 480);

/// A finger that hangs from the upper border: straight down to a place, and from there bent by a curvature that changes evenly.
struct Finger {
    x: f64,
    y: f64,
    heading: f64,
    length: f64,
    /// Curvature at its beginning and its end, in 1/px.
    bend: (f64, f64),
    half: f64,
    wave: f64,
    /// Half the width of a mount from which it hangs; 0: none.
    mount: f64,
    blur: f64,
    noise: f64,
    levels: (f64, f64),
    seed: u128,
}

impl Default for Finger {
    fn default() -> Self {
        let half_turn = std::f64::consts::PI;
        Self {
            x: 330.0,
            y: -0.5,
            heading: 0.5 * half_turn,
            length: 380.0,
            bend: (0.5 * half_turn / 380.0, 0.5 * half_turn / 380.0),
            half: 33.0,
            wave: 0.0,
            mount: 0.0,
            blur: 1.7,
            noise: 3.0,
            levels: (200.0, 50.0),
            seed: 1,
        }
    }
}

impl Finger {
    fn angle(&self, s: f64) -> f64 {
        self.heading + self.bend.0 * s + 0.5 * (self.bend.1 - self.bend.0) * s * s / self.length
    }

    /// Points of the centreline, a quarter of a px apart, from before its beginning.
    fn line(&self) -> Vec<(f64, Place, f64)> {
        const STEP: f64 = 0.25;
        let mut at = Place::new(self.x, self.y);
        let mut all = vec![];
        let mut s = 0.0;
        while s <= self.length + 0.5 * STEP {
            all.push((s, at, self.angle(s)));
            at += direction(self.angle(s + 0.5 * STEP)) * STEP;
            s += STEP;
        }
        all
    }

    /// Straight on from where the half circle of the end begins; and the angle there.
    fn tip(&self) -> (Place, f64) {
        let (.., at, angle) = self.line().pop().unwrap();
        (at + direction(angle) * self.half, angle - self.heading)
    }

    /// Whether a place above the end of the mount is the finger's, which came back up.
    fn is_curled(&self, place: Place, line: &[(f64, Place, f64)]) -> bool {
        let behind = line.iter().skip(line.len() / 2);
        behind.map(|(_, at, _)| (at - place).norm()).fold(f64::INFINITY, f64::min) < self.half
    }

    fn picture(&self) -> Picture {
        let (w, h) = SIZE;
        let line = self.line();
        // The nearest points of a pixel's block: ways along a finger do not jump.
        let nearest = |place: Place, of: &[usize]| -> usize {
            let apart = |i: &usize| (line[*i].1 - place).norm_squared();
            of.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
        };
        let coarse: Vec<usize> = (0..line.len()).step_by(24).collect();
        let is_in = |x: f64, y: f64| {
            let place = Place::new(x, y);
            if self.mount > 0.0 && y < self.y {
                return (x - self.x).abs() < self.mount || self.is_curled(place, &line);
            }
            let near = nearest(place, &coarse);
            let range: Vec<usize> = (near.saturating_sub(24)..(near + 25).min(line.len())).collect();
            let i = nearest(place, &range);
            let (s, at, angle) = line[i];
            let apart = place - at;
            let (along, across) =
                (apart.dot(&direction(angle)), apart.dot(&direction(angle + std::f64::consts::FRAC_PI_2)));
            let end = i + 1 == line.len();
            if i == 0 && along < -0.2 {
                // Above the picture.
                return across.abs() < self.half;
            }
            // Waves on one side.
            let wave = if across > 0.0 { 0.5 * self.wave * (1.0 + (s / 6.0).cos()) } else { 0.0 };
            if end { along.max(0.0).hypot(across) < self.half } else { across.abs() < self.half + wave }
        };
        let part = shares(SIZE, &is_in, self.blur);
        let mut generator = Pcg64Mcg::new(self.seed);
        let value = |(i, part): (usize, &f64)| {
            let light = 1.0 + 0.12 * ((i % w) as f64 / w as f64 - 0.5) - 0.1 * ((i / w) as f64 / h as f64 - 0.5);
            let z: f64 = StandardNormal.sample(&mut generator);
            let value = light * (self.levels.0 + (self.levels.1 - self.levels.0) * part) + self.noise * z;
            // Clamped to the range of a byte.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let byte = value.round().clamp(0.0, 255.0) as u8;
            byte
        };
        Picture::new(w, h, Pixels::Gray8(part.iter().enumerate().map(value).collect())).unwrap()
    }
}

fn plain(picture: &Picture, sought: SoughtBending) -> Result<Bending, BendingRefusal> {
    bending(picture, sought, &|place| Some(place))
}

#[test]
fn angles_and_tips_are_those_of_the_fingers_and_their_intervals_hold() {
    let mut generator = Pcg64Mcg::new(11);
    let mut uniform = |from: f64, to: f64| from + (to - from) * f64::from(generator.next_u32()) / f64::from(u32::MAX);
    let (mut angles, mut tips, mut held) = (vec![], vec![], [0, 0]);
    for seed in 0..12 {
        let length = uniform(260.0, 360.0);
        let turn: f64 = uniform(-150.0, 150.0);
        let turn = turn.to_radians();
        let skew = uniform(-0.4, 0.4);
        let finger = Finger {
            x: 330.0 + 0.35 * length * turn.signum() * (turn.abs() / 2.6),
            heading: std::f64::consts::FRAC_PI_2 + uniform(-0.1, 0.1),
            length,
            bend: (turn / length * (1.0 - skew), turn / length * (1.0 + skew)),
            half: uniform(25.0, 38.0),
            blur: uniform(1.2, 2.5),
            noise: uniform(2.0, 5.0),
            seed,
            ..Finger::default()
        };
        // Known where it begins: at the border, and its direction there.
        let found = plain(&finger.picture(), SoughtBending::default()).unwrap_or_else(|why| panic!("{seed}: {why}"));
        let (true_tip, turn) = finger.tip();
        let angle = (found.angle_rad - turn).to_degrees();
        let tip = (found.tip - true_tip).norm();
        held[0] += usize::from(angle.abs() < 1.96 * found.angle_std_rad.to_degrees());
        held[1] += usize::from(tip < 2.45 * found.tip_std_px[0].max(found.tip_std_px[1]));
        angles.push(angle.abs());
        tips.push(tip);
    }
    let worst = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    // Of 12, each holds with a chance of 0.95: fewer than 9 have one of 500.
    assert!(worst(&angles) < 0.15 && worst(&tips) < 0.2, "{angles:?} {tips:?}");
    assert!(held.iter().all(|h| *h >= 9), "{held:?}");
}

#[test]
fn an_arc_has_its_curvature_everywhere_and_a_clothoid_strays_from_any() {
    let bend = 0.004;
    let arc = Finger { x: 400.0, length: 330.0, bend: (bend, bend), ..Finger::default() };
    let found = plain(&arc.picture(), SoughtBending::default()).unwrap();
    assert_eq!(found.degree, 1);
    assert!((found.arc.per_px / bend - 1.0).abs() < 0.01 && found.arc.rms_px < 0.05, "{:?}", found.arc);
    for at in &found.curvature {
        assert!((at.per_px - bend).abs() < 4.0 * at.std_per_px.max(1e-6), "{at:?}");
    }
    assert!(
        (found.length_px.0 - 363.0).abs() < 0.3 && (found.heading_rad - arc.heading).abs() < 2e-3,
        "{:?} {}",
        found.length_px,
        found.heading_rad
    );
    // The middle of a curve whose curvature goes from b(1 - k) to b(1 + k) lies beside its best arc; here by some px.
    let clothoid = Finger { bend: (0.4 * bend, 1.6 * bend), ..arc };
    let found = plain(&clothoid.picture(), SoughtBending::default()).unwrap();
    assert!(found.degree >= 2 && (1.0..6.0).contains(&found.arc.rms_px), "{} {:?}", found.degree, found.arc);
    let ends = (found.curvature[0].per_px, found.curvature[PROFILE - 1].per_px);
    assert!((ends.0 / bend - 0.4).abs() < 0.05 && (ends.1 / bend - 1.6).abs() < 0.05, "{ends:?}");
}

#[test]
fn a_finger_is_measured_however_far_it_curls_and_however_wide_its_mount_is() {
    let turn = |degrees: f64, length: f64| (degrees.to_radians() / length, degrees.to_radians() / length);
    for (degrees, half, mount) in [(40.0, 18.0, 26.0), (150.0, 12.0, 60.0), (190.0, 12.0, 60.0), (225.0, 16.0, 50.0)] {
        let finger =
            Finger { x: 400.0, y: 90.0, length: 260.0, bend: turn(degrees, 260.0), half, mount, ..Finger::default() };
        let (tip, angle) = finger.tip();
        let found = plain(&finger.picture(), SoughtBending::default()).unwrap_or_else(|why| panic!("{degrees}: {why}"));
        let off = (found.angle_rad - angle).to_degrees();
        assert!(off.abs() < 0.2 && (found.tip - tip).norm() < 0.2, "{degrees}: {off} {} {tip}", found.tip);
        assert!((found.root - Place::new(400.0, 90.0)).norm() < 0.5 && found.flags.is_empty(), "{degrees}: {found:?}");
    }
    // A mount that is hardly wider than the finger cannot be told from it: that is told.
    let slim = Finger {
        x: 400.0,
        y: 120.0,
        length: 260.0,
        bend: turn(40.0, 260.0),
        half: 18.0,
        mount: 22.0,
        ..Finger::default()
    };
    let found = plain(&slim.picture(), SoughtBending::default()).unwrap();
    assert!(
        found.flags.iter().any(|flag| matches!(flag, BendingFlag::Wider(times) if *times > 1.12)),
        "{:?}",
        found.flags
    );
}

#[test]
fn bright_wavy_named_and_headed_fingers_are_measured_too() {
    let bend = 0.005;
    let plainly = Finger { x: 400.0, length: 300.0, bend: (bend, bend), ..Finger::default() };
    let (tip, turn) = plainly.tip();
    let bright = Finger { levels: (60.0, 190.0), ..plainly };
    let found = plain(&bright.picture(), SoughtBending::default()).unwrap();
    assert!(
        (found.tip - tip).norm() < 0.2 && (found.angle_rad - turn).abs().to_degrees() < 0.1,
        "{} {turn}",
        found.angle_rad
    );
    // Where the root is named, the angle counts from there; with a heading, from that.
    let root = plainly.line()[320].1;
    let heading_rad = Some(std::f64::consts::FRAC_PI_2);
    let sought = SoughtBending { root: Some(root), heading_rad, ..SoughtBending::default() };
    let found = plain(&plainly.picture(), sought).unwrap();
    assert!(
        (found.angle_rad - turn).abs().to_degrees() < 0.1 && (found.root - root).norm() < 0.3,
        "{} {turn} {}",
        found.angle_rad,
        found.root
    );
    let from_root = plain(&plainly.picture(), SoughtBending { heading_rad: None, ..sought }).unwrap();
    assert!((from_root.angle_rad - turn + 80.0 * bend).abs().to_degrees() < 0.1, "{}", from_root.angle_rad);
    // Waves on one side leave the other as it is.
    let wavy = Finger { wave: 4.0, ..plainly };
    let found = plain(&wavy.picture(), SoughtBending::default()).unwrap();
    assert!((found.angle_rad - turn).abs().to_degrees() < 0.1, "{} {turn}", found.angle_rad);
    assert!(found.flags.contains(&BendingFlag::OneSide), "{:?}", found.flags);
    // Twice as large where a lens says so: the angle is the same.
    let twice = bending(&plainly.picture(), SoughtBending::default(), &|place| Some(2.0 * place)).unwrap();
    assert!(
        (twice.angle_rad - turn).abs().to_degrees() < 0.1 && (twice.tip - 2.0 * tip).norm() < 0.5,
        "{} {}",
        twice.angle_rad,
        twice.tip
    );
    assert!(matches!(bending(&plainly.picture(), SoughtBending::default(), &|_| None), Err(BendingRefusal::Lens)));
}

#[test]
fn what_cannot_be_measured_is_refused_with_its_reason() {
    let finger = Finger { x: 400.0, length: 300.0, bend: (0.005, 0.005), ..Finger::default() };
    let refused = |picture: &Picture, sought: SoughtBending| plain(picture, sought).unwrap_err().to_string();
    let empty = Picture::new(64, 64, Pixels::Gray8(vec![90; 64 * 64])).unwrap();
    assert!(refused(&empty, SoughtBending::default()).contains("no body"));
    // Both ends in the picture.
    let free = Finger { y: 60.0, ..finger };
    let pixels = |picture: &Picture| match picture.pixels() {
        Pixels::Gray8(all) => all.clone(),
        _ => vec![],
    };
    let mut cut = pixels(&free.picture());
    cut[..50 * SIZE.0].fill(205);
    let free = Picture::new(SIZE.0, SIZE.1, Pixels::Gray8(cut)).unwrap();
    assert!(refused(&free, SoughtBending::default()).contains("name the `root`"));
    let far = SoughtBending { root: Some(Place::new(639.0, 479.0)), ..SoughtBending::default() };
    let why = refused(&free, far);
    assert!(why.contains("nearer end"), "{why}");
    // Out at both ends.
    let long = Finger { x: 320.0, length: 600.0, bend: (0.0, 0.0), ..Finger::default() };
    assert!(refused(&long.picture(), SoughtBending::default()).contains("both ends"));
    // A ring.
    let straight = Finger { length: 150.0, bend: (0.0, 0.0), half: 20.0, ..Finger::default() };
    let mut ring = pixels(&straight.picture());
    for (i, pixel) in ring.iter_mut().enumerate() {
        let (x, y) = ((i % SIZE.0) as f64, (i / SIZE.0) as f64);
        if ((x - 330.0).hypot(y - 240.0) - 80.0).abs() < 20.0 {
            *pixel = 50;
        }
    }
    let ring = Picture::new(SIZE.0, SIZE.1, Pixels::Gray8(ring)).unwrap();
    let why = refused(&ring, SoughtBending::default());
    assert!(why.contains("ring"), "{why}");
    // A dot is no finger.
    let dot = Finger { length: 20.0, bend: (0.0, 0.0), ..Finger::default() };
    assert!(plain(&dot.picture(), SoughtBending::default()).is_err());
}
