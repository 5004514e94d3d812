//! Checks and converts values of a source: background, invalid values, planar depth.

use half::f16;

use crate::error::{Error, Result};
use crate::image::{
    AlphaPlane, ColorPlane, DepthPlane, Face, ImageProjection, MaterialPlane, Plane, Transfer, unit_alpha,
};

/// Treatment of depth that is NaN, zero, negative or −inf and is not the background; in encoders, also of surfaces outside a
/// given near and far.
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
    /// Replaces surfaces nearer or farther than the ends that are given: by the end that they lie beyond, or by the background.
    /// Returns their number, 0 where they are to be refused.
    pub fn replace_outside(self, plane: &mut DepthPlane, [near_m, far_m]: [Option<f32>; 2]) -> u64 {
        if self == InvalidDepth::Refuse {
            return 0;
        }
        let (near, far) = (near_m.unwrap_or(0.0), far_m.unwrap_or(f32::INFINITY));
        let mut count = 0;
        for depth in plane.data_mut().iter_mut().filter(|depth| **depth > 0.0 && **depth < f32::INFINITY) {
            if *depth < near || *depth > far {
                count += 1;
                *depth = if self == InvalidDepth::Far { f32::INFINITY } else { depth.max(near).min(far) };
            }
        }
        count
    }

    /// `refuse`, `far` or `near`, as options spell it.
    pub fn name(self) -> &'static str {
        match self {
            InvalidDepth::Refuse => "refuse",
            InvalidDepth::Far => "far",
            InvalidDepth::Near => "near",
        }
    }
}

/// Treatment of colour that is NaN, of alpha beyond 0 to 1, and of material values that are not finite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InvalidColor {
    /// An error that names file and pixel.
    #[default]
    Refuse,
    /// The component becomes 0; alpha above 1 becomes 1.
    Black,
}

impl InvalidColor {
    pub fn name(self) -> &'static str {
        if self == InvalidColor::Refuse { "refuse" } else { "black" }
    }
}

/// No surface is as far, in metres, unless a manifest states so: values such as 1e30 mean that nothing is there.
pub(super) const FARTHEST_M: f64 = 1e10;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRules {
    /// Value in the file that means "nothing there", besides +inf.
    pub background: f32,
    /// Metres per unit; below 0 where values in front of the camera are negative.
    pub scale: f64,
    /// The one value of an image that is as far as this or farther is background where none but +inf is declared.
    pub farthest_m: f64,
    pub invalid: InvalidDepth,
}

impl DepthRules {
    /// Distance in units of the file, above 0 in front of the camera; +inf for the background.
    pub fn units(&self, stored: f32) -> f32 {
        if stored == f32::INFINITY || stored == self.background {
            return f32::INFINITY;
        }
        if self.scale < 0.0 { -stored } else { stored }
    }

    /// What an image has as its background where none but +inf is declared, in units of the file: its farthest value, if no
    /// surface can be as far. +inf where there is none.
    pub fn farthest(&self, plane: &DepthPlane) -> f32 {
        if self.background.is_finite() {
            return f32::INFINITY;
        }
        let finite = plane.data().iter().map(|&stored| self.units(stored)).filter(|units| *units < f32::INFINITY);
        let farthest = finite.fold(0.0, f32::max);
        if self.is_too_far(farthest) { farthest } else { f32::INFINITY }
    }

    fn is_too_far(&self, units: f32) -> bool {
        f64::from(units) * self.scale.abs() >= self.farthest_m
    }
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
    let farthest = rules.farthest(plane);
    for (index, value) in plane.data_mut().iter_mut().enumerate() {
        let units = rules.units(*value);
        *value = if units >= farthest {
            f32::INFINITY
        } else if units > 0.0 && !rules.is_too_far(units) {
            if rules.scale == 1.0 { units } else { metres(units, rules.scale.abs()) }
        } else {
            match rules.invalid {
                InvalidDepth::Far => f32::INFINITY,
                InvalidDepth::Near => 0.0,
                InvalidDepth::Refuse => {
                    let what = invalid_words(*value, units, farthest.min(rules.background));
                    return Err(Error::invalid(format!("depth at {} is {what}", pixel(index, width))));
                }
            }
        };
    }
    Ok(())
}

/// What is wrong with a stored depth, and what to do.
fn invalid_words(stored: f32, units: f32, background: f32) -> String {
    let say = "set `invalid_depth` to far or near";
    if units.is_nan() {
        format!("not a number; {say}, as `background` cannot match it")
    } else if units == 0.0 {
        format!("zero; {say}, or `background` to 0 if it means no surface")
    } else if units > 0.0 {
        format!(
            "{stored:e}, too far for a surface, and not the {background:e} of the background either, as where both were \
             averaged; {say}, or state a depth.far beyond it in the manifest"
        )
    } else if stored < 0.0 {
        format!(
            "negative ({stored}); {say}, or `background` to the value that means no surface; where all surfaces are \
             negative, as in Houdini's Pz, set `depth_scale` or the manifest's depth.scale to -1"
        )
    } else {
        format!("{stored}, on the other side of the camera than `depth_scale`, which is below 0, says; {say}")
    }
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

/// Every value must be within 0 to 1, or becomes the nearest that is, NaN 0.
pub(super) fn check_alpha(plane: &mut AlphaPlane, invalid: InvalidColor) -> Result<()> {
    let width = plane.width();
    for (index, alpha) in plane.data_mut().iter_mut().enumerate() {
        *alpha = match unit_alpha(*alpha) {
            Ok(alpha) => alpha,
            // What is not a number is not above 0.
            Err(_) if invalid == InvalidColor::Black => {
                if *alpha > 0.0 {
                    1.0
                } else {
                    0.0
                }
            }
            Err(words) => {
                let message = format!("{} {words}; set `invalid_color` to black to clamp it", pixel(index, width));
                return Err(Error::invalid(message));
            }
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: DepthRules =
        DepthRules { background: f32::INFINITY, scale: 1.0, farthest_m: FARTHEST_M, invalid: InvalidDepth::Refuse };

    fn checked(values: &[f32], rules: DepthRules) -> Result<Vec<f32>> {
        let mut plane = Plane::new(values.len() as u32, 1, values.to_vec())?;
        check_depth(&mut plane, &rules).map(|()| plane.into_data())
    }

    #[test]
    fn the_one_value_that_no_surface_has_is_background() {
        let inf = f32::INFINITY;
        assert_eq!(checked(&[2.0, 1e30, 1e30, inf], RULES).unwrap(), [2.0, inf, inf, inf]);
        assert_eq!(checked(&[1e30, 1e30], RULES).unwrap(), [inf, inf]);
        assert_eq!(checked(&[200.0, 1e30], DepthRules { scale: 0.01, ..RULES }).unwrap(), [2.0, inf]);
        assert_eq!(checked(&[2.0, 9e9], RULES).unwrap(), [2.0, 9e9]);
        assert_eq!(checked(&[2.0, 1e12], DepthRules { farthest_m: 1e13, ..RULES }).unwrap(), [2.0, 1e12]);
        let said = checked(&[2.0, 3e29, 1e30], RULES).unwrap_err().to_string();
        assert!(said.contains("pixel (1, 0) is 3e29") && said.contains("1e30") && said.contains("depth.far"), "{said}");
        let far = DepthRules { invalid: InvalidDepth::Far, ..RULES };
        assert_eq!(checked(&[2.0, 3e29, 1e30], far).unwrap(), [2.0, inf, inf]);
    }

    #[test]
    fn a_scale_below_zero_turns_the_sign() {
        let inf = f32::INFINITY;
        let houdini = DepthRules { scale: -1.0, background: 0.0, ..RULES };
        assert_eq!(checked(&[-2.0, 0.0, inf, -inf], houdini).unwrap(), [2.0, inf, inf, inf]);
        assert_eq!(checked(&[-2.0, -1e30], DepthRules { scale: -1.0, ..RULES }).unwrap(), [2.0, inf]);
        assert_eq!(checked(&[-200.0], DepthRules { scale: -0.01, ..RULES }).unwrap(), [2.0]);
        let said = checked(&[-2.0, 3.0], houdini).unwrap_err().to_string();
        assert!(said.contains("pixel (1, 0) is 3") && said.contains("below 0"), "{said}");
        let said = checked(&[-2.0], RULES).unwrap_err().to_string();
        assert!(said.contains("Pz") && said.contains("depth.scale to -1"), "{said}");
    }
}
