//! Interpolation of the colour of a point: CalculateColor of algorithm 4 (CALF 6).
//!
//! Takes active views and a surface point, or a direction of the background. Returns a weighted mean of texels, and how well
//! their depths match. Choices where the paper is ambiguous:
//!
//! - The prose calls both weights exponential; the listing has 1/(x + ε). This code follows the listing: exponential weights are
//!   0.1 to 0.3 dB worse on measured footage at any scale, because they act as a selection where the listing averages.
//! - The printed listing lacks the division by the sum of the weights.
//! - Depths are compared as logarithms of distances, not as codes, so that weights do not depend on near and far. Camera
//!   distances are relative to that of the farthest active view.
//!
//! Each of the four texels around a point is weighted by its own depth, so that colours do not bleed across edges.
//!
//! Colours are weighted by their alpha; if all texels are transparent, the colour is black. The alpha of a surface is averaged
//! over the texels that have this surface, with the weights of coverage: a pane in front of the surface has little weight in its
//! colour, but would lower its alpha. Secondary rays treat surfaces as opaque.

use glam::Vec3;

use crate::march::active_views::CAMERA_EPSILON;
use crate::march::{ActiveView, ActiveViews, RenderSettings};
use crate::views::{BACKGROUND, FaceTexels, Projected, UNKNOWN};

/// ε of the depth weight: a difference of 2% in distance halves the weight.
pub const DEPTH_EPSILON: f32 = 0.02;
/// ε of the angle weight, in radians: this angle halves the weight of a view, relative to a view in the direction of the eye.
pub const ANGLE_EPSILON: f32 = 0.0005;
/// Texels whose log depth differs by more than this have almost no weight with `angle_weight`.
pub const DEPTH_CUT: f32 = 0.2;
/// Penalty on texels next to a nearer surface, which contain a mix with its colour. For these texels, the view's weight
/// 1 / (x + ε), where x is the view's angle or its distance from the eye, becomes 1 / (x (1 + penalty) + ε). Nothing changes if
/// the eye is at the viewpoint, so that images converge to what a probe recorded. A larger penalty hides outlines of bright
/// objects better, but takes more edge detail from views that see the edge less sharply.
pub const EDGE_PENALTY: f32 = 6.0;
/// [`EDGE_PENALTY`] of background texels.
pub const BACKGROUND_EDGE_PENALTY: f32 = 20.0;
/// Minimum ratio of inverse depths at which a surface counts as nearer than an adjacent one: e to the power of
/// [`HOLE_DIFFERENCE`](crate::march::HOLE_DIFFERENCE).
pub const NEARER: f32 = 1.105_171;
/// Fraction of its weight that a texel keeps beyond [`DEPTH_CUT`], so that there is a colour even if all texels are beyond it.
pub const CUT_WEIGHT: f32 = 0.001;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interpolated {
    /// Colour as coded ([`crate::views::light_field::ColorCoding`]): codes over 255, or linear RGB.
    pub color: Vec3,
    /// Minimum difference between the log distances of the point and of a texel.
    pub difference: f32,
    /// Weighted fraction of the texels around the point that have its surface, among those that have no nearer one; 1 if all have
    /// it.
    pub coverage: f32,
    /// Alpha of the surface, 0 to 1.
    pub alpha: f32,
}

/// Four texels around a position in an image, with the weights of bilinear interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// Indices into the image.
    pub texels: [usize; 4],
    /// Sum to 1.
    pub weights: [f32; 4],
}

impl Taps {
    /// Returns the texels around a position, clamped to the image.
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
    /// Absolute difference between the log distances of the point and of the texel.
    pub(crate) difference: f32,
}

/// Returns the image of an active view that contains a point, and the position in it.
fn image_of<'a>(view: &ActiveView<'a>, local: Vec3) -> Option<(&'a FaceTexels, Projected)> {
    let at = view.view.project(local)?;
    Some((view.view.faces[at.face].as_ref()?, at))
}

/// Visits the surface texels around a point in all views, in a fixed order.
pub(crate) fn surface_texels(views: &ActiveViews<'_>, point: Vec3, mut visit: impl FnMut(WeightedTexel<'_>)) {
    views.views.iter().for_each(|view| texels_of_view(view, point, &mut visit));
}

/// Visits the surface texels around a point in one view.
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
    /// Sum of the weights times alpha: the weights of the colours.
    shown: f32,
    difference: f32,
}

impl Sum {
    const EMPTY: Sum = Sum { color: Vec3::ZERO, weight: 0.0, shown: 0.0, difference: f32::INFINITY };

    fn add(&mut self, WeightedTexel { face, texel, weight, difference }: WeightedTexel<'_>) {
        let shown = weight * face.alpha(texel);
        self.color += shown * face.color.get(texel);
        self.weight += weight;
        self.shown += shown;
        self.difference = self.difference.min(difference);
    }

    fn mean(&self) -> Option<Interpolated> {
        let color = if self.shown > 0.0 { self.color / self.shown } else { Vec3::ZERO };
        let alpha = self.shown / self.weight;
        (self.weight > 0.0).then_some(Interpolated { color, difference: self.difference, coverage: 1.0, alpha })
    }
}

/// Interpolates the colour of a surface point. None if no view has a surface in its direction.
pub fn surface_color(views: &ActiveViews<'_>, point: Vec3) -> Option<Interpolated> {
    let mut sum = Sum::EMPTY;
    surface_texels(views, point, |texel| sum.add(texel));
    sum.mean()
}

/// Interpolates the colour of a surface point, with the weight of each view multiplied by its share, which is 0 or more. None if
/// no view with a share above 0 has a surface in its direction.
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

/// Returns the weight of a view for a point that the eye sees. It decreases with the angle between the view's ray and the eye's
/// ray to the point, and with the view's distance from the point (the angle and resolution penalties of unstructured lumigraph
/// rendering).
pub(crate) fn angle_weight(view: &ActiveView<'_>, point: Vec3) -> f32 {
    let from_view = point - view.from_eye;
    let (from_eye_m, from_view_m) = (point.length(), from_view.length());
    let sine = point.cross(from_view).length() / (from_eye_m * from_view_m).max(f32::MIN_POSITIVE);
    let angle = if point.dot(from_view) > 0.0 { sine } else { 1.0 };
    let blur = (from_view_m / from_eye_m.max(f32::MIN_POSITIVE) - 1.0).max(0.0);
    1.0 / (angle + blur + ANGLE_EPSILON)
}

/// Returns the factor on a view's weight for its texels that are next to a nearer surface; `epsilon` is the ε of that weight.
fn edge_part(view: &ActiveView<'_>, (weight, epsilon): (f32, f32), penalty: f32) -> f32 {
    if view.has_edges() { 1.0 / (1.0 + penalty - penalty * epsilon * weight) } else { 1.0 }
}

/// True if the texel above, below, left or right of a texel has a surface with a larger inverse depth than this.
fn is_beside_nearer(face: &FaceTexels, texel: usize, inverse_depth: f32) -> bool {
    face.beside(texel).map(|at| face.inverse_depth[at]).any(|at| at != UNKNOWN && at > inverse_depth)
}

/// Returns the weight of a texel by its difference in depth, almost 0 beyond [`DEPTH_CUT`].
fn cut_weight(difference: f32) -> f32 {
    let weight = 1.0 / (difference + DEPTH_EPSILON);
    (weight - 1.0 / (DEPTH_CUT + DEPTH_EPSILON)).max(CUT_WEIGHT * weight)
}

/// Interpolates colour, coverage and alpha of a surface point that the eye sees. None if no view has a surface in its direction.
pub fn seen_from_eye(views: &ActiveViews<'_>, point: Vec3, settings: &RenderSettings) -> Option<Interpolated> {
    let (mut sum, mut opaque, mut covered, mut all) = (Sum::EMPTY, 0.0, 0.0, 0.0);
    let (refinements, tolerance) = (settings.refinements, settings.tolerance());
    for view in &views.views {
        let Some((face, at)) = image_of(view, view.local(point)) else { continue };
        let (of_view, epsilon) = match refinements.angles {
            true => (angle_weight(view, point), ANGLE_EPSILON),
            false => (view.camera_weight, CAMERA_EPSILON),
        };
        let edge_part = edge_part(view, (of_view, epsilon), EDGE_PENALTY);
        let taps = Taps::around(at.at, face);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            let inverse_depth = face.inverse_depth[texel];
            if inverse_depth == UNKNOWN {
                continue;
            }
            let weight = weight * of_view;
            if inverse_depth == BACKGROUND {
                all += weight;
                continue;
            }
            let nearer = (inverse_depth / at.inverse_depth).ln();
            if nearer <= tolerance {
                all += weight;
            }
            let difference = nearer.abs();
            if difference <= tolerance {
                covered += weight;
                opaque += weight * face.alpha(texel);
            }
            let fit = if refinements.angles { cut_weight(difference) } else { 1.0 / (difference + DEPTH_EPSILON) };
            let is_edge = edge_part < 1.0 && is_beside_nearer(face, texel, inverse_depth * NEARER);
            let weight = weight * fit * if is_edge { edge_part } else { 1.0 };
            sum.add(WeightedTexel { face, texel, weight, difference });
        }
    }
    let coverage = if all > 0.0 { covered / all } else { 1.0 };
    sum.mean().map(|mean| {
        let alpha = if covered > 0.0 { opaque / covered } else { mean.alpha };
        Interpolated { coverage, alpha, ..mean }
    })
}

/// Interpolates the colour of the background in a direction of length 1. None if surfaces hide it from all views.
pub fn background_color(views: &ActiveViews<'_>, direction: Vec3) -> Option<Interpolated> {
    let mut sum = Sum::EMPTY;
    for view in &views.views {
        let Some((face, at)) = image_of(view, view.probe_from_world * direction) else { continue };
        let (taps, of_view) = (Taps::around(at.at, face), view.camera_weight);
        let edge_part = edge_part(view, (of_view, CAMERA_EPSILON), BACKGROUND_EDGE_PENALTY);
        for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
            if face.inverse_depth[texel] == BACKGROUND {
                let is_edge = edge_part < 1.0 && is_beside_nearer(face, texel, BACKGROUND);
                let weight = weight * of_view * if is_edge { edge_part } else { 1.0 };
                sum.add(WeightedTexel { face, texel, weight, difference: 0.0 });
            }
        }
    }
    sum.mean()
}
