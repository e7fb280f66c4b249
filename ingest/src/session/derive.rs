//! Channels computed once from others.
//!
//! | rule | value | standard uncertainty, where every source declares one |
//! |---|---|---|
//! | difference | a - b | √(ua² + ub²) |
//! | product | a b, contact pressure × area | √((A ub)² + (B ua)²), A and B the largest sizes of the run |
//! | displacement | distance of r from r0 | √2 × the largest of the coordinates |
//! | transmitter distance | length of r less length of r0 | the same |
//!
//! r0 is the position at the first sample, which must be a position; a finding says where it is.

use std::collections::BTreeMap;

use super::reader::Reader;
use super::{Channel, Stream};
use crate::error::IngestError;
use crate::finding::{Finding, FindingKind, Severity, Span};
use crate::manifest::{DerivedRule, DerivedSpec, RunSpec};
use crate::units::Dimension;

impl Reader<'_> {
    /// A channel derived from those before it.
    pub fn derive(
        &self,
        spec: &DerivedSpec,
        run: &RunSpec,
        channels: &BTreeMap<String, Channel>,
        streams: &[Stream],
        findings: &mut Vec<Finding>,
    ) -> Result<Channel, IngestError> {
        // The manifest's reader lets a derived channel name only channels above it.
        let from: Vec<&Channel> = spec.from.iter().filter_map(|id| channels.get(id)).collect();
        self.check(spec.unit, self.dimension(spec, &from)?, spec.line)?;
        let stream = self.shared_stream(spec, &from, streams)?;
        let (seconds, lines) = (streams[stream].seconds.as_deref(), &streams[stream].lines);
        let samples = from.iter().map(|c| c.values_si.len()).min().unwrap_or(0);
        let at = |i: usize| -> Vec<f64> { from.iter().map(|c| c.values_si[i]).collect() };
        let moves = matches!(spec.rule, DerivedRule::Displacement | DerivedRule::TransmitterDistance);
        // The first sample that the clock leaves in.
        let first = (0..samples).find(|&i| moves && seconds.is_none_or(|s| s[i].is_finite()));
        let start = first.map(|i| {
            findings.push(origin(spec, run, &at(i), (i, lines.line_of(i)), samples));
            at(i)
        });
        let norm = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
        let value = |r: Vec<f64>| match (spec.rule, &start) {
            (DerivedRule::Difference, _) => r[0] - r[1],
            (DerivedRule::Product, _) => r[0] * r[1],
            (DerivedRule::Displacement, Some(start)) => {
                norm(&r.iter().zip(start).map(|(a, b)| a - b).collect::<Vec<_>>())
            }
            (DerivedRule::TransmitterDistance, Some(start)) => norm(&r) - norm(start),
            _ => f64::NAN,
        };
        Ok(Channel {
            stream,
            unit: spec.unit,
            values_si: (0..samples).map(|i| value(at(i))).collect(),
            std_si: uncertainty(spec.rule, &from),
            commanded: from.iter().any(|c| c.commanded),
        })
    }

    /// The stream that the sources share: samples of two clocks do not belong together by their number.
    fn shared_stream(&self, spec: &DerivedSpec, from: &[&Channel], streams: &[Stream]) -> Result<usize, IngestError> {
        let mut of: Vec<usize> = from.iter().map(|channel| channel.stream).collect();
        of.dedup();
        if let [one] = of[..] {
            return Ok(one);
        }
        let names: Vec<&str> = of.iter().map(|&stream| streams[stream].name.as_str()).collect();
        let next = "derive it from channels of one topic".to_owned();
        Err(self.malformed(spec.line, "channels that share one clock", &names.join(", "), next))
    }

    fn dimension(&self, spec: &DerivedSpec, from: &[&Channel]) -> Result<Dimension, IngestError> {
        let dimensions: Vec<Dimension> = from.iter().map(|c| c.unit.dimension).collect();
        let alike = dimensions.windows(2).all(|pair| pair[0] == pair[1]);
        let expected = match (spec.rule, dimensions.as_slice()) {
            (DerivedRule::Difference, [one, _]) if alike => return Ok(*one),
            (DerivedRule::Product, [Dimension::Pressure, Dimension::Area] | [Dimension::Area, Dimension::Pressure]) => {
                return Ok(Dimension::Force);
            }
            (DerivedRule::Displacement | DerivedRule::TransmitterDistance, [Dimension::Length, ..]) if alike => {
                return Ok(Dimension::Length);
            }
            (DerivedRule::Difference, _) => "two channels of one kind",
            (DerivedRule::Product, _) => "a pressure and an area",
            (DerivedRule::Displacement | DerivedRule::TransmitterDistance, _) => "lengths",
        };
        let found: Vec<&str> = dimensions.iter().map(|d| d.name()).collect();
        Err(self.malformed(spec.line, expected, &found.join(", "), "name other channels".to_owned()))
    }
}

/// Where a displacement starts: the first sample, or nowhere if that is no position.
fn origin(spec: &DerivedSpec, run: &RunSpec, r0: &[f64], (sample, line): (usize, usize), samples: usize) -> Finding {
    let name = format!("channel `{}` of run {}", spec.id, run.id);
    let (severity, count, text) = if r0.iter().all(|v| v.is_finite()) {
        let at: Vec<String> = r0.iter().map(|v| spec.unit.from_si(*v).to_string()).collect();
        let text = format!("{name}: starts from ({}) {} at line {line}", at.join(", "), spec.unit.symbol);
        (Severity::Note, 1, text)
    } else {
        let text = format!("{name}: its first sample, line {line}, is no position, so there is nothing to start from");
        (Severity::Excluded, samples, text)
    };
    Finding {
        kind: FindingKind::Tared,
        severity,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: vec![Span { first_sample: sample, last_sample: sample, first_line: line, last_line: line }],
        count,
        text,
    }
}

/// The standard uncertainty of a derived channel; `None` if a source declares none.
fn uncertainty(rule: DerivedRule, from: &[&Channel]) -> Option<f64> {
    let stds = from.iter().map(|c| c.std_si).collect::<Option<Vec<f64>>>()?;
    let largest = |c: &Channel| c.values_si.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
    match (rule, from, stds.as_slice()) {
        (DerivedRule::Difference, _, [a, b]) => Some(a.hypot(*b)),
        (DerivedRule::Product, [a, b], [ua, ub]) => Some((largest(a) * ub).hypot(largest(b) * ua)),
        (DerivedRule::Displacement | DerivedRule::TransmitterDistance, _, all) => {
            Some(std::f64::consts::SQRT_2 * all.iter().copied().fold(0.0, f64::max))
        }
        _ => None,
    }
}
