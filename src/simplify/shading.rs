//! Colour of tiles (Seurat 5.2).
//!
//! Takes samples at solid constraints, and returns filtered linear RGB by texel. Texels without samples are filled from the
//! texels around them.

use super::texture_filter::{MAX_TEXELS, TextureFilter};

/// Minimum weight of a sample in texels within the radius: a texel that no other sample reaches takes the colour of this one.
const MIN_WEIGHT: f32 = 1e-20;
/// Number of Gauss–Seidel sweeps on each level of the multigrid.
const SWEEPS: usize = 4;

/// Setting that skips work whose result is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShortCuts {
    #[default]
    Taken,
    /// No work is skipped: the result is the same, but takes longer.
    Off,
}

/// Weighted sums of the linear RGB of a square texture's texels, and the sums of weights.
#[derive(Debug, Clone)]
pub struct LightBuffer {
    side: usize,
    filter: TextureFilter,
    sums: Vec<[f32; 4]>,
}

impl LightBuffer {
    pub fn new(side: usize, filter: TextureFilter) -> LightBuffer {
        LightBuffer { side, filter, sums: vec![[0.0; 4]; side * side] }
    }

    pub fn side(&self) -> usize {
        self.side
    }

    /// Adds linear RGB, multiplied by a weight above 0, at a position in texels; 0 is the centre of the first texel.
    pub fn add(&mut self, [x, y]: [f32; 2], [r, g, b]: [f32; 3], share: f32) {
        let radius = self.filter.radius();
        let range = |at: f32| {
            let first = (at - radius).ceil().max(0.0) as usize;
            first..((at + radius).floor() + 1.0).clamp(0.0, self.side as f32) as usize
        };
        let weight = |texel: usize, at: f32| self.filter.weight(texel as f32 - at);
        let (columns, rows) = (range(x), range(y));
        let mut weights = [0.0; MAX_TEXELS];
        columns.clone().zip(&mut weights).for_each(|(column, value)| *value = weight(column, x));
        for row in rows {
            let of_row = weight(row, y);
            let sums = &mut self.sums[row * self.side..][columns.clone()];
            for (sum, of_column) in sums.iter_mut().zip(weights) {
                let weight = (of_row * of_column * share).max(MIN_WEIGHT);
                *sum = std::array::from_fn(|channel| sum[channel] + weight * [r, g, b, 1.0][channel]);
            }
        }
    }

    /// Returns the linear RGB of all texels, each with a coverage of 1, and the number of texels that had no sample and were filled.
    pub fn resolve(mut self, short_cuts: ShortCuts) -> (Vec<[f32; 4]>, usize) {
        let missing = self.sums.iter().filter(|sum| sum[3] <= 0.0).count();
        if missing > 0 || short_cuts == ShortCuts::Off {
            let mean = |&[r, g, b, weight]: &[f32; 4]| (weight > 0.0).then(|| [r / weight, g / weight, b / weight]);
            let light = fill(self.side, &self.sums.iter().map(mean).collect::<Vec<_>>());
            self.sums.iter_mut().zip(light).for_each(|(sum, [r, g, b])| *sum = [r, g, b, 1.0]);
        } else {
            self.sums.iter_mut().for_each(|sum| *sum = sum.map(|value| value / sum[3]));
        }
        (self.sums, missing)
    }
}

/// Returns linear RGB with missing texels filled.
fn filled(side: usize, light: &[Option<[f32; 3]>]) -> Vec<[f32; 3]> {
    if light.iter().all(Option::is_some) { light.iter().copied().flatten().collect() } else { fill(side, light) }
}

/// Solves the discrete Laplace equation at unknown texels, with known texels as the boundary: first on textures of half the size,
/// and then by Gauss–Seidel sweeps.
fn fill(side: usize, light: &[Option<[f32; 3]>]) -> Vec<[f32; 3]> {
    let mut filled: Vec<[f32; 3]> = light.iter().map(|light| light.unwrap_or_default()).collect();
    if side == 1 || light.iter().all(Option::is_none) {
        return filled;
    }
    let half = side.div_ceil(2);
    let mean = |at: usize| {
        let (x, y) = (2 * (at % half), 2 * (at / half));
        let around = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let known: Vec<[f32; 3]> =
            around.iter().filter(|[x, y]| *x < side && *y < side).filter_map(|[x, y]| light[y * side + x]).collect();
        (!known.is_empty()).then(|| {
            std::array::from_fn(|channel| known.iter().map(|light| light[channel]).sum::<f32>() / known.len() as f32)
        })
    };
    let coarse: Vec<Option<[f32; 3]>> = (0..half * half).map(mean).collect();
    let coarse = self::filled(half, &coarse);
    let unknown: Vec<usize> = (0..side * side).filter(|&at| light[at].is_none()).collect();
    for &at in &unknown {
        filled[at] = coarse[at / side / 2 * half + at % side / 2];
    }
    for _ in 0..SWEEPS {
        for &at in &unknown {
            let (x, y) = (at % side, at / side);
            let beside = [
                (x > 0).then(|| at - 1),
                (x + 1 < side).then(|| at + 1),
                (y > 0).then(|| at - side),
                (y + 1 < side).then(|| at + side),
            ];
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for other in beside.into_iter().flatten() {
                (0..3).for_each(|channel| sum[channel] += filled[other][channel]);
                count += 1.0;
            }
            if count > 0.0 {
                filled[at] = sum.map(|sum| sum / count);
            }
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_without_samples_lie_on_the_surface_between_their_neighbours() {
        let side = 17;
        // Only the border is known: a linear ramp, which satisfies the Laplace equation.
        let ramp = |at: usize| (at % side) as f32 / 16.0;
        let is_border = |at: usize| [0, side - 1].contains(&(at % side)) || [0, side - 1].contains(&(at / side));
        let light: Vec<Option<[f32; 3]>> =
            (0..side * side).map(|at| is_border(at).then(|| [ramp(at), 2.0 * ramp(at), 1.0])).collect();
        for (at, filled) in fill(side, &light).into_iter().enumerate() {
            assert!((filled[0] - ramp(at)).abs() < 0.1 && (filled[2] - 1.0).abs() < 1e-5, "{at}: {filled:?}");
        }
        assert_eq!(fill(2, &[None; 4]), [[0.0; 3]; 4]);
    }

    #[test]
    fn samples_are_weighted_by_their_distance() {
        let lit = |filter| {
            let mut buffer = LightBuffer::new(4, filter);
            buffer.add([1.0, 1.0], [1.0, 0.0, 0.0], 1.0);
            buffer.add([1.6, 1.0], [0.0, 1.0, 0.0], 1.0);
            buffer.resolve(ShortCuts::Taken)
        };
        let (light, missing) = lit(TextureFilter::Gaussian);
        let [at, beside] = [light[5], light[6]];
        // At the second texel 1 and e^(-1.5² / 2), at the third e^(-2.5² / 2) and e^(-1 / 2).
        assert!((at[0] - 0.754_91).abs() < 1e-4 && (at[0] + at[1] - 1.0).abs() < 1e-6, "{at:?}");
        assert!((beside[1] - 0.932_45).abs() < 1e-4, "{beside:?}");
        assert!(missing > 0 && missing < 12, "{missing}");
        // Each sample is in a texel of its own.
        let (light, missing) = lit(TextureFilter::Box);
        assert_eq!((light[5], light[6], missing), ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], 14));
        // Weights at the second texel: 2/3 at a distance of 0, 2/3 - 0.36 + 0.108 at 0.6.
        let (light, missing) = lit(TextureFilter::BSpline);
        let share = 2.0 / 3.0 / (2.0 / 3.0 + 0.414_667);
        assert!((light[5][0] - share).abs() < 1e-5 && missing == 0, "{light:?}");
    }
}
