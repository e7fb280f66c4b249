//! The files of NIST's Statistical Reference Datasets for nonlinear regression: data, starts and certified values in one text.
//!
//! <https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml>: `b1 = start 1, start 2, certified value, its standard deviation`, then the
//! data below a line `Data: y x`.

use serde::Serialize;

use super::expression::Fitted;

/// A certified dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct Certified {
    /// Its name.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<CertifiedParameter>,
    /// Certified sum of squared residuals.
    pub sum_of_squares: f64,
    /// Columns by name.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// A parameter of a certified dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct CertifiedParameter {
    /// Its name.
    pub name: String,
    /// The two starts.
    pub starts: [f64; 2],
    /// Certified value.
    pub value: f64,
    /// Certified standard deviation.
    pub std: f64,
}

/// How many digits of a fit are those certified, parameter by parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// The dataset.
    pub dataset: String,
    /// Fewest correct digits of a parameter.
    pub parameter_digits: f64,
    /// Fewest correct digits of a standard deviation; `None` where the fit has none.
    pub std_digits: Option<f64>,
    /// Correct digits of the sum of squares.
    pub sum_of_squares_digits: f64,
}

impl Certified {
    /// Reads such a file; `None` if it is none.
    pub fn read(text: &str) -> Option<Self> {
        if !text.trim_start().starts_with("NIST/ITL StRD") {
            return None;
        }
        let after = |label: &str| text.lines().find_map(|line| line.trim().strip_prefix(label).map(str::trim));
        let name = after("Dataset Name:")?.split_whitespace().next()?.to_owned();
        let mut parameters = Vec::new();
        for line in text.lines() {
            let Some((name, numbers)) = line.split_once('=') else { continue };
            let name = name.trim();
            let is_parameter = name.strip_prefix('b').is_some_and(|rest| rest.parse::<u32>().is_ok());
            let numbers: Option<Vec<f64>> = numbers.split_whitespace().map(|word| word.parse().ok()).collect();
            if let (true, Some(&[first, second, value, std])) = (is_parameter, numbers.as_deref()) {
                let name = name.to_owned();
                parameters.push(CertifiedParameter { name, starts: [first, second], value, std });
            }
        }
        let sum_of_squares = after("Residual Sum of Squares:")?.parse().ok()?;
        // The first "Data:" describes the variables, the last stands above them.
        let above = text.lines().enumerate().filter(|(_, line)| line.starts_with("Data:")).last()?;
        let names: Vec<&str> = above.1.trim_start_matches("Data:").split_whitespace().collect();
        let mut columns: Vec<(String, Vec<f64>)> = names.iter().map(|name| ((*name).to_owned(), vec![])).collect();
        for line in text.lines().skip(above.0 + 1).filter(|line| !line.trim().is_empty()) {
            let numbers: Option<Vec<f64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
            let numbers = numbers.filter(|numbers| numbers.len() == columns.len())?;
            columns.iter_mut().zip(numbers).for_each(|((_, column), number)| column.push(number));
        }
        let is_whole = !parameters.is_empty() && !columns.is_empty();
        is_whole.then_some(Self { name, parameters, sum_of_squares, columns })
    }

    /// How many digits of a fit are right.
    pub fn agreement(&self, fitted: &Fitted) -> Agreement {
        let of = |name: &str| fitted.estimates.parameters.iter().find(|estimate| estimate.name == name);
        let fewest = |digits: &mut dyn Iterator<Item = f64>| digits.fold(f64::INFINITY, f64::min);
        let value = |p: &CertifiedParameter| of(&p.name).map_or(0.0, |found| digits(found.value, p.value));
        let std = |p: &CertifiedParameter| of(&p.name).and_then(|found| Some(digits(found.std?, p.std)));
        let stds: Option<Vec<f64>> = self.parameters.iter().map(std).collect();
        Agreement {
            dataset: self.name.clone(),
            parameter_digits: fewest(&mut self.parameters.iter().map(value)),
            std_digits: stds.map(|stds| fewest(&mut stds.into_iter())),
            sum_of_squares_digits: digits(fitted.estimates.sum_of_squares, self.sum_of_squares),
        }
    }
}

/// Correct digits, the log relative error (`McCullough` 1998, doi:10.1080/00031305.1998.10480589): certified are 11.
pub fn digits(found: f64, certified: f64) -> f64 {
    const CERTIFIED: f64 = 11.0;
    let error = if certified == 0.0 { found.abs() } else { ((found - certified) / certified).abs() };
    if error.is_nan() { 0.0 } else { (-error.log10()).clamp(0.0, CERTIFIED) }
}
