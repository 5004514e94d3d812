//! What a renderer holds of a light field: for each probe the texels of one frame (CALF 6, algorithm 4, C, D, M and P).
//!
//! Enters: pictures as decoders show them, in whole or in rectangles. Leaves: texels that a ray can be compared with at
//! the cost of a multiplication: depth becomes the inverse of planar depth, in which planes are linear, a background is
//! 0, and what is not known is +inf.

use glam::{DMat3, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use crate::container::index::ProbeEntry;
use crate::dataset::stream::DepthKind;
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::transfer::ToneMap;
use crate::math::camera::rotation;

/// The inverse planar depth of a background: no surface at any distance.
pub const BACKGROUND: f32 = 0.0;
/// The inverse planar depth of a texel of which nothing is known, because it was not captured or not decoded.
pub const UNKNOWN: f32 = f32::INFINITY;

/// What colours are coded in, and so what views are interpolated in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorCoding {
    /// 8-bit codes behind a transfer curve and an exposure.
    Codes(ToneMap),
    /// Linear light as half floats.
    Light,
}

impl ColorCoding {
    /// The transfer from light to 8-bit codes: the container's own, or sRGB where it holds light.
    pub fn tone(self) -> ToneMap {
        match self {
            ColorCoding::Codes(tone) => tone,
            ColorCoding::Light => ToneMap::default(),
        }
    }
}

/// The colours of a face.
#[derive(Debug, Clone, PartialEq)]
pub enum ColorTexels {
    /// 8-bit codes; the fourth byte is 0.
    Codes(Vec<[u8; 4]>),
    /// Linear light; the fourth half is 0.
    Light(Vec<[f16; 4]>),
}

impl ColorTexels {
    /// A texel: codes over 255, or light.
    pub fn get(&self, at: usize) -> Vec3 {
        match self {
            ColorTexels::Codes(texels) => {
                let [r, g, b, _] = texels[at];
                Vec3::new(r.into(), g.into(), b.into()) / 255.0
            }
            ColorTexels::Light(texels) => {
                let [r, g, b, _] = texels[at];
                Vec3::new(r.to_f32(), g.to_f32(), b.to_f32())
            }
        }
    }
}

/// The texels of one image of a probe, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceTexels {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Column and row of the direction `forward + u·right + v·down` are `[u, v] · scale + centre`; texel (0, 0) is from 0 to 1.
    pub scale: [f32; 2],
    /// See `scale`.
    pub centre: [f32; 2],
    /// Inverse planar depth in 1/m; [`BACKGROUND`], or [`UNKNOWN`].
    pub inverse_depth: Vec<f32>,
    /// Colour.
    pub color: ColorTexels,
    /// Weights of reflection and refraction, and the index of refraction, as `streams::convert` codes them; the fourth
    /// byte is 0. None where the container has no material of this face.
    pub material: Option<Vec<[u8; 4]>>,
    /// Whether a weight of its material is above 0; [`FaceTexels::material_changed`] keeps it true to `material`.
    pub calls_for_effects: bool,
}

impl FaceTexels {
    /// A face of `size` texels of which nothing is known, without materials.
    pub fn unknown(size: [u32; 2], map: [[f32; 2]; 2], coding: ColorCoding) -> FaceTexels {
        let texels = size[0] as usize * size[1] as usize;
        FaceTexels {
            size,
            scale: map[0],
            centre: map[1],
            inverse_depth: vec![UNKNOWN; texels],
            color: match coding {
                ColorCoding::Codes(_) => ColorTexels::Codes(vec![[0; 4]; texels]),
                ColorCoding::Light => ColorTexels::Light(vec![[f16::ZERO; 4]; texels]),
            },
            material: None,
            calls_for_effects: false,
        }
    }

    /// A face whose depths and colours lie on a device, and nowhere else ([`crate::views::units_on_device`]).
    pub fn on_device(size: [u32; 2], map: [[f32; 2]; 2], coding: ColorCoding) -> FaceTexels {
        let nothing = FaceTexels::unknown([0; 2], map, coding);
        FaceTexels { size, ..nothing }
    }

    /// Whether depths and colours lie on a device.
    pub fn is_on_device(&self) -> bool {
        self.inverse_depth.is_empty() && self.size != [0; 2]
    }

    /// The same face with materials, whose weights are all 0.
    #[must_use]
    pub fn with_material(self) -> FaceTexels {
        let texels = self.size[0] as usize * self.size[1] as usize;
        FaceTexels { material: Some(vec![[0; 4]; texels]), ..self }
    }

    /// Takes in that materials were written. Looks at all texels.
    pub fn material_changed(&mut self) {
        self.calls_for_effects = self.material.as_ref().is_some_and(|texels| texels.iter().any(sends_on));
    }

    /// √(1 + u² + v²) at the centre of a texel: how much farther its surface is than its planar depth.
    pub fn stretch(&self, column: u32, row: u32) -> f32 {
        let [u, v] = self.plane([column, row].map(|at| at as f32 + 0.5));
        (1.0 + u * u + v * v).sqrt()
    }

    /// u and v of a place, column and row in texels from the upper left corner: see `scale`.
    pub fn plane(&self, at: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|axis| (at[axis] - self.centre[axis]) / self.scale[axis])
    }

    /// The way to such a place in the axes of the probe, if this is the image of a face: its planar depth is 1.
    pub fn way(&self, face: Face, at: [f32; 2]) -> Vec3 {
        let [forward, right, down] = face.axes().map(|axis| axis.as_vec3());
        let [u, v] = self.plane(at);
        forward + u * right + v * down
    }
}

/// Whether a weight of a material, as it is coded, is above 0: reflection is the first, refraction the second.
pub(crate) fn sends_on<const N: usize>(material: &[u8; N]) -> bool {
    material.iter().take(2).any(|&weight| weight > 0)
}

/// Where a point lies in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Number of the face ([`Face`]).
    pub face: usize,
    /// Column and row, in texels from the upper left corner of the image.
    pub at: [f32; 2],
    /// Inverse of the planar depth of the point, in 1/m; above 0.
    pub inverse_depth: f32,
}

/// One probe.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Its name.
    pub name: String,
    /// Its index in the container's table of probes.
    pub probe: usize,
    /// Where it stands, in metres.
    pub position: DVec3,
    /// Turns directions of the world into those of its faces.
    pub probe_from_world: DMat3,
    /// No surface of it is nearer, in metres of distance.
    pub near_m: f32,
    /// No surface of it has a greater planar depth or distance, in metres.
    pub far_m: f32,
    /// Its images by the number of their face ([`Face`]); a cube map has up to six, a perspective probe the last.
    pub faces: [Option<FaceTexels>; 7],
}

impl View {
    /// A probe without images.
    ///
    /// # Errors
    /// When its orientation is no rotation.
    pub fn new(probe: usize, entry: &ProbeEntry, range: DepthRange) -> Result<View> {
        let turn = rotation(entry.orientation)
            .ok_or_else(|| Error::invalid(format!("probe {}: its orientation is no rotation", entry.name)))?;
        Ok(View {
            name: entry.name.clone(),
            probe,
            position: DVec3::from_array(entry.position),
            probe_from_world: DMat3::from_quat(turn.inverse()),
            near_m: range.near_m(),
            far_m: range.far_m(),
            faces: Default::default(),
        })
    }

    /// Whether it has a stream of materials.
    pub fn has_material(&self) -> bool {
        self.faces.iter().flatten().any(|face| face.material.is_some())
    }

    /// Whether a weight of its materials is above 0.
    pub fn calls_for_effects(&self) -> bool {
        self.faces.iter().flatten().any(|face| face.calls_for_effects)
    }

    /// Scale and centre of an image of `size` texels ([`FaceTexels::scale`]).
    pub fn image_map(entry: &ProbeEntry, face: Face, size: [u32; 2]) -> [[f32; 2]; 2] {
        if face == Face::View {
            let [fx, fy, cx, cy] = entry.intrinsics.map(|value| value as f32);
            [[fx, fy], [cx, cy]]
        } else {
            let half = size.map(|pixels| pixels as f32 / 2.0);
            [half, half]
        }
    }

    /// Where a point lies in the images of this probe; `from_probe` is the way to it from the centre, in the probe's
    /// own axes and metres. None in the centre, and where no image is.
    pub fn project(&self, from_probe: Vec3) -> Option<Projected> {
        if let Some(view) = &self.faces[Face::View as usize] {
            return project_to_view(from_probe, view);
        }
        let (face, u, v, planar_m) = cube_face(from_probe);
        let texels = self.faces[face].as_ref()?;
        let at = [u * texels.scale[0] + texels.centre[0], v * texels.scale[1] + texels.centre[1]];
        let inverse_depth = 1.0 / planar_m;
        inverse_depth.is_finite().then_some(Projected { face, at, inverse_depth })
    }
}

fn project_to_view(from_probe: Vec3, view: &FaceTexels) -> Option<Projected> {
    let inverse_depth = 1.0 / -from_probe.z;
    if !(inverse_depth.is_finite() && inverse_depth > 0.0) {
        return None;
    }
    let plane = [from_probe.x * inverse_depth, -from_probe.y * inverse_depth];
    let at = [0, 1].map(|axis| plane[axis] * view.scale[axis] + view.centre[axis]);
    let inside = (0..2).all(|axis| at[axis] >= 0.0 && at[axis] < view.size[axis] as f32);
    inside.then_some(Projected { face: Face::View as usize, at, inverse_depth })
}

/// Face, u, v and planar depth of a point, as `image::cube::direction_to_face` has them, in single precision.
pub fn cube_face(x: Vec3) -> (usize, f32, f32, f32) {
    let size = x.abs();
    if size.x >= size.y && size.x >= size.z {
        let scale = 1.0 / size.x;
        if x.x < 0.0 { (1, x.z * scale, -x.y * scale, size.x) } else { (0, -x.z * scale, -x.y * scale, size.x) }
    } else if size.y >= size.z {
        let scale = 1.0 / size.y;
        if x.y < 0.0 { (3, x.x * scale, -x.z * scale, size.y) } else { (2, x.x * scale, x.z * scale, size.y) }
    } else {
        let scale = 1.0 / size.z;
        if x.z < 0.0 { (5, -x.x * scale, -x.y * scale, size.z) } else { (4, x.x * scale, -x.y * scale, size.z) }
    }
}

/// Metres of a stream's codes as texels have them: [`InverseDepth::of`].
#[derive(Debug, Clone)]
pub struct InverseDepth {
    /// 1 over the metres of each code.
    of_code: Vec<f32>,
    kind: DepthKind,
}

impl InverseDepth {
    /// The table of a stream's range.
    pub fn new(range: DepthRange, kind: DepthKind) -> InverseDepth {
        InverseDepth { of_code: (0..=u16::MAX).into_par_iter().map(|code| 1.0 / range.metres(code)).collect(), kind }
    }

    /// 1 over the metres of each code.
    pub fn of_codes(&self) -> &[f32] {
        &self.of_code
    }

    /// What the metres of codes are.
    pub fn kind(&self) -> DepthKind {
        self.kind
    }

    /// Inverse planar depth of a texel that shows `code`.
    pub fn of(&self, code: u16, face: &FaceTexels, column: u32, row: u32) -> f32 {
        let inverse = self.of_code[usize::from(code)];
        match self.kind {
            DepthKind::Planar => inverse,
            DepthKind::Distance => inverse * face.stretch(column, row),
        }
    }

    /// Writes texels that show `codes`, from a column of a row on, which they must fit into; answers the first and the last of
    /// them that became different.
    pub fn write_row(&self, codes: &[u16], face: &mut FaceTexels, [column, row]: [u32; 2]) -> Option<[u32; 2]> {
        let start = row as usize * face.size[0] as usize + column as usize;
        let mut differ = None;
        for (at, &code) in (0u32..).zip(codes) {
            let inverse_depth = self.of(code, face, column + at, row);
            let texel = &mut face.inverse_depth[start + at as usize];
            if *texel != inverse_depth {
                *texel = inverse_depth;
                differ = Some([differ.map_or(at, |[first, _]: [u32; 2]| first), at]);
            }
        }
        differ
    }
}

/// The probes of a container, as far as they are known, in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct LightField {
    /// Its probes, in the order of the container.
    pub views: Vec<View>,
    /// What its colours are coded in.
    pub coding: ColorCoding,
}

impl LightField {
    /// Whether a view has a stream of materials: without one, no effect is called for.
    pub fn has_material(&self) -> bool {
        self.views.iter().any(View::has_material)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::cube::direction_to_face;

    #[test]
    fn faces_are_those_of_the_format() {
        for at in 0..4000u32 {
            let part = |prime: u32| ((at * prime) % 2003) as f32 / 1001.5 - 1.0;
            let x = Vec3::new(part(7), part(11), part(13));
            if x == Vec3::ZERO {
                continue;
            }
            let (face, u, v, planar_m) = cube_face(x);
            let (expected, expected_u, expected_v) = direction_to_face(x.as_dvec3());
            assert_eq!(face, expected as usize);
            assert!((f64::from(u) - expected_u).abs() < 1e-6 && (f64::from(v) - expected_v).abs() < 1e-6);
            assert_eq!(planar_m, x.abs().max_element());
        }
    }
}
