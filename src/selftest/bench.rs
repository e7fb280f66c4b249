//! Sessions that are rehearsed and read again without touching a disk: bytes of logs and manifests, as a rig would leave them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread;

use pneuval_datasets::rehearse::{Rehearsal, Request};
use pneuval_ingest::IngestError;
use pneuval_ingest::error::Place;
use pneuval_ingest::manifest::{Rig, SessionManifest};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::session::Session;

use crate::exit::Failure;

/// The files of a rehearsal, by name.
pub type Files = BTreeMap<String, Arc<[u8]>>;

/// The files of a rehearsed plan.
pub fn rehearsed(name: &str, plan: &str, request: Request) -> Result<Files, Failure> {
    let mut files = BTreeMap::new();
    Rehearsal::of_text(name, plan, request)?.write(&mut |name, bytes| {
        files.insert(name.to_owned(), Arc::from(bytes));
        Ok(())
    })?;
    Ok(files)
}

/// The session of these files, its manifest changed.
pub fn load(plan: &str, files: &Files, change: impl Fn(&str) -> String) -> Result<Session, Failure> {
    let file = |name: &str| files.get(name).ok_or_else(|| broken(plan, &format!("no {name}")));
    let text = String::from_utf8_lossy(file("session.toml")?).into_owned();
    let manifest = SessionManifest::read("session.toml", change(&text).as_bytes())?;
    let rig = Rig::read("rig.toml", file("rig.toml")?)?;
    let open = |name: &str| Ok(RawFile::owned(name, Arc::clone(file(name)?)));
    Ok(Session::load(manifest, Some(rig), &open)?)
}

/// The embedded plan is not what a test takes it for.
pub fn broken(plan: &str, found: &str) -> IngestError {
    IngestError::Malformed {
        place: Place::new(plan, None, None),
        expected: "a session as the plan says".to_owned(),
        found: found.to_owned(),
        next: "tell the authors".to_owned(),
    }
}

/// What every seed from 1 on gives, in the order of seeds, on as many threads as there are cores.
pub fn of_seeds<T: Send>(seeds: u32, trial: &(dyn Fn(u32) -> Result<T, Failure> + Sync)) -> Result<Vec<T>, Failure> {
    let workers = thread::available_parallelism().map_or(1, std::num::NonZero::get).min(16);
    let of_worker = |worker: usize| -> Result<Vec<(u32, T)>, Failure> {
        (1..=seeds).filter(|seed| *seed as usize % workers == worker).map(|seed| Ok((seed, trial(seed)?))).collect()
    };
    let mut trials = thread::scope(|scope| {
        let handles: Vec<_> = (0..workers).map(|worker| scope.spawn(move || of_worker(worker))).collect();
        let mut all = Vec::new();
        for handle in handles {
            // A worker that panics is a defect of this program.
            all.extend(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
        }
        Ok::<_, Failure>(all)
    })?;
    trials.sort_by_key(|(seed, _)| *seed);
    Ok(trials.into_iter().map(|(_, trial)| trial).collect())
}
