//! Claims recomputed.

use std::collections::BTreeMap;

use pneuval_models::expression::{Expression, Relation, RelationKind};

use super::claims::{Claim, Claims, Method, Number, Source};
use super::dimension::Dimension;
use super::number::{Rows, WithUnits, significant};
use super::{Audited, ClaimRecord, NumberRecord, Outcome, ReadingRecord};

/// What models of the catalogue say: `actuator/quantity/form`, one text of pressures per row, inputs as text; values in SI units.
pub type ModelSource<'a> = &'a dyn Fn(&[String; 3], &[String], &BTreeMap<String, String>) -> Result<Vec<f64>, String>;

/// Recomputes every claim of a file.
pub fn audit(claims: &Claims, models: ModelSource) -> Audited {
    Audited {
        paper: claims.id.clone(),
        title: claims.title.clone(),
        file: claims.file.clone(),
        sha256: claims.sha256.clone(),
        claims: claims.claims.iter().map(|claim| record(claim, models)).collect(),
    }
}

/// What came of a check.
struct Told {
    outcome: Outcome,
    recomputation: Vec<String>,
}

impl Told {
    fn new(outcome: Outcome, text: String) -> Self {
        Self { outcome, recomputation: vec![text] }
    }
}

fn record(claim: &Claim, models: ModelSource) -> ClaimRecord {
    let numbers = Numbers::new(&claim.numbers, models);
    let mut readings = Vec::new();
    let told = match &claim.method {
        Method::Check(relations) => all(relations, &numbers),
        Method::Readings(list) => {
            for reading in list {
                let together: Vec<Number> = claim.numbers.iter().chain(&reading.numbers).cloned().collect();
                let told = all(&reading.relations, &Numbers::new(&together, models));
                let name = reading.name.clone();
                readings.push(ReadingRecord { name, outcome: told.outcome, recomputation: told.recomputation });
            }
            of_readings(&readings)
        }
        Method::Possible { share, out_of } => possible(&numbers, share, out_of),
        Method::Spread { max, rmse, n } => spread(&numbers, max, rmse, n.as_deref()),
        Method::Exists(name) => exists(&numbers, name),
        Method::NotCheckable(why) => Told::new(Outcome::NotCheckable, why.clone()),
    };
    let as_expected = match claim.expect {
        Some(expected) => told.outcome == expected,
        None => told.outcome != Outcome::Contradicted,
    };
    ClaimRecord {
        id: claim.id.clone(),
        place: claim.place.clone(),
        statement: claim.statement.clone(),
        method: method(claim),
        outcome: told.outcome,
        as_expected,
        recomputation: told.recomputation,
        readings,
        numbers: numbers.records(),
        remark: claim.remark.clone(),
    }
}

/// The method in words.
fn method(claim: &Claim) -> &'static str {
    let is_model = |number: &Number| matches!(number.source, Source::Model { .. });
    let is_symbol = |number: &Number| number.source == Source::Symbol;
    let many = |number: &Number| matches!(&number.source, Source::Printed(values) if values.len() > 1);
    match &claim.method {
        Method::Possible { .. } => "granularity",
        Method::Spread { .. } => "max, RMSE and n",
        Method::Exists(_) => "model",
        Method::NotCheckable(_) => "–",
        Method::Readings(list) if list.iter().flat_map(|r| &r.numbers).any(is_model) => "model, several readings",
        Method::Readings(_) => "several readings",
        Method::Check(_) if claim.numbers.iter().any(is_symbol) => "units",
        Method::Check(_) if claim.numbers.iter().any(is_model) => "model",
        Method::Check(relations)
            if relations.iter().any(|r| r.kind != RelationKind::Equal) && claim.numbers.iter().any(many) =>
        {
            "order of columns"
        }
        Method::Check(relations) if relations.iter().any(|r| r.kind != RelationKind::Equal) => "order",
        Method::Check(_) => "arithmetic",
    }
}

/// Which readings reproduce a statement, and which do not.
fn of_readings(readings: &[ReadingRecord]) -> Told {
    let outcome = readings.iter().map(|reading| reading.outcome).min().unwrap_or(Outcome::NotCheckable);
    let names = |is: bool| -> Vec<&str> {
        let reproduces =
            |r: &&ReadingRecord| matches!(r.outcome, Outcome::Reproduced | Outcome::ReproducedByRounding) == is;
        readings.iter().filter(reproduces).map(|r| r.name.as_str()).collect()
    };
    let (yes, no) = (names(true), names(false));
    let mut text = match yes.as_slice() {
        [] => "no reading reproduces it".to_owned(),
        some => format!("reproduced by: {}", some.join("; ")),
    };
    if !no.is_empty() && !yes.is_empty() {
        text += ". Not by: ";
        text += &no.join("; ");
    }
    Told::new(outcome, text)
}

/// Relations that must all hold: the worst decides.
fn all(relations: &[Relation], numbers: &Numbers) -> Told {
    let told: Vec<Told> = relations.iter().map(|relation| hold(relation, numbers)).collect();
    let outcome = told.iter().map(|t| t.outcome).max_by_key(|outcome| match outcome {
        Outcome::Reproduced => 0,
        Outcome::ReproducedByRounding => 1,
        // A number that is missing leaves open what another relation contradicts.
        Outcome::NotCheckable => 2,
        Outcome::Contradicted => 3,
    });
    Told {
        outcome: outcome.unwrap_or(Outcome::NotCheckable),
        recomputation: told.into_iter().flat_map(|t| t.recomputation).collect(),
    }
}

/// One relation: as printed, and with intermediate values rounded first.
fn hold(relation: &Relation, numbers: &Numbers) -> Told {
    let plain = compare(relation, numbers, false);
    if plain.outcome == Outcome::Reproduced || !numbers.can_round(relation) {
        return plain;
    }
    let rounded = compare(relation, numbers, true);
    if rounded.outcome == Outcome::Reproduced {
        let mut recomputation = plain.recomputation;
        recomputation
            .extend(rounded.recomputation.into_iter().map(|text| format!("{text}, intermediate values rounded first")));
        return Told { outcome: Outcome::ReproducedByRounding, recomputation };
    }
    plain
}

/// A side of a relation: its value with what rounding leaves open, row by row.
struct Side {
    rows: Rows,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Side {
    fn at(&self, row: usize) -> (f64, f64, f64) {
        let of =
            |values: &[f64]| if values.len() == 1 { values[0] } else { values.get(row).copied().unwrap_or(f64::NAN) };
        (of(&self.rows.values), of(&self.low), of(&self.high))
    }
}

fn compare(relation: &Relation, numbers: &Numbers, rounded: bool) -> Told {
    let sides =
        numbers.side(&relation.left, rounded).and_then(|left| Ok((left, numbers.side(&relation.right, rounded)?)));
    let (left, right) = match sides {
        Ok(sides) => sides,
        Err(Refusal::Units(why)) => {
            return Told::new(
                Outcome::Contradicted,
                format!("{} {} {}: {why}", relation.left.text(), relation.kind.symbol(), relation.right.text()),
            );
        }
        Err(Refusal::Missing(why)) => return Told::new(Outcome::NotCheckable, why),
        Err(Refusal::NoSolution(why)) => return Told::new(Outcome::Contradicted, why),
    };
    if !left.rows.dimension.same(right.rows.dimension) {
        let text = format!(
            "{} is {}, {} is {}: they cannot be compared",
            relation.left.text(),
            left.rows.dimension.symbol(),
            relation.right.text(),
            right.rows.dimension.symbol()
        );
        return Told::new(Outcome::Contradicted, text);
    }
    if numbers.has_symbol(&relation.left) || numbers.has_symbol(&relation.right) {
        return Told::new(
            Outcome::Reproduced,
            format!("{} and {} are both {}", relation.left.text(), relation.right.text(), left.rows.dimension.symbol()),
        );
    }
    let rows = left.rows.values.len().max(right.rows.values.len());
    let outcomes: Vec<Outcome> = (0..rows).map(|row| of_row(relation.kind, left.at(row), right.at(row))).collect();
    let outcome = outcomes.iter().copied().max().unwrap_or(Outcome::NotCheckable);
    // The row that decides is shown; of several alike the first.
    let shown = outcomes.iter().position(|o| *o == outcome).unwrap_or(0);
    let mut text = numbers.written(relation, &left, &right, shown, outcome, rounded);
    if rows > 1 {
        let holds = outcomes.iter().filter(|o| **o != Outcome::Contradicted).count();
        text = format!("holds in {holds} of {rows} rows; row {}: {text}", shown + 1);
    }
    Told::new(outcome, text)
}

/// One row of a relation; each side is value, low, high.
fn of_row(kind: RelationKind, left: (f64, f64, f64), right: (f64, f64, f64)) -> Outcome {
    // What arithmetic in doubles leaves of an equality.
    let dust = 1e-9 * left.0.abs().max(right.0.abs());
    let all_finite = [left.0, left.1, left.2, right.0, right.1, right.2].iter().all(|v| v.is_finite());
    if !all_finite {
        return Outcome::Contradicted;
    }
    let (exact, perhaps) = match kind {
        RelationKind::Equal => {
            let half = 0.5 * (right.2 - right.1);
            ((left.0 - right.0).abs() <= half + dust, left.1 <= right.2 + dust && left.2 >= right.1 - dust)
        }
        RelationKind::Less => (left.2 < right.1, left.1 < right.2),
        RelationKind::LessOrEqual => (left.2 <= right.1 + dust, left.1 <= right.2 + dust),
        RelationKind::Greater => (left.1 > right.2, left.2 > right.1),
        RelationKind::GreaterOrEqual => (left.1 >= right.2 - dust, left.2 >= right.1 - dust),
    };
    match (exact, perhaps) {
        (true, _) => Outcome::Reproduced,
        (false, true) => Outcome::ReproducedByRounding,
        (false, false) => Outcome::Contradicted,
    }
}

/// Why a side has no value.
enum Refusal {
    /// Units do not fit.
    Units(String),
    /// A number is missing.
    Missing(String),
    /// A model has none.
    NoSolution(String),
}

/// Numbers of a claim, models evaluated.
struct Numbers<'a> {
    numbers: &'a [Number],
    /// Per number: its values in SI units with half widths, if it has any by itself.
    base: Vec<Result<Vec<(f64, f64)>, String>>,
}

impl<'a> Numbers<'a> {
    fn new(numbers: &'a [Number], models: ModelSource) -> Self {
        let base = numbers
            .iter()
            .map(|number| {
                let factor = number.unit.map_or(1.0, |unit| unit.factor);
                match &number.source {
                    Source::Printed(values) => {
                        Ok(values.iter().map(|(_, v, half)| (v * factor, half * factor)).collect())
                    }
                    Source::Exact(values) => Ok(values.iter().map(|v| (v * factor, 0.0)).collect()),
                    Source::Model { path, at, with } => {
                        models(path, at, with).map(|values| values.into_iter().map(|v| (v, 0.0)).collect())
                    }
                    // Computed when it is asked for; of a symbol only the unit is used.
                    Source::Formula(_) | Source::Symbol => Ok(vec![(1.0, 0.0)]),
                }
            })
            .collect();
        Self { numbers, base }
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.numbers.iter().position(|number| number.name == name)
    }

    fn uses(&self, expression: &Expression, is: &dyn Fn(&Number) -> bool) -> bool {
        expression.symbols().iter().filter_map(|name| self.find(name)).any(|i| {
            let number = &self.numbers[i];
            let below = |inner: &Expression| inner.text() != expression.text() && self.uses(inner, is);
            is(number) || matches!(&number.source, Source::Formula(inner) if below(inner))
        })
    }

    fn has_symbol(&self, expression: &Expression) -> bool {
        self.uses(expression, &|number| number.source == Source::Symbol)
    }

    fn can_round(&self, relation: &Relation) -> bool {
        [&relation.left, &relation.right].iter().any(|side| self.uses(side, &|number| number.rounded_to.is_some()))
    }

    /// The value of a number, with one of the printed ones moved.
    fn value(
        &self,
        i: usize,
        moved: Option<(usize, usize, f64)>,
        rounded: bool,
        depth: usize,
    ) -> Result<Rows, Refusal> {
        const DEPTH_MAX: usize = 20;
        let number = &self.numbers[i];
        let mut rows = if let Source::Formula(inner) = &number.source {
            if depth > DEPTH_MAX {
                return Err(Refusal::Missing(format!("`{}` is computed from itself", number.name)));
            }
            self.rows(inner, moved, rounded, depth + 1)?
        } else {
            let base = self.base[i]
                .as_ref()
                .map_err(|why| Refusal::NoSolution(format!("`{}` has no value: {why}", number.name)))?;
            let mut values: Vec<f64> = base.iter().map(|(value, _)| *value).collect();
            if let Some((which, row, by)) = moved
                && which == i
            {
                values[row] += by;
            }
            Rows { values, dimension: number.unit.map_or(Dimension::NONE, |unit| unit.dimension) }
        };
        if let (Source::Formula(_), Some(unit)) = (&number.source, number.unit)
            && !unit.dimension.same(rows.dimension)
        {
            return Err(Refusal::Units(format!(
                "`{}` comes out as {}, not {}",
                number.name,
                rows.dimension.symbol(),
                number.symbol
            )));
        }
        if let (Some(step), true) = (number.rounded_to, rounded) {
            rows.values.iter_mut().for_each(|v| *v = (*v / step).round() * step);
        }
        Ok(rows)
    }

    fn rows(
        &self,
        expression: &Expression,
        moved: Option<(usize, usize, f64)>,
        rounded: bool,
        depth: usize,
    ) -> Result<Rows, Refusal> {
        let mut symbols = Vec::new();
        for name in expression.symbols() {
            let i = self.find(name).ok_or_else(|| Refusal::Missing(format!("`{name}` is no number of this claim")))?;
            symbols.push(self.value(i, moved, rounded, depth)?);
        }
        expression.evaluate(&WithUnits, &symbols).map_err(Refusal::Units)
    }

    /// A side with what rounding leaves open: each printed number is moved to either end by itself, and what that does adds up. A number
    /// that stands in a formula twice moves in both places.
    fn side(&self, expression: &Expression, rounded: bool) -> Result<Side, Refusal> {
        let rows = self.rows(expression, None, rounded, 0)?;
        let (mut low, mut high) = (rows.values.clone(), rows.values.clone());
        for (i, base) in self.base.iter().enumerate() {
            let Ok(values) = base else { continue };
            for (row, (_, half)) in values.iter().enumerate().filter(|(_, (_, half))| *half > 0.0) {
                let mut reach = vec![(0.0_f64, 0.0_f64); rows.values.len()];
                for by in [-half, *half] {
                    let moved = self.rows(expression, Some((i, row, by)), rounded, 0)?;
                    for ((reach, value), here) in reach.iter_mut().zip(&moved.values).zip(&rows.values) {
                        let change = value - here;
                        *reach = (reach.0.min(change), reach.1.max(change));
                    }
                }
                for ((low, high), reach) in low.iter_mut().zip(high.iter_mut()).zip(&reach) {
                    *low += reach.0;
                    *high += reach.1;
                }
            }
        }
        Ok(Side { rows, low, high })
    }

    /// The unit in which a side is shown: that of the number it is, or of one that measures the same.
    fn unit(&self, relation: &Relation, dimension: Dimension) -> (String, f64) {
        let of = |expression: &Expression| {
            let numbers = expression.symbols().iter().filter_map(|name| self.find(name)).map(|i| &self.numbers[i]);
            let fits = |number: &&Number| {
                number.unit.is_some_and(|unit| unit.dimension.same(dimension)) && !number.symbol.is_empty()
            };
            numbers.filter(fits).map(|n| (n.symbol.clone(), n.unit.map_or(1.0, |u| u.factor))).next()
        };
        let found = of(&relation.right).or_else(|| of(&relation.left).filter(|_| !dimension.is_none()));
        let (symbol, factor) =
            found.unwrap_or_else(|| if dimension.is_none() { (String::new(), 1.0) } else { (dimension.symbol(), 1.0) });
        (if symbol == "1" { String::new() } else { symbol }, factor)
    }

    /// A relation with its numbers.
    fn written(
        &self,
        relation: &Relation,
        left: &Side,
        right: &Side,
        row: usize,
        outcome: Outcome,
        rounded: bool,
    ) -> String {
        let (symbol, factor) = self.unit(relation, left.rows.dimension);
        let with_unit = |value: f64| {
            let text = significant(value / factor, 6);
            if symbol.is_empty() { text } else { format!("{text} {symbol}") }
        };
        let formula = |expression: &Expression| self.substituted(expression, row, rounded);
        let side = |expression: &Expression, side: &Side| {
            let value = with_unit(side.at(row).0);
            let formula = formula(expression);
            // A number alone is its own formula.
            if expression.symbols().len() == 1 && expression.text() == expression.symbols()[0] || formula == value {
                value
            } else {
                format!("{formula} = {value}")
            }
        };
        let printed = |expression: &Expression| {
            let alone = expression.symbols().first().filter(|name| expression.text() == name.as_str());
            let number = alone.and_then(|name| self.find(name)).map(|i| &self.numbers[i]);
            number.and_then(|number| match &number.source {
                Source::Printed(values) => {
                    values.get(if values.len() == 1 { 0 } else { row }).map(|(text, ..)| spaced(text, &number.symbol))
                }
                _ => None,
            })
        };
        let (_, low, high) = left.at(row);
        let open = if high - low > 1e-9 * high.abs().max(low.abs()) && outcome != Outcome::Reproduced {
            format!(" (the printed digits leave open {} to {})", significant(low / factor, 6), with_unit(high))
        } else {
            String::new()
        };
        match relation.kind {
            RelationKind::Equal => {
                let printed = printed(&relation.right)
                    .map_or_else(|| side(&relation.right, right), |text| format!("printed {text}"));
                format!("{}{open}; {printed}", side(&relation.left, left))
            }
            kind => {
                let is = if outcome == Outcome::Contradicted { "is not" } else { "is" };
                format!("{}{open} {is} {} {}", side(&relation.left, left), kind.symbol(), side(&relation.right, right))
            }
        }
    }

    /// A formula with the numbers in the place of their names; columns that are taken as a whole keep theirs.
    fn substituted(&self, expression: &Expression, row: usize, rounded: bool) -> String {
        let mut out = String::new();
        let text = expression.text();
        let mut letters = text.char_indices().peekable();
        while let Some((start, c)) = letters.next() {
            if !(c.is_alphabetic() || c == '_') {
                out.push(c);
                // The exponent of a number is no name.
                if c.is_ascii_digit() || c == '.' {
                    while let Some((_, next)) = letters.next_if(|(_, n)| n.is_alphanumeric() || *n == '.') {
                        out.push(next);
                    }
                }
                continue;
            }
            let mut end = start + c.len_utf8();
            while let Some((at, next)) = letters.next_if(|(_, n)| n.is_alphanumeric() || *n == '_') {
                end = at + next.len_utf8();
            }
            let name = &text[start..end];
            match self.find(name).map(|i| (i, &self.numbers[i])) {
                Some((i, number)) => out += &self.told(i, number, row, rounded),
                None => out += name,
            }
        }
        out
    }

    fn told(&self, i: usize, number: &Number, row: usize, rounded: bool) -> String {
        let factor = number.unit.map_or(1.0, |unit| unit.factor);
        let text = match &number.source {
            Source::Printed(values) => {
                values.get(if values.len() == 1 { 0 } else { row }).map(|(text, ..)| text.clone())
            }
            Source::Symbol => None,
            Source::Exact(_) | Source::Model { .. } | Source::Formula(_) => {
                self.value(i, None, rounded, 0).ok().map(|rows| significant(rows.at(row) / factor, 6))
            }
        };
        text.map_or_else(|| number.name.clone(), |text| if text.starts_with('-') { format!("({text})") } else { text })
    }

    fn records(&self) -> Vec<NumberRecord> {
        let record = |(i, number): (usize, &Number)| {
            let factor = number.unit.map_or(1.0, |unit| unit.factor);
            let list = |texts: Vec<String>| spaced(&texts.join(", "), &number.symbol);
            let (text, from) = match &number.source {
                Source::Printed(values) => {
                    (list(values.iter().map(|(text, ..)| text.clone()).collect()), "printed".to_owned())
                }
                Source::Exact(values) => {
                    (list(values.iter().map(|v| significant(*v, 9)).collect()), "exact".to_owned())
                }
                Source::Symbol => (number.symbol.clone(), "only its unit is known".to_owned()),
                Source::Formula(inner) => {
                    let value = self
                        .value(i, None, false, 0)
                        .map(|rows| list(rows.values.iter().map(|v| significant(v / factor, 6)).collect()));
                    (value.unwrap_or_else(|_| "no value".to_owned()), inner.text().to_owned())
                }
                Source::Model { path, at, with } => {
                    let value = match &self.base[i] {
                        Ok(values) => list(values.iter().map(|(v, _)| significant(v / factor, 6)).collect()),
                        Err(why) => format!("no value: {why}"),
                    };
                    let with: Vec<String> = with.iter().map(|(name, value)| format!("{name} = {value}")).collect();
                    let with = if with.is_empty() { String::new() } else { format!(", {}", with.join(", ")) };
                    (value, format!("model {} at {}{with}", path.join("/"), at.join("; ")))
                }
            };
            let from = number.place.as_ref().map_or(from.clone(), |place| format!("{from}, {place}"));
            NumberRecord { name: number.name.clone(), text, from }
        };
        self.numbers.iter().enumerate().map(record).collect()
    }
}

fn spaced(text: &str, symbol: &str) -> String {
    if symbol.is_empty() || symbol == "1" { text.to_owned() } else { format!("{text} {symbol}") }
}

/// The values of a number by name, with half widths; why there are none.
fn values<'a>(numbers: &'a Numbers, name: &str) -> Result<&'a [(f64, f64)], Told> {
    let i = numbers
        .find(name)
        .ok_or_else(|| Told::new(Outcome::NotCheckable, format!("`{name}` is no number of this claim")))?;
    match &numbers.base[i] {
        Ok(values) if numbers.numbers[i].source != Source::Symbol => Ok(values),
        Ok(_) => Err(Told::new(Outcome::NotCheckable, format!("`{name}` is not printed"))),
        Err(why) => Err(Told::new(Outcome::Contradicted, format!("`{name}` has no value: {why}"))),
    }
}

/// Whether whole counts have the printed shares.
fn possible(numbers: &Numbers, share: &str, out_of: &str) -> Told {
    let (shares, totals) = match (values(numbers, share), values(numbers, out_of)) {
        (Ok(shares), Ok(totals)) => (shares, totals),
        (Err(told), _) | (_, Err(told)) => return told,
    };
    let mut impossible = Vec::new();
    let mut counts = Vec::new();
    for (row, (value, half)) in shares.iter().enumerate() {
        let total = totals.get(if totals.len() == 1 { 0 } else { row }).map_or(f64::NAN, |(total, _)| *total);
        let count = (value * total).round();
        let percent = |count: f64| significant(100.0 * count / total, 5);
        if (count / total - value).abs() <= half + 1e-12 {
            counts.push(format!("{count}/{total}"));
        } else {
            let (below, above) = ((value * total).floor(), (value * total).ceil());
            impossible.push(format!(
                "{} % is no share of {total}: {below}/{total} = {} %, {above}/{total} = {} %",
                significant(100.0 * value, 6),
                percent(below),
                percent(above)
            ));
        }
    }
    if impossible.is_empty() {
        Told::new(Outcome::Reproduced, format!("whole counts have these shares: {}", counts.join(", ")))
    } else {
        Told { outcome: Outcome::Contradicted, recomputation: impossible }
    }
}

/// Whether a largest error and an RMSE can be of one series.
fn spread(numbers: &Numbers, max: &str, rmse: &str, n: Option<&str>) -> Told {
    let single = |name: &str| values(numbers, name).map(|values| values.first().copied().unwrap_or((f64::NAN, 0.0)));
    let ((max, max_half), (rmse, rmse_half)) = match (single(max), single(rmse)) {
        (Ok(max), Ok(rmse)) => (max, rmse),
        (Err(told), _) | (_, Err(told)) => return told,
    };
    if rmse - rmse_half > max + max_half {
        return Told::new(Outcome::Contradicted, "an RMSE is never larger than the largest error".to_owned());
    }
    // rmse >= max / sqrt(n)
    let least = |max: f64, rmse: f64| (max / rmse).powi(2).ceil().max(1.0);
    let (fewest, perhaps) = (least(max, rmse), least(max - max_half, rmse + rmse_half));
    let formula = format!(
        "n >= (max/RMSE)^2 = ({}/{})^2 = {}",
        significant(max, 6),
        significant(rmse, 6),
        significant((max / rmse).powi(2), 6)
    );
    let Some(n) = n else {
        return Told::new(
            Outcome::NotCheckable,
            format!(
                "{formula}: they can be of one series of {fewest} samples or more; how many there were is not printed"
            ),
        );
    };
    let n = match single(n) {
        Ok((n, _)) => n,
        Err(told) => return told,
    };
    let outcome = if n >= fewest {
        Outcome::Reproduced
    } else if n >= perhaps {
        Outcome::ReproducedByRounding
    } else {
        Outcome::Contradicted
    };
    Told::new(outcome, format!("{formula}; printed n = {n}"))
}

/// Whether a model has a solution.
fn exists(numbers: &Numbers, name: &str) -> Told {
    match values(numbers, name) {
        Ok(_) => {
            let text = numbers
                .records()
                .into_iter()
                .find(|record| record.name == name)
                .map_or(String::new(), |record| record.text);
            Told::new(Outcome::Reproduced, format!("{name} = {text}"))
        }
        Err(told) => told,
    }
}
