//! Colour at the end of a ray: of a surface, of the background, or of a disocclusion.

use glam::Vec3;

use crate::march::{ActiveViews, HOLE_DIFFERENCE, Interpolated, background_color, surface_color};
use crate::views::ColorCoding;
use codec::image::ToneMap;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayResult {
    /// Linear RGB of a surface or of the background.
    Light(Vec3),
    /// No view saw this point; the linear RGB of the texels with the nearest depths, if there are any.
    Disoccluded(Option<Vec3>),
}

impl RayResult {
    /// Returns the result for an interpolated surface colour. `uncertainty` is that of the hit, in log distance.
    pub(crate) fn of_surface(color: Option<Interpolated>, uncertainty: f32, light: impl Fn(Vec3) -> Vec3) -> RayResult {
        match color {
            Some(found) if found.difference <= HOLE_DIFFERENCE + uncertainty => RayResult::Light(light(found.color)),
            found => RayResult::Disoccluded(found.map(|found| light(found.color))),
        }
    }
}

/// Shades a surface point; see `RayResult::of_surface` for `uncertainty`.
pub fn surface(views: &ActiveViews<'_>, point: Vec3, uncertainty: f32) -> RayResult {
    RayResult::of_surface(surface_color(views, point), uncertainty, |color| light_of(views.coding, color))
}

/// Shades the background in a direction of length 1.
pub fn background(views: &ActiveViews<'_>, direction: Vec3) -> RayResult {
    background_color(views, direction)
        .map_or(RayResult::Disoccluded(None), |found| RayResult::Light(light_of(views.coding, found.color)))
}

pub fn light_of(coding: ColorCoding, color: Vec3) -> Vec3 {
    match coding {
        ColorCoding::Light => color,
        ColorCoding::Codes(tone) => color.to_array().map(|code| decode(tone, code)).into(),
    }
}

fn decode(tone: ToneMap, code: f32) -> f32 {
    (tone.transfer.decode(code.into()) * gain(tone)) as f32
}

/// Returns the linear value of the maximum code.
fn gain(tone: ToneMap) -> f64 {
    libm::exp2(-f64::from(tone.exposure_ev))
}

/// Table from 8-bit codes with fractions to linear values.
pub(crate) struct LightCurve {
    values: Vec<f32>,
}

impl LightCurve {
    /// Number of intervals. The error of linear interpolation is less than 2e-7 of the maximum value.
    const PARTS: usize = 4096;

    pub(crate) fn new(tone: ToneMap) -> LightCurve {
        let gain = gain(tone);
        let value = |at: usize| (tone.transfer.decode(at as f64 / Self::PARTS as f64) * gain) as f32;
        LightCurve { values: (0..=Self::PARTS + 1).map(value).collect() }
    }

    /// Returns the linear value of a code over 255.
    pub(crate) fn light(&self, code: f32) -> f32 {
        let at = code.clamp(0.0, 1.0) * Self::PARTS as f32;
        let entry = at as usize;
        let [low, high] = [self.values[entry], self.values[entry + 1]];
        low + (high - low) * (at - entry as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::transfer::Transfer;

    #[test]
    fn light_is_that_of_the_curve() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            let curve = LightCurve::new(ToneMap { transfer, exposure_ev: 0.0 });
            for at in 0..=100_000 {
                let code = at as f32 / 100_000.0;
                let exact = transfer.decode(f64::from(code));
                assert!((f64::from(curve.light(code)) - exact).abs() < 2e-7, "{code}");
            }
        }
    }
}
