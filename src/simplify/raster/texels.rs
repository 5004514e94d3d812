//! Bilinear sampling of an atlas in linear RGB.

use glam::Vec4;
use half::f16;

use crate::quad_mesh::QuadMesh;
use codec::image::Transfer;
use scene::mesh::ImageTexture;

/// An atlas, and the linear RGB of its codes.
pub struct Texels<'a> {
    texture: &'a ImageTexture,
    /// Linear RGB that replaces the codes.
    light: Option<&'a [[f16; 3]]>,
    of_codes: [f32; 256],
    alpha: [f32; 256],
}

impl<'a> Texels<'a> {
    pub fn new(scene: &'a QuadMesh) -> Texels<'a> {
        Texels {
            texture: &scene.texture,
            light: scene.light.as_deref(),
            of_codes: light_of_codes(),
            alpha: std::array::from_fn(|code| code as f32 / 255.0),
        }
    }

    /// Returns linear RGB, not multiplied by alpha, and alpha. (0, 0) is the top left corner; coordinates are clamped.
    pub fn sample(&self, at: [f64; 2]) -> Vec4 {
        let ([a, b, c, d], [along, down]) = self.around(at);
        let (above, below) = (self.texel(a).lerp(self.texel(b), along), self.texel(c).lerp(self.texel(d), along));
        above.lerp(below, down)
    }

    #[inline(always)]
    fn texel(&self, at: usize) -> Vec4 {
        let [r, g, b, alpha] = self.texture.pixels[at];
        let [r, g, b] = match self.light {
            Some(light) => light[at].map(f16::to_f32),
            None => [r, g, b].map(|code| self.of_codes[usize::from(code)]),
        };
        Vec4::new(r, g, b, self.alpha[usize::from(alpha)])
    }

    /// Returns the alpha of [`Self::sample`].
    pub fn alpha(&self, at: [f64; 2]) -> f32 {
        let (texels, [along, down]) = self.around(at);
        let [a, b, c, d] = texels.map(|at| self.alpha[usize::from(self.texture.pixels[at][3])]);
        let between = |from: f32, to: f32, part: f32| from * (1.0 - part) + to * part;
        between(between(a, b, along), between(c, d, along), down)
    }

    /// Returns the four texels around a position, in row-major order, and the weights of the second column and of the second row.
    fn around(&self, [u, v]: [f64; 2]) -> ([usize; 4], [f32; 2]) {
        let (left, along) = place(u, self.texture.width);
        let (top, down) = place(v, self.texture.height);
        let width = self.texture.width as usize;
        let right = usize::from(left + 1 < width);
        let below = if top + 1 < self.texture.height as usize { width } else { 0 };
        let first = top * width + left;
        ([first, first + right, first + below, first + below + right], [along, down])
    }
}

/// Returns the linear value of each sRGB code.
pub fn light_of_codes() -> [f32; 256] {
    std::array::from_fn(|code| Transfer::Srgb.decode(code as f64 / 255.0) as f32)
}

/// Returns the texel before a coordinate, and the weight of the next texel.
fn place(at: f64, side: u32) -> (usize, f32) {
    // In this order of operations, NaN becomes 0.
    let at = (at * f64::from(side) - 0.5).max(0.0).min(f64::from(side - 1)) as f32;
    let first = at as usize;
    (first, at - first as f32)
}

/// Returns the homogeneous texture coordinates of a corner.
pub fn texture_coordinates(scene: &QuadMesh, corner: u32) -> [f64; 3] {
    match scene.stq.get(corner as usize) {
        Some(stq) => stq.as_dvec3().to_array(),
        None => scene.mesh.uvs[corner as usize].as_dvec2().extend(1.0).to_array(),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use scene::mesh::{Mesh, Wrap};

    #[test]
    fn texels_are_met_at_their_centres_and_mixed_as_light_between() {
        let pixels = vec![[0, 0, 0, 0], [255, 255, 255, 255], [255, 0, 0, 255], [0, 0, 255, 51]];
        let texture = ImageTexture { width: 2, height: 2, pixels, wrap: [Wrap::Clamp; 2] };
        let texture = Arc::new(texture);
        let scene = QuadMesh { mesh: Mesh::default(), texture, stq: Vec::new(), light: None, runs: Vec::new() };
        let texels = Texels::new(&scene);
        assert_eq!(texels.sample([0.25, 0.25]), Vec4::ZERO);
        assert_eq!(texels.sample([0.75, 0.25]), Vec4::ONE);
        assert_eq!(texels.sample([0.5, 0.25]), Vec4::splat(0.5));
        assert_eq!(texels.sample([-3.0, 0.75]), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(texels.sample([9.0, 9.0]), Vec4::new(0.0, 0.0, 1.0, 0.2));
        for step in 0..100 {
            let at = [0.07 * f64::from(step % 17), 0.11 * f64::from(step % 13)];
            assert_eq!(texels.alpha(at), texels.sample(at).w, "{at:?}");
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
            let found = texels.sample([bad, bad]);
            assert!(found.is_finite() && texels.alpha([bad, bad]).is_finite(), "{bad}: {found}");
        }
    }
}
