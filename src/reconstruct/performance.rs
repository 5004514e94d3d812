//! How many views fit into the time that a frame may take: performance-based culling (CALF 6.3).
//!
//! Enters: how long frames took, and with how many views. Leaves: how many views the next one may have. It is a function of
//! these figures alone. What a view costs is the median over the last frames of time over views, as a frame in which a view
//! is new takes longer once; fewer views are allowed at once, more of them only one by one, and only after some frames in a
//! row had room for them, so that no view comes and goes.

use std::collections::VecDeque;

/// Frames over which the median is taken.
const FRAMES: usize = 5;
/// Frames before which nothing is decided, as the first ones are slow.
const LEAST: usize = 3;
/// Part of the time that must suffice for one view more.
const ROOM: f64 = 0.85;
/// Frames in a row that must have had room.
const PATIENCE: u32 = 8;

/// Decides how many views there may be.
#[derive(Debug, Clone, PartialEq)]
pub struct PerformanceCulling {
    target_ms: f64,
    /// Milliseconds for each view, in the last frames.
    costs_ms: VecDeque<f64>,
    most: Option<usize>,
    roomy: u32,
}

impl PerformanceCulling {
    /// Frames are to take at most `target_ms`, above 0. There is no limit before one takes longer.
    pub fn new(target_ms: f64) -> PerformanceCulling {
        PerformanceCulling { target_ms, costs_ms: VecDeque::new(), most: None, roomy: 0 }
    }

    /// The most views that the next frame may have, at least 1; none where nothing was ever too slow.
    pub fn most(&self) -> Option<usize> {
        self.most
    }

    /// Takes note of a frame.
    pub fn measured(&mut self, frame_ms: f64, views: usize) {
        if views == 0 || !frame_ms.is_finite() {
            return;
        }
        self.costs_ms.push_back(frame_ms / views as f64);
        if self.costs_ms.len() > FRAMES {
            self.costs_ms.pop_front();
        }
        if self.costs_ms.len() < LEAST {
            return;
        }
        let mut costs: Vec<f64> = self.costs_ms.iter().copied().collect();
        costs.sort_by(f64::total_cmp);
        let cost_ms = costs[(costs.len() - 1) / 2];
        if cost_ms * views as f64 > self.target_ms {
            self.most = Some(((self.target_ms / cost_ms) as usize).clamp(1, views));
            self.roomy = 0;
        } else if cost_ms * (views + 1) as f64 <= ROOM * self.target_ms {
            self.roomy += 1;
            if self.roomy >= PATIENCE {
                self.roomy = 0;
                // As long as fewer views take part than may, the limit does not bind.
                self.most = self.most.map(|most| most.max(views + 1).min(most.saturating_add(1)));
            }
        } else {
            self.roomy = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views of each of some frames, where a view costs `cost_ms(frame)` and there are `views` of them.
    fn run(target_ms: f64, views: usize, frames: usize, cost_ms: impl Fn(usize) -> f64) -> Vec<usize> {
        let mut culling = PerformanceCulling::new(target_ms);
        let mut taken = Vec::new();
        for frame in 0..frames {
            let active = culling.most().unwrap_or(usize::MAX).min(views);
            culling.measured(cost_ms(frame) * active as f64, active);
            taken.push(active);
        }
        taken
    }

    #[test]
    fn as_many_views_take_part_as_fit() {
        let taken = run(10.0, 9, 60, |_| 2.0);
        assert_eq!(taken[..LEAST], [9; LEAST]);
        assert!(taken[LEAST..].iter().all(|&views| views == 5), "{taken:?}");
        // One at least.
        assert_eq!(run(10.0, 9, 60, |_| 100.0)[59], 1);
        // Where all fit, nothing happens.
        assert!(run(10.0, 9, 60, |_| 1.0).iter().all(|&views| views == 9));
    }

    #[test]
    fn one_slow_frame_among_others_leaves_nothing_out() {
        for slow in [0, 20] {
            let taken = run(10.0, 4, 60, |frame| if frame == slow { 50.0 } else { 2.0 });
            assert!(taken.iter().all(|&views| views == 4), "{taken:?}");
        }
    }

    #[test]
    fn views_come_back_one_by_one_and_do_not_flicker() {
        let taken = run(10.0, 9, 300, |frame| if frame < 50 { 3.0 } else { 1.0 });
        assert_eq!(taken[49], 3);
        assert!(taken[49..].windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1), "{taken:?}");
        // 8 of them fit with room to spare.
        assert_eq!(taken[299], 8);
        let turns = taken[50..].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(turns, 5);
        // Noise of a tenth about a cost with which 5 views just fit: it settles.
        let noisy = run(10.0, 9, 400, |frame| 1.9 * (1.0 + 0.1 * ((frame * 37 % 11) as f64 / 5.0 - 1.0)));
        let turns = noisy[100..].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(turns, 0, "{noisy:?}");
    }

    #[test]
    fn figures_that_mean_nothing_are_left_out() {
        let mut culling = PerformanceCulling::new(10.0);
        culling.measured(f64::NAN, 3);
        culling.measured(f64::INFINITY, 3);
        culling.measured(1e9, 0);
        assert_eq!(culling.most(), None);
    }
}
