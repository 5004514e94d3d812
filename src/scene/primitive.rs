//! Analytic shapes and their intersections with rays, in f64: errors are far below one 16-bit depth code.

use glam::{DVec2, DVec3};

use crate::mesh::{AxisBox, Intersection, Ray};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub center: DVec3,
    /// Metres, above 0.
    pub radius: f64,
}

impl Sphere {
    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        let to_center = self.center - ray.origin();
        let closest = to_center.dot(ray.direction());
        // Computed from the offset, because b² − c cancels for small distant spheres.
        let offset = to_center - closest * ray.direction();
        let inside = self.radius * self.radius - offset.length_squared();
        if inside < 0.0 {
            return None;
        }
        let half = inside.sqrt();
        // Squares of large distances are infinite.
        let ahead = |distance: &f64| *distance > min_distance && distance.is_finite();
        let distance = [closest - half, closest + half].into_iter().find(ahead)?;
        Some(Intersection { distance, normal: (ray.at(distance) - self.center) / self.radius })
    }
}

/// A box rotated about the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnedBox {
    pub center: DVec3,
    /// Half the length of each edge, metres.
    pub half: DVec3,
    /// Cosine and sine of the rotation about +Y (from +Z towards +X).
    pub turn: DVec2,
}

impl TurnedBox {
    pub fn to_local(self, v: DVec3) -> DVec3 {
        let (cos, sin) = (self.turn.x, self.turn.y);
        DVec3::new(cos * v.x - sin * v.z, v.y, sin * v.x + cos * v.z)
    }

    pub fn to_world(self, v: DVec3) -> DVec3 {
        let (cos, sin) = (self.turn.x, self.turn.y);
        DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x)
    }

    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        let local = Ray::from_unit(self.to_local(ray.origin() - self.center), self.to_local(ray.direction()));
        let hit = AxisBox { min: -self.half, max: self.half }.intersect(&local, min_distance)?;
        Some(Intersection { distance: hit.distance, normal: self.to_world(hit.normal) })
    }
}

/// A flat rectangle, visible from both sides; its normal is that of `u × v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quad {
    pub corner: DVec3,
    /// Edge from the corner, metres.
    pub u: DVec3,
    /// The other edge, perpendicular to `u`.
    pub v: DVec3,
}

impl Quad {
    /// Returns the intersection if it is beyond `min_distance`. A ray in the plane misses.
    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        let across = self.u.cross(self.v);
        let slope = across.dot(ray.direction());
        if slope == 0.0 {
            return None;
        }
        let distance = across.dot(self.corner - ray.origin()) / slope;
        if distance <= min_distance || !distance.is_finite() {
            return None;
        }
        let inside = |edge: DVec3| {
            let along = (ray.at(distance) - self.corner).dot(edge);
            along >= 0.0 && along <= edge.length_squared()
        };
        // A rectangle without area has no normal and cannot be hit.
        let normal = across.try_normalize()?;
        (inside(self.u) && inside(self.v)).then_some(Intersection { distance, normal })
    }
}

/// A row of equal thin posts along +X, joined by rails; difficult for a depth codec.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fence {
    /// Foot of the first post's centre, metres.
    pub foot: DVec3,
    /// At least 1.
    pub posts: u32,
    /// Distance between the centres of posts, metres, above `width`.
    pub spacing: f64,
    /// Width of a post in x and z, metres.
    pub width: f64,
    pub height: f64,
    /// Heights of the centres of the rails above the foot, metres; rails are as thick as posts.
    pub rails: [f64; 2],
}

impl Fence {
    pub fn bounds(&self) -> AxisBox {
        let half = 0.5 * self.width;
        let length = f64::from(self.posts.saturating_sub(1)) * self.spacing;
        AxisBox {
            min: self.foot - DVec3::new(half, 0.0, half),
            max: self.foot + DVec3::new(length + half, self.height, half),
        }
    }

    /// Returns the rail centred at a height above the foot, metres.
    pub fn rail(&self, height: f64) -> AxisBox {
        let (AxisBox { min, max }, y, half) = (self.bounds(), self.foot.y + height, 0.5 * self.width);
        AxisBox { min: DVec3::new(min.x, y - half, min.z), max: DVec3::new(max.x, y + half, max.z) }
    }

    pub fn post(&self, number: u32) -> AxisBox {
        let (foot, half) = (self.foot + DVec3::X * (f64::from(number) * self.spacing), 0.5 * self.width);
        AxisBox { min: foot - DVec3::new(half, 0.0, half), max: foot + DVec3::new(half, self.height, half) }
    }

    /// Returns the nearest intersection beyond `min_distance`. Only posts near the ray are tested.
    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        let slabs = self.bounds().slabs(ray);
        let (enter, leave) = (slabs.enter().max(min_distance), slabs.leave());
        if enter > leave || self.posts == 0 {
            return None;
        }
        let mut best: Option<Intersection> = None;
        let mut offer = |solid: AxisBox| {
            if let Some(hit) = solid.intersect(ray, min_distance)
                && best.is_none_or(|best| hit.distance < best.distance)
            {
                best = Some(hit);
            }
        };
        self.rails.into_iter().for_each(|rail| offer(self.rail(rail)));
        let post_at = |x: f64| (x - self.foot.x) / self.spacing;
        let ends = [ray.at(enter).x, ray.at(leave).x];
        // Half a post and a margin for rounding.
        let reach = 0.5 * self.width + 1e-9;
        // The casts saturate, and the indices are clamped to existing posts.
        let first = (post_at(ends[0].min(ends[1]) - reach).ceil() as u32).min(self.posts - 1);
        let last = (post_at(ends[0].max(ends[1]) + reach).floor() as u32).min(self.posts - 1);
        (first..=last).for_each(|post| offer(self.post(post)));
        best
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    Sphere(Sphere),
    AxisBox(AxisBox),
    TurnedBox(TurnedBox),
    Quad(Quad),
    Fence(Fence),
}

impl Shape {
    /// Returns the nearest intersection beyond `min_distance` metres.
    pub fn intersect(&self, ray: &Ray, min_distance: f64) -> Option<Intersection> {
        match self {
            Shape::Sphere(shape) => shape.intersect(ray, min_distance),
            Shape::AxisBox(shape) => shape.intersect(ray, min_distance),
            Shape::TurnedBox(shape) => shape.intersect(ray, min_distance),
            Shape::Quad(shape) => shape.intersect(ray, min_distance),
            Shape::Fence(shape) => shape.intersect(ray, min_distance),
        }
    }

    /// Returns a box that contains the shape (not always the smallest).
    pub fn bounding_box(&self) -> AxisBox {
        let around = |center: DVec3, half: DVec3| AxisBox { min: center - half, max: center + half };
        match self {
            Shape::Sphere(shape) => around(shape.center, DVec3::splat(shape.radius)),
            Shape::AxisBox(shape) => *shape,
            Shape::TurnedBox(shape) => {
                let reach = shape.half.x.hypot(shape.half.z);
                around(shape.center, DVec3::new(reach, shape.half.y, reach))
            }
            Shape::Quad(shape) => {
                let half = 0.5 * (shape.u.abs() + shape.v.abs());
                around(shape.corner + 0.5 * (shape.u + shape.v), half)
            }
            Shape::Fence(shape) => shape.bounds(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray::new(DVec3::from(origin), DVec3::from(direction)).unwrap()
    }

    #[test]
    fn sphere_from_outside_inside_and_beside() {
        let ball = Sphere { center: DVec3::new(0.0, 0.0, -5.0), radius: 2.0 };
        let hit = ball.intersect(&ray([0.0; 3], [0.0, 0.0, -3.0]), 0.0).unwrap();
        assert_eq!((hit.distance, hit.normal), (3.0, DVec3::Z));
        let hit = ball.intersect(&ray([0.0, 0.0, -5.0], [0.0, 1.0, 0.0]), 0.0).unwrap();
        assert_eq!((hit.distance, hit.normal), (2.0, DVec3::Y));
        assert_eq!(ball.intersect(&ray([0.0, 2.1, 0.0], [0.0, 0.0, -1.0]), 0.0), None);
        assert_eq!(ball.intersect(&ray([0.0; 3], [0.0, 0.0, 1.0]), 0.0), None);
        // A sphere of 1 mm radius at a distance of 1 km is still hit.
        let speck = Sphere { center: DVec3::new(1000.0, 0.0, 0.0), radius: 0.001 };
        let hit = speck.intersect(&ray([0.0; 3], [1.0, 0.0, 0.0]), 0.0).unwrap();
        assert!((hit.distance - 999.999).abs() < 1e-9);
    }

    #[test]
    fn a_surface_does_not_hit_itself() {
        let ball = Sphere { center: DVec3::new(0.3, -0.2, 0.1), radius: 0.7 };
        for i in 0..500 {
            let angle = f64::from(i) * 0.37;
            let from = ray([5.0 * angle.cos(), 0.3, 5.0 * angle.sin()], [-angle.cos(), -0.07, -angle.sin()]);
            let hit = ball.intersect(&from, 0.0).unwrap();
            let away = Ray::new(from.at(hit.distance) + 1e-6 * hit.normal, hit.normal).unwrap();
            assert_eq!(ball.intersect(&away, 0.0), None);
        }
    }

    #[test]
    fn turned_box_is_the_box_turned() {
        let (sin, cos) = std::f64::consts::FRAC_PI_4.sin_cos();
        let turned = TurnedBox { center: DVec3::ZERO, half: DVec3::ONE, turn: DVec2::new(cos, sin) };
        // An edge points at the camera: √2 from the centre.
        let hit = turned.intersect(&ray([0.001, 0.0, 5.0], [0.0, 0.0, -1.0]), 0.0).unwrap();
        assert!((hit.distance - (5.0 - 2.0_f64.sqrt() + 0.001)).abs() < 1e-9, "{}", hit.distance);
        assert!((hit.normal - DVec3::new(cos, 0.0, sin)).length() < 1e-12);
        let v = DVec3::new(0.2, 0.4, -0.9);
        assert!((turned.to_world(turned.to_local(v)) - v).length() < 1e-15);
    }

    #[test]
    fn quad_ends_at_its_edges() {
        let floor = Quad { corner: DVec3::ZERO, u: DVec3::Z * 2.0, v: DVec3::X * 4.0 };
        let down = |x: f64, z: f64| floor.intersect(&ray([x, 3.0, z], [0.0, -1.0, 0.0]), 0.0);
        assert_eq!(down(3.9, 1.9), Some(Intersection { distance: 3.0, normal: DVec3::Y }));
        assert_eq!(down(4.1, 1.0), None);
        assert_eq!(down(-0.1, 1.0), None);
        assert_eq!(floor.intersect(&ray([-1.0, 0.0, 1.0], [1.0, 0.0, 0.0]), 0.0), None);
    }

    #[test]
    fn fence_equals_its_parts() {
        let fence = Fence {
            foot: DVec3::new(-1.0, 0.0, 1.0),
            posts: 11,
            spacing: 0.2,
            width: 0.02,
            height: 1.0,
            rails: [0.2, 0.8],
        };
        let mut parts = vec![];
        for post in 0..11 {
            let foot = fence.foot + DVec3::X * 0.2 * f64::from(post);
            parts.push(AxisBox { min: foot - DVec3::new(0.01, 0.0, 0.01), max: foot + DVec3::new(0.01, 1.0, 0.01) });
        }
        for rail in fence.rails {
            parts.push(AxisBox { min: DVec3::new(-1.01, rail - 0.01, 0.99), max: DVec3::new(1.01, rail + 0.01, 1.01) });
        }
        let mut hits = 0;
        for i in 0..20_000_u32 {
            let (a, b) = (f64::from(i) * 0.618_034 % 1.0, f64::from(i) * 0.754_878 % 1.0);
            // From the side, from the end and from between the posts.
            let origin = [[0.1, 0.5, 0.0], [-3.0, 0.4, 0.9], [0.11, 0.5, 1.0]][i as usize % 3];
            let from = ray(origin, [a * 4.0 - 2.0, b - 0.5, 1.0 - 2.0 * f64::from(i % 2)]);
            let nearest = parts
                .iter()
                .filter_map(|part| part.intersect(&from, 0.0))
                .map(|hit| hit.distance)
                .fold(f64::INFINITY, f64::min);
            let found = fence.intersect(&from, 0.0).map_or(f64::INFINITY, |hit| hit.distance);
            assert!(found == nearest || (found - nearest).abs() < 1e-9, "{i}: {found} {nearest}");
            hits += u32::from(found.is_finite());
        }
        assert!(hits > 300, "{hits}");
    }

    #[test]
    fn bounding_boxes_contain_every_hit() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let shapes = [
            Shape::Sphere(Sphere { center: DVec3::ONE, radius: 0.8 }),
            Shape::TurnedBox(TurnedBox {
                center: DVec3::X,
                half: DVec3::new(0.2, 0.5, 1.0),
                turn: DVec2::new(cos, sin),
            }),
            Shape::Quad(Quad { corner: DVec3::NEG_ONE, u: DVec3::new(1.0, 0.0, 1.0), v: DVec3::Y * 2.0 }),
        ];
        for shape in shapes {
            let bounds = shape.bounding_box();
            let middle = 0.5 * (bounds.min + bounds.max);
            let mut hits = 0;
            for i in 0..2000_u32 {
                let angle = f64::from(i) * 2.4;
                let side = DVec3::new(angle.cos(), 1.0 - f64::from(i) / 1000.0, angle.sin());
                let target = middle + 0.9 * DVec3::new((angle * 1.7).sin(), (angle * 2.3).sin(), (angle * 3.1).sin());
                let from = Ray::new(middle + 6.0 * side, target - middle - 6.0 * side).unwrap();
                if let Some(hit) = shape.intersect(&from, 0.0) {
                    let point = from.at(hit.distance);
                    let outside = (bounds.min - point).max(point - bounds.max).max_element();
                    assert!(outside < 1e-9, "{shape:?}: {point}");
                    hits += 1;
                }
            }
            assert!(hits > 100, "{shape:?}: {hits}");
        }
    }
}
