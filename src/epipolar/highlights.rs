//! Highlights along the line of eyes, as piecewise linear functions between splits (Epipolar 3.5, 7.3).
//!
//! Only the eye moves from the first view to the last. Splits are placed at both ends, then where the mirror direction of each
//! light comes closest to the line of eyes, and then where linear interpolation has the largest error, up to a limit.
//!
//! Listing 3.16 of the thesis divides by 0 if the best position is the first view, and if there is one split. Listing 3.17
//! follows the line of eyes from right to left, and uses the left point of a quad for its right one. Radiance is computed by the
//! scene's own shading, not by listing 3.14 and equation 3.4, which lack the exponent.

use glam::DVec3;

use super::views::OutputViews;
use scene::shading::Gloss;

/// Default maximum number of splits of a line, not counting its ends.
pub const DEFAULT_SPLITS: usize = 8;
/// Tolerated radiance error of linear interpolation: half of the smallest step of 8-bit codes.
const ERROR_TOLERANCE: f64 = 0.5 / 255.0 / 12.92;

/// Position from 0 at the first view to 1 at the last, and the radiance towards it.
type Split = (f64, DVec3);

/// Radiance of a highlight along the line of eyes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Highlight {
    /// See [`Self::places`].
    splits: Vec<(f64, DVec3)>,
}

/// Line from the eye of the first view to that of the last.
#[derive(Debug, Clone, Copy)]
pub struct EyeLine {
    first: DVec3,
    along: DVec3,
}

impl EyeLine {
    pub fn new(views: &OutputViews) -> EyeLine {
        let ends = [views.offsets_m.first(), views.offsets_m.last()];
        let [first, last] = ends.map(|offset_m| views.eye(offset_m.copied().unwrap_or(0.0)));
        EyeLine { first, along: last - first }
    }

    /// Returns the position, 0 to 1, at which the angle between a direction from a point and the eye is smallest.
    ///
    /// With `a` from the point to the first eye, `b` along the line and `r` the direction, the cosine r·(a + t b)/|a + t b| is
    /// stationary at t = ((r·a)(a·b) − (r·b)|a|²) / ((r·b)(a·b) − (r·a)|b|²). (Listing 3.15 intersects two lines instead, which
    /// hardly ever meet.)
    pub fn best_place(&self, point: DVec3, direction: DVec3) -> f64 {
        let (a, b) = (self.first - point, self.along);
        let cosine = |place: f64| (a + place * b).normalize_or_zero().dot(direction);
        let (ra, rb, ab) = (direction.dot(a), direction.dot(b), a.dot(b));
        let place = (ra * ab - rb * a.length_squared()) / (rb * ab - ra * b.length_squared());
        let inside = Some(place).filter(|place| *place > 0.0 && *place < 1.0);
        let ends = [0.0, 1.0].into_iter();
        ends.chain(inside).max_by(|a, b| cosine(*a).total_cmp(&cosine(*b))).unwrap_or(0.0)
    }

    fn eye(&self, place: f64) -> DVec3 {
        self.first + place * self.along
    }
}

impl Highlight {
    /// Computes the highlight of a surface with at most `limit` splits between the ends. Splits are placed at the best positions
    /// of its lights, those first whose radiance is farthest above linear interpolation between the ends. Further splits halve
    /// the interval with the largest interpolation error.
    pub fn new(gloss: &Gloss, eyes: &EyeLine, limit: usize) -> Highlight {
        let at = |place: f64| (place, gloss.towards(eyes.eye(place)));
        let first = at(0.0);
        if eyes.along == DVec3::ZERO {
            return Highlight { splits: vec![first] };
        }
        let last = at(1.0);
        let places = gloss.mirrored().map(|direction| eyes.best_place(gloss.point, direction));
        let mut best: Vec<Split> = places.filter(|place| *place > 0.0 && *place < 1.0).map(at).collect();
        let above_chord = |split: &Split| (split.1 - first.1.lerp(last.1, split.0)).max_element();
        best.sort_by(|a, b| above_chord(b).total_cmp(&above_chord(a)).then(a.0.total_cmp(&b.0)));
        best.dedup_by_key(|split| split.0);
        best.truncate(limit);
        best.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut splits = [vec![first], best, vec![last]].concat();
        // Returns the split in the middle of an interval, and the interpolation error at its position.
        let probe = |pair: &[Split]| {
            let middle = at(0.5 * (pair[0].0 + pair[1].0));
            (middle, (middle.1 - 0.5 * (pair[0].1 + pair[1].1)).abs().max_element())
        };
        let has_more = splits.len() < limit + 2;
        let mut probes: Vec<(Split, f64)> = if has_more { splits.windows(2).map(probe).collect() } else { Vec::new() };
        while splits.len() < limit + 2 {
            let worst = probes.iter().enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1));
            let Some((before, &(split, _))) = worst.filter(|(_, (_, error))| *error > ERROR_TOLERANCE) else { break };
            splits.insert(before + 1, split);
            probes[before] = probe(&splits[before..before + 2]);
            probes.insert(before + 1, probe(&splits[before + 1..before + 3]));
        }
        Highlight { splits }
    }

    /// Returns the number of splits, including the ends.
    pub fn splits(&self) -> usize {
        self.splits.len()
    }

    /// Returns the positions of the splits, from 0 at the first view to 1 at the last, in ascending order, with the radiance
    /// towards each.
    pub fn places(&self) -> &[(f64, DVec3)] {
        &self.splits
    }

    /// Returns the radiance at a position, 0 to 1.
    pub fn at(&self, place: f64) -> DVec3 {
        let after = self.splits.partition_point(|split| split.0 <= place);
        match (after.checked_sub(1).map(|before| self.splits[before]), self.splits.get(after)) {
            (Some((from, a)), Some(&(to, b))) => a.lerp(b, (place - from) / (to - from)),
            (Some((_, a)), None) => a,
            (None, first) => first.map_or(DVec3::ZERO, |first| first.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::mesh::Ray;
    use scene::trace::EyeLight;
    use scene::{Lamp, Light, Material, Object, Phong, Quad, SceneAtTime, Shape, Sky, Texture, Window};

    const EYES: EyeLine = EyeLine { first: DVec3::new(-1.0, 1.0, 0.0), along: DVec3::new(2.0, 0.0, 0.0) };

    /// Returns the gloss of a floor under lamps of the given positions and radiances, at the point 4 m away that the middle eye
    /// sees.
    fn gloss(lamps: &[([f64; 3], f64)]) -> Gloss {
        let floor = Quad { corner: DVec3::new(-9.0, 0.0, 9.0), u: DVec3::X * 18.0, v: DVec3::NEG_Z * 18.0 };
        let phong = Phong { weight: DVec3::splat(0.5), exponent: 2000.0 };
        let material = Material { phong, ..Material::diffuse(Texture::Solid(DVec3::splat(0.2))) };
        let lamp = |&(position, radiance): &([f64; 3], f64)| Lamp {
            position: DVec3::from_array(position),
            radiance: DVec3::splat(radiance),
            reach: f64::INFINITY,
            window: Window::Smooth,
            cone: None,
        };
        let light = Light { lamps: lamps.iter().map(lamp).collect(), suns: Vec::new(), sky: Sky::NONE };
        let scene = SceneAtTime::new(vec![Object::new(Shape::Quad(floor), material)], light);
        let eye = EYES.eye(0.5);
        let ray = Ray::new(eye, DVec3::new(0.0, 0.0, -4.0) - eye).unwrap();
        let hit = scene.first_hit(&ray, [0]).unwrap();
        match scene.eye_light(&ray, &hit) {
            EyeLight::Gloss(gloss) => gloss,
            _ => panic!("a floor without gloss"),
        }
    }

    /// Returns a lamp whose highlight is brightest towards an eye: the lamp is as far behind the floor's point as the eye is in
    /// front of it.
    fn lamp_at(place: f64, radiance: f64) -> ([f64; 3], f64) {
        ([-EYES.eye(place).x, 1.0, -8.0], radiance)
    }

    #[test]
    fn of_more_lights_than_splits_the_brightest_have_them() {
        let lamps = [lamp_at(0.2, 0.5), lamp_at(0.5, 2.0), lamp_at(0.8, 8.0)];
        let gloss = gloss(&lamps);
        let places = |limit: usize| -> Vec<f64> {
            let highlight = Highlight::new(&gloss, &EYES, limit);
            highlight.places().iter().map(|split| split.0).collect()
        };
        for wanted in [&[0.0, 1.0][..], &[0.0, 0.8, 1.0], &[0.0, 0.5, 0.8, 1.0], &[0.0, 0.2, 0.5, 0.8, 1.0]] {
            let found = places(wanted.len() - 2);
            // Hit points are in single precision.
            let is_near = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(found.len() == wanted.len() && is_near, "{found:?} {wanted:?}");
        }
        // Further splits halve the intervals, where the interpolation error is largest.
        let many = places(20);
        assert!(many.len() == 22 && many.windows(2).all(|pair| pair[0] < pair[1]), "{many:?}");
    }

    #[test]
    fn one_split_shows_a_narrow_highlight_as_bright_as_it_is() {
        let place = 0.3;
        let gloss = gloss(&[lamp_at(place, 4.0)]);
        let highlight = Highlight::new(&gloss, &EYES, 1);
        let brightest = gloss.towards(EYES.eye(place));
        assert!(brightest.x > 0.01 && (highlight.at(place) / brightest - 1.0).abs().max_element() < 1e-4);
        // Evenly spaced splits include the middle, where the highlight is dark.
        let even = Highlight { splits: [0.0, 0.5, 1.0].map(|at| (at, gloss.towards(EYES.eye(at)))).into() };
        assert!(even.at(place).x < 0.1 * brightest.x, "{} {}", even.at(place), brightest);
    }

    #[test]
    fn highlights_at_the_first_view_and_the_last_need_no_split() {
        for place in [0.0, 1.0] {
            let gloss = gloss(&[lamp_at(place, 4.0)]);
            for limit in [0, 1] {
                let highlight = Highlight::new(&gloss, &EYES, limit);
                assert_eq!(highlight.at(place), gloss.towards(EYES.eye(place)));
                assert!(highlight.at(place).x > highlight.at(0.5).x && highlight.splits() <= limit + 2);
            }
        }
    }

    #[test]
    fn the_best_place_is_where_the_direction_meets_the_line_best() {
        let eyes = EyeLine { first: DVec3::new(-1.0, 0.0, 0.0), along: DVec3::X * 2.0 };
        let point = DVec3::new(0.2, -0.3, -2.0);
        for direction in
            [DVec3::new(0.1, 0.2, 1.0), DVec3::new(-0.3, -0.1, 1.0), DVec3::new(2.0, 0.0, 1.0), DVec3::X, DVec3::NEG_Z]
        {
            let direction = direction.normalize();
            let cosine = |place: f64| (eyes.eye(place) - point).normalize().dot(direction);
            let best = eyes.best_place(point, direction);
            let searched = (0..=1000).map(|at| cosine(f64::from(at) / 1000.0)).fold(f64::NEG_INFINITY, f64::max);
            assert!((0.0..=1.0).contains(&best) && cosine(best) >= searched - 1e-9, "{direction}: {best}");
        }
        // All eyes in one place, and a point at the first eye.
        let still = EyeLine { along: DVec3::ZERO, ..eyes };
        assert!((0.0..=1.0).contains(&still.best_place(point, DVec3::Z)));
        assert!((0.0..=1.0).contains(&eyes.best_place(eyes.first, DVec3::Z)));
    }

    #[test]
    fn highlights_are_linear_between_splits() {
        let highlight = Highlight { splits: vec![(0.0, DVec3::ZERO), (0.25, DVec3::ONE), (1.0, DVec3::splat(4.0))] };
        assert_eq!(highlight.at(0.0), DVec3::ZERO);
        assert_eq!(highlight.at(0.125), DVec3::splat(0.5));
        assert_eq!((highlight.at(0.25), highlight.at(0.5)), (DVec3::ONE, DVec3::splat(2.0)));
        assert_eq!((highlight.at(1.0), highlight.at(2.0)), (DVec3::splat(4.0), DVec3::splat(4.0)));
        assert_eq!(Highlight::default().at(0.5), DVec3::ZERO);
    }
}
