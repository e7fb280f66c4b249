//! From saddles to a grid: each next corner lies along an edge and is of the other sign.

use std::collections::BTreeMap;

use super::super::picture::Place;
use super::saddles::Saddle;

/// Cosine of the angle by which a neighbour of the first corner may lie off its edge, and by which edges may turn to the next corner.
const OFF_EDGE: f64 = 0.97;
const TURN: f64 = 0.9;

/// A corner is looked for so far from where its neighbours say, as a share of the distance to them.
const OFF_PLACE: f64 = 0.3;

/// Neighbours looked at along an edge: clutter may lie between.
const NEAREST: usize = 6;

/// A row or column at the side of which less than this share is there is no part of the board.
const FILLED: f64 = 0.5;

/// Steps that follow each other change by less than this share of them, at the median: in noise, saddles line up by chance.
const UNEVEN_MAX: f64 = 0.1;

/// A part of a board fills this share of its columns and rows.
const PART_FILLED: f64 = 0.6;

/// A grid of fewer corners is none.
const GRID_MIN: usize = 4;

/// Column and row.
type Cell = (i32, i32);

const SIDES: [Cell; 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// Corners in columns and rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    places: BTreeMap<Cell, Place>,
    low: Cell,
    high: Cell,
}

/// All grids in the saddles; each saddle begins or belongs to one at most. `enough` is how many corners the board has.
pub(super) fn grids(saddles: &[Saddle], enough: usize) -> Vec<Grid> {
    let field = Field::new(saddles);
    let mut is_used = vec![false; saddles.len()];
    let mut found = vec![];
    for first in 0..saddles.len() {
        if is_used[first] {
            continue;
        }
        let Some(cells) = square(&field, first) else { continue };
        let cells = grown(&field, cells, enough);
        if cells.len() >= 2 * GRID_MIN {
            for i in cells.values() {
                is_used[*i] = true;
            }
        }
        found.extend(Grid::of(saddles, &cells));
    }
    found
}

/// The nearest saddle along a direction of an edge that is of the other sign and has its edges alike.
fn neighbour(saddles: &[Saddle], from: usize, along: Place, across: Place) -> Option<usize> {
    let own = &saddles[from];
    let mut ahead: Vec<(f64, usize)> = saddles
        .iter()
        .enumerate()
        .filter_map(|(i, other)| {
            let by = other.at - own.at;
            let distance = by.norm();
            (i != from && by.dot(&along) > OFF_EDGE * distance).then_some((distance, i))
        })
        .collect();
    ahead.sort_by(|a, b| a.0.total_cmp(&b.0));
    let bright = own.is_bright(along, across);
    let fits = |(_, i): &(f64, usize)| {
        let (other, by) = (&saddles[*i], saddles[*i].at - own.at);
        other.along(by) > OFF_EDGE && other.along(across) > TURN && other.is_bright(by, across) != bright
    };
    ahead.into_iter().take(NEAREST).find(fits).map(|(_, i)| i)
}

/// Four corners of one square, the first at the origin.
fn square(field: &Field, first: usize) -> Option<BTreeMap<Cell, usize>> {
    let saddles = field.saddles;
    let own = &saddles[first];
    let [u, v] = own.edges;
    for (u, v) in [(u, v), (u, -v), (-u, v), (-u, -v)] {
        let (Some(i), Some(j)) = (neighbour(saddles, first, u, v), neighbour(saddles, first, v, u)) else { continue };
        let (by_u, by_v) = (saddles[i].at - own.at, saddles[j].at - own.at);
        let expected = own.at + by_u + by_v;
        let reach = OFF_PLACE * by_u.norm().min(by_v.norm());
        if let Some(k) = field.nearest(expected, reach, (by_u, by_v), own.is_bright(u, v)) {
            return Some(BTreeMap::from([((0, 0), first), ((1, 0), i), ((0, 1), j), ((1, 1), k)]));
        }
    }
    None
}

/// Saddles, and their order from left to right.
struct Field<'s> {
    saddles: &'s [Saddle],
    by_x: Vec<(f64, usize)>,
}

impl<'s> Field<'s> {
    fn new(saddles: &'s [Saddle]) -> Self {
        let mut by_x: Vec<(f64, usize)> = saddles.iter().enumerate().map(|(i, saddle)| (saddle.at.x, i)).collect();
        by_x.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        Self { saddles, by_x }
    }

    /// The saddle nearest to a place that has the edges and the sign expected there.
    fn nearest(&self, at: Place, reach: f64, (u, v): (Place, Place), is_bright: bool) -> Option<usize> {
        let from = self.by_x.partition_point(|(x, _)| *x < at.x - reach);
        self.by_x[from..]
            .iter()
            .take_while(|(x, _)| *x <= at.x + reach)
            .map(|(_, i)| ((self.saddles[*i].at - at).norm(), *i))
            .filter(|(distance, i)| {
                let saddle = &self.saddles[*i];
                *distance < reach
                    && saddle.along(u) > TURN
                    && saddle.along(v) > TURN
                    && saddle.is_bright(u, v) == is_bright
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, i)| i)
    }
}

/// Grows a grid on all sides until no more corners are where they should be.
fn grown(field: &Field, mut cells: BTreeMap<Cell, usize>, enough: usize) -> BTreeMap<Cell, usize> {
    let saddles = field.saddles;
    let Some(sign) = cells.get(&(0, 0)).zip(cells.get(&(1, 0))).zip(cells.get(&(0, 1))).map(|((a, b), c)| {
        let own = saddles[*a].at;
        saddles[*a].is_bright(saddles[*b].at - own, saddles[*c].at - own)
    }) else {
        return cells;
    };
    // A board larger than the one wanted is told apart by a few rows more.
    while cells.len() < 4 * enough {
        let mut beside: Vec<Cell> = vec![];
        for cell in cells.keys() {
            beside.extend(SIDES.iter().map(|(i, j)| (cell.0 + i, cell.1 + j)).filter(|next| !cells.contains_key(next)));
        }
        beside.sort_unstable();
        beside.dedup();
        let mut added = vec![];
        for cell in beside {
            let Some((at, u, v)) = expected(saddles, &cells, cell) else { continue };
            let is_bright = sign == ((cell.0 + cell.1).rem_euclid(2) == 0);
            let reach = OFF_PLACE * u.norm().min(v.norm());
            let Some(i) = field.nearest(at, reach, (u, v), is_bright) else { continue };
            let is_taken = cells.values().any(|other| *other == i) || added.iter().any(|(_, other)| *other == i);
            if !is_taken {
                added.push((cell, i));
            }
        }
        if added.is_empty() {
            break;
        }
        cells.extend(added);
    }
    cells
}

/// Where a corner should be by those beside it, and the steps along columns and rows there.
fn expected(saddles: &[Saddle], cells: &BTreeMap<Cell, usize>, cell: Cell) -> Option<(Place, Place, Place)> {
    let at = |i: i32, j: i32| cells.get(&(cell.0 + i, cell.1 + j)).map(|k| saddles[*k].at);
    let (mut sum, mut weights) = (Place::zeros(), 0.0);
    let mut add = |place: Place, weight: f64| {
        sum += place * weight;
        weights += weight;
    };
    let (mut u, mut v) = (None, None);
    for (i, j) in SIDES {
        let Some(one) = at(i, j) else { continue };
        if let Some(two) = at(2 * i, 2 * j) {
            // As far again; with a third, steps may change evenly.
            match at(3 * i, 3 * j) {
                Some(three) => add(one * 3.0 - two * 3.0 + three, 1.0),
                None => add(one * 2.0 - two, 1.0),
            }
            let step = (two - one) * f64::from(i + j);
            *(if j == 0 { &mut u } else { &mut v }) = Some(step);
        }
        // The fourth corner of a square of which three are there.
        for (k, l) in [(j, i), (-j, -i)] {
            if let (Some(side), Some(far)) = (at(k, l), at(i + k, j + l)) {
                add(one + side - far, 1.0);
            }
        }
        for (k, l) in [(j, i), (-j, -i)] {
            // A step beside it, along the other direction.
            if let Some(far) = at(i + k, j + l) {
                let step = (far - one) * f64::from(k + l);
                (if j == 0 { &mut v } else { &mut u }).get_or_insert(step);
            }
        }
    }
    (weights > 0.0).then_some((sum / weights, u?, v?))
}

impl Grid {
    /// Without rows and columns of which most is not there; `None` if too little is left.
    fn of(saddles: &[Saddle], cells: &BTreeMap<Cell, usize>) -> Option<Self> {
        let mut places: BTreeMap<Cell, Place> = cells.iter().map(|(cell, i)| (*cell, saddles[*i].at)).collect();
        loop {
            let bounds = |of: fn(&Cell) -> i32| Some((places.keys().map(of).min()?, places.keys().map(of).max()?));
            let ((left, right), (top, bottom)) = (bounds(|c| c.0)?, bounds(|c| c.1)?);
            let columns = (right - left + 1, |c: &Cell| c.1);
            let rows = (bottom - top + 1, |c: &Cell| c.0);
            let column = |x: i32| places.keys().filter(|c| c.0 == x).count() as f64 / f64::from(rows.0);
            let row = |y: i32| places.keys().filter(|c| c.1 == y).count() as f64 / f64::from(columns.0);
            let sides = [
                (column(left), true, left),
                (column(right), true, right),
                (row(top), false, top),
                (row(bottom), false, bottom),
            ];
            let emptiest = sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
            if emptiest.0 >= FILLED {
                let grid = Self { places, low: (left, top), high: (right, bottom) };
                return (grid.count() >= GRID_MIN).then_some(grid);
            }
            places.retain(|c, _| if emptiest.1 { c.0 != emptiest.2 } else { c.1 != emptiest.2 });
        }
    }

    /// Whether it looks like a part of a board: steps alike from corner to corner, and few holes.
    pub fn is_part(&self) -> bool {
        let mut changes: Vec<f64> = vec![];
        for (cell, at) in &self.places {
            for (i, j) in [(1, 0), (0, 1)] {
                let beside = |sign: i32| self.places.get(&(cell.0 + sign * i, cell.1 + sign * j));
                if let (Some(a), Some(b)) = (beside(-1), beside(1)) {
                    changes.push((a + b - at * 2.0).norm() * 2.0 / (b - a).norm());
                }
            }
        }
        changes.sort_by(f64::total_cmp);
        let is_even = changes.get(changes.len() / 2).is_some_and(|change| *change < UNEVEN_MAX);
        is_even && self.count() as f64 > PART_FILLED * (self.width() * self.height()) as f64
    }

    pub fn count(&self) -> usize {
        self.places.len()
    }

    pub fn width(&self) -> usize {
        self.high.0.abs_diff(self.low.0) as usize + 1
    }

    pub fn height(&self) -> usize {
        self.high.1.abs_diff(self.low.1) as usize + 1
    }

    /// Whether it is such a board with no corner missing.
    pub fn is_whole(&self, columns: usize, rows: usize) -> bool {
        let (w, h) = (self.width(), self.height());
        self.count() == columns * rows && ((w, h) == (columns, rows) || (h, w) == (columns, rows))
    }

    /// Whether a corner is so few squares from the border of a picture.
    pub fn touches(&self, width: f64, height: f64, squares: f64) -> bool {
        self.places.iter().any(|(cell, at)| {
            let beside = SIDES.iter().filter_map(|(i, j)| self.places.get(&(cell.0 + i, cell.1 + j)));
            let square = beside.map(|other| (other - at).norm()).fold(0.0, f64::max);
            at.x.min(at.y).min(width - 1.0 - at.x).min(height - 1.0 - at.y) < squares * square
        })
    }

    /// Row by row, as it is read. Only of a whole one.
    pub fn in_order(&self, columns: usize, rows: usize) -> Vec<Place> {
        let (w, h) = (self.high.0 - self.low.0, self.high.1 - self.low.1);
        // The eight orders of a grid: from which corner, and which way first.
        let orders = [false, true].into_iter().flat_map(|turned| {
            [(false, false), (true, false), (false, true), (true, true)].map(|(x, y)| (turned, x, y))
        });
        let of = |(turned, back_x, back_y): (bool, bool, bool)| -> Option<Vec<Place>> {
            let mut all = Vec::with_capacity(columns * rows);
            for j in 0..i32::try_from(rows).ok()? {
                for i in 0..i32::try_from(columns).ok()? {
                    let (x, y) = if turned { (j, i) } else { (i, j) };
                    let (x, y) = (if back_x { w - x } else { x }, if back_y { h - y } else { y });
                    all.push(*self.places.get(&(self.low.0 + x, self.low.1 + y))?);
                }
            }
            let (along, across) = (all.get(1)? - all.first()?, all.get(columns)? - all.first()?);
            (along.x * across.y - along.y * across.x > 0.0).then_some(all)
        };
        let from_upper_left = |all: &Vec<Place>| all.first().map_or(f64::MAX, |p| p.x + p.y);
        orders.filter_map(of).min_by(|a, b| from_upper_left(a).total_cmp(&from_upper_left(b))).unwrap_or_default()
    }
}
