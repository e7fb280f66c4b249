//! From X to stamps: what a segment's X counts from, and whether that is known.

use super::header::Header;
use super::layout::{Channel, Layout};
use super::start::{S_1904_TO_1970, Start};
use crate::finding::places::Places;
use crate::formats::stamps::{rfc3339_second, utc_second};

/// X of which size counts from 1904: 1935 to 2220, in s. Nothing is measured for thirty years.
const SINCE_1904: std::ops::Range<f64> = 1e9..1e10;

/// Part of the time between two starts by which an X that has gone on since the first start may differ from it.
const COUNTED_ON_PART: f64 = 0.1;

/// What stamps count from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Origin {
    /// No segment has begun.
    Open,
    /// No start is stated.
    Nothing,
    /// A whole second of the clock of the computer; and whether its date may be read two ways.
    Local(Start),
    /// A whole second since 1904, UTC.
    Since1904(f64),
}

/// What X counts from, while segments go by.
#[derive(Debug)]
pub(super) struct Clock {
    origin: Origin,
    /// What was added to X in the first segment and in the last one, channel by channel.
    base_s: Vec<f64>,
    last_s: Vec<f64>,
    last: Option<Start>,
    /// The first X of the first segment, in s.
    first_x: Option<f64>,
    /// Whether a segment has had rows: until then nothing hangs on the origin.
    pub is_used: bool,
    /// Segments, those that state no start, those that state the start of the one before, those whose X cannot be related to the first.
    segments: usize,
    without: usize,
    equal: usize,
    foreign: usize,
    /// Segments whose X has gone on by as much as their start, and those that state LabVIEW's zero as their start.
    counted_on: usize,
    unset: usize,
    /// Starts that are earlier than one that stands before them.
    pub back: Places,
    /// Dates or times of day that cannot be read.
    pub unread: Places,
    pub reasons: Vec<String>,
}

/// A segment that begins.
pub(super) struct Segment<'a> {
    pub file: &'a Header,
    pub header: &'a Header,
    pub layout: &'a Layout,
    /// The first X of its first channel that has one, in s: given, or `X0`.
    pub first_x: Option<f64>,
    /// What `Time_Pref` states.
    pub is_absolute: bool,
    /// The sample that comes next, and the line of the names.
    pub row: usize,
    pub line: usize,
}

impl Clock {
    pub fn new() -> Self {
        Self {
            origin: Origin::Open,
            base_s: Vec::new(),
            last_s: Vec::new(),
            last: None,
            first_x: None,
            is_used: false,
            segments: 0,
            without: 0,
            equal: 0,
            foreign: 0,
            counted_on: 0,
            unset: 0,
            back: Places::default(),
            unread: Places::default(),
            reasons: Vec::new(),
        }
    }

    /// What is to be added to the X of each channel of a segment, in s; and when its first channel began.
    pub fn begin(&mut self, segment: &Segment) -> (Vec<f64>, Option<Start>) {
        let channels = segment.layout.channels.len();
        if !segment.layout.is_time {
            return (vec![0.0; channels], None);
        }
        if !self.is_used {
            self.origin = Origin::Open;
            self.first_x = segment.first_x;
        }
        let is_first = self.origin == Origin::Open;
        self.segments += 1;
        if let Some(x) = segment.first_x.filter(|x| SINCE_1904.contains(x)) {
            return (vec![self.since_1904(x); channels], None);
        }
        let is_given = !segment.layout.channels.iter().all(Channel::is_implicit);
        if segment.is_absolute && is_first && is_given && segment.first_x.is_some() {
            let why =
                "Time_Pref is Absolute, but X does not count from 1904: it is taken for relative to Date and Time";
            self.reasons.push(why.to_owned());
        }
        let starts: Vec<Option<Start>> =
            segment.layout.channels.iter().enumerate().map(|at| self.start(segment, at, is_first)).collect();
        let first = starts.first().copied().flatten();
        let stamped = starts.iter().flatten();
        match self.origin {
            Origin::Open => {
                let earliest = stamped.min_by_key(|start| start.second);
                self.origin =
                    earliest.map_or(Origin::Nothing, |start| Origin::Local(Start { fraction: 0.0, ..*start }));
            }
            Origin::Since1904(_) => self.foreign += 1,
            Origin::Nothing | Origin::Local(_) => {}
        }
        let Origin::Local(origin) = self.origin else { return (vec![0.0; channels], first) };
        let since =
            |start: Option<Start>| start.filter(|start| start.is_comparable(origin)).map(|s| s.since(origin.second));
        let of = |kept: &[f64], channel: usize| kept.get(channel).or(kept.first()).copied().unwrap_or(0.0);
        let before = self.last.and_then(|last| since(Some(last)));
        let is_back = since(first).zip(before).is_some_and(|(now, before)| now < before);
        // Both at once would count the time between two segments twice.
        let is_counted_on = !is_first && {
            let later = since(first).zip(self.base_s.first()).map(|(now, base)| now - base);
            let gone = segment.first_x.zip(self.first_x).map(|(x, first)| x - first);
            gone.zip(later).is_some_and(|(x, start)| start > 0.0 && (x - start).abs() <= COUNTED_ON_PART * start)
        };
        self.counted_on += usize::from(is_counted_on);
        if is_back {
            self.back.add(segment.row, segment.line, &[]);
        } else if !is_first && since(first).is_none() {
            self.without += 1;
        } else if !is_first && since(first) == before {
            self.equal += 1;
        }
        let offsets: Vec<f64> = starts
            .iter()
            .enumerate()
            .map(|(channel, start)| match since(*start) {
                _ if is_back || is_counted_on => of(&self.base_s, channel),
                Some(since) => since,
                // In the first segment the channel's neighbour says when it began.
                None if is_first => since(first).unwrap_or(0.0),
                None => of(&self.last_s, channel),
            })
            .collect();
        if is_first {
            self.base_s.clone_from(&offsets);
        }
        self.last_s.clone_from(&offsets);
        self.last = if is_back { self.last } else { first.or(self.last) };
        (offsets, first)
    }

    fn since_1904(&mut self, x: f64) -> f64 {
        match self.origin {
            Origin::Open => {
                self.origin = Origin::Since1904(x.floor());
                self.reasons.push("X counts from 1904-01-01 00:00 UTC, as its size shows".to_owned());
                -x.floor()
            }
            Origin::Since1904(origin) => -origin,
            Origin::Nothing | Origin::Local(_) => {
                self.foreign += 1;
                0.0
            }
        }
    }

    /// When a channel began: as the segment states it; what it does not state is that of the file, if there is a time of day or if it is
    /// the first segment.
    fn start(&mut self, segment: &Segment, (index, channel): (usize, &Channel), is_first: bool) -> Option<Start> {
        let count = segment.layout.channels.len();
        let own = |key| segment.header.of_channel(key, channel.column, index, count, true);
        let of_file = |key| segment.file.value(key);
        let (date, time) = (own("Date"), own("Time"));
        let (date, time) = match (date, time) {
            (date, Some(time)) => (date.or(of_file("Date")), Some(time)),
            (date, None) if is_first => (date.or(of_file("Date")), of_file("Time")),
            (_, None) => (None, None),
        };
        let (date, time) = (date?, time?);
        let start = Start::of(date, time);
        if start.is_some_and(Start::is_unset) {
            self.unset += usize::from(index == 0);
            return is_first.then(|| Start::of(of_file("Date")?, of_file("Time")?)).flatten().filter(|s| !s.is_unset());
        }
        if start.is_none() {
            self.unread.add(segment.row, segment.line, format!("{date} {time}").as_bytes());
        }
        start
    }

    /// Whether the X of every segment counts from one zero, as far as is known.
    pub fn is_one(&self) -> bool {
        self.foreign == 0
    }

    /// Whether the date may be read two ways.
    pub fn is_open(&self) -> bool {
        matches!(self.origin, Origin::Local(start) if start.is_open)
    }

    /// The origin in RFC 3339, and what is to be said of all segments.
    pub fn finish(mut self) -> (Option<String>, Vec<String>) {
        let origin = match self.origin {
            Origin::Local(start) if !start.is_open => Some(rfc3339_second(start.second, false)),
            Origin::Since1904(second) => Some(utc_second(second - S_1904_TO_1970 as f64, true)),
            Origin::Open | Origin::Nothing | Origin::Local(_) => None,
        };
        if self.origin == Origin::Nothing {
            self.reasons.push("no start is stated that can be read: X is used as it stands".to_owned());
        }
        let segments = self.segments;
        for (count, what) in [
            (self.without, "state no start of their own: X counts on from that of the segment before"),
            (self.equal, "state the start of the segment before: X is used as it stands"),
            (self.counted_on, "state a later start, and their X has gone on by as much: X counts from the first start"),
            (self.unset, "state 1904-01-01 00:00 UTC, LabVIEW's zero, as their start: it is none"),
            (self.foreign, "have an X that cannot be related to the first segment's: it is used as it stands"),
        ] {
            if count > 0 {
                self.reasons.push(format!("{count} of {segments} segments {what}"));
            }
        }
        (origin, self.reasons)
    }
}
