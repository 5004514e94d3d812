//! Texels and poses of probes in one frame (CALF 6, algorithm 4, C, D, M and P).
//!
//! Depth is stored as inverse planar depth: planes are linear in it, and a point of a ray is compared by one multiplication.
//! Background is 0, and unknown texels are +inf.

use glam::{DMat3, DVec3, Vec3};
use half::f16;

use codec::container::ProbeEntry;
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::texel_map::PlanarPoint;
use codec::image::{Face, TexelMap, ToneMap};
use codec::math::camera::rotation;

/// Inverse planar depth of background.
pub const BACKGROUND: f32 = 0.0;
/// Inverse planar depth of a texel that was not captured or not decoded.
pub const UNKNOWN: f32 = f32::INFINITY;

/// Coding of the colours, in which views are interpolated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorCoding {
    /// 8-bit codes after a transfer curve and an exposure.
    Codes(ToneMap),
    /// Linear light as half floats.
    Light,
}

impl ColorCoding {
    /// Returns the transfer from linear light to 8-bit codes: that of the container, or sRGB if the container holds linear light.
    pub fn tone(self) -> ToneMap {
        match self {
            ColorCoding::Codes(tone) => tone,
            ColorCoding::Light => ToneMap::default(),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum ColorTexels {
    /// 8-bit codes; the fourth byte is alpha in 255ths.
    Codes(Vec<[u8; 4]>),
    /// Linear light; the fourth half is alpha.
    Light(Vec<[f16; 4]>),
}

impl ColorTexels {
    /// Returns a texel: codes over 255, or linear light.
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

    /// Returns the fourth component of a texel, 0 to 1.
    fn fourth(&self, at: usize) -> f32 {
        match self {
            ColorTexels::Codes(texels) => f32::from(texels[at][3]) / 255.0,
            ColorTexels::Light(texels) => texels[at][3].to_f32(),
        }
    }
}

/// Texels of one image of a probe, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceTexels {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub map: TexelMap,
    /// Inverse planar depth in 1/m, [`BACKGROUND`] or [`UNKNOWN`].
    pub inverse_depth: Vec<f32>,
    /// Straight colours, not multiplied by alpha, so that codes can be interpolated with alpha as their weight: a mean of codes
    /// of premultiplied light is too dark.
    pub color: ColorTexels,
    /// True if the fourth component of its colours is alpha. Otherwise its texels are opaque, and the fourth component is
    /// ignored.
    pub has_alpha: bool,
    /// Weights of reflection and refraction, and the index of refraction, as coded by `streams::convert`; the fourth byte is 0.
    /// None if the container has no material of this face.
    pub material: Option<Vec<[u8; 4]>>,
    /// True if a weight of its material is above 0. Call [`FaceTexels::update_specular`] after writing `material`.
    pub is_specular: bool,
}

impl FaceTexels {
    /// Creates a face of `size` unknown texels, without material.
    pub fn unknown(size: [u32; 2], map: TexelMap, coding: ColorCoding) -> FaceTexels {
        let texels = size[0] as usize * size[1] as usize;
        FaceTexels {
            size,
            map,
            inverse_depth: vec![UNKNOWN; texels],
            color: match coding {
                ColorCoding::Codes(_) => ColorTexels::Codes(vec![[0; 4]; texels]),
                ColorCoding::Light => ColorTexels::Light(vec![[f16::ZERO; 4]; texels]),
            },
            has_alpha: false,
            material: None,
            is_specular: false,
        }
    }

    /// Creates a face whose depths and colours are stored only by a [`backend`](crate::views::backend).
    pub fn in_backend(size: [u32; 2], map: TexelMap, coding: ColorCoding) -> FaceTexels {
        let nothing = FaceTexels::unknown([0; 2], map, coding);
        FaceTexels { size, ..nothing }
    }

    pub fn is_in_backend(&self) -> bool {
        self.inverse_depth.is_empty() && self.size != [0; 2]
    }

    #[must_use]
    pub fn with_material(self) -> FaceTexels {
        let texels = self.size[0] as usize * self.size[1] as usize;
        FaceTexels { material: Some(vec![[0; 4]; texels]), ..self }
    }

    /// Returns the fraction of a texel that its surface or background covers, 0 to 1.
    pub fn alpha(&self, at: usize) -> f32 {
        if self.has_alpha { self.color.fourth(at) } else { 1.0 }
    }

    /// Returns the texels to the left and right of a texel, above and below it, inside the image.
    pub(crate) fn beside(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, texels) = (self.size[0] as usize, self.inverse_depth.len());
        let column = at % width.max(1);
        let beside = [
            (column > 0).then(|| at - 1),
            (column + 1 < width).then_some(at + 1),
            at.checked_sub(width),
            Some(at + width).filter(|&below| below < texels),
        ];
        beside.into_iter().flatten()
    }

    /// Returns the direction of the centre of a texel in the probe's axes, with planar depth 1.
    pub(crate) fn direction(&self, face: Face, at: usize) -> DVec3 {
        let width = self.size[0] as usize;
        self.map.direction(face, [at % width, at / width].map(|at| at as f32 + 0.5)).as_dvec3()
    }

    pub fn update_specular(&mut self) {
        self.is_specular = self.material.as_ref().is_some_and(|texels| texels.iter().any(has_specular_weight));
    }
}

/// True if a weight of a coded material is above 0; the first component is reflection, the second refraction.
pub(crate) fn has_specular_weight<const N: usize>(material: &[u8; N]) -> bool {
    material.iter().take(2).any(|&weight| weight > 0)
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Index of the face ([`Face`]).
    pub face: usize,
    /// Column and row, in texels from the upper left corner of the image.
    pub at: [f32; 2],
    /// Inverse planar depth of the point, in 1/m; above 0.
    pub inverse_depth: f32,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct View {
    pub name: String,
    /// Index in the container's table of probes.
    pub probe: usize,
    pub position: DVec3,
    pub probe_from_world: DMat3,
    /// Lower bound on the distance of its surfaces, in metres.
    pub near_m: f32,
    /// Upper bound on the planar depth or distance of its surfaces, in metres.
    pub far_m: f32,
    /// Images by the index of their face ([`Face`]); a cube map has up to six, a perspective probe only the last.
    pub faces: [Option<FaceTexels>; 7],
}

impl View {
    pub fn new(probe: usize, entry: &ProbeEntry, range: DepthRange) -> Result<View> {
        let mut view =
            View { name: entry.name.clone(), probe, near_m: range.near_m(), far_m: range.far_m(), ..View::default() };
        view.place(entry)?;
        Ok(view)
    }

    /// Moves the view to the pose of its probe. Fails if the orientation is not a rotation.
    pub fn place(&mut self, entry: &ProbeEntry) -> Result<()> {
        let turn = rotation(entry.orientation)
            .ok_or_else(|| Error::invalid(format!("probe {}: its orientation is not a rotation", entry.name)))?;
        self.position = DVec3::from_array(entry.position);
        self.probe_from_world = DMat3::from_quat(turn.inverse());
        Ok(())
    }

    pub fn has_material(&self) -> bool {
        self.faces.iter().flatten().any(|face| face.material.is_some())
    }

    pub fn is_specular(&self) -> bool {
        self.faces.iter().flatten().any(|face| face.is_specular)
    }

    /// Projects a point, given in the probe's axes, into an image plane; none behind a perspective image.
    pub fn planar_point(&self, from_probe: Vec3) -> Option<PlanarPoint> {
        match self.faces[Face::View as usize] {
            Some(_) => PlanarPoint::in_view(from_probe),
            None => Some(PlanarPoint::on_cube(from_probe)),
        }
    }

    /// Projects a point into the images of this probe. `from_probe` is the vector to the point from the centre, in the probe's
    /// axes and metres. None at the centre, and where the probe has no image.
    pub fn project(&self, from_probe: Vec3) -> Option<Projected> {
        let PlanarPoint { face, plane, planar } = self.planar_point(from_probe)?;
        let texels = self.faces[face].as_ref()?;
        let at = texels.map.position(plane);
        let inside = |axis: usize| at[axis] >= 0.0 && at[axis] < texels.size[axis] as f32;
        let inverse_depth = 1.0 / planar;
        let is_shown = face != Face::View as usize || (inverse_depth > 0.0 && inside(0) && inside(1));
        (inverse_depth.is_finite() && is_shown).then_some(Projected { face, at, inverse_depth })
    }
}

/// Probes of a container in one frame, as far as they are decoded.
#[derive(Debug, Clone, PartialEq)]
pub struct LightField {
    /// Views of the probes, in the order of the container.
    pub views: Vec<View>,
    pub coding: ColorCoding,
}
