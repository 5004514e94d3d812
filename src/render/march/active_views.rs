//! Active views of a rendered image, with positions relative to its eye (CALF 6, 6.3).
//!
//! Positions are subtracted in double precision, so that images far from the world's origin lose no precision. All points are in
//! metres relative to the eye.
//!
//! The paper skips views that are too near a point, because their directions to it are unreliable. But no surface captured by a
//! probe is nearer than the probe's near plane, so a point within that distance is empty, regardless of the texels. Algorithm 4
//! treats a point that no view classifies as a surface, which would place a surface in front of any eye that is too near all
//! views. This implementation does not treat such a point as a surface.

use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};

use crate::march::{Counters, Pyramids, Ray, ViewPyramids};
use crate::views::{ColorCoding, LightField, Projected, UNKNOWN, View};

/// ε of the camera weight 1 / (d + ε), where d is the distance from the eye to the view, relative to that of the farthest active
/// view.
pub const CAMERA_EPSILON: f32 = 0.01;

/// Bilinear weight along one axis below which a texel does not belong to the footprint of a point. At the centre of a texel only
/// that texel counts, regardless of rounding in the position.
pub const NEGLIGIBLE_WEIGHT: f32 = 1.0 / 64.0;

/// A hit is disoccluded if the log distances of all texels differ from its own by more than this, in addition to the uncertainty
/// of the steps.
pub const HOLE_DIFFERENCE: f32 = 0.1;

/// Number of bisections in `ActiveViews::on_texels`.
pub const SETTLE_TIMES: u32 = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupancy {
    /// The point lies between the viewpoint and the surface that the view sees in this direction.
    Empty,
    /// The point lies on that surface or behind it.
    Occupied,
    /// The view has no depth in this direction.
    Unknown,
}

/// Texels that an occupancy test compares a point with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Footprint {
    /// The texel that contains the point (algorithm 4).
    #[default]
    Texel,
    /// Those of the four texels around the point that have a bilinear weight of at least [`NEGLIGIBLE_WEIGHT`] along each axis.
    /// The point is empty only if it is nearer than all of them.
    Around,
}

impl Footprint {
    /// Returns the half width of the footprint around a projected point, in texels. Texels that this interval touches belong to
    /// the footprint.
    pub fn reach(self) -> f32 {
        match self {
            Footprint::Texel => 0.0,
            Footprint::Around => 0.5 - NEGLIGIBLE_WEIGHT,
        }
    }
}

#[derive(Debug, Clone)]
pub struct ActiveView<'a> {
    pub view: &'a View,
    pub from_eye: Vec3,
    pub probe_from_world: Mat3,
    /// Weight w_cam of algorithm 4.
    pub camera_weight: f32,
    /// Result of [`ViewPyramids::greatest`], in 1/m.
    pub greatest_inverse_depth: f32,
    /// Maximum pyramids of its inverse depths; an empty pyramid proves no segment empty.
    pub pyramids: Arc<ViewPyramids>,
    pub footprint: Footprint,
}

impl<'a> ActiveView<'a> {
    pub fn new(view: &'a View, pyramids: Arc<ViewPyramids>, from_eye: Vec3) -> ActiveView<'a> {
        ActiveView {
            view,
            from_eye,
            probe_from_world: view.probe_from_world.as_mat3(),
            camera_weight: 1.0,
            greatest_inverse_depth: pyramids.greatest(view),
            pyramids,
            footprint: Footprint::Texel,
        }
    }

    /// Returns the vector from the viewpoint to a point, in the probe's axes.
    pub fn local(&self, point: Vec3) -> Vec3 {
        self.probe_from_world * (point - self.from_eye)
    }

    /// Returns the inverse planar depth of the texel that contains a point; [`UNKNOWN`] if the view has no image of that face.
    pub fn nearest_inverse_depth(&self, at: &Projected) -> f32 {
        let Some(face) = &self.view.faces[at.face] else { return UNKNOWN };
        let [column, row] = [0, 1].map(|axis| (at.at[axis].max(0.0) as u32).min(face.size[axis] - 1));
        face.inverse_depth[row as usize * face.size[0] as usize + column as usize]
    }

    /// Returns the maximum inverse planar depth of the footprint's texels; [`UNKNOWN`] if any of them is unknown.
    fn footprint_inverse_depth(&self, at: &Projected) -> f32 {
        match (self.footprint, &self.view.faces[at.face]) {
            (Footprint::Around, Some(face)) => {
                let ends = |axis: usize| {
                    let reach = self.footprint.reach();
                    [-reach, reach].map(|by| ((at.at[axis] + by).max(0.0) as u32).min(face.size[axis] - 1) as usize)
                };
                let of_row =
                    |row: usize| ends(0).map(|column| face.inverse_depth[row * face.size[0] as usize + column]);
                ends(1).map(of_row).as_flattened().iter().copied().fold(0.0, f32::max)
            }
            _ => self.nearest_inverse_depth(at),
        }
    }

    /// True if texels next to a nearer surface get a reduced weight: with [`Footprint::Around`], unless the eye is at the
    /// viewpoint.
    pub(crate) fn has_edges(&self) -> bool {
        self.footprint == Footprint::Around && self.from_eye != Vec3::ZERO
    }

    /// Classifies a point: BetweenViewpointAndGeometry (algorithm 4, line 1).
    pub fn occupancy(&self, point: Vec3) -> Occupancy {
        let local = self.local(point);
        let near = local.length_squared() < self.view.near_m * self.view.near_m;
        let Some(at) = self.view.project(local) else {
            // The viewpoint itself projects into no image; it is empty.
            let is_centre = near && local.length_squared() <= f32::MIN_POSITIVE;
            return if is_centre { Occupancy::Empty } else { Occupancy::Unknown };
        };
        let surface = self.footprint_inverse_depth(&at);
        if near || surface < at.inverse_depth {
            Occupancy::Empty
        } else if surface == UNKNOWN {
            Occupancy::Unknown
        } else {
            Occupancy::Occupied
        }
    }
}

/// Active views in order of priority.
#[derive(Debug, Clone)]
pub struct ActiveViews<'a> {
    pub views: Vec<ActiveView<'a>>,
    pub coding: ColorCoding,
}

impl<'a> ActiveViews<'a> {
    /// Selects the views with these indices, relative to an eye. Builds their pyramids; [`ActiveViews::with_pyramids`] reuses
    /// existing ones.
    pub fn new(field: &'a LightField, indices: &[usize], eye: DVec3) -> ActiveViews<'a> {
        Self::relative(field, indices, eye, |at| Arc::new(ViewPyramids::of(&field.views[at])))
    }

    /// Like [`ActiveViews::new`], with existing pyramids.
    pub fn with_pyramids(field: &'a LightField, pyramids: &Pyramids, indices: &[usize], eye: DVec3) -> ActiveViews<'a> {
        Self::relative(field, indices, eye, |at| pyramids.view(at))
    }

    fn relative(
        field: &'a LightField,
        indices: &[usize],
        eye: DVec3,
        pyramids: impl Fn(usize) -> Arc<ViewPyramids>,
    ) -> ActiveViews<'a> {
        let known = indices.iter().filter_map(|&at| Some((at, field.views.get(at)?)));
        let views = known.map(|(at, view)| ActiveView::new(view, pyramids(at), (view.position - eye).as_vec3()));
        let mut views: Vec<ActiveView<'_>> = views.collect();
        let farthest_m = views.iter().map(|view| view.from_eye.length()).fold(0.0, f32::max);
        if farthest_m > 0.0 {
            for view in &mut views {
                view.camera_weight = 1.0 / (view.from_eye.length() / farthest_m + CAMERA_EPSILON);
            }
        }
        ActiveViews { views, coding: field.coding }
    }

    /// Returns the same views with another footprint.
    pub fn with_footprint(&self, footprint: Footprint) -> ActiveViews<'a> {
        let view = |view: &ActiveView<'a>| ActiveView { footprint, ..view.clone() };
        ActiveViews { views: self.views.iter().map(view).collect(), coding: self.coding }
    }

    /// Returns the index of the view nearest to the eye, the first of equally near ones; none without views.
    pub fn nearest_number(&self) -> Option<usize> {
        let of = |at: &usize| self.views[*at].from_eye.length();
        (0..self.views.len()).min_by(|a, b| of(a).total_cmp(&of(b)))
    }

    /// Returns only the view nearest to the eye; none without views.
    pub fn nearest(&self) -> Option<ActiveViews<'a>> {
        let nearest = self.views[self.nearest_number()?].clone();
        Some(ActiveViews { views: vec![nearest], coding: self.coding })
    }

    /// True if a point is on or behind a surface: empty in no view, and occupied in at least one.
    pub fn is_surface(&self, point: Vec3) -> bool {
        let mut occupied = false;
        for view in &self.views {
            match view.occupancy(point) {
                Occupancy::Empty => return false,
                Occupancy::Occupied => occupied = true,
                Occupancy::Unknown => {}
            }
        }
        occupied
    }

    /// Bisects an interval, in metres, that contains the start of a surface. Returns the end of the last interval that is in the
    /// surface.
    pub fn refine(&self, ray: &Ray, interval_m: [f32; 2], times: u32, counters: &mut Counters) -> f32 {
        let [mut empty_m, mut surface_m] = interval_m;
        for _ in 0..times {
            let middle_m = 0.5 * (empty_m + surface_m);
            counters.refine_steps += 1;
            if self.is_surface(ray.at(middle_m)) {
                surface_m = middle_m;
            } else {
                empty_m = middle_m;
            }
        }
        surface_m
    }

    /// Moves a hit at `hit_m` metres along a ray from the eye to the surface of the texels that contain it, and returns its
    /// distance in metres. Hits found with [`Footprint::Around`] lie in front of that surface.
    pub(crate) fn on_texels(&self, ray: &Ray, hit_m: f32, counters: &mut Counters) -> f32 {
        let behind_m = hit_m * HOLE_DIFFERENCE.exp();
        counters.march_steps += 2;
        if self.is_surface(ray.at(hit_m)) || !self.is_surface(ray.at(behind_m)) {
            return hit_m;
        }
        self.refine(ray, [hit_m, behind_m], SETTLE_TIMES, counters)
    }

    /// Returns an upper bound on the distance of the surfaces of these views from the eye, in metres; 0 without views.
    pub fn far_m(&self) -> f32 {
        // In the corner of a cube face the distance is √3 times the planar depth; in a wide perspective image it is even larger.
        let reach_m = |view: &ActiveView<'_>| {
            let corner = view.view.faces.iter().flatten().flat_map(|face| {
                let [right, bottom] = face.size.map(|size| size - 1);
                [[0, 0], [right, 0], [0, bottom], [right, bottom]]
                    .map(|[column, row]| face.map.ray_length_factor(column, row))
            });
            view.from_eye.length() + view.view.far_m * corner.fold(1.0, f32::max)
        };
        self.views.iter().map(reach_m).fold(0.0, f32::max)
    }

    /// Returns the minimum distance of a surface from its own view, in metres; 1 without views.
    pub fn near_m(&self) -> f32 {
        self.views.iter().map(|view| view.view.near_m).reduce(f32::min).unwrap_or(1.0)
    }
}
