//! Highlights along a line: piecewise linear between splits (Epipolar 3.5, 7.3).
//!
//! While the eye moves from the first view to the last, nothing else does. Splits stand at both ends, where the mirror direction of each
//! light meets the line of eyes best, and then where the chord errs most, up to a limit.
//!
//! Listing 3.16 of the thesis divides by 0 where the best place is the first view, and with one split; listing 3.17 takes the line of eyes
//! from right to left, and the left point of a quad for its right one. Light itself is that of the scene, not that of listing 3.14 and
//! equation 3.4, which lack the exponent.

use glam::DVec3;

use super::views::OutputViews;
use crate::scene::shading::Gloss;

/// Splits of a line at most, beside its ends, unless given.
pub const DEFAULT_SPLITS: usize = 8;
/// Radiance by which a chord may err: half of the smallest step of 8-bit codes.
const LEAST_ERROR: f64 = 0.5 / 255.0 / 12.92;

/// Radiance of highlights along the line of eyes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Highlight {
    /// As [`Self::places`].
    splits: Vec<(f64, DVec3)>,
}

/// The line of eyes.
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

    /// Where the angle between a direction from a point and the eye is least, 0 to 1.
    ///
    /// With `a` from the point to the first eye, `b` along the line and `r` the direction, the cosine r·(a + t b)/|a + t b| is stationary at
    /// t = ((r·a)(a·b) − (r·b)|a|²) / ((r·b)(a·b) − (r·a)|b|²). (Listing 3.15 intersects two lines instead, which hardly ever meet.)
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
    /// Of a surface, with at most `limit` splits between the ends.
    pub fn new(gloss: &Gloss, eyes: &EyeLine, limit: usize) -> Highlight {
        let at = |place: f64| (place, gloss.towards(eyes.eye(place)));
        let mut splits = vec![at(0.0)];
        if eyes.along == DVec3::ZERO {
            return Highlight { splits };
        }
        let mut best: Vec<f64> = gloss.mirrored().map(|direction| eyes.best_place(gloss.point, direction)).collect();
        best.retain(|place| *place > 0.0 && *place < 1.0);
        best.sort_by(f64::total_cmp);
        best.dedup();
        best.truncate(limit);
        splits.extend(best.iter().map(|&place| at(place)));
        splits.push(at(1.0));
        // The middles of all intervals, and by how much the chord errs there.
        let probe = |pair: &[(f64, DVec3)]| {
            let middle = at(0.5 * (pair[0].0 + pair[1].0));
            (middle, (middle.1 - 0.5 * (pair[0].1 + pair[1].1)).abs().max_element())
        };
        while splits.len() < limit + 2 {
            let worst = splits.windows(2).map(probe).enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1));
            match worst {
                Some((before, (split, error))) if error > LEAST_ERROR => splits.insert(before + 1, split),
                _ => break,
            }
        }
        Highlight { splits }
    }

    /// Splits, ends among them.
    pub fn splits(&self) -> usize {
        self.splits.len()
    }

    /// Places of the splits, 0 at the first view to 1 at the last, rising, and the radiance towards each.
    pub fn places(&self) -> &[(f64, DVec3)] {
        &self.splits
    }

    /// Radiance at a place, 0 to 1.
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
        // Eyes in one place, and a point at the first of them.
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
