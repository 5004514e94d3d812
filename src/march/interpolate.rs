//! What colour a point has: CalculateColor of algorithm 4 (CALF 6).
//!
//! Enters: active views and a point on a surface, or a direction of the background. Leaves: the colour that the views
//! saw there, by the product of two weights, and how well they fit.
//!
//! Three things that the paper leaves open are settled so:
//!
//! - The prose calls both weights exponential, the listing has 1/(x + ε). It is 1/(x + ε): on measured footage the
//!   exponential is 0.1 to 0.3 dB worse, whatever its scale, since it chooses where the listing averages.
//! - The scan of the listing lost the division by the sum of the weights; without it colours would depend on their number.
//! - Differences of depth are differences of the logarithm of the distance, not of codes, so that they do not depend on
//!   how far near is from far; distances of cameras count in parts of the farthest active one.
//!
//! Colour is read from the four texels around a point, each weighted by its own depth, so that a texel on the other side
//! of an edge does not bleed into this one.

use glam::Vec3;

use crate::march::active_views::{ActiveView, ActiveViews};
use crate::views::light_field::{BACKGROUND, FaceTexels, Projected, UNKNOWN};

/// ε of the weight of depth: a difference of two per cent halves the weight.
pub const DEPTH_EPSILON: f32 = 0.02;
/// ε of the weight of the camera, in parts of the distance of the farthest active view from the eye.
pub const CAMERA_EPSILON: f32 = 0.01;

/// What views saw at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Colour as it is coded ([`crate::views::light_field::ColorCoding`]): codes over 255, or light.
    pub color: Vec3,
    /// The least difference of the logarithms of distance between the point and a texel that its colour is from.
    pub difference: f32,
}

/// Four texels around a point in an image, with the weights of bilinear interpolation, which sum up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// Places of the texels in their image.
    pub texels: [usize; 4],
    /// Their weights.
    pub weights: [f32; 4],
}

impl Taps {
    /// The texels around a place; those beyond an edge of the image are those at the edge.
    pub fn around(at: [f32; 2], face: &FaceTexels) -> Taps {
        let [x, y] = at.map(|at| at - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = (x - left, y - top);
        let clamp = |at: f32, size: u32| at.clamp(0.0, size.saturating_sub(1) as f32) as usize;
        let columns = [clamp(left, face.size[0]), clamp(left + 1.0, face.size[0])];
        let rows = [clamp(top, face.size[1]), clamp(top + 1.0, face.size[1])].map(|row| row * face.size[0] as usize);
        Taps {
            texels: [rows[0] + columns[0], rows[0] + columns[1], rows[1] + columns[0], rows[1] + columns[1]],
            weights: [(1.0 - across) * (1.0 - down), across * (1.0 - down), (1.0 - across) * down, across * down],
        }
    }
}

/// The weights of active views by their distance from the eye: w_cam of algorithm 4.
pub fn camera_weights(views: &ActiveViews<'_>) -> Vec<f32> {
    let distances: Vec<f32> = views.views.iter().map(|view| view.from_eye.length()).collect();
    let farthest = distances.iter().copied().fold(0.0, f32::max);
    if farthest == 0.0 {
        return vec![1.0; distances.len()];
    }
    distances.iter().map(|distance| 1.0 / (distance / farthest + CAMERA_EPSILON)).collect()
}

/// The difference of the logarithms of two inverse depths; none where one of them is no surface.
pub(crate) fn log_difference(texel: f32, point: f32) -> Option<f32> {
    if texel == BACKGROUND || texel == UNKNOWN { None } else { Some((texel / point).ln().abs()) }
}

/// Sums up what views saw.
#[derive(Debug, Clone, Copy)]
struct Sum {
    color: Vec3,
    weight: f32,
    difference: f32,
}

impl Sum {
    const EMPTY: Sum = Sum { color: Vec3::ZERO, weight: 0.0, difference: f32::INFINITY };

    fn add(&mut self, face: &FaceTexels, texel: usize, weight: f32, difference: f32) {
        self.color += weight * face.color.get(texel);
        self.weight += weight;
        self.difference = self.difference.min(difference);
    }

    fn seen(&self) -> Option<Seen> {
        (self.weight > 0.0).then(|| Seen { color: self.color / self.weight, difference: self.difference })
    }
}

/// The face of an active view that a point is in, with the place there.
pub(crate) fn image_of<'a>(view: &ActiveView<'a>, local: Vec3) -> Option<(&'a FaceTexels, Projected)> {
    let at = view.view.project(local)?;
    Some((view.view.faces[at.face].as_ref()?, at))
}

/// What the views saw of a surface in a point, `point` in metres from the eye. None where none of them saw any surface
/// in its direction.
pub fn surface_color(views: &ActiveViews<'_>, camera_weights: &[f32], point: Vec3) -> Option<Seen> {
    let mut sum = Sum::EMPTY;
    for (view, camera_weight) in views.views.iter().zip(camera_weights) {
        let Some((face, at)) = image_of(view, view.local(point)) else { continue };
        let taps = Taps::around(at.at, face);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            if let Some(difference) = log_difference(face.inverse_depth[texel], at.inverse_depth) {
                let weight = weight * camera_weight / (difference + DEPTH_EPSILON);
                sum.add(face, texel, weight, difference);
            }
        }
    }
    sum.seen()
}

/// What the views saw of the background in a direction of length 1. None where surfaces hide it from all of them.
pub fn background_color(views: &ActiveViews<'_>, camera_weights: &[f32], direction: Vec3) -> Option<Seen> {
    let mut sum = Sum::EMPTY;
    for (view, camera_weight) in views.views.iter().zip(camera_weights) {
        let Some((face, at)) = image_of(view, view.probe_from_world * direction) else { continue };
        let taps = Taps::around(at.at, face);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            if face.inverse_depth[texel] == BACKGROUND {
                sum.add(face, texel, weight * camera_weight, 0.0);
            }
        }
    }
    sum.seen()
}
