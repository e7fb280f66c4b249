//! `rehearsals/<id>.toml`: what is rehearsed, with which instruments, and what the specimen does.

mod camera;
mod raw;

use pneuval_ingest::IngestError;
use pneuval_ingest::document::Document;
use pneuval_ingest::formats::Format;
use pneuval_ingest::manifest::{ComparisonSpec, Quantity};
use pneuval_ingest::units::{Dimension, Unit};

pub use camera::{Moments, PlanCamera, PlanObject};

/// A rehearsal as it is written. Times are in s, pressures gauge in Pa, shares in 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Its id.
    pub id: String,
    /// The actuator that is rehearsed.
    pub actuator: String,
    /// Its name on pages.
    pub title: String,
    /// The rig that holds the instruments.
    pub rig: String,
    /// From the command to the pressure.
    pub regulator: Regulator,
    /// From the pressure to what is measured.
    pub specimen: Specimen,
    /// What logs, each with a clock and a file of its own.
    pub devices: Vec<Device>,
    /// What is logged.
    pub channels: Vec<Channel>,
    /// Sessions, each with a programme.
    pub sittings: Vec<Sitting>,
    /// Tests of materials.
    pub tensile: Vec<Tensile>,
    /// The file as the user named it.
    pub file: String,
}

/// A pressure regulator: a first-order lag that settles a little below what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regulator {
    /// Time constant.
    pub time_constant_s: f64,
    /// The share of the command by which the pressure stays below it.
    pub droop: f64,
}

/// What a specimen does beyond its equilibrium curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Specimen {
    /// Share of the deflection that comes late, and its retardation time: a Prony series.
    pub creep: Vec<(f64, f64)>,
    /// Width of the loop at half pressure, as a share of the full deflection. Loading is the equilibrium curve.
    pub hysteresis: f64,
    /// Deflection that is left at zero pressure after unloading, as a share of the loop's width.
    pub residual: f64,
    /// Share of the deflection that a virgin specimen lacks in its first cycle.
    pub softening: f64,
    /// Cycles in which that falls to 1/e.
    pub softening_cycles: f64,
    /// Cycles before the first run.
    pub cycles_before: u64,
    /// Standard deviation of the deflection from specimen to specimen, as a share of it.
    pub spread: f64,
    /// The same from run to run.
    pub repeat: f64,
    /// How long it takes a pressure to reach what is measured, in s: a pure delay.
    pub delay_s: f64,
}

/// Something that logs.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Its id; the first is the one whose file a run is named by.
    pub id: String,
    /// The format it writes.
    pub format: Format,
    /// Samples per second.
    pub rate_hz: f64,
    /// Decimals of its stamps in s.
    pub decimals: usize,
    /// What its clock shows when the sitting begins.
    pub offset_s: f64,
    /// What its clock gains per second.
    pub drift: f64,
    /// Standard deviation of single stamps.
    pub jitter_s: f64,
    /// If it takes photographs.
    pub camera: Option<PlanCamera>,
    /// Line of the file.
    pub line: usize,
}

/// What a channel shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shows {
    /// What is asked of the regulator of a chamber.
    Command(String),
    /// The pressure of a chamber.
    Pressure(String),
    /// A quantity, and which of its components.
    Quantity(String, usize),
    /// A condition.
    Condition(String),
    /// The trigger line: 1 while a sync event lasts.
    Trigger,
}

/// Something that is logged.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its id, and the name of its column.
    pub id: String,
    /// What logs it.
    pub device: String,
    /// What it shows.
    pub shows: Shows,
    /// The instrument of the rig; without one it is exact.
    pub instrument: Option<String>,
    /// The unit that is logged where no instrument says it.
    pub unit: Option<Unit>,
    /// Standard deviation of single readings, in SI units of what is measured.
    pub noise_si: f64,
    /// What it gains per second, in SI units of what is measured.
    pub drift_si_per_s: f64,
    /// What noise and drift are amounts of, where they are declared.
    pub noise_dimensions: Vec<Dimension>,
    /// Its instrument measures without bias, noise and drift.
    pub is_flawless: bool,
    /// Decimals that are logged.
    pub decimals: usize,
    /// Line of the file.
    pub line: usize,
}

/// A session.
#[derive(Debug, Clone, PartialEq)]
pub struct Sitting {
    /// Its id, and its folder where there are several.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// What the pressure does.
    pub programme: Programme,
    /// What is measured against it.
    pub responses: Vec<Response>,
    /// What is compared.
    pub comparisons: Vec<ComparisonSpec>,
}

/// What the pressure does.
#[derive(Debug, Clone, PartialEq)]
pub struct Programme {
    /// Its shape.
    pub kind: ProgrammeKind,
    /// Chambers, in the order of `levels`.
    pub chambers: Vec<String>,
    /// The pressures visited, one for each chamber; none: those of the first response's truth.
    pub levels: Vec<Vec<f64>>,
    /// At zero before and after.
    pub rest_s: f64,
    /// From level to level.
    pub rise_s: f64,
    /// At each level; of a sine, its period.
    pub hold_s: f64,
    /// Whether the levels are visited again on the way down.
    pub unload: bool,
    /// Times that all of it is done in a run.
    pub cycles: usize,
    /// The end of a hold that is averaged.
    pub window_s: f64,
    /// How far a steady pressure may be from the middle of its range.
    pub tolerance_pa: f64,
}

/// Shapes of programmes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProgrammeKind {
    /// Level after level, each held.
    Steps,
    /// Straight up to the highest level and down again, nothing held.
    Ramp,
    /// `(1 - cos)/2` of the highest level.
    Sine,
    /// Between zero and the highest level, both held.
    Cycles,
}

/// A quantity that is measured against pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// What.
    pub quantity: Quantity,
    /// The chambers whose pressure it depends on.
    pub chambers: Vec<String>,
    /// Channels, one for each component.
    pub measured: Vec<String>,
    /// How it is measured.
    pub method: String,
    /// What is set beside the pressure.
    pub conditions: Vec<Setting>,
    /// What really happens.
    pub truth: Truth,
    /// What is added to it, one amount for each level, on the first component.
    pub deviation: Deviation,
    /// Line of the file.
    pub line: usize,
}

/// A condition of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The channel that logs it.
    pub channel: String,
    /// Its id, as the model's input.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// Its values where the truth does not say them.
    pub values_si: Vec<f64>,
    /// Whether every value has runs of its own: another specimen, another wall.
    pub per_run: bool,
}

/// What really happens.
#[derive(Debug, Clone, PartialEq)]
pub enum Truth {
    /// The measured column of the paper's table of this quantity.
    Published,
    /// A form of the catalogue.
    Form(String),
    /// A table beside the plan: pressure, components.
    File(String),
    /// The sum of other responses.
    Sum(Vec<String>),
}

/// What is added to the truth at each level.
#[derive(Debug, Clone, PartialEq)]
pub enum Deviation {
    /// Nothing.
    None,
    /// One amount for each level.
    Each(Vec<f64>),
    /// Amounts whose largest and whose root mean square over all levels above zero are these.
    MaxAndRmse(f64, f64),
}

/// Strips of a material, pulled.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensile {
    /// The material of the actuator.
    pub material: String,
    /// Strips.
    pub strips: usize,
    /// Gauge length.
    pub length_m: f64,
    /// Width.
    pub width_m: f64,
    /// Thickness.
    pub thickness_m: f64,
    /// Speed of the machine.
    pub speed_m_per_s: f64,
    /// Where the test ends.
    pub stretch_max: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Standard deviation of single forces.
    pub force_noise_n: f64,
    /// Standard deviation of single displacements.
    pub displacement_noise_m: f64,
    /// Standard deviation of the stress from strip to strip, as a share of it.
    pub spread: f64,
    /// Line of the file.
    pub line: usize,
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        document.parse::<raw::Raw>()?.checked(&document)
    }

    /// A specimen and instruments without any flaw: what is logged is the truth.
    pub fn idealise(&mut self) {
        self.regulator = Regulator { time_constant_s: 0.0, droop: 0.0 };
        let cycles_before = self.specimen.cycles_before;
        self.specimen = Specimen { cycles_before, ..Specimen::default() };
        for device in &mut self.devices {
            (device.offset_s, device.drift, device.jitter_s) = (0.0, 0.0, 0.0);
            if let Some(camera) = &mut device.camera {
                (camera.noise, camera.is_flawless) = (0.0, true);
            }
        }
        for tensile in &mut self.tensile {
            (tensile.force_noise_n, tensile.displacement_noise_m, tensile.spread) = (0.0, 0.0, 0.0);
        }
        for channel in &mut self.channels {
            (channel.noise_si, channel.drift_si_per_s, channel.is_flawless) = (0.0, 0.0, true);
        }
    }
}

impl Default for Specimen {
    /// One that follows its equilibrium curve.
    fn default() -> Self {
        Self {
            creep: vec![],
            hysteresis: 0.0,
            residual: 0.0,
            softening: 0.0,
            softening_cycles: 1.0,
            cycles_before: 0,
            spread: 0.0,
            repeat: 0.0,
            delay_s: 0.0,
        }
    }
}
