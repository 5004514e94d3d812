//! Low-discrepancy sequences: additive recurrences of the generalised golden ratio, Hammersley sets, spirals. Any run of
//! consecutive indices is spread evenly.

use std::f64::consts::TAU;

use glam::DVec3;

/// Powers of 1/g, where g is the root of x⁴ = x + 1.
const CUBE_STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_1];
/// Golden angle as a fraction of a full turn.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105_1;

/// Returns a point of the sequence in the unit cube; the first point is the centre.
pub fn in_cube(index: u64) -> DVec3 {
    // Beyond 2^40 points the fraction would lose precision.
    let along = |step: f64| (0.5 + (index % (1 << 40)) as f64 * step).fract();
    DVec3::new(along(CUBE_STEPS[0]), along(CUBE_STEPS[1]), along(CUBE_STEPS[2]))
}

/// Returns a point of a Hammersley set: (index + ½) / count, and the radical inverses of the index in base 2 and 3.
pub fn hammersley(index: u64, count: u64) -> DVec3 {
    DVec3::new((index as f64 + 0.5) / count as f64, mirrored(index, 2), mirrored(index, 3))
}

/// Returns the radical inverse of a number.
fn mirrored(mut number: u64, base: u64) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= base as f64;
        value += digit * (number % base) as f64;
        number /= base;
    }
    value
}

/// Returns one of `count` directions that are spread evenly over the sphere.
pub fn on_sphere(index: usize, count: usize) -> DVec3 {
    spiral(index, 1.0 - 2.0 * (index as f64 + 0.5) / count as f64)
}

/// Returns one of `count` directions that are spread evenly over the hemisphere of y > 0.
pub fn on_hemisphere(index: usize, count: usize) -> DVec3 {
    spiral(index, 1.0 - (index as f64 + 0.5) / count as f64)
}

fn spiral(index: usize, y: f64) -> DVec3 {
    around((index as f64 * GOLDEN_TURN).fract(), y)
}

/// Returns the unit direction of height y at a fraction of a turn around the vertical axis.
pub fn around(turn: f64, y: f64) -> DVec3 {
    let (sin, cos) = (TAU * turn).sin_cos();
    let across = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(across * cos, y, across * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_the_ratio() {
        let ratio = CUBE_STEPS[0];
        assert!((ratio.powi(-4) - ratio.recip() - 1.0).abs() < 1e-12);
        assert!((ratio.powi(2) - CUBE_STEPS[1]).abs() < 1e-15 && (ratio.powi(3) - CUBE_STEPS[2]).abs() < 1e-15);
    }

    #[test]
    fn any_run_fills_the_cube_evenly() {
        assert_eq!(in_cube(0), DVec3::splat(0.5));
        for start in [0, 7000, 123_456_789] {
            let mut counts = [0; 64];
            for point in (start..start + 6400).map(in_cube) {
                assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
                let cell = (point * 4.0).floor();
                counts[(cell.x + 4.0 * cell.y + 16.0 * cell.z) as usize] += 1;
            }
            assert!(counts.iter().all(|count| (86..=114).contains(count)), "{counts:?}");
        }
    }

    #[test]
    fn hammersleys_points_are_indices_and_their_mirrored_digits() {
        let found: Vec<[f64; 3]> = (0..4).map(|at| hammersley(at, 4).to_array()).collect();
        let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0];
        let expected = [[0.125, 0.0], [0.375, 0.5], [0.625, 0.25], [0.875, 0.75]];
        for (at, point) in found.iter().enumerate() {
            assert_eq!(point[..2], expected[at]);
            assert!((point[2] - thirds[at]).abs() < 1e-15);
        }
    }

    #[test]
    fn directions_are_spread_evenly() {
        let sum: DVec3 = (0..64).map(|at| on_sphere(at, 64)).sum();
        assert!(sum.length() < 1.0, "{sum}");
        let half: Vec<DVec3> = (0..64).map(|at| on_hemisphere(at, 64)).collect();
        assert!(half.iter().all(|v| v.y > 0.0 && (v.length() - 1.0).abs() < 1e-12));
        let mean = half.iter().sum::<DVec3>() / 64.0;
        assert!((mean - DVec3::Y * 0.5).length() < 0.02, "{mean}");
    }
}
