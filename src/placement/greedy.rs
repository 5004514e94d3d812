//! The best of many positions (CALF 4, equation 5), again and again.
//!
//! Enters: views of candidates, and the cameras so far. Leaves: the candidate with the largest gain, the lowest index of
//! those that are equal; none where no gain is above 0.
//!
//! [`plain`] asks for the gain of every candidate in every round, as algorithm 1 is written. [`Lazy`] chooses the same ones
//! with few questions: gains only shrink (see [`super::objective`]), so what a candidate was worth earlier bounds what it is
//! worth now, and those whose bound is below the best found need not be asked (Minoux 1978). A cheaper bound comes before each
//! question.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::objective::{State, View};

/// A candidate that was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Its index.
    pub candidate: usize,
    /// Its gain as a part of all area and time, above 0.
    pub gain: f64,
}

/// How much was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Calls {
    /// [`State::gain`]s.
    pub gains: u64,
    /// [`State::bound`]s.
    pub bounds: u64,
}

/// Asks for all gains. Adds to `calls` how many.
pub fn plain(state: &State<'_>, views: &[View], calls: &mut u64) -> Option<Choice> {
    let gains: Vec<f64> = views.par_iter().map(|view| state.gain(view)).collect();
    *calls += gains.len() as u64;
    let all = gains.into_iter().enumerate().map(|(candidate, gain)| Choice { candidate, gain });
    all.filter(|choice| choice.gain > 0.0).reduce(|best, other| if other.gain > best.gain { other } else { best })
}

/// A candidate in the queue, the most promising first.
#[derive(Debug, Clone, Copy)]
struct Entry {
    /// At least its gain.
    bound: f64,
    candidate: Reverse<usize>,
    /// Round in which the bound was found.
    round: u64,
    /// Whether it was the gain then.
    is_gain: bool,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(self.candidate.cmp(&other.candidate))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// Remembers what candidates were worth.
#[derive(Debug, Clone)]
pub struct Lazy {
    queue: BinaryHeap<Entry>,
    round: u64,
}

impl Lazy {
    /// A queue of all candidates by their [`State::bound`]s.
    pub fn new(state: &State<'_>, views: &[View]) -> Lazy {
        let bounds: Vec<f64> = views.par_iter().map(|view| state.bound(view)).collect();
        let entry = |(candidate, bound)| Entry { bound, candidate: Reverse(candidate), round: 1, is_gain: false };
        Lazy { queue: bounds.into_iter().enumerate().map(entry).collect(), round: 0 }
    }

    /// The best candidate now. Cameras may have been added since the last time, and none taken away. Adds to `calls` how
    /// many gains and bounds were computed; the bounds of [`Self::new`], one for each candidate, are not among them.
    pub fn best(&mut self, state: &State<'_>, views: &[View], calls: &mut Calls) -> Option<Choice> {
        self.round += 1;
        loop {
            // What is equal to the best found comes first where its index is lower, and is asked.
            let mut entry = self.queue.pop()?;
            let is_new = entry.round == self.round;
            if (is_new && entry.is_gain) || entry.bound <= 0.0 {
                self.queue.push(entry);
                let choice = Choice { candidate: entry.candidate.0, gain: entry.bound };
                return (entry.bound > 0.0).then_some(choice);
            }
            let view = &views[entry.candidate.0];
            if is_new {
                calls.gains += 1;
                (entry.bound, entry.is_gain) = (state.gain(view), true);
            } else {
                calls.bounds += 1;
                (entry.bound, entry.is_gain) = (entry.bound.min(state.bound(view)), false);
            }
            entry.round = self.round;
            self.queue.push(entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::super::objective::{Facet, Lighting, Problem};
    use super::super::sequence::in_cube;
    use super::*;

    fn views(facets: usize, seeds: &[u64]) -> Vec<View> {
        let view = |(at, seed): (usize, &u64)| {
            let mut random = seed | 1;
            let mut word = || {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                random ^ random >> 29
            };
            let mut seen: Vec<u64> = (0..facets.div_ceil(64)).map(|_| word() & word()).collect();
            if let Some(last) = seen.last_mut().filter(|_| !facets.is_multiple_of(64)) {
                *last &= (1 << (facets % 64)) - 1;
            }
            View { position: 3.0 * in_cube(40 + at as u64), seen }
        };
        seeds.iter().enumerate().map(view).collect()
    }

    fn problem(facets: usize, rate: f64) -> Problem {
        let facet = |at: usize| Facet {
            point: in_cube(at as u64),
            normal: DVec3::Y,
            weight: (1.0 + (at % 3) as f64) / (2.0 * facets as f64),
            viewer_distance_m: 0.3 * (at % 4) as f64,
        };
        Problem::new((0..facets).map(facet).collect(), rate)
    }

    fn lighting(theta_deg: Option<f64>) -> Lighting {
        theta_deg.map_or(Lighting::Diffuse, |theta_deg| Lighting::Specular { theta_deg })
    }

    /// Choices of both ways, at most `most`; and how often each asked.
    fn both(problem: &Problem, views: &[View], lighting: Lighting, most: usize) -> ([Vec<Choice>; 2], [u64; 2]) {
        let (mut plain_calls, mut calls) = (0, Calls::default());
        let mut state = State::new(problem, lighting);
        let mut first = Vec::new();
        while let Some(choice) = plain(&state, views, &mut plain_calls).filter(|_| first.len() < most) {
            state.add(&views[choice.candidate]);
            first.push(choice);
        }
        let mut state = State::new(problem, lighting);
        let mut lazy = Lazy::new(&state, views);
        let mut second = Vec::new();
        while let Some(choice) = lazy.best(&state, views, &mut calls).filter(|_| second.len() < most) {
            state.add(&views[choice.candidate]);
            second.push(choice);
        }
        ([first, second], [plain_calls, calls.gains])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn lazy_chooses_what_plain_chooses(
            facets in 1usize..150,
            rate in prop_oneof![Just(0.0), 0.0..5.0f64],
            theta in prop_oneof![Just(None), Just(Some(0.0)), Just(Some(180.0)), (1.0..179.0f64).prop_map(Some)],
            seeds in prop::collection::vec(0u64..40, 1..40),
        ) {
            // Few seeds: many candidates see the same, and gains are equal where nothing fades.
            let (problem, views) = (problem(facets, rate), views(facets, &seeds));
            let ([first, second], calls) = both(&problem, &views, lighting(theta), 25);
            prop_assert_eq!(&first, &second);
            prop_assert!(calls[1] <= calls[0]);
            // Gains only shrink.
            prop_assert!(first.windows(2).all(|pair| pair[1].gain <= pair[0].gain));
        }
    }

    #[test]
    fn of_equal_gains_the_lowest_index_is_chosen() {
        let problem = problem(64, 0.0);
        let mut same = views(64, &[5, 9, 9, 9]);
        same[0].seen = vec![1];
        let (choices, _) = both(&problem, &same, Lighting::Diffuse, 9);
        assert_eq!(choices[0][0].candidate, 1);
        assert_eq!(choices[0], choices[1]);
    }

    #[test]
    fn without_gain_nothing_is_chosen() {
        let problem = problem(64, 1.0);
        let blind = vec![View { position: DVec3::ZERO, seen: vec![0] }; 3];
        assert_eq!(both(&problem, &blind, Lighting::Diffuse, 9).0, [vec![], vec![]]);
        assert_eq!(both(&problem, &[], Lighting::Diffuse, 9).0, [vec![], vec![]]);
    }

    #[test]
    fn theta_of_180_is_diffuse_and_of_0_never_ends() {
        let (problem, views) = (problem(120, 0.7), views(120, &(0..30).collect::<Vec<_>>()));
        let choices = |theta| both(&problem, &views, lighting(theta), 99).0[1].clone();
        assert_eq!(choices(None), choices(Some(180.0)));
        assert_eq!(choices(Some(0.0)).len(), 30);
    }
}
