//! Plain numbers, and exact derivatives by the chain rule run backwards.

use super::{Expression, Function, Node, Operation};

/// Room for the values and slopes of nodes, kept between points.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Expression {
    /// Its value at numbers in the order of [`Expression::symbols`].
    pub fn value(&self, symbols: &[f64]) -> f64 {
        let mut values = Vec::with_capacity(self.nodes.len());
        self.run(symbols, &mut values);
        // A formula has at least one node.
        values.last().copied().unwrap_or(f64::NAN)
    }

    /// Its value, and its derivative by each symbol.
    pub fn value_and_gradient(&self, symbols: &[f64]) -> (f64, Vec<f64>) {
        let mut gradient = vec![0.0; symbols.len()];
        let value = self.gradient_into(symbols, &mut Workspace::default(), &mut gradient);
        (value, gradient)
    }

    /// As [`Expression::value_and_gradient`], without allocating.
    pub fn gradient_into(&self, symbols: &[f64], room: &mut Workspace, gradient: &mut [f64]) -> f64 {
        self.run(symbols, &mut room.values);
        let values = &room.values;
        room.slopes.clear();
        room.slopes.resize(values.len(), 0.0);
        gradient.fill(0.0);
        if let Some(last) = room.slopes.last_mut() {
            *last = 1.0;
        }
        for (i, node) in self.nodes.iter().enumerate().rev() {
            let slope = room.slopes[i];
            // Nothing depends on it here: no 0 × infinity.
            if slope == 0.0 {
                continue;
            }
            match node {
                Node::Constant(_) => {}
                Node::Symbol(symbol) => gradient[*symbol] += slope,
                Node::Apply(operation, arguments) => {
                    let of = |k: usize| values[arguments[k]];
                    let mut add = |k: usize, by: f64| {
                        // A factor of exactly zero says that the argument has no influence, whatever the other is.
                        room.slopes[arguments[k]] += slope * by;
                    };
                    match operation {
                        Operation::Negate => add(0, -1.0),
                        Operation::Add => {
                            add(0, 1.0);
                            add(1, 1.0);
                        }
                        Operation::Subtract => {
                            add(0, 1.0);
                            add(1, -1.0);
                        }
                        Operation::Multiply => {
                            let (a, b) = (of(0), of(1));
                            add(0, b);
                            add(1, a);
                        }
                        Operation::Divide => {
                            let (a, b) = (of(0), of(1));
                            add(0, 1.0 / b);
                            add(1, -a / (b * b));
                        }
                        Operation::Power => {
                            let (a, b) = (of(0), of(1));
                            add(0, if b == 0.0 { 0.0 } else { b * power(a, b - 1.0) });
                            if !matches!(self.nodes[arguments[1]], Node::Constant(_)) {
                                add(1, if a == 0.0 { 0.0 } else { values[i] * a.ln() });
                            }
                        }
                        Operation::Call(Function::Min | Function::Max) => {
                            // The argument that is the value moves it.
                            let k = (0..arguments.len()).find(|&k| of(k).total_cmp(&values[i]).is_eq()).unwrap_or(0);
                            add(k, 1.0);
                        }
                        Operation::Call(function) => add(0, slope_of(*function, of(0), values[i])),
                    }
                }
            }
        }
        // A formula has at least one node.
        values.last().copied().unwrap_or(f64::NAN)
    }

    /// The values of all nodes.
    fn run(&self, symbols: &[f64], values: &mut Vec<f64>) {
        values.clear();
        for node in &self.nodes {
            let value = match node {
                Node::Constant(value) => *value,
                Node::Symbol(i) => symbols[*i],
                Node::Apply(operation, arguments) => {
                    let of = |k: usize| values[arguments[k]];
                    match operation {
                        Operation::Negate => -of(0),
                        Operation::Add => of(0) + of(1),
                        Operation::Subtract => of(0) - of(1),
                        Operation::Multiply => of(0) * of(1),
                        Operation::Divide => of(0) / of(1),
                        Operation::Power => power(of(0), of(1)),
                        // A comparison loses a NaN, which must not get lost.
                        Operation::Call(Function::Min) => extreme(arguments.iter().map(|&i| values[i]), f64::min),
                        Operation::Call(Function::Max) => extreme(arguments.iter().map(|&i| values[i]), f64::max),
                        Operation::Call(function) => function.at(of(0)),
                    }
                }
            };
            values.push(value);
        }
    }
}

/// The smallest or largest, NaN if one is.
fn extreme(values: impl Iterator<Item = f64>, choose: fn(f64, f64) -> f64) -> f64 {
    values.reduce(|a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { choose(a, b) }).unwrap_or(f64::NAN)
}

/// Whole powers by multiplication: of negative numbers, too, and to the last digit.
fn power(base: f64, exponent: f64) -> f64 {
    const WHOLE_MAX: f64 = 1024.0;
    if exponent.fract() == 0.0 && exponent.abs() <= WHOLE_MAX {
        // Whole and below 1024.
        #[expect(clippy::cast_possible_truncation)]
        return base.powi(exponent as i32);
    }
    base.powf(exponent)
}

/// Slope of a function at a number, given its value there.
fn slope_of(function: Function, x: f64, value: f64) -> f64 {
    match function {
        Function::Exp => value,
        Function::Ln => 1.0 / x,
        Function::Log10 => std::f64::consts::LOG10_E / x,
        Function::Sqrt => 0.5 / value,
        Function::Abs | Function::Rms => x.signum(),
        Function::Sin => x.cos(),
        Function::Cos => -x.sin(),
        Function::Tan => 1.0 + value * value,
        Function::Asin => 1.0 / (1.0 - x * x).sqrt(),
        Function::Acos => -1.0 / (1.0 - x * x).sqrt(),
        Function::Atan => 1.0 / (1.0 + x * x),
        Function::Sinh => x.cosh(),
        Function::Cosh => x.sinh(),
        Function::Tanh => 1.0 - value * value,
        Function::Min | Function::Max | Function::Mean | Function::Sum => 1.0,
        Function::Count => 0.0,
    }
}
