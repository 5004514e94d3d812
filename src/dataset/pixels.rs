//! Checks and converts values of a source: background, invalid values, planar depth.

use half::f16;

use crate::error::{Error, Result};
use crate::image::{ColorPlane, DepthPlane, Face, ImageProjection, MaterialPlane, Plane, Transfer};

/// Treatment of depth that is NaN, zero, negative or −inf and is not the background.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InvalidDepth {
    /// An error that names file and pixel.
    #[default]
    Refuse,
    /// Nothing is there: the pixel becomes +inf.
    Far,
    /// As near as can be: the pixel becomes 0.0, which encoders store as code 0, the probe's near plane.
    Near,
}

impl InvalidDepth {
    pub fn name(self) -> &'static str {
        match self {
            InvalidDepth::Refuse => "refuse",
            InvalidDepth::Far => "far",
            InvalidDepth::Near => "near",
        }
    }
}

/// Treatment of colour that is NaN, and of material values that are not finite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InvalidColor {
    /// An error that names file and pixel.
    #[default]
    Refuse,
    /// The component becomes 0.
    Black,
}

impl InvalidColor {
    pub fn name(self) -> &'static str {
        if self == InvalidColor::Refuse { "refuse" } else { "black" }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct DepthRules {
    /// Value in the file that means "nothing there", besides +inf.
    pub background: f32,
    pub scale: f64,
    pub invalid: InvalidDepth,
}

pub(super) fn pixel(index: usize, width: u32) -> String {
    format!("pixel ({}, {})", index as u64 % u64::from(width.max(1)), index as u64 / u64::from(width.max(1)))
}

/// A positive depth in metres times a factor, kept inside the positive finite floats: +inf and 0 have a meaning.
fn metres(value: f32, factor: f64) -> f32 {
    let product = (f64::from(value) * factor) as f32;
    product.clamp(f32::from_bits(1), f32::MAX)
}

/// Applies the rules: +inf where nothing is, 0.0 where [`InvalidDepth::Near`] put it, else a finite value above 0.
pub(super) fn check_depth(plane: &mut DepthPlane, rules: &DepthRules) -> Result<()> {
    let width = plane.width();
    for (index, value) in plane.data_mut().iter_mut().enumerate() {
        let depth = *value;
        *value = if depth == f32::INFINITY || depth == rules.background {
            f32::INFINITY
        } else if depth > 0.0 {
            if rules.scale == 1.0 { depth } else { metres(depth, rules.scale) }
        } else {
            match rules.invalid {
                InvalidDepth::Far => f32::INFINITY,
                InvalidDepth::Near => 0.0,
                InvalidDepth::Refuse => {
                    let say = "set `invalid_depth` to far or near";
                    let what = match depth {
                        depth if depth.is_nan() => format!("not a number; {say}, as `background` cannot match it"),
                        0.0 => format!("zero; {say}, or `background` to 0 if it means no surface"),
                        depth => {
                            format!("negative ({depth}); {say}, or `background` to the value that means no surface")
                        }
                    };
                    return Err(Error::invalid(format!("depth at {} is {what}", pixel(index, width))));
                }
            }
        };
    }
    Ok(())
}

/// Turns planar depth into distance; +inf and 0.0 stay.
pub(crate) fn planar_to_distance(plane: &mut DepthPlane, projection: &ImageProjection) {
    for row in 0..plane.height() {
        for (col, value) in plane.row_mut(row).iter_mut().enumerate() {
            if *value > 0.0 && *value < f32::INFINITY {
                *value = metres(*value, projection.ray_length_factor(col as u32, row));
            }
        }
    }
}

/// Clamps infinities to the largest half; NaN is an error or black.
pub(super) fn check_color(plane: &mut ColorPlane, invalid: InvalidColor) -> Result<()> {
    let width = plane.width();
    for (index, components) in plane.data_mut().iter_mut().enumerate() {
        for component in components.iter_mut() {
            if component.is_nan() {
                match invalid {
                    InvalidColor::Black => *component = f16::ZERO,
                    InvalidColor::Refuse => {
                        let message = format!(
                            "colour at {} is not a number; set `invalid_color` to black to replace it",
                            pixel(index, width)
                        );
                        return Err(Error::invalid(message));
                    }
                }
            } else if component.is_infinite() {
                *component = if component.is_sign_negative() { f16::MIN } else { f16::MAX };
            }
        }
    }
    Ok(())
}

/// Every value must be a finite number, or becomes 0.
pub(super) fn check_material(plane: &mut MaterialPlane, invalid: InvalidColor) -> Result<()> {
    let width = plane.width();
    for (index, components) in plane.data_mut().iter_mut().enumerate() {
        for component in components.iter_mut().filter(|component| !component.is_finite()) {
            match invalid {
                InvalidColor::Black => *component = 0.0,
                InvalidColor::Refuse => {
                    let message = format!("material at {} is {component}, not a finite number", pixel(index, width));
                    return Err(Error::invalid(message));
                }
            }
        }
    }
    Ok(())
}

/// sRGB code values, 1.0 the brightest, to linear light.
pub(super) fn linear_from_srgb(plane: &mut ColorPlane) {
    for component in plane.data_mut().as_flattened_mut() {
        *component = f16::from_f64(Transfer::Srgb.decode(component.to_f64()));
    }
}

/// Keeps the planes of `wanted` out of all six cube faces.
pub(super) fn keep_faces<T>(all: Vec<Plane<T>>, wanted: &[Face]) -> Vec<Plane<T>> {
    Face::CUBE.into_iter().zip(all).filter(|(face, _)| wanted.contains(face)).map(|(_, plane)| plane).collect()
}
