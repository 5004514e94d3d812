//! What a camera is worth (CALF 4, equations 2, 3, 4, 6 and 7).
//!
//! Enters: facets of surfaces, and which of them each position sees. Leaves: the gain of a camera, given others.
//!
//! With `d = |x O|`, `Z` the viewer distance of x and `k` the rate of decay, a camera at O is suited to see x by
//! `I_suit = V · exp(−k · max(d − Z, 0))` (2). What it adds there is `I_cov = max(I_suit(O) − max_i I_suit(C_i), 0)` (3), and
//! what it adds at all is the sum of it over facets by area (4).
//!
//! **Equation 6**, for surfaces that look different from each side, is printed as `I(θ ≥ ∠(xO, xC_i)) · I_cov`: a new camera
//! would count only *near* an old one. Its prose wants a least angle between views. Here a camera covers x for another one if the
//! angle between them, seen from x, is less than θ:
//! `I'_cov = max(I_suit(O) − max over i with ∠ < θ of I_suit(C_i), 0)`. With θ = 180° all cameras count, as for diffuse
//! surfaces; with θ = 0° none does, and nothing is ever redundant.
//!
//! **Equation 7**, for scenes that move, multiplies `I_suit · I_cov` under the integral over time. `I_cov` has `I_suit` in it
//! already: a still scene would be judged by another measure than (4), and what is seen from afar would be punished twice.
//! Here (7) is the integral of (4) over time: facets of several frames, each with its part of the time.
//!
//! A gain never grows when cameras are added: in each term the maximum is then taken over more of them. Terms are added in a
//! fixed order and rounding is monotone, so that this is so for the computed numbers, too; [`super::greedy`] relies on it.

use glam::DVec3;

/// Facets whose distances [`State::bound`] takes together: a byte of a view's bits.
const GROUP: usize = 8;
/// More than rounding can make a suitability too large, relative to it.
const ROUNDING: f64 = 1e-9;

/// One side of a surface around a point, at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// Where, metres.
    pub point: DVec3,
    /// To the side that is meant, length 1.
    pub normal: DVec3,
    /// Its part of all area and time; those of all facets come to 1.
    pub weight: f64,
    /// Z: metres within which it is seen as well as any viewer sees it.
    pub viewer_distance_m: f64,
}

/// What light does at surfaces, as far as cameras must know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lighting {
    /// A point looks alike from everywhere: one camera will do (CALF 4.1).
    Diffuse,
    /// It looks different from each side (CALF 4.2).
    Specular {
        /// θ: cameras less than so many degrees apart, seen from a point, see the same there; 0..=180.
        theta_deg: f64,
    },
}

impl Lighting {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Lighting::Diffuse => "diffuse",
            Lighting::Specular { .. } => "specular",
        }
    }

    /// The cosine above which two directions from a point are near each other; beyond all cosines at both ends of the range of θ,
    /// where rounding must not decide.
    pub(super) fn near_cosine(self) -> f64 {
        match self {
            Lighting::Specular { theta_deg } if theta_deg <= 0.0 => f64::INFINITY,
            Lighting::Specular { theta_deg } if theta_deg < 180.0 => theta_deg.to_radians().cos(),
            _ => f64::NEG_INFINITY,
        }
    }
}

/// Which facets a position sees: one bit for each, the first the lowest of the first word.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Where, metres.
    pub position: DVec3,
    /// The bits; those beyond the last facet are 0.
    pub seen: Vec<u64>,
}

impl View {
    /// Indices of the facets that it sees, in order.
    pub fn facets(&self) -> impl Iterator<Item = usize> + '_ {
        self.seen.iter().enumerate().flat_map(|(at, &word)| {
            let mut left = word;
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                (left != 0).then(|| {
                    left &= left - 1;
                    64 * at + bit
                })
            })
        })
    }
}

/// All facets, and how their importance fades with distance.
#[derive(Debug, Clone)]
pub struct Problem {
    facets: Vec<Facet>,
    rate_per_m: f64,
    groups: Vec<Group>,
}

/// What is known of [`GROUP`] facets that follow each other.
#[derive(Debug, Clone)]
struct Group {
    min: DVec3,
    max: DVec3,
    /// Middle of the box, and how far from it the facets are at most.
    middle: DVec3,
    radius_m: f64,
    viewer_distance_m: f64,
}

impl Problem {
    /// Facets, and k: by how much a camera is less suited with each metre beyond the viewer distance, 0 or more.
    pub fn new(facets: Vec<Facet>, rate_per_m: f64) -> Problem {
        let group = |facets: &[Facet]| {
            let min = facets.iter().fold(DVec3::INFINITY, |min, facet| min.min(facet.point));
            let max = facets.iter().fold(DVec3::NEG_INFINITY, |max, facet| max.max(facet.point));
            let viewer_distance_m = facets.iter().map(|facet| facet.viewer_distance_m).fold(0.0, f64::max);
            Group { min, max, middle: 0.5 * (min + max), radius_m: 0.5 * (max - min).length(), viewer_distance_m }
        };
        let groups = facets.chunks(GROUP).map(group).collect();
        Problem { facets, rate_per_m, groups }
    }

    /// The facets.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Puts another k in the place of the one that was given.
    pub fn set_rate_per_m(&mut self, rate_per_m: f64) {
        self.rate_per_m = rate_per_m;
    }

    /// k, per metre.
    pub fn rate_per_m(&self) -> f64 {
        self.rate_per_m
    }

    /// `I_suit` (2) of a camera for a facet that it sees: 1 within the viewer distance, less beyond it.
    pub fn suitability(&self, camera: DVec3, facet: usize) -> f64 {
        let facet = &self.facets[facet];
        self.decay(camera.distance(facet.point) - facet.viewer_distance_m)
    }

    fn decay(&self, beyond_m: f64) -> f64 {
        (-self.rate_per_m * beyond_m.max(0.0)).exp()
    }
}

/// A camera that sees facets of a group.
#[derive(Debug, Clone, Copy)]
struct Near {
    /// From the middle of the group.
    direction: DVec3,
    /// How much the direction can differ for a facet of the group, radians.
    spread: f64,
    /// The least of its suitabilities for those that it sees, one bit for each.
    suitability: f64,
    seen: u8,
}

impl Group {
    /// Direction from the middle, and by how many radians it can differ for a facet of the group.
    fn direction_to(&self, position: DVec3) -> (DVec3, f64) {
        let way = position - self.middle;
        let share = self.radius_m / way.length();
        (way.normalize_or_zero(), if share < 1.0 { share.asin() } else { std::f64::consts::PI })
    }
}

/// What cameras so far cover.
#[derive(Debug, Clone)]
pub struct State<'a> {
    problem: &'a Problem,
    near_cosine: f64,
    /// Of each facet, the largest suitability of any camera: all that diffuse surfaces ask for.
    best: Vec<f64>,
    /// Of each facet, direction and suitability of the cameras that see it; empty for diffuse surfaces.
    around: Vec<Vec<(DVec3, f64)>>,
    /// The same of each group, for bounds.
    around_groups: Vec<Vec<Near>>,
    cameras: Vec<DVec3>,
}

impl<'a> State<'a> {
    /// No cameras.
    pub fn new(problem: &'a Problem, lighting: Lighting) -> State<'a> {
        let count = problem.facets.len();
        let of_specular = lighting != Lighting::Diffuse;
        State {
            problem,
            near_cosine: lighting.near_cosine(),
            best: vec![0.0; count],
            around: vec![Vec::new(); if of_specular { count } else { 0 }],
            around_groups: vec![Vec::new(); if of_specular { problem.groups.len() } else { 0 }],
            cameras: Vec::new(),
        }
    }

    /// The facets.
    pub fn problem(&self) -> &'a Problem {
        self.problem
    }

    /// Where the cameras are, metres.
    pub fn cameras(&self) -> &[DVec3] {
        &self.cameras
    }

    /// The sum of the best suitabilities by area: what (4) comes to over all cameras of a diffuse scene.
    pub fn weighted(&self) -> f64 {
        self.problem.facets.iter().zip(&self.best).map(|(facet, best)| facet.weight * best).sum()
    }

    /// f (4) of a further camera, as a part of all area and time. Nothing where a camera stands already.
    pub fn gain(&self, view: &View) -> f64 {
        if self.cameras.contains(&view.position) {
            return 0.0;
        }
        let mut sum = 0.0;
        for facet in view.facets() {
            let suitability = self.problem.suitability(view.position, facet);
            let left = suitability - self.covered(view.position, facet);
            if left > 0.0 {
                sum += self.problem.facets[facet].weight * left;
            }
        }
        sum
    }

    /// At least the gain of a camera, for less work: the facets of a group are taken to be as near as the nearest could be, and a
    /// camera covers for another where it does so for all facets of the group.
    pub fn bound(&self, view: &View) -> f64 {
        let mut sum = 0.0;
        for (at, group) in self.problem.groups.iter().enumerate() {
            let first = at * GROUP;
            let mut left = (view.seen[first / 64] >> (first % 64)) as u8;
            if left == 0 {
                continue;
            }
            let off = (group.min - view.position).max(view.position - group.max).max(DVec3::ZERO).length();
            let most = self.problem.decay(off - group.viewer_distance_m) * (1.0 + ROUNDING);
            let mut covered: [f64; GROUP] = std::array::from_fn(|_| 0.0);
            match self.around_groups.get(at) {
                None => covered.iter_mut().zip(&self.best[first..]).for_each(|(covered, best)| *covered = *best),
                Some(cameras) => self.cover_group(&mut covered, group.direction_to(view.position), cameras),
            }
            while left != 0 {
                let bit = left.trailing_zeros() as usize;
                sum += self.problem.facets[first + bit].weight * (most - covered[bit]).max(0.0);
                left &= left - 1;
            }
        }
        sum
    }

    /// Raises what is covered of each facet of a group by the cameras that cover it for all of the group.
    fn cover_group(&self, covered: &mut [f64; GROUP], (direction, spread): (DVec3, f64), cameras: &[Near]) {
        for camera in cameras {
            // A margin far above what rounding makes of an angle.
            let angle = direction.dot(camera.direction).clamp(-1.0, 1.0).acos() + spread + camera.spread + 1e-6;
            let is_near = angle < std::f64::consts::PI && angle.cos() > self.near_cosine;
            if is_near || self.near_cosine == f64::NEG_INFINITY {
                let seen = covered.iter_mut().enumerate().filter(|(bit, _)| camera.seen >> bit & 1 == 1);
                seen.for_each(|(_, covered)| *covered = covered.max(camera.suitability));
            }
        }
    }

    /// The largest suitability of the cameras that cover a facet for a position.
    fn covered(&self, position: DVec3, facet: usize) -> f64 {
        if self.around.is_empty() {
            return self.best[facet];
        }
        let direction = (position - self.problem.facets[facet].point).normalize_or_zero();
        let near = self.around[facet].iter().filter(|(other, _)| direction.dot(*other) > self.near_cosine);
        near.map(|(_, suitability)| *suitability).fold(0.0, f64::max)
    }

    /// Adds a camera.
    pub fn add(&mut self, view: &View) {
        for facet in view.facets() {
            let suitability = self.problem.suitability(view.position, facet);
            self.best[facet] = self.best[facet].max(suitability);
            if let Some(around) = self.around.get_mut(facet) {
                let direction = (view.position - self.problem.facets[facet].point).normalize_or_zero();
                around.push((direction, suitability));
            }
        }
        for (at, around) in self.around_groups.iter_mut().enumerate() {
            let first = at * GROUP;
            let seen = (view.seen[first / 64] >> (first % 64)) as u8;
            if seen != 0 {
                let (direction, spread) = self.problem.groups[at].direction_to(view.position);
                let suitabilities = (0..GROUP).filter(|bit| seen >> bit & 1 == 1);
                let suitability = suitabilities
                    .map(|bit| self.problem.suitability(view.position, first + bit))
                    .fold(f64::INFINITY, f64::min);
                around.push(Near { direction, spread, suitability, seen });
            }
        }
        self.cameras.push(view.position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet(point: DVec3, weight: f64) -> Facet {
        Facet { point, normal: DVec3::Y, weight, viewer_distance_m: 1.0 }
    }

    fn view(position: DVec3, seen: u64) -> View {
        View { position, seen: vec![seen] }
    }

    #[test]
    fn suitability_fades_beyond_the_viewer_distance() {
        let problem = Problem::new(vec![facet(DVec3::ZERO, 1.0)], 0.5);
        let at = |height: f64| problem.suitability(DVec3::Y * height, 0);
        assert_eq!([at(0.2), at(1.0), at(3.0)], [1.0, 1.0, (-1.0f64).exp()]);
    }

    #[test]
    fn only_what_is_better_seen_counts() {
        let problem = Problem::new(vec![facet(DVec3::ZERO, 0.75), facet(DVec3::X * 4.0, 0.25)], 1.0);
        let mut state = State::new(&problem, Lighting::Diffuse);
        let far = view(DVec3::Y * 3.0, 0b01);
        let first = state.gain(&far);
        assert!((first - 0.75 * (-2.0f64).exp()).abs() < 1e-15);
        state.add(&far);
        assert_eq!(state.gain(&far), 0.0);
        let near = view(DVec3::Y, 0b11);
        let second = state.gain(&near);
        assert!(state.bound(&near) >= second && state.bound(&near) < 1.0);
        let beyond = 17f64.sqrt() - 1.0;
        assert!((second - (0.75 * (1.0 - (-2.0f64).exp()) + 0.25 * (-beyond).exp())).abs() < 1e-15);
        state.add(&near);
        // For diffuse surfaces, gains add up to the objective.
        assert!((state.weighted() - (first + second)).abs() < 1e-15);
        assert!(State::new(&problem, Lighting::Diffuse).bound(&far) >= first);
    }

    #[test]
    fn a_camera_covers_for_others_within_theta() {
        let problem = Problem::new(vec![facet(DVec3::ZERO, 1.0)], 1.0);
        let above = view(DVec3::Y, 1);
        let aside = view(DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0), 1);
        let gain = |theta_deg: f64| {
            let mut state = State::new(&problem, Lighting::Specular { theta_deg });
            state.add(&above);
            (state.gain(&aside), state.gain(&view(DVec3::Y * 0.5, 1)), state.gain(&above))
        };
        assert_eq!(gain(44.0), (1.0, 0.0, 0.0));
        assert_eq!(gain(46.0), (0.0, 0.0, 0.0));
        assert_eq!(gain(180.0), (0.0, 0.0, 0.0));
        // Nothing is redundant, but two cameras never stand at one place.
        assert_eq!(gain(0.0), (1.0, 1.0, 0.0));
    }

    #[test]
    fn bits_are_facets() {
        let view = View { position: DVec3::ZERO, seen: vec![0b1010, 1 << 63 | 1] };
        assert_eq!(view.facets().collect::<Vec<_>>(), [1, 3, 64, 127]);
    }

    mod bounds {
        use proptest::prelude::*;

        use super::super::super::sequence::in_cube;
        use super::*;

        proptest! {
            #![proptest_config(ProptestConfig::with_cases(400))]
            /// Facets in clusters of any size, so that cameras lie inside the boxes of groups too; near the origin and far off.
            #[test]
            fn a_bound_is_never_below_the_gain(
                count in 1usize..128,
                size in prop_oneof![Just(0.0), 1e-3..1.0f64, 1.0..50.0f64],
                off in prop_oneof![Just(0.0), Just(1e4), Just(-1e7)],
                rate in prop_oneof![Just(0.0), 0.0..4.0f64],
                theta in prop_oneof![Just(None), Just(Some(0.0)), Just(Some(180.0)), (0.5..179.5f64).prop_map(Some)],
                cameras in prop::collection::vec((0u64..5000, any::<[u64; 2]>(), 0.0..4.0f64), 2..12),
            ) {
                let place = |at: u64, size: f64| DVec3::splat(off) + size * (in_cube(at) - 0.5);
                let facet = |at: usize| Facet {
                    point: place((at / 8) as u64, 3.0) - DVec3::splat(off) + place(900 + at as u64, size),
                    viewer_distance_m: 0.2 * (at % 5) as f64,
                    ..facet(DVec3::ZERO, 1.0 / count as f64)
                };
                let problem = Problem::new((0..count).map(facet).collect(), rate);
                let mask = |word: usize| match count.saturating_sub(64 * word) {
                    0 => 0,
                    left @ 1..64 => (1 << left) - 1,
                    _ => u64::MAX,
                };
                let words = count.div_ceil(64);
                let views: Vec<View> = cameras
                    .iter()
                    .map(|(at, seen, spread)| View {
                        position: place(*at, *spread),
                        seen: (0..words).map(|word| seen[word] & mask(word)).collect(),
                    })
                    .collect();
                let lighting = theta.map_or(Lighting::Diffuse, |theta_deg| Lighting::Specular { theta_deg });
                let mut state = State::new(&problem, lighting);
                for placed in &views {
                    for view in &views {
                        let (bound, gain) = (state.bound(view), state.gain(view));
                        prop_assert!(bound >= gain, "{bound:e} {gain:e} with {} cameras", state.cameras().len());
                    }
                    state.add(placed);
                }
            }
        }
    }
}
