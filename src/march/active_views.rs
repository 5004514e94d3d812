//! The views that take part in a picture, as one eye has them (CALF 6, 6.3).
//!
//! All lengths are relative to the eye: positions are subtracted in double precision, so that a light field far from the
//! origin of the world is as sharp as one around it.

use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};

use crate::march::counters::Counters;
use crate::march::pyramid::{Pyramids, ViewPyramids};
use crate::march::ray::Ray;
use crate::views::light_field::{ColorCoding, LightField, Projected, UNKNOWN, View};

/// What a view says of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// The point is between the viewpoint and the surface that it sees in this direction: empty space.
    Open,
    /// A surface lies before the point, or in it.
    Behind,
    /// The view knows nothing of this direction.
    Unknown,
}

/// A view, relative to the eye.
#[derive(Debug, Clone)]
pub struct ActiveView<'a> {
    /// Its texels.
    pub view: &'a View,
    /// Its centre, in metres from the eye along the world's axes.
    pub from_eye: Vec3,
    /// Turns directions of the world into those of its faces.
    pub probe_from_world: Mat3,
    /// [`ViewPyramids::greatest`].
    pub greatest_inverse_depth: f32,
    /// Pyramids above its inverse depths; an empty one proves nothing.
    pub pyramids: Arc<ViewPyramids>,
}

impl<'a> ActiveView<'a> {
    /// A view whose centre is at `from_eye`.
    pub fn new(view: &'a View, pyramids: Arc<ViewPyramids>, from_eye: Vec3) -> ActiveView<'a> {
        let probe_from_world = view.probe_from_world.as_mat3();
        ActiveView { view, from_eye, probe_from_world, greatest_inverse_depth: pyramids.greatest(view), pyramids }
    }

    /// The way from the viewpoint to a point, in the probe's axes; `point` is in metres from the eye.
    pub fn local(&self, point: Vec3) -> Vec3 {
        self.probe_from_world * (point - self.from_eye)
    }

    /// Inverse planar depth of the texel that a point falls into; [`UNKNOWN`] where there is none.
    pub fn nearest_inverse_depth(&self, at: &Projected) -> f32 {
        let Some(face) = &self.view.faces[at.face] else { return UNKNOWN };
        let [column, row] = [0, 1].map(|axis| (at.at[axis].max(0.0) as u32).min(face.size[axis] - 1));
        face.inverse_depth[row as usize * face.size[0] as usize + column as usize]
    }

    /// BetweenViewpointAndGeometry (algorithm 4, line 1), with a third answer where nothing is known.
    ///
    /// The paper leaves out views whose centre is too near to the point, as directions mean little there. But no surface
    /// of a probe is nearer than its near plane, so within that the answer is known without any direction: open.
    pub fn evidence(&self, point: Vec3) -> Evidence {
        let local = self.local(point);
        let near = local.length_squared() < self.view.near_m * self.view.near_m;
        let Some(at) = self.view.project(local) else {
            // The centre itself has no direction.
            return if near && local.length_squared() <= f32::MIN_POSITIVE {
                Evidence::Open
            } else {
                Evidence::Unknown
            };
        };
        let surface = self.nearest_inverse_depth(&at);
        // Within near it is so even where no texel was decoded.
        if near || surface < at.inverse_depth {
            Evidence::Open
        } else if surface == UNKNOWN {
            Evidence::Unknown
        } else {
            Evidence::Behind
        }
    }
}

/// The views that are asked, in the order of their priority.
#[derive(Debug, Clone)]
pub struct ActiveViews<'a> {
    /// The views.
    pub views: Vec<ActiveView<'a>>,
    /// What their colours are coded in.
    pub coding: ColorCoding,
}

impl<'a> ActiveViews<'a> {
    /// The views of these indices, relative to an eye. Builds their pyramids; [`ActiveViews::with_pyramids`] reuses them.
    pub fn new(field: &'a LightField, indices: &[usize], eye: DVec3) -> ActiveViews<'a> {
        Self::relative(field, indices, eye, |at| Arc::new(ViewPyramids::of(&field.views[at])))
    }

    /// The same with pyramids that were built before.
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
        ActiveViews { views: views.collect(), coding: field.coding }
    }

    /// Whether a surface is met at a point: no view sees past it, and at least one sees a surface before it.
    ///
    /// In algorithm 4 a point that no view was asked about is a surface, which would put one before any eye that all
    /// views are too near to. Here it is not.
    pub fn is_surface(&self, point: Vec3) -> bool {
        let mut behind = false;
        for view in &self.views {
            match view.evidence(point) {
                Evidence::Open => return false,
                Evidence::Behind => behind = true,
                Evidence::Unknown => {}
            }
        }
        behind
    }

    /// Halves the interval in which a surface begins; returns its end that is in the surface.
    pub fn refine(&self, ray: &Ray, interval_m: [f32; 2], times: u32, counters: &mut Counters) -> f32 {
        let [mut open_m, mut surface_m] = interval_m;
        for _ in 0..times {
            let middle_m = 0.5 * (open_m + surface_m);
            counters.refine_steps += 1;
            if self.is_surface(ray.at(middle_m)) {
                surface_m = middle_m;
            } else {
                open_m = middle_m;
            }
        }
        surface_m
    }

    /// The farthest that a surface of these views can be from the eye, in metres; 0 without views.
    pub fn far_m(&self) -> f32 {
        // Planar depths reach √3 times as far in the corner of a face, and farther in a wide perspective image.
        let reach = |view: &ActiveView<'_>| {
            let corner = view.view.faces.iter().flatten().flat_map(|face| {
                let [right, bottom] = face.size.map(|size| size - 1);
                [[0, 0], [right, 0], [0, bottom], [right, bottom]]
                    .map(|[column, row]| face.map.ray_length_factor(column, row))
            });
            view.from_eye.length() + view.view.far_m * corner.fold(1.0, f32::max)
        };
        self.views.iter().map(reach).fold(0.0, f32::max)
    }

    /// The nearest that a surface of these views is to its own view, in metres; 1 without views.
    pub fn near_m(&self) -> f32 {
        self.views.iter().map(|view| view.view.near_m).reduce(f32::min).unwrap_or(1.0)
    }
}
