//! Payload of a chunk of packed nodes: a keyframe and the nodes that change after it (depth.md 9).
//!
//! [`NodeChunk`] checks a payload and converts it to the runtime form, from which frames are decoded.

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::domain::Domain;
use crate::depth::mode_statistics::ModeStatistics;
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of};
use crate::depth::record_table;
use crate::depth::runtime::{Runtime, RuntimeFrame};
use crate::depth::storage::{self, Coverage, SECTION};
use crate::error::Result;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeRecord {
    pub frame: u32,
    pub updated_pixels: u64,
    /// Bytes of the record in the payload, including its row of the record table.
    pub bytes: u64,
    /// Number of nodes; for a tree including the functions of coarser places.
    pub nodes: u64,
    pub complete: bool,
}

pub(super) struct RecordNodes {
    pub nodes: Vec<Node>,
    /// Number of functions besides the nodes.
    pub functions: usize,
    pub complete: bool,
}

#[derive(Debug, Clone)]
pub struct NodeChunk {
    pub runtime: Runtime,
    pub records: Vec<NodeRecord>,
    domain: Domain,
    spare: Payload,
}

impl NodeChunk {
    /// Parses and checks a payload. On success all nodes lie in the unit, nodes of a record do not overlap, frames ascend, and
    /// the first record covers the unit.
    pub fn parse(payload: impl Into<Payload>, grid: Grid, frame_count: u32, domain: Domain) -> Result<NodeChunk> {
        Self::parse_records(payload.into(), (grid, SECTION), frame_count, domain, |at, fields| {
            let coverage = match fields.u8()? {
                0 => Coverage::Complete,
                1 if at > 0 => Coverage::Partial,
                kind => return Err(fields.error(format!("record {at} is of kind {kind}, which it cannot be"))),
            };
            let nodes = storage::read_nodes(grid, coverage, fields)?;
            Ok(RecordNodes { nodes, functions: 0, complete: coverage == Coverage::Complete })
        })
    }

    /// Reads the record table, and then each record with `read`, which gets the record's number.
    pub(super) fn parse_records(
        payload: Payload,
        (grid, section): (Grid, &'static str),
        frame_count: u32,
        domain: Domain,
        mut read: impl FnMut(usize, &mut Fields<'_>) -> Result<RecordNodes>,
    ) -> Result<NodeChunk> {
        let mut fields = Fields::new(&payload, 0, section);
        let (mut runtime, mut records) = (Runtime::new(grid), Vec::new());
        for (at, row) in record_table::read(&mut fields, frame_count)?.into_iter().enumerate() {
            record_table::check_start(&fields, at, row)?;
            let start = fields.position();
            let RecordNodes { nodes, functions, complete } = read(at, &mut fields)?;
            let updated_pixels = runtime.push(row.frame, &nodes);
            records.push(NodeRecord {
                frame: row.frame,
                updated_pixels,
                bytes: (fields.position() - start + record_table::ROW_BYTES) as u64,
                nodes: (nodes.len() + functions) as u64,
                complete,
            });
        }
        fields.finish()?;
        Ok(NodeChunk { runtime, records, domain, spare: payload })
    }

    /// Returns true if every record fills the unit with one code.
    pub fn is_constant(&self) -> bool {
        let is_root = |place: Place| place == self.runtime.grid.root();
        let constant = |(place, c): (Place, &[u8; COEFFICIENT_BYTES])| {
            is_root(place) && function_of(place.level, c) == Function::Biquadratic && c[..20] == [0; 20]
        };
        self.runtime.frames.iter().all(|&frame| self.runtime.nodes(frame).all(constant))
    }

    pub fn mode_statistics(&self) -> ModeStatistics {
        let mut statistics = ModeStatistics::default();
        for &frame in &self.runtime.frames {
            for (place, &coefficients) in self.runtime.nodes(frame) {
                statistics.count(self.runtime.grid, &Node { place, coefficients });
            }
        }
        statistics
    }

    /// Advances `picture` from frame `at` of this chunk (`None`: no frame shown yet) to `target` in steps of at most `window`
    /// frames; returns the number of pixels written.
    pub fn advance(&self, picture: &mut [u16], at: Option<u32>, target: u32, window: u8) -> u64 {
        let frames = &self.runtime.frames;
        record_table::steps(frames, |frame| frame.frame, at, target, window)
            .map(|found| self.apply(picture, frames[found]))
            .sum()
    }

    pub fn apply(&self, picture: &mut [u16], frame: RuntimeFrame) -> u64 {
        self.runtime.apply(picture, frame, &self.domain)
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.spare.into_spare()
    }
}
