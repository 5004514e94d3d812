//! Synthetic light fields from formulas, for tests and hard cases.

use glam::{DMat3, DQuat, DVec3};
use half::f16;

use crate::views::{BACKGROUND, ColorCoding, ColorTexels, FaceTexels, View};
use codec::image::projection::centre_of;
use codec::image::{Face, ImageProjection, TexelMap};

/// Function from a unit direction in world axes to a distance in metres and a colour; none for background.
pub type Sight<'a> = &'a dyn Fn(DVec3) -> Option<(f64, [u8; 3])>;

#[derive(Debug, Clone, Copy)]
pub struct SyntheticProbe {
    pub position: DVec3,
    /// Rotation from probe axes to world axes.
    pub turn: DQuat,
    /// Width and height of the faces in pixels, at least 1.
    pub size: [u32; 2],
    /// Nearest and farthest distance, in metres.
    pub range_m: [f32; 2],
}

impl SyntheticProbe {
    /// Creates a cube map with square faces and no rotation.
    pub fn new(position: DVec3, side: u32) -> SyntheticProbe {
        SyntheticProbe { position, turn: DQuat::IDENTITY, size: [side; 2], range_m: [0.1, 100.0] }
    }

    pub fn cube(&self, coding: ColorCoding, sight: Sight<'_>) -> View {
        let mut view = self.view();
        for face in Face::CUBE {
            view.faces[face as usize] = Some(self.face(face, TexelMap::cube_face(self.size), coding, sight));
        }
        view
    }

    pub fn view(&self) -> View {
        View {
            name: "made".into(),
            position: self.position,
            probe_from_world: DMat3::from_quat(self.turn.inverse()),
            near_m: self.range_m[0],
            far_m: self.range_m[1],
            ..View::default()
        }
    }

    pub fn face(&self, face: Face, map: TexelMap, coding: ColorCoding, sight: Sight<'_>) -> FaceTexels {
        let mut texels = FaceTexels::unknown(self.size, map, coding);
        let [forward, right, down] = face.axes();
        let ([fx, fy], [cx, cy]) = (map.scale, map.centre);
        let exact = ImageProjection::Pinhole { size: self.size, intrinsics: [fx, fy, cx, cy].map(f64::from) };
        for at in 0..texels.inverse_depth.len() {
            let [u, v] = exact.plane(centre_of(at as u32 % self.size[0], at as u32 / self.size[0]));
            let direction = self.turn * (forward + u * right + v * down);
            let stretch = direction.length();
            let (inverse, [r, g, b]) = match sight(direction / stretch) {
                Some((distance_m, color)) => ((stretch / distance_m) as f32, color),
                None => (BACKGROUND, [90, 120, 200]),
            };
            texels.inverse_depth[at] = inverse;
            match &mut texels.color {
                ColorTexels::Codes(codes) => codes[at] = [r, g, b, 0],
                ColorTexels::Light(light) => light[at] = [r, g, b, 0].map(|code| f16::from_f32(f32::from(code) / 64.0)),
            }
        }
        texels
    }
}

/// Sets the alpha of a view's texels, in 255ths, given their image and index.
pub fn set_alpha(view: &mut View, mut alpha: impl FnMut(&FaceTexels, usize) -> u8) {
    for texels in view.faces.iter_mut().flatten() {
        texels.has_alpha = true;
        for at in 0..texels.inverse_depth.len() {
            let alpha = alpha(texels, at);
            match &mut texels.color {
                ColorTexels::Codes(codes) => codes[at][3] = alpha,
                ColorTexels::Light(light) => light[at][3] = f16::from_f32(f32::from(alpha) / 255.0),
            }
        }
    }
}

/// Sets the alpha of a view in blocks of this many columns and rows of texels: 255, 128, 0 or 60.
pub fn set_alpha_of_blocks(view: &mut View, [columns, rows]: [usize; 2]) {
    set_alpha(view, |texels, at| {
        let width = texels.size[0] as usize;
        [255, 128, 0, 60][(at % width / columns + at / width / rows) % 4]
    });
}

/// Intersects a ray from `eye` with the inside of a box around the origin with half of these sides, which contains a box of
/// `pillar` times its width and depth. Colours are functions of position.
pub fn room(eye: DVec3, direction: DVec3, half: DVec3, pillar: f64) -> Option<(f64, [u8; 3])> {
    let crossings = |half: DVec3| {
        let [low, high] = [-half, half].map(|wall| (wall - eye) / direction);
        (low.min(high).max_element(), low.max(high).min_element())
    };
    let inner = DVec3::new(half.x * pillar, half.y, half.z * pillar);
    let (enters, leaves) = crossings(inner);
    let distance_m = if enters > 0.0 && enters <= leaves { enters } else { crossings(half).1 };
    let at = eye + direction * distance_m;
    let color = [at.x, at.y, at.z].map(|at| (128.0 + 100.0 * (3.0 * at).sin()) as u8);
    distance_m.is_finite().then_some((distance_m, color))
}
