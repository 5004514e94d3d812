//! Coding map of one unit, by codec; rectangles are relative to the upper left pixel of the unit.

use std::collections::HashMap;

use crate::color::transform::region::Content;
use crate::color::transform::{Keyed, TransformChunk};
use crate::color::{CellChunk, ColorChunk, Sample};
use crate::depth::node_chunk::NodeChunk;
use crate::depth::nodes::{Function, Grid, Place, function_of};
use crate::depth::predictive::PredictiveChunk;
use crate::depth::predictive::modes::BlockCoding;
use crate::depth::records::{Body, TemporalChunk};
use crate::depth::runtime::Runtime;
use crate::depth::tree_chunk::TreeChunk;
use crate::depth::{Texel, block_chunk};
use crate::error::Result;
use crate::streams::{DepthChunk, StreamChunk};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Writing {
    /// A node with a modelling function, or a BC4w block.
    Function(Function),
    OneValue,
    /// Plain values of a unit, a box or a block tile, or a keyframe stored as samples.
    Values,
    /// Blocks of a texture format.
    Blocks,
    /// Interpolation between two keyframes.
    Blend,
    /// A transform block of colour.
    Transform,
    /// A palette block of colour.
    Palette,
    /// A block of predictive coding.
    Predicted(BlockCoding),
}

/// A rectangle of pixels with the same coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    pub writing: Writing,
    /// Index, counted from 0 in the frame, of the node, box or unit that the patch belongs to. A box or unit of block tiles has
    /// several patches, and a function of the intermediate form has one per leaf.
    pub part: u32,
}

impl Patch {
    pub fn pixels(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }
}

#[derive(Debug, Default)]
pub struct UnitMap {
    pub patches: Vec<Patch>,
    pub keyframe: bool,
}

#[derive(Debug, Default)]
pub struct ChunkSurvey {
    pub keyframes_in_blocks: u64,
    pub keyframes_in_samples: u64,
    /// 1 for a chunk of the transform codec, whose first frame is a keyframe.
    pub transformed_keyframes: u64,
    /// Frames, counted from the first of the chunk, and their pixels: for depth and material all records but the first, for
    /// colour frames between keyframes.
    pub changed: Vec<(u32, u64)>,
    /// Frames of all colour keyframes but the first, and their pixels.
    pub later_keyframes: Vec<(u32, u64)>,
}

/// Returns the map of frame `at` of a chunk; `size` is the width and height of the unit in pixels.
pub fn unit_map(chunk: &StreamChunk, size: [u32; 2], at: u32) -> Result<UnitMap> {
    let grid = Grid { width: size[0], height: size[1] };
    let patches = match chunk {
        StreamChunk::Depth(DepthChunk::Boxes(chunk)) => of_record(chunk, at),
        StreamChunk::Depth(DepthChunk::Nodes(chunk)) => of_nodes(chunk, at),
        StreamChunk::Depth(DepthChunk::Tree(chunk)) => of_tree(chunk, at),
        StreamChunk::Depth(DepthChunk::Blocks(_)) => {
            let bc4w = |place| (place, Writing::Function(Function::Bc4w));
            of_places(grid, block_chunk::places(grid).map(bc4w))
        }
        StreamChunk::Depth(DepthChunk::Predictive(chunk)) => of_predictive(chunk, at)?,
        StreamChunk::Material(chunk) => of_record(chunk, at),
        StreamChunk::Alpha(chunk) => of_predictive(chunk, at)?,
        StreamChunk::Color8(chunk) => return Ok(of_color(chunk, at)),
        StreamChunk::ColorHalf(chunk) => return Ok(of_color(chunk, at)),
    };
    Ok(UnitMap { patches, keyframe: at == 0 })
}

fn nodes_at(runtime: &Runtime, at: u32) -> Vec<(Place, Function)> {
    let Ok(found) = runtime.frames.binary_search_by_key(&at, |frame| frame.frame) else { return Vec::new() };
    let nodes = runtime.nodes(runtime.frames[found]);
    nodes.map(|(place, coefficients)| (place, function_of(place.level, coefficients))).collect()
}

fn of_places(grid: Grid, places: impl Iterator<Item = (Place, Writing)>) -> Vec<Patch> {
    places.zip(0..).map(|((place, writing), part)| Patch { rect: grid.rect_of(place), writing, part }).collect()
}

fn of_nodes(chunk: &NodeChunk, at: u32) -> Vec<Patch> {
    let nodes = nodes_at(&chunk.runtime, at).into_iter();
    of_places(chunk.runtime.grid, nodes.map(|(place, function)| (place, Writing::Function(function))))
}

/// Returns the leaves of a tree, each with its coarsest function.
fn of_tree(chunk: &TreeChunk, at: u32) -> Vec<Patch> {
    let grid = chunk.leaves.runtime.grid;
    let functions: HashMap<Place, Function> = chunk.functions(at).map(|node| (node.place, node.function())).collect();
    let coarsest = |leaf: Place| {
        let above =
            |level: u8| Place { level, x: leaf.x.unbounded_shr(level.into()), y: leaf.y.unbounded_shr(level.into()) };
        let mut places = (1..=grid.root().level).rev().map(above);
        let found = places.find_map(|place| functions.get(&place).map(|&function| (place, function)));
        found.unwrap_or((leaf, Function::Raw))
    };
    let mut leaves: Vec<(Place, Place, Function)> = nodes_at(&chunk.leaves.runtime, at)
        .into_iter()
        .map(|(leaf, _)| {
            let (place, function) = coarsest(leaf);
            (leaf, place, function)
        })
        .collect();
    leaves.sort_by_key(|(leaf, _, _)| leaf.walk_key());
    let mut parts: HashMap<Place, u32> = HashMap::new();
    let patch = |(leaf, place, function)| {
        let next = parts.len() as u32;
        let part = *parts.entry(place).or_insert(next);
        Patch { rect: grid.rect_of(leaf), writing: Writing::Function(function), part }
    };
    leaves.into_iter().map(patch).collect()
}

/// Returns the blocks that differ from the previous frame. For a first frame, returns all blocks, or the whole unit as
/// background.
fn of_predictive(chunk: &PredictiveChunk, at: u32) -> Result<Vec<Patch>> {
    let mut patches = Vec::new();
    chunk.for_each_frame(|frame| {
        if frame.frame != at {
            return Ok(());
        }
        let is_first = at == 0;
        let written = frame.blocks.iter().filter(|block| is_first || block.coding != BlockCoding::Same);
        let coded = written.map(|block| (block.area.rect(), block.coding));
        let whole = ([0, 0, frame.size[0], frame.size[1]], BlockCoding::Background);
        let background = (is_first && frame.blocks.is_empty()).then_some(whole);
        let rects = coded.chain(background).zip(0..);
        patches.extend(rects.map(|((rect, coding), part)| Patch { rect, writing: Writing::Predicted(coding), part }));
        Ok(())
    })?;
    Ok(patches)
}

/// Returns the patches of the rectangles of a record.
fn of_record<T: Texel>(chunk: &TemporalChunk<T>, at: u32) -> Vec<Patch> {
    let Ok(found) = chunk.records.binary_search_by_key(&at, |record| record.frame) else { return Vec::new() };
    let body = chunk.records[found].body;
    if let Body::Constant(_) = body {
        let [width, height] = chunk.size;
        return vec![Patch { rect: [0, 0, width, height], writing: Writing::OneValue, part: 0 }];
    }
    let corners: Vec<[u32; 2]> = match body {
        Body::Boxes { .. } => chunk.boxes(body).iter().map(|(b, _)| [u32::from(b.x), u32::from(b.y)]).collect(),
        _ => vec![[0, 0]],
    };
    let rectangles = chunk.rectangles(body).zip(corners).zip(0..);
    let patches = rectangles.flat_map(|(((size, bytes), [left, top]), part)| {
        chunk.layout.parts::<T>(bytes, size).into_iter().map(move |tile| {
            let [x, y, width, height] = tile.rect.map(|pixels| pixels as u32);
            let writing = if tile.in_blocks { Writing::Blocks } else { Writing::Values };
            Patch { rect: [left + x, top + y, width, height], writing, part }
        })
    });
    patches.collect()
}

fn of_color<S: Keyed>(chunk: &ColorChunk<S>, at: u32) -> UnitMap {
    match chunk {
        ColorChunk::Cells(chunk) => of_cell(chunk, at),
        ColorChunk::Transform(chunk) => of_transform(chunk, at),
    }
}

/// Returns the blocks that differ from the previous frame.
fn of_transform(chunk: &TransformChunk, at: u32) -> UnitMap {
    let before = at.checked_sub(1).map(|before| before as usize);
    let patches = chunk.changed_leaves(at as usize, before).zip(0..).map(|((leaf, rect), part)| {
        let writing = match leaf.content {
            Content::Transform { .. } => Writing::Transform,
            Content::Palette(_) => Writing::Palette,
        };
        Patch { rect: rect.map(|side| side as u32), writing, part }
    });
    UnitMap { patches: patches.collect(), keyframe: at == 0 }
}

fn of_cell<S: Sample>(chunk: &CellChunk<S>, at: u32) -> UnitMap {
    let shown = chunk.blend(at);
    if at.checked_sub(1).is_some_and(|before| chunk.blend(before) == shown) {
        return UnitMap::default();
    }
    let keyframe = chunk.keyframes[shown.keyframe] == at;
    let writing = match keyframe {
        true if chunk.in_blocks(shown.keyframe) => Writing::Blocks,
        true => Writing::Values,
        false => Writing::Blend,
    };
    let [width, height] = chunk.format.size.map(|pixels| pixels as u32);
    UnitMap { patches: vec![Patch { rect: [0, 0, width, height], writing, part: 0 }], keyframe }
}

pub fn survey_chunk(chunk: &StreamChunk, frames: u32) -> Result<ChunkSurvey> {
    let changed = match chunk {
        StreamChunk::Depth(DepthChunk::Boxes(chunk)) => changes(chunk),
        StreamChunk::Depth(DepthChunk::Nodes(chunk)) => node_changes(&chunk.runtime),
        StreamChunk::Depth(DepthChunk::Tree(chunk)) => node_changes(&chunk.leaves.runtime),
        // Each frame is coded without reference to others.
        StreamChunk::Depth(DepthChunk::Blocks(_)) => Vec::new(),
        StreamChunk::Depth(DepthChunk::Predictive(chunk)) => predictive_changes(chunk)?,
        StreamChunk::Material(chunk) => changes(chunk),
        StreamChunk::Alpha(chunk) => predictive_changes(chunk)?,
        StreamChunk::Color8(chunk) => return Ok(survey_color(chunk, frames)),
        StreamChunk::ColorHalf(chunk) => return Ok(survey_color(chunk, frames)),
    };
    Ok(ChunkSurvey { changed, ..ChunkSurvey::default() })
}

fn changes<T: Texel>(chunk: &TemporalChunk<T>) -> Vec<(u32, u64)> {
    let later = chunk.records.iter().skip(1);
    later.map(|record| (record.frame, chunk.updated_pixels(record.body))).collect()
}

fn node_changes(runtime: &Runtime) -> Vec<(u32, u64)> {
    runtime.frames.iter().skip(1).map(|frame| (frame.frame, frame.updated_pixels)).collect()
}

fn predictive_changes(chunk: &PredictiveChunk) -> Result<Vec<(u32, u64)>> {
    let mut changes = Vec::new();
    chunk.for_each_frame(|frame| {
        if frame.frame > 0 {
            changes.push((frame.frame, frame.updated_pixels));
        }
        Ok(())
    })?;
    Ok(changes)
}

fn survey_color<S: Keyed>(chunk: &ColorChunk<S>, frames: u32) -> ChunkSurvey {
    match chunk {
        ColorChunk::Cells(chunk) => survey_cell(chunk),
        ColorChunk::Transform(chunk) => {
            let changed = |frame: u32| (frame, chunk.updated_pixels(frame as usize, Some(frame as usize - 1)));
            ChunkSurvey {
                transformed_keyframes: 1,
                changed: (1..frames).map(changed).collect(),
                ..ChunkSurvey::default()
            }
        }
    }
}

fn survey_cell<S: Sample>(chunk: &CellChunk<S>) -> ChunkSurvey {
    let keyframes = chunk.keyframes.len();
    let in_blocks = (0..keyframes).filter(|&keyframe| chunk.in_blocks(keyframe)).count();
    let between = (0..).zip(chunk.weights().1).filter(|(_, weight)| **weight != 0);
    let pixels = chunk.format.pixels() as u64;
    ChunkSurvey {
        keyframes_in_blocks: in_blocks as u64,
        keyframes_in_samples: (keyframes - in_blocks) as u64,
        changed: between.map(|(frame, _)| (frame, pixels)).collect(),
        transformed_keyframes: 0,
        later_keyframes: chunk.keyframes.iter().skip(1).map(|&frame| (frame, pixels)).collect(),
    }
}
