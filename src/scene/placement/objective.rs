//! The gain of a camera (CALF 4, equations 2, 3, 4, 6 and 7).
//!
//! With `d = |x O|`, `Z` the viewer distance of x and `k` the rate of decay, the suitability of a camera at O for x is `I_suit =
//! V · exp(−k · max(d − Z, 0))` (2). The gain of the camera at x is `I_cov = max(I_suit(O) − max_i I_suit(C_i), 0)` (3), and its
//! total gain is the sum over surfels by area (4).
//!
//! **Equation 6**, for specular surfaces, is printed as `I(θ ≥ ∠(xO, xC_i)) · I_cov`: a new camera would count only *near* an old
//! one, and the first camera would count nowhere. The text asks for a *minimum* angle between views. In this implementation a
//! camera is redundant with another one if both are within θ of each other, seen from x: `I'_cov = max(I_suit(O) − max over i
//! with ∠ < θ of I_suit(C_i), 0)`. θ = 180° makes the same choices as the diffuse case; with θ = 0° no camera is redundant.
//!
//! **Equation 7**, for moving scenes, multiplies `I_suit · I_cov` under the integral over time. `I_cov` already contains
//! `I_suit`: the product squares it, so distance would count twice as much as in a still scene, and a single frame would not give
//! equation 4. In this implementation (7) is the integral of (4) over time: the surfels come from several time samples.
//!
//! A gain never grows when cameras are added, because the maximum is taken over more of them. Terms are added in a fixed order
//! and rounding is monotone, so the same holds for the computed gains. `greedy` relies on this.

use glam::DVec3;

use crate::mesh::AxisBox;

/// Number of surfels that [`State::bound`] groups: those of one byte of a visible set.
const GROUP: usize = 8;
/// Relative margin, larger than the rounding error of suitabilities.
const ROUNDING: f64 = 1e-9;

/// Surface sample: one side of a surface at a point, at one time sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfel {
    pub point: DVec3,
    /// Unit normal on the visible side.
    pub normal: DVec3,
    /// Fraction of all area and time; the sum over all surfels is 1.
    pub weight: f64,
    /// Z: distance in metres within which a camera sees the surfel as well as any viewer.
    pub viewer_distance_m: f64,
}

/// Reflectance of surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lighting {
    /// Looks the same from all directions: one camera is enough (CALF 4.1).
    Diffuse,
    /// Looks different from each direction (CALF 4.2).
    Specular {
        /// θ in degrees, 0..=180: cameras whose directions from a point are closer than this are redundant at that point.
        theta_deg: f64,
    },
}

impl Lighting {
    pub fn name(self) -> &'static str {
        match self {
            Lighting::Diffuse => "diffuse",
            Lighting::Specular { .. } => "specular",
        }
    }

    /// Returns the cosine above which two directions are within θ. It is infinite at both ends of the range, so that rounding has
    /// no effect.
    pub(super) fn near_cosine(self) -> f64 {
        match self {
            Lighting::Specular { theta_deg } if theta_deg <= 0.0 => f64::INFINITY,
            Lighting::Specular { theta_deg } if theta_deg < 180.0 => theta_deg.to_radians().cos(),
            _ => f64::NEG_INFINITY,
        }
    }
}

/// Surfels that a position sees, one bit each, from the lowest bit of the first word.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleSet {
    pub position: DVec3,
    /// Bits beyond the last surfel are 0.
    pub seen: Vec<u64>,
}

impl VisibleSet {
    /// Returns the indices of the surfels, in ascending order.
    pub fn surfels(&self) -> impl Iterator<Item = usize> + '_ {
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

#[derive(Debug, Clone)]
pub struct Problem {
    pub surfels: Vec<Surfel>,
    /// Rate of decay k in 1/m, 0 or more.
    pub rate_per_m: f64,
    groups: Vec<Group>,
}

/// Bounds of [`GROUP`] consecutive surfels.
#[derive(Debug, Clone)]
struct Group {
    bounds: AxisBox,
    /// Centre of the box, and the radius of a sphere around the surfels.
    middle: DVec3,
    radius_m: f64,
    viewer_distance_m: f64,
}

impl Problem {
    pub fn new(surfels: Vec<Surfel>, rate_per_m: f64) -> Problem {
        let group = |surfels: &[Surfel]| {
            let bounds = AxisBox::around(surfels.iter().map(|surfel| surfel.point));
            let bounds = bounds.unwrap_or(AxisBox { min: DVec3::ZERO, max: DVec3::ZERO });
            let AxisBox { min, max } = bounds;
            let viewer_distance_m = surfels.iter().map(|surfel| surfel.viewer_distance_m).fold(0.0, f64::max);
            Group { bounds, middle: 0.5 * (min + max), radius_m: 0.5 * (max - min).length(), viewer_distance_m }
        };
        let groups = surfels.chunks(GROUP).map(group).collect();
        Problem { surfels, rate_per_m, groups }
    }

    /// Returns `I_suit` (2) of a camera for a surfel that it sees.
    pub fn suitability(&self, camera: DVec3, surfel: usize) -> f64 {
        let surfel = &self.surfels[surfel];
        self.decay(camera.distance(surfel.point) - surfel.viewer_distance_m)
    }

    fn decay(&self, beyond_m: f64) -> f64 {
        (-self.rate_per_m * beyond_m.max(0.0)).exp()
    }
}

/// A camera that sees surfels of a group.
#[derive(Debug, Clone, Copy)]
struct GroupCamera {
    direction: DirectionBound,
    /// Minimum suitability for the surfels that it sees.
    suitability: f64,
    seen: u8,
}

/// Cone of the directions from the surfels of a group to a position.
#[derive(Debug, Clone, Copy)]
struct DirectionBound {
    /// Direction from the centre of the group.
    direction: DVec3,
    /// Maximum angle between this direction and that from a surfel, in radians.
    spread: f64,
}

impl Group {
    fn direction_to(&self, position: DVec3) -> DirectionBound {
        let way = position - self.middle;
        let share = self.radius_m / way.length();
        let spread = if share < 1.0 { share.asin() } else { std::f64::consts::PI };
        DirectionBound { direction: way.normalize_or_zero(), spread }
    }
}

/// A camera that sees a surfel.
#[derive(Debug, Clone, Copy)]
struct Observer {
    /// Direction from the surfel.
    direction: DVec3,
    suitability: f64,
}

/// Coverage by the cameras so far.
#[derive(Debug, Clone)]
pub struct State<'a> {
    problem: &'a Problem,
    near_cosine: f64,
    /// Maximum suitability of the cameras, for each surfel.
    best: Vec<f64>,
    /// Cameras that see each surfel; empty for diffuse surfaces.
    around: Vec<Vec<Observer>>,
    /// Cameras that see each group; empty for diffuse surfaces.
    around_groups: Vec<Vec<GroupCamera>>,
    cameras: Vec<DVec3>,
}

impl<'a> State<'a> {
    pub fn new(problem: &'a Problem, lighting: Lighting) -> State<'a> {
        let count = problem.surfels.len();
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

    /// Returns the gain (4) of a further camera, as a fraction of all area and time; 0 at the position of a camera.
    pub fn gain(&self, visible: &VisibleSet) -> f64 {
        if self.cameras.contains(&visible.position) {
            return 0.0;
        }
        let mut sum = 0.0;
        for surfel in visible.surfels() {
            let suitability = self.problem.suitability(visible.position, surfel);
            let left = suitability - self.covered(visible.position, surfel);
            if left > 0.0 {
                sum += self.problem.surfels[surfel].weight * left;
            }
        }
        sum
    }

    /// Returns an upper bound of the gain that is cheaper to compute: distances are those of the nearest point of a group's box,
    /// and a camera makes another one redundant only if it does so for the whole group.
    pub fn bound(&self, visible: &VisibleSet) -> f64 {
        let mut sum = 0.0;
        for (at, group) in self.problem.groups.iter().enumerate() {
            let first = at * GROUP;
            let mut left = (visible.seen[first / 64] >> (first % 64)) as u8;
            if left == 0 {
                continue;
            }
            let off = group.bounds.distance_m(visible.position);
            let most = self.problem.decay(off - group.viewer_distance_m) * (1.0 + ROUNDING);
            let mut covered = [0.0; GROUP];
            match self.around_groups.get(at) {
                None => covered.iter_mut().zip(&self.best[first..]).for_each(|(covered, best)| *covered = *best),
                Some(cameras) => self.cover_group(&mut covered, group.direction_to(visible.position), cameras),
            }
            while left != 0 {
                let bit = left.trailing_zeros() as usize;
                sum += self.problem.surfels[first + bit].weight * (most - covered[bit]).max(0.0);
                left &= left - 1;
            }
        }
        sum
    }

    /// Raises the covered suitabilities of a group by the cameras that make `towards` redundant for the whole group.
    fn cover_group(&self, covered: &mut [f64; GROUP], towards: DirectionBound, cameras: &[GroupCamera]) {
        for camera in cameras {
            let [a, b] = [towards.direction, camera.direction.direction];
            // The margin is far above the rounding error of angles.
            let angle = a.dot(b).clamp(-1.0, 1.0).acos() + towards.spread + camera.direction.spread + 1e-6;
            let is_near = angle < std::f64::consts::PI && angle.cos() > self.near_cosine;
            if is_near || self.near_cosine == f64::NEG_INFINITY {
                let seen = covered.iter_mut().enumerate().filter(|(bit, _)| camera.seen >> bit & 1 == 1);
                seen.for_each(|(_, covered)| *covered = covered.max(camera.suitability));
            }
        }
    }

    /// Returns the maximum suitability of the cameras that make a position redundant for a surfel.
    fn covered(&self, position: DVec3, surfel: usize) -> f64 {
        if self.around.is_empty() {
            return self.best[surfel];
        }
        let direction = (position - self.problem.surfels[surfel].point).normalize_or_zero();
        let near = self.around[surfel].iter().filter(|other| direction.dot(other.direction) > self.near_cosine);
        near.map(|other| other.suitability).fold(0.0, f64::max)
    }

    pub fn add(&mut self, visible: &VisibleSet) {
        for surfel in visible.surfels() {
            let suitability = self.problem.suitability(visible.position, surfel);
            self.best[surfel] = self.best[surfel].max(suitability);
            if let Some(around) = self.around.get_mut(surfel) {
                let direction = (visible.position - self.problem.surfels[surfel].point).normalize_or_zero();
                around.push(Observer { direction, suitability });
            }
        }
        for (at, around) in self.around_groups.iter_mut().enumerate() {
            let first = at * GROUP;
            let seen = (visible.seen[first / 64] >> (first % 64)) as u8;
            if seen != 0 {
                let direction = self.problem.groups[at].direction_to(visible.position);
                let suitabilities = (0..GROUP).filter(|bit| seen >> bit & 1 == 1);
                let suitability = suitabilities
                    .map(|bit| self.problem.suitability(visible.position, first + bit))
                    .fold(f64::INFINITY, f64::min);
                around.push(GroupCamera { direction, suitability, seen });
            }
        }
        self.cameras.push(visible.position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfel(point: DVec3, weight: f64) -> Surfel {
        Surfel { point, normal: DVec3::Y, weight, viewer_distance_m: 1.0 }
    }

    fn visible(position: DVec3, seen: u64) -> VisibleSet {
        VisibleSet { position, seen: vec![seen] }
    }

    #[test]
    fn suitability_fades_beyond_the_viewer_distance() {
        let problem = Problem::new(vec![surfel(DVec3::ZERO, 1.0)], 0.5);
        let at = |height: f64| problem.suitability(DVec3::Y * height, 0);
        assert_eq!([at(0.2), at(1.0), at(3.0)], [1.0, 1.0, (-1.0f64).exp()]);
    }

    #[test]
    fn only_what_is_better_seen_counts() {
        let problem = Problem::new(vec![surfel(DVec3::ZERO, 0.75), surfel(DVec3::X * 4.0, 0.25)], 1.0);
        let mut state = State::new(&problem, Lighting::Diffuse);
        let far = visible(DVec3::Y * 3.0, 0b01);
        let first = state.gain(&far);
        assert!((first - 0.75 * (-2.0f64).exp()).abs() < 1e-15);
        state.add(&far);
        assert_eq!(state.gain(&far), 0.0);
        let near = visible(DVec3::Y, 0b11);
        let second = state.gain(&near);
        assert!(state.bound(&near) >= second && state.bound(&near) < 1.0);
        let beyond = 17f64.sqrt() - 1.0;
        assert!((second - (0.75 * (1.0 - (-2.0f64).exp()) + 0.25 * (-beyond).exp())).abs() < 1e-15);
        state.add(&near);
        // For diffuse surfaces, gains add up to the objective.
        let weighted: f64 = problem.surfels.iter().zip(&state.best).map(|(surfel, best)| surfel.weight * best).sum();
        assert!((weighted - (first + second)).abs() < 1e-15);
        assert!(State::new(&problem, Lighting::Diffuse).bound(&far) >= first);
    }

    #[test]
    fn a_camera_covers_for_others_within_theta() {
        let problem = Problem::new(vec![surfel(DVec3::ZERO, 1.0)], 1.0);
        let above = visible(DVec3::Y, 1);
        let aside = visible(DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0), 1);
        let gain = |theta_deg: f64| {
            let mut state = State::new(&problem, Lighting::Specular { theta_deg });
            state.add(&above);
            (state.gain(&aside), state.gain(&visible(DVec3::Y * 0.5, 1)), state.gain(&above))
        };
        assert_eq!(gain(44.0), (1.0, 0.0, 0.0));
        assert_eq!(gain(46.0), (0.0, 0.0, 0.0));
        assert_eq!(gain(180.0), (0.0, 0.0, 0.0));
        // No camera is redundant, but two cameras are never at the same position.
        assert_eq!(gain(0.0), (1.0, 1.0, 0.0));
    }

    #[test]
    fn bits_are_facets() {
        let visible = VisibleSet { position: DVec3::ZERO, seen: vec![0b1010, 1 << 63 | 1] };
        assert_eq!(visible.surfels().collect::<Vec<_>>(), [1, 3, 64, 127]);
    }

    mod bounds {
        use proptest::prelude::*;

        use super::super::super::sequence::in_cube;
        use super::*;

        proptest! {
            #![proptest_config(ProptestConfig::with_cases(400))]
            /// Uses surfels in clusters of any size, so that cameras also lie inside the boxes of groups; near the origin and far
            /// from it.
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
                let surfel = |at: usize| Surfel {
                    point: place((at / 8) as u64, 3.0) - DVec3::splat(off) + place(900 + at as u64, size),
                    viewer_distance_m: 0.2 * (at % 5) as f64,
                    ..surfel(DVec3::ZERO, 1.0 / count as f64)
                };
                let problem = Problem::new((0..count).map(surfel).collect(), rate);
                let mask = |word: usize| match count.saturating_sub(64 * word) {
                    0 => 0,
                    left @ 1..64 => (1 << left) - 1,
                    _ => u64::MAX,
                };
                let words = count.div_ceil(64);
                let visible_sets: Vec<VisibleSet> = cameras
                    .iter()
                    .map(|(at, seen, spread)| VisibleSet {
                        position: place(*at, *spread),
                        seen: (0..words).map(|word| seen[word] & mask(word)).collect(),
                    })
                    .collect();
                let lighting = theta.map_or(Lighting::Diffuse, |theta_deg| Lighting::Specular { theta_deg });
                let mut state = State::new(&problem, lighting);
                for placed in &visible_sets {
                    for visible in &visible_sets {
                        let (bound, gain) = (state.bound(visible), state.gain(visible));
                        prop_assert!(bound >= gain, "{bound:e} {gain:e} with {} cameras", state.cameras.len());
                    }
                    state.add(placed);
                }
            }
        }
    }
}
