//! Material laws fitted to tests of strips and sheets.
//!
//! The residual is law - measured in nominal stress, over every test together. Laws that are linear in their constants are solved by QR;
//! for the others every sensible set of exponents (or locking stretches) is tried with the linear constants solved for, and the best of
//! them start a Levenberg-Marquardt with exact derivatives.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use pneuval_models::ModelError;
use pneuval_models::catalogue::find_law;
use pneuval_models::least_squares::{Minimum, Problem, Search, minimise};
use pneuval_models::materials::{EndReason, Family, Hyperelastic, LoadCase};

use super::estimate::{Estimates, estimates, search_record};

/// A test in a load case.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its name in tables.
    pub label: String,
    /// How it was loaded.
    pub case: LoadCase,
    /// Stretch and nominal stress in Pa.
    pub points: Vec<(f64, f64)>,
}

/// How residuals are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weighting {
    /// Every sample alike.
    Samples,
    /// Every test alike, however many samples it has.
    Tests,
    /// Over the measured stress, but no less than a hundredth of the test's largest.
    Relative,
}

impl Weighting {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Samples => "every sample alike, in nominal stress",
            Self::Tests => "every test alike, its samples sharing its weight",
            Self::Relative => {
                "residuals over the measured stress, or over a hundredth of the test's largest where that is more"
            }
        }
    }
}

/// A law fitted to tests.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedLaw {
    /// Id of the family: `yeoh-3`.
    pub id: String,
    /// Id of the law in the catalogue.
    pub law: String,
    /// What was found; constants in Pa and 1.
    pub estimates: Estimates,
    /// Root mean square of the residuals over the largest measured stress.
    pub relative_rmse: f64,
    /// Akaike's criterion, corrected for few samples: smaller is better; only differences mean something.
    pub aicc: Option<f64>,
    /// Correlation of neighbouring residuals along the curves: near 1 they are the law's misfit, not scatter.
    pub neighbours: Option<f64>,
    /// Where each load case is stable, inside the stretches fitted and beyond.
    pub stability: Vec<StabilityRecord>,
    /// Why the constants are no material, if they are none.
    pub no_material: Option<String>,
    /// Each measured load case predicted by a fit to the others.
    pub left_out: Vec<LeftOut>,
}

/// Stability of a load case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StabilityRecord {
    /// The load case.
    pub load_case: &'static str,
    /// Whether the stress rises over all stretches that were fitted in any load case.
    pub inside: bool,
    /// From which stretch on it does not rise, below 1.
    pub unstable_below: Option<f64>,
    /// From which stretch on it does not rise, above 1: looked for up to twice the largest stretch fitted.
    pub unstable_above: Option<f64>,
}

/// A load case that the fit did not see.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// The load case.
    pub load_case: &'static str,
    /// Root mean square of predicted - measured, Pa; `None` if the others do not determine the law.
    pub rmse_pa: Option<f64>,
    /// Over the largest measured stress of the load case.
    pub relative: Option<f64>,
    /// Why there is no number.
    pub why: Option<String>,
}

/// A law that could not be fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// Id of the family.
    pub id: String,
    /// Why.
    pub why: String,
}

/// Fits a family to tests.
///
/// # Errors
/// [`ModelError`] if no minimum was found, or there are fewer samples than constants.
pub fn fit(family: Family, tests: &[Measured], weighting: Weighting, confidence: f64) -> Result<FittedLaw, ModelError> {
    let problem = Curves::new(family, tests, weighting);
    let names: Vec<String> = family.constants().iter().map(|name| (*name).to_owned()).collect();
    let found = minimum(&problem)?;
    let mut estimates = estimates(&problem, &found.best, search_record(&found), &names, confidence);
    if let (Family::Ogden(2), [mu1, alpha1, mu2, alpha2]) = (family, found.best.parameters.as_slice())
        && (alpha2 - alpha1).abs() < 3.0 * MERGED
        && mu1 * mu2 < 0.0
    {
        estimates.warnings.push(
            "the two exponents merge and the two mu cancel without limit: the tests hold no two terms of this law, and the constants are one choice of many".to_owned(),
        );
    }
    let largest = tests.iter().flat_map(|t| &t.points).map(|p| p.1.abs()).fold(0.0, f64::max);
    let (n, p) = (estimates.n as f64, names.len() as f64);
    // One more constant is the scatter itself.
    let k = p + 1.0;
    let aicc =
        (n > k + 1.0).then(|| n * (estimates.sum_of_squares / n).ln() + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0));
    let constants: Vec<f64> = found.best.parameters.clone();
    let law = build(family, &constants);
    let (stability, no_material) = match &law {
        Ok(law) => (stability(law.as_ref(), tests), None),
        Err(error) => (vec![], Some(error.to_string())),
    };
    let unweighted = Curves::new(family, tests, Weighting::Samples);
    let residuals = unweighted.residuals(&constants)?;
    let rmse = (residuals.norm_squared() / residuals.len() as f64).sqrt();
    Ok(FittedLaw {
        id: family.id().to_owned(),
        law: family.law().to_owned(),
        estimates,
        relative_rmse: rmse / largest,
        aicc: aicc.filter(|a| a.is_finite()),
        neighbours: neighbours(tests, &residuals),
        stability,
        no_material,
        left_out: left_out(family, tests, weighting),
    })
}

/// The law of constants.
///
/// # Errors
/// As the law says.
pub fn build(family: Family, constants: &[f64]) -> Result<Box<dyn Hyperelastic>, ModelError> {
    let names = family.constants();
    // Every family's law stands in the catalogue; a test holds them to it.
    let entry =
        find_law(family.law()).ok_or(ModelError::MissingParameter { name: "law", meaning: "of the catalogue" })?;
    entry.build(&|name| names.iter().position(|known| *known == name).map(|i| constants[i]))
}

/// Wave-finger's Eq. 28: the two-term Yeoh law as a straight line, `t1 / (2(l - l^-2)) = C10 - 6 C20 + C20 × 2(l² + 2/l)`.
///
/// With x = `2 (l² + 2/l)` = 2 I1 the slope is C20 and the intercept C10 - 6 C20. Dividing by `l - l^-2` weighs samples near l = 1 up
/// without limit; those within 2 % of it are left out, as on the paper's line. Uniaxial tests only.
///
/// # Errors
/// [`ModelError::TooFewResiduals`] for fewer than two samples.
pub fn eq_28_line(tests: &[Measured], confidence: f64) -> Result<(Estimates, usize), ModelError> {
    const NEAR: f64 = 0.02;
    let uniaxial = tests.iter().filter(|test| test.case == LoadCase::Uniaxial).flat_map(|test| &test.points);
    let used: Vec<(f64, f64)> = uniaxial.copied().filter(|(l, _)| (l - 1.0).abs() > NEAR).collect();
    let line =
        Line { points: used.iter().map(|(l, p)| (2.0 * (l * l + 2.0 / l), p / (2.0 * (l - l.powi(-2))))).collect() };
    let minimum = minimise(&line, &[1e5, 1e4])?;
    let search = Search { best: minimum.clone(), given: Ok(minimum.clone()), starts: 1, settled: 1, at_best: 1 };
    let names = ["C10".to_owned(), "C20".to_owned()];
    Ok((estimates(&line, &minimum, search_record(&search), &names, confidence), used.len()))
}

/// Points of Eq. 28's line.
struct Line {
    points: Vec<(f64, f64)>,
}

impl Problem for Line {
    fn parameters(&self) -> usize {
        2
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        let residual = |(x, y): &(f64, f64)| at[0] - 6.0 * at[1] + at[1] * x - y;
        Ok(DVector::from_iterator(self.points.len(), self.points.iter().map(residual)))
    }

    fn jacobian(&self, _: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        Ok(DMatrix::from_fn(self.points.len(), 2, |i, j| if j == 0 { 1.0 } else { self.points[i].0 - 6.0 }))
    }
}

/// A family at the samples of tests.
struct Curves {
    family: Family,
    /// Load case, stretch, nominal stress, weight.
    samples: Vec<(LoadCase, f64, f64, f64)>,
}

impl Curves {
    fn new(family: Family, tests: &[Measured], weighting: Weighting) -> Self {
        let total: usize = tests.iter().map(|test| test.points.len()).sum();
        let mut samples = Vec::with_capacity(total);
        for test in tests {
            let largest = test.points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
            let share = (total as f64 / tests.len() as f64 / test.points.len() as f64).sqrt();
            for &(stretch, stress) in &test.points {
                let weight = match weighting {
                    Weighting::Samples => 1.0,
                    Weighting::Tests => share,
                    Weighting::Relative => 1.0 / stress.abs().max(0.01 * largest),
                };
                samples.push((test.case, stretch, stress, weight));
            }
        }
        Self { family, samples }
    }

    /// The largest `I1 - 3` of all samples.
    fn farthest(&self) -> f64 {
        self.samples.iter().map(|(case, stretch, ..)| case.i1_minus_3(stretch - 1.0)).fold(0.0, f64::max)
    }
}

impl Problem for Curves {
    fn parameters(&self) -> usize {
        self.family.constants().len()
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        let mut slopes = vec![0.0; at.len()];
        let mut residuals = DVector::zeros(self.samples.len());
        for (i, &(case, stretch, stress, weight)) in self.samples.iter().enumerate() {
            residuals[i] = weight * (self.family.nominal_stress_pa(at, case, stretch, &mut slopes)? - stress);
        }
        match residuals.iter().find(|r| !r.is_finite()) {
            Some(value) => Err(ModelError::NotFinite { component: 0, value: *value }),
            None => Ok(residuals),
        }
    }

    fn jacobian(&self, at: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        let mut slopes = vec![0.0; at.len()];
        let mut jacobian = DMatrix::zeros(self.samples.len(), at.len());
        for (i, &(case, stretch, _, weight)) in self.samples.iter().enumerate() {
            self.family.nominal_stress_pa(at, case, stretch, &mut slopes)?;
            for (j, slope) in slopes.iter().enumerate() {
                jacobian[(i, j)] = weight * slope;
            }
        }
        Ok(jacobian)
    }
}

/// Exponents that are tried: of both signs, closer together where laws of rubber have them.
const EXPONENTS: [f64; 34] = [
    -12.0, -9.0, -7.0, -5.5, -4.5, -3.5, -2.8, -2.2, -1.7, -1.3, -0.9, -0.5, -0.2, 0.2, 0.5, 0.8, 1.1, 1.4, 1.7, 2.0,
    2.4, 2.8, 3.3, 3.8, 4.4, 5.0, 5.8, 6.7, 8.0, 10.0, 13.0, 17.0, 22.0, 30.0,
];
/// Locking `Jm` that are tried, in units of the largest `I1 - 3`.
const LOCKS: [f64; 14] = [1.001, 1.01, 1.03, 1.1, 1.2, 1.4, 1.7, 2.2, 3.0, 5.0, 10.0, 30.0, 100.0, 1000.0];
/// Starts that are followed to their minimum.
const FOLLOWED: usize = 24;

/// The lowest minimum from every start that makes sense.
fn minimum(problem: &Curves) -> Result<Search, ModelError> {
    let starts: Vec<Vec<f64>> = match problem.family {
        Family::Gent => LOCKS.iter().map(|lock| vec![0.0, lock * problem.farthest()]).collect(),
        Family::Ogden(terms) => exponents(problem, terms),
        Family::NeoHooke | Family::MooneyRivlin | Family::Yeoh(_) => vec![vec![0.0; problem.parameters()]],
    };
    let linear = problem.family.linear();
    let mut minima: Vec<Minimum> = Vec::new();
    let mut first_error = None;
    for start in &starts {
        let solved = solve_linear(problem, start, &linear);
        match solved.and_then(|start| minimise(problem, &start)) {
            Ok(minimum) => minima.push(minimum),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    if problem.family == Family::Ogden(2) {
        minima.extend(merged(problem));
    }
    let lowest = minima.iter().min_by(|a, b| a.sum_of_squares().total_cmp(&b.sum_of_squares())).cloned();
    let Some(best) = lowest else {
        return Err(first_error.unwrap_or(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations: 0 }));
    };
    let same = |m: &&Minimum| m.sum_of_squares() <= best.sum_of_squares() * (1.0 + 1e-8);
    let at_best = minima.iter().filter(same).count();
    let best = tidy(problem, best);
    Ok(Search { given: Ok(best.clone()), best, starts: starts.len(), settled: minima.len(), at_best })
}

/// How far apart two exponents are that have all but merged.
const MERGED: f64 = 1e-4;

/// Two Ogden terms whose exponents merge: `c phi(a) + d phi'(a)`, phi the stress of one term, phi' its derivative by the exponent. No set of
/// distinct exponents comes near it without weights that grow without limit and cancel, so that no descent finds it; it is written with
/// exponents a little apart. It is the lowest the law can reach where a material has no two exponents, and then tells nothing of either.
fn merged(problem: &Curves) -> Option<Minimum> {
    let columns = |a: f64| -> Option<(DMatrix<f64>, DVector<f64>)> {
        let mut slopes = [0.0; 2];
        let mut design = DMatrix::zeros(problem.samples.len(), 2);
        for (i, &(case, stretch, _, weight)) in problem.samples.iter().enumerate() {
            Family::Ogden(1).nominal_stress_pa(&[1.0, a], case, stretch, &mut slopes).ok()?;
            design[(i, 0)] = weight * slopes[0];
            design[(i, 1)] = weight * slopes[1];
        }
        let measured = DVector::from_iterator(problem.samples.len(), problem.samples.iter().map(|s| s.2 * s.3));
        design.iter().all(|v| v.is_finite()).then_some((design, measured))
    };
    let solve = |a: f64| -> Option<(f64, DVector<f64>)> {
        let (design, measured) = columns(a)?;
        let qr = design.clone().qr();
        let mut target = measured.clone();
        qr.q_tr_mul(&mut target);
        let weights = qr.r().solve_upper_triangular(&target.rows(0, 2).into_owned())?;
        Some(((design * &weights - measured).norm_squared(), weights))
    };
    let sum = |a: f64| solve(a).map_or(f64::INFINITY, |(sum, _)| sum);
    // Every valley of a grid, to its floor by golden section.
    let heights: Vec<f64> = EXPONENTS.iter().map(|a| sum(*a)).collect();
    let end = EXPONENTS.len() - 1;
    let is_valley = |i: &usize| heights[*i] <= heights[i.saturating_sub(1)] && heights[*i] <= heights[(i + 1).min(end)];
    let floor = |i: usize| {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (EXPONENTS[i.saturating_sub(1)], EXPONENTS[(i + 1).min(end)]);
        for _ in 0..60 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if sum(a) < sum(b) { high = b } else { low = a }
        }
        0.5 * (low + high)
    };
    let floors = (0..=end).filter(is_valley).map(floor);
    let (a, (_, weights)) = floors.filter_map(|a| Some((a, solve(a)?))).min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    let (half, apart) = (0.5 * weights[0], 0.5 * weights[1] / MERGED);
    let start = [half - apart, a - MERGED, half + apart, a + MERGED];
    // Once more with the exponents as they are: the best weights for them.
    let start = solve_linear(problem, &start, &[0, 2]).ok()?;
    let residuals = problem.residuals(&start).ok()?;
    let jacobian = problem.jacobian(&start).ok()?;
    Some(Minimum { parameters: start, residuals, jacobian, iterations: 0 })
}

/// Ogden's terms in the order of their exponents: their order means nothing.
fn tidy(problem: &Curves, mut minimum: Minimum) -> Minimum {
    if let Family::Ogden(_) = problem.family {
        let mut terms: Vec<(f64, f64)> = minimum.parameters.chunks(2).map(|term| (term[0], term[1])).collect();
        terms.sort_by(|a, b| a.1.total_cmp(&b.1));
        minimum.parameters = terms.iter().flat_map(|term| [term.0, term.1]).collect();
        if let Ok(jacobian) = problem.jacobian(&minimum.parameters) {
            minimum.jacobian = jacobian;
        }
    }
    minimum
}

/// The linear constants that suit the others best.
fn solve_linear(problem: &Curves, start: &[f64], linear: &[usize]) -> Result<Vec<f64>, ModelError> {
    let mut solved = start.to_vec();
    // At zero the stress is zero whatever the other constants are, but for those that it divides by.
    let residuals = problem.residuals(start)?;
    let design = problem.jacobian(start)?.select_columns(linear);
    let lengths: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(design.nrows(), design.ncols(), |i, j| design[(i, j)] / lengths[j]);
    let step = scaled.svd(true, true).solve(&-residuals, 1e-13).unwrap_or_else(|_| DVector::zeros(linear.len()));
    for ((&i, step), length) in linear.iter().zip(step.iter()).zip(&lengths) {
        solved[i] += step / length;
    }
    Ok(solved)
}

/// The best sets of exponents, each with zero weights: sums of squares from products of the columns, which are formed once.
fn exponents(problem: &Curves, terms: usize) -> Vec<Vec<f64>> {
    let single = Family::Ogden(1);
    let mut columns: Vec<(f64, DVector<f64>)> = Vec::new();
    let mut slopes = [0.0; 2];
    for alpha in EXPONENTS {
        let column: Option<Vec<f64>> = problem
            .samples
            .iter()
            .map(|&(case, stretch, _, weight)| {
                single.nominal_stress_pa(&[1.0, alpha], case, stretch, &mut slopes).ok().map(|stress| weight * stress)
            })
            .collect();
        let Some(column) = column.map(DVector::from_vec) else { continue };
        let length = column.norm();
        if length.is_finite() && length > 0.0 {
            columns.push((alpha, column / length));
        }
    }
    let measured = DVector::from_iterator(problem.samples.len(), problem.samples.iter().map(|s| s.2 * s.3));
    let products: Vec<Vec<f64>> =
        columns.iter().map(|(_, a)| columns.iter().map(|(_, b)| a.dot(b)).collect()).collect();
    let targets: Vec<f64> = columns.iter().map(|(_, column)| column.dot(&measured)).collect();
    let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
    let mut set: Vec<usize> = (0..terms).collect();
    let count = columns.len();
    if count < terms {
        return vec![];
    }
    loop {
        let gram = DMatrix::from_fn(terms, terms, |i, j| products[set[i]][set[j]]);
        let target = DVector::from_iterator(terms, set.iter().map(|i| targets[*i]));
        if let Some(weights) = gram.cholesky().map(|factor| factor.solve(&target)) {
            // What the set takes away from the sum of squares.
            sets.push((-weights.dot(&target), set.clone()));
        }
        // The next set in order.
        let Some(turn) = (0..terms).rev().find(|&i| set[i] < count - terms + i) else { break };
        set[turn] += 1;
        for i in turn + 1..terms {
            set[i] = set[i - 1] + 1;
        }
    }
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Sets that differ in one neighbouring exponent lead to the same minimum.
    let mut chosen: Vec<Vec<usize>> = Vec::new();
    for (_, set) in sets {
        let near = |other: &Vec<usize>| set.iter().zip(other).all(|(a, b)| a.abs_diff(*b) <= 1);
        if !chosen.iter().any(near) {
            chosen.push(set);
        }
        if chosen.len() == FOLLOWED {
            break;
        }
    }
    chosen.iter().map(|set| set.iter().flat_map(|i| [0.0, columns[*i].0]).collect()).collect()
}

/// Correlation of neighbouring residuals along the tests.
fn neighbours(tests: &[Measured], residuals: &DVector<f64>) -> Option<f64> {
    let (mut top, mut bottom, mut at) = (0.0, 0.0, 0);
    for test in tests {
        let part: Vec<f64> = residuals.iter().skip(at).take(test.points.len()).copied().collect();
        at += test.points.len();
        top += part.windows(2).map(|w| w[0] * w[1]).sum::<f64>();
        bottom += part.iter().map(|r| r * r).sum::<f64>();
    }
    let correlation = top / bottom;
    (correlation.is_finite() && at > 8).then_some(correlation)
}

/// Where every load case is stable: inside the stretches fitted, and up to twice as far.
fn stability(law: &dyn Hyperelastic, tests: &[Measured]) -> Vec<StabilityRecord> {
    let stretches = || tests.iter().flat_map(|test| &test.points).map(|point| point.0);
    let (min, max) = (stretches().fold(1.0, f64::min), stretches().fold(1.0, f64::max));
    let of = |case: LoadCase| {
        // An equibiaxial stretch of a strip's largest stretch is far beyond what any test reaches; it is said all the same.
        let range = law.stable_range(case, 0.5 * min, 2.0 * max).ok()?;
        let ends =
            |end: pneuval_models::materials::StableEnd| (end.why != EndReason::AsFarAsAsked).then_some(end.stretch);
        let (below, above) = (ends(range.min), ends(range.max));
        let inside = below.is_none_or(|end| end <= min) && above.is_none_or(|end| end >= max);
        Some(StabilityRecord { load_case: case.name(), inside, unstable_below: below, unstable_above: above })
    };
    LoadCase::ALL.into_iter().filter_map(of).collect()
}

/// Each measured load case predicted by a fit to the others.
fn left_out(family: Family, tests: &[Measured], weighting: Weighting) -> Vec<LeftOut> {
    let cases: Vec<LoadCase> = LoadCase::ALL.into_iter().filter(|case| tests.iter().any(|t| t.case == *case)).collect();
    if cases.len() < 2 {
        return vec![];
    }
    cases
        .into_iter()
        .map(|case| {
            let (out, others): (Vec<Measured>, Vec<Measured>) = tests.iter().cloned().partition(|t| t.case == case);
            let predicted = || -> Result<f64, ModelError> {
                let found = minimum(&Curves::new(family, &others, weighting))?;
                // What the others do not determine predicts nothing.
                found.best.statistics()?;
                let residuals = Curves::new(family, &out, Weighting::Samples).residuals(&found.best.parameters)?;
                Ok((residuals.norm_squared() / residuals.len() as f64).sqrt())
            };
            let largest = out.iter().flat_map(|t| &t.points).map(|p| p.1.abs()).fold(0.0, f64::max);
            match predicted() {
                Ok(rmse) => {
                    LeftOut { load_case: case.name(), rmse_pa: Some(rmse), relative: Some(rmse / largest), why: None }
                }
                Err(error) => {
                    LeftOut { load_case: case.name(), rmse_pa: None, relative: None, why: Some(error.to_string()) }
                }
            }
        })
        .collect()
}
