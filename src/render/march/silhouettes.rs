//! Mask of pixels near silhouettes of views, where ghosting occurs: a texel at a silhouette mixes two surfaces, and one of them
//! is shown at the position of the other.
//!
//! Takes views, a camera and a size. Returns a mask.

use glam::DVec3;

use crate::march::HOLE_DIFFERENCE;
use crate::views::{BACKGROUND, FaceTexels, UNKNOWN, View};
use codec::error::Result;
use codec::image::{Face, Plane};
use codec::math::Camera;

/// Maximum number of columns and rows between a silhouette and a pixel near it.
pub const REACH_PIXELS: u32 = 3;

/// Returns the pixels of a camera's image of this width and height that are at most [`REACH_PIXELS`] columns and rows from a
/// projected silhouette of a view, occluded or not. A silhouette lies between two adjacent texels whose log distances differ by
/// more than [`HOLE_DIFFERENCE`], or of which one is background. None if no depth is decoded on the CPU.
pub fn near_silhouettes(views: &[&View], camera: &Camera, [width, height]: [u32; 2]) -> Result<Option<Plane<bool>>> {
    let mut mask = vec![false; width as usize * height as usize];
    let mut is_known = false;
    let mut mark = |from_eye: DVec3| {
        let Some((at, _)) = camera.project(from_eye) else { return };
        let [x, y] = [at[0] * f64::from(width), at[1] * f64::from(height)];
        if !(0.0..f64::from(width)).contains(&x) || !(0.0..f64::from(height)).contains(&y) {
            return;
        }
        let around = |at: f64, size: u32| {
            let at = at as u32;
            at.saturating_sub(REACH_PIXELS)..(at + REACH_PIXELS + 1).min(size)
        };
        for row in around(y, height) {
            let first = row as usize * width as usize;
            around(x, width).for_each(|column| mask[first + column as usize] = true);
        }
    };
    for view in views {
        for (face, texels) in view.faces.iter().enumerate().filter_map(|(face, texels)| Some((face, texels.as_ref()?)))
        {
            let Some(face) = Face::from_index(face as u8).filter(|_| !texels.is_in_backend()) else { continue };
            is_known = true;
            for at in (0..texels.inverse_depth.len()).filter(|&at| is_silhouette(texels, at)) {
                mark(from_eye(view, (face, texels), at, camera.eye()));
            }
        }
    }
    is_known.then(|| Plane::new(width, height, mask)).transpose()
}

/// True if an adjacent texel has another surface.
fn is_silhouette(texels: &FaceTexels, at: usize) -> bool {
    let own = texels.inverse_depth[at];
    let differs = |other: usize| match (own, texels.inverse_depth[other]) {
        (UNKNOWN, _) | (_, UNKNOWN) => false,
        (BACKGROUND, other) => other != BACKGROUND,
        (_, BACKGROUND) => true,
        (own, other) => (own / other).ln().abs() > HOLE_DIFFERENCE,
    };
    texels.beside(at).any(differs)
}

/// Returns the vector in metres from the eye to the surface of a texel; for background, its direction.
fn from_eye(view: &View, (face, texels): (Face, &FaceTexels), at: usize, eye: DVec3) -> DVec3 {
    let direction = view.probe_from_world.transpose() * texels.direction(face, at);
    match texels.inverse_depth[at] {
        BACKGROUND => direction,
        inverse_depth => direction / f64::from(inverse_depth) + (view.position - eye),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::synthetic::SyntheticProbe;
    use crate::views::light_field::ColorCoding;
    use codec::image::transfer::{ToneMap, Transfer};
    use codec::math::Lens;

    const CODES: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });

    /// A plate of 16 × 16 texels 1 m in front of a probe, with background behind it.
    fn plate() -> View {
        SyntheticProbe::new(DVec3::ZERO, 64).cube(CODES, &|direction| {
            let at = direction / -direction.z;
            (direction.z < 0.0 && at.x.abs() < 0.25 && at.y.abs() < 0.25)
                .then(|| (direction.length() / -direction.z, [9; 3]))
        })
    }

    #[test]
    fn pixels_near_the_outline_of_a_plate_are_marked_and_no_others() {
        let camera = |eye: DVec3| Camera::look_at(eye, eye + DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
        let mask = near_silhouettes(&[&plate()], &camera(DVec3::ZERO), [64; 2]).unwrap().unwrap();
        // The plate covers columns 24 to 39. The two texels on both sides of each edge are silhouettes.
        for (x, expected) in
            [(19, false), (20, true), (27, true), (28, false), (35, false), (36, true), (43, true), (44, false)]
        {
            assert_eq!(mask.get(x, 32), expected, "column {x}");
        }
        // From the side, the background stays in place, and the plate moves.
        let mask = near_silhouettes(&[&plate()], &camera(DVec3::new(-0.5, 0.0, 0.0)), [64; 2]).unwrap().unwrap();
        assert!(mask.get(23, 32) && mask.get(40, 32) && mask.get(55, 32) && !mask.get(48, 32));
    }

    #[test]
    fn without_depths_there_is_no_mask() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
        assert_eq!(near_silhouettes(&[], &camera, [8; 2]).unwrap(), None);
    }
}
