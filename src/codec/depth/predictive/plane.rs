//! Planes in blocks (depth.md 15.6): a value and two slopes at a block's centre, with the curvature that planes have in the
//! logarithm of depth. Arithmetic is on 32-bit integers; sums and products wrap if a file was made so that they overflow.

use crate::depth::predictive::pixel::{MIDDLE, Pixel, Steps};
use crate::depth::predictive::projection::Curvature;

/// Maximum magnitude of slopes.
const MAX_SLOPE: i32 = 1 << 20;
/// Maximum magnitude of the argument of the square in [`Plane::row`].
const MAX_HEIGHT: i32 = 32_767;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    /// Value at the block's centre, in 256ths of a code.
    pub value: i32,
    /// Slopes to the right and down, in 256ths of a code per pixel.
    pub slope: [i32; 2],
}

/// Block size of a plane: 8x8 pixels or 4x4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Block = 0,
    Quarter = 1,
}

/// Step sizes of a plane's change, in 256ths of a code.
#[derive(Debug, Clone, Copy)]
pub struct ChangeSteps {
    pub value: i32,
    pub slope: i32,
}

impl ChangeSteps {
    pub fn new(steps: &Steps, side: Side) -> ChangeSteps {
        let slope = match side {
            Side::Block => steps.bound * 32,
            Side::Quarter => steps.bound * 64,
        };
        ChangeSteps { value: (steps.bound * 128).max(256), slope: slope.max(16) }
    }
}

impl Plane {
    /// Plane that is assumed outside the unit and next to background.
    pub const UNKNOWN: Plane = Plane { value: MIDDLE, slope: [0; 2] };

    pub fn of_pixel(pixel: &Pixel) -> Plane {
        Plane { value: pixel.value, slope: pixel.slope.map(clamp_slope) }
    }

    /// Returns the same plane at another centre, which is offset by `x` half pixels to the right and `y` down.
    pub fn moved(self, [x, y]: [i32; 2], curvature: Curvature) -> Plane {
        let distance = (self.slope[0] * x + self.slope[1] * y) >> 1;
        let value = self.value.wrapping_add(distance);
        let codes = curvature.codes;
        if codes == 0 || distance.abs() > codes << 7 {
            // No curvature is applied without a projection. A plane that is almost parallel to the ray stays as it is.
            return if codes == 0 { Plane { value, ..self } } else { self };
        }
        // Change of the logarithm and its square, in 4096ths.
        let ratio = 16 * distance / codes;
        let square = (ratio * ratio) >> 12;
        let bend = (((distance >> 6) * ratio) >> 7) + (distance >> 6) * square / 192;
        let steeper = |slope: i32| clamp_slope(slope + (((slope >> 2) * (ratio + square)) >> 10));
        Plane { value: value.wrapping_add(bend), slope: self.slope.map(steeper) }
    }

    pub fn average(self, other: Plane) -> Plane {
        let mean = |a: i32, b: i32| a.wrapping_add(b) >> 1;
        Plane { value: mean(self.value, other.value), slope: [0, 1].map(|at| mean(self.slope[at], other.slope[at])) }
    }

    pub fn changed(self, [value, x, y]: [i32; 3], steps: ChangeSteps) -> Plane {
        let slope = |at: usize, change: i32| clamp_slope(self.slope[at].wrapping_add(change.wrapping_mul(steps.slope)));
        Plane { value: self.value.wrapping_add(value.wrapping_mul(steps.value)), slope: [slope(0, x), slope(1, y)] }
    }

    /// Returns the values of row `y` of a block of SIDE x SIDE pixels.
    #[inline(always)]
    pub fn row<const SIDE: usize>(&self, y: usize, curvature: Curvature) -> [i32; SIDE] {
        let half = |at: usize| 2 * at as i32 + 1 - SIDE as i32;
        let start = self.slope[1] * half(y);
        std::array::from_fn(|x| {
            // `height` is in 512ths of a code, `quarters` in quarters of a code.
            let height = self.slope[0] * half(x) + start;
            let quarters = (height >> 7).clamp(-MAX_HEIGHT, MAX_HEIGHT);
            let bend = (((quarters * quarters) as u32 >> 12) * curvature.factor) >> 7;
            self.value.wrapping_add(height >> 1).wrapping_add(bend as i32)
        })
    }
}

fn clamp_slope(slope: i32) -> i32 {
    slope.clamp(-MAX_SLOPE, MAX_SLOPE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::predictive::projection::{Projection, Shape};

    #[test]
    fn a_plane_in_space_stays_one_when_its_centre_moves() {
        // Inverse depth is linear over the picture: code = -codes · ln(1 - t).
        for octave in [2_000, 9_731, 60_000] {
            let curvature = Projection { shape: Shape::Planar, octave }.curvature();
            let codes = f64::from(octave) / std::f64::consts::LN_2;
            let code = |t: f64| -codes * (-t).ln_1p() * 256.0;
            for slope in [0.0, 0.0005, -0.002, 0.004] {
                let plane = Plane { value: 0, slope: [(slope * codes * 256.0) as i32, 0] };
                let moved = plane.moved([16, 0], curvature);
                let error = (f64::from(moved.value) - code(8.0 * slope)).abs() / 256.0;
                assert!(error < 0.5 + codes * 2e-5, "{octave} {slope}: {error}");
                let row = plane.row::<8>(0, curvature);
                for (x, value) in row.into_iter().enumerate() {
                    let error = (f64::from(value) - code((x as f64 - 3.5) * slope)).abs() / 256.0;
                    assert!(error < 0.5 + codes * 2e-5, "{octave} {slope} {x}: {error}");
                }
            }
        }
    }

    #[test]
    fn no_legal_plane_overflows() {
        let extremes = [i32::MIN, -MAX_SLOPE, -1, 0, 1, MAX_SLOPE, i32::MAX];
        for octave in [0, 512, 131_071] {
            let shape = if octave == 0 { Shape::None } else { Shape::Planar };
            let curvature = Projection { shape, octave }.curvature();
            for (value, x, y) in itertools(extremes) {
                let pixel = Pixel::in_plane(value, [x, y]);
                let plane = Plane::of_pixel(&pixel);
                for by in [[16, 0], [0, 16], [9, -1], [-1, 5]] {
                    _ = plane.moved(by, curvature).average(plane).row::<8>(7, curvature);
                }
                _ = plane.changed([value, x, y], ChangeSteps { value: 65_534 * 128, slope: 65_534 * 64 });
            }
        }
    }

    fn itertools(values: [i32; 7]) -> impl Iterator<Item = (i32, i32, i32)> {
        (0..343).map(move |at| (values[at % 7], values[at / 7 % 7], values[at / 49]))
    }
}
