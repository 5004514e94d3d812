//! Fits the plane with the lowest maximum error over a block, by iteratively reweighted least squares (Lawson 1961): weights are
//! multiplied by the errors of the previous fit.

use crate::depth::predictive::projection::Curvature;

/// A value at (x, y), in pixels from the block's centre.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub x: f64,
    pub y: f64,
    /// Code without the projection's correction.
    pub value: f64,
}

/// Value and slopes of a plane at the block's centre, in codes, and its maximum error.
#[derive(Debug, Clone, Copy)]
pub struct Fit {
    pub numbers: [f64; 3],
    pub error: f64,
}

/// Fits a plane. Stops after `rounds` rounds of reweighting, or earlier if no plane comes near `bound` or one is well within it.
pub fn minimax(samples: &[Sample], bound: f64, curvature: Curvature, rounds: usize) -> Fit {
    let mean = samples.iter().map(|sample| sample.value).sum::<f64>() / samples.len().max(1) as f64;
    let bend = if curvature.codes > 0 { 0.5 / f64::from(curvature.codes) } else { 0.0 };
    let mut weights = [1.0; 64];
    let mut errors = [0.0; 64];
    let mut numbers = [mean, 0.0, 0.0];
    let mut best = Fit { numbers, error: f64::INFINITY };
    for round in 0..rounds {
        let mut sums = [[0.0; 4]; 3];
        for (sample, weight) in samples.iter().zip(weights) {
            let height = numbers[1] * sample.x + numbers[2] * sample.y;
            let target = sample.value - mean - height * height * bend;
            let basis = [1.0, sample.x, sample.y, target];
            for (row, &factor) in sums.iter_mut().zip(&basis[..3]) {
                row.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * factor * value);
            }
        }
        let [value, x, y] = solve(sums);
        numbers = [mean + value, x, y];
        let (mut worst, mut total) = (0.0f64, 0.0);
        for ((sample, error), weight) in samples.iter().zip(&mut errors).zip(&weights) {
            let height = x * sample.x + y * sample.y;
            *error = (numbers[0] + height + height * height * bend - sample.value).abs();
            worst = worst.max(*error);
            total += weight * (*error + 1e-9);
        }
        if worst < best.error {
            best = Fit { numbers, error: worst };
        }
        let hopeless = round == 0 && worst > 6.0 * bound + 6.0 || round > 8 && best.error > 2.0 * bound + 2.0;
        if hopeless || round > 0 && best.error < 0.6 * bound {
            break;
        }
        let scale = samples.len() as f64 / total;
        weights.iter_mut().zip(errors).for_each(|(weight, error)| *weight *= (error + 1e-9) * scale);
    }
    best
}

/// Solves a linear system by Gauss-Jordan elimination. The matrix is positive semidefinite, so no pivoting is needed.
fn solve(mut rows: [[f64; 4]; 3]) -> [f64; 3] {
    for pivot in 0..3 {
        let scale = 1.0 / (rows[pivot][pivot] + 1e-12);
        rows[pivot].iter_mut().for_each(|value| *value *= scale);
        let from = rows[pivot];
        for (at, row) in rows.iter_mut().enumerate() {
            if at != pivot {
                let factor = row[pivot];
                row.iter_mut().zip(from).for_each(|(value, from)| *value -= factor * from);
            }
        }
    }
    rows.map(|row| row[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_error_of_a_ramp_with_two_outliers_is_halved() {
        let curvature = Curvature { codes: 0, factor: 0 };
        let samples: Vec<Sample> = (0..64)
            .map(|at| {
                let [x, y] = [at % 8, at / 8].map(|at| f64::from(at) - 3.5);
                let outlier = if at == 0 { 10.0 } else { 0.0 };
                Sample { x, y, value: 1000.0 + 7.0 * x - 3.0 * y + outlier }
            })
            .collect();
        let fit = minimax(&samples, 4.0, curvature, 30);
        assert!(fit.error < 5.0, "{fit:?}");
        assert!((fit.numbers[1] - 7.0).abs() < 1.0 && (fit.numbers[2] + 3.0).abs() < 1.0);
    }
}
