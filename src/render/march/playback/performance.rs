//! Performance-based culling: limits the number of views so that frames meet their target time (CALF 6.3).
//!
//! Takes the times of past frames and their numbers of views. Returns the maximum number of views of the next frame, which
//! depends on these measurements only.
//!
//! Frame time is not proportional to the number of views: some work is constant, and rays that few views stop are marched
//! farther, so fewer views can take longer. Times are therefore kept per number of views, as medians of the last frames, because
//! the first frame with a new view takes longer. A slow frame reduces the number of views to as many as would fit at equal cost
//! each. A reduction that did not help is undone, and not tried again while its time is remembered. Views are added back one by
//! one, after several consecutive frames with time to spare, so that views do not flicker.

use std::collections::{BTreeMap, VecDeque};

/// Number of frames over which the median is taken.
const FRAMES: usize = 5;
/// Minimum number of frames before a decision, because the first ones are slow.
const MIN_SAMPLES: usize = 3;
/// Number of frames after which a time is forgotten, because the visible scene changes.
const MEMORY: u64 = 120;
/// Maximum fraction of the target time that the predicted frame time with one more view may take.
const ROOM: f64 = 0.85;
/// Fraction of a frame's time below which the time of another number of views justifies a change.
const WORTH: f64 = 0.85;
/// Number of consecutive frames with time to spare before a view is added.
const PATIENCE: u32 = 8;

#[derive(Debug, Clone, PartialEq)]
pub struct PerformanceCulling {
    target_ms: f64,
    /// Last frames by number of views: the frame's number and its milliseconds.
    times: BTreeMap<usize, VecDeque<(u64, f64)>>,
    frame: u64,
    /// Maximum number of views of the next frame, at least 1; none if no frame was too slow yet.
    pub most: Option<usize>,
    roomy: u32,
}

impl PerformanceCulling {
    /// Creates a limit for frames of at most `target_ms`, above 0. The number of views is unlimited until a frame takes longer.
    pub fn new(target_ms: f64) -> PerformanceCulling {
        PerformanceCulling { target_ms, times: BTreeMap::new(), frame: 0, most: None, roomy: 0 }
    }

    pub fn measured(&mut self, frame_ms: f64, views: usize) {
        if views == 0 || !frame_ms.is_finite() {
            return;
        }
        self.frame += 1;
        let now = self.frame;
        let times = self.times.entry(views).or_default();
        times.push_back((now, frame_ms));
        if times.len() > FRAMES {
            times.pop_front();
        }
        for times in self.times.values_mut() {
            times.retain(|&(at, _)| now - at < MEMORY);
        }
        let Some(median_ms) = self.median_ms(views) else { return };
        if median_ms > self.target_ms {
            self.roomy = 0;
            let next = self.after_a_slow_one(median_ms, views);
            // An unlimited number of views stays unlimited if no view is culled.
            if next != views || self.most.is_some() {
                self.most = Some(next);
            }
        } else if self.one_more_ms(median_ms, views) <= ROOM * self.target_ms {
            self.roomy += 1;
            if self.roomy >= PATIENCE {
                self.roomy = 0;
                // The limit stays if it exceeds the number of active views, because it has no effect.
                self.most = self.most.map(|most| most.max(views + 1).min(most.saturating_add(1)));
            }
        } else {
            self.roomy = 0;
        }
    }

    /// Returns the median time of frames with this number of views, if enough are remembered.
    fn median_ms(&self, views: usize) -> Option<f64> {
        let times = self.times.get(&views).filter(|times| times.len() >= MIN_SAMPLES)?;
        let mut sorted: Vec<f64> = times.iter().map(|&(_, ms)| ms).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get((sorted.len() - 1) / 2).copied()
    }

    /// Returns the number of views after frames that took too long with `views` of them.
    fn after_a_slow_one(&self, median_ms: f64, views: usize) -> usize {
        let known = || self.times.keys().filter_map(|&count| Some((count, self.median_ms(count)?)));
        // Fewer views did not help: return to the largest number that was as fast.
        if let Some((count, _)) = known().rfind(|&(count, ms)| count > views && ms <= median_ms) {
            return count;
        }
        let fitting = (self.target_ms / median_ms * views as f64) as usize;
        let fewer = fitting.clamp(1, (views - 1).max(1));
        if fewer < views && self.median_ms(fewer).is_none() {
            return fewer;
        }
        let fastest = known().min_by(|(_, a), (_, b)| a.total_cmp(b));
        fastest.filter(|&(_, ms)| ms < WORTH * median_ms).map_or(views, |(count, _)| count)
    }

    /// Predicts the time of a frame with one more view. Returns its measured time if known; else the smaller of an estimate at
    /// equal cost per view and an interpolation to the next larger measured number of views.
    fn one_more_ms(&self, median_ms: f64, views: usize) -> f64 {
        if let Some(ms) = self.median_ms(views + 1) {
            return ms;
        }
        let even = median_ms * (views + 1) as f64 / views as f64;
        let above = self.times.range(views + 2..).find_map(|(&count, _)| Some((count, self.median_ms(count)?)));
        above.map_or(even, |(count, ms)| even.min(median_ms + (ms - median_ms) / (count - views) as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of views of each frame, where a view costs `cost_ms(frame)` and there are `views` of them.
    fn run(target_ms: f64, views: usize, frames: usize, cost_ms: impl Fn(usize) -> f64) -> Vec<usize> {
        let mut culling = PerformanceCulling::new(target_ms);
        let mut taken = Vec::new();
        for frame in 0..frames {
            let active = culling.most.unwrap_or(usize::MAX).min(views);
            culling.measured(cost_ms(frame) * active as f64, active);
            taken.push(active);
        }
        taken
    }

    #[test]
    fn as_many_views_take_part_as_fit() {
        let taken = run(10.0, 9, 60, |_| 2.0);
        assert_eq!(taken[..MIN_SAMPLES], [9; MIN_SAMPLES]);
        assert!(taken[MIN_SAMPLES..].iter().all(|&views| views == 5), "{taken:?}");
        // At least one view remains.
        assert_eq!(run(10.0, 9, 60, |_| 100.0)[59], 1);
        // If all views fit, none is culled.
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
        // 8 of them fit with time to spare.
        assert_eq!(taken[299], 8);
        let turns = taken[50..].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(turns, 5);
        // With noise of 10% around a cost at which 5 views just fit, the number of views settles.
        let noisy = run(10.0, 9, 400, |frame| 1.9 * (1.0 + 0.1 * ((frame * 37 % 11) as f64 / 5.0 - 1.0)));
        let turns = noisy[100..].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(turns, 0, "{noisy:?}");
    }

    /// Returns the number of views of each frame, where a frame with n views takes `frame_ms(n)`.
    fn run_uneven(target_ms: f64, views: usize, frames: usize, frame_ms: impl Fn(usize) -> f64) -> Vec<usize> {
        let mut culling = PerformanceCulling::new(target_ms);
        let mut taken = Vec::new();
        for _ in 0..frames {
            let active = culling.most.unwrap_or(usize::MAX).min(views);
            culling.measured(frame_ms(active), active);
            taken.push(active);
        }
        taken
    }

    #[test]
    fn a_step_that_makes_frames_slower_is_undone() {
        // Measured on a scene in which one view stops few rays.
        let taken = run_uneven(60.0, 6, 100, |views| [0.0, 125.0, 80.0, 100.0, 130.0, 150.0, 179.0][views]);
        assert_eq!(taken[..10], [6, 6, 6, 2, 2, 2, 1, 1, 1, 2]);
        assert!(taken[10..].iter().all(|&views| views == 2), "{taken:?}");
        // If views cost nothing, culling them does not help.
        let taken = run_uneven(60.0, 6, 100, |_| 70.0);
        assert!(taken[6..].iter().all(|&views| views == 6), "{taken:?}");
        // With a constant cost of 20 ms, the number of views settles within the target.
        let taken = run_uneven(60.0, 9, 200, |views| 20.0 + 5.0 * views as f64);
        assert!(taken[199] >= 5 && taken.iter().skip(6).all(|&views| 20 + 5 * views <= 60), "{taken:?}");
    }

    #[test]
    fn figures_that_mean_nothing_are_left_out() {
        let mut culling = PerformanceCulling::new(10.0);
        culling.measured(f64::NAN, 3);
        culling.measured(f64::INFINITY, 3);
        culling.measured(1e9, 0);
        assert_eq!(culling.most, None);
    }
}
