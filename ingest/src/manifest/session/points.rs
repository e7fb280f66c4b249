//! `points` of a response: how samples become what is compared.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use crate::document::{Amount, Document};
use crate::error::IngestError;
use crate::units::Dimension;

/// How samples become points of a response.
#[derive(Debug, Clone, PartialEq)]
pub enum PointRule {
    /// Every sample is a point: a log of steady states.
    Samples {
        /// Pressures of several runs so near each other are repeats, in Pa; 0: equal to the bit.
        same_within_pa: f64,
    },
    /// Every stretch of steady pressure is a point: the mean over its end.
    Plateaus {
        /// How far the pressure may be from the middle of the stretch's range, in Pa.
        tolerance_pa: f64,
        /// How long a stretch must last, in s.
        hold_s: f64,
        /// The end of it that is averaged, in s.
        window_s: f64,
    },
    /// Stated stretches of time are points: the mean over each.
    Windows {
        /// Where they begin, in s from the first stamp of the run.
        begin_s: Vec<f64>,
        /// How long each is, in s.
        window_s: f64,
        /// Pressures so near each other are one, in Pa.
        same_within_pa: f64,
    },
    /// The samples of a run are one movement, compared as they stand; runs are never merged.
    Trajectory(TrajectoryRule),
}

/// How a movement meets its prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryRule {
    /// What is equal where the two are compared.
    pub at: Abscissa,
    /// How stamps meet; of a comparison at equal time.
    pub matching: Matching,
    /// The longest step between two measured stamps that is interpolated across, in s; five usual steps where absent.
    pub gap_s: Option<f64>,
    /// The share of the shorter series that must meet the other, or nothing is judged.
    pub overlap_min: f64,
    /// Of so many samples one counts; of a comparison at equal pressure.
    pub every: usize,
}

impl PointRule {
    /// The rule of a movement that is compared at equal time or arc length, and so needs no pressure.
    pub fn path(&self) -> Option<&TrajectoryRule> {
        match self {
            Self::Trajectory(rule) if rule.at != Abscissa::Pressure => Some(rule),
            _ => None,
        }
    }

    /// Whether points are means over stretches of time, for which samples of several tables need no partners.
    pub fn is_timed(&self) -> bool {
        matches!(self, Self::Plateaus { .. } | Self::Windows { .. })
    }

    /// Pressures so near each other are one nominal pressure, in Pa; 0: equal to the bit.
    pub fn same_within_pa(&self) -> f64 {
        match self {
            Self::Samples { same_within_pa } | Self::Windows { same_within_pa, .. } => *same_within_pa,
            Self::Plateaus { tolerance_pa, .. } => *tolerance_pa,
            // No sample of a movement meets another.
            Self::Trajectory(_) => 0.0,
        }
    }
}

/// What is equal where a measurement and a prediction are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Abscissa {
    /// Gauge pressure.
    Pressure,
    /// Time.
    Time,
    /// The share of the path's arc length, from its first sample to its last.
    ArcLength,
}

impl Abscissa {
    /// Its word in manifests.
    pub fn id(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::Time => "time",
            Self::ArcLength => "arc-length",
        }
    }
}

/// How the stamps of two series meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Matching {
    /// Each stamp of the shorter series with the nearest of the longer one.
    Nearest {
        /// So far apart they may be, in s.
        within_s: f64,
    },
    /// Straight lines between measured samples, at the stamps of the prediction.
    Interpolate,
}

/// Less than half of the shorter series says little of the whole.
const OVERLAP_MIN: f64 = 0.5;

/// `{ from = "samples", same_within }`, `{ from = "plateaus", tolerance, hold, window }`, `{ from = "windows", begin, window, same_within }`
/// or `{ from = "trajectory", at, match, within, gap, overlap_min, every }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPoints {
    from: Spanned<PointSource>,
    same_within: Option<Amount>,
    tolerance: Option<Amount>,
    hold: Option<Amount>,
    window: Option<Amount>,
    begin: Option<Vec<Amount>>,
    at: Option<Spanned<Abscissa>>,
    #[serde(rename = "match")]
    matching: Option<Spanned<Match>>,
    within: Option<Amount>,
    gap: Option<Amount>,
    overlap_min: Option<Amount>,
    every: Option<Spanned<usize>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PointSource {
    Samples,
    Plateaus,
    Windows,
    Trajectory,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Match {
    Nearest,
    Interpolate,
}

impl PointSource {
    fn id(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Plateaus => "plateaus",
            Self::Windows => "windows",
            Self::Trajectory => "trajectory",
        }
    }

    /// The keys that stand beside it.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Samples => &["same_within"],
            Self::Plateaus => &["tolerance", "hold", "window"],
            Self::Windows => &["begin", "window", "same_within"],
            Self::Trajectory => &["at", "match", "within", "gap", "overlap_min", "every"],
        }
    }
}

impl RawPoints {
    pub fn checked(&self, document: &Document) -> Result<PointRule, IngestError> {
        let source = *self.from.get_ref();
        // Asked for and not heeded would be worse than refused.
        if let Some((key, span)) = self.keys().into_iter().find(|(key, _)| !source.keys().contains(key)) {
            let expected = format!("no `{key}` beside from = \"{}\"", source.id());
            let next = match (source, key) {
                (PointSource::Plateaus, "same_within") => {
                    "remove it: plateaus within `tolerance` of each other are repeats".to_owned()
                }
                _ => format!("remove it; beside it stand {}", source.keys().join(", ")),
            };
            return Err(document.malformed(span, expected, "one", next));
        }
        match source {
            PointSource::Samples => Ok(PointRule::Samples { same_within_pa: self.same_within_pa(document)? }),
            PointSource::Plateaus => self.plateaus(document),
            PointSource::Windows => self.windows(document),
            PointSource::Trajectory => self.trajectory(document).map(PointRule::Trajectory),
        }
    }

    /// Every key but `from` that is there, with its place.
    fn keys(&self) -> Vec<(&'static str, Range<usize>)> {
        let amount = |key, amount: &Option<Amount>| amount.as_ref().map(|a| (key, a.span()));
        let keys = [
            amount("same_within", &self.same_within),
            amount("tolerance", &self.tolerance),
            amount("hold", &self.hold),
            amount("window", &self.window),
            self.begin.as_ref().map(|begin| ("begin", begin.first().map_or(self.from.span(), Amount::span))),
            self.at.as_ref().map(|at| ("at", at.span())),
            self.matching.as_ref().map(|m| ("match", m.span())),
            amount("within", &self.within),
            amount("gap", &self.gap),
            amount("overlap_min", &self.overlap_min),
            self.every.as_ref().map(|every| ("every", every.span())),
        ];
        keys.into_iter().flatten().collect()
    }

    fn same_within_pa(&self, document: &Document) -> Result<f64, IngestError> {
        let same = self.same_within.as_ref().map(|s| s.not_negative(document, Dimension::Pressure)).transpose()?;
        Ok(same.unwrap_or(0.0))
    }

    fn windows(&self, document: &Document) -> Result<PointRule, IngestError> {
        let (Some(begin), Some(window)) = (self.begin.as_ref().filter(|begin| !begin.is_empty()), &self.window) else {
            let next = "say begin = [{ value = 9, unit = \"s\" }, ..] from the first stamp of a run, and window = { value, unit }";
            let expected = "`begin` and `window` beside from = \"windows\"";
            return Err(document.malformed(self.from.span(), expected, "not both of them", next));
        };
        let window_s = window.checked(document, Dimension::Time)?;
        let mut begin_s: Vec<f64> = Vec::new();
        for begin in begin {
            let at = begin.not_negative(document, Dimension::Time)?;
            if let Some(before) = begin_s.last().filter(|before| **before + window_s > at) {
                let expected = format!("windows one after the other: from {} s on", before + window_s);
                return Err(document.malformed(begin.span(), expected, format!("{at} s"), "sort them"));
            }
            begin_s.push(at);
        }
        Ok(PointRule::Windows { begin_s, window_s, same_within_pa: self.same_within_pa(document)? })
    }

    fn plateaus(&self, document: &Document) -> Result<PointRule, IngestError> {
        let (Some(tolerance), Some(hold), Some(window)) = (&self.tolerance, &self.hold, &self.window) else {
            let next = "add what is missing, each as { value, unit }";
            let expected = "`tolerance`, `hold` and `window` beside from = \"plateaus\"";
            return Err(document.malformed(self.from.span(), expected, "not all of them", next));
        };
        let hold_s = hold.checked(document, Dimension::Time)?;
        let window_s = window.checked(document, Dimension::Time)?;
        if window_s > hold_s {
            let expected = format!("at most the hold of {hold_s} s");
            let next = "a window lies inside its plateau";
            return Err(document.malformed(window.span(), expected, format!("{window_s} s"), next));
        }
        let tolerance_pa = tolerance.checked(document, Dimension::Pressure)?;
        Ok(PointRule::Plateaus { tolerance_pa, hold_s, window_s })
    }

    fn trajectory(&self, document: &Document) -> Result<TrajectoryRule, IngestError> {
        let Some(at) = &self.at else {
            let expected = "`at` beside from = \"trajectory\"";
            let next = "say at = \"time\", \"pressure\" or \"arc-length\": what is equal where the two are compared";
            return Err(document.malformed(self.from.span(), expected, "nothing", next));
        };
        let at = *at.get_ref();
        let heeded: &[&str] = match at {
            Abscissa::Time => &["at", "match", "within", "gap", "overlap_min"],
            Abscissa::ArcLength => &["at", "gap", "overlap_min"],
            Abscissa::Pressure => &["at", "every"],
        };
        if let Some((key, span)) = self.keys().into_iter().find(|(key, _)| !heeded.contains(key)) {
            let expected = format!("no `{key}` beside at = \"{}\"", at.id());
            return Err(document.malformed(span, expected, "one", "remove it: nothing would heed it"));
        }
        let is_nearest = self.matching.as_ref().is_some_and(|m| *m.get_ref() == Match::Nearest);
        let matching = match (is_nearest, &self.within, &self.gap) {
            (true, Some(_), Some(gap)) => {
                let next = "remove it: nothing is interpolated";
                return Err(document.malformed(gap.span(), "no `gap` beside match = \"nearest\"", "one", next));
            }
            (true, Some(within), None) => Matching::Nearest { within_s: within.checked(document, Dimension::Time)? },
            (true, None, _) => {
                let next = "say how far apart two stamps may be: within = { value = 10, unit = \"ms\" }";
                let span = self.matching.as_ref().map_or(self.from.span(), Spanned::span);
                return Err(document.malformed(span, "`within` beside match = \"nearest\"", "nothing", next));
            }
            (false, Some(within), _) => {
                let next = "remove it, or say match = \"nearest\"";
                let expected = "`within` only beside match = \"nearest\"";
                return Err(document.malformed(within.span(), expected, "match = \"interpolate\"", next));
            }
            (false, None, _) => Matching::Interpolate,
        };
        let overlap = self.overlap_min.as_ref().map(|share| Ok((share.checked(document, Dimension::Ratio)?, share)));
        let overlap_min = match overlap.transpose()? {
            Some((share, amount)) if share > 1.0 => {
                let found = format!("{} %", 100.0 * share);
                return Err(document.malformed(amount.span(), "a share of at most 100 %", found, "correct it"));
            }
            Some((share, _)) => share,
            None => OVERLAP_MIN,
        };
        let every = self.every.as_ref().map_or(1, |every| *every.get_ref());
        if let Some(every) = self.every.as_ref().filter(|every| *every.get_ref() == 0) {
            return Err(document.malformed(every.span(), "a number > 0", "0", "leave it out to take every sample"));
        }
        let gap_s = self.gap.as_ref().map(|gap| gap.checked(document, Dimension::Time)).transpose()?;
        Ok(TrajectoryRule { at, matching, gap_s, overlap_min, every })
    }
}
