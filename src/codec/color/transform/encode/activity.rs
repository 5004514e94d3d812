//! Activity of regions, which determines how fine their steps are (color.md 6.3).

use crate::color::quality::Quality;
use crate::color::transform::blocks::MIN_SIDE;
use crate::color::transform::domain::Keyed;
use crate::color::transform::encode::source::CellSource;
use crate::color::transform::steps::{DELTA_UNIT, DELTAS};

/// Variances of luma in codes². Below `QUIET`, a place hardly masks errors; at `USUAL`, its weight is 1, which is a delta of
/// 0.
const QUIET: f32 = 80.0;
const USUAL: f32 = 100.0;
/// Width in pixels of the margin around a square that counts as its surroundings.
const AROUND: usize = 2;

/// Returns the delta of the step indices of a region. Steps are finer the lower the variance around its squares of 4x4 pixels
/// is, in all frames, and the more codes one key is. It is derived from the mean of the weights, not from the weight of the
/// mean, so that a region with a smooth part keeps fine steps.
pub fn delta<S: Keyed, Q: Quality<S>>(
    cell: &CellSource<'_, S>,
    [left, top, width, height]: [usize; 4],
    quality: &Q,
) -> i8 {
    let (mut sum, mut count) = (0.0f64, 0u32);
    let mut image = Image { width, luma: Vec::new(), slopes: Vec::new() };
    for frame in cell.frames {
        image.luma.clear();
        image.slopes.clear();
        for y in top..top + height {
            let row = &frame[3 * (y * cell.size[0] + left)..][..3 * width];
            for pixel in row.as_chunks::<3>().0 {
                let [red, green, blue] = pixel.map(|sample| quality.code(sample));
                image.luma.push(0.25 * (red + blue) + 0.5 * green);
                image.slopes.push(pixel.iter().map(|&sample| quality.codes_a_key(sample)).sum::<f32>() / 3.0);
            }
        }
        for (y, x) in (0..height).step_by(MIN_SIDE).flat_map(|y| (0..width).step_by(MIN_SIDE).map(move |x| (y, x))) {
            sum += f64::from(image.weight([x, y]));
            count += 1;
        }
    }
    let octaves = log2(sum / f64::from(count.max(1)));
    let units = -8.0 * octaves / f64::from(DELTA_UNIT);
    (units.round() as i32).clamp((*DELTAS.start()).into(), (*DELTAS.end()).into()) as i8
}

struct Image {
    width: usize,
    luma: Vec<f32>,
    /// Codes per key, relative to 8-bit samples.
    slopes: Vec<f32>,
}

impl Image {
    /// Weight of a squared error in keys, at a square.
    fn weight(&self, place: [usize; 2]) -> f32 {
        let height = self.luma.len() / self.width;
        let [[columns, rows], [inner_columns, inner_rows]] = [AROUND, 0].map(|around| {
            let range = |at: usize, most: usize| at.saturating_sub(around)..(at + MIN_SIDE + around).min(most);
            [range(place[0], self.width), range(place[1], height)]
        });
        let count = (columns.len() * rows.len()) as f32;
        let (mut sum, mut squares) = (0.0, 0.0);
        for row in rows {
            for value in &self.luma[row * self.width..][columns.clone()] {
                sum += value;
                squares += value * value;
            }
        }
        let variance = (squares / count - (sum / count) * (sum / count)).max(0.0);
        let count = (inner_columns.len() * inner_rows.len()) as f32;
        let slope = inner_rows.map(|row| self.slopes[row * self.width..][inner_columns.clone()].iter().sum::<f32>());
        let slope = slope.sum::<f32>() / count;
        ((QUIET + USUAL) / (QUIET + variance)).sqrt() * slope * slope
    }
}

/// Approximates log2, with the same result on all machines: linear between powers of 2; -1000 for 0.
fn log2(value: f64) -> f64 {
    if value <= 0.0 {
        return -1000.0;
    }
    let exponent = (value.to_bits() >> 52) as i32 - 1023;
    f64::from(exponent) + value / 2f64.powi(exponent) - 1.0
}
