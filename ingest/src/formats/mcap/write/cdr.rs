//! Messages as ROS 2 encodes them, after a definition that is known, given, or made from the names of the columns.

use std::borrow::Cow;

use re_ros_msg::message_spec::{ArraySize, BuiltInType, Type};

use super::{Source, field_name};
use crate::error::shown;
use crate::formats::mcap::plan::{Definitions, Kind, is_time};
use crate::formats::mcap::{LOG_TIME, PUBLISH_TIME};
use crate::limits::ARRAY_COLUMNS_MAX;
use crate::recording::{Cells, Table};

/// Definitions of the types that rigs send, as `ros2 bag` would store them.
const DEFINITIONS: &[(&str, &str)] = &[
    ("std_msgs/Float64", "float64 data"),
    ("sensor_msgs/FluidPressure", "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance"),
    ("sensor_msgs/Temperature", "std_msgs/Header header\nfloat64 temperature\nfloat64 variance"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\ngeometry_msgs/Wrench wrench"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose"),
    ("geometry_msgs/PointStamped", "std_msgs/Header header\ngeometry_msgs/Point point"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\ngeometry_msgs/Vector3 vector"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1"),
];

/// A definition with all it refers to, as it stands in a file.
pub(super) fn known_definition(name: &str) -> Option<String> {
    let of = |name: &str| DEFINITIONS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let mut text = of(name)?.to_owned();
    let mut told = vec![name.to_owned()];
    let mut next = 0;
    while let Some(name) = told.get(next) {
        let fields = of(name).unwrap_or_default();
        let kinds: Vec<&str> = fields.lines().filter_map(|line| line.split(' ').next()).collect();
        for kind in kinds {
            if !told.iter().any(|told| told == kind)
                && let Some(fields) = of(kind)
            {
                text.extend(["\n", &"=".repeat(80), "\nMSG: ", kind, "\n", fields]);
                told.push(kind.to_owned());
            }
        }
        next += 1;
    }
    Some(text)
}

/// A definition made from the columns of a table: `header` where there is a stamp, and one level of numbers and texts.
pub(super) fn made_definition(table: &Table) -> String {
    let mut text = String::new();
    let stamped = table.column("header.stamp").is_some();
    if stamped {
        text += "std_msgs/Header header\n";
    }
    for column in &table.columns {
        let time = [LOG_TIME, PUBLISH_TIME, "header.stamp"].contains(&column.name.as_str());
        if !time {
            let kind = if matches!(column.cells, Cells::Text(_)) { "string" } else { "float64" };
            text.extend([kind, " ", &field_name(&column.name), "\n"]);
        }
    }
    if stamped { with_header(text) } else { text }
}

/// A definition that refers to a header, with that of the header.
pub(super) fn with_header(mut text: String) -> String {
    let header = known_definition("std_msgs/Header").unwrap_or_default();
    text.extend([&"=".repeat(80), "\nMSG: std_msgs/Header\n", &header]);
    text
}

/// A message, with the four bytes before its body.
pub(super) fn encode(definitions: &Definitions, source: &Source, row: usize, out: &mut Vec<u8>) -> Result<(), String> {
    out.extend_from_slice(&[0, 1, 0, 0]);
    let mut cdr = Cdr { definitions, source, row, out };
    let (name, spec) = definitions.root();
    spec.fields.iter().try_for_each(|field| cdr.field(&field.ty, name, &field.name))
}

/// CDR into `out`, which holds the four bytes before the body already.
struct Cdr<'c> {
    definitions: &'c Definitions,
    source: &'c Source<'c>,
    row: usize,
    out: &'c mut Vec<u8>,
}

impl Cdr<'_> {
    fn align(&mut self, size: usize) {
        while !(self.out.len() - 4).is_multiple_of(size) {
            self.out.push(0);
        }
    }

    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.align(N);
        self.out.extend_from_slice(&bytes);
    }

    fn count(&mut self, count: usize) -> Result<(), String> {
        let count = u32::try_from(count).map_err(|_| format!("{count}, which is more than CDR holds"))?;
        self.put(count.to_le_bytes());
        Ok(())
    }

    fn field(&mut self, ty: &Type, owner: &str, path: &str) -> Result<(), String> {
        let package = owner.split_once('/').map_or("", |(package, _)| package);
        match ty {
            Type::BuiltIn(BuiltInType::WString(_)) => self.put(0_u32.to_le_bytes()),
            Type::BuiltIn(BuiltInType::String(_)) => {
                let text = self.text(path);
                self.count(text.len() + 1)?;
                self.out.extend_from_slice(text.as_bytes());
                self.out.push(0);
            }
            Type::BuiltIn(built_in) => {
                let Some(kind) = Kind::of(built_in) else { return Ok(()) };
                let value = self.number(path).unwrap_or(0.0);
                self.number_of(kind, value, path)?;
            }
            Type::Complex(complex) => {
                let (name, spec) = self.definitions.resolve(complex, package)?;
                if is_time(&name, &spec).is_some() {
                    let ns = self.source.ns(path, self.row).unwrap_or(0);
                    // Beyond 2106 the seconds of ROS end.
                    for part in [ns / 1_000_000_000, ns % 1_000_000_000] {
                        self.count(usize::try_from(part).unwrap_or(usize::MAX))?;
                    }
                    return Ok(());
                }
                for field in &spec.fields {
                    self.field(&field.ty, &name, &format!("{path}.{}", field.name))?;
                }
            }
            Type::Array { ty, size } => {
                let count = match size {
                    ArraySize::Fixed(count) => *count,
                    ArraySize::Bounded(_) | ArraySize::Unbounded => {
                        let present = |index: &usize| self.has(&format!("{path}[{index}]"));
                        let count = (0..ARRAY_COLUMNS_MAX).take_while(present).count();
                        self.count(count)?;
                        count
                    }
                };
                for index in 0..count {
                    self.field(ty, owner, &format!("{path}[{index}]"))?;
                }
            }
        }
        Ok(())
    }

    /// The column of a field: by its path, or as a name made of it.
    fn column(&self, path: &str) -> Option<Cow<'_, str>> {
        if self.source.table.column(path).is_some() {
            return Some(path.to_owned().into());
        }
        // No name made of words holds a dot.
        if path.contains('.') {
            return None;
        }
        self.source.table.columns.iter().find(|c| field_name(&c.name) == path).map(|c| c.name.as_str().into())
    }

    fn number(&self, path: &str) -> Option<f64> {
        self.source.number(&self.column(path)?, self.row)
    }

    fn text(&self, path: &str) -> String {
        self.column(path).map_or_else(String::new, |path| self.source.text(&path, self.row).to_owned())
    }

    /// Whether an element of a sequence has a number in this row, or a column below it has.
    fn has(&self, path: &str) -> bool {
        self.source.table.columns.iter().any(|column| {
            let below =
                column.name.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']));
            below
                && match &column.cells {
                    Cells::Numbers(numbers) => numbers.get(self.row).is_some_and(|n| !n.is_nan()),
                    Cells::Text(texts) => texts.get(self.row).is_some_and(|text| !text.is_empty()),
                    Cells::NotKept => false,
                }
        })
    }

    // Integers beyond their range end at it; holes do not come so far.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn number_of(&mut self, kind: Kind, value: f64, path: &str) -> Result<(), String> {
        let float = matches!(kind, Kind::F32 | Kind::F64);
        if !float && !value.is_finite() {
            return Err(format!("{value} in row {} of {}, which is an integer", self.row, shown(path)));
        }
        match kind {
            Kind::U8 => self.put((value as u8).to_le_bytes()),
            Kind::I8 => self.put((value as i8).to_le_bytes()),
            Kind::U16 => self.put((value as u16).to_le_bytes()),
            Kind::I16 => self.put((value as i16).to_le_bytes()),
            Kind::U32 => self.put((value as u32).to_le_bytes()),
            Kind::I32 => self.put((value as i32).to_le_bytes()),
            Kind::U64 => self.put((value as u64).to_le_bytes()),
            Kind::I64 => self.put((value as i64).to_le_bytes()),
            Kind::F32 => self.put((value as f32).to_le_bytes()),
            Kind::F64 => self.put(value.to_le_bytes()),
        }
        Ok(())
    }
}
