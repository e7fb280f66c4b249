//! Formulas as people write them: `b1*(1 - exp(-b2*x))`.
//!
//! A formula is read once and evaluated in any [`Algebra`]: plain numbers here, numbers with units and rounding intervals
//! elsewhere. [`Expression::value_and_gradient`] differentiates it exactly, by running the chain rule backwards.
//!
//! | written | means |
//! |---|---|
//! | `+ - * /`, `^` or `**` | arithmetic; powers bind first and from the right, so `-x^2` is `-(x^2)` |
//! | `( )`, `[ ]` | brackets, either kind |
//! | `exp ln log log10 sqrt abs`, `sin cos tan asin acos atan`, `arcsin arccos arctan`, `sinh cosh tanh` | functions; `log` is the natural logarithm |
//! | `min max` | the smallest and largest of their arguments |
//! | `mean sum rms count` | over the rows of a column, in an algebra that has columns |
//! | `pi` | the number |
//!
//! # Check value
//! ```
//! use pneuval_models::expression::Expression;
//! let formula = Expression::parse("b1*(1 - exp(-b2*x))")?;
//! assert_eq!(formula.symbols(), ["b1", "b2", "x"]);
//! let (value, gradient) = formula.value_and_gradient(&[2.0, 0.5, 3.0]);
//! assert!((value - 2.0 * (1.0 - (-1.5_f64).exp())).abs() < 1e-15);
//! assert!((gradient[0] - (1.0 - (-1.5_f64).exp())).abs() < 1e-15);
//! assert!((gradient[1] - 2.0 * 3.0 * (-1.5_f64).exp()).abs() < 1e-15);
//! # Ok::<(), pneuval_models::expression::ParseError>(())
//! ```

mod gradient;
mod parse;
mod precise;
mod relation;
mod two_float;

pub use gradient::Workspace;
pub use parse::ParseError;
pub use precise::{Precise, decimal};
pub use relation::{Relation, RelationKind};
pub use two_float::TwoFloat;

/// What a node of a formula does to the nodes below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// -a
    Negate,
    /// a + b
    Add,
    /// a - b
    Subtract,
    /// a b
    Multiply,
    /// a / b
    Divide,
    /// a to the power b
    Power,
    /// A named function.
    Call(Function),
}

/// A function that formulas know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// e to the power.
    Exp,
    /// Natural logarithm.
    Ln,
    /// Logarithm to base 10.
    Log10,
    /// Square root.
    Sqrt,
    /// Absolute value.
    Abs,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Inverse sine.
    Asin,
    /// Inverse cosine.
    Acos,
    /// Inverse tangent.
    Atan,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// The smallest argument, or row of a column.
    Min,
    /// The largest argument, or row of a column.
    Max,
    /// Mean over the rows of a column.
    Mean,
    /// Sum over the rows of a column.
    Sum,
    /// Root mean square over the rows of a column.
    Rms,
    /// Number of rows of a column.
    Count,
}

impl Function {
    const NAMES: [(&'static str, Self); 24] = [
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("log", Self::Ln),
        ("log10", Self::Log10),
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("arcsin", Self::Asin),
        ("arccos", Self::Acos),
        ("arctan", Self::Atan),
        ("sinh", Self::Sinh),
        ("cosh", Self::Cosh),
        ("tanh", Self::Tanh),
        ("min", Self::Min),
        ("max", Self::Max),
        ("mean", Self::Mean),
        ("sum", Self::Sum),
        ("rms", Self::Rms),
        ("count", Self::Count),
    ];

    fn find(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    /// Its name in formulas.
    pub fn name(self) -> &'static str {
        // Every function stands in the table; a test holds it to that.
        Self::NAMES.iter().find(|(_, function)| *function == self).map_or("?", |(name, _)| *name)
    }

    /// Whether it takes several arguments, and columns as a whole.
    pub fn is_over_rows(self) -> bool {
        matches!(self, Self::Min | Self::Max | Self::Mean | Self::Sum | Self::Rms | Self::Count)
    }

    /// Its value at a number; of functions over rows, which see one row here, that of the row.
    pub fn at(self, x: f64) -> f64 {
        match self {
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log10 => x.log10(),
            Self::Sqrt => x.sqrt(),
            Self::Abs | Self::Rms => x.abs(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Min | Self::Max | Self::Mean | Self::Sum => x,
            Self::Count => 1.0,
        }
    }
}

/// A node; it refers only to nodes before it, so one pass from the first to the last evaluates a formula.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// A number.
    Constant(f64),
    /// A symbol, by its place among [`Expression::symbols`].
    Symbol(usize),
    /// An operation on nodes.
    Apply(Operation, Vec<usize>),
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    pub(crate) nodes: Vec<Node>,
    symbols: Vec<String>,
    text: String,
}

/// A kind of number in which formulas can be evaluated.
pub trait Algebra {
    /// The number.
    type Value: Clone;
    /// Why an operation has no value.
    type Error;

    /// A number that stands in the formula.
    fn constant(&self, value: f64) -> Self::Value;

    /// The value of an operation.
    ///
    /// # Errors
    /// If the operation has none.
    fn apply(&self, operation: Operation, arguments: &[&Self::Value]) -> Result<Self::Value, Self::Error>;
}

impl Expression {
    /// Reads a formula.
    ///
    /// # Errors
    /// [`ParseError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        parse::whole(text)
    }

    /// The names that stand for numbers, in the order in which they first occur.
    pub fn symbols(&self) -> &[String] {
        &self.symbols
    }

    /// The formula as written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its value in an algebra; `symbols` in the order of [`Expression::symbols`].
    ///
    /// # Errors
    /// The algebra's.
    pub fn evaluate<A: Algebra>(&self, algebra: &A, symbols: &[A::Value]) -> Result<A::Value, A::Error> {
        let mut values: Vec<A::Value> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let value = match node {
                Node::Constant(value) => algebra.constant(*value),
                Node::Symbol(i) => symbols[*i].clone(),
                Node::Apply(operation, arguments) => {
                    let arguments: Vec<&A::Value> = arguments.iter().map(|&i| &values[i]).collect();
                    algebra.apply(*operation, &arguments)?
                }
            };
            values.push(value);
        }
        // A formula has at least one node: the parser refuses an empty one.
        Ok(values.swap_remove(self.nodes.len() - 1))
    }

    /// Whether the formula is a straight line in all of these symbols together, whatever the others are; decided by how it is
    /// written, so that `ln(exp(b))` is not.
    pub fn is_linear_in(&self, symbols: &[usize]) -> bool {
        // Degree in the symbols; `None` is more than a polynomial.
        let mut degrees: Vec<Option<f64>> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let degree = match node {
                Node::Constant(_) => Some(0.0),
                Node::Symbol(i) => Some(if symbols.contains(i) { 1.0 } else { 0.0 }),
                Node::Apply(operation, arguments) => {
                    let of = |k: usize| arguments.get(k).and_then(|&i| degrees[i]);
                    let flat = arguments.iter().all(|&i| degrees[i] == Some(0.0));
                    match operation {
                        _ if flat => Some(0.0),
                        Operation::Negate => of(0),
                        Operation::Add | Operation::Subtract => of(0).zip(of(1)).map(|(a, b)| a.max(b)),
                        Operation::Multiply => of(0).zip(of(1)).map(|(a, b)| a + b),
                        Operation::Divide => of(0).filter(|_| of(1) == Some(0.0)),
                        Operation::Power => match arguments.get(1).map(|&i| &self.nodes[i]) {
                            Some(Node::Constant(power)) if *power >= 0.0 && power.fract() == 0.0 => {
                                of(0).map(|degree| degree * power)
                            }
                            _ => None,
                        },
                        Operation::Call(_) => None,
                    }
                }
            };
            degrees.push(degree);
        }
        degrees.last().copied().flatten().is_some_and(|degree| degree <= 1.0)
    }
}
