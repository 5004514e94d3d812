//! Finds the line, endpoints and indices of a block.
//!
//! The search space is every bipartition by a line ([`bipartitions`](crate::depth::bc4w::bipartitions)) and, for each side and in
//! both modes, all pairs of 13-bit endpoints within [`PAD`](crate::depth::bc4w::tile::PAD) of the side's surfaces. Tests search
//! all of it (`literal`). `Exhaustive` finds the same squared error by branch and bound (`MAX_SQUARES` states where that is not
//! proven). `Normal` and `Fast` try the most promising lines, many or few, with endpoints around a least-squares fit (`quick`):
//! the exact search takes milliseconds per block, and its last tenths of a decibel are seldom worth the time.
//!
//! Branch and bound is over pairs of endpoints, for all lines at once. The plane of endpoint pairs is divided into squares.
//! Palette entries increase with both endpoints, so over a square each entry stays between its values at two corners. The
//! distance of a pixel to the nearest of these eight intervals is a lower bound of its error for all pairs of the square, and
//! the sum of the squared distances over a side is a lower bound of the side's cost. A line is dropped once the bounds of its
//! sides add up to at least the limit, which is the lowest cost known to be possible. A square is dropped if it cannot improve
//! any remaining line; the remaining squares are divided into four. At the end the exact costs of the remaining lines and pairs
//! are computed: either the lowest is that of the literal search, or no solution is better than the known one.
//!
//! Bounds are 16-bit integers in units of 2^shift, rounded down, so that eight squares are processed in parallel.

use crate::depth::bc4w::bipartitions::bipartitions;
use crate::depth::bc4w::quick::{self, Trials};
use crate::depth::bc4w::sums::{Plan, Quantity, lesser, plus};
use crate::depth::bc4w::tile::{Solution, Tile, surface_codes};
use crate::depth::bc4w::{Bc4w, MAX_ENDPOINT, Pair};
use crate::depth::block::{Accuracy, Block};
use crate::depth::quantise::BACKGROUND_CODE;
use crate::effort::Effort;

const LANES: usize = 8;
/// Minimum number of initial squares per axis; there are at most twice as many.
const FIRST_SQUARES: u16 = 8;
const TRIALS: Trials = Trials { fitted: 16, polished: 8 };
/// Maximum limit in units of 2^shift. Errors are clamped so that their squares fit 15 bits; the clamped square exceeds this
/// maximum at every shift.
const MAX_UNITS: u64 = 32_000;

/// Maximum number of remaining squares. If there are more, the search ends with the known solution. This happens on tiles with
/// widely spaced codes, where many pairs have nearly the same cost.
const MAX_SQUARES: usize = 1 << 13;

/// Returns the block with the lowest squared error found at this effort. The background is exact.
pub fn encode(block: &Block<'_>, effort: Effort) -> (Bc4w, Accuracy) {
    let tile = Tile::new(block, u16::MAX);
    // Without a bound there is always a solution: palettes of the second mode contain the background and code 0.
    let solution = search(&tile, effort).unwrap_or(Solution::FLAT);
    tile.finish(solution)
}

/// Returns the block with the lowest squared error found at this effort among those with no difference above `bound` codes;
/// `None` if no such block was found.
pub fn encode_within(block: &Block<'_>, bound: u16, effort: Effort) -> Option<(Bc4w, Accuracy)> {
    let tile = Tile::new(block, bound);
    search(&tile, effort).map(|solution| tile.finish(solution))
}

fn search(tile: &Tile, effort: Effort) -> Option<Solution> {
    if tile.surfaces == 0 {
        return Some(Solution::FLAT);
    }
    match effort {
        Effort::Fast => quick::best_of(tile, quick::FAST).map(|(_, solution)| solution),
        Effort::Normal => quick::best_of(tile, quick::NORMAL).map(|(_, solution)| solution),
        Effort::Exhaustive => bounded(tile),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Eight,
    Six,
}

/// A square of endpoint pairs, given by its smallest endpoints. All squares of a pass have the same size.
#[derive(Debug, Clone, Copy)]
struct Square {
    mode: Mode,
    low: u16,
    high: u16,
}

impl Square {
    fn pair(self) -> Pair {
        match self.mode {
            Mode::Eight => Pair { e0: self.high, e1: self.low },
            Mode::Six => Pair { e0: self.low, e1: self.high },
        }
    }
}

/// Searches by branch and bound, as described at the head of this file.
fn bounded(tile: &Tile) -> Option<Solution> {
    let known = quick::best_of(tile, TRIALS);
    // Any solution within the error bound costs less than this.
    let pixels = u64::from(tile.surfaces.count_ones());
    let most = pixels * u64::from(tile.bound) * u64::from(tile.bound) + 1;
    let limit = known.map_or(most, |(cost, _)| cost);
    let known = known.map(|(_, solution)| solution);
    if limit == 0 { known } else { Search::new(tile, limit, known).run() }
}

/// Minimum and maximum code of each palette index over a square, and the cost of a background pixel. Each lane is a square.
struct Levels {
    least: [[u16; LANES]; 8],
    most: [[u16; LANES]; 8],
    background: [i16; LANES],
}

type Costs<T, const L: usize> = [[T; L]; 64];

struct Search<'a> {
    tile: &'a Tile,
    known: Option<Solution>,
    limit: u64,
    unit_limit: i16,
    shift: u32,
    first: u16,
    last: u16,
    lines: Vec<usize>,
    plan: Plan,
    /// Lower bounds of the costs of sides A and B of the remaining lines, for solutions that cost less than the limit.
    bounds: Vec<[i16; 2]>,
    /// First and last endpoint of sides A and B of the remaining lines.
    ranges: Vec<[[i16; 2]; 2]>,
    tried: Vec<usize>,
}

impl<'a> Search<'a> {
    fn new(tile: &'a Tile, limit: u64, known: Option<Solution>) -> Search<'a> {
        let endpoints = tile.endpoints(u64::MAX);
        let plan = Plan::all().clone();
        let mut shift = 0;
        while limit.div_ceil(1 << shift) > MAX_UNITS {
            shift += 1;
        }
        Search {
            tile,
            known,
            limit,
            unit_limit: limit.div_ceil(1 << shift) as i16,
            shift,
            first: *endpoints.start(),
            last: *endpoints.end(),
            lines: (0..plan.len()).collect(),
            bounds: vec![[0; 2]; plan.len()],
            ranges: bipartitions()
                .iter()
                .map(|parted| {
                    [!parted.side_b, parted.side_b].map(|side| {
                        let range = tile.endpoints(side);
                        [*range.start() as i16, *range.end() as i16]
                    })
                })
                .collect(),
            tried: Vec::new(),
            plan,
        }
    }

    fn run(mut self) -> Option<Solution> {
        let count = self.last - self.first + 1;
        let mut size = 1 << (count / FIRST_SQUARES).max(1).ilog2();
        let starts = || (self.first..=self.last).step_by(usize::from(size));
        let mut squares: Vec<Square> = [Mode::Eight, Mode::Six]
            .into_iter()
            .flat_map(|mode| starts().flat_map(move |high| starts().map(move |low| Square { mode, low, high })))
            .filter(|square| self.holds_any(*square, size))
            .collect();
        loop {
            let kept = self.pass(&squares, size);
            if self.lines.is_empty() {
                return self.known;
            }
            if size == 1 {
                return self.exact(&kept).or(self.known);
            }
            if kept.len() > MAX_SQUARES {
                return self.known;
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

    fn holds_any(&self, square: Square, size: u16) -> bool {
        let most = (square.high + size - 1).min(self.last);
        match square.mode {
            Mode::Eight => most > square.low,
            Mode::Six => most >= square.low,
        }
    }

    /// Computes the bounds of lines, drops lines, and returns the squares that may improve a remaining line.
    fn pass(&mut self, squares: &[Square], size: u16) -> Vec<Square> {
        let costs: Vec<_> = squares.chunks(LANES).map(|group| self.costs(&self.levels(group, size))).collect();
        let mut room = Vec::new();
        let mut least = vec![[[i16::INFINITE; LANES]; 2]; self.lines.len()];
        let ranges = &self.ranges;
        for (group, costs) in squares.chunks(LANES).zip(&costs) {
            let ends = ends(group, size);
            self.plan.for_each_line(costs, &mut room, |line, a, b| {
                let (a, b) = (within(ranges[line][0], &ends, a), within(ranges[line][1], &ends, b));
                let [min_a, min_b] = &mut least[line];
                for lane in 0..LANES {
                    min_a[lane] = lesser(a[lane], min_a[lane]);
                    min_b[lane] = lesser(b[lane], min_b[lane]);
                }
            });
        }
        self.bounds =
            least.iter().map(|sides| sides.map(|lanes| lanes.into_iter().fold(i16::INFINITE, lesser))).collect();
        self.drop_lines();
        self.try_lines();
        self.drop_lines();
        let mut kept = Vec::new();
        for (group, costs) in squares.chunks(LANES).zip(&costs) {
            let mut total = [i16::INFINITE; LANES];
            let (bounds, ranges) = (&self.bounds, &self.ranges);
            let ends = ends(group, size);
            self.plan.for_each_line(costs, &mut room, |line, a, b| {
                let (a, b) = (within(ranges[line][0], &ends, a), within(ranges[line][1], &ends, b));
                let [other_a, other_b] = bounds[line].map(|bound| [bound; LANES]);
                let (a, b) = (plus(a, other_b), plus(b, other_a));
                for lane in 0..LANES {
                    total[lane] = lesser(lesser(a[lane], b[lane]), total[lane]);
                }
            });
            kept.extend(
                group.iter().zip(total).filter(|(_, total)| *total < self.unit_limit).map(|(square, _)| *square),
            );
        }
        kept
    }

    fn drop_lines(&mut self) {
        let places: Vec<usize> = (0..self.lines.len())
            .filter(|&place| self.bounds[place][0].plus(self.bounds[place][1]) < self.unit_limit)
            .collect();
        if places.len() < self.lines.len() {
            self.lines = places.iter().map(|&place| self.lines[place]).collect();
            self.bounds = places.iter().map(|&place| self.bounds[place]).collect();
            self.ranges = places.iter().map(|&place| self.ranges[place]).collect();
            self.plan = self.plan.of_some(&places);
        }
    }

    /// Solves the lines with the lowest bounds heuristically, and lowers the limit to the lowest cost found.
    fn try_lines(&mut self) {
        let mut order: Vec<(i16, usize)> =
            self.bounds.iter().zip(&self.lines).map(|([a, b], &line)| (a.plus(*b), line)).collect();
        order.sort_unstable();
        for (_, line) in
            order.into_iter().filter(|(_, line)| !self.tried.contains(line)).take(TRIALS.polished).collect::<Vec<_>>()
        {
            self.tried.push(line);
            if let Some((cost, solution)) = quick::solve(self.tile, line).filter(|&(cost, _)| cost < self.limit) {
                self.limit = cost;
                self.unit_limit = cost.div_ceil(1 << self.shift) as i16;
                self.known = Some(solution);
            }
        }
    }

    fn levels(&self, group: &[Square], size: u16) -> Levels {
        let mut levels = Levels { least: [[0; LANES]; 8], most: [[0; LANES]; 8], background: [i16::INFINITE; LANES] };
        for lane in 0..LANES {
            let Square { mode, low, high } = group[lane.min(group.len() - 1)];
            let [max_low, max_high] = [low, high].map(|at| (at + size - 1).min(self.last));
            let (least, most) = match mode {
                Mode::Eight => (Pair::eight([high, low]), Pair::eight([max_high, max_low])),
                Mode::Six => (Pair::six([low, high]), Pair::six([max_low, max_high])),
            };
            if mode == Mode::Six || max_high == MAX_ENDPOINT {
                levels.background[lane] = 0;
            }
            // A surface must not use the background code; another code of the palette replaces it.
            let spare = if least[1] == BACKGROUND_CODE { 6 } else { 1 };
            for i in 0..8 {
                let at = if least[i] == BACKGROUND_CODE { spare } else { i };
                levels.least[i][lane] = least[at];
                levels.most[i][lane] = most[at].min(BACKGROUND_CODE - 1);
            }
        }
        levels
    }

    fn costs(&self, levels: &Levels) -> Costs<i16, LANES> {
        // Largest error whose square fits into 15 bits, in units of 2^shift.
        let most = ((1u64 << (15 + self.shift)) - 1).isqrt().min(65535) as u16;
        let mut costs = [[0; LANES]; 64];
        for (pixel, costs) in costs.iter_mut().enumerate() {
            if self.tile.surfaces >> pixel & 1 != 0 {
                let code = self.tile.codes[pixel];
                let mut nearest = [u16::MAX; LANES];
                for (least, most) in levels.least.iter().zip(&levels.most) {
                    for lane in 0..LANES {
                        let outside = least[lane].saturating_sub(code) | code.saturating_sub(most[lane]);
                        nearest[lane] = nearest[lane].min(outside);
                    }
                }
                for lane in 0..LANES {
                    let error = u32::from(nearest[lane].min(most));
                    let cost = ((error * error) >> self.shift) as i16;
                    costs[lane] = if nearest[lane] > self.tile.bound { i16::INFINITE } else { cost };
                }
            } else if self.tile.background >> pixel & 1 != 0 {
                *costs = levels.background;
            }
        }
        costs
    }

    fn exact(&self, squares: &[Square]) -> Option<Solution> {
        const FEW: usize = 4;
        let mut best = vec![[(f64::INFINITE, Pair { e0: 0, e1: 0 }); 2]; self.lines.len()];
        let mut room = Vec::new();
        for group in squares.chunks(FEW) {
            let pairs: [Pair; FEW] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)].pair());
            self.plan.for_each_line(&self.exact_costs(pairs), &mut room, |line, a, b| {
                for ((best, costs), [first, last]) in best[line].iter_mut().zip([a, b]).zip(self.ranges[line]) {
                    for lane in 0..FEW {
                        let Pair { e0, e1 } = pairs[lane];
                        let inside = e0.min(e1) as i16 >= first && e0.max(e1) as i16 <= last;
                        if inside && costs[lane] < best.0 {
                            *best = (costs[lane], pairs[lane]);
                        }
                    }
                }
            });
        }
        let (&line, best) =
            self.lines.iter().zip(best).min_by(|(_, [a, b]), (_, [c, d])| (a.0 + b.0).total_cmp(&(c.0 + d.0)))?;
        let [a, b] = best;
        (a.0 + b.0 < self.limit as f64).then_some(Solution { line: bipartitions()[line].line, pairs: [a.1, b.1] })
    }

    fn exact_costs<const L: usize>(&self, pairs: [Pair; L]) -> Costs<f64, L> {
        let palettes = pairs.map(Pair::palette);
        let levels = palettes.map(surface_codes);
        let background = palettes.map(|palette| if palette.contains(&BACKGROUND_CODE) { 0.0 } else { f64::INFINITE });
        std::array::from_fn(|pixel| {
            if self.tile.surfaces >> pixel & 1 != 0 {
                let code = self.tile.codes[pixel];
                levels.map(|levels| {
                    let error = levels.iter().fold(u16::MAX, |least, level| least.min(level.abs_diff(code)));
                    if error > self.tile.bound { f64::INFINITE } else { f64::from(error) * f64::from(error) }
                })
            } else if self.tile.background >> pixel & 1 != 0 {
                background
            } else {
                [0.0; L]
            }
        })
    }
}

/// Returns the largest low endpoint and the smallest high endpoint of each square.
fn ends(group: &[Square], size: u16) -> [[i16; LANES]; 2] {
    let at = |lane: usize| group[lane.min(group.len() - 1)];
    [std::array::from_fn(|lane| (at(lane).low + size - 1) as i16), std::array::from_fn(|lane| at(lane).high as i16)]
}

/// Returns the costs of a side, with `INFINITE` for squares without a pair in the endpoint range of the side.
#[inline(always)]
fn within([first, last]: [i16; 2], [low, high]: &[[i16; LANES]; 2], mut costs: [i16; LANES]) -> [i16; LANES] {
    for lane in 0..LANES {
        costs[lane] = if (low[lane] < first) | (high[lane] > last) { i16::INFINITE } else { costs[lane] };
    }
    costs
}
