//! Sequence files of the PLUS toolkit (`.igs.mha`, `.mha`, `.mhd`): tool transforms, their status and stamps.
//!
//! Only the header is read; pixels never are. A transform is sixteen numbers, row by row, of a 4 × 4 matrix; it becomes a position
//! and, if its upper left is a rotation, a quaternion. PLUS holds positions in mm by convention
//! (<http://perk-software.cs.queensu.ca/plus/doc/nightly/user/FileSequenceFile.html>); the file itself states no unit.

use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{Places, as_text, told};
use crate::finding::{FindingKind, Severity};
use crate::formats::csv::{Decimal, parse_number};
use crate::formats::lines::{Lines, trim};
use crate::formats::sheet::Sheet;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

/// How far a rotation matrix times its transpose may be from the identity: matrices are written with six digits.
const ROTATION_ERROR_MAX: f64 = 1e-3;

const POSE: [&str; 7] = ["x", "y", "z", "qx", "qy", "qz", "qw"];

/// Whether a text is the header of such a file, by its first bytes.
pub fn looks_like(head: &[u8]) -> bool {
    let lines = || head.split(|b| matches!(b, b'\n' | b'\r')).take(200).map(trim);
    let key = |line: &[u8], word: &[u8]| line.strip_prefix(word).is_some_and(|rest| trim(rest).starts_with(b"="));
    let is_meta =
        lines().find(|line| !line.is_empty()).is_some_and(|line| key(line, b"ObjectType") || key(line, b"NDims"));
    is_meta && lines().any(|line| frame_field(line).is_some() || key(line, b"CustomFrameFieldNames"))
}

/// Frame, field and value of a line `Seq_Frame0003_Timestamp = 2.5`.
fn frame_field(line: &[u8]) -> Option<(u64, &[u8], &[u8])> {
    let rest = line.strip_prefix(b"Seq_Frame")?;
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let (number, rest) = rest.split_at_checked(digits)?;
    let number = std::str::from_utf8(number).ok()?.parse().ok()?;
    let rest = rest.strip_prefix(b"_")?;
    let equals = rest.iter().position(|b| *b == b'=')?;
    let (field, value) = rest.split_at_checked(equals)?;
    Some((number, trim(field), trim(value.get(1..)?)))
}

/// Reads the frames of a sequence file.
///
/// # Errors
/// [`IngestError::Unusable`] if there is no frame, and for sizes beyond [`crate::limits`]; [`IngestError::Read`].
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let mut reading = Reading::new(raw.name(), keep);
    let mut lines = Lines::of(raw)?;
    let mut is_whole = false;
    while let Some(line) = lines.next()? {
        let bytes = trim(line.bytes);
        if !line.is_ended && !bytes.starts_with(b"ElementDataFile") {
            reading.cut = Some(line.number);
        } else if let Some((frame, field, value)) = frame_field(bytes) {
            reading.field(frame, field, value, line.number)?;
        } else if !bytes.is_empty() {
            is_whole = bytes.strip_prefix(b"ElementDataFile").is_some_and(|rest| trim(rest).starts_with(b"="));
            reading.header(bytes, line.number);
            // Pixels follow.
            if is_whole {
                break;
            }
        }
    }
    let end = if is_whole { Vec::new() } else { lines.end_findings(reading.sheet.lines()) };
    let mut recording = reading.finish(is_whole)?;
    recording.findings.extend(end);
    Ok(recording)
}

/// What a field of a frame becomes.
enum Target {
    /// The first of the seven columns of a pose.
    Pose(usize),
    Number(usize),
    /// The status of the transform of a name.
    Status(String),
}

struct Reading<'a> {
    file: &'a str,
    sheet: Sheet<'a>,
    targets: Vec<(Vec<u8>, Target)>,
    /// The frame that is being filled, and its first line.
    frame: Option<(u64, usize)>,
    /// Transforms of this frame whose status is not `OK`: what it is, and where it stands.
    bad: Vec<(String, Vec<u8>, usize)>,
    frames_seen: u64,
    odd_lines: Places,
    apart: Places,
    missing_frames: Places,
    skipped_counts: Places,
    last_count: Option<f64>,
    no_rotation: Places,
    stated: Option<(u64, usize)>,
    cut: Option<usize>,
    metadata: Vec<String>,
}

impl<'a> Reading<'a> {
    fn new(file: &'a str, keep: Keep<'a>) -> Self {
        Self {
            file,
            sheet: Sheet::new(file, "", keep),
            targets: Vec::new(),
            frame: None,
            bad: Vec::new(),
            frames_seen: 0,
            odd_lines: Places::default(),
            apart: Places::default(),
            missing_frames: Places::default(),
            skipped_counts: Places::default(),
            last_count: None,
            no_rotation: Places::default(),
            stated: None,
            cut: None,
            metadata: Vec::new(),
        }
    }

    fn header(&mut self, line: &[u8], number: usize) {
        if let Some(sizes) = line.strip_prefix(b"DimSize").map(trim).and_then(|rest| rest.strip_prefix(b"=")) {
            let last = sizes.split(|b| *b == b' ').rfind(|word| !word.is_empty());
            let frames = last.and_then(|word| std::str::from_utf8(word).ok()).and_then(|word| word.parse().ok());
            self.stated = frames.map(|frames| (frames, number));
        }
        // Free text, but not without end.
        if self.metadata.len() < 1000 {
            self.metadata.push(as_text(line));
        }
    }

    fn field(&mut self, frame: u64, field: &[u8], value: &[u8], line: usize) -> Result<(), IngestError> {
        match self.frame {
            Some((current, _)) if current == frame => {}
            Some((current, _)) if frame < current => {
                // A frame that was ended already.
                self.apart.add(self.sheet.rows(), line, field);
                return Ok(());
            }
            current => {
                self.end_frame()?;
                let expected = current.map_or(0, |(before, _)| before + 1);
                if frame > expected {
                    let what = || format!("frame {expected} expected, frame {frame} found");
                    self.missing_frames.add_said(self.sheet.rows(), line, what);
                }
                self.frame = Some((frame, line));
            }
        }
        let index = if let Some(index) = self.targets.iter().position(|(known, _)| known == field) {
            index
        } else {
            let target = self.target(field, value)?;
            self.targets.push((field.to_vec(), target));
            self.targets.len() - 1
        };
        let row = self.sheet.rows();
        match self.targets.get(index) {
            Some((_, Target::Pose(first))) => {
                let first = *first;
                if let Some(pose) = pose(value) {
                    let (position, quaternion) = pose;
                    for (offset, number) in position.iter().enumerate() {
                        self.sheet.put(first + offset, *number);
                    }
                    match quaternion {
                        Ok(quaternion) => quaternion.iter().enumerate().for_each(|(offset, number)| {
                            self.sheet.put(first + 3 + offset, *number);
                        }),
                        Err(error) => {
                            (3..7).for_each(|offset| self.sheet.put(first + offset, f64::NAN));
                            let what = || format!("off by {error:.3}");
                            self.no_rotation.add_said(row, line, what);
                        }
                    }
                } else {
                    (0..7).for_each(|offset| {
                        self.sheet.hole(first + offset, FindingKind::NonNumericCell, line, value);
                    });
                }
            }
            Some((_, Target::Number(column))) => self.sheet.cell(*column, value, Decimal::Point, line),
            Some((_, Target::Status(transform))) => {
                if value != b"OK" {
                    self.bad.push((transform.clone(), value.to_vec(), line));
                }
            }
            None => self.odd_lines.add(row, line, field),
        }
        Ok(())
    }

    fn target(&mut self, field: &[u8], value: &[u8]) -> Result<Target, IngestError> {
        let name = as_text(field);
        if let Some(transform) = name.strip_suffix("Status") {
            return Ok(Target::Status(transform.strip_suffix("Transform").unwrap_or(transform).to_owned()));
        }
        if let Some(transform) = name.strip_suffix("Transform") {
            let mut first = None;
            for part in POSE {
                let unit = matches!(part, "x" | "y" | "z").then_some("mm");
                let column = self.sheet.numbers(&format!("{transform}.{part}"), unit, true)?;
                first.get_or_insert(column);
            }
            return Ok(Target::Pose(first.unwrap_or(0)));
        }
        let unit = matches!(name.as_str(), "Timestamp" | "UnfilteredTimestamp").then_some("s");
        let is_number = unit.is_some() || name == "FrameNumber" || parse_number(value, Decimal::Point).is_some();
        let column = if is_number { self.sheet.numbers(&name, unit, true)? } else { self.sheet.text(&name)? };
        Ok(Target::Number(column))
    }

    /// The column of a field of numbers.
    fn column(&self, field: &str) -> Option<usize> {
        self.targets.iter().find_map(|(known, target)| match target {
            Target::Number(column) if known == field.as_bytes() => Some(*column),
            _ => None,
        })
    }

    fn end_frame(&mut self) -> Result<(), IngestError> {
        let Some((_, line)) = self.frame.take() else { return Ok(()) };
        let row = self.sheet.rows();
        for (transform, status, status_line) in std::mem::take(&mut self.bad) {
            let field = format!("{transform}Transform");
            let pose = self.targets.iter().find_map(|(known, target)| match target {
                Target::Pose(first) if known == field.as_bytes() => Some(*first),
                _ => None,
            });
            if let Some(first) = pose {
                (0..7).for_each(|offset| {
                    self.sheet.hole(first + offset, FindingKind::LowQuality, status_line, &status);
                });
            }
        }
        if let Some(column) = self.column("FrameNumber") {
            let count = self.sheet.get(column);
            if let Some(before) = self.last_count
                && count.is_finite()
                && (count - before - 1.0).abs() > 0.5
            {
                self.skipped_counts.add_said(row, line, || format!("{before} to {count}"));
            }
            if count.is_finite() {
                self.last_count = Some(count);
            }
        }
        self.frames_seen += 1;
        self.sheet.end_row(line, true)
    }

    fn finish(mut self, is_whole: bool) -> Result<Recording, IngestError> {
        self.end_frame()?;
        let file = self.file;
        let clock = self.column("Timestamp");
        let rows = self.sheet.rows();
        if rows == 0 {
            return Err(IngestError::Unusable {
                place: Place::new(file, None, None),
                expected: "frames of a PLUS sequence file: lines `Seq_Frame0000_... = ...`".to_owned(),
                found: "none".to_owned(),
                next: "was the sequence recorded with a tracker? Images alone are not read as logs".to_owned(),
            });
        }
        let mut findings = Vec::new();
        let last = self.sheet.lines().line_of(rows - 1);
        if !is_whole {
            let at = self.cut.unwrap_or(last);
            let text = format!(
                "the file ends within its header, at line {at}: frame {rows}, the last, may lack fields; what followed is lost"
            );
            findings.push(told(FindingKind::Truncated, Severity::Lost, file, rows, at, text));
        }
        if let Some((stated, line)) = self.stated
            && stated != self.frames_seen
        {
            let severity = if stated > self.frames_seen { Severity::Lost } else { Severity::Note };
            let text = format!("line {line} states {stated} frames, {} are there", self.frames_seen);
            findings.push(told(FindingKind::HeaderMismatch, severity, file, rows, line, text));
        }
        let mut tell = |places: Places, kind, severity, text: &dyn Fn(&Places) -> String| {
            if places.count() > 0 {
                let text = text(&places);
                findings.push(places.finding(kind, severity, file, None, text));
            }
        };
        tell(self.missing_frames, FindingKind::Gap, Severity::Lost, &|places| {
            format!("frames of the sequence are missing at {} {}", places.counted("place", "places"), places.listed())
        });
        tell(self.skipped_counts, FindingKind::Gap, Severity::Note, &|places| {
            format!(
                "FrameNumber, the tracker's own count, does not go up by one at {} {}: frames were not recorded",
                places.counted("place", "places"),
                places.listed()
            )
        });
        tell(self.apart, FindingKind::SkippedLine, Severity::Excluded, &|places| {
            format!(
                "{} of a frame that was ended before {}; left out",
                places.counted("line", "lines"),
                places.listed()
            )
        });
        tell(self.odd_lines, FindingKind::SkippedLine, Severity::Excluded, &|places| {
            format!("{} not understood {}; left out", places.counted("line", "lines"), places.listed())
        });
        tell(self.no_rotation, FindingKind::NotRotation, Severity::Excluded, &|places| {
            format!(
                "{} no rotation {}: the orientation is a hole, the position is kept",
                places.counted("matrix is", "matrices are"),
                places.listed()
            )
        });
        let (mut table, cells) = self.sheet.finish();
        findings.extend(cells);
        table.clock = clock;
        let transforms: Vec<String> = self
            .targets
            .iter()
            .filter(|(_, target)| matches!(target, Target::Pose(_)))
            .map(|(field, _)| shown(&as_text(field)))
            .collect();
        let mut reasons =
            vec![format!("a sequence file of the PLUS toolkit with the transforms {}", transforms.join(", "))];
        reasons.push("positions are in mm by the convention of the PLUS toolkit; the file states no unit".to_owned());
        Ok(Recording {
            format: "PLUS sequence",
            tables: vec![table],
            findings,
            reasons,
            metadata: self.metadata,
            origin: None,
            photographs: vec![],
        })
    }
}

/// A position, and a quaternion or how far the matrix is from a rotation.
type Pose = ([f64; 3], Result<[f64; 4], f64>);

/// Position and quaternion of a matrix, or how far it is from a rotation; `None` if it is not sixteen numbers of a transform.
fn pose(value: &[u8]) -> Option<Pose> {
    let mut matrix = [0.0; 16];
    let mut words = value.split(|b| matches!(b, b' ' | b'\t')).filter(|word| !word.is_empty());
    for element in &mut matrix {
        *element = parse_number(words.next()?, Decimal::Point).filter(|n| n.is_finite())?;
    }
    let [r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z, b0, b1, b2, one] = matrix;
    let is_affine = [b0, b1, b2, one - 1.0].iter().all(|v| v.abs() < 1e-9);
    if words.next().is_some() || !is_affine {
        return None;
    }
    Some(([x, y, z], quaternion([[r00, r01, r02], [r10, r11, r12], [r20, r21, r22]])))
}

/// The quaternion x, y, z, w of a rotation matrix, w not negative (Shepperd 1978: by the largest of four, so that nothing small is
/// divided by); or how far the matrix is from a rotation.
fn quaternion(r: [[f64; 3]; 3]) -> Result<[f64; 4], f64> {
    let [[a, b, c], [d, e, f], [g, h, i]] = r;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let [p, q, s] = r;
    let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    let errors =
        [dot(p, p) - 1.0, dot(q, q) - 1.0, dot(s, s) - 1.0, dot(p, q), dot(p, s), dot(q, s), determinant - 1.0];
    let error = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    if error.is_nan() || error > ROTATION_ERROR_MAX {
        return Err(error);
    }
    let trace = a + e + i;
    let largest = [trace, a, e, i].into_iter().fold(f64::NEG_INFINITY, f64::max);
    let raw = if largest <= trace {
        [h - f, c - g, d - b, 1.0 + trace]
    } else if largest <= a {
        [1.0 + a - e - i, b + d, c + g, h - f]
    } else if largest <= e {
        [b + d, 1.0 + e - a - i, f + h, c - g]
    } else {
        [c + g, f + h, 1.0 + i - a - e, d - b]
    };
    let norm = raw.iter().map(|v| v * v).sum::<f64>().sqrt();
    let sign = if raw[3] < 0.0 { -norm } else { norm };
    Ok(raw.map(|v| v / sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_and_its_quaternion_turn_alike() {
        let turns = [
            [0.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.5, -0.5, 0.5, 0.5],
            [0.1, 0.7, -0.1, 0.7],
        ];
        for [x, y, z, w] in turns {
            let n: f64 = x * x + y * y + z * z + w * w;
            let [x, y, z, w] = [x, y, z, w].map(|v: f64| v / n.sqrt());
            let r = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
                [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
            ];
            let found = quaternion(r).unwrap();
            let same = found.iter().zip([x, y, z, w]).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(same, "{found:?} {:?}", [x, y, z, w]);
        }
        assert!(quaternion([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).is_err());
        assert!(quaternion([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]]).is_err());
    }
}
