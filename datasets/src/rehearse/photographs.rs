//! Photographs of a run: when they are taken, what they show, how they are called, and what `session.toml` says of them.
//!
//! ```text
//! log of the camera's device --> rows: one a state, or all of a film --> value seen --> photo::{body, finger, imprint} --> PNG
//! ```
//!
//! The value that is seen is the true one. What is off is the camera: its scale and its distance by their declared standard
//! uncertainties, drawn once for a seed; the object stands a little aside and turned, drawn for each run.

use pneuval_ingest::camera::picture::Picture;
use pneuval_ingest::digest;
use pneuval_ingest::recording::Table;

use super::bench::{DeviceLog, LoggedColumn, TruePoint};
use super::photo::{
    Bending, Body, Camera, Depth, File, Finger, Imprint, NoPhotograph, Photograph, Profile, Settings, Shape, area_m2,
    body, bytes, finger, imprint,
};
use super::plan::{Channel, Device, Moments, Plan, PlanCamera, PlanObject, Programme};
use super::random::Normal;
use super::record::PictureRecord;

/// How far an object is turned and stands aside from run to run, as standard deviations, in rad and shares of the picture's height.
const TURN_RAD: f64 = 0.005;
const ASIDE: f64 = 0.004;

/// Where the middle of the picture is from a finger's mount, as shares of the finger's length: to its side and downwards.
const FINGER_MIDDLE: [f64; 2] = [0.3, 0.35];

/// A blot of a disc of 1: its waves, and how large its holes are.
const BLOT: [[f64; 2]; 3] = [[0.08, 0.5], [0.05, 2.0], [0.02, 1.0]];
const HOLE: f64 = 0.07;
/// Holes lie on a spiral, by this angle one after the other.
const SPIRAL_RAD: f64 = 2.4;

/// Paint is red, paper is not quite white.
const PAINT: [f32; 3] = [0.5, 0.03, 0.05];
const PAPER: [f32; 3] = [0.75, 0.74, 0.7];

const MM: f64 = 1e-3;

/// The keys of the reader's `camera`, each with its value.
pub fn reader_keys(plan: &Plan, device: &Device, camera: &PlanCamera, table: &Table) -> Vec<String> {
    let mm = |(value, std): (f64, f64)| {
        // What conversions leave behind the twelfth digit nobody wrote.
        let shown = |si: f64| (si / MM * 1e12).round() / 1e12;
        format!("{{ value = {}, unit = \"mm\", std = {} }}", shown(value), shown(std))
    };
    let mut keys = vec![
        format!("measure = \"{}\"", camera.object.measure()),
        format!("scale = {}", mm(camera.scale_m)),
        "tone = \"linear\"".to_owned(),
        format!("distance = {}", mm(camera.distance_m)),
    ];
    // It bends to the right, and hangs down.
    if matches!(camera.object, PlanObject::Finger { .. }) {
        keys.push("sense = \"counterclockwise\"".to_owned());
    }
    match camera.moments {
        Moments::Film => keys.push(format!("fps = {}", device.rate_hz)),
        Moments::Stations => keys.push(format!("names = \"{}\"", pattern(plan, device, camera, table))),
    }
    keys
}

/// The channels that stand in the names of pictures.
fn noted<'p>(plan: &'p Plan, device: &'p Device, camera: &'p PlanCamera) -> impl Iterator<Item = &'p Channel> + 'p {
    plan.channels.iter().filter(|channel| channel.device == device.id && channel.id != camera.channel)
}

/// How pictures of states are called: by their number, and by what was read with them.
fn pattern(plan: &Plan, device: &Device, camera: &PlanCamera, table: &Table) -> String {
    let field = |channel: &Channel| {
        let unit = table.column(&channel.id).and_then(|column| column.unit.as_ref());
        format!("_{}_{{{}{}}}", channel.id, channel.id, unit.map(|unit| format!(":{unit}")).unwrap_or_default())
    };
    noted(plan, device, camera).fold("{n}".to_owned(), |text, channel| text + &field(channel)) + ".png"
}

/// The digest of a folder: that of the list of its files, as `sha256sum *` prints it there.
pub fn folder_sha256(pictures: &[PictureRecord]) -> String {
    let mut lines: Vec<(&str, String)> = pictures
        .iter()
        .map(|picture| (picture.name.as_str(), format!("{}  {}\n", picture.sha256, picture.name)))
        .collect();
    lines.sort();
    digest::sha256(lines.into_iter().map(|(_, line)| line).collect::<String>().as_bytes())
}

/// A camera in one run.
pub struct Shooting<'a> {
    plan: &'a Plan,
    camera: &'a PlanCamera,
    log: &'a DeviceLog,
    /// The camera as it really is, before an object that stands as it really does.
    real: Camera,
    seed: u64,
    purpose: &'a str,
}

impl<'a> Shooting<'a> {
    /// A camera whose errors are those of the seed, and whose object stands as it does in this run.
    pub fn new(plan: &'a Plan, camera: &'a PlanCamera, log: &'a DeviceLog, seed: u64, purpose: &'a str) -> Self {
        let flaw = if camera.is_flawless { 0.0 } else { 1.0 };
        let mut of_camera = Normal::new(seed, &format!("camera {}", plan.devices[log.device].id));
        let mut off = |(declared, std): (f64, f64)| declared + flaw * std * of_camera.next();
        let (metre_per_px, distance_m) = (off(camera.scale_m), off(camera.distance_m));
        let [width, height] = camera.size_px;
        let mut stand = Normal::new(seed, &format!("{purpose} stand"));
        let mut stray = |std: f64| flaw * std * stand.next();
        let aside_m = ASIDE * height as f64 * metre_per_px;
        let mut shift_m = [stray(aside_m), stray(aside_m)];
        if let PlanObject::Finger { length_m, .. } = camera.object {
            shift_m[0] -= FINGER_MIDDLE[0] * length_m;
            shift_m[1] -= FINGER_MIDDLE[1] * length_m;
        }
        let roll_rad = stray(TURN_RAD);
        let real = Camera { shift_m, roll_rad, ..Camera::facing(width, height, metre_per_px, distance_m) };
        Self { plan, camera, log, real, seed, purpose }
    }

    /// Samples of the log at which pictures are taken: all, or the middle of the window of each state. What is only let go at the
    /// end is not photographed any more, nor what leaves no imprint for want of pressure.
    pub fn rows(&self, points: &[TruePoint], programme: &Programme) -> Vec<usize> {
        let times = &self.log.true_s;
        match self.camera.moments {
            Moments::Film => (0..times.len()).collect(),
            Moments::Stations => {
                let middle = |point: &TruePoint| point.plateau.to_s - 0.5 * programme.window_s;
                let before = |at: f64| times.partition_point(|t| *t <= at).saturating_sub(1);
                let is_imprint = matches!(self.camera.object, PlanObject::Imprint { .. });
                let is_taken = |point: &&TruePoint| {
                    let is_pressed = point.plateau.state.pressures_pa.iter().any(|pressure| *pressure > 0.0);
                    (point.plateau.loading || programme.unload) && (is_pressed || !is_imprint)
                };
                points.iter().filter(is_taken).map(|point| before(middle(point))).collect()
            }
        }
    }

    fn column(&self, id: &str) -> Option<&LoggedColumn> {
        self.log.columns.iter().find(|column| self.plan.channels[column.channel].id == id)
    }

    /// The name of the picture of a row, of so many.
    fn name(&self, row: usize, index: usize, count: usize) -> String {
        let digits = count.to_string().len();
        let number = format!("{:0digits$}", index + 1);
        if self.camera.moments == Moments::Film {
            return format!("{number}.png");
        }
        let device = &self.plan.devices[self.log.device];
        let note = |channel: &Channel| {
            let value = self.column(&channel.id).map_or(f64::NAN, |column| column.values[row]);
            format!("_{}_{value:.*}", channel.id, channel.decimals)
        };
        noted(self.plan, device, self.camera).fold(number, |text, channel| text + &note(channel)) + ".png"
    }

    /// Takes a picture: its bytes, and the truth.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub fn take(&self, row: usize, index: usize, count: usize) -> Result<(Vec<u8>, PictureRecord), String> {
        let column = self.column(&self.camera.channel).ok_or("nothing to see: its channel is not logged")?;
        let value_si = column.unit.to_si(column.values[row]);
        let name = self.name(row, index, count);
        // Every picture has noise of its own.
        let seed = Normal::new(self.seed, &format!("{} {name}", self.purpose)).even().to_bits();
        let record = PictureRecord {
            name,
            sha256: String::new(),
            at_s: self.log.true_s[row],
            value_si,
            metre_per_px: self.real.metre_per_px(),
            distance_m: self.real.distance_m,
            tip_m: None,
            root_and_tip_px: None,
            length_m: None,
        };
        let (picture, record) =
            self.seen(value_si, seed, record).map_err(|why| format!("{value_si} in SI units: {why}"))?;
        let bytes = bytes(&picture, File::Png).map_err(|why| why.to_string())?;
        let sha256 = digest::sha256(&bytes);
        Ok((bytes, PictureRecord { sha256, ..record }))
    }

    fn seen(&self, value_si: f64, seed: u64, record: PictureRecord) -> Result<(Picture, PictureRecord), NoPhotograph> {
        let PlanCamera { blur_px, noise, .. } = *self.camera;
        let settings = Settings { blur_px, noise, depth: Depth::Eight, ..Settings::default() };
        match &self.camera.object {
            PlanObject::Barrel { length_m, ends_m, rod_m, foot_m } => {
                let profile = Profile::Barrel {
                    middle_radius_m: 0.5 * value_si,
                    end_radius_m: 0.5 * ends_m.min(value_si),
                    length_m: *length_m,
                };
                // No wider than the widest place: that is what the value is.
                let of = Body { profile, rod_radius_m: 0.5 * rod_m.min(value_si), foot_m: *foot_m };
                Ok((body(&of, &self.real, &settings, seed)?.picture, record))
            }
            PlanObject::Finger { length_m, width_m, waves } => {
                let of = Finger {
                    bending: Bending::Constant(value_si),
                    length_m: *length_m,
                    width_m: *width_m,
                    waves: *waves,
                    markers: vec![],
                };
                let Photograph { picture, truth } = finger(&of, &self.real, &settings, seed)?;
                let places = [truth.root_px, truth.tip_px].map(Into::into);
                let (tip_m, length_m) = (Some(truth.tip_m), Some(truth.length_m));
                Ok((picture, PictureRecord { tip_m, root_and_tip_px: Some(places), length_m, ..record }))
            }
            PlanObject::Imprint { holes, uneven } => {
                let settings = Settings { is_colour: true, background: PAPER, object: PAINT, ..settings };
                let of = blot(value_si, *holes, *uneven);
                Ok((imprint(&of, &self.real, &settings, seed)?.picture, record))
            }
        }
    }
}

/// Paint of an area; of none, bare paper.
fn blot(area: f64, holes: usize, uneven: f64) -> Imprint {
    if area <= 0.0 {
        return Imprint { shapes: vec![], holes: vec![], uneven };
    }
    let of = |radius_m: f64| {
        let shapes = vec![Shape::Blot { middle_m: [0.0; 2], radius_m, waves: BLOT.to_vec() }];
        let hole = |i: usize| {
            let (sin, cos) = (SPIRAL_RAD * i as f64).sin_cos();
            let out = radius_m * 0.75 * ((i as f64 + 0.5) / holes as f64).sqrt();
            Shape::disc([out * cos, out * sin], HOLE * radius_m)
        };
        (shapes, (0..holes).map(hole).collect::<Vec<_>>())
    };
    let (shapes, cut) = of(1.0);
    let (shapes, holes) = of((area / area_m2(&shapes, &cut)).sqrt());
    Imprint { shapes, holes, uneven }
}
