//! The payload of a chunk of the intermediate form: what a quadtree knows, to be flattened at any bound (depth.md 11).
//!
//! A record holds the leaves that differ from the frame before as they are, and the function of every coarser place
//! where one was found. Decoding it is lossless; [`crate::depth::node_encoder`] makes the packed form of it.

#[cfg(feature = "encode")]
pub mod encoder;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::bits::BitReader;
use crate::depth::domain::Domain;
use crate::depth::mode_statistics::ModeStatistics;
use crate::depth::node_chunk::NodeRecord;
use crate::depth::nodes::{Grid, Node, Place};
use crate::depth::record_table;
use crate::depth::runtime::Runtime;
use crate::depth::storage;
use crate::error::Result;

const SECTION: &str = "depth.md 11";

/// A function of a coarser place, and its largest error in codes.
#[derive(Debug, Clone, Copy)]
struct TreeFunction {
    node: Node,
    max_error: u16,
}

#[derive(Debug, Clone)]
pub struct TreeChunk {
    runtime: Runtime,
    domain: Domain,
    trees: Vec<Vec<TreeFunction>>,
    record_bytes: Vec<u64>,
    spare: Payload,
}

impl TreeChunk {
    /// Checks a payload for a unit of `grid`'s size and `frame_count` frames.
    pub fn parse(payload: impl Into<Payload>, grid: Grid, frame_count: u32, domain: Domain) -> Result<TreeChunk> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let table = record_table::read(&mut fields, frame_count)?;
        let (mut runtime, mut trees, mut record_bytes) = (Runtime::new(grid), Vec::new(), Vec::new());
        for (at, &row) in table.iter().enumerate() {
            fields.enter(SECTION);
            record_table::check_start(&fields, at, row)?;
            let start = fields.position();
            let (leaves, tree) = read_record(grid, &mut fields)?;
            if at == 0 && leaves.len() != grid.leaves().iter().product::<usize>() {
                return Err(fields.error("a chunk's first record must hold all leaves"));
            }
            runtime.push(row.frame, &leaves);
            trees.push(tree);
            record_bytes.push((fields.position() - start + record_table::ROW_BYTES) as u64);
        }
        fields.finish()?;
        Ok(TreeChunk { runtime, domain, trees, record_bytes, spare: payload })
    }

    /// The leaves of all records, in the runtime form.
    pub fn runtime(&self) -> &Runtime {
        &self.runtime
    }

    /// The records, in order of their frames; leaves and functions count as nodes.
    pub fn records(&self) -> impl Iterator<Item = NodeRecord> {
        let costs = self.record_bytes.iter().zip(&self.trees);
        self.runtime.frames().iter().zip(costs).map(|(frame, (&bytes, tree))| NodeRecord {
            frame: frame.frame,
            updated_pixels: frame.updated_pixels,
            bytes,
            nodes: frame.nodes + tree.len() as u64,
            complete: frame.updated_pixels == self.runtime.grid().pixel_count(),
        })
    }

    pub fn mode_statistics(&self) -> ModeStatistics {
        let mut statistics = ModeStatistics::default();
        let grid = self.runtime.grid();
        for &frame in self.runtime.frames() {
            for (place, &coefficients) in self.runtime.nodes(frame) {
                statistics.count(grid, &Node { place, coefficients });
            }
        }
        self.trees.iter().flatten().for_each(|found| statistics.count(grid, &found.node));
        statistics
    }

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target`; each frame
    /// between is visited. Answers how many pixels were written.
    pub fn advance(&self, picture: &mut [u16], at: Option<u32>, target: u32) -> u64 {
        let frames = self.runtime.frames();
        record_table::steps(frames, |frame| frame.frame, at, target, 1)
            .map(|found| self.runtime.apply(picture, frames[found], &self.domain))
            .sum()
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.spare.into_spare()
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
