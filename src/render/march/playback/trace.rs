//! Playback trace: one line of JSON per frame.

use serde::Serialize;

use crate::march::playback::selection::{Selection, Why};
use crate::views::LightField;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameTrace {
    /// Index of the frame request, from 0.
    pub shot: usize,
    pub frame: u32,
    /// Mean position of the cameras in metres.
    pub eye: [f64; 3],
    pub active: Vec<ActiveTrace>,
    /// Culled views that have the frame.
    pub culled: Vec<CulledTrace>,
    /// Units that were decoded.
    pub cells_decoded: u64,
    pub cells_skipped: u64,
    /// Stored bytes that were read.
    pub bytes_read: u64,
    /// Milliseconds of selection, decoding and update, before rendering.
    pub update_ms: f64,
    /// Milliseconds of rendering.
    pub render_ms: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ActiveTrace {
    pub slot: usize,
    pub probe: String,
    pub distance_m: f64,
    pub angle_deg: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CulledTrace {
    pub probe: String,
    /// `angle`, `limit` or `performance`.
    pub why: &'static str,
    /// View of higher priority that makes it redundant; only for `angle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
}

pub fn name(selection: &Selection, field: &LightField) -> (Vec<ActiveTrace>, Vec<CulledTrace>) {
    let named = |view: usize| field.views.get(view).map(|view| view.name.clone()).unwrap_or_default();
    let active = selection.active.iter().map(|active| ActiveTrace {
        slot: active.slot,
        probe: named(active.view),
        distance_m: active.distance_m,
        angle_deg: active.angle_deg,
    });
    let culled = selection.culled.iter().map(|&(view, why)| {
        let (why, by) = match why {
            Why::Angle(by) => ("angle", Some(named(by))),
            Why::Limit => ("limit", None),
            Why::Performance => ("performance", None),
        };
        CulledTrace { probe: named(view), why, by }
    });
    (active.collect(), culled.collect())
}
