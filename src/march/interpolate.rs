//! The colour of a point: CalculateColor of algorithm 4 (CALF 6).
//!
//! Enters: active views and a surface point, or a direction of the background. Leaves: a weighted mean of texels, and
//! how well their depths fit. What the paper leaves open:
//!
//! - The prose calls both weights exponential, the listing has 1/(x + ε). We take the listing's: the exponential is 0.1
//!   to 0.3 dB worse on measured footage at any scale, as it selects where the listing averages.
//! - The printed listing lacks the division by the sum of the weights.
//! - Depths are compared as logarithms of distances, not as codes, so that weights do not depend on near and far.
//!   Distances of cameras are relative to the farthest active one.
//!
//! Each of the four texels around a point has a weight by its own depth, so that edges do not bleed.

use glam::Vec3;

use crate::march::{ActiveView, ActiveViews};
use crate::views::{BACKGROUND, FaceTexels, Projected, UNKNOWN};

/// ε of the weight of depth: a difference of two per cent halves the weight.
pub const DEPTH_EPSILON: f32 = 0.02;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interpolated {
    /// As it is coded ([`crate::views::light_field::ColorCoding`]): codes over 255, or light.
    pub color: Vec3,
    /// The least difference between the logarithms of the distances of the point and of a texel.
    pub difference: f32,
}

/// Four texels around a point in an image, with the weights of bilinear interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// Indices into the image.
    pub texels: [usize; 4],
    /// They sum up to 1.
    pub weights: [f32; 4],
}

impl Taps {
    /// The texels around a place, clamped to the image.
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

/// A texel near a surface point, with its weight in the mean.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightedTexel<'a> {
    pub(crate) face: &'a FaceTexels,
    pub(crate) texel: usize,
    pub(crate) weight: f32,
    /// See [`Interpolated::difference`].
    pub(crate) difference: f32,
}

/// The face of an active view that contains a point, and the place in it.
fn image_of<'a>(view: &ActiveView<'a>, local: Vec3) -> Option<(&'a FaceTexels, Projected)> {
    let at = view.view.project(local)?;
    Some((view.view.faces[at.face].as_ref()?, at))
}

/// The texels of surfaces around a point in all views, in a fixed order.
pub(crate) fn surface_texels(views: &ActiveViews<'_>, point: Vec3, mut visit: impl FnMut(WeightedTexel<'_>)) {
    views.views.iter().for_each(|view| texels_of_view(view, point, &mut visit));
}

/// The texels of surfaces around a point in a view.
fn texels_of_view(view: &ActiveView<'_>, point: Vec3, mut visit: impl FnMut(WeightedTexel<'_>)) {
    let Some((face, at)) = image_of(view, view.local(point)) else { return };
    let taps = Taps::around(at.at, face);
    for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
        let inverse_depth = face.inverse_depth[texel];
        if inverse_depth != BACKGROUND && inverse_depth != UNKNOWN {
            let difference = (inverse_depth / at.inverse_depth).ln().abs();
            let weight = weight * view.camera_weight / (difference + DEPTH_EPSILON);
            visit(WeightedTexel { face, texel, weight, difference });
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Sum {
    color: Vec3,
    weight: f32,
    difference: f32,
}

impl Sum {
    const EMPTY: Sum = Sum { color: Vec3::ZERO, weight: 0.0, difference: f32::INFINITY };

    fn add(&mut self, WeightedTexel { face, texel, weight, difference }: WeightedTexel<'_>) {
        self.color += weight * face.color.get(texel);
        self.weight += weight;
        self.difference = self.difference.min(difference);
    }

    fn mean(&self) -> Option<Interpolated> {
        (self.weight > 0.0).then(|| Interpolated { color: self.color / self.weight, difference: self.difference })
    }
}

/// The colour of a surface point. None where no view has a surface in its direction.
pub fn surface_color(views: &ActiveViews<'_>, point: Vec3) -> Option<Interpolated> {
    let mut sum = Sum::EMPTY;
    surface_texels(views, point, |texel| sum.add(texel));
    sum.mean()
}

/// The colour of a surface point in views by their share, which is 0 or more. None where no such view has a surface in its direction.
pub fn surface_color_of(
    views: &ActiveViews<'_>,
    point: Vec3,
    share: impl Fn(&ActiveView<'_>) -> f32,
) -> Option<Interpolated> {
    let mut sum = Sum::EMPTY;
    for view in &views.views {
        let share = share(view);
        if share > 0.0 {
            texels_of_view(view, point, |texel| sum.add(WeightedTexel { weight: share * texel.weight, ..texel }));
        }
    }
    sum.mean()
}

/// The colour of the background in a direction of length 1. None where surfaces hide it from all views.
pub fn background_color(views: &ActiveViews<'_>, direction: Vec3) -> Option<Interpolated> {
    let mut sum = Sum::EMPTY;
    for view in &views.views {
        let Some((face, at)) = image_of(view, view.probe_from_world * direction) else { continue };
        let taps = Taps::around(at.at, face);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            if face.inverse_depth[texel] == BACKGROUND {
                sum.add(WeightedTexel { face, texel, weight: weight * view.camera_weight, difference: 0.0 });
            }
        }
    }
    sum.mean()
}
