//! How many views fit into the time that a frame may take: performance-based culling (CALF 6.3).
//!
//! Enters: how long frames took, and with how many views. Leaves: how many views the next one may have. It is a function of
//! these figures alone. What a view costs is the median over the last frames of time over views, as a frame in which a view
//! is new takes longer once; fewer views are allowed at once, more of them only one by one, and only after some frames in a
//! row had room for them, so that no view comes and goes.

use std::collections::VecDeque;

/// Frames over which the median is taken.
const FRAMES: usize = 5;
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
        let mut costs: Vec<f64> = self.costs_ms.iter().copied().collect();
        costs.sort_by(f64::total_cmp);
        // The lower one of two in the middle: a slow first frame alone decides nothing once there is another.
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
