//! The payload of a chunk of the intermediate form: what a quadtree knows, to be flattened at any bound (depth.md 11).
//!
//! A record holds the leaves that differ from the frame before as they are, and the function of every coarser place
//! where one was found. Decoding it is lossless; [`crate::depth::node_encoder`] makes the packed form of it.

use crate::container::EncodedChunk;
use crate::container::Payload;
use crate::container::fields::{Fields, PutFields};
use crate::depth::bits::{BitReader, BitWriter};
use crate::depth::block::{Accuracy, Block};
use crate::depth::census::NodeCensus;
use crate::depth::domain::Domain;
use crate::depth::mode_decision::{Approximation, Modelling, Rounding};
use crate::depth::node_chunk::NodeRecord;
use crate::depth::node_encoder::NodeSettings;
use crate::depth::nodes::{Grid, Node, Place, raw};
use crate::depth::quadtree::{self, Build, Known, Leaf, Tree, Wanted};
use crate::depth::record_table::{self, TableBuilder};
use crate::depth::runtime::Runtime;
use crate::depth::storage;
use crate::depth::temporal::CLOSE_AT_BYTES;
use crate::error::Result;

const SECTION: &str = "depth.md 11";

/// A payload that has been checked.
#[derive(Debug, Clone)]
pub struct TreeChunk {
    /// The leaves, in the runtime form.
    runtime: Runtime,
    domain: Domain,
    trees: Vec<Vec<Approximation>>,
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

    /// The approximations of a frame, and the leaves that they were searched for. Squared errors are not stored and
    /// read 0.
    pub fn known(&self, frame: u32) -> Known {
        let [columns, rows] = self.runtime.grid().leaves();
        let mut known = Known { leaves: vec![false; columns * rows], ..Known::default() };
        if let Ok(at) = self.runtime.frames().binary_search_by_key(&frame, |row| row.frame) {
            known.tree = self.trees[at].iter().map(|found| (found.node.place, *found)).collect();
            for (place, _) in self.runtime.nodes(self.runtime.frames()[at]) {
                known.leaves[usize::from(place.y) * columns + usize::from(place.x)] = true;
            }
        }
        known
    }

    /// All leaves and approximations, counted.
    pub fn census(&self) -> NodeCensus {
        let mut census = NodeCensus::default();
        let grid = self.runtime.grid();
        for &frame in self.runtime.frames() {
            for (place, &coefficients) in self.runtime.nodes(frame) {
                census.count(grid, &Node { place, coefficients });
            }
        }
        self.trees.iter().flatten().for_each(|found| census.count(grid, &found.node));
        census
    }

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target`; each frame
    /// between is visited. Answers how many pixels were written.
    pub fn advance(&self, picture: &mut [u16], at: Option<u32>, target: u32) -> u64 {
        let frames = self.runtime.frames();
        record_table::steps(frames, |frame| frame.frame, at, target, 1)
            .map(|found| self.runtime.apply(picture, frames[found], &self.domain))
            .sum()
    }

    /// The payload's memory, for the next chunk.
    pub fn into_spare(self) -> Vec<u8> {
        self.spare.into_spare()
    }
}

fn read_record(grid: Grid, fields: &mut Fields<'_>) -> Result<(Vec<Node>, Vec<Approximation>)> {
    let (mut leaves, mut coarse) = (Vec::new(), Vec::new());
    let mut bits = BitReader::new(fields);
    read_walk(grid, grid.root(), &mut bits, [&mut leaves, &mut coarse])?;
    bits.finish()?;
    let leaves = storage::read_functions(&leaves, fields)?;
    let coarse = storage::read_functions(&coarse, fields)?;
    fields.enter(SECTION);
    let found = coarse
        .into_iter()
        .map(|node| Ok(Approximation { node, accuracy: Accuracy { max_error: fields.u16()?, squared_error: 0 } }));
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

/// Encodes one unit in the intermediate form.
#[derive(Debug)]
pub struct TreeEncoder {
    settings: NodeSettings,
    domain: Domain,
    grid: Grid,
    held: Vec<u16>,
    open: Option<TableBuilder>,
    chunk_first: u32,
    next_frame: u32,
}

impl TreeEncoder {
    /// An encoder for a unit of `grid`'s size, at most 1024×1024. Of the settings, window and epsilon play no part.
    pub fn new(grid: Grid, domain: Domain, settings: NodeSettings) -> TreeEncoder {
        let held = vec![0; grid.pixel_count() as usize];
        TreeEncoder { settings, domain, grid, held, open: None, chunk_first: 0, next_frame: 0 }
    }

    /// Takes the next frame. Answers the chunk that it closes, if any.
    pub fn push(&mut self, source: &[u16]) -> Result<Option<EncodedChunk>> {
        let frame = self.next_frame;
        let full = |open: &TableBuilder| {
            frame - self.chunk_first >= self.settings.keyframe_interval || open.bytes() >= CLOSE_AT_BYTES
        };
        let finished = if self.open.as_ref().is_some_and(full) { self.finish()? } else { None };
        self.next_frame += 1;
        let keyframe = self.open.is_none();
        if keyframe {
            self.chunk_first = frame;
        }
        let [columns, rows] = self.grid.leaves();
        let width = self.grid.width as usize;
        let differs = |at: usize| {
            let place = Place { level: 0, x: (at % columns) as u8, y: (at / columns) as u8 };
            let of = |picture| Block::of(picture, width, 0, place.pixel());
            keyframe || of(source).rows().ne(of(&self.held).rows())
        };
        let leaves: Vec<Leaf> =
            (0..columns * rows).map(|at| if differs(at) { Leaf::Wanted } else { Leaf::Free }).collect();
        if keyframe || leaves.contains(&Leaf::Wanted) {
            let wanted = Wanted { picture: source, grid: self.grid, leaves: &leaves };
            let modelling = self.settings.modelling(&self.domain);
            let modelling = Modelling { rounding: Rounding::Exact, ..modelling };
            let build = Build { modelling, min_children: self.settings.min_children, known: None };
            let tree = quadtree::build(&wanted, &build);
            let open = self.open.get_or_insert_with(TableBuilder::default);
            write_record(&wanted, &tree, open.begin(frame - self.chunk_first));
        }
        self.held.copy_from_slice(source);
        Ok(finished)
    }

    /// Closes the open chunk, if there is one.
    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        let Some(open) = self.open.take() else { return Ok(None) };
        let (first_frame, frame_count) = (self.chunk_first, self.next_frame - self.chunk_first);
        Ok(Some(EncodedChunk { first_frame, frame_count, payload: open.finish()? }))
    }
}

fn write_record(wanted: &Wanted<'_>, tree: &Tree, out: &mut Vec<u8>) {
    let mut walk = Walk { wanted, tree, bits: BitWriter::default(), leaves: Vec::new(), coarse: Vec::new() };
    walk.visit(wanted.grid.root());
    out.extend(walk.bits.finish());
    storage::write_functions(&walk.leaves, out);
    let coarse: Vec<Node> = walk.coarse.iter().map(|found| found.node).collect();
    storage::write_functions(&coarse, out);
    walk.coarse.iter().for_each(|found| out.put_u16(found.accuracy.max_error));
}

struct Walk<'a> {
    wanted: &'a Wanted<'a>,
    tree: &'a Tree,
    bits: BitWriter,
    leaves: Vec<Node>,
    coarse: Vec<Approximation>,
}

impl Walk<'_> {
    fn visit(&mut self, place: Place) {
        if !self.wanted.grid.has(place) {
            return;
        }
        let exists = self.wanted.any(place);
        self.bits.put(u16::from(exists), 1);
        if !exists {
            return;
        }
        if place.level == 0 {
            self.leaves.push(Node { place, coefficients: raw::encode(&self.wanted.block(place)) });
            return;
        }
        let found = self.tree.get(&place);
        self.bits.put(u16::from(found.is_some()), 1);
        self.coarse.extend(found);
        place.children().into_iter().for_each(|child| self.visit(child));
    }
}
