//! From the message definition in the file to a list of steps that decodes one message.
//!
//! Structs leave no trace in CDR, so their fields become one flat list, and neighbouring numbers of one kind one step. Elements
//! of sequences get their steps when the first message has them.

use std::collections::HashMap;
use std::rc::Rc;

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, MessageSpecification, Type};

use super::columns::{Budget, Columns, Slot};
use super::known;
use crate::limits::{ARRAY_COLUMNS_MAX, BYTE_COLUMNS_MAX, DECODE_STEPS_MAX, NESTING_MAX};
use crate::recording::Keep;

/// A kind of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Kind {
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The kind of a built-in type that is a number.
    pub fn of(built_in: &BuiltInType) -> Option<Self> {
        Some(match built_in {
            BuiltInType::Bool | BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => Self::U8,
            BuiltInType::Int8 => Self::I8,
            BuiltInType::UInt16 => Self::U16,
            BuiltInType::Int16 => Self::I16,
            BuiltInType::UInt32 => Self::U32,
            BuiltInType::Int32 => Self::I32,
            BuiltInType::UInt64 => Self::U64,
            BuiltInType::Int64 => Self::I64,
            BuiltInType::Float32 => Self::F32,
            BuiltInType::Float64 => Self::F64,
            BuiltInType::String(_) | BuiltInType::WString(_) => return None,
        })
    }
}

/// A step.
#[derive(Debug)]
pub(super) enum Op {
    /// Numbers of one kind into neighbouring cells.
    Numbers {
        kind: Kind,
        slot: usize,
        count: usize,
    },
    /// Numbers that go nowhere.
    Skip {
        size: usize,
        count: usize,
    },
    /// Seconds and nanoseconds; an instant counts from the origin, a duration from nothing.
    Time {
        slot: Slot,
        instant: bool,
    },
    Text(Slot),
    /// `frame_id` of the header: the same in every message, so it is told once.
    FrameId,
    /// Wide characters; not read.
    Wide,
    /// A sequence of numbers.
    Numeric(Box<Numeric>),
    /// A sequence of anything else.
    Sequence(Box<Sequence>),
    /// Elements of an array that become no columns.
    Repeat {
        count: usize,
        body: Vec<Op>,
    },
    /// In XCDR2 a length stands before elements that are no numbers.
    Delimiter,
}

#[derive(Debug)]
pub(super) struct Numeric {
    pub kind: Kind,
    pub at: At,
    pub slots: Vec<Slot>,
    /// Elements that become columns at most; none once a byte array turned out to be no signal.
    pub columns_max: usize,
    pub bytes: bool,
}

#[derive(Debug)]
pub(super) struct Sequence {
    of: Type,
    package: String,
    pub at: At,
    pub elements: Vec<Vec<Op>>,
    pub skip: Vec<Op>,
    pub columns_max: usize,
}

/// Where in a message a field stands.
#[derive(Debug, Clone)]
pub(super) struct At {
    pub path: String,
    /// The types around it, and where their own path ends.
    owners: Vec<(Rc<str>, usize)>,
    depth: usize,
}

impl At {
    fn root() -> Self {
        Self { path: String::new(), owners: vec![], depth: 0 }
    }

    fn field(&self, name: &str) -> Self {
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        Self { path, owners: self.owners.clone(), depth: self.depth + 1 }
    }

    pub fn element(&self, index: usize) -> Self {
        Self { path: format!("{}[{index}]", self.path), owners: self.owners.clone(), depth: self.depth + 1 }
    }

    /// The unit that a type around it promises, the nearest first.
    fn unit(&self) -> Option<&'static str> {
        self.owners.iter().rev().find_map(|(owner, begin)| {
            let mut field = String::new();
            let mut inside = false;
            for c in self.path.get(*begin..)?.trim_start_matches('.').chars() {
                inside = (inside || c == '[') && c != ']';
                if !inside && c != ']' {
                    field.push(c);
                }
            }
            known::unit_of(owner, &field)
        })
    }
}

/// Message types by `package/Type`.
#[derive(Debug)]
pub(super) struct Definitions {
    types: HashMap<String, Rc<MessageSpecification>>,
    root: String,
}

/// `package/msg/Type` as `package/Type`: both are written.
pub(super) fn short_name(name: &str) -> String {
    match (name.split_once('/'), name.rsplit_once('/')) {
        (Some((package, _)), Some((_, name))) => format!("{package}/{name}"),
        _ => name.to_owned(),
    }
}

fn package_of(name: &str) -> &str {
    name.split_once('/').map_or("", |(package, _)| package)
}

/// Types whose definition never changes: seconds and nanoseconds.
const BUILT_IN: [&str; 2] = ["builtin_interfaces/Time", "builtin_interfaces/Duration"];

impl Definitions {
    /// Reads the definitions that stand in a file.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        // The parser takes a section without any line for none; a message without fields is one.
        let mut lines = vec![];
        for line in text.lines() {
            lines.push(line);
            if line.trim_start().starts_with("MSG: ") {
                lines.push("#");
            }
        }
        let text = lines.join("\n");
        let schema = MessageSchema::parse(name, &text).map_err(|error| format!("{error:#}"))?;
        let root = short_name(name);
        let mut types: HashMap<_, _> =
            schema.dependencies.into_iter().map(|spec| (short_name(&spec.name), Rc::new(spec))).collect();
        types.insert(root.clone(), Rc::new(schema.spec));
        // Some writers leave out what every ROS 2 knows.
        for name in BUILT_IN {
            if !types.contains_key(name) {
                let spec =
                    MessageSchema::parse(name, "int32 sec\nuint32 nanosec").map_err(|error| format!("{error:#}"))?;
                types.insert(name.to_owned(), Rc::new(spec.spec));
            }
        }
        Ok(Self { types, root })
    }

    pub fn root(&self) -> (&str, &MessageSpecification) {
        // Inserted when this was made.
        (&self.root, &self.types[&self.root])
    }

    /// The type that a field of a message of `package` refers to.
    pub fn resolve(&self, complex: &ComplexType, package: &str) -> Result<(String, Rc<MessageSpecification>), String> {
        let asked = match complex {
            ComplexType::Absolute { package, name } => short_name(&format!("{package}/{name}")),
            ComplexType::Relative { name } => format!("{package}/{name}"),
        };
        // `Header` alone means the one of std_msgs.
        let header = (asked.ends_with("/Header") && asked == format!("{package}/Header")).then_some("std_msgs/Header");
        let found = self.types.get_key_value(&asked).or_else(|| self.types.get_key_value(header?));
        match found {
            Some((name, spec)) => Ok((name.clone(), Rc::clone(spec))),
            None => Err(format!("the definition of {} is not in it", crate::error::shown(&asked))),
        }
    }
}

/// Whether a type is an instant or a duration, as ROS 2 writes both.
pub(super) fn is_time(name: &str, spec: &MessageSpecification) -> Option<bool> {
    let instant = match name {
        "builtin_interfaces/Time" => true,
        "builtin_interfaces/Duration" => false,
        _ => return None,
    };
    let fields: Vec<_> = spec.fields.iter().map(|f| (f.name.as_str(), &f.ty)).collect();
    let int = Type::BuiltIn(BuiltInType::Int32);
    let nano = Type::BuiltIn(BuiltInType::UInt32);
    (fields == [("sec", &int), ("nanosec", &nano)]).then_some(instant)
}

/// Types of which a field is a picture or a cloud, never a signal.
const PIXELS: &[(&str, &str)] = &[
    ("sensor_msgs/Image", "data"),
    ("sensor_msgs/CompressedImage", "data"),
    ("sensor_msgs/PointCloud2", "data"),
    ("foxglove_msgs/CompressedVideo", "data"),
];

/// How one message type is decoded.
#[derive(Debug)]
pub(super) struct Plan {
    pub definitions: Rc<Definitions>,
    pub ops: Vec<Op>,
    pub steps: usize,
    /// Whether some messages may fill fewer cells than others.
    pub ragged: bool,
    /// Whether it holds wide characters, of which two encodings are in use.
    pub wide: bool,
}

impl Plan {
    /// The steps for a message type, with a column for each number and text.
    pub fn new(name: &str, text: &str, columns: &mut Columns, keep: Keep, budget: &mut Budget) -> Result<Self, String> {
        let definitions = Rc::new(Definitions::parse(name, text)?);
        let mut plan = Self { definitions: Rc::clone(&definitions), ops: vec![], steps: 0, ragged: false, wide: false };
        let (name, spec) = definitions.root();
        let mut ops = vec![];
        let mut compiler = Compiler::new(&definitions, &mut plan.steps, columns, keep, budget);
        compiler.message(name, spec, &At::root(), true, &mut ops)?;
        (plan.ragged, plan.wide) = (compiler.ragged, compiler.wide);
        plan.ops = ops;
        Ok(plan)
    }
}

/// Makes steps.
pub(super) struct Compiler<'c> {
    definitions: &'c Definitions,
    steps: &'c mut usize,
    columns: &'c mut Columns,
    keep: Keep<'c>,
    budget: &'c mut Budget,
    ragged: bool,
    wide: bool,
}

impl<'c> Compiler<'c> {
    pub fn new(
        definitions: &'c Definitions,
        steps: &'c mut usize,
        columns: &'c mut Columns,
        keep: Keep<'c>,
        budget: &'c mut Budget,
    ) -> Self {
        Self { definitions, steps, columns, keep, budget, ragged: false, wide: false }
    }

    /// The steps of one more element of a sequence.
    pub fn element(&mut self, sequence: &mut Sequence) -> Result<(), String> {
        let mut ops = vec![];
        let at = sequence.at.element(sequence.elements.len());
        self.field(&sequence.of, &sequence.package, &at, true, &mut ops)?;
        sequence.elements.push(ops);
        Ok(())
    }

    /// The cell of one more element of a sequence of numbers.
    pub fn number(&mut self, numeric: &mut Numeric) {
        let at = numeric.at.element(numeric.slots.len());
        numeric.slots.push(self.columns.number(&at.path, at.unit(), false, self.keep, self.budget));
    }

    fn message(
        &mut self,
        name: &str,
        spec: &MessageSpecification,
        at: &At,
        wanted: bool,
        out: &mut Vec<Op>,
    ) -> Result<(), String> {
        let mut at = at.clone();
        at.owners.push((name.into(), at.path.len()));
        if spec.fields.is_empty() {
            // Nothing but constants: one byte all the same.
            skip(out, 1, 1);
        }
        for field in &spec.fields {
            let dummy = field.name == "structure_needs_at_least_one_member";
            let wanted = wanted && !dummy && !PIXELS.contains(&(name, field.name.as_str()));
            let inside = at.field(&field.name);
            let header_of_frame = name == "std_msgs/Header" && at.path == "header" && field.name == "frame_id";
            if header_of_frame && field.ty == Type::BuiltIn(BuiltInType::String(None)) {
                out.push(Op::FrameId);
            } else {
                self.field(&field.ty, package_of(name), &inside, wanted, out)?;
            }
        }
        Ok(())
    }

    fn field(&mut self, ty: &Type, package: &str, at: &At, wanted: bool, out: &mut Vec<Op>) -> Result<(), String> {
        *self.steps += 1;
        if *self.steps > DECODE_STEPS_MAX {
            return Err(format!("its definition asks for more than {DECODE_STEPS_MAX} fields"));
        }
        if at.depth > NESTING_MAX {
            return Err(format!("its definition nests more than {NESTING_MAX} levels deep"));
        }
        match ty {
            Type::BuiltIn(BuiltInType::WString(_)) => {
                self.wide = true;
                out.push(Op::Wide);
            }
            Type::BuiltIn(built_in) => match Kind::of(built_in) {
                Some(kind) => {
                    let slot = if wanted {
                        self.columns.number(&at.path, at.unit(), false, self.keep, self.budget)
                    } else {
                        Slot::None
                    };
                    numbers(out, kind, slot);
                }
                None => out.push(Op::Text(if wanted {
                    self.columns.text(&at.path, self.keep, self.budget)
                } else {
                    Slot::None
                })),
            },
            Type::Complex(complex) => {
                let (name, spec) = self.definitions.resolve(complex, package)?;
                if let Some(instant) = is_time(&name, &spec) {
                    let stamp = is_stamp(&at.path);
                    let slot = if wanted {
                        self.columns.number(&at.path, Some("s"), stamp, self.keep, self.budget)
                    } else {
                        Slot::None
                    };
                    if instant {
                        self.columns.date(slot);
                    }
                    out.push(Op::Time { slot, instant });
                } else {
                    self.message(&name, &spec, at, wanted, out)?;
                }
            }
            Type::Array { ty, size: ArraySize::Fixed(count) } => self.array(ty, *count, package, at, wanted, out)?,
            Type::Array { ty, .. } => self.sequence(ty, package, at, wanted, out)?,
        }
        Ok(())
    }

    fn array(
        &mut self,
        ty: &Type,
        count: usize,
        package: &str,
        at: &At,
        wanted: bool,
        out: &mut Vec<Op>,
    ) -> Result<(), String> {
        let columns = columns_of(ty, count);
        if wanted && columns < count {
            self.columns.cut_at(&at.path, count);
        }
        let columns = if wanted { columns } else { 0 };
        if let Some(kind) = kind_of(ty) {
            for index in 0..columns {
                self.field(ty, package, &at.element(index), true, out)?;
            }
            skip(out, kind.size(), count - columns);
            return Ok(());
        }
        out.push(Op::Delimiter);
        for index in 0..columns {
            self.field(ty, package, &at.element(index), true, out)?;
        }
        if count > columns {
            let mut body = vec![];
            self.field(ty, package, &at.element(columns), false, &mut body)?;
            out.push(Op::Repeat { count: count - columns, body });
        }
        Ok(())
    }

    fn sequence(&mut self, ty: &Type, package: &str, at: &At, wanted: bool, out: &mut Vec<Op>) -> Result<(), String> {
        self.ragged = true;
        let columns_max = if wanted { ARRAY_COLUMNS_MAX } else { 0 };
        if let Some(kind) = kind_of(ty) {
            let bytes = kind.size() == 1;
            let numeric = Numeric { kind, at: at.clone(), slots: vec![], columns_max, bytes };
            out.push(Op::Numeric(Box::new(numeric)));
            return Ok(());
        }
        let mut skip = vec![];
        self.field(ty, package, &at.element(0), false, &mut skip)?;
        let (of, package) = (ty.clone(), package.to_owned());
        let sequence = Sequence { of, package, at: at.clone(), elements: vec![], skip, columns_max };
        out.push(Op::Sequence(Box::new(sequence)));
        Ok(())
    }
}

/// Whether a path is that of a message's own stamp.
pub(super) fn is_stamp(path: &str) -> bool {
    super::HEADER_STAMPS.contains(&path)
}

fn kind_of(ty: &Type) -> Option<Kind> {
    match ty {
        Type::BuiltIn(built_in) => Kind::of(built_in),
        _ => None,
    }
}

/// How many elements of a fixed array become columns.
fn columns_of(ty: &Type, count: usize) -> usize {
    match kind_of(ty) {
        Some(kind) if kind.size() == 1 && count > BYTE_COLUMNS_MAX => 0,
        _ => count.min(ARRAY_COLUMNS_MAX),
    }
}

/// Adds a number, to the step before where it continues that.
fn numbers(out: &mut Vec<Op>, kind: Kind, at: Slot) {
    let Slot::Number(at) = at else { return skip(out, kind.size(), 1) };
    match out.last_mut() {
        Some(Op::Numbers { kind: same, slot, count }) if *same == kind && *slot + *count == at => *count += 1,
        _ => out.push(Op::Numbers { kind, slot: at, count: 1 }),
    }
}

/// Adds numbers that go nowhere.
fn skip(out: &mut Vec<Op>, size: usize, more: usize) {
    match out.last_mut() {
        Some(Op::Skip { size: same, count }) if *same == size => *count = count.saturating_add(more),
        _ if more > 0 => out.push(Op::Skip { size, count: more }),
        _ => {}
    }
}
