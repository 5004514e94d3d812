//! Checks and converts values of a source: background, invalid values, planar depth.

use half::f16;

use codec::error::{Error, Result};
use codec::image::{
    AlphaPlane, ColorPlane, DepthPlane, Face, ImageProjection, MaterialPlane, Plane, Transfer, unit_alpha,
};

/// Treatment of depth that is NaN, zero, negative or −inf and is not the background; in encoders, also of surfaces outside a
/// given near and far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InvalidDepth {
    /// Fails with an error that names the file and the pixel.
    #[default]
    Refuse,
    /// The pixel becomes background, +inf.
    Far,
    /// The pixel becomes 0.0, which encoders store as code 0, the near plane of the probe.
    Near,
}

impl InvalidDepth {
    /// Replaces surfaces outside the given near and far: by the nearest given bound for `Near`, by the background for `Far`.
    /// Returns the number of replaced pixels, 0 for `Refuse`, which changes nothing.
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

    /// Returns `refuse`, `far` or `near`, as in options.
    pub fn name(self) -> &'static str {
        match self {
            InvalidDepth::Refuse => "refuse",
            InvalidDepth::Far => "far",
            InvalidDepth::Near => "near",
        }
    }
}

/// Treatment of NaN in colour, of alpha outside 0 to 1, and of material values that are not finite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InvalidColor {
    /// Fails with an error that names the file and the pixel.
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

/// Default of [`DepthRules::farthest_m`]: no surface is this far, so values such as 1e30 mark the background. A larger `far` in a
/// manifest replaces it.
pub(super) const FARTHEST_M: f64 = 1e10;

/// Conversion of disparity to metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Disparity {
    /// Metres times the unit of the files; 0 is the background.
    Scale(f64),
    /// Nearest and farthest distance in metres, stored as 1 (the largest code) and 0; values between are linear in 1/m.
    Range([f64; 2]),
}

impl Disparity {
    /// Returns the distance in metres of a stored value, where `largest` is the largest code, 1 for floats. +inf for a value of 0
    /// that is infinitely far, NaN for values below 0.
    fn metres(self, stored: f32, largest: f64) -> f64 {
        let inverse = match self {
            Disparity::Scale(scale) => f64::from(stored) / scale,
            Disparity::Range([near, far]) => far.recip() + f64::from(stored) / largest * (near.recip() - far.recip()),
        };
        if inverse >= 0.0 { inverse.recip() } else { f64::NAN }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRules {
    /// Background value of the file, in addition to +inf.
    pub background: f32,
    /// Metres per unit; negative if values in front of the camera are negative.
    pub scale: f64,
    /// Conversion of files with disparity; `scale` is then 1.
    pub disparity: Option<Disparity>,
    /// Largest code of integer files, 1 for floats.
    pub largest: f64,
    /// Distance in metres from which a value is too far for a surface. If only +inf is declared as background, the largest finite
    /// value of an image is also background if it is at least this far.
    pub farthest_m: f64,
    pub invalid: InvalidDepth,
}

impl Default for DepthRules {
    /// Rules of float files in metres.
    fn default() -> Self {
        DepthRules {
            background: f32::INFINITY,
            scale: 1.0,
            disparity: None,
            largest: 1.0,
            farthest_m: FARTHEST_M,
            invalid: InvalidDepth::default(),
        }
    }
}

impl DepthRules {
    /// Returns the distance in units of the file, positive in front of the camera; +inf for the background.
    pub fn units(&self, stored: f32) -> f32 {
        if stored == f32::INFINITY || stored == self.background {
            return f32::INFINITY;
        }
        match self.disparity {
            None if self.scale < 0.0 => -stored,
            None => stored,
            Some(disparity) => match disparity.metres(stored, self.largest) {
                metres if metres >= self.farthest_m => f32::INFINITY,
                metres => metres as f32,
            },
        }
    }

    /// Returns the undeclared background value of an image, in units of the file: its largest finite value, if only +inf is
    /// declared and no surface can be that far. Returns +inf if there is none.
    pub fn farthest(&self, plane: &DepthPlane) -> f32 {
        if self.background.is_finite() || self.disparity.is_some() {
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

/// Multiplies a positive depth by a factor and clamps to positive finite floats, because +inf and 0 are reserved.
fn metres(value: f32, factor: f64) -> f32 {
    let product = (f64::from(value) * factor) as f32;
    product.clamp(f32::from_bits(1), f32::MAX)
}

/// Applies the rules to a plane. Values become +inf for the background, 0.0 for invalid depth with [`InvalidDepth::Near`], else
/// finite and positive metres.
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

/// Describes why a stored depth is invalid, and how to fix it.
fn invalid_words(stored: f32, units: f32, background: f32) -> String {
    let say = "set `invalid_depth` to far or near";
    if units.is_nan() && stored < 0.0 {
        format!("a disparity below 0 ({stored}); {say}, or `background` to the value that means no surface")
    } else if units.is_nan() {
        format!("not a number; {say}, as `background` cannot match it")
    } else if units == 0.0 {
        format!("zero; {say}, or `background` to 0 if it means no surface")
    } else if units > 0.0 {
        format!(
            "{stored:e}, too far for a surface but different from the background {background:e}, as if both were \
            averaged; {say}, or set a larger depth.far in the manifest"
        )
    } else if stored < 0.0 {
        format!(
            "negative ({stored}); {say}, or `background` to the value that means no surface; where all surfaces are \
             negative, as in Houdini's Pz, set `depth_scale` or the manifest's depth.scale to -1"
        )
    } else {
        format!("positive ({stored}), although `depth_scale` is negative; {say}")
    }
}

/// Converts planar depth to distance from the centre; +inf and 0.0 are unchanged.
pub fn planar_to_distance(plane: &mut DepthPlane, projection: &ImageProjection) {
    for row in 0..plane.height() {
        for (col, value) in plane.row_mut(row).iter_mut().enumerate() {
            if *value > 0.0 && *value < f32::INFINITY {
                *value = metres(*value, projection.ray_length_factor(col as u32, row));
            }
        }
    }
}

/// Clamps infinities to the largest finite half; NaN becomes 0 or is an error.
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

/// Checks that every value is finite; others become 0 or are an error.
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

/// Checks that every value is within 0 to 1; others are clamped, NaN to 0, or are an error.
pub(super) fn check_alpha(plane: &mut AlphaPlane, invalid: InvalidColor) -> Result<()> {
    let width = plane.width();
    for (index, alpha) in plane.data_mut().iter_mut().enumerate() {
        *alpha = match unit_alpha(*alpha) {
            Ok(alpha) => alpha,
            // NaN compares false and becomes 0.
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

/// Converts sRGB values, 1.0 for white, to linear.
pub(super) fn linear_from_srgb(plane: &mut ColorPlane) {
    for component in plane.data_mut().as_flattened_mut() {
        *component = f16::from_f64(Transfer::Srgb.decode(component.to_f64()));
    }
}

/// Fails if an image has another size than the given width and height.
pub(super) fn check_plane<T>(plane: &Plane<T>, (width, height): (u32, u32)) -> Result<()> {
    if (plane.width(), plane.height()) == (width, height) {
        return Ok(());
    }
    let found = format!("{}x{}", plane.width(), plane.height());
    Err(Error::invalid(format!("the image is {found} pixels, expected {width}x{height}")))
}

/// Resamples an image to another size by nearest neighbour: each pixel is the one that contains its centre.
pub(super) fn resized<T: Copy>(plane: &Plane<T>, (width, height): (u32, u32)) -> Plane<T> {
    let place = |at: u32, size: u32, own: u32| {
        let at = (2 * u64::from(at) + 1) * u64::from(own) / (2 * u64::from(size));
        at as u32
    };
    let (wide, high) = (plane.width(), plane.height());
    Plane::from_fn(width, height, |x, y| plane.get(place(x, width, wide), place(y, height, high)))
}

/// Selects the planes of the `wanted` faces; `all` has all six faces in cube order.
pub(super) fn keep_faces<T>(all: Vec<Plane<T>>, wanted: &[Face]) -> Vec<Plane<T>> {
    Face::CUBE.into_iter().zip(all).filter(|(face, _)| wanted.contains(face)).map(|(_, plane)| plane).collect()
}

/// Returns the face of an OpenGL cube map that a camera saw: a side left to right, top and bottom upside down.
pub(super) fn from_camera<T: Copy>(seen: &Plane<T>, face: Face) -> Plane<T> {
    let (right, bottom) = (seen.width().saturating_sub(1), seen.height().saturating_sub(1));
    let is_side = !matches!(face, Face::Py | Face::Ny);
    Plane::from_fn(
        seen.width(),
        seen.height(),
        |x, y| {
            if is_side { seen.get(right - x, y) } else { seen.get(x, bottom - y) }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(values: &[f32], rules: DepthRules) -> Result<Vec<f32>> {
        let mut plane = Plane::new(values.len() as u32, 1, values.to_vec())?;
        check_depth(&mut plane, &rules).map(|()| plane.into_data())
    }

    #[test]
    fn the_one_value_that_no_surface_has_is_background() {
        let inf = f32::INFINITY;
        assert_eq!(checked(&[2.0, 1e30, 1e30, inf], DepthRules::default()).unwrap(), [2.0, inf, inf, inf]);
        assert_eq!(checked(&[1e30, 1e30], DepthRules::default()).unwrap(), [inf, inf]);
        assert_eq!(checked(&[200.0, 1e30], DepthRules { scale: 0.01, ..DepthRules::default() }).unwrap(), [2.0, inf]);
        assert_eq!(checked(&[2.0, 9e9], DepthRules::default()).unwrap(), [2.0, 9e9]);
        assert_eq!(
            checked(&[2.0, 1e12], DepthRules { farthest_m: 1e13, ..DepthRules::default() }).unwrap(),
            [2.0, 1e12]
        );
        let said = checked(&[2.0, 3e29, 1e30], DepthRules::default()).unwrap_err().to_string();
        assert!(said.contains("pixel (1, 0) is 3e29") && said.contains("1e30") && said.contains("depth.far"), "{said}");
        let far = DepthRules { invalid: InvalidDepth::Far, ..DepthRules::default() };
        assert_eq!(checked(&[2.0, 3e29, 1e30], far).unwrap(), [2.0, inf, inf]);
    }

    #[test]
    fn disparity_becomes_metres() {
        let inf = f32::INFINITY;
        let stereo = DepthRules { disparity: Some(Disparity::Scale(60.0)), ..DepthRules::default() };
        assert_eq!(checked(&[30.0, 120.0, 0.0, 1e-12, inf], stereo).unwrap(), [2.0, 0.5, inf, inf, inf]);
        let said = checked(&[30.0, -1.0], stereo).unwrap_err().to_string();
        assert!(said.contains("pixel (1, 0) is a disparity below 0 (-1)"), "{said}");
        assert_eq!(checked(&[-1.0], DepthRules { background: -1.0, ..stereo }).unwrap(), [inf]);
        let codes =
            DepthRules { disparity: Some(Disparity::Range([0.5, 10.0])), largest: 65535.0, ..DepthRules::default() };
        let found = checked(&[0.0, 65535.0, 32767.5], codes).unwrap();
        assert_eq!((found[0], found[1]), (10.0, 0.5));
        // The middle code has the mean of both inverses.
        assert!((found[2].recip() - 1.05).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_scale_below_zero_turns_the_sign() {
        let inf = f32::INFINITY;
        let houdini = DepthRules { scale: -1.0, background: 0.0, ..DepthRules::default() };
        assert_eq!(checked(&[-2.0, 0.0, inf, -inf], houdini).unwrap(), [2.0, inf, inf, inf]);
        assert_eq!(checked(&[-2.0, -1e30], DepthRules { scale: -1.0, ..DepthRules::default() }).unwrap(), [2.0, inf]);
        assert_eq!(checked(&[-200.0], DepthRules { scale: -0.01, ..DepthRules::default() }).unwrap(), [2.0]);
        let said = checked(&[-2.0, 3.0], houdini).unwrap_err().to_string();
        assert!(said.contains("pixel (1, 0) is positive (3)") && said.contains("negative"), "{said}");
        let said = checked(&[-2.0], DepthRules::default()).unwrap_err().to_string();
        assert!(said.contains("Pz") && said.contains("depth.scale to -1"), "{said}");
    }

    #[test]
    fn resized_images_take_the_pixel_at_the_centre_of_each() {
        let plane = Plane::from_fn(2, 1, |x, _| x);
        let wide: Vec<u32> = resized(&plane, (4, 2)).data().to_vec();
        assert_eq!(wide, [0, 0, 1, 1, 0, 0, 1, 1]);
        let small = resized(&Plane::from_fn(4, 3, |x, y| 10 * y + x), (2, 1));
        assert_eq!(small.data(), [11, 13]);
    }
}
