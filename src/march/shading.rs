//! The light of a ray by where it ends: on a surface, in the background, or in a disocclusion.

use glam::Vec3;

use crate::image::transfer::ToneMap;
use crate::march::active_views::ActiveViews;
use crate::march::interpolate::{Seen, background_color, surface_color};
use crate::views::light_field::ColorCoding;

/// A hit is a hole where every texel differs from it by more than this in the logarithm of the distance, beyond what the
/// steps leave open: nobody saw a surface there.
pub const HOLE_DIFFERENCE: f32 = 0.1;

/// What a ray from the eye has brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// A colour in linear light, of a surface or of the background.
    Seen(Vec3),
    /// A hole; the colour of what comes nearest, where there is anything.
    Hole(Option<Vec3>),
}

impl Outcome {
    /// What views saw of a surface: a hole where nothing fits; `unsure` is how far steps leave open where it is.
    pub(crate) fn of_surface(seen: Option<Seen>, unsure: f32, light: impl Fn(&Seen) -> Vec3) -> Outcome {
        match seen {
            Some(seen) if seen.difference <= HOLE_DIFFERENCE + unsure => Outcome::Seen(light(&seen)),
            seen => Outcome::Hole(seen.map(|seen| light(&seen))),
        }
    }
}

/// What a ray brings that ends in a surface at a point; `unsure` is how far, in the logarithm of the distance, the steps
/// leave open where.
pub fn surface(views: &ActiveViews<'_>, weights: &[f32], point: Vec3, unsure: f32) -> Outcome {
    Outcome::of_surface(surface_color(views, weights, point), unsure, |seen| light(views.coding, seen))
}

/// What a ray brings that meets no surface and goes in this direction, of length 1.
pub fn background(views: &ActiveViews<'_>, weights: &[f32], direction: Vec3) -> Outcome {
    background_color(views, weights, direction)
        .map_or(Outcome::Hole(None), |seen| Outcome::Seen(light(views.coding, &seen)))
}

/// Linear light of what views saw.
fn light(coding: ColorCoding, seen: &Seen) -> Vec3 {
    light_of(coding, seen.color)
}

/// Linear light of a colour as it is coded.
pub fn light_of(coding: ColorCoding, color: Vec3) -> Vec3 {
    match coding {
        ColorCoding::Light => color,
        ColorCoding::Codes(tone) => color.to_array().map(|code| decode(tone, code)).into(),
    }
}

fn decode(tone: ToneMap, code: f32) -> f32 {
    (tone.transfer.decode(code.into()) * (-f64::from(tone.exposure_ev)).exp2()) as f32
}
