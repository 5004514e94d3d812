//! Rays through the pixels of an image.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use half::f16;

use super::samples::SamplePattern;
use crate::mesh::{AxisBox, Ray};
use crate::{Hit, SceneAtTime};
use codec::image::ImageProjection;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    pub position: DVec3,
    /// Rotation from probe axes to world axes.
    pub orientation: Option<DQuat>,
    /// Projection in probe axes.
    pub projection: ImageProjection,
}

pub(super) type BoxTest = Box<dyn Fn(&AxisBox) -> bool>;

/// Traces the rays of an image.
#[derive(Debug, Clone, Copy)]
pub struct PixelTracer<'a> {
    pub scene: &'a SceneAtTime,
    pub from: &'a Viewpoint,
    /// Forward, right and down in world axes; `None` for a panorama.
    axes: Option<[DVec3; 3]>,
}

impl Viewpoint {
    /// Rotates a direction from probe axes to world axes.
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        self.orientation.map_or(direction, |turn| turn * direction)
    }
}

/// Converts radiance to half floats, clamped to the largest finite one, 65,504.
pub fn halves(light: DVec3) -> [f16; 3] {
    light.min(DVec3::splat(f16::MAX.to_f64())).to_array().map(f16::from_f64)
}

/// Returns the mean radiance of a pixel's samples.
pub fn mean_light(samples: impl ExactSizeIterator<Item = DVec3>) -> [f16; 3] {
    let count = samples.len();
    halves(samples.fold(DVec3::ZERO, |sum, light| sum + light) / count as f64)
}

impl<'a> PixelTracer<'a> {
    /// Width and height of the pixel tiles that share a list of candidate objects.
    pub const TILE: u32 = 16;

    pub fn new(scene: &'a SceneAtTime, from: &'a Viewpoint) -> PixelTracer<'a> {
        PixelTracer { scene, from, axes: from.projection.axes().map(|axes| axes.map(|axis| from.turned(axis))) }
    }

    /// Traces the ray through a position in the image, against all meshes and the `candidates` from [`Self::in_view`].
    pub fn trace(&self, at: [f64; 2], candidates: &[usize]) -> Hit {
        self.scene.trace(&self.ray(at), candidates.iter().copied())
    }

    /// Returns the mean radiance of the pixel with this upper left corner.
    pub fn color(&self, [left, top]: [f64; 2], samples: &SamplePattern, candidates: &[usize]) -> [f16; 3] {
        mean_light(samples.points.iter().map(|[x, y]| self.trace([left + x, top + y], candidates).color))
    }

    /// Returns the ray through a position in the image, in pixels. Positions outside a flat image are allowed.
    pub fn ray(&self, at: [f64; 2]) -> Ray {
        // Normalising is safe: the vector has length 1 in panoramas, and 1 or more in flat images.
        Ray::from_unit(self.from.position, self.from.turned(self.from.projection.unproject(at).normalize()))
    }

    /// Returns the indices, in order, of the objects that may be visible in a rectangle of the image, given by two corners.
    pub fn in_view(&self, from: [f64; 2], to: [f64; 2]) -> Vec<usize> {
        self.inside(&self.outside(from, to))
    }

    /// Returns the indices, in order, of the objects that a test does not exclude.
    pub(super) fn inside(&self, outside: &BoxTest) -> Vec<usize> {
        let objects = &self.scene.objects;
        (0..objects.len()).filter(|&index| !outside(&objects[index].bounds)).collect()
    }

    /// Returns a test that is true only for boxes that no ray through a rectangle of the image meets.
    pub(super) fn outside(&self, from: [f64; 2], to: [f64; 2]) -> BoxTest {
        match self.axes {
            Some(axes) => self.outside_of_pyramid(axes, from, to),
            None => self.outside_of_cone(from, to),
        }
    }

    /// Returns a test that is true for boxes entirely outside one of the five planes of the rectangle's pyramid.
    fn outside_of_pyramid(&self, axes: [DVec3; 3], from: [f64; 2], to: [f64; 2]) -> BoxTest {
        let [forward, right, down] = axes;
        let plane = |at: [f64; 2]| self.from.projection.plane(at);
        let ([left, top], [beyond, below]) = (plane(from), plane(to));
        // Inward normals of planes through the camera.
        let planes =
            [forward, right - left * forward, beyond * forward - right, down - top * forward, below * forward - down];
        let position = self.from.position;
        Box::new(move |bounds| {
            let corners = bounds.corners().map(|corner| corner - position);
            // A margin of 1e-6 m for rounding.
            planes.iter().any(|normal| corners.iter().all(|corner| corner.dot(*normal) < -1e-6))
        })
    }

    /// Returns a test that is true for boxes whose bounding sphere is outside a cone around a rectangle of a panorama.
    fn outside_of_cone(&self, from: [f64; 2], to: [f64; 2]) -> BoxTest {
        let [width, height] = self.from.projection.size().map(f64::from);
        let [x, y] = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        // Path along a meridian and then a parallel: an upper bound of the angle.
        let across = (to[0] - from[0]) / width * PI;
        let along = (to[1] - from[1]) / height * 0.5 * PI;
        let reach = across + along + 1e-6;
        let axis = self.from.turned(self.from.projection.unproject([x, y]));
        let position = self.from.position;
        Box::new(move |bounds| {
            let to_middle = 0.5 * (bounds.min + bounds.max) - position;
            let (distance, radius) = (to_middle.length(), 0.5 * (bounds.max - bounds.min).length());
            // Infinite boxes, and boxes around the camera, count as visible: comparisons with NaN are false.
            distance > radius * 1.000_001 + 1e-6
                && axis.angle_between(to_middle) > reach + ((radius + 1e-6) / distance).min(1.0).asin()
        })
    }
}
