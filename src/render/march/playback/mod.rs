//! Playback of animated light fields: view selection, decoding, rendering, timing (CALF 6.2, 6.3).

pub mod frames;
pub mod pacing;
pub mod performance;
pub mod selection;
pub mod trace;
