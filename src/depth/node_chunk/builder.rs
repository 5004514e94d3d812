//! Writes the payload of a chunk of packed nodes (depth.md 9).

use crate::depth::node_chunk::{COMPLETE, PARTIAL};
use crate::depth::nodes::{Grid, Node};
use crate::depth::record_table::builder::TableBuilder;
use crate::depth::storage::{self, Coverage};
use crate::error::Result;

#[derive(Debug)]
pub struct NodeChunkBuilder {
    grid: Grid,
    records: TableBuilder,
}

impl NodeChunkBuilder {
    /// An empty chunk for a unit of `grid`'s size; the nodes that are pushed first must cover it.
    pub fn new(grid: Grid) -> NodeChunkBuilder {
        NodeChunkBuilder { grid, records: TableBuilder::default() }
    }

    /// Adds the nodes of a frame: they do not overlap and come in the order of the walk.
    pub fn push(&mut self, frame: u32, nodes: &[Node]) {
        let data = self.records.begin(frame);
        data.push(match storage::coverage(self.grid, nodes) {
            Coverage::Complete => COMPLETE,
            Coverage::Partial => PARTIAL,
        });
        storage::write_nodes(self.grid, nodes, data);
    }

    pub fn bytes(&self) -> usize {
        self.records.bytes()
    }

    pub fn finish(self) -> Result<Vec<u8>> {
        self.records.finish()
    }
}
