//! Scalings: from the numbers that a card wrote to what they stand for, as the properties `NI_Scale[i]_..` state it.
//!
//! A channel states its scales, or its group does, or the file. Each takes the raw values, those of a scaler of the card, or what
//! another scale gives; the last one gives the channel's values. What is stated is checked once, before the first value: the
//! program that comes of it cannot fail. A scaling that is not understood is an error and never leaves raw numbers in its place.

mod equations;
mod stated;
mod strain;
#[cfg(test)]
mod tests;
mod thermistor;

use std::collections::BTreeSet;
use std::ops::Range;

use super::value::Properties;
use crate::error::shown;
use crate::limits::TDMS_SCALE_NUMBERS_MAX;
use equations::Equation;
use stated::{Input, Stated, Status, kind_of, scales_of, status_of};

/// Why a scaling cannot be applied, as a sentence without a full stop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Unsupported(pub String);

/// A checked scaling.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scaling {
    /// In an order in which each takes only what comes before it.
    steps: Vec<Step>,
    /// What the last scale gives: of a step only the last.
    result: Source,
    scalers: Vec<u32>,
    takes_raw: bool,
}

/// Buffers of [`Scaling::apply`], which all channels share.
#[derive(Debug, Default)]
pub(super) struct Scratch(Vec<Vec<f64>>);

/// Where values come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Raw,
    /// By its place among [`Scaling::scalers`].
    Scaler(usize),
    /// By its number.
    Step(usize),
}

#[derive(Debug, Clone, PartialEq)]
enum Step {
    Of(Equation, Source),
    Add(Source, Source),
    /// The first less the second.
    Subtract(Source, Source),
}

impl Step {
    fn sources(&self) -> [Source; 2] {
        match *self {
            Self::Of(_, source) => [source, source],
            Self::Add(left, right) | Self::Subtract(left, right) => [left, right],
        }
    }
}

/// Values scaled at once: what every step gives of them stays in the cache.
const BLOCK: usize = 1024;

impl Scaling {
    /// The scaling of a channel: as it states it, or else its group, or else the file. `None` where no scale is stated, or the values
    /// are scaled already.
    pub fn of(channel: &Properties, group: &Properties, file: &Properties) -> Result<Option<Self>, Unsupported> {
        for properties in [channel, group, file] {
            let (status, scales) = (status_of(properties), scales_of(properties)?);
            match (status, scales) {
                (Status::Scaled, _) => return Ok(None),
                (_, 0) => {}
                (Status::Unscaled, scales) => return Compiler::compile(properties, scales).map(Some),
                (Status::Unknown(status), _) => {
                    let status = shown(&status);
                    return Err(Unsupported(format!("`NI_Scaling_Status` is {status}, neither scaled nor unscaled")));
                }
            }
        }
        Ok(None)
    }

    /// Ids of the scalers whose values it takes, ascending.
    pub fn scalers(&self) -> &[u32] {
        &self.scalers
    }

    /// Whether it takes the raw values of the channel.
    pub fn takes_raw(&self) -> bool {
        self.takes_raw
    }

    /// Scales values and adds them to `out`. `scalers` are those of [`scalers`](Self::scalers), in that order; `raw` is looked at only
    /// if it [`takes_raw`](Self::takes_raw). All that are looked at have one length; of longer ones the beginning is.
    ///
    /// A value outside the domain of an equation, and NaN, gives NaN.
    pub fn apply(&self, raw: &[f64], scalers: &[&[f64]], scratch: &mut Scratch, out: &mut Vec<f64>) {
        let lengths = scalers.iter().map(|scaler| scaler.len());
        let length = lengths.chain(self.takes_raw.then_some(raw.len())).min().unwrap_or(0);
        let buffers = &mut scratch.0;
        if buffers.len() < self.steps.len() {
            buffers.resize_with(self.steps.len(), Vec::new);
        }
        out.reserve(length);
        for start in (0..length).step_by(BLOCK) {
            let range = start..length.min(start + BLOCK);
            let Some((last, before)) = self.steps.split_last() else {
                out.extend_from_slice(self.result.values(raw, scalers, &[], range));
                continue;
            };
            for (number, step) in before.iter().enumerate() {
                let mut own = std::mem::take(&mut buffers[number]);
                own.clear();
                step.run(|source| source.values(raw, scalers, buffers, range.clone()), &mut own);
                buffers[number] = own;
            }
            last.run(|source| source.values(raw, scalers, buffers, range.clone()), out);
        }
    }
}

impl Source {
    /// Values of a block; none where the caller gave fewer than the program takes.
    fn values<'v>(
        self,
        raw: &'v [f64],
        scalers: &[&'v [f64]],
        steps: &'v [Vec<f64>],
        block: Range<usize>,
    ) -> &'v [f64] {
        let values = match self {
            Self::Raw => raw.get(block),
            Self::Scaler(place) => scalers.get(place).and_then(|scaler| scaler.get(block)),
            Self::Step(number) => steps.get(number).map(Vec::as_slice),
        };
        values.unwrap_or_default()
    }
}

impl Step {
    /// Adds what it gives to `out`.
    fn run<'v>(&self, values: impl Fn(Source) -> &'v [f64], out: &mut Vec<f64>) {
        match self {
            Self::Of(equation, source) => equation.apply(values(*source), out),
            Self::Add(left, right) => out.extend(values(*left).iter().zip(values(*right)).map(|(a, b)| a + b)),
            Self::Subtract(from, what) => out.extend(values(*from).iter().zip(values(*what)).map(|(a, b)| a - b)),
        }
    }
}

/// Turns scales into steps, from the last scale down to what it takes. A scale that nothing takes is not looked at.
struct Compiler<'p> {
    properties: &'p Properties,
    /// How far every scale is.
    states: Vec<State>,
    scalers: BTreeSet<usize>,
    steps: Vec<Step>,
    /// How many more numbers tables and polynomials may hold.
    numbers: usize,
}

#[derive(Clone, Copy)]
enum State {
    Untouched,
    /// What it takes is being looked at.
    Open,
    Done(Source),
}

impl<'p> Compiler<'p> {
    fn compile(properties: &'p Properties, scales: usize) -> Result<Scaling, Unsupported> {
        let states = vec![State::Untouched; scales];
        let numbers = TDMS_SCALE_NUMBERS_MAX;
        let mut compiler = Self { properties, states, scalers: BTreeSet::new(), steps: vec![], numbers };
        let result = compiler.input(Input::Scale(scales.saturating_sub(1)))?;
        // Until here scalers are given by their ids.
        let ids = compiler.scalers;
        let place = |source| match source {
            Source::Scaler(id) => Source::Scaler(ids.range(..id).count()),
            other => other,
        };
        let placed = |step| match step {
            Step::Of(equation, source) => Step::Of(equation, place(source)),
            Step::Add(left, right) => Step::Add(place(left), place(right)),
            Step::Subtract(from, what) => Step::Subtract(place(from), place(what)),
        };
        let steps: Vec<Step> = compiler.steps.into_iter().map(placed).collect();
        let takes_raw = result == Source::Raw || steps.iter().any(|step| step.sources().contains(&Source::Raw));
        let scalers = ids.iter().filter_map(|id| u32::try_from(*id).ok()).collect();
        Ok(Scaling { steps, result: place(result), scalers, takes_raw })
    }

    /// What an input gives. No scale is opened twice, so this calls itself no deeper than there are scales.
    fn input(&mut self, input: Input) -> Result<Source, Unsupported> {
        let Input::Scale(id) = input else { return Ok(Source::Raw) };
        match self.states[id] {
            State::Done(source) => Ok(source),
            State::Open => Err(Unsupported(format!("scale {id} takes its own values"))),
            State::Untouched => {
                self.states[id] = State::Open;
                let source = self.scale(id)?;
                self.states[id] = State::Done(source);
                Ok(source)
            }
        }
    }

    fn scale(&mut self, id: usize) -> Result<Source, Unsupported> {
        let Some(kind) = kind_of(self.properties, id)? else {
            self.scalers.insert(id);
            return Ok(Source::Scaler(id));
        };
        let stated = Stated { properties: self.properties, id, kind, scales: self.states.len() };
        let step = match kind {
            "AdvancedAPI" => return self.input(stated.input_or_raw("Input_Source")?),
            "Add" => {
                let [left, right] = self.operands(&stated)?;
                Step::Add(left, right)
            }
            "Subtract" => {
                let [left, right] = self.operands(&stated)?;
                // The left operand is what is taken away: so NI's plug-in for Excel has it, and npTDMS.
                Step::Subtract(right, left)
            }
            "Linear" | "Polynomial" | "Table" => {
                let source = self.input(stated.input_or_raw("Input_Source")?)?;
                Step::Of(Equation::of(&stated, &mut self.numbers)?, source)
            }
            "Thermistor" | "Strain" => {
                let source = self.input(stated.input("Input_Source")?)?;
                Step::Of(Equation::of(&stated, &mut self.numbers)?, source)
            }
            "RTD" | "Thermocouple" => {
                return Err(Unsupported(format!("scale {id} is of the type {kind}, which is not supported")));
            }
            other => {
                return Err(Unsupported(format!("scale {id} is of the type {}, which is not known", shown(other))));
            }
        };
        self.steps.push(step);
        Ok(Source::Step(self.steps.len() - 1))
    }

    fn operands(&mut self, stated: &Stated) -> Result<[Source; 2], Unsupported> {
        let (left, right) = (stated.input("Left_Operand_Input_Source")?, stated.input("Right_Operand_Input_Source")?);
        Ok([self.input(left)?, self.input(right)?])
    }
}
