//! Payload of a chunk of the intermediate form: a quadtree that can be flattened at any bound up to the header's (depth.md 11).
//!
//! A record contains the leaves that differ from the frame before, as raw codes, and the function of every coarser place for
//! which one was found. Decoding is lossless; [`crate::depth::node_encoder`] converts it to the packed form.

#[cfg(feature = "encode")]
pub mod encoder;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::bits::BitReader;
use crate::depth::domain::Domain;
use crate::depth::mode_statistics::ModeStatistics;
use crate::depth::node_chunk::{NodeChunk, RecordNodes};
use crate::depth::nodes::{Grid, Node, Place};
use crate::depth::storage;
use crate::error::Result;

const SECTION: &str = "depth.md 11";

#[derive(Debug, Clone, Copy)]
struct TreeFunction {
    node: Node,
    #[cfg_attr(not(feature = "encode"), expect(dead_code))]
    max_error: u16,
}

#[derive(Debug, Clone)]
pub struct TreeChunk {
    /// Leaves of all records. Frames are decoded in steps of 1.
    pub leaves: NodeChunk,
    trees: Vec<Vec<TreeFunction>>,
}

impl TreeChunk {
    pub fn parse(payload: impl Into<Payload>, grid: Grid, frame_count: u32, domain: Domain) -> Result<TreeChunk> {
        let mut trees = Vec::new();
        let leaves = NodeChunk::parse_records(payload.into(), (grid, SECTION), frame_count, domain, |at, fields| {
            let (nodes, tree) = read_record(grid, fields)?;
            let complete = nodes.len() == grid.leaves().iter().product::<usize>();
            if at == 0 && !complete {
                return Err(fields.error("a chunk's first record must hold all leaves"));
            }
            let functions = tree.len();
            trees.push(tree);
            Ok(RecordNodes { nodes, functions, complete })
        })?;
        Ok(TreeChunk { leaves, trees })
    }

    /// Returns the functions of coarser places in a frame; none if the frame has no record.
    pub fn functions(&self, frame: u32) -> impl Iterator<Item = &Node> {
        let record = self.leaves.runtime.frames.binary_search_by_key(&frame, |row| row.frame).ok();
        record.into_iter().flat_map(|at| &self.trees[at]).map(|found| &found.node)
    }

    pub fn mode_statistics(&self) -> ModeStatistics {
        let mut statistics = self.leaves.mode_statistics();
        let grid = self.leaves.runtime.grid;
        self.trees.iter().flatten().for_each(|found| statistics.count(grid, &found.node));
        statistics
    }
}

fn read_record(grid: Grid, fields: &mut Fields<'_>) -> Result<(Vec<Node>, Vec<TreeFunction>)> {
    let (mut leaves, mut coarse) = (Vec::new(), Vec::new());
    let mut bits = BitReader::new(fields);
    read_walk(grid, grid.root(), &mut bits, [&mut leaves, &mut coarse])?;
    bits.finish()?;
    let leaves = storage::read_functions(&leaves, fields)?;
    let coarse = storage::read_functions(&coarse, fields)?;
    fields.enter(SECTION);
    let found = coarse.into_iter().map(|node| Ok(TreeFunction { node, max_error: fields.u16()? }));
    let found = found.collect::<Result<_>>()?;
    Ok((leaves, found))
}

fn read_walk(grid: Grid, place: Place, bits: &mut BitReader<'_, '_>, out: [&mut Vec<Place>; 2]) -> Result<()> {
    if !grid.has(place) || !bits.bit()? {
        return Ok(());
    }
    let [leaves, coarse] = out;
    if place.level == 0 {
        leaves.push(place);
        return Ok(());
    }
    if bits.bit()? {
        coarse.push(place);
    }
    place.children().into_iter().try_for_each(|child| read_walk(grid, child, bits, [leaves, coarse]))
}
