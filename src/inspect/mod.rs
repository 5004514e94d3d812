//! Statistics and coding maps of a container.

#![doc(hidden)]

mod chunk_counts;
mod coding_map;
mod measure;
mod patch;
mod report;
mod statistics;
mod unit_map;

pub use chunk_counts::{BlockCount, FrameCost};
pub use coding_map::{CellKeyframes, CodingMap, Extent, Survey, coding_map, survey, survey_steps};
pub use measure::{inspect, statistics, steps};
pub use patch::{Patch, Writing};
pub use report::{
    ChunksReport, ContainerReport, FrameReport, StreamReport, depth_kind_name, percent, projection_name, transfer_name,
};
pub use statistics::{
    Check, FrameRow, FrameRows, InspectSettings, Inspection, MAX_ROWS, Spread, StorageStats, StreamStats, Totals,
};
