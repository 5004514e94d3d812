//! Intersection of rays with a sphere.

use glam::Vec3;

use crate::march::Ray;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// In metres relative to the eye.
    pub centre: Vec3,
    /// Metres, above 0.
    pub radius_m: f32,
}

impl Sphere {
    /// Returns the point where the line of a ray enters the sphere, which may be behind the ray's origin. None if the line misses
    /// the sphere.
    pub fn entry(&self, ray: &Ray) -> Option<Vec3> {
        let [along, squared] = self.chord(ray);
        (squared > 0.0).then(|| ray.at(-along - squared.sqrt()))
    }

    /// Returns the outward unit normal at a point on the sphere.
    pub fn normal(&self, point: Vec3) -> Option<Vec3> {
        (point - self.centre).try_normalize()
    }

    /// Returns the distance at which a ray leaves the sphere; none if the ray misses it.
    pub fn exit_m(&self, ray: &Ray) -> Option<f32> {
        let [along, squared] = self.chord(ray);
        let exit_m = squared.max(0.0).sqrt() - along;
        (squared >= 0.0 && exit_m > 0.0).then_some(exit_m)
    }

    /// Returns the distance along a ray from the middle of its chord to its origin, and the square of half the chord.
    fn chord(&self, ray: &Ray) -> [f32; 2] {
        let from_centre = ray.origin - self.centre;
        let along = ray.direction.dot(from_centre);
        [along, along * along - (from_centre.length_squared() - self.radius_m * self.radius_m)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_leave_spheres_ahead() {
        let sphere = Sphere { centre: Vec3::new(0.0, 0.0, -3.0), radius_m: 2.0 };
        let exit = |z: f32, direction: Vec3| sphere.exit_m(&Ray { origin: Vec3::new(0.0, 0.0, z), direction });
        // From the surface of the sphere, from inside, and from in front of it.
        assert_eq!(exit(-1.0, Vec3::NEG_Z), Some(4.0));
        assert_eq!(exit(-4.0, Vec3::NEG_Z), Some(1.0));
        assert_eq!(exit(-4.0, Vec3::Z), Some(3.0));
        assert_eq!(exit(0.0, Vec3::NEG_Z), Some(5.0));
        assert!((exit(-3.0, Vec3::X).unwrap() - 2.0).abs() < 1e-6);
        // Away from the sphere, from in front of it and from its surface, and past it.
        assert_eq!(exit(0.0, Vec3::Z), None);
        assert_eq!(exit(-1.0, Vec3::Z), None);
        assert_eq!(exit(0.0, Vec3::X), None);
    }
}
