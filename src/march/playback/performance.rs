//! Performance-based culling: how many views fit into the target time of a frame (CALF 6.3).
//!
//! Enters: how long frames took, and with how many views. Leaves: how many views the next one may have. It is a function of
//! these figures alone.
//!
//! Frame time is not proportional to the number of views: some work is constant, and rays that few views stop are marched
//! farther, so that fewer views can take longer. So times are kept by number of views, as medians of the last frames, since a
//! frame with a new view takes longer once. A slow frame reduces the views to as many as would fit at equal cost each; a
//! reduction that did not help is undone, and not tried again while its time is remembered. Views come back one by one, after
//! several frames in a row with time to spare, so that views do not flicker.

use std::collections::{BTreeMap, VecDeque};

/// Frames over which the median is taken.
const FRAMES: usize = 5;
/// Frames before which nothing is decided, as the first ones are slow.
const MIN_SAMPLES: usize = 3;
/// Frames after which a time is forgotten, as the visible scene changes.
const MEMORY: u64 = 120;
/// Part of the time that must suffice for one view more.
const ROOM: f64 = 0.85;
/// Part of a frame's time below which another number of views is worth a change.
const WORTH: f64 = 0.85;
/// Frames in a row that must have had room.
const PATIENCE: u32 = 8;

#[derive(Debug, Clone, PartialEq)]
pub struct PerformanceCulling {
    target_ms: f64,
    /// By number of views, the last frames that had so many: which one it was, and its milliseconds.
    times: BTreeMap<usize, VecDeque<(u64, f64)>>,
    frame: u64,
    /// The most views that the next frame may have, at least 1; none where nothing was ever too slow.
    pub most: Option<usize>,
    roomy: u32,
}

impl PerformanceCulling {
    /// Frames are to take at most `target_ms`, above 0. There is no limit before one takes longer.
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
            // A limit that says no more than the number of views that there are is none.
            if next != views || self.most.is_some() {
                self.most = Some(next);
            }
        } else if self.one_more_ms(median_ms, views) <= ROOM * self.target_ms {
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

    /// The time of frames with so many views, where enough of them are remembered.
    fn median_ms(&self, views: usize) -> Option<f64> {
        let times = self.times.get(&views).filter(|times| times.len() >= MIN_SAMPLES)?;
        let mut sorted: Vec<f64> = times.iter().map(|&(_, ms)| ms).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get((sorted.len() - 1) / 2).copied()
    }

    /// How many views come after frames that took too long with `views` of them.
    fn after_a_slow_one(&self, median_ms: f64, views: usize) -> usize {
        let known = || self.times.keys().filter_map(|&count| Some((count, self.median_ms(count)?)));
        // Fewer views brought nothing: back to the most that were as fast.
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

    /// What a frame would take with one view more: as measured, else between what was measured, else as if each view cost the
    /// same, whichever of these two is less.
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

    /// Views of each of some frames, where a view costs `cost_ms(frame)` and there are `views` of them.
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

    /// Views of each of some frames, where a frame with so many takes `frame_ms(views)`.
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
        // As measured of a scene in which one view stops few rays.
        let taken = run_uneven(60.0, 6, 100, |views| [0.0, 125.0, 80.0, 100.0, 130.0, 150.0, 179.0][views]);
        assert_eq!(taken[..10], [6, 6, 6, 2, 2, 2, 1, 1, 1, 2]);
        assert!(taken[10..].iter().all(|&views| views == 2), "{taken:?}");
        // Where views cost nothing, leaving them out brings nothing.
        let taken = run_uneven(60.0, 6, 100, |_| 70.0);
        assert!(taken[6..].iter().all(|&views| views == 6), "{taken:?}");
        // Where nearly all of the time is the same for any number of views, a few too many went at first.
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
