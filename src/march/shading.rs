//! Light at the end of a ray: on a surface, in the background, or in a disocclusion.

use glam::Vec3;

use crate::image::ToneMap;
use crate::march::{ActiveViews, HOLE_DIFFERENCE, Interpolated, background_color, surface_color};
use crate::views::ColorCoding;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayResult {
    /// Linear light of a surface or of the background.
    Light(Vec3),
    /// No view saw this point; the light of the nearest texels, where there are any.
    Disoccluded(Option<Vec3>),
}

impl RayResult {
    /// `uncertainty` is that of the hit, in the logarithm of its distance.
    pub(crate) fn of_surface(color: Option<Interpolated>, uncertainty: f32, light: impl Fn(Vec3) -> Vec3) -> RayResult {
        match color {
            Some(found) if found.difference <= HOLE_DIFFERENCE + uncertainty => RayResult::Light(light(found.color)),
            found => RayResult::Disoccluded(found.map(|found| light(found.color))),
        }
    }
}

/// Shades a surface point; `uncertainty` as for [`RayResult::of_surface`].
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
    (tone.transfer.decode(code.into()) * (-f64::from(tone.exposure_ev)).exp2()) as f32
}
