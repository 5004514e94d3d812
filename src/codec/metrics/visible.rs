//! Visible error of an image (color.md 5.2): a squared error that weights errors some pixels wide the most, luma more than
//! chroma, and textured areas less. The quality on the scale of SSIMULACRA2 is computed from it.

/// Side of the squares in which the texture of the source masks errors.
const SIDE: usize = 8;
const PIXELS: usize = SIDE * SIDE;
/// Weights of errors by their width: differences of pixels within 2x2, of 2x2 means within 4x4, of 4x4 means within 8x8, and the
/// 8x8 mean. Rows are luma, green chroma and orange chroma. The weights are fitted to scores of 64x64 pixels of images of several
/// codecs.
const WEIGHTS: [[f32; 4]; 3] = [[0.5, 0.5, 8.0, 1.0], [0.03125, 0.04, 0.09, 0.125], [0.00625, 0.008, 0.018, 0.025]];
/// Luma variance of the source in codes²: below `QUIET` it masks hardly any error, and at `USUAL` the weight of errors is 1.
const QUIET: f32 = 40.0;
const USUAL: f32 = 100.0;
/// Loss of quality at a visible error of 1 code².
const LOSS: f64 = 7.8;

/// Returns the quality for a visible error in codes²; 100 without any error.
pub fn quality_of(error: f64) -> f64 {
    100.0 - LOSS * error.sqrt()
}

/// Returns the maximum visible error, in codes², at a quality of 0 to 100.
pub fn error_of(quality: f64) -> f64 {
    ((100.0 - quality) / LOSS).powi(2)
}

/// Returns the visible error in codes² of an image of `width`×`height` pixels. `at` returns the shown pixel and the source pixel
/// at a column and row, as red, green and blue codes.
pub fn visible_error([width, height]: [usize; 2], at: impl Fn(usize, usize) -> [[f32; 3]; 2]) -> f64 {
    let mut sum = 0.0;
    for top in (0..height).step_by(SIDE) {
        for left in (0..width).step_by(SIDE) {
            let mut square = Square::default();
            for place in 0..PIXELS {
                let (x, y) = ((left + place % SIDE).min(width - 1), (top + place / SIDE).min(height - 1));
                square.set(place, at(x, y));
            }
            sum += f64::from(square.error());
        }
    }
    sum / (width.div_ceil(SIDE) * height.div_ceil(SIDE)).max(1) as f64
}

/// Channel errors of 8x8 pixels, and the luma of the source.
struct Square {
    errors: [[f32; PIXELS]; 3],
    luma: [f32; PIXELS],
}

impl Default for Square {
    fn default() -> Self {
        Square { errors: [[0.0; PIXELS]; 3], luma: [0.0; PIXELS] }
    }
}

impl Square {
    #[inline(always)]
    fn set(&mut self, place: usize, [shown, source]: [[f32; 3]; 2]) {
        let [red, green, blue] = [0, 1, 2].map(|channel| shown[channel] - source[channel]);
        let channels = [0.25 * (red + blue) + 0.5 * green, green - 0.5 * (red + blue), red - blue];
        for (errors, error) in self.errors.iter_mut().zip(channels) {
            errors[place] = error;
        }
        self.luma[place] = 0.25 * (source[0] + source[2]) + 0.5 * source[1];
    }

    /// Returns the weighted error per pixel, times the masking factor of the source.
    fn error(&self) -> f32 {
        let weighted = |(errors, weights): (&[f32; PIXELS], &[f32; 4])| {
            let twos: [f32; 16] = pooled::<PIXELS, 16>(errors);
            let fours: [f32; 4] = pooled::<16, 4>(&twos);
            let eights: [f32; 1] = pooled::<4, 1>(&fours);
            let energies = [energy(errors), energy(&twos) / 4.0, energy(&fours) / 16.0, energy(&eights) / 64.0, 0.0];
            let bands = energies.windows(2).map(|pair| pair[0] - pair[1]);
            bands.zip(weights).map(|(band, weight)| band * weight).sum::<f32>()
        };
        let error = self.errors.iter().zip(&WEIGHTS).map(weighted).sum::<f32>() / PIXELS as f32;
        let mean = self.luma.iter().sum::<f32>() / PIXELS as f32;
        let variance = self.luma.iter().map(|luma| (luma - mean) * (luma - mean)).sum::<f32>() / PIXELS as f32;
        // Rounding may make the sum of the bands negative.
        error.max(0.0) * (QUIET + USUAL) / (QUIET + variance)
    }
}

/// Returns the sums over the 2x2 squares of a square of N values.
fn pooled<const N: usize, const M: usize>(values: &[f32; N]) -> [f32; M] {
    let side = N.isqrt();
    std::array::from_fn(|at| {
        let first = at / (side / 2) * 2 * side + at % (side / 2) * 2;
        values[first] + values[first + 1] + values[first + side] + values[first + side + 1]
    })
}

fn energy(values: &[f32]) -> f32 {
    values.iter().map(|value| value * value).sum()
}
