//! What is said of two formulas: `(a - b)/b = gain`, `error <= bound`.

use super::{Expression, ParseError, parse};

/// A relation between two formulas.
#[derive(Debug, Clone, PartialEq)]
pub struct Relation {
    /// What stands on the left.
    pub left: Expression,
    /// What is said.
    pub kind: RelationKind,
    /// What stands on the right.
    pub right: Expression,
}

/// What a relation says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RelationKind {
    /// Both are the same.
    Equal,
    /// The left is smaller.
    Less,
    /// The left is not larger.
    LessOrEqual,
    /// The left is larger.
    Greater,
    /// The left is not smaller.
    GreaterOrEqual,
}

impl RelationKind {
    /// As in formulas.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Equal => "=",
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
        }
    }
}

impl Relation {
    /// Reads a relation.
    ///
    /// # Errors
    /// [`ParseError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        parse::relation(text)
    }
}
