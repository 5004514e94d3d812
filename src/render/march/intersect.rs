//! Intersection of a ray with the captured surfaces: RayIntersection of algorithm 4 (CALF 6), point by point or over segments.
//!
//! Takes active views and a ray. Returns the distance at which the ray first meets a surface, if it meets one.

use crate::march::{Acceleration, ActiveViews, Counters, Occupancy, Ray, Steps, StepsFrom, Until, segments};

/// Returns the distance in metres at which a ray first meets a surface. Both accelerations return the same bits.
pub fn intersect(
    how: Acceleration,
    views: &ActiveViews<'_>,
    ray: &Ray,
    steps: &Steps,
    counters: &mut Counters,
) -> Option<f32> {
    intersect_from(how, views, ray, StepsFrom { steps, first: 0 }, counters)
}

/// Like [`intersect`], from a given step on: nearer points count as empty.
pub fn intersect_from(
    how: Acceleration,
    views: &ActiveViews<'_>,
    ray: &Ray,
    steps: StepsFrom<'_>,
    counters: &mut Counters,
) -> Option<f32> {
    let step = first_step(how, views, (ray, steps), Until::Surface, counters)?;
    Some(views.refine(ray, steps.steps.before(step), steps.steps.refine(), counters))
}

/// Returns the index of the first step at which marching along a ray ends.
pub(crate) fn first_step(
    how: Acceleration,
    views: &ActiveViews<'_>,
    (ray, steps): (&Ray, StepsFrom<'_>),
    until: Until,
    counters: &mut Counters,
) -> Option<usize> {
    if how == Acceleration::Pyramid {
        return segments::first_step(views, ray, steps, until, counters);
    }
    (steps.first..steps.steps.distances_m.len()).find(|&step| {
        counters.march_steps += 1;
        let point = ray.at(steps.steps.distances_m[step]);
        match until {
            Until::Surface => views.is_surface(point),
            Until::Unknown => views.views.iter().all(|view| view.occupancy(point) != Occupancy::Empty),
        }
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::march::render::render;
    use crate::march::settings::{Refinements, RenderSettings, SpecularMode};
    use crate::march::synthetic::{SyntheticProbe, room};
    use crate::march::tests::field;
    use crate::rendered_image::{BackgroundFill, HoleFill};
    use crate::views::light_field::ColorCoding;
    use codec::image::transfer::ToneMap;
    use codec::math::{Camera, Lens};
    use codec::monitor::Silent;

    #[test]
    fn few_steps_make_no_holes_however_they_are_refined() {
        let coding = ColorCoding::Codes(ToneMap::default());
        let places = [DVec3::new(0.3, 0.1, -0.2), DVec3::new(-0.4, -0.2, 0.3)];
        let view =
            |at: DVec3| SyntheticProbe::new(at, 32).cube(coding, &|to| room(at, to, DVec3::new(3.0, 1.5, 2.0), 0.0));
        let light_field = field(places.map(view).to_vec(), coding);
        let eye = DVec3::new(0.11, 0.07, 0.02);
        let views = ActiveViews::new(&light_field, &[0, 1], eye);
        let camera = Camera::look_at(eye, eye + DVec3::new(0.3, 0.2, -1.0), DVec3::Y, Lens::new(90.0)).unwrap();
        for refine in 0..9 {
            let settings = RenderSettings {
                size: [24; 2],
                steps: Steps::new(16, 0.01, views.far_m(), refine),
                samples: 1,
                holes: HoleFill::Blank,
                background: BackgroundFill::Opaque,
                specular: SpecularMode::None,
                max_bounces: 0,
                acceleration: Acceleration::Pyramid,
                refinements: Refinements::NONE,
            };
            let picture = render(&views, &camera, &settings, &Silent).unwrap();
            assert_eq!(picture.counters.hole_rays, 0, "refined {refine} times");
        }
    }
}
