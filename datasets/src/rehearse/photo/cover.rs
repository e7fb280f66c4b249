//! How much of each cell of a row a contour covers: exactly, by areas.
//!
//! ```text
//!  cells      |     |    /|/////|/////|     a piece of the contour that crosses the row gives the cell that it is in the
//!             |     |  /##|#####|#####|     area to its right, and all cells behind it its height: a running sum of both
//!             |     |/####|#####|#####|     is the covered share of every cell
//! ```

use pneuval_ingest::camera::picture::Place;

/// Pieces narrower than this lie in one cell.
const UPRIGHT: f64 = 1e-12;

/// A closed contour, cut into rows of cells.
pub(super) struct Contour {
    first_row: usize,
    /// Of each row from the first on: where a piece enters and leaves it across, and by how much it goes down (upwards: negative).
    rows: Vec<Vec<[f64; 3]>>,
}

impl Contour {
    /// Of points in cells; what lies above or below the rows is cut off.
    pub fn new(points: &[Place], rows: usize) -> Self {
        let (mut top, mut bottom) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in points {
            (top, bottom) = (top.min(point.y), bottom.max(point.y));
        }
        let (first_row, behind) = (whole(top, rows), whole(bottom.ceil(), rows));
        let mut contour = Self { first_row, rows: vec![vec![]; behind.saturating_sub(first_row)] };
        for (i, from) in points.iter().enumerate() {
            contour.cut(*from, points[(i + 1) % points.len()]);
        }
        contour
    }

    fn cut(&mut self, from: Place, to: Place) {
        let (upper, lower, sign) = if from.y <= to.y { (from, to, 1.0) } else { (to, from, -1.0) };
        let height = lower.y - upper.y;
        if height <= 0.0 {
            return;
        }
        let last = self.first_row + self.rows.len();
        let across = |y: f64| upper.x + (y - upper.y) / height * (lower.x - upper.x);
        for row in whole(upper.y, last).max(self.first_row)..whole(lower.y.ceil(), last) {
            let (y0, y1) = (upper.y.max(row as f64), lower.y.min((row + 1) as f64));
            if y1 > y0 {
                self.rows[row - self.first_row].push([across(y0), across(y1), sign * (y1 - y0)]);
            }
        }
    }

    /// Adds what it covers of a row to what is covered there already; edges are the cells with a boundary in them.
    pub fn add(&self, row: usize, sums: &mut [f64], covered: &mut [f32], edges: &mut Vec<usize>) {
        let Some(pieces) = row.checked_sub(self.first_row).and_then(|i| self.rows.get(i)) else { return };
        let cells = covered.len();
        let (mut from, mut to) = (cells, 0);
        for [x0, x1, down] in pieces {
            let (left, right) = (x0.min(*x1), x0.max(*x1));
            from = from.min(whole(left, cells));
            to = to.max(whole(right.floor() + 2.0, cells));
            area(sums, cells, left, right, *down);
        }
        let mut sum = 0.0;
        for i in from..to {
            if sums[i] != 0.0 {
                edges.push(i);
            }
            sum += sums[i];
            sums[i] = 0.0;
            join(&mut covered[i], sum);
        }
        sums[cells] = 0.0;
        // A contour may go on beyond the right border; what rounding leaves is nothing.
        if sum.abs() > UPRIGHT {
            covered[to.max(from)..].iter_mut().for_each(|cell| join(cell, sum));
        }
    }
}

/// Covers a share of a cell, whichever way round the contour goes, beside what is covered already: the larger of both, which is exact where
/// one lies within the other or their boundaries are the same.
fn join(cell: &mut f32, sum: f64) {
    #[expect(clippy::cast_possible_truncation, reason = "shares of a cell: seven digits are enough")]
    let share = sum.abs().min(1.0) as f32;
    *cell = cell.max(share);
}

/// A number of rows or cells between nought and a limit.
fn whole(x: f64, limit: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut to the range before")]
    let whole = x.clamp(0.0, limit as f64) as usize;
    whole
}

/// The areas to the right of a piece.
fn area(sums: &mut [f64], cells: usize, left: f64, right: f64, down: f64) {
    let end = cells as f64;
    let mut put = |x: f64, down: f64| {
        // Left of the border it covers all of the row, right of it nothing.
        let x = x.max(0.0);
        if x < end {
            let i = whole(x, cells - 1);
            let behind = x - i as f64;
            sums[i] += down * (1.0 - behind);
            sums[i + 1] += down * behind;
        }
    };
    let width = right - left;
    if width < UPRIGHT {
        return put(left, down);
    }
    // Beyond the borders at once, between them cell by cell.
    let mut x = left;
    while x < right {
        let next = if x < 0.0 { 0.0 } else { x.floor() + 1.0 };
        let next = if x >= end { right } else { next.min(right) };
        put(0.5 * (x + next), down * (next - x) / width);
        x = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All rows of a grid of cells.
    fn covered(contours: &[&[Place]], columns: usize, rows: usize) -> Vec<Vec<f32>> {
        let contours: Vec<Contour> = contours.iter().map(|points| Contour::new(points, rows)).collect();
        let mut sums = vec![0.0; columns + 1];
        let row = |row| {
            let mut covered = vec![0.0; columns];
            for contour in &contours {
                contour.add(row, &mut sums, &mut covered, &mut vec![]);
            }
            covered
        };
        (0..rows).map(row).collect()
    }

    fn sum(cells: &[Vec<f32>]) -> f64 {
        cells.iter().flatten().map(|share| f64::from(*share)).sum()
    }

    #[test]
    fn areas_are_exact_wherever_a_contour_lies_and_whichever_way_it_goes() {
        // A rectangle between cells: 2.5 by 1.25.
        let mut points = [(1.25, 0.5), (3.75, 0.5), (3.75, 1.75), (1.25, 1.75)].map(|(x, y)| Place::new(x, y));
        for _ in 0..2 {
            let cells = covered(&[&points], 6, 3);
            assert!((sum(&cells) - 3.125).abs() < 1e-6);
            assert!((cells[0][1] - 0.375).abs() < 1e-6 && (cells[1][2] - 0.75).abs() < 1e-6 && cells[1][4] == 0.0);
            points.reverse();
        }
        // A triangle, slanting over many cells.
        let triangle = [(0.3, 0.2), (19.1, 3.7), (2.2, 9.9)].map(|(x, y)| Place::new(x, y));
        let area = 0.5 * ((19.1 - 0.3) * (9.9 - 0.2) - (2.2 - 0.3) * (3.7 - 0.2));
        assert!((sum(&covered(&[&triangle], 20, 10)) - area).abs() < 1e-5);
        // A disc of many corners.
        let disc: Vec<Place> = (0..2000)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 2000.0)
            .map(|t| Place::new(20.3 + 15.0 * t.cos(), 19.6 + 15.0 * t.sin()))
            .collect();
        let polygon = 1000.0 * 225.0 * (std::f64::consts::TAU / 2000.0).sin();
        assert!((sum(&covered(&[&disc], 40, 40)) - polygon).abs() < 1e-3);
    }

    #[test]
    fn what_goes_over_the_border_covers_the_cells_up_to_it_and_contours_join() {
        let wide = [(-7.5, 1.0), (99.0, 1.0), (99.0, 2.5), (-7.5, 2.5)].map(|(x, y)| Place::new(x, y));
        let cells = covered(&[&wide], 5, 4);
        assert!(cells[1].iter().all(|share| (share - 1.0).abs() < 1e-6) && (sum(&cells) - 7.5).abs() < 1e-5);
        let slanting = [(-4.0, 0.0), (6.0, 10.0), (-4.0, 10.0)].map(|(x, y)| Place::new(x, y));
        // Right of the border: a triangle with legs of 6.
        assert!((sum(&covered(&[&slanting], 20, 10)) - 18.0).abs() < 1e-5);
        // Beyond it on the other side: 5 by 5 less a triangle with legs of 4.
        let other = [(1.0, 0.0), (11.0, 10.0), (1.0, 10.0)].map(|(x, y)| Place::new(x, y));
        assert!((sum(&covered(&[&other], 5, 10)) - (8.0 + 4.0 * 6.0)).abs() < 1e-5);
        // Two squares that share a quarter, and one alone twice.
        let square = |x, y| [(x, y), (x + 2.0, y), (x + 2.0, y + 2.0), (x, y + 2.0)].map(|(x, y)| Place::new(x, y));
        assert!((sum(&covered(&[&square(0.0, 0.0), &square(1.0, 1.0)], 4, 4)) - 7.0).abs() < 1e-6);
        assert!((sum(&covered(&[&square(0.3, 0.6), &square(0.3, 0.6)], 4, 4)) - 4.0).abs() < 1e-6);
        // Above and below the rows.
        assert!(sum(&covered(&[&square(0.0, -9.0), &square(0.0, 50.0)], 4, 4)).abs() < 1e-12);
    }
}
