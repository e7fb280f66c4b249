//! CDR, the binary form in which ROS 2 sends messages: a walk along the steps of a [`Plan`].
//!
//! Four bytes stand before the body: which byte order, and which of two rules for alignment. Alignment counts from the body.

use super::columns::{Budget, Columns, Slot};
use super::plan::{Compiler, Definitions, Kind, Numeric, Op, Plan, Sequence};
use crate::limits::BYTE_COLUMNS_MAX;
use crate::recording::Keep;

/// Why a message cannot be decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bad {
    /// It ends before its last field does.
    Short,
    /// The four bytes before the body name no encoding that is read.
    Encapsulation,
    /// It is not what its encoding asks for.
    Syntax,
}

impl Bad {
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Short => "ends before its last field",
            Self::Encapsulation => "says that it is encoded in another way than plain CDR",
            Self::Syntax => "is not what its encoding asks for",
        }
    }
}

/// Distinct `frame_id`s of a topic.
#[derive(Debug, Default)]
pub(super) struct Frames {
    pub seen: Vec<String>,
    last: Vec<u8>,
}

/// Names of frames that are told.
const FRAMES_MAX: usize = 8;

impl Frames {
    pub fn see(&mut self, bytes: &[u8]) {
        if bytes == self.last && !self.seen.is_empty() {
            return;
        }
        // What is longer than any name is none.
        let bytes = &bytes[..bytes.len().min(crate::limits::TEXT_BYTES_MAX)];
        bytes.clone_into(&mut self.last);
        let name = String::from_utf8_lossy(bytes);
        if self.seen.len() < FRAMES_MAX && !self.seen.iter().any(|seen| *seen == name) {
            self.seen.push(name.into_owned());
        }
    }
}

/// Where the cells of a message go.
pub(super) struct Target<'t> {
    pub columns: &'t mut Columns,
    pub keep: Keep<'t>,
    pub budget: &'t mut Budget,
    pub frames: &'t mut Frames,
    /// The instant from which stamps count, in s since 1970.
    pub origin_s: i64,
}

/// Bytes behind the last field that no padding explains.
const TRAILING_MAX: usize = 8;

/// Decodes a message. True if bytes are left that its definition does not explain.
pub(super) fn decode(plan: &mut Plan, data: &[u8], target: &mut Target) -> Result<bool, Bad> {
    target.columns.begin(plan.ragged);
    let (head, body) = data.split_first_chunk::<4>().ok_or(Bad::Short)?;
    let once = |plan: &mut Plan, target: &mut Target, wide| match head[..2] {
        [0, 0] => Cursor::<true, 8>::decode(plan, body, wide, target),
        [0, 1] => Cursor::<false, 8>::decode(plan, body, wide, target),
        [0, 6] => Cursor::<true, 4>::decode(plan, body, wide, target),
        [0, 7] => Cursor::<false, 4>::decode(plan, body, wide, target),
        _ => Err(Bad::Encapsulation),
    };
    // Older middleware writes wide characters in four bytes, newer in two: what ends where the message ends is meant.
    let first = once(plan, target, 4);
    if plan.wide && !first.is_ok_and(|left| left < 4) {
        target.columns.begin(plan.ragged);
        let left = once(plan, target, 2)?;
        return Ok(left >= TRAILING_MAX);
    }
    Ok(first? >= TRAILING_MAX)
}

struct Cursor<'a, const BIG: bool, const ALIGN_MAX: usize> {
    body: &'a [u8],
    at: usize,
    /// Bytes of a wide character.
    wide: usize,
}

/// What the walk needs beside the steps themselves.
struct Walk<'w, 't> {
    target: &'w mut Target<'t>,
    definitions: &'w Definitions,
    steps: &'w mut usize,
}

/// Runs `$body` with `$read` turned into the conversion of one number.
macro_rules! by_kind {
    ($kind:expr, $big:expr, |$read:ident: $size:ident| $body:expr) => {
        match $kind {
            Kind::U8 => by_kind!(@one u8, 1, $big, $read, $size, $body),
            Kind::I8 => by_kind!(@one i8, 1, $big, $read, $size, $body),
            Kind::U16 => by_kind!(@one u16, 2, $big, $read, $size, $body),
            Kind::I16 => by_kind!(@one i16, 2, $big, $read, $size, $body),
            Kind::U32 => by_kind!(@one u32, 4, $big, $read, $size, $body),
            Kind::I32 => by_kind!(@one i32, 4, $big, $read, $size, $body),
            Kind::U64 => by_kind!(@wide u64, 8, $big, $read, $size, $body),
            Kind::I64 => by_kind!(@wide i64, 8, $big, $read, $size, $body),
            Kind::F32 => by_kind!(@one f32, 4, $big, $read, $size, $body),
            Kind::F64 => by_kind!(@one f64, 8, $big, $read, $size, $body),
        }
    };
    (@one $type:ty, $bytes:literal, $big:expr, $read:ident, $size:ident, $body:expr) => {{
        const $size: usize = $bytes;
        let $read = |b: [u8; $bytes]| f64::from(if $big { <$type>::from_be_bytes(b) } else { <$type>::from_le_bytes(b) });
        $body
    }};
    // Beyond 2^53 the nearest double.
    (@wide $type:ty, $bytes:literal, $big:expr, $read:ident, $size:ident, $body:expr) => {{
        const $size: usize = $bytes;
        let $read = |b: [u8; $bytes]| (if $big { <$type>::from_be_bytes(b) } else { <$type>::from_le_bytes(b) }) as f64;
        $body
    }};
}

impl<'a, const BIG: bool, const ALIGN_MAX: usize> Cursor<'a, BIG, ALIGN_MAX> {
    /// Decodes a body; how many bytes are left behind it.
    fn decode(plan: &mut Plan, body: &'a [u8], wide: usize, target: &mut Target) -> Result<usize, Bad> {
        let mut cursor = Self { body, at: 0, wide };
        let mut walk = Walk { target, definitions: &plan.definitions, steps: &mut plan.steps };
        cursor.run(&mut plan.ops, &mut walk)?;
        Ok(body.len() - cursor.at)
    }

    /// Numbers of a size, aligned to it.
    #[inline]
    fn take(&mut self, size: usize, count: usize) -> Result<&'a [u8], Bad> {
        if count == 0 {
            // Nothing is aligned for nothing.
            return Ok(&[]);
        }
        let align = if size < ALIGN_MAX { size } else { ALIGN_MAX };
        // Sizes are 1, 2, 4 and 8. The position lies within a message, hence far below the largest number.
        let start = (self.at + align - 1) & !(align - 1);
        let end = size.checked_mul(count).and_then(|bytes| start.checked_add(bytes)).ok_or(Bad::Short)?;
        let bytes = self.body.get(start..end).ok_or(Bad::Short)?;
        self.at = end;
        Ok(bytes)
    }

    #[inline]
    fn u32(&mut self) -> Result<u32, Bad> {
        let bytes = self.take(4, 1)?.first_chunk().ok_or(Bad::Short)?;
        Ok(if BIG { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) })
    }

    fn string(&mut self) -> Result<&'a [u8], Bad> {
        let length = self.u32()? as usize;
        let bytes = self.take(1, length)?;
        Ok(bytes.strip_suffix(&[0]).unwrap_or(bytes))
    }

    fn run(&mut self, ops: &mut [Op], walk: &mut Walk) -> Result<(), Bad> {
        for op in ops {
            match op {
                Op::Numbers { kind, slot, count } => {
                    let (slot, count) = (*slot, *count);
                    let bytes = self.take(kind.size(), count)?;
                    let Some(cells) = walk.target.columns.cells(slot, count) else { continue };
                    by_kind!(*kind, BIG, |read: SIZE| {
                        for (cell, number) in cells.iter_mut().zip(bytes.as_chunks::<SIZE>().0) {
                            *cell = read(*number);
                        }
                    });
                }
                Op::Skip { size, count } => drop(self.take(*size, *count)?),
                Op::Time { slot, instant } => {
                    let (seconds, nanoseconds) = (self.u32()?.cast_signed(), self.u32()?);
                    let from = if *instant { walk.target.origin_s } else { 0 };
                    // 2^63 ns are 292 years, and the seconds of a stamp at most 68 from 1970.
                    let ns = (i64::from(seconds) - from).saturating_mul(1_000_000_000);
                    walk.target.columns.put(*slot, ns.saturating_add(nanoseconds.into()) as f64 / 1e9);
                }
                Op::Text(slot) => {
                    let text = self.string()?;
                    if *slot != Slot::None {
                        walk.target.columns.put_text(*slot, text);
                    }
                }
                Op::FrameId => {
                    let name = self.string()?;
                    walk.target.frames.see(name);
                }
                Op::Wide => {
                    let length = self.u32()? as usize;
                    self.take(1, length.checked_mul(self.wide).ok_or(Bad::Short)?)?;
                }
                Op::Numeric(numeric) => self.numeric(numeric, walk)?,
                Op::Sequence(sequence) => self.sequence(sequence, walk)?,
                Op::Repeat { count, body } => {
                    for _ in 0..*count {
                        let before = self.at;
                        self.run(body, walk)?;
                        // Elements without bytes: any number of them is none.
                        if self.at == before {
                            break;
                        }
                    }
                }
                Op::Delimiter => {
                    if ALIGN_MAX == 4 {
                        self.u32()?;
                    }
                }
            }
        }
        Ok(())
    }

    fn numeric(&mut self, numeric: &mut Numeric, walk: &mut Walk) -> Result<(), Bad> {
        let count = self.u32()? as usize;
        let bytes = self.take(numeric.kind.size(), count)?;
        if numeric.columns_max == 0 {
            return Ok(());
        }
        if numeric.bytes && count > BYTE_COLUMNS_MAX {
            numeric.columns_max = 0;
            walk.target.columns.cut_at(&numeric.at.path, count);
            walk.target.columns.drop_field(&numeric.at.path);
            return Ok(());
        }
        if count > numeric.columns_max {
            walk.target.columns.cut_at(&numeric.at.path, count);
        }
        let wanted = count.min(numeric.columns_max);
        while numeric.slots.len() < wanted {
            let Target { columns, keep, budget, .. } = &mut *walk.target;
            Compiler::new(walk.definitions, walk.steps, columns, *keep, budget).number(numeric);
        }
        let columns = &mut *walk.target.columns;
        by_kind!(numeric.kind, BIG, |read: SIZE| {
            for (slot, number) in numeric.slots.iter().zip(bytes.as_chunks::<SIZE>().0) {
                columns.put(*slot, read(*number));
            }
        });
        Ok(())
    }

    fn sequence(&mut self, sequence: &mut Sequence, walk: &mut Walk) -> Result<(), Bad> {
        if ALIGN_MAX == 4 {
            self.u32()?;
        }
        let count = self.u32()? as usize;
        if count > self.body.len() - self.at {
            return Err(Bad::Short);
        }
        if count > sequence.columns_max && sequence.columns_max > 0 {
            walk.target.columns.cut_at(&sequence.at.path, count);
        }
        for index in 0..count {
            let before = self.at;
            if index < sequence.columns_max && index == sequence.elements.len() {
                let Target { columns, keep, budget, .. } = &mut *walk.target;
                let made = Compiler::new(walk.definitions, walk.steps, columns, *keep, budget).element(sequence);
                if made.is_err() {
                    sequence.columns_max = index;
                    walk.target.columns.cut_at(&sequence.at.path, count);
                }
            }
            let ops = if index < sequence.columns_max { sequence.elements.get_mut(index) } else { None };
            self.run(ops.unwrap_or(&mut sequence.skip), walk)?;
            if self.at == before {
                break;
            }
        }
        Ok(())
    }
}
