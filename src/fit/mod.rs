//! `pneuval fit`: constants from measured values, with what the values know of them.

mod actuator;
mod arguments;
mod expression;
mod material;
mod words;

pub use arguments::Fit;
use arguments::Fitted;

use crate::exit::{Failure, Outcome};

pub fn run(arguments: &Fit) -> Result<Outcome, Failure> {
    match &arguments.what {
        Fitted::Actuator(arguments) => actuator::run(arguments),
        Fitted::Material(arguments) => material::run(arguments),
        Fitted::Expression(arguments) => expression::run(arguments),
    }
}
