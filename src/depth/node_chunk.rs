//! The payload of a chunk of packed nodes: a keyframe and the nodes that change after it (depth.md 9).
//!
//! [`NodeChunk`] checks a payload and brings it into the runtime form, which is then decoded.

#[cfg(feature = "encode")]
pub mod builder;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::domain::Domain;
use crate::depth::mode_statistics::ModeStatistics;
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of};
use crate::depth::record_table;
use crate::depth::runtime::{Runtime, RuntimeFrame};
use crate::depth::storage::{self, Coverage, SECTION};
use crate::error::Result;

const COMPLETE: u8 = 0;
const PARTIAL: u8 = 1;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeRecord {
    pub frame: u32,
    pub updated_pixels: u64,
    /// Payload bytes that it takes, its row of the table included.
    pub bytes: u64,
    pub nodes: u64,
    pub complete: bool,
}

#[derive(Debug, Clone)]
pub struct NodeChunk {
    runtime: Runtime,
    /// Payload bytes of each record, its row in the table included.
    record_bytes: Vec<u64>,
    complete: Vec<bool>,
    domain: Domain,
    spare: Payload,
}

impl NodeChunk {
    /// Checks a payload for a unit of `grid`'s size and `frame_count` frames.
    ///
    /// Afterwards all nodes lie in the unit, those of a record do not overlap, frames ascend, and the first record
    /// covers the unit.
    pub fn parse(payload: impl Into<Payload>, grid: Grid, frame_count: u32, domain: Domain) -> Result<NodeChunk> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let table = record_table::read(&mut fields, frame_count)?;
        let (mut runtime, mut record_bytes, mut complete) = (Runtime::new(grid), Vec::new(), Vec::new());
        for (at, &row) in table.iter().enumerate() {
            record_table::check_start(&fields, at, row)?;
            let start = fields.position();
            let coverage = match fields.u8()? {
                COMPLETE => Coverage::Complete,
                PARTIAL if at > 0 => Coverage::Partial,
                kind => return Err(fields.error(format!("record {at} is of kind {kind}, which it cannot be"))),
            };
            runtime.push(row.frame, &storage::read_nodes(grid, coverage, &mut fields)?);
            record_bytes.push((fields.position() - start + record_table::ROW_BYTES) as u64);
            complete.push(coverage == Coverage::Complete);
        }
        fields.finish()?;
        Ok(NodeChunk { runtime, record_bytes, complete, domain, spare: payload })
    }

    pub fn runtime(&self) -> &Runtime {
        &self.runtime
    }

    pub fn records(&self) -> impl Iterator<Item = NodeRecord> {
        let costs = self.record_bytes.iter().zip(&self.complete);
        self.runtime.frames().iter().zip(costs).map(|(frame, (&bytes, &complete))| NodeRecord {
            frame: frame.frame,
            updated_pixels: frame.updated_pixels,
            bytes,
            nodes: frame.nodes,
            complete,
        })
    }

    /// Whether every record fills the unit with one code.
    pub fn is_constant(&self) -> bool {
        let is_root = |place: Place| place == self.runtime.grid().root();
        let constant = |(place, c): (Place, &[u8; COEFFICIENT_BYTES])| {
            is_root(place) && function_of(place.level, c) == Function::Biquadratic && c[..20] == [0; 20]
        };
        self.runtime.frames().iter().all(|&frame| self.runtime.nodes(frame).all(constant))
    }

    pub fn mode_statistics(&self) -> ModeStatistics {
        let mut statistics = ModeStatistics::default();
        for &frame in self.runtime.frames() {
            for (place, &coefficients) in self.runtime.nodes(frame) {
                statistics.count(self.runtime.grid(), &Node { place, coefficients });
            }
        }
        statistics
    }

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target` in steps of at
    /// most `window` frames; answers how many pixels were written.
    pub fn advance(&self, picture: &mut [u16], at: Option<u32>, target: u32, window: u8) -> u64 {
        let frames = self.runtime.frames();
        record_table::steps(frames, |frame| frame.frame, at, target, window)
            .map(|found| self.apply(picture, frames[found]))
            .sum()
    }

    /// Writes the nodes of one of the runtime form's frames into `picture`; answers how many pixels that were.
    pub fn apply(&self, picture: &mut [u16], frame: RuntimeFrame) -> u64 {
        self.runtime.apply(picture, frame, &self.domain)
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.spare.into_spare()
    }
}
