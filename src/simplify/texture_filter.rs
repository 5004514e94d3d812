//! Reconstruction filters of colour (Seurat 5.2): weights of a sample in the texels around it, separable into columns and rows.

/// Maximum number of texels of a row that a sample reaches.
pub const MAX_TEXELS: usize = 5;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// Radius of 1.5 texels and standard deviation of 0.4 texels: with less, views from between the cameras have more noise.
    #[default]
    Gaussian,
    /// Mean of the samples in each texel.
    Box,
    /// Cubic, with a radius of 2 texels.
    BSpline,
}

impl TextureFilter {
    /// Returns the distance in texels beyond which weights are 0.
    pub fn radius(self) -> f32 {
        match self {
            TextureFilter::Gaussian => 1.5,
            TextureFilter::Box => 0.5,
            TextureFilter::BSpline => 2.0,
        }
    }

    /// Returns the weight at a distance in texels, which must be within the radius.
    pub fn weight(self, distance: f32) -> f32 {
        match self {
            TextureFilter::Gaussian => {
                const SIGMA: f32 = 0.4;
                (distance.powi(2) * (-0.5 / (SIGMA * SIGMA))).exp()
            }
            TextureFilter::Box => 1.0,
            TextureFilter::BSpline => match distance.abs() {
                near @ ..1.0 => 2.0 / 3.0 - near * near * (1.0 - 0.5 * near),
                far => (2.0 - far).powi(3) / 6.0,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_from_the_middle_and_reach_few_texels() {
        for filter in [TextureFilter::Gaussian, TextureFilter::Box, TextureFilter::BSpline] {
            let radius = filter.radius();
            let weights: Vec<f32> = (0..=100).map(|step| filter.weight(step as f32 * radius / 100.0)).collect();
            assert!(weights.is_sorted_by(|a, b| a >= b) && weights[0] > 0.5 && weights[100] >= 0.0, "{filter:?}");
            let texels = 1 + (2.0 * radius) as usize;
            assert!(texels <= MAX_TEXELS && filter.weight(-0.3) == filter.weight(0.3));
        }
    }

    #[test]
    fn weights_of_a_b_spline_add_up_to_one() {
        for at in (0..10).map(|step| step as f32 / 10.0) {
            let sum: f32 = (-1..3).map(|texel| TextureFilter::BSpline.weight(texel as f32 - at)).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{at}: {sum}");
        }
        assert!((TextureFilter::BSpline.weight(1.0) - 1.0 / 6.0).abs() < 1e-6);
    }
}
