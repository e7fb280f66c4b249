//! What is compared, whatever it was read from: the responses of a dataset or session and the comparisons asked of them.

use pneuval_ingest::finding::Finding;
use pneuval_ingest::manifest::{
    Abscissa, Actuator, Align, ComparisonSpec, ImportedModel, Over, PointRule, PublishedDataset, Statistic,
};
use pneuval_ingest::session::Session;
use pneuval_models::catalogue::{self, Entry};

use crate::AnalysisError;
use crate::align::Alignment;
use crate::bounds::Bounds;
use crate::response::{Census, POINTS_MAX, Response};
use crate::results::SourceFile;

/// The data of an input.
pub enum Data {
    /// A paper's printed tables.
    Published(Box<PublishedDataset>),
    /// A sitting at a rig.
    Session(Box<Session>),
}

/// The form of a response that nothing predicts.
pub const NO_FORM: &str = "none";

/// A dataset or session with all that its comparisons need.
pub struct Input {
    /// `dataset.toml` or `session.toml` as the user named it.
    pub file: String,
    /// The data.
    pub data: Data,
    /// Its actuator.
    pub actuator: Actuator,
    /// The actuator file, relative to the dataset's folder.
    pub actuator_path: String,
    /// The bounds that apply, if any were found.
    pub bounds: Bounds,
    /// The bounds file, relative to the dataset's folder, with its digest.
    pub bounds_source: Option<SourceFile>,
    /// Whose bounds they are.
    pub bounds_scope: BoundsScope,
}

/// Whose bounds apply to a dataset: what a row that meets no comparison means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundsScope {
    /// They lie beside the dataset: such a row is a mistake.
    Own,
    /// They lie above it, or were named: such a row may be meant for a dataset that is not here, and is told.
    Shared,
    /// They are the embedded ones: such a row is for the embedded papers.
    Embedded,
}

/// A dataset or session, ready to be compared.
pub struct Study<'a> {
    /// Its id.
    pub id: &'a str,
    /// Where it comes from.
    pub input: &'a Input,
    /// What was measured.
    pub responses: Vec<Response>,
    /// Of a session, its runs on one time each.
    pub alignment: Alignment<'a>,
    /// Per response of a session, what became of its samples.
    pub censuses: Vec<Census>,
    /// What is compared with it.
    pub comparisons: Vec<ComparisonSpec>,
    /// Errors stated without their data.
    pub statistics: &'a [Statistic],
}

impl<'a> Study<'a> {
    /// The study of an input. A session that asks for no comparison is compared with every model there is.
    ///
    /// # Errors
    /// [`AnalysisError::TooManyPoints`] for a response that is a trajectory rather than a set of states; [`AnalysisError::Ingest`] for one
    /// whose pressure and motion were stamped by clocks that cannot be set against each other.
    pub fn of(input: &'a Input) -> Result<Self, AnalysisError> {
        match &input.data {
            Data::Published(dataset) => Ok(Self {
                id: &dataset.id,
                input,
                responses: dataset.tables.iter().map(Response::from).collect(),
                alignment: Alignment::default(),
                censuses: vec![],
                comparisons: dataset.comparisons.clone(),
                statistics: &dataset.statistics,
            }),
            Data::Session(session) => {
                let manifest = &session.manifest;
                let alignment = Alignment::of(session)?;
                let mut responses = Vec::new();
                let mut censuses = Vec::new();
                for spec in &manifest.responses {
                    let (response, census) =
                        Response::from_session(session, &alignment.runs, spec).map_err(|points| {
                            AnalysisError::TooManyPoints {
                                file: input.file.clone(),
                                line: spec.line,
                                quantity: spec.quantity.id.clone(),
                                points,
                                limit: POINTS_MAX,
                                next: match spec.points {
                                    PointRule::Trajectory(_) => {
                                        "add `every` to `points`: every = 10 takes one of ten samples"
                                    }
                                    _ => "say points = { from = \"plateaus\", … }",
                                },
                            }
                        })?;
                    responses.push(response);
                    censuses.push(census);
                }
                let mut comparisons = manifest.comparisons.clone();
                if comparisons.is_empty() {
                    comparisons = responses.iter().flat_map(|response| every(input, response)).collect();
                }
                Ok(Self { id: &manifest.id, input, responses, alignment, censuses, comparisons, statistics: &[] })
            }
        }
    }

    /// The response of a quantity.
    pub fn response(&self, quantity: &str) -> Option<&Response> {
        self.responses.iter().find(|r| r.quantity.id == quantity)
    }

    /// What is odd about the logs of a session.
    pub fn findings(&self) -> &[Finding] {
        match &self.input.data {
            Data::Published(_) => &[],
            Data::Session(session) => &session.findings,
        }
    }

    /// Its comparisons: quantity and form.
    pub fn posed(&self) -> Vec<(String, String)> {
        let computed = self.comparisons.iter().map(|s| (s.quantity.clone(), s.form.clone()));
        computed.chain(self.statistics.iter().map(|s| (s.quantity.id.clone(), s.form.clone()))).collect()
    }

    /// Measurements and printed predictions that no comparison uses.
    pub fn uncompared(&self) -> Vec<String> {
        let mut texts = Vec::new();
        for response in &self.responses {
            let quantity = &response.quantity.id;
            let specs = || self.comparisons.iter().filter(|s| s.quantity == *quantity);
            if specs().next().is_none() {
                texts.push(format!("{quantity} of {} is compared with nothing", self.id));
                continue;
            }
            let compared = |form: &str| specs().any(|s| s.form == form || s.fit.as_ref().is_some_and(|f| f.to == form));
            let forms = response.columns.iter().filter(|p| !compared(&p.form));
            texts.extend(forms.map(|p| format!("{} of {quantity} of {} is compared with nothing", p.form, self.id)));
        }
        texts
    }
}

/// Whether a catalogue form predicts what a response measures: unit, components, chambers, and its conditions are there.
pub fn suits(entry: &Entry, response: &Response) -> bool {
    let has = |name: &str, si_unit: &str| {
        response.conditions.iter().any(|c| c.id == name && c.unit.dimension.si_symbol() == si_unit)
    };
    entry.quantity == response.quantity.id
        && response.movement.is_none()
        && entry.quantity_si_unit == response.quantity.unit.dimension.si_symbol()
        && response.quantity.components == entry.components
        && response.chambers == entry.chambers
        && entry.conditions.iter().all(|c| has(c.name, c.si_unit))
}

/// A comparison with every model of a response, or with none where there is none.
fn every(input: &Input, response: &Response) -> Vec<ComparisonSpec> {
    let actuator = &input.actuator;
    let entries = catalogue::entries().filter(|e| e.actuator == actuator.kind && suits(e, response)).map(|e| e.form);
    // A table over time meets nothing at equal pressure, and one over pressure nothing at equal time.
    let at = response.movement.as_ref().map(|movement| movement.rule.at);
    let suits_axis = |m: &&ImportedModel| match m.over {
        Over::Pressure { .. } => at != Some(Abscissa::Time),
        Over::Time { .. } => at.is_some(),
    };
    let imported = actuator.imported.iter().filter(|m| m.quantity.id == response.quantity.id).filter(suits_axis);
    let imported = imported.map(|m| m.form.as_str());
    let spec = |form: &str| ComparisonSpec {
        quantity: response.quantity.id.clone(),
        form: form.to_owned(),
        model: None,
        title: None,
        fit: None,
        align: Align::None,
        not_judged: None,
        remark: None,
        line: 1,
    };
    let mut specs: Vec<ComparisonSpec> = entries.chain(imported).map(spec).collect();
    // A table of the name of a catalogue form takes its place; a finding says so.
    let mut seen = Vec::new();
    specs.retain(|spec| {
        let new = !seen.contains(&spec.form);
        seen.push(spec.form.clone());
        new
    });
    if specs.is_empty() {
        specs.push(spec(NO_FORM));
    }
    specs
}
