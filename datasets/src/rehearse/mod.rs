//! The rehearsal rig: complete raw sessions with known truth, in real formats, with faults on demand.
//!
//! ```text
//! plan -> states -> timeline -> bench (regulator, specimen, instruments, clocks) -> faults -> files, session.toml, truth.json
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `plan/` | `rehearsals/<id>.toml` |
//! | `check.rs` | whether its parts fit together |
//! | `states.rs` | which pressures and conditions are visited, in which runs |
//! | `programme.rs` | what is asked of the pressure over time |
//! | `truth.rs` | what really happens at equilibrium: a form, the paper's table, a table of the user's |
//! | `specimen.rs` | hysteresis, softening, creep on the way there |
//! | `tensile.rs` | strips of the materials on a tensile machine |
//! | `instrument.rs`, `random.rs` | what instruments make of it |
//! | `photo/` | photographs: rendered, with known truth |
//! | `bench.rs` | one run of all that, and what every device logs |
//! | `session.rs` | one session: its runs, what goes wrong, its files |
//! | `faults/` | what goes wrong |
//! | `photographs.rs` | photographs of a run |
//! | `files.rs`, `manifests.rs`, `bounds.rs`, `record.rs` | logs in their formats, `session.toml`, `bounds.toml`, `truth.json` |
//!
//! Everything depends on the plan and the seed alone: the same seed gives the same bytes.

mod bench;
mod bounds;
mod check;
mod faults;
mod files;
mod instrument;
mod manifests;
pub mod photo;
mod photographs;
pub mod plan;
mod programme;
mod random;
mod record;
mod session;
mod specimen;
mod states;
mod tensile;
mod truth;

use std::path::{Path, PathBuf};

use serde::Serialize;

use pneuval_ingest::IngestError;
use pneuval_ingest::error::{Place, suggestion};
use pneuval_ingest::formats::Format;
use pneuval_ingest::manifest::{Actuator, PublishedDataset, Rig};

use bench::Bench;
use manifests::printed_models;
use plan::{Plan, ProgrammeKind, Sitting};
use random::Normal;
use session::Session;
use states::Visit;
use truth::{Equilibrium, Sources};

pub use faults::{Asked, FAULTS, FaultRecord};
pub use files::Bag;

use crate::{DatasetError, Folder};

/// Spread from specimen to specimen where several are asked for and the plan says none.
const SPREAD: f64 = 0.03;

/// What is asked of a rehearsal beyond its plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// What the random numbers come from.
    pub seed: u64,
    /// Runs of each set of states.
    pub repeats: usize,
    /// Specimens, each with sessions of its own.
    pub specimens: usize,
    /// Without noise, lag, creep, hysteresis.
    pub ideal: bool,
    /// The format of every device, in place of the plan's.
    pub format: Option<Format>,
    /// How bags are written.
    pub bag: Bag,
    /// Whether devices have the clocks of the plan; else they share one.
    pub own_clocks: bool,
    /// The shape of every programme, in place of the plan's.
    pub programme: Option<ProgrammeKind>,
    /// One sitting only.
    pub sitting: Option<String>,
    /// Truths of quantities, in place of the plan's.
    pub truths: Vec<(String, plan::Truth)>,
    /// What goes wrong.
    pub faults: Vec<Asked>,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            seed: 1,
            repeats: 3,
            specimens: 1,
            ideal: false,
            format: None,
            bag: Bag::default(),
            own_clocks: false,
            programme: None,
            sitting: None,
            truths: vec![],
            faults: vec![],
        }
    }
}

/// Takes a file: its name in the folder that is written, and its bytes.
pub type Sink<'a> = &'a mut dyn FnMut(&str, &[u8]) -> Result<(), IngestError>;

/// A session that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Written {
    /// Its id.
    pub id: String,
    /// Its folder; empty if it is the one that is written.
    pub folder: String,
    /// Runs.
    pub runs: usize,
    /// Samples of all devices.
    pub samples: usize,
    /// How long a run lasts, in s.
    pub run_s: f64,
    /// What goes wrong in it.
    pub faults: Vec<FaultRecord>,
}

/// The text of a plan, to begin one of one's own with.
///
/// # Errors
/// [`DatasetError`] if there is none of that name, or it is not text.
pub fn plan_text(name: &str, from: &Path) -> Result<String, DatasetError> {
    let (located, _) = Folder::plan(name, from)?;
    Ok(pneuval_ingest::document::utf8(&located.file, &located.bytes)?.to_owned())
}

/// A plan and all that it names, ready to be rehearsed.
pub struct Rehearsal {
    plan: Plan,
    request: Request,
    rig: Rig,
    rig_text: Vec<u8>,
    actuator: Actuator,
    actuator_text: Vec<u8>,
    /// Tables that the actuator's own models name.
    actuator_tables: Vec<(String, Vec<u8>)>,
    bounds_text: Option<String>,
    published: Option<PublishedDataset>,
    folder: Option<PathBuf>,
}

impl Rehearsal {
    /// Finds the plan of an id, or the one in a file, and all that it names: beside it, above it, or embedded.
    ///
    /// # Errors
    /// [`DatasetError`] for what is not there or malformed, and for what the request asks and the plan does not have.
    pub fn find(name: &str, from: &Path, request: Request) -> Result<Self, DatasetError> {
        let (located, folder) = Folder::plan(name, from)?;
        Self::planned(Plan::read(&located.file, &located.bytes)?, &folder, request)
    }

    /// The plan of a text, with embedded actuator and rig.
    ///
    /// # Errors
    /// As [`Rehearsal::find`].
    pub fn of_text(file: &str, text: &str, request: Request) -> Result<Self, DatasetError> {
        Self::planned(Plan::read(file, text.as_bytes())?, &Folder::Embedded(String::new()), request)
    }

    fn planned(mut plan: Plan, folder: &Folder, request: Request) -> Result<Self, DatasetError> {
        let Some((actuator, actuator_located)) = folder.actuator(&plan.actuator)? else {
            return Err(crate::unknown_actuator(&plan.file, &plan.actuator));
        };
        let (rig, rig_located) = folder.rig(&plan.file, &plan.rig)?;
        let bounds_name = format!("bounds/{}.toml", plan.actuator);
        let bounds = folder.lookup(&["bounds.toml", &bounds_name])?;
        let published = crate::embedded_dataset(&plan.actuator)?;
        let mut actuator_tables = Vec::new();
        for model in &actuator.imported {
            actuator_tables.push((model.file.name.clone(), actuator_located.beside(&model.file.name)?));
        }
        check::check(&plan, &rig, &actuator)?;
        change(&mut plan, &request)?;
        let bounds_text = bounds.map(|bounds| bounds::of_plan(&bounds.file, &bounds.bytes, &plan)).transpose()?;
        Ok(Self {
            plan,
            request,
            rig,
            rig_text: rig_located.bytes,
            actuator,
            actuator_text: actuator_located.bytes,
            actuator_tables,
            bounds_text,
            published,
            folder: located_folder(folder),
        })
    }

    /// The plan's id.
    pub fn id(&self) -> &str {
        &self.plan.id
    }

    /// Whether the pressure moves all the time in some sitting, so that nothing can be compared at plateaus.
    pub fn is_moving(&self) -> bool {
        let moves = |sitting: &Sitting| matches!(sitting.programme.kind, ProgrammeKind::Ramp | ProgrammeKind::Sine);
        self.plan.sittings.iter().any(moves)
    }

    /// Writes all files, one session after the other.
    ///
    /// # Errors
    /// [`IngestError`] for a truth that is not known, a fault that has nothing to hit, a format that cannot hold what is logged, and
    /// as the sink.
    pub fn write(&self, sink: Sink) -> Result<Vec<Written>, IngestError> {
        let several = self.plan.sittings.len() > 1 || self.request.specimens > 1;
        let prepared: Vec<Prepared> =
            self.plan.sittings.iter().map(|sitting| self.prepare(sitting)).collect::<Result<_, _>>()?;
        self.check_faults(&prepared)?;
        self.write_shared(sink)?;
        tensile::write(&self.plan, &self.actuator, self.request.seed, &self.note(), sink)?;
        let mut written = Vec::new();
        for (sitting, prepared) in self.plan.sittings.iter().zip(&prepared) {
            for specimen in 0..self.request.specimens {
                let suffix = if self.request.specimens > 1 { format!("-s{}", specimen + 1) } else { String::new() };
                let session = Session {
                    rehearsal: self,
                    bench: prepared.bench(self, sitting),
                    prepared,
                    id: &format!("{}-seed{}{suffix}", sitting.id, self.request.seed),
                    folder: &if several { format!("{}{suffix}/", sitting.id) } else { String::new() },
                    specimen,
                    factor: self.factor(specimen),
                };
                written.push(session.write(sink)?);
            }
        }
        Ok(written)
    }

    /// Every fault has something to hit in one sitting at least.
    fn check_faults(&self, prepared: &[Prepared]) -> Result<(), IngestError> {
        for asked in &self.request.faults {
            let mut refused = None;
            for (sitting, prepared) in self.plan.sittings.iter().zip(prepared) {
                let bench = prepared.bench(self, sitting);
                let (id, folder) = (sitting.id.as_str(), "");
                let session = Session { rehearsal: self, bench, prepared, id, folder, specimen: 0, factor: 1.0 };
                match session.can_carry(asked) {
                    Ok(()) => refused = Some(Ok(())),
                    Err(error) => refused = refused.or(Some(Err(error))),
                }
            }
            refused.unwrap_or(Ok(()))?;
        }
        Ok(())
    }

    /// What a specimen makes of every deflection.
    fn factor(&self, specimen: usize) -> f64 {
        let spread = self.plan.specimen.spread;
        1.0 + spread * Normal::new(self.request.seed, &format!("specimen {specimen}")).next()
    }

    fn malformed(&self, line: Option<usize>, item: &str, expected: &str, found: &str, next: &str) -> IngestError {
        IngestError::Malformed {
            place: Place::new(&self.plan.file, line, Some(item.to_owned())),
            expected: expected.to_owned(),
            found: found.to_owned(),
            next: next.to_owned(),
        }
    }

    /// The sentence that stands in every file.
    fn note(&self) -> String {
        format!(
            "SYNTHETIC: rehearsed by pneuval, plan {}, seed {}; no instrument was there",
            self.plan.id, self.request.seed
        )
    }

    fn write_shared(&self, sink: Sink) -> Result<(), IngestError> {
        let note = self.note();
        let noted = |bytes: &[u8]| [format!("# {note}\n").as_bytes(), bytes].concat();
        let mut actuator = noted(&self.actuator_text);
        for model in self.published.iter().flat_map(|published| printed_models(published, &self.plan)) {
            if self.actuator.imported.iter().all(|known| known.file.name != model.file) {
                actuator.extend_from_slice(model.text.as_bytes());
                sink(&model.file, model.table.as_bytes())?;
            }
        }
        for (name, bytes) in &self.actuator_tables {
            sink(name, bytes)?;
        }
        sink("actuator.toml", &actuator)?;
        sink("rig.toml", &noted(&self.rig_text))?;
        self.bounds_text.as_ref().map_or(Ok(()), |bounds| sink("bounds.toml", &noted(bounds.as_bytes())))
    }

    fn prepare(&self, sitting: &Sitting) -> Result<Prepared, IngestError> {
        let sources = Sources {
            actuator: &self.actuator,
            published: self.published.as_ref(),
            file: &self.plan.file,
            folder: self.folder.as_deref(),
        };
        let Visit { groups, settings, setting_ids, levels } = states::visit(sitting, &sources)?;
        let chambers = &sitting.programme.chambers;
        let states = || groups.iter().flat_map(|group| &group.states);
        let full_pa: Vec<f64> =
            (0..chambers.len()).map(|i| states().map(|s| s.pressures_pa[i]).fold(0.0, f64::max)).collect();
        let (mut equilibria, mut deviations) = (Vec::new(), Vec::new());
        for (index, response) in sitting.responses.iter().enumerate() {
            let sets = states::sets_of(response, &settings, &setting_ids);
            let before = &sitting.responses[..index];
            let chamber = response.chambers.first().and_then(|id| chambers.iter().position(|known| known == id));
            let top = chamber.map_or(0.0, |chamber| full_pa[chamber]);
            equilibria.push(sources.equilibrium(response, before, chambers, &sets, top)?);
            deviations.push(bench::deviations(&response.deviation, levels).map_err(|found| {
                let item = format!("deviation of `{}`", response.quantity.id);
                let expected = format!("amounts for the {levels} levels of the programme");
                self.malformed(Some(response.line), &item, &expected, &found, "correct it")
            })?);
        }
        Ok(Prepared { groups, settings, setting_ids, full_pa, equilibria, deviations })
    }
}

/// A sitting with its truths.
struct Prepared {
    groups: Vec<states::Group>,
    settings: Vec<Vec<f64>>,
    setting_ids: Vec<String>,
    full_pa: Vec<f64>,
    equilibria: Vec<Equilibrium>,
    deviations: Vec<Vec<f64>>,
}

impl Prepared {
    fn bench<'a>(&'a self, rehearsal: &'a Rehearsal, sitting: &'a Sitting) -> Bench<'a> {
        Bench {
            plan: &rehearsal.plan,
            sitting,
            rig: &rehearsal.rig,
            equilibria: &self.equilibria,
            deviations: &self.deviations,
            settings: &self.settings,
            setting_ids: &self.setting_ids,
            full_pa: &self.full_pa,
            seed: rehearsal.request.seed,
        }
    }
}

/// What the request changes of the plan.
fn change(plan: &mut Plan, request: &Request) -> Result<(), IngestError> {
    let wrong = |file: &str, item: &str, expected: &str, found: &str, next: String| IngestError::Malformed {
        place: Place::new(file, None, Some(item.to_owned())),
        expected: expected.to_owned(),
        found: found.to_owned(),
        next,
    };
    if let Some(id) = &request.sitting {
        let known: Vec<String> = plan.sittings.iter().map(|sitting| sitting.id.clone()).collect();
        plan.sittings.retain(|sitting| sitting.id == *id);
        if plan.sittings.is_empty() {
            let next = suggestion(id, known.iter().map(String::as_str));
            return Err(wrong(&plan.file, "sitting", "a sitting of the plan", id, next));
        }
    }
    if request.ideal {
        plan.idealise();
    }
    if request.specimens > 1 && plan.specimen.spread == 0.0 && !request.ideal {
        plan.specimen.spread = SPREAD;
    }
    for device in &mut plan.devices {
        if !request.own_clocks {
            (device.offset_s, device.drift) = (0.0, 0.0);
        }
        // Photographs are what they are, and a film is counted in the time of its session.
        if device.camera.is_some() {
            (device.offset_s, device.drift, device.jitter_s) = (0.0, 0.0, 0.0);
        } else if let Some(format) = request.format {
            device.format = format;
        }
    }
    if let Some(kind) = request.programme {
        plan.sittings.iter_mut().for_each(|sitting| sitting.programme.kind = kind);
    }
    for (quantity, truth) in &request.truths {
        let responses = || plan.sittings.iter().flat_map(|sitting| &sitting.responses);
        if responses().all(|response| response.quantity.id != *quantity) {
            let next = suggestion(quantity, responses().map(|response| response.quantity.id.as_str()));
            return Err(wrong(&plan.file, "truth", "a quantity of the plan", quantity, next));
        }
        let mut responses = plan.sittings.iter_mut().flat_map(|sitting| &mut sitting.responses);
        responses.by_ref().filter(|r| r.quantity.id == *quantity).for_each(|r| r.truth = truth.clone());
    }
    Ok(())
}

fn located_folder(folder: &Folder) -> Option<PathBuf> {
    match folder {
        Folder::Disk(path) => Some(path.clone()),
        Folder::Embedded(_) => None,
    }
}
