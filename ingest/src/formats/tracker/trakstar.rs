//! trakSTAR logs: positions, angles, time and quality of every sensor, with and without a header.
//!
//! Two orders of columns occur. All sensors on one line, eight cells each, make one table with columns `x1 y1 z1 a1 e1 r1 time1
//! quality1`; one line per sensor and record makes a table per sensor, `sensor 1`. Angles are azimuth, elevation and roll in degrees.
//!
//! The instrument gives positions as multiples of its range over 2^15 (36 in; 72 in is twice that), whatever length they are written
//! in. Where no unit is stated, the unit in which all of them are such multiples is inferred, and told.

mod grid;
mod layout;

use super::TrackerOptions;
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{Places, as_text};
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::csv::{Decimal, parse_number};
use crate::formats::lines::{Line, Lines, cells, trim};
use crate::formats::sheet::{OddLines, Sheet};
use crate::formats::stamps::{seconds_of, utc_second, wrap_finding};
use crate::formats::text_head;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording, full_name};
use grid::{AngleGrid, LengthGrid};
use layout::{Layout, Role};

/// Seconds since 1970 from which on a time is a date: 2001.
const EPOCH_S: f64 = 1e9;

/// Whether a text is a trakSTAR log, by its first bytes: its header names position and angles of a sensor, or its lines hold them in
/// one of the orders that occur.
pub fn looks_like(head: &[u8], is_whole: bool) -> bool {
    Layout::of(head, is_whole).is_some()
}

/// Reads a trakSTAR log.
///
/// # Errors
/// [`IngestError::Unusable`] if its first lines are not in one of the known orders, and for sizes beyond [`crate::limits`];
/// [`IngestError::Read`].
pub fn read(raw: &RawFile, options: TrackerOptions, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let head = text_head(raw)?;
    let Some(layout) = Layout::of(&head.bytes, head.is_whole) else {
        return Err(IngestError::Unusable {
            place: Place::new(file, None, None),
            expected: "x, y, z, azimuth, elevation and roll of each sensor, with or without a header".to_owned(),
            found: "other columns".to_owned(),
            next: "is this a trakSTAR log? Other delimited text is read as `csv`".to_owned(),
        });
    };
    let mut reading = Reading::new(file, &layout, options, keep)?;
    let mut lines = Lines::of(raw)?;
    let mut metadata = Vec::new();
    while let Some(line) = lines.next()? {
        if line.number < layout.data_line {
            if Some(line.number) != layout.names_line && !line.bytes.trim_ascii().is_empty() {
                metadata.push(as_text(trim(line.bytes)));
            }
            continue;
        }
        if !line.bytes.trim_ascii().is_empty() {
            // The cells borrow the line.
            let mut parts = Vec::with_capacity(layout.fields.len());
            layout.cells(line.bytes, &mut parts);
            reading.line(line, &mut parts)?;
        }
    }
    let lines_map = reading.tables.first().map(|t| t.sheet.lines().clone()).unwrap_or_default();
    let end = lines.end_findings(&lines_map);
    let mut recording = reading.finish(end);
    recording.metadata = metadata;
    Ok(recording)
}

/// A table while it is read.
struct Tracked<'a> {
    name: String,
    sheet: Sheet<'a>,
    /// Column of each field of a line.
    columns: Vec<Option<usize>>,
    clocks: Vec<Clock>,
    angles: Vec<(usize, f64, Places)>,
    /// Field of the quality and the fields it speaks of, by sensor.
    masks: Vec<(usize, Vec<usize>)>,
    /// Smallest and largest quality of each of the masks.
    qualities: Vec<Option<(f64, f64)>>,
    /// The last position of each field, so that a sensor at rest is counted once.
    last: Vec<f64>,
}

/// A column of stamps while it is read.
struct Clock {
    field: usize,
    before: Option<f64>,
    days: f64,
    wraps: Vec<usize>,
}

struct Reading<'a> {
    file: &'a str,
    layout: &'a Layout,
    options: TrackerOptions,
    tables: Vec<Tracked<'a>>,
    odd: OddLines,
    lengths: LengthGrid,
    angles: AngleGrid,
    /// Whole seconds since 1970 from which stamps count, and whether their zone is stated.
    origin_s: Option<f64>,
}

impl<'a> Reading<'a> {
    fn new(file: &'a str, layout: &'a Layout, options: TrackerOptions, keep: Keep<'a>) -> Result<Self, IngestError> {
        let names: Vec<String> = match &layout.sensors {
            Some(sensors) => sensors.iter().map(|id| format!("sensor {id}")).collect(),
            None => vec![String::new()],
        };
        let mut tables = Vec::with_capacity(names.len());
        for name in names {
            let mut sheet = Sheet::new(file, &name, keep);
            let mut columns = Vec::with_capacity(layout.fields.len());
            let mut tracked_angles = Vec::new();
            let mut clocks = Vec::new();
            for (index, field) in layout.fields.iter().enumerate() {
                let unit = match (field.role, &field.unit) {
                    (_, Some(unit)) => Some(unit.as_str()),
                    (Role::Angle(_), None) => Some("deg"),
                    _ => None,
                };
                columns.push(match field.role {
                    Role::Sensor => None,
                    Role::Word => Some(sheet.text(&field.name)?),
                    Role::Time => Some(sheet.stamps(&field.name, unit)?),
                    _ => Some(sheet.numbers(&field.name, unit, true)?),
                });
                match field.role {
                    // Elevation ends at ±90 deg and goes back.
                    Role::Angle(0 | 2) => tracked_angles.push((index, f64::NAN, Places::default())),
                    Role::Time => clocks.push(Clock { field: index, before: None, days: 0.0, wraps: Vec::new() }),
                    _ => {}
                }
            }
            let masks = layout.masks();
            let qualities = vec![None; masks.len()];
            let last = vec![f64::NAN; layout.fields.len()];
            tables.push(Tracked { name, sheet, columns, clocks, angles: tracked_angles, masks, qualities, last });
        }
        Ok(Self {
            file,
            layout,
            options,
            tables,
            odd: OddLines::default(),
            lengths: LengthGrid::default(),
            angles: AngleGrid::default(),
            origin_s: None,
        })
    }

    fn line(&mut self, line: Line, parts: &mut Vec<&[u8]>) -> Result<(), IngestError> {
        let layout = self.layout;
        let rows = self.tables.iter().map(|t| t.sheet.rows()).max().unwrap_or(0);
        if trim(line.bytes) == layout.names_raw.as_slice() && layout.names_line.is_some() {
            self.odd.add(FindingKind::RepeatedHeader, rows, line);
            return Ok(());
        }
        let numbers = parts.iter().filter(|cell| parse_number(cell, layout.decimal).is_some()).count();
        let sensor = layout.fields.iter().position(|f| f.role == Role::Sensor);
        let index = match (&layout.sensors, sensor) {
            (Some(sensors), Some(field)) => {
                let id = parts.get(field).copied().unwrap_or_default();
                sensors.iter().position(|known| known.as_bytes() == id)
            }
            _ => Some(0),
        };
        // Words, or a sensor that none of the first lines knows.
        let (Some(index), true) = (index, numbers * 2 >= parts.len().min(layout.fields.len())) else {
            self.odd.add(FindingKind::SkippedLine, rows, line);
            return Ok(());
        };
        let Some(table) = self.tables.get_mut(index) else { return Ok(()) };
        let row = table.sheet.rows();
        if !self.odd.fit(self.file, parts, layout.fields.len(), row, line) {
            return Ok(());
        }
        for (field, cell) in parts.iter().enumerate() {
            let (Some(Some(column)), Some(known)) = (table.columns.get(field), layout.fields.get(field)) else {
                continue;
            };
            match known.role {
                Role::Time => {
                    self.origin_s = table.stamp(field, *column, cell, layout.decimal, line.number, self.origin_s);
                }
                Role::Position => {
                    table.sheet.cell(*column, cell, layout.decimal, line.number);
                    let value = table.sheet.get(*column);
                    if known.unit.is_none() && table.is_new(field, value) {
                        self.lengths.add(cell, layout.decimal);
                    }
                }
                Role::Angle(_) => {
                    table.sheet.cell(*column, cell, layout.decimal, line.number);
                    let value = table.sheet.get(*column);
                    if table.is_new(field, value) {
                        self.angles.add(cell, layout.decimal);
                    }
                }
                _ => table.sheet.cell(*column, cell, layout.decimal, line.number),
            }
        }
        table.watch_angles(line.number);
        table.mask(self.options.quality_max, line.number);
        // Cells that are missing are told with the line.
        table.sheet.end_row(line.number, false)
    }

    fn finish(self, end: Vec<Finding>) -> Recording {
        let Self { file, layout, options, tables, odd, lengths, angles, origin_s } = self;
        let mut findings = odd.finish(file, layout.fields.len());
        findings.extend(end);
        let mut reasons = layout.reasons.clone();
        let inferred = lengths.unit();
        let states_unit = layout.fields.iter().any(|f| f.role == Role::Position && f.unit.is_some());
        match (&inferred, states_unit) {
            (Some(found), _) => {
                let count = layout.fields.iter().filter(|f| f.role == Role::Position).count();
                let step = match found.multiple {
                    1 => "the step".to_owned(),
                    many => format!("{many} times the step"),
                };
                let text = format!(
                    "the unit {} of the positions is inferred, the file states none: all of them are multiples of {} {}, \
                     {step} of a trakSTAR of 36 in range (36 in / 32768)",
                    found.unit,
                    grid::shown_step(found.step * found.multiple as f64),
                    found.unit,
                );
                reasons.push(text.clone());
                let mut finding =
                    Places::default().finding(FindingKind::InferredUnit, Severity::Note, file, None, text);
                finding.count = count;
                findings.push(finding);
            }
            (None, true) => {}
            (None, false) => reasons.push(
                "no unit is stated for the positions, and in none of in, cm, mm and m are they multiples of a \
                 trakSTAR's step to more than their digits allow: the unit is left open"
                    .to_owned(),
            ),
        }
        if let Some(step) = angles.step_deg() {
            reasons.push(format!("angles are multiples of {step} deg"));
        }
        let mut out = Vec::with_capacity(tables.len());
        for tracked in tables {
            let (table, told) = tracked.finish(file, layout, inferred.as_ref().map(|f| f.unit), options, &mut reasons);
            findings.extend(told);
            out.push(table);
        }
        let origin = origin_s.map(|s| utc_second(s, layout.is_utc));
        Recording {
            format: "trakSTAR log",
            tables: out,
            findings,
            reasons,
            metadata: Vec::new(),
            origin,
            photographs: vec![],
        }
    }
}

impl Tracked<'_> {
    /// A stamp: a time of day or date, or a number of seconds. The origin, which the first date sets.
    fn stamp(
        &mut self,
        field: usize,
        column: usize,
        cell: &[u8],
        decimal: Decimal,
        line: usize,
        origin_s: Option<f64>,
    ) -> Option<f64> {
        let row = self.sheet.rows();
        let number = parse_number(cell, decimal).filter(|n| n.is_finite());
        let stamp = number.map(|n| (n, n >= EPOCH_S)).or_else(|| std::str::from_utf8(cell).ok().and_then(seconds_of));
        let Some((seconds, is_absolute)) = stamp else {
            self.sheet.cell(column, cell, decimal, line);
            return origin_s;
        };
        self.sheet.set_unit_if_none(column, if number.is_some() && !is_absolute { None } else { Some("s") });
        if is_absolute {
            let origin = origin_s.unwrap_or(seconds.floor());
            self.sheet.date(column);
            self.sheet.put(column, seconds - origin);
            return Some(origin);
        }
        let mut seconds = seconds;
        if number.is_none()
            && let Some(clock) = self.clocks.iter_mut().find(|c| c.field == field)
        {
            // Half a day back is no clock that was set: it is midnight.
            if clock.before.is_some_and(|before| before - seconds > 43_200.0) {
                clock.days += 86_400.0;
                clock.wraps.push(row);
            }
            clock.before = Some(seconds);
            seconds += clock.days;
        }
        self.sheet.put(column, seconds);
        origin_s
    }

    /// Whether a field holds another number than on the line before: a sensor at rest says nothing new.
    #[expect(clippy::float_cmp)]
    fn is_new(&mut self, field: usize, value: f64) -> bool {
        let Some(last) = self.last.get_mut(field) else { return false };
        let is_new = value.is_finite() && value != *last;
        *last = value;
        is_new
    }

    fn watch_angles(&mut self, line: usize) {
        let row = self.sheet.rows();
        for (field, before, places) in &mut self.angles {
            let Some(Some(column)) = self.columns.get(*field) else { continue };
            let angle = self.sheet.get(*column);
            if angle.is_finite() {
                if (angle - *before).abs() > 180.0 {
                    places.add_said(row, line, || format!("{before} to {angle} deg"));
                }
                *before = angle;
            }
        }
    }

    /// Makes holes of a pose whose quality number is above the limit.
    fn mask(&mut self, quality_max: Option<u32>, line: usize) {
        for ((quality, poses), range) in self.masks.iter().zip(&mut self.qualities) {
            let Some(Some(column)) = self.columns.get(*quality) else { continue };
            let value = self.sheet.get(*column);
            if !value.is_finite() {
                continue;
            }
            let (low, high) = range.unwrap_or((value, value));
            *range = Some((low.min(value), high.max(value)));
            if quality_max.is_some_and(|max| value > f64::from(max)) {
                for pose in poses {
                    if let Some(Some(column)) = self.columns.get(*pose) {
                        self.sheet.hole(*column, FindingKind::LowQuality, line, value.to_string().as_bytes());
                    }
                }
            }
        }
    }

    fn finish(
        self,
        file: &str,
        layout: &Layout,
        unit: Option<&str>,
        options: TrackerOptions,
        reasons: &mut Vec<String>,
    ) -> (crate::recording::Table, Vec<Finding>) {
        let Self { name, mut sheet, columns, clocks, angles, masks, qualities, .. } = self;
        let channel = |field: usize| layout.fields.get(field).map(|f| full_name(&name, &f.name)).unwrap_or_default();
        if let Some(unit) = unit {
            for (field, column) in layout.fields.iter().zip(&columns) {
                if let (Role::Position, None, Some(column)) = (field.role, &field.unit, column) {
                    sheet.set_unit(*column, unit);
                }
            }
        }
        for ((quality, _), range) in masks.iter().zip(qualities) {
            let Some((low, high)) = range else { continue };
            let used = match options.quality_max {
                Some(max) => format!("poses above {max} are holes"),
                None => "all are used".to_owned(),
            };
            let quality = shown(&channel(*quality));
            reasons
                .push(format!("column {quality}: quality numbers from {low} to {high}, the larger the worse; {used}"));
        }
        let mut findings = Vec::new();
        for (field, _, places) in angles {
            if places.count() > 0 {
                let channel = channel(field);
                let jumps = places.counted("jump", "jumps");
                let listed = places.listed();
                let text = format!(
                    "column {}: {jumps} across ±180 deg {listed}; left as written, means and interpolation across it are wrong",
                    shown(&channel)
                );
                findings.push(places.finding(FindingKind::AngleWrap, Severity::Note, file, Some(&channel), text));
            }
        }
        for clock in &clocks {
            findings.extend(wrap_finding(file, &channel(clock.field), &clock.wraps, sheet.lines()));
        }
        let clock = clocks.first().and_then(|clock| columns.get(clock.field).copied().flatten());
        let (mut table, mut cells) = sheet.finish();
        table.clock = clock;
        cells.append(&mut findings);
        (table, cells)
    }
}

/// The cells of a line; `[0]` and `3.1:` as sample programs print them hold no more than the number.
fn plain_cells<'b>(line: &'b [u8], delimiter: u8, out: &mut Vec<&'b [u8]>) {
    cells(line, delimiter, out);
    if delimiter == b' ' {
        out.retain(|cell| *cell != b":");
        for cell in out.iter_mut() {
            let inside = cell.strip_prefix(b"[").unwrap_or(cell);
            let inside = inside.strip_suffix(b":").unwrap_or(inside);
            *cell = inside.strip_suffix(b"]").unwrap_or(inside);
        }
    }
}
