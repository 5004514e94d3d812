//! Compares containers, datasets and image sequences stream by stream.

mod bounds;
mod comparison;
mod difference;
mod domain;
mod error_map;
mod manifest_coding;
mod measure;
mod open;
mod pairing;
mod report;
mod side;

pub use bounds::{Bound, Bounds, Judgement, Violation};
pub use comparison::{Comparison, Measured, SampleTotal, StreamReport, side_name};
pub use difference::{Lowest, SampleErrors};
pub use domain::{ColorDomain, Domain, Origin};
pub use error_map::{CellPsnr, ErrorMap, LargestError, error_map};
pub use measure::{CompareSettings, Measure, SsimFrames, compare};
pub use open::{SideOptions, open_both};
pub use pairing::{Coverage, Pair, Pairing};
pub use side::{Coding, Side};
