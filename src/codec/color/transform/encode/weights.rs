//! Weights of squared errors by frame, and quantisation with these weights.
//!
//! A quality target holds in the worst frame, so an error counts more in frames that are worse than others. Within a block of
//! several frames, the error of frame f is Σ b(k, f)·d(k) over its temporal frequencies k, and the weighted error is dᵀ·M·d
//! with M(k, j) = Σ w(f)·b(k, f)·b(j, f). Frequencies are quantised in turn; each compensates for the errors of earlier ones.

use crate::color::transform::blocks::Block;
use crate::color::transform::encode::source::TimeBases;

/// Change of log2 of a weight per change of log2 of the frame's error.
const RESPONSE: f64 = 1.5;
/// Change of all weights in octaves that has the effect of one step index.
const OCTAVES_A_STEP: f64 = 0.3;
/// Maximum of |log2| of a weight: weights are from 1/32 to 32.
const MAX_OCTAVES: f64 = 5.0;

/// Weights of the frames of a chunk, as logarithms to base 2.
#[derive(Debug, Clone)]
pub struct FrameWeights {
    octaves: Vec<f64>,
    weights: Vec<f32>,
}

impl FrameWeights {
    pub fn even(frames: usize) -> FrameWeights {
        FrameWeights { octaves: vec![0.0; frames], weights: vec![1.0; frames] }
    }

    /// Weights of the frames of a block.
    pub fn of(&self, block: Block) -> &[f32] {
        &self.weights[block.place.frame..][..block.shape.frames]
    }

    /// Mean weight of the frames of a block.
    pub fn mean(&self, block: Block) -> f32 {
        self.of(block).iter().sum::<f32>() / block.shape.frames as f32
    }

    /// Raises the weights of frames whose squared error is above the limit and lowers the others; `excess` is log2 of error
    /// over limit by frame. The common change of all weights is moved into the step as far as possible. Returns the number of
    /// indices by which the step becomes finer.
    pub fn follow(&mut self, excess: &[f64]) -> i32 {
        for (octaves, excess) in self.octaves.iter_mut().zip(excess) {
            *octaves += RESPONSE * excess;
        }
        let finer = (self.octaves.iter().sum::<f64>() / self.octaves.len() as f64 / OCTAVES_A_STEP).round();
        for (octaves, weight) in self.octaves.iter_mut().zip(&mut self.weights) {
            *octaves = (*octaves - OCTAVES_A_STEP * finer).clamp(-MAX_OCTAVES, MAX_OCTAVES);
            *weight = exp2(*octaves) as f32;
        }
        finer as i32
    }
}

/// Approximates 2^x, with the same result on all machines: linear between powers of 2.
fn exp2(x: f64) -> f64 {
    let whole = x.floor();
    (1.0 + x - whole) * 2f64.powi(whole as i32)
}

/// Weights of a block's temporal frequencies.
pub struct TimeWeights {
    frames: usize,
    mean: f32,
    /// M, row by row; empty if all frames have the same weight.
    matrix: Vec<f32>,
}

impl TimeWeights {
    pub fn new(bases: &TimeBases, weights: &[f32]) -> TimeWeights {
        let frames = weights.len();
        let mean = weights.iter().sum::<f32>() / frames as f32;
        let mut matrix = Vec::new();
        if weights.iter().any(|weight| *weight != weights[0]) {
            let basis = bases.of(frames);
            matrix.resize(frames * frames, 0.0);
            for (k, row) in basis.chunks_exact(frames).enumerate() {
                for (j, other) in basis.chunks_exact(frames).enumerate().take(k + 1) {
                    let terms = weights.iter().zip(row).zip(other).map(|((weight, a), b)| weight * a * b);
                    matrix[k * frames + j] = terms.sum();
                }
            }
        }
        TimeWeights { frames, mean, matrix }
    }

    /// Weight of the squared error of a plane.
    pub fn of_plane(&self, plane: usize) -> f32 {
        if self.matrix.is_empty() { self.mean } else { self.matrix[plane * self.frames + plane] }
    }

    /// Changes a plane's coefficients so that they best compensate for the `errors` of earlier planes, and appends the
    /// unchanged coefficients to `errors`. Returns the amount by which the squared error of the changed coefficients is too
    /// large.
    pub fn compensate(&self, plane: usize, coefficients: &mut [f32], errors: &mut Vec<f32>) -> f32 {
        if self.matrix.is_empty() {
            return 0.0;
        }
        errors.extend_from_slice(coefficients);
        let row = &self.matrix[plane * self.frames..][..plane + 1];
        let mut shifts = vec![0.0; coefficients.len()];
        for (weight, errors) in row[..plane].iter().zip(errors.chunks_exact(coefficients.len())) {
            let weight = weight / row[plane];
            shifts.iter_mut().zip(errors).for_each(|(shift, error)| *shift += weight * error);
        }
        coefficients.iter_mut().zip(&shifts).for_each(|(coefficient, shift)| *coefficient += shift);
        shifts.iter().map(|shift| shift * shift).sum()
    }

    /// Subtracts the plane's levels from its part of `errors`.
    pub fn subtract(&self, plane: usize, levels: &[i32], errors: &mut [f32]) {
        let first = plane * levels.len();
        if let Some(errors) = errors.get_mut(first..first + levels.len()) {
            errors.iter_mut().zip(levels).for_each(|(error, level)| *error -= *level as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: usize = 6;

    /// Σ w(f)·e(f)² of an error with these temporal frequencies.
    fn weighted(errors: &[f32], weights: &[f32], basis: &[f32]) -> f32 {
        let of_frame = |frame: usize| -> f32 { (0..FRAMES).map(|k| errors[k] * basis[k * FRAMES + frame]).sum() };
        weights.iter().enumerate().map(|(frame, weight)| weight * of_frame(frame).powi(2)).sum()
    }

    #[test]
    fn errors_of_planes_add_up_to_the_weighted_error_of_frames() {
        let bases = TimeBases::up_to(FRAMES);
        let coefficients = [5.3, -2.6, 1.4, 0.7, -0.45, 0.3];
        for weights in [[1.0; FRAMES], [2.5; FRAMES], [0.2, 0.5, 1.0, 1.0, 3.0, 8.0]] {
            let time = TimeWeights::new(&bases, &weights);
            let (mut compensated, mut levels, mut errors) = (0.0, [0; FRAMES], Vec::new());
            for plane in 0..FRAMES {
                let mut coefficient = [coefficients[plane]];
                let saved = time.compensate(plane, &mut coefficient, &mut errors);
                levels[plane] = coefficient[0].round() as i32;
                time.subtract(plane, &levels[plane..plane + 1], &mut errors);
                compensated += time.of_plane(plane) * ((coefficient[0] - levels[plane] as f32).powi(2) - saved);
            }
            let error: Vec<f32> = coefficients.iter().zip(levels).map(|(value, level)| value - level as f32).collect();
            let expected = weighted(&error, &weights, bases.of(FRAMES));
            // Integer bases are orthonormal only within their precision.
            assert!((compensated - expected).abs() < 0.01 * expected, "{weights:?}: {compensated}, {expected}");
            let rounded: Vec<f32> = coefficients.iter().map(|value| value - value.round()).collect();
            assert!(expected <= 1.01 * weighted(&rounded, &weights, bases.of(FRAMES)), "{weights:?}");
        }
    }

    #[test]
    fn weights_follow_errors_and_leave_what_is_common_to_the_step() {
        let mut weights = FrameWeights::even(3);
        // All frames an octave above the limit: about 1.5 octaves of weight, or five indices.
        assert_eq!(weights.follow(&[1.0; 3]), 5);
        assert!(weights.weights.iter().all(|weight| (weight - 1.0).abs() < 0.01), "{weights:?}");
        assert_eq!(weights.follow(&[0.4, -0.2, -0.2]), 0);
        assert!(weights.weights[0] > 1.4 && weights.weights[1] < 0.9, "{weights:?}");
        for _ in 0..100 {
            weights.follow(&[4.0, -4.0, -4.0]);
        }
        assert!(weights.weights.iter().all(|weight| (1.0 / 32.0..=32.0).contains(weight)), "{weights:?}");
    }
}
