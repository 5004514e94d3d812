//! The normal search: branch and bound over pairs of endpoints, for all lines at once.
//!
//! The plane of pairs is covered with squares. Over a square, each entry of the palette moves between its values at two
//! corners, since it grows with both endpoints; a pixel's distance to the nearest of these eight intervals is at most
//! what any pair of the square costs it. Sums over a side bound the side's cost from below, exactly so where a square
//! is a single pair. A line goes once the bounds of its sides add up to no less than what is known to be possible; a
//! square goes once it helps no line that is left; the squares that remain are cut in four. What is left in the end has
//! the lowest squared error of the literal search, or there is nothing better than what was known.

use crate::depth::bc4w::lines::bipartitions;
use crate::depth::bc4w::quick;
use crate::depth::bc4w::sums::{Plan, Real, greater, lesser};
use crate::depth::bc4w::tile::{Solution, Tile};
use crate::depth::bc4w::{MAX_ENDPOINT, Pair};
use crate::depth::quantise::BACKGROUND_CODE;

/// Squares that are looked at side by side.
const LANES: usize = 8;
/// The first squares are this many in a row, or up to twice as many.
const FIRST_SQUARES: u16 = 8;
/// Lines that are tried for a good solution to start from.
const LINES: usize = 8;

/// BC4's two modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Eight,
    Six,
}

/// A square of pairs, of a size that its pass knows: the smallest endpoints.
#[derive(Debug, Clone, Copy)]
struct Square {
    mode: Mode,
    low: u16,
    high: u16,
}

/// A solution of the lowest squared error within the tile's bound.
pub fn search(tile: &Tile) -> Option<Solution> {
    let known = quick::best_of(tile, LINES);
    let pixels = u64::from(tile.surfaces.count_ones());
    // Within the bound, no solution costs more.
    let most = pixels * u64::from(tile.bound) * u64::from(tile.bound) + 1;
    let limit = known.map_or(most, |(cost, _)| cost);
    let better = if limit == 0 {
        None
    } else if limit < 1 << 24 {
        Search::<f32>::new(tile, limit).run()
    } else {
        Search::<f64>::new(tile, limit).run()
    };
    better.or(known.map(|(_, solution)| solution))
}

/// Levels of the palettes of squares: for each index, what it is at least and at most.
struct Levels<T> {
    least: [[T; LANES]; 8],
    most: [[T; LANES]; 8],
    /// What the background costs.
    background: [T; LANES],
}

struct Search<'a, T> {
    tile: &'a Tile,
    /// Solutions must cost less.
    limit: T,
    first: u16,
    last: u16,
    /// Places of the lines that are left.
    lines: Vec<usize>,
    plan: Plan,
    /// What sides A and B of these lines cost at least, if the line is to be better than the limit.
    bounds: Vec<[T; 2]>,
}

impl<'a, T: Real> Search<'a, T> {
    fn new(tile: &'a Tile, limit: u64) -> Search<'a, T> {
        let endpoints = tile.endpoints();
        let plan = Plan::all().clone();
        let zero = T::from_code(0);
        Search {
            tile,
            limit: T::from_sum(limit),
            first: *endpoints.start(),
            last: *endpoints.end(),
            lines: (0..plan.len()).collect(),
            bounds: vec![[zero; 2]; plan.len()],
            plan,
        }
    }

    /// A solution below the limit, the best there is.
    fn run(mut self) -> Option<Solution> {
        let count = self.last - self.first + 1;
        let mut size = (count / FIRST_SQUARES).max(1);
        size = 1 << size.ilog2();
        let starts = || (self.first..=self.last).step_by(usize::from(size));
        let mut squares: Vec<Square> = [Mode::Eight, Mode::Six]
            .into_iter()
            .flat_map(|mode| starts().flat_map(move |high| starts().map(move |low| Square { mode, low, high })))
            .filter(|square| self.holds_any(*square, size))
            .collect();
        loop {
            let kept = self.pass(&squares, size);
            if self.lines.is_empty() {
                return None;
            }
            if size == 1 {
                return self.solution(&kept);
            }
            size /= 2;
            squares.clear();
            for Square { mode, low, high } in kept {
                for [low, high] in [[low, high], [low + size, high], [low, high + size], [low + size, high + size]] {
                    let square = Square { mode, low, high };
                    if low <= self.last && high <= self.last && self.holds_any(square, size) {
                        squares.push(square);
                    }
                }
            }
        }
    }

    /// Whether a square holds pairs of its mode.
    fn holds_any(&self, square: Square, size: u16) -> bool {
        let most = (square.high + size - 1).min(self.last);
        match square.mode {
            Mode::Eight => most > square.low,
            Mode::Six => most >= square.low,
        }
    }

    /// Bounds lines and squares; drops lines and returns the squares that are left.
    fn pass(&mut self, squares: &[Square], size: u16) -> Vec<Square> {
        let mut kept = Vec::new();
        let mut least = vec![[[T::CAP; LANES]; 2]; self.lines.len()];
        let mut room = Vec::new();
        for group in squares.chunks(LANES) {
            let costs = self.costs(&self.levels(group, size));
            let mut total = [T::CAP + T::CAP; LANES];
            let bounds = &self.bounds;
            self.plan.for_each_line(&costs, &mut room, |line, a, b| {
                let [other_a, other_b] = bounds[line];
                let [least_a, least_b] = &mut least[line];
                for lane in 0..LANES {
                    least_a[lane] = lesser(a[lane], least_a[lane]);
                    least_b[lane] = lesser(b[lane], least_b[lane]);
                    total[lane] = lesser(lesser(a[lane] + other_b, b[lane] + other_a), total[lane]);
                }
            });
            kept.extend(group.iter().zip(total).filter(|(_, total)| *total < self.limit).map(|(square, _)| *square));
        }
        let mut places = Vec::new();
        self.bounds.clear();
        for (place, least) in least.iter().enumerate() {
            let [a, b] = least.map(|lanes| lanes.into_iter().fold(T::CAP, lesser));
            if a + b < self.limit {
                places.push(place);
                self.bounds.push([a, b]);
            }
        }
        if places.len() < self.lines.len() {
            self.lines = places.iter().map(|&place| self.lines[place]).collect();
            self.plan = self.plan.of_some(&places);
        }
        kept
    }

    fn levels(&self, group: &[Square], size: u16) -> Levels<T> {
        let zero = T::from_code(0);
        let mut levels = Levels { least: [[zero; LANES]; 8], most: [[zero; LANES]; 8], background: [T::CAP; LANES] };
        for lane in 0..LANES {
            let Square { mode, low, high } = group[lane.min(group.len() - 1)];
            let [most_low, most_high] = [low, high].map(|at| (at + size - 1).min(self.last));
            let (least, most) = match mode {
                Mode::Eight => (Pair::eight([high, low]), Pair::eight([most_high, most_low])),
                Mode::Six => (Pair::six([low, high]), Pair::six([most_low, most_high])),
            };
            if mode == Mode::Six || most_high == MAX_ENDPOINT {
                levels.background[lane] = zero;
            }
            // The background is no surface; another code of the palette stands in.
            let spare = if least[1] == BACKGROUND_CODE { 6 } else { 1 };
            for i in 0..8 {
                let at = if least[i] == BACKGROUND_CODE { spare } else { i };
                levels.least[i][lane] = T::from_code(u32::from(least[at]));
                levels.most[i][lane] = T::from_code(u32::from(most[at].min(BACKGROUND_CODE - 1)));
            }
        }
        levels
    }

    /// What each pixel costs at least.
    fn costs(&self, levels: &Levels<T>) -> [[T; LANES]; 64] {
        let zero = T::from_code(0);
        let bound = T::from_code(u32::from(self.tile.bound));
        let mut costs = [[zero; LANES]; 64];
        for (pixel, costs) in costs.iter_mut().enumerate() {
            if self.tile.surfaces >> pixel & 1 != 0 {
                let code = T::from_code(u32::from(self.tile.codes[pixel]));
                let mut nearest = [T::CAP; LANES];
                for (least, most) in levels.least.iter().zip(&levels.most) {
                    for lane in 0..LANES {
                        let outside = greater(least[lane] - code, code - most[lane]);
                        nearest[lane] = lesser(outside, nearest[lane]);
                    }
                }
                for lane in 0..LANES {
                    let error = greater(nearest[lane], zero);
                    costs[lane] = if error > bound { T::CAP } else { lesser(error * error, T::CAP) };
                }
            } else if self.tile.background >> pixel & 1 != 0 {
                *costs = levels.background;
            }
        }
        costs
    }

    /// The solution of the line with the least bounds, when squares are single pairs and bounds are costs.
    fn solution(&self, pairs: &[Square]) -> Option<Solution> {
        let total = |place: &usize| self.bounds[*place][0] + self.bounds[*place][1];
        let place = (0..self.lines.len())
            .min_by(|a, b| total(a).partial_cmp(&total(b)).unwrap_or(std::cmp::Ordering::Equal))?;
        let parted = bipartitions()[self.lines[place]];
        let find = |side: u64, cost: T| {
            pairs
                .iter()
                .map(|square| match square.mode {
                    Mode::Eight => Pair { e0: square.high, e1: square.low },
                    Mode::Six => Pair { e0: square.low, e1: square.high },
                })
                .find(|&pair| self.tile.cost(side, pair).is_some_and(|found| T::from_sum(found) == cost))
        };
        let [a, b] = self.bounds[place];
        Some(Solution { line: parted.line, pairs: [find(!parted.side_b, a)?, find(parted.side_b, b)?] })
    }
}
