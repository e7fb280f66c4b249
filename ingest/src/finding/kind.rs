//! The kinds of findings, each once: its name, its id and what it means.

use serde::{Deserialize, Serialize};

/// An enum of kinds with their ids: in results, in a store and in messages they are the same words.
macro_rules! kinds {
    ($($(#[doc = $doc:literal])+ $name:ident = $id:literal,)+) => {
        /// What was found.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[non_exhaustive]
        pub enum FindingKind {
            $($(#[doc = $doc])+ #[serde(rename = $id)] $name,)+
        }

        impl FindingKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$name,)+];

            /// Its id in results.
            pub fn id(self) -> &'static str {
                match self {
                    $(Self::$name => $id,)+
                }
            }
        }
    };
}

kinds! {
    /// Bytes that are not the text encoding they should be.
    Encoding = "encoding",
    /// The header names another number of columns than the lines hold.
    HeaderMismatch = "header-mismatch",
    /// The header runs into the first sample without a line end.
    HeaderGlued = "header-glued",
    /// A picture that cannot be decoded.
    BrokenPicture = "broken-picture",
    /// A picture in which nothing could be measured, with the reason.
    NotMeasured = "not-measured",
    /// What is worth knowing of what was measured in a picture.
    PictureQuality = "picture-quality",
    /// What is not known of the scale of pictures, with the size of the error.
    PictureScale = "picture-scale",
    /// A file whose name does not say what the pattern asks for.
    UnreadName = "unread-name",
    /// Text where a number should stand.
    NonNumericCell = "non-numeric-cell",
    /// The instrument wrote that it had no value: `NaN`, `inf`, `--`, `n/a`.
    NoValue = "no-value",
    /// Nothing stands where a number should.
    EmptyCell = "empty-cell",
    /// A line with too few or too many cells.
    RaggedLine = "ragged-line",
    /// A line among the data that is no sample.
    SkippedLine = "skipped-line",
    /// A comment among the data.
    CommentLine = "comment-line",
    /// The header stands again among the data.
    RepeatedHeader = "repeated-header",
    /// Text after the last sample.
    Trailer = "trailer",
    /// The file ends within a line.
    Truncated = "truncated",
    /// The last line is whole but has no line end.
    NoLineEnd = "no-line-end",
    /// A sample without a time stamp.
    NoStamp = "no-stamp",
    /// Time goes back.
    TimeReversed = "time-reversed",
    /// A stamp equal to the one before.
    DuplicateStamp = "duplicate-stamp",
    /// Steps of time much longer than usual.
    Gap = "gap",
    /// Steps of time that differ much from each other.
    Jitter = "jitter",
    /// A step back in time that looks like a counter which began anew.
    ClockWrap = "clock-wrap",
    /// A channel that stays at an end of its range, and varies elsewhere.
    Saturated = "saturated",
    /// A channel that stays on one value within its range, and varies elsewhere.
    Flatline = "flatline",
    /// A channel that a response needs and that has one value in every sample of the session.
    Constant = "constant",
    /// A channel that moves over few steps of its grid only.
    Quantised = "quantised",
    /// Bytes that are not those of which the file holds the checksum.
    CrcMismatch = "crc-mismatch",
    /// Values outside the range in which the sensor was calibrated.
    OutOfCalibration = "out-of-calibration",
    /// Values beyond what the instrument can show.
    OutOfRange = "out-of-range",
    /// A log that cannot be used at all, beside others that can.
    UnusableFile = "unusable-file",
    /// The log says another unit than the session or the instrument.
    UnitMismatch = "unit-mismatch",
    /// A measured channel that is not what was commanded, although the command stands.
    CommandMismatch = "command-mismatch",
    /// A measured channel that should follow a command, and no sample at which the two can be compared.
    NotCompared = "not-compared",
    /// Rows that belong to no run.
    UnclaimedRows = "unclaimed-rows",
    /// Numbers that leave the range of a double on their way to SI.
    Overflow = "overflow",
    /// A strip that takes no load at the beginning of its test.
    SlackToe = "slack-toe",
    /// Load that falls while the strip gets longer, and rises again: it slipped in its grips.
    Slippage = "slippage",
    /// Load that falls and does not come back: the strip broke.
    Rupture = "rupture",
    /// A test of several loadings, of which one is used.
    SeveralLoadings = "several-loadings",
    /// Two columns that say different things of one strain or stress.
    StrainMismatch = "strain-mismatch",
    /// A stiffness that no elastomer has: a unit may be wrong.
    ImplausibleStiffness = "implausible-stiffness",
    /// A load that pulls where it should push.
    WrongSign = "wrong-sign",
    /// The channel's zero is the mean of its first samples.
    Tared = "tared",
    /// A unit that the file does not state, inferred from its numbers.
    InferredUnit = "inferred-unit",
    /// An angle that jumps from one end of its circle to the other.
    AngleWrap = "angle-wrap",
    /// The instrument itself says that a value is not to be trusted: a status, a quality number.
    LowQuality = "low-quality",
    /// A matrix that should be a rotation and is none.
    NotRotation = "not-rotation",
    /// A date whose day and month may be either way round.
    AmbiguousDate = "ambiguous-date",
    /// A key that stands on one line only.
    StrayKey = "stray-key",
    /// Values that the gauge marks as its peak.
    PeakMark = "peak-mark",
    /// The sign stands beside the value, as a letter.
    SignLetter = "sign-letter",
    /// A record that is not what such a record holds.
    BadRecord = "bad-record",
    /// Messages of a topic that cannot be decoded at all.
    UnreadTopic = "unread-topic",
    /// A message that cannot be decoded, beside others of its topic that can.
    UnreadMessage = "unread-message",
    /// An id that is defined twice, and not alike.
    ConflictingDefinition = "conflicting-definition",
    /// A file says that it holds more or less than was found.
    CountMismatch = "count-mismatch",
    /// A file states another step of time than its stamps have.
    StepMismatch = "step-mismatch",
    /// Elements of arrays that became no columns, or texts that became no cells.
    NotExpanded = "not-expanded",
    /// A scale from raw values to measured ones that is not supported, or not whole.
    UnsupportedScaling = "unsupported-scaling",
    /// Integers that a double cannot hold.
    Rounded = "rounded",
    /// Counts of a converter, and no scale for them.
    Unscaled = "unscaled",
    /// Seconds were added to stamps, so that the files of a run count from one instant.
    ClockShift = "clock-shift",
    /// Plateaus of the pressure within whose windows another device or topic stamped nothing.
    UnmetPlateaus = "unmet-plateaus",
    /// A run without a reading at zero pressure before its first rise, from which its zero should come.
    Untared = "untared",
    /// What is measured still moves while it is averaged.
    Creeping = "creeping",
    /// Events that several devices recorded and that do not agree as well as each of them is known.
    SyncMismatch = "sync-mismatch",
    /// A run in which the clocks of several devices cannot be set against each other.
    ClockUnaligned = "clock-unaligned",
    /// One event only: the clock's offset is known, what it gains is not.
    DriftUnknown = "drift-unknown",
    /// Between pressure and motion there is a lag, and nobody says whether it is that of a clock or that of the specimen.
    TotalLag = "total-lag",
    /// The lag of one run is far from that of the others.
    UnusualLag = "unusual-lag",
    /// A clock without a date, in a file whose other clocks have one.
    NoDate = "no-date",
}
