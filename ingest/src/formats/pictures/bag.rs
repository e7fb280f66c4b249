//! The pictures of a topic of a bag, each with the stamp of its message.
//!
//! Messages are read one after the other; as many pictures as there are threads, twice over, are decoded and measured side by side. In the
//! recording of the bag the table of the topic becomes that of what was measured.

use rayon::prelude::*;

use super::PictureOptions;
use super::measured::{self, Row, Sheet};
use crate::IngestError;
use crate::camera::decode::decode;
use crate::camera::photograph::{Photograph, SHOWN_MAX};
use crate::camera::picture::Picture;
use crate::camera::rows::{self, Rows};
use crate::formats::mcap::{self, Frame, FrameKind};
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

/// A picture that waits to be measured.
struct Waiting {
    sample: usize,
    bytes: Vec<u8>,
    /// How rows of pixels lie; `None`: the bytes are a file of a picture.
    rows: Option<Layout>,
}

struct Layout {
    encoding: String,
    size: (u32, u32),
    step: u32,
    big_endian: bool,
}

/// Stamps of a message, in s from the origin of the recording.
struct Stamps {
    header: f64,
    log: f64,
    publish: f64,
}

/// Measures the pictures of the topic that the options name, in place of the table of its messages.
///
/// # Errors
/// [`IngestError::Malformed`] if there is no such topic, or it holds no pictures; those of [`mcap::read`].
pub fn with_topic(
    raw: &RawFile,
    mut recording: Recording,
    options: &PictureOptions,
    keep: Keep,
) -> Result<Recording, IngestError> {
    let (Some(topic), Some(task)) = (&options.topic, &options.task) else { return Ok(recording) };
    let batch = 2 * rayon::current_num_threads().max(1);
    let (mut waiting, mut stamps, mut all) = (Vec::with_capacity(batch), Vec::new(), Vec::new());
    // How many pictures there are is known at the end: as many are shown as lie so far apart, and the step doubles with them.
    let mut every = 1;
    let mut measure = |waiting: &mut Vec<Waiting>, all: &mut Vec<Row>| {
        let one = |(k, waiting): (usize, &Waiting)| {
            let shown = (all.len() + k).is_multiple_of(every).then_some(all.len() + k);
            Row::new(&format!("{topic} #{}", waiting.sample), waiting.picture(), Some(task), shown)
        };
        let measured: Vec<Row> = waiting.par_iter().enumerate().map(one).collect();
        all.extend(measured);
        waiting.clear();
        every = thinned(all, every);
    };
    mcap::frames(raw, topic, &mut |frame| {
        stamps.push(Stamps { header: frame.stamp_s, log: frame.log_time_s, publish: frame.publish_time_s });
        waiting.push(Waiting::of(&frame));
        if waiting.len() == batch {
            measure(&mut waiting, &mut all);
        }
        Ok(())
    })?;
    measure(&mut waiting, &mut all);
    let mut sheet = Sheet::new(topic, all.len(), keep);
    let log = sheet.add_stamps(mcap::LOG_TIME, |i| stamps[i].log);
    let publish = sheet.add_stamps(mcap::PUBLISH_TIME, |i| stamps[i].publish);
    let header = sheet.add_stamps("header.stamp", |i| stamps[i].header);
    let mut findings = measured::broken(raw.name(), &all);
    findings.extend(measured::add(&mut sheet, raw.name(), &all, Some(task)));
    let before = recording.tables.iter().position(|table| table.name == *topic);
    let known = before.map(|i| recording.tables.remove(i));
    // Which of its stamps is the clock was found out with all its messages.
    let name = known.as_ref().and_then(|table| Some(table.columns.get(table.clock?)?.name.clone()));
    let clock = match name.as_deref() {
        Some(name) if name == mcap::PUBLISH_TIME => publish,
        Some(name) if name == mcap::LOG_TIME => log,
        _ => header,
    };
    let mut table = sheet.finish(known.and_then(|table| table.schema), Some(clock));
    for column in &mut table.columns[..=header] {
        column.is_dated = true;
    }
    let photographs = all.into_iter().filter_map(|row| row.photograph);
    recording.photographs.extend(photographs.map(|shown| Photograph { table: topic.clone(), ..shown }));
    recording.reasons.push(format!("{} pictures of {topic} measured, each at the stamp of its message", table.rows));
    recording.tables.insert(before.unwrap_or(0), table);
    recording.findings.extend(findings);
    Ok(recording)
}

/// Leaves every second picture that is shown, until they are few enough.
fn thinned(all: &mut [Row], mut every: usize) -> usize {
    while all.iter().filter(|row| row.photograph.is_some()).count() > SHOWN_MAX {
        every *= 2;
        all.iter_mut().enumerate().filter(|(i, _)| !i.is_multiple_of(every)).for_each(|(_, row)| row.photograph = None);
    }
    every
}

impl Waiting {
    fn of(frame: &Frame) -> Self {
        let rows = match frame.kind {
            FrameKind::Compressed { .. } => None,
            FrameKind::Raw { encoding, width, height, step, big_endian } => {
                Some(Layout { encoding: encoding.to_owned(), size: (width, height), step, big_endian })
            }
        };
        Self { sample: frame.sample, bytes: frame.data.to_vec(), rows }
    }

    fn picture(&self) -> Result<Picture, String> {
        let Some(Layout { encoding, size: (width, height), step, big_endian }) = &self.rows else {
            return decode(&self.bytes).map_err(|broken| broken.to_string());
        };
        rows::picture(Rows {
            encoding,
            width: *width,
            height: *height,
            step: *step,
            big_endian: *big_endian,
            data: &self.bytes,
        })
    }
}
