//! Rays and axis-aligned boxes, in metres.

use glam::DVec3;

/// A ray with a direction of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    origin: DVec3,
    direction: DVec3,
    /// 1 / direction, infinite where a component is 0; used by box tests.
    inverse: DVec3,
}

impl Ray {
    /// Creates a ray in a direction of any length. `None` if the length is 0, or the origin is not finite.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Ray> {
        let direction = direction.try_normalize()?;
        origin.is_finite().then_some(Ray::from_unit(origin, direction))
    }

    /// Creates a ray with a direction of length 1.
    pub(crate) fn from_unit(origin: DVec3, direction: DVec3) -> Ray {
        Ray { origin, direction, inverse: direction.recip() }
    }

    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Returns the direction, of length 1.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    pub fn at(&self, distance_m: f64) -> DVec3 {
        self.origin + distance_m * self.direction
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intersection {
    /// Metres along the ray.
    pub distance: f64,
    /// Normal of the surface, of length 1, pointing out of the solid.
    pub normal: DVec3,
}

/// An axis-aligned box, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBox {
    pub min: DVec3,
    pub max: DVec3,
}

impl AxisBox {
    /// Returns the smallest box around points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Option<AxisBox> {
        let alone = |point| AxisBox { min: point, max: point };
        points.into_iter().map(alone).reduce(AxisBox::join)
    }

    pub fn join(self, other: AxisBox) -> AxisBox {
        AxisBox { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if a point lies inside the box or on a face.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Returns the distance in metres from a point to the box; 0 inside.
    pub fn distance_m(&self, point: DVec3) -> f64 {
        point.distance(point.clamp(self.min, self.max))
    }

    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Returns the nearest surface point beyond `min_distance`, also for a ray from inside.
    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        let slabs = self.slabs(ray);
        let (enter, leave) = (slabs.enter(), slabs.leave());
        // Written so that a box or ray with NaN is a miss.
        let met = enter <= leave && leave > min_distance;
        if !met {
            return None;
        }
        let entering = enter > min_distance;
        let distance = if entering { enter } else { leave };
        let axis = if entering { slabs.enters.max_position() } else { slabs.leaves.min_position() };
        let mut normal = DVec3::ZERO;
        normal[axis] = if entering { -ray.direction[axis].signum() } else { ray.direction[axis].signum() };
        Some(Intersection { distance, normal })
    }

    /// Returns the distances at which a ray crosses the slabs. For a ray parallel to a slab they are −inf..+inf inside the slab
    /// and +inf..−inf outside; the product alone would be 0 · inf = NaN on the slab's own plane.
    pub(crate) fn slabs(&self, ray: &Ray) -> Slabs {
        let a = (self.min - ray.origin) * ray.inverse;
        let b = (self.max - ray.origin) * ray.inverse;
        let (mut enters, mut leaves) = (a.min(b), a.max(b));
        if ray.inverse.is_finite() {
            return Slabs { enters, leaves };
        }
        for axis in 0..3 {
            if !ray.inverse[axis].is_finite() {
                let inside = ray.origin[axis] >= self.min[axis] && ray.origin[axis] <= self.max[axis];
                (enters[axis], leaves[axis]) =
                    if inside { (f64::NEG_INFINITY, f64::INFINITY) } else { (f64::INFINITY, f64::NEG_INFINITY) };
            }
        }
        Slabs { enters, leaves }
    }
}

/// Distances at which a ray enters and leaves the slab of each axis, in metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slabs {
    pub enters: DVec3,
    pub leaves: DVec3,
}

impl Slabs {
    pub fn enter(&self) -> f64 {
        self.enters.max_element()
    }

    /// Returns the distance at which the ray leaves the box; less than [`Self::enter`] for a miss.
    pub fn leave(&self) -> f64 {
        self.leaves.min_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray::new(DVec3::from(origin), DVec3::from(direction)).unwrap()
    }

    const UNIT: AxisBox = AxisBox { min: DVec3::NEG_ONE, max: DVec3::ONE };

    #[test]
    fn a_box_around_points_contains_them_and_is_so_far_from_others() {
        assert_eq!(AxisBox::around([]), None);
        let points = [DVec3::new(1.0, 5.0, -3.0), DVec3::new(-1.0, 2.0, 0.0), DVec3::new(0.0, 3.0, 1.0)];
        let around = AxisBox::around(points).unwrap();
        assert_eq!((around.min, around.max), (DVec3::new(-1.0, 2.0, -3.0), DVec3::new(1.0, 5.0, 1.0)));
        assert!(points.iter().all(|&point| around.contains(point) && around.distance_m(point) == 0.0));
        for (outside, distance) in [(DVec3::new(4.0, 3.0, 5.0), 5.0), (DVec3::new(0.0, 1.0, 0.0), 1.0)] {
            assert!(!around.contains(outside) && around.distance_m(outside) == distance);
        }
        assert!(!around.contains(DVec3::NAN));
    }

    #[test]
    fn box_faces_axis_parallel_and_inside() {
        let hit = UNIT.intersect(&ray([0.3, 0.2, 4.0], [0.0, 0.0, -1.0]), 0.0).unwrap();
        assert_eq!((hit.distance, hit.normal), (3.0, DVec3::Z));
        let hit = UNIT.intersect(&ray([-4.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.0).unwrap();
        assert_eq!((hit.distance, hit.normal), (3.0, DVec3::NEG_X));
        let hit = UNIT.intersect(&ray([0.0; 3], [0.0, -1.0, 0.0]), 0.0).unwrap();
        assert_eq!((hit.distance, hit.normal), (1.0, DVec3::NEG_Y));
        // A ray parallel to a face grazes it in its plane and misses outside; no result is NaN.
        assert!(UNIT.intersect(&ray([1.0, 0.0, 4.0], [0.0, 0.0, -1.0]), 0.0).is_some());
        assert_eq!(UNIT.intersect(&ray([1.000_001, 0.0, 4.0], [0.0, 0.0, -1.0]), 0.0), None);
        assert_eq!(UNIT.intersect(&ray([0.0, 0.0, 4.0], [0.0, 0.0, 1.0]), 0.0), None);
    }

    #[test]
    fn bad_rays_are_refused() {
        assert_eq!(Ray::new(DVec3::ZERO, DVec3::ZERO), None);
        assert_eq!(Ray::new(DVec3::NAN, DVec3::X), None);
        assert_eq!(Ray::new(DVec3::ZERO, DVec3::NAN), None);
    }
}
