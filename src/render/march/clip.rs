//! Near and far clip planes of a camera.
//!
//! Takes a ray and returns the range of distances in which its surfaces are visible. A surface in front of the near plane is cut
//! away, and the ray continues behind it. Secondary rays are not clipped.

use glam::Vec3;

use crate::march::Ray;
use codec::math::Camera;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipPlanes {
    /// Optical axis, a unit vector.
    forward: Vec3,
    /// Metres along the axis.
    near_m: f32,
    /// Metres along the axis; may be `+inf`.
    far_m: f32,
}

impl ClipPlanes {
    /// Returns the planes of a camera; none if it does not limit the depth.
    pub fn of(camera: &Camera) -> Option<ClipPlanes> {
        let [near_m, far_m] = camera.depth_m().map(|metres| metres as f32);
        camera.has_range().then(|| ClipPlanes { forward: camera.axes()[0].as_vec3(), near_m, far_m })
    }

    /// True if a depth, in metres along the axis, lies between the planes, inclusive.
    pub fn contains(&self, depth_m: f32) -> bool {
        (self.near_m..=self.far_m).contains(&depth_m)
    }

    /// Returns the range of distances, in metres, in which a ray's surfaces are visible, inclusive.
    pub fn distances_m(&self, ray: &Ray) -> [f32; 2] {
        let cosine = ray.direction.dot(self.forward).max(f32::MIN_POSITIVE);
        [self.near_m / cosine, self.far_m / cosine]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::march::active_views::ActiveViews;
    use crate::march::ray::Steps;
    use crate::march::render::{Rendered, render, render_plainly};
    use crate::march::settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
    use crate::march::synthetic::{SyntheticProbe, room};
    use crate::march::tests::field;
    use crate::rendered_image::{BackgroundFill, HoleFill};
    use crate::views::light_field::ColorCoding;
    use codec::image::transfer::ToneMap;
    use codec::math::Lens;
    use codec::monitor::Silent;

    /// Renders 22 × 22 pixels along −Z from `eye` with a field of view of 90 degrees, from views of a room that ends at z = −2.
    fn picture(
        (places, eye): (&[DVec3], DVec3),
        pillar: f64,
        [near_m, far_m]: [f64; 2],
        acceleration: Acceleration,
    ) -> Rendered {
        let coding = ColorCoding::Codes(ToneMap::default());
        let view = |&at: &DVec3| {
            SyntheticProbe::new(at, 48).cube(coding, &|to| room(at, to, DVec3::new(3.0, 1.5, 2.0), pillar))
        };
        let light_field = field(places.iter().map(view).collect(), coding);
        let all: Vec<usize> = (0..places.len()).collect();
        let views = ActiveViews::new(&light_field, &all, eye);
        let lens = Lens { near_m, far_m, ..Lens::new(90.0) };
        let camera = Camera::look_at(eye, eye + DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        let settings = RenderSettings {
            size: [22; 2],
            steps: Steps::new(256, 0.01, views.far_m(), 8),
            samples: 1,
            holes: HoleFill::Blank,
            background: BackgroundFill::Opaque,
            specular: SpecularMode::None,
            max_bounces: 0,
            acceleration,
            refinements: Refinements::NONE,
        };
        let fast = render(&views, &camera, &settings, &Silent).unwrap();
        let plain = render_plainly(&views, &camera, &settings, &Silent).unwrap();
        assert_eq!((&fast.image.alpha, fast.counters), (&plain.image.alpha, plain.counters));
        fast
    }

    /// Returns which pixels of the middle row show a surface, and the number of such pixels in the image.
    fn seen(picture: &Rendered) -> (Vec<bool>, usize) {
        let is_seen = |alpha: &f32| *alpha == 1.0;
        let count = picture.image.alpha.data().iter().filter(|alpha| is_seen(alpha)).count();
        (picture.image.alpha.row(11).iter().map(is_seen).collect(), count)
    }

    #[test]
    fn planes_cut_by_depth_along_the_axis_and_not_by_distance() {
        let from = (&[DVec3::new(0.3, 0.1, 0.2), DVec3::new(-0.4, -0.2, 0.3)][..], DVec3::new(0.05, 0.02, 0.1));
        let all = picture(from, 0.0, [0.0, f64::INFINITY], Acceleration::Pyramid);
        assert_eq!(seen(&all).1, 22 * 22);
        for acceleration in [Acceleration::Pyramid, Acceleration::None] {
            // The far wall has a depth of 2.1 m everywhere, and a distance of 3 m at the corners of the image.
            let whole = picture(from, 0.0, [0.0, 2.2], acceleration);
            assert_eq!((&whole.image.color, &whole.image.alpha), (&all.image.color, &all.image.alpha));
            let without_wall = picture(from, 0.0, [0.0, 1.95], acceleration);
            assert!(seen(&without_wall).0.iter().all(|seen| !seen), "the wall is farther");
            assert!(seen(&without_wall).1 > 0, "floor and ceiling are nearer");
            // No view has seen the space below the floor.
            let wall_alone = picture(from, 0.0, [2.0, f64::INFINITY], acceleration);
            let (row, count) = seen(&wall_alone);
            assert!(row.iter().all(|seen| *seen) && count < 22 * 22, "{count}");
            assert_eq!(wall_alone.image.color.row(11), all.image.color.row(11));
            let nothing = picture(from, 0.0, [2.5, 3.0], acceleration);
            assert_eq!((seen(&nothing).1, nothing.counters.hole_rays), (0, 22 * 22));
        }
    }

    #[test]
    fn behind_a_surface_before_the_near_plane_shows_what_views_saw_there() {
        // A pillar from z = −0.4 to 0.4 in front of the eye, and views that see past it on both sides.
        let from = (&[DVec3::new(1.5, 0.0, 1.5), DVec3::new(-1.5, 0.1, 1.5)][..], DVec3::new(0.0, 0.0, 1.7));
        let middle = |pillar: f64, near_m: f64| {
            let picture = picture(from, pillar, [near_m, f64::INFINITY], Acceleration::Pyramid);
            (glam::Vec3::from(picture.image.color.row(11)[11]), picture.image.alpha.row(11)[11])
        };
        let (wall, alpha) = middle(0.0, 0.0);
        assert_eq!(alpha, 1.0);
        let (pillar, _) = middle(0.2, 0.0);
        assert!(pillar.distance(wall) > 0.1, "{pillar} {wall}");
        let (behind, alpha) = middle(0.2, 2.2);
        assert!(alpha == 1.0 && behind.distance(wall) < 0.06, "{behind} {wall}");
        // A near plane that cuts the pillar open does not show its inside.
        let (cut, alpha) = middle(0.2, 1.35);
        assert!(alpha == 1.0 && cut.distance(wall) < 0.06, "{cut} {wall}");
    }
}
