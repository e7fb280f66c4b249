//! `truth.json`: everything that nobody at a rig would know.

use serde::Serialize;

use super::bench::{RunLog, TruePoint};
use super::faults::FaultRecord;
use super::plan::{Plan, Sitting};

/// The version of its layout.
const SCHEMA: u32 = 2;

/// The truth of one session. SI units, times in s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthRecord {
    /// Version of this layout.
    pub schema: u32,
    /// Always true.
    pub synthetic: bool,
    /// The session's id.
    pub session: String,
    /// The plan.
    pub plan: String,
    /// The actuator.
    pub actuator: String,
    /// What the random numbers come from.
    pub seed: u64,
    /// What this specimen makes of every deflection.
    pub specimen_factor: f64,
    /// Devices with their clocks: what a stamp is, `offset + (1 + drift) t`.
    pub devices: Vec<DeviceRecord>,
    /// By how much what is measured comes behind the pressure, in s.
    pub delay_s: f64,
    /// Runs.
    pub runs: Vec<RunRecord>,
    /// Faults.
    pub faults: Vec<FaultRecord>,
}

/// A device and its clock.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceRecord {
    /// Its id.
    pub id: String,
    /// Samples per second.
    pub rate_hz: f64,
    /// What its clock shows at the beginning.
    pub offset_s: f64,
    /// What its clock gains, in 1e-6.
    pub drift_ppm: f64,
    /// Standard deviation of single stamps.
    pub jitter_s: f64,
}

/// A run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunRecord {
    /// Its id.
    pub id: String,
    /// Its files.
    pub files: Vec<FileRecord>,
    /// Events that all devices with a trigger line show, in s of the true time: when it rises, and when it falls.
    pub triggers_s: Vec<(f64, f64)>,
    /// What was there at every state that stood.
    pub points: Vec<PointRecord>,
    /// Photographs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<PictureRecord>,
}

/// A photograph.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PictureRecord {
    /// Its file.
    pub name: String,
    /// Its SHA-256.
    pub sha256: String,
    /// When it was taken.
    pub at_s: f64,
    /// What is seen: the diameter, the angle, the area.
    pub value_si: f64,
    /// Metres in a px in the object's plane.
    pub metre_per_px: f64,
    /// From the camera to the object.
    pub distance_m: f64,
    /// Of a finger, where its tip is, along and across from its root.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_m: Option<[f64; 2]>,
    /// Where its root and its tip are seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root_and_tip_px: Option<[[f64; 2]; 2]>,
    /// Its length along the centreline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileRecord {
    /// Its name.
    pub name: String,
    /// Its format.
    pub format: &'static str,
    /// Its SHA-256.
    pub sha256: String,
    /// Samples of each device in it.
    pub samples: Vec<(String, usize)>,
}

/// What was there while a state stood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointRecord {
    /// Since when.
    pub from_s: f64,
    /// Until when.
    pub to_s: f64,
    /// Which cycle, from 1.
    pub cycle: usize,
    /// Whether the pressure was no higher before.
    pub loading: bool,
    /// What was asked of the regulator, in Pa.
    pub commanded_pa: Vec<f64>,
    /// Mean pressure over the window, in Pa.
    pub pressures_pa: Vec<f64>,
    /// Quantities.
    pub quantities: Vec<QuantityRecord>,
}

/// A quantity while a state stood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantityRecord {
    /// Its id.
    pub quantity: String,
    /// At equilibrium at these pressures on the loading branch, a component each, of a specimen without spread.
    pub equilibrium_si: Vec<f64>,
    /// Mean over the window, without noise.
    pub mean_si: Vec<f64>,
}

impl TruthRecord {
    /// A record without runs.
    pub fn new(plan: &Plan, session: &str, seed: u64, specimen_factor: f64) -> Self {
        let device = |device: &super::plan::Device| DeviceRecord {
            id: device.id.clone(),
            rate_hz: device.rate_hz,
            offset_s: device.offset_s,
            drift_ppm: device.drift * 1e6,
            jitter_s: device.jitter_s,
        };
        Self {
            schema: SCHEMA,
            synthetic: true,
            session: session.to_owned(),
            plan: plan.id.clone(),
            actuator: plan.actuator.clone(),
            seed,
            specimen_factor,
            devices: plan.devices.iter().map(device).collect(),
            delay_s: plan.specimen.delay_s,
            runs: vec![],
            faults: vec![],
        }
    }
}

/// What was there in a run.
pub fn points(sitting: &Sitting, log: &RunLog) -> Vec<PointRecord> {
    let point = |point: &TruePoint| {
        let quantities = sitting.responses.iter().zip(&point.values).map(|(response, values)| QuantityRecord {
            quantity: response.quantity.id.clone(),
            equilibrium_si: values.iter().map(|(equilibrium, _)| *equilibrium).collect(),
            mean_si: values.iter().map(|(_, mean)| *mean).collect(),
        });
        PointRecord {
            from_s: point.plateau.from_s,
            to_s: point.plateau.to_s,
            cycle: point.plateau.cycle + 1,
            loading: point.plateau.loading,
            commanded_pa: point.plateau.state.pressures_pa.clone(),
            pressures_pa: point.pressures_pa.clone(),
            quantities: quantities.collect(),
        }
    };
    log.points.iter().map(point).collect()
}
