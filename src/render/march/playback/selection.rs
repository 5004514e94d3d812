//! Selection of active views (CALF 6.3).
//!
//! Takes the positions of views, an eye, and the times of past frames. Returns the views in order of priority, each in a slot
//! that it keeps while it is active, and the reason why each other view is culled.
//!
//! Choices where the paper is ambiguous:
//!
//! - Priority by angle uses the angle at a reference point between the directions to the eye and to the view. A view at the
//!   reference point has no direction and counts as 90 degrees; if the eye is at the reference point, distance decides.
//! - Culling by angle uses the angle at the eye. A view at the eye has no direction: only another view at the eye is redundant to
//!   it.
//! - Views of equal priority are ordered by distance, then by index.
//!
//! Rendered images depend on the order of the views, which is a function of the eye only, and not on slots. Only performance
//! culling reads clocks.

use glam::DVec3;

use crate::march::playback::performance::PerformanceCulling;
use crate::views::player::Candidate;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ViewPriority {
    #[default]
    Distance,
    /// Angle between view and eye, seen from the reference point.
    Angle,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SelectionSettings {
    pub priority: ViewPriority,
    /// Reference point of [`ViewPriority::Angle`], in metres; by default the mean position of all candidates.
    pub pivot: Option<DVec3>,
    /// Minimum angle in degrees, seen from the eye, to a view of higher priority.
    pub cull_angle_deg: Option<f64>,
    /// Maximum number of active views, at least 1.
    pub most: Option<usize>,
    /// Target time of a frame in milliseconds, for update and rendering; views of low priority are culled to meet it.
    pub target_ms: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active {
    /// Slot that the view keeps while it is active.
    pub slot: usize,
    pub view: usize,
    /// Metres from the eye.
    pub distance_m: f64,
    /// Angle between eye and view at the reference point, in degrees.
    pub angle_deg: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// The angle to this view of higher priority is below the minimum.
    Angle(usize),
    Limit,
    /// With this view the frame would take too long.
    Performance,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Selection {
    /// Active views, in order of priority.
    pub active: Vec<Active>,
    /// Culled views in the same order, with the reason.
    pub culled: Vec<(usize, Why)>,
}

impl Selection {
    pub fn views(&self) -> Vec<usize> {
        self.active.iter().map(|active| active.view).collect()
    }
}

#[derive(Debug, Clone)]
pub struct ViewSelector {
    settings: SelectionSettings,
    performance: Option<PerformanceCulling>,
    slots: Vec<Option<usize>>,
}

impl ViewSelector {
    pub fn new(settings: SelectionSettings) -> ViewSelector {
        let performance = settings.target_ms.map(PerformanceCulling::new);
        ViewSelector { settings, performance, slots: Vec::new() }
    }

    pub fn select(&mut self, candidates: &[Candidate], eye: DVec3) -> Selection {
        let mut selection = Selection::default();
        let most = self.settings.most.map_or(usize::MAX, |most| most.max(1));
        let fast_enough = self.performance.as_ref().and_then(|performance| performance.most).unwrap_or(usize::MAX);
        let way_to = |view: usize| candidates.iter().find(|other| other.view == view).map(|other| other.position - eye);
        for active in self.by_priority(candidates, eye) {
            let close = self.settings.cull_angle_deg.zip(way_to(active.view)).and_then(|(min_deg, way)| {
                let mut taken = selection.active.iter().map(|active: &Active| active.view);
                taken.find(|&view| way_to(view).is_some_and(|other| apart_deg(way, other) < min_deg))
            });
            let why = match close {
                Some(view) => Some(Why::Angle(view)),
                None if selection.active.len() >= most => Some(Why::Limit),
                None if selection.active.len() >= fast_enough => Some(Why::Performance),
                None => None,
            };
            match why {
                Some(why) => selection.culled.push((active.view, why)),
                None => selection.active.push(active),
            }
        }
        self.give_slots(&mut selection.active);
        selection
    }

    pub fn measured(&mut self, frame_ms: f64, views: usize) {
        if let Some(performance) = &mut self.performance {
            performance.measured(frame_ms, views);
        }
    }

    /// Returns all candidates in order of priority. Slots are 0 until assigned.
    fn by_priority(&self, candidates: &[Candidate], eye: DVec3) -> Vec<Active> {
        let middle = || candidates.iter().map(|candidate| candidate.position).sum::<DVec3>() / candidates.len() as f64;
        let pivot = self.settings.pivot.unwrap_or_else(middle);
        let active = |&Candidate { view, position }: &Candidate| {
            let angle_deg = angle_at_pivot_deg(position - pivot, eye - pivot);
            Active { slot: 0, view, distance_m: position.distance(eye), angle_deg }
        };
        let mut all: Vec<Active> = candidates.iter().map(active).collect();
        all.sort_by(|a, b| {
            let by_angle = match self.settings.priority {
                ViewPriority::Distance => std::cmp::Ordering::Equal,
                ViewPriority::Angle => a.angle_deg.total_cmp(&b.angle_deg),
            };
            by_angle.then(a.distance_m.total_cmp(&b.distance_m)).then(a.view.cmp(&b.view))
        });
        all
    }

    /// Assigns slots: views that have a slot keep it, and others take the first free one.
    fn give_slots(&mut self, active: &mut [Active]) {
        for slot in &mut self.slots {
            *slot = slot.filter(|&view| active.iter().any(|active| active.view == view));
        }
        for active in active {
            let has = |wanted: Option<usize>| move |slot: &Option<usize>| *slot == wanted;
            let slot = self.slots.iter().position(has(Some(active.view)));
            active.slot = slot.or_else(|| self.slots.iter().position(has(None))).unwrap_or_else(|| {
                self.slots.push(None);
                self.slots.len() - 1
            });
            self.slots[active.slot] = Some(active.view);
        }
    }
}

/// Returns the angle in degrees, at the reference point, between a view and the eye.
fn angle_at_pivot_deg(to_view: DVec3, to_eye: DVec3) -> f64 {
    if to_eye == DVec3::ZERO {
        0.0
    } else if to_view == DVec3::ZERO {
        90.0
    } else {
        angle_deg(to_view, to_eye)
    }
}

/// Returns the angle in degrees, at the eye, between two views, given the vectors to them.
fn apart_deg(a: DVec3, b: DVec3) -> f64 {
    match (a == DVec3::ZERO, b == DVec3::ZERO) {
        (true, true) => 0.0,
        (true, false) | (false, true) => 180.0,
        (false, false) => angle_deg(a, b),
    }
}

/// Returns the angle in degrees between two nonzero vectors; accurate for small angles.
fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[cfg(test)]
mod tests;
