//! What really happens at equilibrium: curves of a quantity over pressure, one for each set of conditions.
//!
//! Between the points of a table the curve is a monotone cubic (Fritsch and Carlson 1980, with Brodlie's weighted harmonic mean of
//! the slopes at inner points and straight ends): it goes through every point and swings over none. Beyond its ends it goes straight on.

use std::path::Path;

use pneuval_ingest::error::{Place, shown, suggestion};
use pneuval_ingest::manifest::{Actuator, PublishedDataset, PublishedTable};
use pneuval_ingest::table::Table;
use pneuval_ingest::units::Dimension;
use pneuval_ingest::{IngestError, limits};
use pneuval_models::catalogue::{self, Inputs};

use super::plan::{Response, Truth};

/// Points on which a form is evaluated between zero and the highest pressure.
const FORM_STEPS: u32 = 256;

/// A quantity over one pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    slopes: Vec<f64>,
}

impl Curve {
    /// The curve through points of rising x; a single one is a constant.
    pub fn through(points: &[(f64, f64)]) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let steps: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
        let rises: Vec<f64> = y.windows(2).zip(&steps).map(|(y, h)| (y[1] - y[0]) / h).collect();
        let slopes = (0..x.len())
            .map(|i| match (i.checked_sub(1).and_then(|i| rises.get(i)), rises.get(i)) {
                (Some(left), Some(right)) if left * right > 0.0 => {
                    let (a, b) = (steps[i] * 2.0 + steps[i - 1], steps[i] + 2.0 * steps[i - 1]);
                    (a + b) / (a / left + b / right)
                }
                (Some(_), Some(_)) | (None, None) => 0.0,
                (Some(only), None) | (None, Some(only)) => *only,
            })
            .collect();
        Self { x, y, slopes }
    }

    /// Its value.
    pub fn at(&self, x: f64) -> f64 {
        let last = self.x.len() - 1;
        if x <= self.x[0] {
            return self.y[0] + self.slopes[0] * (x - self.x[0]);
        }
        if x >= self.x[last] {
            return self.y[last] + self.slopes[last] * (x - self.x[last]);
        }
        let i = self.x.partition_point(|known| *known <= x) - 1;
        let h = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / h;
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * self.y[i]
            + (t3 - 2.0 * t2 + t) * h * self.slopes[i]
            + (3.0 * t2 - 2.0 * t3) * self.y[i + 1]
            + (t3 - t2) * h * self.slopes[i + 1]
    }
}

/// The curves of one response at one set of conditions.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// Values of its conditions.
    pub conditions: Vec<f64>,
    /// One curve for each component.
    pub components: Vec<Curve>,
}

/// What really happens to one quantity.
#[derive(Debug, Clone, PartialEq)]
pub enum Equilibrium {
    /// Curves over the pressure of one chamber.
    Curves {
        /// Index of the chamber in the programme.
        chamber: usize,
        /// One for each set of conditions.
        sets: Vec<Set>,
    },
    /// The sum of responses before it.
    Sum(Vec<usize>),
}

/// Where truths come from.
pub struct Sources<'a> {
    /// The actuator, for forms.
    pub actuator: &'a Actuator,
    /// The paper's tables, if there are any.
    pub published: Option<&'a PublishedDataset>,
    /// The plan's file, for messages.
    pub file: &'a str,
    /// Where the tables lie that the plan names.
    pub folder: Option<&'a Path>,
}

impl Sources<'_> {
    /// The paper's table of a response's quantity.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] if there is none.
    pub fn table(&self, response: &Response) -> Result<&PublishedTable, IngestError> {
        let tables = self.published.map(|published| published.tables.as_slice()).unwrap_or_default();
        let id = &response.quantity.id;
        tables.iter().find(|table| table.quantity.id == *id).ok_or_else(|| {
            let next = "name a form, or a file of your own".to_owned();
            self.malformed(response, "a quantity that the paper prints a table of", &shown(id), next)
        })
    }

    /// The conditions of a printed row, in the order in which a response names them.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] if the two do not have the same.
    pub fn conditions(&self, response: &Response, table: &PublishedTable, row: usize) -> Result<Vec<f64>, IngestError> {
        let named = || table.conditions.iter().map(|condition| condition.id.as_str());
        let wrong = || {
            let found: Vec<&str> = response.conditions.iter().map(|setting| setting.id.as_str()).collect();
            let expected = format!("the conditions of the printed table: {}", named().collect::<Vec<_>>().join(", "));
            let next = "name every one of them, and no other".to_owned();
            self.malformed(response, &expected, &found.join(", "), next)
        };
        if table.conditions.len() != response.conditions.len() {
            return Err(wrong());
        }
        let value = |setting: &super::plan::Setting| {
            let at = named().position(|id| id == setting.id).ok_or_else(wrong)?;
            Ok(table.conditions_si[row][at].si)
        };
        response.conditions.iter().map(value).collect()
    }

    fn malformed(&self, response: &Response, expected: &str, found: &str, next: String) -> IngestError {
        let item = format!("truth of `{}`", response.quantity.id);
        IngestError::Malformed {
            place: Place::new(self.file, Some(response.line), Some(item)),
            expected: expected.to_owned(),
            found: found.to_owned(),
            next,
        }
    }

    /// The truth of a response at the sets of conditions that a programme visits.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] where a truth is not known, has a hole, or says nothing at such conditions.
    pub fn equilibrium(
        &self,
        response: &Response,
        before: &[Response],
        chambers: &[String],
        sets: &[Vec<f64>],
        pressure_max: f64,
    ) -> Result<Equilibrium, IngestError> {
        if let Truth::Sum(parts) = &response.truth {
            // Parts are responses before it: the plan is checked for it.
            let index = |part: &String| before.iter().position(|r| r.quantity.id == *part);
            return Ok(Equilibrium::Sum(parts.iter().filter_map(index).collect()));
        }
        let [chamber] = &response.chambers[..] else {
            let found = response.chambers.join(", ");
            let next = "make it { sum = [..] } of quantities of one chamber each".to_owned();
            return Err(self.malformed(response, "one chamber", &found, next));
        };
        let Some(chamber) = chambers.iter().position(|known| known == chamber) else {
            let next = suggestion(chamber, chambers.iter().map(String::as_str));
            return Err(self.malformed(response, "a chamber of the programme", &shown(chamber), next));
        };
        let curves = |conditions: &Vec<f64>| -> Result<Set, IngestError> {
            let points = match &response.truth {
                Truth::Published => self.printed(response, conditions)?,
                Truth::Form(form) => self.computed(response, form, conditions, pressure_max)?,
                Truth::File(name) => self.tabled(response, name)?,
                Truth::Sum(_) => vec![],
            };
            let component = |i: usize| Curve::through(&points.iter().map(|(p, y)| (*p, y[i])).collect::<Vec<_>>());
            let components = (0..response.quantity.width()).map(component).collect();
            Ok(Set { conditions: conditions.clone(), components })
        };
        Ok(Equilibrium::Curves { chamber, sets: sets.iter().map(curves).collect::<Result<_, _>>()? })
    }

    /// Rows of the paper's table at some conditions, with the state at rest, which is zero where print does not say it.
    fn printed(&self, response: &Response, conditions: &[f64]) -> Result<Vec<(f64, Vec<f64>)>, IngestError> {
        let table = self.table(response)?;
        let Some(chamber) = table.chambers.iter().position(|known| response.chambers.contains(known)) else {
            let next = suggestion("", table.chambers.iter().map(String::as_str));
            let found = response.chambers.join(", ");
            return Err(self.malformed(response, "a chamber of the printed table", &found, next));
        };
        let mut points: Vec<(f64, Vec<f64>)> = Vec::new();
        for (row, pressures) in table.pressures_gauge_pa.iter().enumerate() {
            if !same(&self.conditions(response, table, row)?, conditions) {
                continue;
            }
            let Some(measured) = &table.measured[row] else {
                let found = format!("a hole at line {}", table.lines[row]);
                let next = "take a form, or a file of your own".to_owned();
                return Err(self.malformed(response, "a printed value in every row", &found, next));
            };
            points.push((pressures[chamber], measured.iter().map(|value| value.si).collect()));
        }
        if points.is_empty() {
            let next = "leave `levels` and `values` out, so that the printed rows are visited".to_owned();
            return Err(self.malformed(response, "rows at these conditions", "none", next));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| same(&[a.0], &[b.0]));
        if points[0].0 > 0.0 {
            points.insert(0, (0.0, vec![0.0; response.quantity.width()]));
        }
        Ok(points)
    }

    /// A form of the catalogue, evaluated.
    fn computed(
        &self,
        response: &Response,
        form: &str,
        conditions: &[f64],
        pressure_max: f64,
    ) -> Result<Vec<(f64, Vec<f64>)>, IngestError> {
        let (kind, id) = (&self.actuator.kind, &response.quantity.id);
        let of = || catalogue::entries().filter(|e| e.actuator == *kind && e.quantity == *id);
        let Some(entry) = of().find(|entry| entry.form == form) else {
            let next = suggestion(form, of().map(|entry| entry.form));
            return Err(self.malformed(response, &format!("a form of {kind}, {id}"), &shown(form), next));
        };
        let mut inputs: Inputs = self.actuator.values.iter().map(|(name, value)| (name.clone(), value.si)).collect();
        for (setting, value) in response.conditions.iter().zip(conditions) {
            inputs.set(setting.id.clone(), *value);
        }
        let next = || "take another form, or other pressures: `pneuval predict` shows what it says".to_owned();
        let refused = |error: pneuval_models::ModelError| {
            self.malformed(response, "a form that has a value at every pressure", &error.to_string(), next())
        };
        let model = entry.build(&inputs).map_err(refused)?;
        let mut points = Vec::new();
        for step in 0..=FORM_STEPS {
            let pressure = pressure_max * f64::from(step) / f64::from(FORM_STEPS);
            points.push((pressure, model.predict(&[pressure]).map_err(refused)?));
        }
        Ok(points)
    }

    /// A table that lies beside the plan: gauge pressure, then one column for each component, a row of units below the names.
    fn tabled(&self, response: &Response, name: &str) -> Result<Vec<(f64, Vec<f64>)>, IngestError> {
        let Some(folder) = self.folder else {
            let next = "bring a plan of your own".to_owned();
            return Err(self.malformed(response, "a file beside the plan", "an embedded plan", next));
        };
        let path = folder.join(name);
        let bytes = limits::read(&path, limits::WRITTEN_BYTES_MAX)?;
        let file = path.display().to_string();
        let table = Table::read(&file, &bytes)?;
        let width = response.quantity.width();
        let names: Vec<String> = table.names().to_vec();
        if names.len() < 1 + width {
            let expected = format!("a column of gauge pressure and {width} of `{}` in {file}", response.quantity.id);
            let next = "add what is missing".to_owned();
            return Err(self.malformed(response, &expected, &names.join(", "), next));
        }
        let dimension = |i: usize| if i == 0 { Dimension::Pressure } else { response.quantity.unit.dimension };
        let columns = (0..=width)
            .map(|i| table.every(&names[i], dimension(i), "a number in every row"))
            .collect::<Result<Vec<_>, _>>()?;
        let rows = columns[0].len();
        let points: Vec<(f64, Vec<f64>)> = (0..rows)
            .map(|row| (columns[0][row].si, columns[1..].iter().map(|column| column[row].si).collect()))
            .collect();
        match points.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
            _ if points.is_empty() => {
                let next = "add the curve, pressures rising".to_owned();
                Err(self.malformed(response, &format!("at least one row in {file}"), "none", next))
            }
            Some(row) => {
                Err(table.malformed(row + 1, &names[0], "pressures that rise from row to row", "sort the rows"))
            }
            None => Ok(points),
        }
    }
}

/// Equal but for what units cost on their way to SI.
pub fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_goes_through_its_points_and_swings_over_none() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (3.0, 1.0), (5.0, 9.0)];
        let curve = Curve::through(&points);
        for (x, y) in points {
            assert!((curve.at(x) - y).abs() < 1e-15, "{x}");
        }
        let values: Vec<f64> = (0..=500).map(|i| curve.at(f64::from(i) / 100.0)).collect();
        assert!(values.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15));
        assert!(values[100..=200].iter().all(|y| (0.0..=1.0).contains(y)));
        // Straight on beyond its ends.
        assert!((curve.at(6.0) - 13.0).abs() < 1e-12 && curve.at(-1.0).abs() < 1e-15);
    }

    #[test]
    fn a_straight_line_stays_one_and_one_point_is_a_constant() {
        let line = Curve::through(&[(0.0, 1.0), (0.3, 1.6), (2.0, 5.0)]);
        assert!((line.at(1.1) - 3.2).abs() < 1e-14);
        assert!((Curve::through(&[(2.0, 7.0)]).at(9.0) - 7.0).abs() < 1e-15);
    }
}
