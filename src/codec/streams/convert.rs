//! Conversion between values and codes: metres and depth codes, linear colour and 8 bits, material weights and bytes, alpha
//! and 8 bits.

use crate::depth::Quantiser;
use crate::depth::quantise::metres_in_words;
use crate::error::{Error, Result};
use crate::image::plane::{AlphaPlane, ColorPlane, DepthPlane, MaterialPlane, Plane, unit_alpha};
use crate::image::transfer::{DecodeTable, EncodeTable};

/// Range of the 8-bit index of refraction (CALF 7.1).
pub const IOR_RANGE: [f32; 2] = [1.0, 3.0];

/// Returns the codes of all pixels. `expected` completes the error message for the first pixel without a code.
fn codes<S: Copy, C: Default + Clone>(
    plane: &Plane<S>,
    code: impl Fn(S) -> Option<C>,
    expected: impl Fn(S) -> String,
) -> Result<Plane<C>> {
    let mut outside = None;
    let codes = plane.data().iter().enumerate().map(|(at, &value)| {
        code(value).unwrap_or_else(|| {
            outside.get_or_insert((at, value));
            C::default()
        })
    });
    let codes = codes.collect();
    if let Some((at, value)) = outside {
        let (x, y) = (at % plane.width() as usize, at / plane.width() as usize);
        return Err(Error::invalid(format!("pixel ({x}, {y}) {}", expected(value))));
    }
    Plane::new(plane.width(), plane.height(), codes)
}

pub fn depth_codes(plane: &DepthPlane, quantiser: &Quantiser) -> Result<Plane<u16>> {
    let range = quantiser.range;
    codes(
        plane,
        |z| quantiser.code(z),
        |z| {
            let z = metres_in_words(z);
            format!(
                "lies at {z} m, outside the range of {range}: widen `near` and `far`, leave them to be found, or set `invalid_depth` \
                 to near or far; scan again where images have changed since the scan"
            )
        },
    )
}

/// Returns 8-bit colour, and the number of clipped pixels.
pub fn color_codes(plane: &ColorPlane, table: &EncodeTable) -> (Plane<[u8; 3]>, u64) {
    let mut clipped = 0;
    let codes = plane.map(|pixel| {
        clipped += u64::from(pixel.iter().any(|&value| table.is_clipped(value)));
        pixel.map(|value| table.code(value))
    });
    (codes, clipped)
}

pub fn color_light(codes: &Plane<[u8; 3]>, table: &DecodeTable) -> ColorPlane {
    codes.map(|pixel| pixel.map(|code| table.value(code)))
}

pub fn material_codes(plane: &MaterialPlane) -> Result<Plane<[u8; 3]>> {
    let [low, high] = IOR_RANGE;
    let code = |[reflect, refract, ior]: [f32; 3]| {
        let unit = [reflect, refract, (ior - low) / (high - low)];
        // Half floats slightly outside the range are clamped to its end.
        let fits = unit.iter().all(|value| (-0.002..=1.002).contains(value));
        fits.then(|| unit.map(|value| (value * 255.0).round() as u8))
    };
    codes(plane, code, |[reflect, refract, ior]| {
        format!(
            "has material weights {reflect} and {refract} and index {ior}: weights of 0 to 1 and an index of {low} to \
             {high} were expected"
        )
    })
}

pub fn material_value(&[reflect, refract, ior]: &[u8; 3]) -> [f32; 3] {
    let [low, high] = IOR_RANGE;
    let unit = |code: u8| f32::from(code) / 255.0;
    [unit(reflect), unit(refract), low + unit(ior) * (high - low)]
}

pub fn material_values(codes: &Plane<[u8; 3]>) -> MaterialPlane {
    codes.map(material_value)
}

/// Returns codes of 0 to 255.
pub fn alpha_codes(plane: &AlphaPlane) -> Result<Plane<u16>> {
    let code = |alpha| unit_alpha(alpha).ok().map(|alpha| u16::from((alpha * 255.0).round() as u8));
    codes(plane, code, |alpha| unit_alpha(alpha).err().unwrap_or_default())
}

/// Returns the alpha of a decoded code; 1 for codes above 255, which no encoder writes.
pub fn alpha_value(code: u16) -> f32 {
    f32::from(alpha_byte(code)) / 255.0
}

/// Clamps the code to 8 bits.
pub fn alpha_byte(code: u16) -> u8 {
    code.min(255) as u8
}

/// Distances of the nearest and the farthest surface of one or more images, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize))]
pub struct DepthExtent {
    pub near_m: f32,
    pub far_m: f32,
}

impl DepthExtent {
    /// Returns the extent of an image; `None` without surfaces. A depth of 0 is invalid and no surface.
    pub fn of(plane: &DepthPlane) -> Option<DepthExtent> {
        let (mut near_m, mut far_m) = (f32::INFINITY, 0.0f32);
        for &z in plane.data() {
            let surface = z > 0.0 && z < f32::INFINITY;
            near_m = if surface && z < near_m { z } else { near_m };
            far_m = if surface && z > far_m { z } else { far_m };
        }
        (near_m <= far_m).then_some(DepthExtent { near_m, far_m })
    }

    #[must_use]
    pub fn union(self, other: DepthExtent) -> DepthExtent {
        DepthExtent { near_m: self.near_m.min(other.near_m), far_m: self.far_m.max(other.far_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn material_round_trips_to_half_a_step_and_refuses_what_does_not_fit() {
        let plane = Plane::from_fn(4, 1, |x, _| [x as f32 / 3.0, 1.0 - x as f32 / 3.0, 1.0 + x as f32 / 2.0]);
        let back = material_values(&material_codes(&plane).unwrap());
        for (a, b) in plane.data().iter().flatten().zip(back.data().iter().flatten()) {
            assert!((a - b).abs() <= 1.0 / 255.0 + 1e-6);
        }
        for bad in [[2.0, 0.0, 1.0], [0.0, -1.0, 1.0], [0.0, 0.0, 0.0], [f32::NAN, 0.0, 1.0], [0.0, 0.0, f32::INFINITY]]
        {
            let message = material_codes(&Plane::filled(1, 1, bad)).unwrap_err().to_string();
            assert!(message.contains("pixel (0, 0)"), "{message}");
        }
    }
}
