//! A rendered image, in the forms that files store.
//!
//! Input: linear RGB and alpha. Output: 8-bit Rec. 709 codes with straight alpha, or half floats premultiplied by alpha.

use half::f16;

use codec::error::Result;
use codec::image::plane::ColorPlane;
use codec::image::{CodeSteps, Display, Plane, Primaries};

/// Treatment of surfaces that no source view shows (disocclusions).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum HoleFill {
    /// The surface behind it that source views show, else the colour of [`HoleFill::Nearest`]; alpha is 1.
    #[default]
    Behind,
    /// The colour of the texels with the nearest depth; alpha is 0.
    Nearest,
    /// Blank: colour and alpha are 0.
    Blank,
}

/// Treatment of pixels without a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum BackgroundFill {
    /// The colour of the background; alpha is 1.
    #[default]
    Opaque,
    /// Transparent: alpha is the coverage by surfaces, and colour is that of the surfaces.
    Transparent,
}

#[derive(Debug, Clone, PartialEq)]
pub struct RenderedImage {
    /// Linear RGB, the mean of the samples with a colour in a pixel, not premultiplied by alpha.
    pub color: Plane<[f32; 3]>,
    /// Fraction of a pixel that a source view shows or that [`HoleFill::Behind`] fills. The background is included only with
    /// [`BackgroundFill::Opaque`].
    pub alpha: Plane<f32>,
    /// Primaries of the colour.
    pub primaries: Primaries,
    /// Additional planes of the same size.
    pub aovs: Vec<Aov>,
}

/// An arbitrary output variable: a plane that an image file stores beside its colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Aov {
    /// Channel name.
    pub channel: &'static str,
    pub plane: Plane<f32>,
}

impl RenderedImage {
    /// Creates an image in Rec. 709 primaries.
    pub fn new(color: Plane<[f32; 3]>, alpha: Plane<f32>) -> RenderedImage {
        RenderedImage { color, alpha, primaries: Primaries::REC709, aovs: Vec::new() }
    }

    /// Creates an image with alpha 1 in all pixels.
    pub fn opaque(color: &ColorPlane) -> RenderedImage {
        let alpha = Plane::filled(color.width(), color.height(), 1.0);
        RenderedImage::new(color.map(|light| light.map(f16::to_f32)), alpha)
    }

    /// Creates an image from pixels in row order: linear RGB, then alpha.
    pub fn of_pixels([width, height]: [u32; 2], pixels: impl Iterator<Item = [f32; 4]>) -> Result<RenderedImage> {
        let (color, alpha) = pixels.map(|[r, g, b, alpha]| ([r, g, b], alpha)).unzip();
        Ok(RenderedImage::new(Plane::new(width, height, color)?, Plane::new(width, height, alpha)?))
    }

    /// Converts the image to Rec. 709 primaries.
    #[must_use]
    pub fn into_rec709(mut self) -> RenderedImage {
        if let Some(matrix) = self.primaries.conversion_to(Primaries::REC709) {
            self.color = self.color.map(|&light| matrix.convert(light));
            self.primaries = Primaries::REC709;
        }
        self
    }

    /// Returns 8-bit codes in Rec. 709 primaries.
    pub fn codes(&self, display: impl Into<Display>) -> Plane<[u8; 3]> {
        let steps = CodeSteps::new(display);
        let code = |light: [f32; 3]| light.map(|light| steps.code(light));
        match self.primaries.conversion_to(Primaries::REC709) {
            Some(matrix) => self.color.map(|&light| code(matrix.convert(light))),
            None => self.color.map(|&light| code(light)),
        }
    }

    /// Returns 8-bit codes and alpha; colour is not premultiplied by alpha.
    pub fn rgba_codes(&self, display: impl Into<Display>) -> Plane<[u8; 4]> {
        let codes = self.codes(display);
        Plane::from_fn(codes.width(), codes.height(), |x, y| {
            let [r, g, b] = codes.get(x, y);
            [r, g, b, (self.alpha.get(x, y) * 255.0).round() as u8]
        })
    }

    /// Returns linear RGB premultiplied by alpha, and alpha. With [`HoleFill::Nearest`], colour is kept where alpha is 0.
    pub fn rgba_light(&self, holes: HoleFill) -> Plane<[f16; 4]> {
        Plane::from_fn(self.color.width(), self.color.height(), |x, y| {
            let alpha = self.alpha.get(x, y);
            let factor = if holes == HoleFill::Nearest && alpha == 0.0 { 1.0 } else { alpha };
            let [r, g, b] = self.color.get(x, y).map(|light| finite(light * factor));
            [r, g, b, f16::from_f32(alpha)]
        })
    }
}

/// Converts to the nearest finite half float, and NaN to 0: files hold neither NaN nor infinities.
fn finite(value: f32) -> f16 {
    if value.is_nan() { f16::ZERO } else { f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ToneMap;

    #[test]
    fn holes_are_transparent_and_nothing_is_nan() {
        let rendered = RenderedImage::new(
            Plane::new(3, 1, vec![[1.0, 0.5, 0.0], [1.0; 3], [f32::NAN, f32::INFINITY, -1.0]]).unwrap(),
            Plane::new(3, 1, vec![1.0, 0.0, 0.25]).unwrap(),
        );
        let codes = rendered.rgba_codes(ToneMap::default());
        assert_eq!(codes.data(), [[255, 188, 0, 255], [255, 255, 255, 0], [0, 255, 0, 64]]);
        let blank = rendered.rgba_light(HoleFill::Blank);
        assert_eq!(blank.get(1, 0).map(f16::to_f32), [0.0; 4]);
        assert_eq!(blank.get(2, 0).map(f16::to_f32), [0.0, f16::MAX.to_f32(), -0.25, 0.25]);
        let filled = rendered.rgba_light(HoleFill::Nearest);
        assert_eq!(filled.get(1, 0).map(f16::to_f32), [1.0, 1.0, 1.0, 0.0]);
    }
}
