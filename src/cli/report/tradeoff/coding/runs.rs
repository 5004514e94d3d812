//! Reference points of coding sweeps.

use super::table::CODING;
use crate::report::tradeoff::kind::{Measured, Point, Setting};
use crate::report::tradeoff::study::Results;
use codec::image::StreamKind;

/// Returns the depth point coded in boxes, without modelling functions, whose other settings are `others`.
pub fn in_boxes<'a>(results: &'a Results, others: &[Setting]) -> Option<&'a Measured> {
    let others = others.iter().filter(|(name, _)| *name != "depth-codec").cloned();
    let settings = others.chain([("depth-codec", "aabb".to_owned())]).collect();
    results.of(&Point::new(&CODING, Some(StreamKind::Depth), settings))
}
