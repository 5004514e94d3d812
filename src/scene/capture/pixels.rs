//! Rays through the pixels of an image.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use half::f16;

use super::samples::SamplePattern;
use crate::image::ImageProjection;
use crate::mesh::{AxisBox, Ray};
use crate::scene::{Hit, SceneAtTime};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    pub position: DVec3,
    /// From the probe's axes to the world's.
    pub orientation: Option<DQuat>,
    /// In the probe's axes.
    pub projection: ImageProjection,
}

type BoxTest = Box<dyn Fn(&AxisBox) -> bool>;

/// Traces the rays of an image.
#[derive(Debug, Clone, Copy)]
pub struct PixelTracer<'a> {
    pub scene: &'a SceneAtTime,
    pub from: &'a Viewpoint,
    /// Forward, right and down in the world, of a flat image.
    axes: Option<[DVec3; 3]>,
}

impl Viewpoint {
    /// From the probe's axes to the world's.
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        self.orientation.map_or(direction, |turn| turn * direction)
    }
}

/// Radiance as half floats, clamped to the largest one, 65,504.
pub fn halves(light: DVec3) -> [f16; 3] {
    light.min(DVec3::splat(f16::MAX.to_f64())).to_array().map(f16::from_f64)
}

/// The mean radiance of a pixel's samples.
pub fn mean_light(samples: impl ExactSizeIterator<Item = DVec3>) -> [f16; 3] {
    let count = samples.len();
    halves(samples.fold(DVec3::ZERO, |sum, light| sum + light) / count as f64)
}

impl<'a> PixelTracer<'a> {
    /// Rows and columns that share a list of objects in view.
    pub const TILE: u32 = 16;

    pub fn new(scene: &'a SceneAtTime, from: &'a Viewpoint) -> PixelTracer<'a> {
        PixelTracer { scene, from, axes: from.projection.axes().map(|axes| axes.map(|axis| from.turned(axis))) }
    }

    /// What the ray through a position hits, among all meshes and the `candidates` of [`Self::in_view`].
    pub fn trace(&self, at: [f64; 2], candidates: &[usize]) -> Hit {
        self.scene.trace(&self.ray(at), candidates.iter().copied())
    }

    /// The mean radiance of a pixel, by its upper left corner.
    pub fn color(&self, [left, top]: [f64; 2], samples: &SamplePattern, candidates: &[usize]) -> [f16; 3] {
        mean_light(samples.points.iter().map(|[x, y]| self.trace([left + x, top + y], candidates).color))
    }

    /// The ray through a position in the image, in pixels; also beside a flat image.
    pub fn ray(&self, at: [f64; 2]) -> Ray {
        // Its length lies within f64's reach: 1 or more in flat images, and 1 in others.
        Ray::from_unit(self.from.position, self.from.turned(self.from.projection.unproject(at).normalize()))
    }

    /// Indices, in order, of the objects that positions between two corners of the image may see.
    pub fn in_view(&self, from: [f64; 2], to: [f64; 2]) -> Vec<usize> {
        let objects = &self.scene.objects;
        let outside = match self.axes {
            Some(axes) => self.outside_of_pyramid(axes, from, to),
            None => self.outside_of_cone(from, to),
        };
        (0..objects.len()).filter(|&index| !outside(&objects[index].bounds)).collect()
    }

    /// Whether a box is outside of one of the five planes of the pixels' pyramid.
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
            // The millionth of a metre is a margin for rounding.
            planes.iter().any(|normal| corners.iter().all(|corner| corner.dot(*normal) < -1e-6))
        })
    }

    /// Whether the sphere around a box is outside of a cone around the pixels of a panorama.
    fn outside_of_cone(&self, from: [f64; 2], to: [f64; 2]) -> BoxTest {
        let [width, height] = self.from.projection.size().map(f64::from);
        let [x, y] = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        // Along a meridian and then a parallel, which is an upper bound.
        let across = (to[0] - from[0]) / width * PI;
        let along = (to[1] - from[1]) / height * 0.5 * PI;
        let reach = across + along + 1e-6;
        let axis = self.from.turned(self.from.projection.unproject([x, y]));
        let position = self.from.position;
        Box::new(move |bounds| {
            let to_middle = 0.5 * (bounds.min + bounds.max) - position;
            let (distance, radius) = (to_middle.length(), 0.5 * (bounds.max - bounds.min).length());
            // Infinite boxes, and those around the camera, are in view: comparisons with NaN fail.
            distance > radius * 1.000_001 + 1e-6
                && axis.angle_between(to_middle) > reach + ((radius + 1e-6) / distance).min(1.0).asin()
        })
    }
}
