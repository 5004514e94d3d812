//! Finds a good pair of endpoints for the pixels of one side: a least-squares fit and a search around it.

use crate::depth::bc4w::tile::{Tile, surface_codes};
use crate::depth::bc4w::{MAX_ENDPOINT, Pair};
use crate::depth::quantise::BACKGROUND_CODE;

const LANES: usize = 8;

/// Surface codes of a side, padded to a multiple of [`LANES`] by repeating the last one with weight 0.
struct Surfaces {
    codes: [[f32; LANES]; 8],
    weights: [[f32; LANES]; 8],
    groups: usize,
    count: usize,
}

impl Surfaces {
    fn of(tile: &Tile, side: u64) -> Surfaces {
        let mut surfaces = Surfaces { codes: [[0.0; LANES]; 8], weights: [[0.0; LANES]; 8], groups: 0, count: 0 };
        let mut rest = tile.surfaces & side;
        let mut last = 0.0;
        while rest != 0 {
            let at = surfaces.count;
            last = f32::from(tile.codes[rest.trailing_zeros() as usize]);
            surfaces.codes[at / LANES][at % LANES] = last;
            surfaces.weights[at / LANES][at % LANES] = 1.0;
            surfaces.count += 1;
            rest &= rest - 1;
        }
        surfaces.groups = surfaces.count.div_ceil(LANES);
        for at in surfaces.count..surfaces.groups * LANES {
            surfaces.codes[at / LANES][at % LANES] = last;
        }
        surfaces
    }

    fn extremes(&self) -> [f32; 2] {
        let (mut low, mut high) = (self.codes[0], self.codes[0]);
        for codes in &self.codes[..self.groups] {
            for lane in 0..LANES {
                low[lane] = if codes[lane] < low[lane] { codes[lane] } else { low[lane] };
                high[lane] = if codes[lane] > high[lane] { codes[lane] } else { high[lane] };
            }
        }
        [low.into_iter().fold(f32::MAX, f32::min), high.into_iter().fold(0.0, f32::max)]
    }

    /// Returns the sum of squared differences in single precision; infinite if a difference exceeds the bound.
    fn cost(&self, pair: Pair, bound: f32) -> f32 {
        let levels = surface_codes(pair.palette()).map(f32::from);
        let (mut sum, mut worst) = ([0.0; LANES], [0.0; LANES]);
        for (codes, weights) in self.codes[..self.groups].iter().zip(&self.weights) {
            let mut least = [f32::MAX; LANES];
            for level in levels {
                for lane in 0..LANES {
                    let error = (codes[lane] - level).abs();
                    least[lane] = if error < least[lane] { error } else { least[lane] };
                }
            }
            for lane in 0..LANES {
                worst[lane] = if least[lane] > worst[lane] { least[lane] } else { worst[lane] };
                sum[lane] += least[lane] * least[lane] * weights[lane];
            }
        }
        if worst.iter().any(|&worst| worst > bound) { f32::INFINITY } else { sum.iter().sum() }
    }

    /// Returns the ends of the least-squares line of the codes over their nearest of `steps` + 1 levels from `low` to `high`,
    /// after two iterations. Codes below `floor` are excluded: code 0 of the second mode represents them.
    fn ends(&self, [mut low, mut high]: [f32; 2], steps: f32, floor: f32) -> [f32; 2] {
        for _ in 0..2 {
            let scale = if high > low { steps / (high - low) } else { 0.0 };
            let mut sums = [[0.0; LANES]; 5];
            for (codes, weights) in self.codes[..self.groups].iter().zip(&self.weights) {
                for lane in 0..LANES {
                    let at = (codes[lane] - low) * scale;
                    let at = if at > 0.0 { at } else { 0.0 };
                    let at = if at < steps { at } else { steps };
                    let at = ((at + 0.5) as i32) as f32;
                    let weight = if codes[lane] < floor { 0.0 } else { weights[lane] };
                    let value = codes[lane] - low;
                    sums[0][lane] += weight;
                    sums[1][lane] += weight * at;
                    sums[2][lane] += weight * at * at;
                    sums[3][lane] += weight * value;
                    sums[4][lane] += weight * at * value;
                }
            }
            let [n, t, tt, v, tv] = sums.map(|lanes| lanes.iter().sum::<f32>());
            let spread = n * tt - t * t;
            if spread <= 0.0 {
                break;
            }
            let slope = (n * tv - t * v) / spread;
            low += (v - slope * t) / n;
            high = low + slope * steps;
        }
        [low, high]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polish {
    None,
    /// Moves to neighbouring pairs while the cost falls.
    Neighbours,
}

/// Returns a good pair for a side within the bound, with its approximate cost. With [`Polish::Neighbours`] the pair is a local
/// minimum or close to one.
pub fn best_pair(tile: &Tile, side: u64, polish: Polish) -> Option<(f32, Pair)> {
    let (rounds, reach) = match polish {
        Polish::None => (1, 0),
        Polish::Neighbours => (8, 1),
    };
    let surfaces = Surfaces::of(tile, side);
    let lacks = |pair: Pair| tile.background & side != 0 && !pair.palette().contains(&BACKGROUND_CODE);
    if surfaces.count == 0 {
        return Some((0.0, Pair { e0: 0, e1: 0 }));
    }
    let endpoints = tile.endpoints(side);
    let (first, last) = (i32::from(*endpoints.start()), i32::from(*endpoints.end()));
    let bound = f32::from(tile.bound);
    let [low, high] = surfaces.extremes();
    let mut best = (f32::INFINITY, None);
    for (steps, descending) in [(7.0, true), (5.0, false)] {
        if descending && tile.background & side != 0 && last < i32::from(MAX_ENDPOINT) {
            continue;
        }
        // The second mode also has code 0, so its other codes need not extend down to it.
        let floor = if descending || low > 64.0 { 0.0 } else { 64.0 + f32::from(tile.bound.min(448)) };
        let start = if floor > 0.0 && high > 2.0 * floor { [floor, high] } else { [low, high] };
        let floor = if start[0] > low { floor } else { 0.0 };
        let ends = if tile.bound < u16::MAX { start } else { surfaces.ends(start, steps, floor) };
        let at = ends.map(|end| (end * (8191.0 / 65535.0) + 0.5) as i32);
        let mut centre = at.map(|at| at.clamp(first, last));
        if descending && centre[0] == centre[1] {
            // The first mode needs two different endpoints.
            if centre[1] < last { centre[1] += 1 } else { centre[0] -= 1 }
        }
        let mut least = f32::INFINITY;
        for _ in 0..rounds {
            let mut next = centre;
            for dl in -reach..=reach {
                for dh in -reach..=reach {
                    let [low, high] = [centre[0] + dl, centre[1] + dh];
                    if low < first || high > last || high < low + i32::from(descending) {
                        continue;
                    }
                    let (low, high) = (low as u16, high as u16);
                    let pair = if descending { Pair { e0: high, e1: low } } else { Pair { e0: low, e1: high } };
                    let cost = if lacks(pair) { f32::INFINITY } else { surfaces.cost(pair, bound) };
                    if cost < least {
                        (least, next) = (cost, [i32::from(low), i32::from(high)]);
                        if cost < best.0 {
                            best = (cost, Some(pair));
                        }
                    }
                }
            }
            if next == centre {
                break;
            }
            centre = next;
        }
    }
    best.1.map(|pair| (best.0, pair))
}
