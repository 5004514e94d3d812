//! Encodes units in the intermediate form (depth.md 11).

use crate::container::EncodedChunk;
use crate::container::serialize::PutFields;
use crate::depth::bits::BitWriter;
use crate::depth::block::{Accuracy, Block};
use crate::depth::domain::Domain;
use crate::depth::mode_decision::{Approximation, Modelling, Rounding};
use crate::depth::node_encoder::NodeSettings;
use crate::depth::nodes::{Grid, Node, Place, raw};
use crate::depth::open_chunk::OpenChunk;
use crate::depth::quadtree::{self, Build, DirtyLeaves, Known, Leaf, Tree};
use crate::depth::storage;
use crate::depth::tree_chunk::{TreeChunk, TreeFunction};
use crate::error::Result;

impl TreeChunk {
    /// Returns the approximations of a frame, and the leaves for which they were searched. Squared errors are not stored and are
    /// returned as 0.
    pub fn known(&self, frame: u32) -> Known {
        let runtime = &self.leaves.runtime;
        let [columns, rows] = runtime.grid.leaves();
        let mut known = Known { leaves: vec![false; columns * rows], ..Known::default() };
        if let Ok(at) = runtime.frames.binary_search_by_key(&frame, |row| row.frame) {
            let found = self.trees[at].iter().map(|&TreeFunction { node, max_error }| {
                (node.place, Approximation { node, accuracy: Accuracy { max_error, squared_error: 0 } })
            });
            known.tree = found.collect();
            for (place, _) in runtime.nodes(runtime.frames[at]) {
                known.leaves[usize::from(place.y) * columns + usize::from(place.x)] = true;
            }
        }
        known
    }
}

#[derive(Debug)]
pub struct TreeEncoder {
    settings: NodeSettings,
    domain: Domain,
    grid: Grid,
    held: Vec<u16>,
    chunk: OpenChunk,
}

impl TreeEncoder {
    /// Creates an encoder. Window and epsilon of the settings are ignored.
    pub fn new(grid: Grid, domain: Domain, settings: NodeSettings) -> TreeEncoder {
        let held = vec![0; grid.pixel_count() as usize];
        TreeEncoder { settings, domain, grid, held, chunk: OpenChunk::new(settings.keyframe_interval) }
    }

    pub fn push(&mut self, source: &[u16]) -> Result<Option<EncodedChunk>> {
        let finished = self.chunk.count_frame(source.len())?;
        let keyframe = self.chunk.frame() == 0;
        let [columns, rows] = self.grid.leaves();
        let width = self.grid.width as usize;
        let differs = |at: usize| {
            let place = Place { level: 0, x: (at % columns) as u8, y: (at / columns) as u8 };
            let of = |picture| Block::of(picture, width, 0, place.pixel());
            keyframe || of(source).rows().ne(of(&self.held).rows())
        };
        let leaves: Vec<Leaf> =
            (0..columns * rows).map(|at| if differs(at) { Leaf::Dirty } else { Leaf::Free }).collect();
        if leaves.contains(&Leaf::Dirty) {
            let dirty = DirtyLeaves { picture: source, grid: self.grid, leaves: &leaves };
            let modelling = Modelling { rounding: Rounding::Exact, ..self.settings.modelling(&self.domain) };
            let build = Build { modelling, min_children: self.settings.min_children, known: None };
            write_record(&dirty, &quadtree::build(&dirty, &build), self.chunk.record());
        }
        self.held.copy_from_slice(source);
        Ok(finished)
    }

    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        self.chunk.finish()
    }
}

fn write_record(dirty: &DirtyLeaves<'_>, tree: &Tree, out: &mut Vec<u8>) {
    let mut walk = Walk { dirty, tree, bits: BitWriter::default(), leaves: Vec::new(), coarse: Vec::new() };
    walk.visit(dirty.grid.root());
    out.extend(walk.bits.finish());
    storage::write_functions(&walk.leaves, out);
    let coarse: Vec<Node> = walk.coarse.iter().map(|found| found.node).collect();
    storage::write_functions(&coarse, out);
    walk.coarse.iter().for_each(|found| out.put_u16(found.accuracy.max_error));
}

struct Walk<'a> {
    dirty: &'a DirtyLeaves<'a>,
    tree: &'a Tree,
    bits: BitWriter,
    leaves: Vec<Node>,
    coarse: Vec<Approximation>,
}

impl Walk<'_> {
    fn visit(&mut self, place: Place) {
        if !self.dirty.grid.has(place) {
            return;
        }
        let exists = self.dirty.any(place);
        self.bits.put(u16::from(exists), 1);
        if !exists {
            return;
        }
        if place.level == 0 {
            self.leaves.push(Node { place, coefficients: raw::encode(&self.dirty.block(place)) });
            return;
        }
        let found = self.tree.get(&place);
        self.bits.put(u16::from(found.is_some()), 1);
        self.coarse.extend(found);
        place.children().into_iter().for_each(|child| self.visit(child));
    }
}
