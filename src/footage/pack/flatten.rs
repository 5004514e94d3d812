//! Packs the intermediate form: converts chunks of trees to chunks of packed nodes at an error bound (depth.md 11, 9).
//!
//! Each chunk of trees starts with all leaves, so chunks can be packed independently and in any order.

use crate::encode::ErrorBound;
use codec::container::{ChunkEntry, EncodedChunk, Reader, StreamEntry};
use codec::depth::domain::Domain;
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::{NodeEncoder, NodeSettings};
use codec::depth::nodes::Grid;
use codec::depth::tree_chunk::TreeChunk;
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use codec::streams::{CodecHeader, DEPTH_TREE, DepthCoding, DepthHeader, NodeHeader};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlattenSettings {
    /// Maximum error of a node; at most the error that the tree was built for.
    pub error: ErrorBound,
    pub window: u8,
    pub epsilon: u16,
    pub decide: Decide,
    pub effort: Effort,
    pub min_children: u8,
}

#[derive(Debug)]
pub struct Flattener {
    entry: StreamEntry,
    settings: NodeSettings,
    domain: Domain,
    header: CodecHeader,
}

pub fn is_tree(entry: &StreamEntry) -> bool {
    entry.codec == DEPTH_TREE
}

impl Flattener {
    pub fn new(entry: &StreamEntry, settings: &FlattenSettings) -> Result<Flattener> {
        let header = CodecHeader::read(entry)?;
        let CodecHeader::Depth(depth @ DepthHeader { coding: DepthCoding::Tree(tree), .. }) = header else {
            return Err(Error::Usage("only streams of the intermediate form can be packed at an error bound".into()));
        };
        let bound = settings.error.codes(depth.range)?;
        if bound > tree.bound {
            return Err(Error::Usage(format!(
                "a maximum error of {bound} codes was requested, but the quadtree was built for at most ±{} codes: \
                reduce `max_error`, or run quadtree again with a larger one",
                tree.bound
            )));
        }
        let FlattenSettings { window, epsilon, decide, effort, min_children, .. } = *settings;
        let keyframe_interval = tree.keyframe_interval;
        let nodes = NodeHeader { window, epsilon, keyframe_interval, bound, domain: tree.domain };
        let settings = NodeSettings { window, epsilon, keyframe_interval, bound, decide, effort, min_children };
        settings.check()?;
        Ok(Flattener {
            entry: entry.clone(),
            settings,
            domain: tree.domain.domain()?,
            header: CodecHeader::Depth(DepthHeader { coding: DepthCoding::Nodes(nodes), ..depth }),
        })
    }

    pub fn entry(&self) -> StreamEntry {
        StreamEntry { codec: self.header.codec(), codec_header: self.header.write().into(), ..self.entry.clone() }
    }

    /// Packs a chunk; frames are numbered as in its key.
    pub fn flatten(&self, reader: &Reader, chunk: &ChunkEntry, monitor: &dyn Monitor) -> Result<Vec<EncodedChunk>> {
        let [_, _, width, height] = self.entry.unit_rect(chunk.key.unit);
        let grid = Grid { width, height };
        let frame_count = chunk.key.frame_count;
        let payload = reader.fetch(chunk)?;
        let trees = TreeChunk::parse(payload, grid, frame_count, self.domain.clone())
            .map_err(|error| reader.blame(chunk, error))?;
        let mut encoder = NodeEncoder::new(grid, self.domain.clone(), self.settings);
        let mut source = vec![0; grid.pixel_count() as usize];
        let mut finished = Vec::new();
        for frame in 0..frame_count {
            monitor.check()?;
            trees.leaves.advance(&mut source, frame.checked_sub(1), frame, 1);
            finished.extend(encoder.push(&source, Some(&trees.known(frame)))?);
        }
        finished.extend(encoder.finish()?);
        finished.iter_mut().for_each(|packed| packed.first_frame += chunk.key.first_frame);
        Ok(finished)
    }
}
