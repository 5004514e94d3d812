//! Statistics and coding maps of a container.

mod account;
mod chunk_counts;
mod coding_map;
mod measure;
mod report;
mod statistics;

pub use account::account;
pub use chunk_counts::{BlockCount, FrameCost, PredictiveCount, TransformCount};
pub use codec::unit_map::{Patch, Writing};
pub use coding_map::{CellCoding, CodingMap, Survey, coding_map, survey};
pub use measure::{inspect, statistics, steps};
pub use report::{ChunksReport, ContainerReport, FrameReport, percent, projection_name};
pub use statistics::{Check, FrameRows, InspectSettings, Inspection, StreamStats, Totals};
