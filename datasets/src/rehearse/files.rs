//! What devices log, as files in real formats. Every one of them says that it is synthetic, as far as its format can.

use std::io::Cursor;
use std::num::NonZeroUsize;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::{Format, csv, gauge, lvm, mcap, serial, tdms, tracker};
use pneuval_ingest::recording::{Cells, Column, Table};

use super::bench::DeviceLog;
use super::plan::{Plan, Shows};

/// The instant from which stamps of formats count that know absolute ones only: 2026-01-01 00:00 UTC, in s since 1970.
const ORIGIN_S: u64 = 1_767_225_600;

/// Seconds from 1904, from which LabVIEW counts, to 1970.
const S_1904_TO_1970: i64 = 2_082_844_800;

/// Rows of a chunk of a TDMS file, and bytes of one of a bag: small, as the sessions are.
const CHUNK_ROWS: usize = 256;
const CHUNK_BYTES: u64 = 32 << 10;

/// The column of stamps where a format has no name of its own for it.
pub const STAMPS: &str = "t";

/// How bags are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bag {
    /// How messages are encoded.
    pub encoding: mcap::Encoding,
    /// How chunks are compressed.
    pub compression: mcap::Compression,
}

/// A file of a run, not written yet.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFile {
    /// The device that it is called by.
    pub device: String,
    /// Its format.
    pub format: Format,
    /// One table for each device that writes into it.
    pub tables: Vec<Table>,
    /// Devices of the tables, as indices in the plan.
    pub devices: Vec<usize>,
    /// Decimals of its first channel.
    decimals: usize,
}

impl LogFile {
    /// The files of a run: those of devices that share a format of several tables are one.
    pub fn of_run(plan: &Plan, logs: &[DeviceLog]) -> Vec<Self> {
        let mut files: Vec<Self> = Vec::new();
        for log in logs {
            let device = &plan.devices[log.device];
            let table = table(plan, log);
            let shared = files.iter_mut().find(|file| file.format == device.format && holds_several(file.format));
            if let Some(file) = shared {
                file.tables.push(table);
                file.devices.push(log.device);
            } else {
                let devices = vec![log.device];
                let decimals = log.columns.first().map_or(0, |column| plan.channels[column.channel].decimals);
                let device = device.clone();
                files.push(Self { device: device.id, format: device.format, tables: vec![table], devices, decimals });
            }
        }
        files
    }

    /// What `session.toml` calls a column.
    pub fn column_name(&self, table: usize, column: &str) -> String {
        if holds_several(self.format) { self.tables[table].full_name(column) } else { column.to_owned() }
    }

    /// The file's name in a run.
    pub fn name(&self, run: &str, is_only: bool) -> String {
        let ending = match self.format {
            // A folder.
            Format::Pictures if is_only => return run.to_owned(),
            Format::Pictures => return format!("{run}-{}", self.device),
            Format::Mcap => "mcap",
            Format::Tdms => "tdms",
            Format::Lvm => "lvm",
            Format::Trakstar | Format::Serial => "log",
            Format::Gauge => "txt",
            _ => "csv",
        };
        if is_only || holds_several(self.format) {
            return format!("{run}.{ending}");
        }
        format!("{run}-{}.{ending}", self.device)
    }

    /// Its bytes.
    ///
    /// # Errors
    /// As the writers of the formats: for what they cannot hold.
    pub fn bytes(&self, note: &str, bag: Bag) -> Result<Vec<u8>, IngestError> {
        let table = &self.tables[0];
        let text = |text: String| Ok(text.into_bytes());
        match self.format {
            // Photographs are files of their own (`photographs.rs`).
            Format::Csv | Format::Pictures | Format::Plus | Format::Transposed => {
                let options = csv::WriteOptions {
                    delimiter: b',',
                    decimal: Decimal::Point,
                    names: true,
                    units: true,
                    empty_holes: false,
                };
                text(format!("# {note}\n{}", csv::write(&table.columns, options)))
            }
            Format::Serial => {
                let options = serial::WriteOptions { sign: '=', separator: " ", units: true };
                text(format!("# {note}\n{}", serial::write(&table.columns, options)))
            }
            Format::Gauge => {
                let value = table.columns.iter().find(|column| column.name != STAMPS);
                let seconds = table.column(STAMPS).and_then(|column| column.cells.numbers()).unwrap_or_default();
                let (values, unit) = value.map_or((&[][..], ""), |column| {
                    (column.cells.numbers().unwrap_or_default(), column.unit.as_deref().unwrap_or_default())
                });
                let clock = gauge::Clock::Seconds(seconds);
                text(format!("# {note}\n{}", gauge::write(values, unit, self.decimals, clock)))
            }
            Format::Trakstar => text(format!("# {note}\n{}", tracker::write_trakstar(table))),
            Format::Lvm => {
                let options = lvm::WriteOptions { operator: note.to_owned(), ..lvm::WriteOptions::default() };
                let mut bytes = Vec::new();
                lvm::write(&mut bytes, &self.tables, &options)?;
                Ok(bytes)
            }
            Format::Tdms => {
                let file = tdms::Properties::from([
                    ("description".to_owned(), tdms::Value::Text(note.to_owned())),
                    ("synthetic".to_owned(), tdms::Value::Bool(true)),
                ]);
                // An uneven clock is a channel of instants, which readers know for a clock.
                let origin = Some(tdms::Timestamp { seconds: ORIGIN_S.cast_signed() + S_1904_TO_1970, fraction: 0 });
                // Written as it goes, so that a cut costs the end and not whole channels.
                let chunk_rows = NonZeroUsize::new(CHUNK_ROWS);
                let options = tdms::WriteOptions { file, origin, chunk_rows, ..tdms::WriteOptions::default() };
                let mut bytes = Vec::new();
                tdms::write(&mut bytes, &self.tables, &options)?;
                Ok(bytes)
            }
            Format::Mcap => {
                let options = mcap::WriteOptions {
                    encoding: bag.encoding,
                    compression: bag.compression,
                    origin_s: ORIGIN_S,
                    chunk_bytes: Some(CHUNK_BYTES),
                    metadata: vec![(
                        "pneuval".to_owned(),
                        [("synthetic", "true"), ("note", note)].map(|(k, v)| (k.to_owned(), v.to_owned())).into(),
                    )],
                    ..mcap::WriteOptions::default()
                };
                let mut bytes = Cursor::new(Vec::new());
                mcap::write(&mut bytes, &self.tables, &options)?;
                Ok(bytes.into_inner())
            }
        }
    }
}

/// Whether one file of a format holds tables of several devices.
fn holds_several(format: Format) -> bool {
    matches!(format, Format::Mcap | Format::Tdms)
}

/// What a device logs, as a table in the manner of its format.
fn table(plan: &Plan, log: &DeviceLog) -> Table {
    let device = &plan.devices[log.device];
    let numbers = |values: &[f64]| Cells::Numbers(values.to_vec());
    let rows = log.stamps_s.len();
    let mut columns = Vec::new();
    let mut clock = Some(0);
    match device.format {
        Format::Mcap => {
            // The recorder has a clock of its own, and the device's is the publisher's.
            columns.push(Column::new(mcap::LOG_TIME, Some("s"), numbers(&log.true_s)));
            columns.push(Column::new(mcap::PUBLISH_TIME, Some("s"), numbers(&log.stamps_s)));
        }
        Format::Trakstar => return trakstar(plan, log),
        _ => columns.push(Column::new(STAMPS, Some("s"), numbers(&log.stamps_s))),
    }
    for logged in &log.columns {
        let unit = Some(logged.unit.symbol).filter(|symbol| *symbol != "1");
        columns.push(Column::new(&plan.channels[logged.channel].id, unit, numbers(&logged.values)));
    }
    let name = match device.format {
        Format::Mcap => format!("/{}", device.id),
        Format::Tdms => device.id.clone(),
        _ => String::new(),
    };
    if device.format == Format::Mcap {
        clock = Some(1);
    }
    // Tools find a definition by its name: no two devices may share one.
    let schema = (device.format == Format::Mcap).then(|| format!("pneuval_msgs/msg/{}", type_name(&device.id)));
    Table { name, schema, columns, rows, lines: LineMap::default(), clock, decimal: Decimal::Point }
}

/// An id as ROS names types: `force-gauge` is `ForceGauge`.
fn type_name(id: &str) -> String {
    let capital = |word: &str| {
        let mut letters = word.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    };
    format!("Of{}", id.split(|c: char| !c.is_ascii_alphanumeric()).map(capital).collect::<String>())
}

/// The record of a trakSTAR: one sensor, position and angles, time and quality. What no channel shows stands still.
fn trakstar(plan: &Plan, log: &DeviceLog) -> Table {
    let rows = log.stamps_s.len();
    let shown = |component: usize| {
        log.columns.iter().find(|column| {
            let shows = &plan.channels[column.channel].shows;
            matches!(shows, Shows::Quantity(_, index) if *index == component)
        })
    };
    let values = |component: usize| shown(component).map_or_else(|| vec![0.0; rows], |column| column.values.clone());
    let trigger = log.columns.iter().find(|column| plan.channels[column.channel].shows == Shows::Trigger);
    let mut columns: Vec<Column> = TRACKER_COLUMNS
        .iter()
        .map(|(name, component)| {
            let values = component.map_or_else(|| vec![0.0; rows], &values);
            Column::new(name, None, Cells::Numbers(values))
        })
        .collect();
    columns.push(Column::new("time1", Some("s"), Cells::Numbers(log.stamps_s.clone())));
    columns.push(Column::new("quality1", None, Cells::Numbers(vec![1.0; rows])));
    if let Some(trigger) = trigger {
        columns.push(Column::new("button1", None, Cells::Numbers(trigger.values.clone())));
    }
    let clock = columns.iter().position(|column| column.name == "time1");
    Table {
        name: String::new(),
        schema: None,
        columns,
        rows,
        lines: LineMap::default(),
        clock,
        decimal: Decimal::Point,
    }
}

/// A trakSTAR's columns of a pose, and the component that each shows.
const TRACKER_COLUMNS: [(&str, Option<usize>); 6] = [
    ("x1 (mm)", Some(0)),
    ("y1 (mm)", None),
    ("z1 (mm)", Some(1)),
    ("a1 (deg)", None),
    ("e1 (deg)", None),
    ("r1 (deg)", None),
];

/// The column of a channel in the manner of a format.
pub fn column_of(format: Format, shows: &Shows, id: &str) -> String {
    match (format, shows) {
        (Format::Trakstar, Shows::Quantity(_, component)) => TRACKER_COLUMNS
            .iter()
            .find(|(_, shown)| *shown == Some(*component))
            .map_or_else(|| id.to_owned(), |(name, _)| (*name).to_owned()),
        (Format::Trakstar, Shows::Trigger) => "button1".to_owned(),
        _ => id.to_owned(),
    }
}
