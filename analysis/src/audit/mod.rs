//! What a paper or a manuscript says, recomputed from its own printed numbers.
//!
//! A claims file lists statements, the numbers they rest on as printed, and a formula; nothing in it says what comes out. Outcomes:
//!
//! | outcome | meaning |
//! |---|---|
//! | `reproduced` | the printed numbers give the statement, to its last digit |
//! | `reproduced-by-rounding` | what the printed digits leave open, or an intermediate value rounded first, explains it |
//! | `contradicted` | they do not, or the units do not fit |
//! | `not-checkable` | a number it needs is not printed |
//!
//! | method | asks |
//! |---|---|
//! | `check`, `reading` | does a relation between formulas hold, with units: arithmetic, geometry, order of columns, models |
//! | `possible` | is there a whole count with the printed share (GRIM, Brown and Heathers 2017, doi:10.1177/1948550616673876) |
//! | `spread` | can a largest error and an RMSE be of one series: `rmse <= max <= rmse sqrt(n)` |
//! | `exists` | has a model a solution where the paper uses it |

mod check;
mod claims;
mod dimension;
mod number;

use serde::Serialize;

pub use check::{ModelSource, audit};
pub use claims::{Claims, Method};
pub use number::significant;

/// What became of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The printed numbers give it.
    Reproduced,
    /// They may, within what their digits leave open.
    ReproducedByRounding,
    /// They do not.
    Contradicted,
    /// A number is missing.
    NotCheckable,
}

impl Outcome {
    /// The word used in results.
    pub fn id(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::ReproducedByRounding => "reproduced-by-rounding",
            Self::Contradicted => "contradicted",
            Self::NotCheckable => "not-checkable",
        }
    }

    /// The outcome of a word.
    pub fn find(id: &str) -> Option<Self> {
        [Self::Reproduced, Self::ReproducedByRounding, Self::Contradicted, Self::NotCheckable]
            .into_iter()
            .find(|outcome| outcome.id() == id)
    }
}

/// The claims of a paper with their outcomes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Audited {
    /// Id of the paper.
    pub paper: String,
    /// Its title.
    pub title: String,
    /// The claims file.
    pub file: String,
    /// SHA-256 of it.
    pub sha256: String,
    /// One per claim, in the order of the file.
    pub claims: Vec<ClaimRecord>,
}

/// A claim and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClaimRecord {
    /// Its id.
    pub id: String,
    /// Where in the paper it stands.
    pub place: String,
    /// What the paper says.
    pub statement: String,
    /// How it was checked, in a word or two.
    pub method: &'static str,
    /// What became of it.
    pub outcome: Outcome,
    /// Whether that is what the file expects: an outcome of `expect`, or else reproduced in either way, or not checkable.
    pub as_expected: bool,
    /// The recomputation: formulas with numbers, or why there is none.
    pub recomputation: Vec<String>,
    /// Where several readings were tried: each with what became of it.
    pub readings: Vec<ReadingRecord>,
    /// The numbers it rests on.
    pub numbers: Vec<NumberRecord>,
    /// What a reader should know.
    pub remark: Option<String>,
}

/// One way to read a statement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingRecord {
    /// Its name.
    pub name: String,
    /// What became of it.
    pub outcome: Outcome,
    /// The recomputation.
    pub recomputation: Vec<String>,
}

/// A number that a claim rests on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NumberRecord {
    /// Its name in formulas.
    pub name: String,
    /// As printed, or as computed.
    pub text: String,
    /// Where it is from.
    pub from: String,
}

impl Audited {
    /// How many claims had an outcome.
    pub fn count(&self, outcome: Outcome) -> usize {
        self.claims.iter().filter(|claim| claim.outcome == outcome).count()
    }
}
