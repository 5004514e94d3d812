//! Probe views from images in metres and linear RGB, without encoding.

use half::f16;

use crate::views::{BACKGROUND, ColorCoding, ColorTexels, FaceTexels, View, straight, straight_half};
use codec::container::ProbeEntry;
use codec::depth::DepthRange;
use codec::error::Result;
use codec::image::{AlphaPlane, ColorPlane, DepthKind, DepthPlane, Face, MaterialPlane, TexelMap};
use codec::streams::convert::material_codes;

/// Images of a face; all have the same size.
#[derive(Debug, Clone)]
pub struct FaceImages {
    pub face: Face,
    /// Linear RGB, multiplied by alpha if there is alpha.
    pub color: ColorPlane,
    /// Alpha, 0 to 1; none if all pixels are opaque.
    pub alpha: Option<AlphaPlane>,
    /// Metres; +inf for background.
    pub depth: DepthPlane,
    pub kind: DepthKind,
    /// Weights of reflection and refraction, and index of refraction.
    pub material: Option<MaterialPlane>,
}

impl FaceImages {
    fn texels(&self, entry: &ProbeEntry, coding: ColorCoding) -> Result<FaceTexels> {
        let size = [self.color.width(), self.color.height()];
        let mut texels = FaceTexels::unknown(size, TexelMap::of_face(self.face, size, entry.intrinsics), coding);
        for (at, &metres) in (0u32..).zip(self.depth.data()) {
            let inverse = match self.kind {
                DepthKind::Planar => 1.0 / metres,
                DepthKind::Distance => 1.0 / metres * texels.map.ray_length_factor(at % size[0], at / size[0]),
            };
            texels.inverse_depth[at as usize] = BACKGROUND.max(inverse);
        }
        let alpha = |at: usize| match &self.alpha {
            Some(alpha) if alpha.data()[at] > 0.0 => alpha.data()[at].min(1.0),
            Some(_) => 0.0,
            None => 1.0,
        };
        let color = self.color.data().iter().enumerate().map(|(at, &color)| (color, alpha(at)));
        let has_alpha = self.alpha.is_some();
        let fourth = |alpha: f32| if has_alpha { alpha } else { 0.0 };
        texels.has_alpha = has_alpha;
        texels.color = match coding {
            ColorCoding::Codes(tone) => {
                let texel = |(color, alpha): ([f16; 3], f32)| {
                    let [r, g, b] = color.map(|light| tone.code(straight(light.to_f32(), alpha)));
                    [r, g, b, (255.0 * fourth(alpha)).round() as u8]
                };
                ColorTexels::Codes(color.map(texel).collect())
            }
            ColorCoding::Light => {
                let texel = |(color, alpha): ([f16; 3], f32)| {
                    let [r, g, b] = color.map(|light| straight_half(light, alpha));
                    [r, g, b, f16::from_f32(fourth(alpha))]
                };
                ColorTexels::Light(color.map(texel).collect())
            }
        };
        if let Some(material) = &self.material {
            let codes = material_codes(material)?;
            texels.material = Some(codes.data().iter().map(|&[a, b, c]| [a, b, c, 0]).collect());
            texels.update_specular();
        }
        Ok(texels)
    }
}

/// Creates the view of a probe; near and far are those of its images.
pub fn from_images(probe: usize, entry: &ProbeEntry, images: &[FaceImages], coding: ColorCoding) -> Result<View> {
    let finite = images.iter().flat_map(|image| image.depth.data()).filter(|metres| metres.is_finite());
    let (near, far) = finite.fold((f32::INFINITY, 0f32), |(near, far), &m| (near.min(m), far.max(m)));
    let range = if near < far { DepthRange::new(near, far)? } else { DepthRange::empty() };
    let mut view = View::new(probe, entry, range)?;
    for image in images {
        view.faces[image.face as usize] = Some(image.texels(entry, coding)?);
    }
    Ok(view)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ToneMap;

    #[test]
    fn colours_are_divided_by_their_alpha() {
        let alphas = [1.0, 0.5, 0.0, f32::NAN];
        let images = FaceImages {
            face: Face::Nz,
            color: ColorPlane::from_fn(2, 2, |x, y| [f16::from_f32(0.4 * alphas[(x + 2 * y) as usize].max(0.0)); 3]),
            alpha: Some(AlphaPlane::from_fn(2, 2, |x, y| alphas[(x + 2 * y) as usize])),
            depth: DepthPlane::filled(2, 2, 2.0),
            kind: DepthKind::Planar,
            material: None,
        };
        let entry = ProbeEntry {
            name: "a".into(),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [0, 0],
            intrinsics: [0.0; 4],
        };
        let tone = ToneMap::default();
        let texels = |alpha: bool, coding| {
            let images = FaceImages { alpha: images.alpha.clone().filter(|_| alpha), ..images.clone() };
            images.texels(&entry, coding).unwrap()
        };
        let codes = texels(true, ColorCoding::Codes(tone));
        let found: Vec<[f32; 2]> = (0..4).map(|at| [codes.color.get(at).x * 255.0, codes.alpha(at) * 255.0]).collect();
        let code = f32::from(tone.code(0.4));
        assert_eq!(found, [[code, 255.0], [code, 128.0], [0.0, 0.0], [0.0, 0.0]]);
        let light = texels(true, ColorCoding::Light);
        assert!((0..2).all(|at| (light.color.get(at).y - 0.4).abs() < 2e-4 && light.alpha(at) == alphas[at]));
        let opaque = texels(false, ColorCoding::Codes(tone));
        assert!((0..4).all(|at| opaque.alpha(at) == 1.0) && !opaque.has_alpha);
    }
}
