//! Encodes the frames of one unit as packed nodes: a keyframe, then nodes over the changes (GDC 2.1, 3, 4).
//!
//! Input: the unit's codes, frame by frame. Output: payloads of [`crate::depth::node_chunk`].
//!
//! The loop is closed: a leaf is dirty if a pixel of the source differs from the decoder's picture by more than the sum of bound
//! and epsilon. For the window rule (depth.md 4) a node is sent again, bit for bit, in the W − 1 frames after its first, because
//! an approximation of the decoder's picture would be a different picture. If one of its leaves becomes dirty within that time,
//! the whole node is modelled again.

use crate::container::EncodedChunk;
use crate::depth::block::BlockMut;
use crate::depth::domain::Domain;
use crate::depth::mode_decision::{Decide, Modelling, Rounding};
use crate::depth::nodes::{Grid, Node};
use crate::depth::open_chunk::OpenChunk;
use crate::depth::quadtree::{self, Build, DirtyLeaves, Known, Leaf};
use crate::depth::runtime::decode_node;
use crate::depth::storage;
use crate::depth::texel::Texel;
use crate::effort::Effort;
use crate::error::{Error, Result};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeSettings {
    /// W, 1 to 255: a decoder may step over up to W − 1 frames.
    pub window: u8,
    /// Difference in codes, in addition to the bound, up to which the source may differ from the decoder's picture without an
    /// update.
    pub epsilon: u16,
    pub keyframe_interval: u32,
    pub bound: u16,
    pub decide: Decide,
    pub effort: Effort,
    /// Minimum number of changed children, 1 to 4, for which a function is tried for their parent.
    pub min_children: u8,
}

impl Default for NodeSettings {
    fn default() -> Self {
        NodeSettings {
            window: 2,
            epsilon: 0,
            keyframe_interval: 64,
            bound: 100,
            decide: Decide::Mse,
            effort: Effort::Normal,
            min_children: 3,
        }
    }
}

impl NodeSettings {
    pub fn check(&self) -> Result<()> {
        let wrong = |what: &str| Err(Error::Usage(what.to_owned()));
        match self {
            NodeSettings { window: 0, .. } => wrong("the depth window must be 1 to 255 frames"),
            NodeSettings { keyframe_interval: 0, .. } => wrong("the keyframe interval must be at least 1 frame"),
            NodeSettings { min_children, .. } if !(1..=4).contains(min_children) => {
                wrong("the least number of children must be 1 to 4")
            }
            _ => Ok(()),
        }
    }

    pub fn modelling<'a>(&self, domain: &'a Domain) -> Modelling<'a> {
        let rounding = match self.decide {
            Decide::Mse => Rounding::Slight,
            Decide::Size => Rounding::ToBound,
        };
        Modelling { domain, bound: self.bound, decide: self.decide, rounding, effort: self.effort }
    }
}

#[derive(Debug, Clone, Copy)]
struct Recent {
    node: Node,
    /// Frame in which the node was first sent, counted from the keyframe.
    first_sent: u32,
}

#[derive(Debug)]
pub struct NodeEncoder {
    settings: NodeSettings,
    domain: Domain,
    grid: Grid,
    held: Vec<u16>,
    recent: Vec<Recent>,
    leaves: Vec<Leaf>,
    chunk: OpenChunk,
}

impl NodeEncoder {
    pub fn new(grid: Grid, domain: Domain, settings: NodeSettings) -> NodeEncoder {
        let [columns, rows] = grid.leaves();
        NodeEncoder {
            settings,
            domain,
            grid,
            held: vec![0; grid.pixel_count() as usize],
            recent: Vec::new(),
            leaves: vec![Leaf::Free; columns * rows],
            chunk: OpenChunk::new(settings.keyframe_interval),
        }
    }

    /// Encodes a frame. `known` is the search result for this frame at a larger bound. Returns the previous chunk if this frame
    /// starts a new one.
    pub fn push(&mut self, source: &[u16], known: Option<&Known>) -> Result<Option<EncodedChunk>> {
        let finished = self.chunk.count_frame(source.len())?;
        let frame = self.chunk.frame();
        if frame == 0 {
            self.recent.clear();
            self.leaves.fill(Leaf::Dirty);
        } else {
            let window = u32::from(self.settings.window);
            self.recent.retain(|recent| frame - recent.first_sent < window);
            self.mark_changes(source);
            self.settle_recent();
        }
        let nodes = self.model(source, known);
        let width = self.grid.width as usize;
        for Node { place, coefficients } in &nodes {
            let target = &mut BlockMut::of(&mut self.held, width, place.level, place.pixel());
            decode_node(*place, coefficients, &self.domain, target);
        }
        let mut sent: Vec<Node> = self.recent.iter().map(|recent| recent.node).chain(nodes.iter().copied()).collect();
        sent.sort_by_key(|node| node.place.walk_key());
        // The nodes of the keyframe are not repeated, because decoders enter a chunk only at its keyframe.
        if frame > 0 {
            self.recent.extend(nodes.into_iter().map(|node| Recent { node, first_sent: frame }));
        }
        if !sent.is_empty() {
            storage::write_record(self.grid, &sent, self.chunk.record());
        }
        Ok(finished)
    }

    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        self.chunk.finish()
    }

    fn mark_changes(&mut self, source: &[u16]) {
        let tolerance = self.settings.bound.saturating_add(self.settings.epsilon);
        let (width, [columns, _]) = (self.grid.width as usize, self.grid.leaves());
        self.leaves.fill(Leaf::Free);
        for (y, (held, source)) in self.held.chunks(width).zip(source.chunks(width)).enumerate() {
            let leaves = &mut self.leaves[y / 4 * columns..][..columns];
            for ((leaf, held), source) in leaves.iter_mut().zip(held.chunks(4)).zip(source.chunks(4)) {
                if held.iter().zip(source).any(|(&held, &source)| !u16::within(held, source, tolerance)) {
                    *leaf = Leaf::Dirty;
                }
            }
        }
    }

    /// Marks all leaves of a recent node as dirty if one of them is, and otherwise as held, so that no other node covers them.
    fn settle_recent(&mut self) {
        let (grid, leaves) = (self.grid, &mut self.leaves);
        self.recent.retain(|recent| {
            let changes = grid.leaf_rows(recent.node.place).any(|row| leaves[row].contains(&Leaf::Dirty));
            let leaf = if changes { Leaf::Dirty } else { Leaf::Held };
            grid.leaf_rows(recent.node.place).for_each(|row| leaves[row].fill(leaf));
            !changes
        });
    }

    fn model(&self, source: &[u16], known: Option<&Known>) -> Vec<Node> {
        if !self.leaves.contains(&Leaf::Dirty) {
            return Vec::new();
        }
        let dirty = DirtyLeaves { picture: source, grid: self.grid, leaves: &self.leaves };
        let modelling = self.settings.modelling(&self.domain);
        let build = Build { modelling, min_children: self.settings.min_children, known };
        quadtree::flatten(&dirty, &quadtree::build(&dirty, &build))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::domain::DomainKind;
    use crate::depth::node_chunk::NodeChunk;
    use crate::depth::quantise::DepthRange;

    const GRID: Grid = Grid { width: 29, height: 18 };

    fn domain() -> Domain {
        Domain::new(DomainKind::Log, DepthRange::new(1.0, 10.0).unwrap()).unwrap()
    }

    fn encode(frames: &[Vec<u16>], settings: NodeSettings) -> Vec<EncodedChunk> {
        let mut encoder = NodeEncoder::new(GRID, domain(), settings);
        let mut chunks = Vec::new();
        for frame in frames {
            chunks.extend(encoder.push(frame, None).unwrap());
        }
        chunks.extend(encoder.finish().unwrap());
        assert_eq!(chunks.iter().map(|chunk| chunk.frame_count as usize).sum::<usize>(), frames.len());
        chunks
    }

    /// Decodes along the canonical path and along random legal ones; all must show the same pictures, within the bound.
    fn check_all_paths(frames: &[Vec<u16>], settings: NodeSettings) {
        let mut seed = 7u32;
        let domain = domain();
        for chunk in encode(frames, settings) {
            let parsed = NodeChunk::parse(chunk.payload, GRID, chunk.frame_count, domain.clone()).unwrap();
            parsed.check_window(settings.window, chunk.frame_count).unwrap();
            let mut canonical = vec![vec![0; frames[0].len()]];
            parsed.advance(&mut canonical[0], None, 0, 1);
            for frame in 1..chunk.frame_count {
                let mut picture = canonical[frame as usize - 1].clone();
                parsed.advance(&mut picture, Some(frame - 1), frame, 1);
                canonical.push(picture);
            }
            for (at, picture) in canonical.iter().enumerate() {
                let source = &frames[chunk.first_frame as usize + at];
                let tolerance = settings.bound + settings.epsilon;
                let ok = picture.iter().zip(source).all(|(&held, &source)| u16::within(held, source, tolerance));
                assert!(ok, "frame {at} leaves the bound");
            }
            for _ in 0..30 {
                let (mut picture, mut frame) = (canonical[0].clone(), 0);
                while frame + 1 < chunk.frame_count {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let step = 1 + (seed >> 16) % u32::from(settings.window);
                    let next = (frame + step).min(chunk.frame_count - 1);
                    // This is a single step, because it is no longer than the window.
                    parsed.advance(&mut picture, Some(frame), next, settings.window);
                    frame = next;
                    assert_eq!(picture, canonical[frame as usize], "frame {frame}");
                }
            }
        }
    }

    fn random_frames(count: usize) -> Vec<Vec<u16>> {
        let mut seed = 3u32;
        let mut next = |n: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 12) % n
        };
        let pixels = GRID.pixel_count() as usize;
        let width = GRID.width as usize;
        let plane = |x: usize, y: usize| (20_000 + 37 * x + 91 * y) as u16;
        let mut frames = vec![(0..pixels).map(|at| plane(at % width, at / width)).collect::<Vec<u16>>()];
        for _ in 1..count {
            let mut frame = frames[frames.len() - 1].clone();
            for _ in 0..next(4) {
                let at = next(pixels as u32) as usize;
                frame[at] = match next(4) {
                    0 => u16::MAX,
                    1 => frame[at].saturating_add(30),
                    2 => plane(at % width, at / width),
                    _ => next(65_536) as u16,
                };
            }
            if next(5) == 0 {
                // Writes a block of another depth.
                let (left, top) = (next(20) as usize, next(10) as usize);
                for y in top..top + 8 {
                    frame[y * width + left..][..9].fill(9000 + next(50) as u16);
                }
            }
            frames.push(frame);
        }
        frames
    }

    #[test]
    fn every_legal_path_shows_the_same_frames_within_the_bound() {
        let frames = random_frames(40);
        for window in [1, 2, 3, 16, 100] {
            for (bound, epsilon) in [(0, 0), (30, 0), (100, 10), (1000, 0)] {
                for (decide, min_children, keyframe_interval) in
                    [(Decide::Mse, 3, 1000), (Decide::Size, 1, 20), (Decide::Size, 4, 1)]
                {
                    let settings = NodeSettings {
                        window,
                        epsilon,
                        keyframe_interval,
                        bound,
                        decide,
                        effort: Effort::Fast,
                        min_children,
                    };
                    check_all_paths(&frames, settings);
                }
            }
        }
    }

    #[test]
    fn creep_for_600_frames_stays_within_bound_and_epsilon() {
        let frames: Vec<Vec<u16>> = (0..600u16).map(|n| vec![1000 + n; GRID.pixel_count() as usize]).collect();
        let settings = NodeSettings { bound: 20, epsilon: 5, keyframe_interval: 1000, ..NodeSettings::default() };
        check_all_paths(&frames, settings);
    }

    #[test]
    fn a_static_unit_has_one_record() {
        let frames = vec![random_frames(1).remove(0); 30];
        let chunks = encode(&frames, NodeSettings::default());
        assert_eq!(chunks.len(), 1);
        let parsed = NodeChunk::parse(chunks[0].payload.clone(), GRID, 30, domain()).unwrap();
        assert_eq!(parsed.records.len(), 1);
    }
}
