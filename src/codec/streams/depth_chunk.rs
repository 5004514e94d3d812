//! A parsed depth chunk of any codec.

use crate::container::Payload;
use crate::depth::block_chunk::BlockChunk;
use crate::depth::block_tiles::Layout;
use crate::depth::node_chunk::NodeChunk;
use crate::depth::nodes::Grid;
use crate::depth::predictive::{PredictiveChunk, UnitArea};
use crate::depth::records::TemporalChunk;
use crate::depth::tree_chunk::TreeChunk;
use crate::error::Result;
use crate::streams::header::{DepthCoding, DepthHeader};
use crate::streams::picture_chunk::PictureChunk;

#[derive(Debug, Clone)]
pub enum DepthChunk {
    Boxes(TemporalChunk<u16>),
    Nodes(NodeChunk),
    Tree(TreeChunk),
    Blocks(BlockChunk),
    Predictive(Box<PredictiveChunk>),
}

impl PictureChunk for DepthChunk {
    type Pixel = u16;
    type Header = DepthHeader;

    fn parse(header: &DepthHeader, payload: Payload, area: UnitArea, frames: u32) -> Result<DepthChunk> {
        let size = area.size();
        let grid = Grid { width: size[0], height: size[1] };
        Ok(match &header.coding {
            DepthCoding::Boxes(_) => DepthChunk::Boxes(TemporalChunk::parse(Layout::Values, payload, size, frames)?),
            DepthCoding::BoxesInBlocks(_) => {
                DepthChunk::Boxes(TemporalChunk::parse(Layout::BlockTiles, payload, size, frames)?)
            }
            DepthCoding::Nodes(nodes) => {
                DepthChunk::Nodes(NodeChunk::parse(payload, grid, frames, nodes.domain.domain()?)?)
            }
            DepthCoding::Tree(nodes) => {
                DepthChunk::Tree(TreeChunk::parse(payload, grid, frames, nodes.domain.domain()?)?)
            }
            DepthCoding::Blocks => DepthChunk::Blocks(BlockChunk::parse(payload, grid, frames)?),
            DepthCoding::Predictive(header) => {
                DepthChunk::Predictive(Box::new(PredictiveChunk::parse(payload, header.clone(), area, frames)?))
            }
        })
    }

    fn advance(&mut self, picture: &mut [u16], at: Option<u32>, target: u32, window: u8) -> Result<u64> {
        Ok(match self {
            DepthChunk::Boxes(chunk) => chunk.advance(picture, at, target, window),
            DepthChunk::Nodes(chunk) => chunk.advance(picture, at, target, window),
            DepthChunk::Tree(chunk) => chunk.leaves.advance(picture, at, target, 1),
            DepthChunk::Blocks(_) if at == Some(target) => 0,
            DepthChunk::Blocks(chunk) => chunk.show(picture, target),
            DepthChunk::Predictive(chunk) => chunk.advance(picture, at, target)?,
        })
    }

    fn check_window(&self, window: u8, frames: u32) -> Result<()> {
        match self {
            DepthChunk::Boxes(chunk) => chunk.check_window(window, frames),
            DepthChunk::Nodes(chunk) => chunk.check_window(window, frames),
            DepthChunk::Tree(_) | DepthChunk::Blocks(_) => Ok(()),
            DepthChunk::Predictive(chunk) => chunk.check(),
        }
    }

    fn into_spare(self) -> Vec<u8> {
        match self {
            DepthChunk::Boxes(chunk) => chunk.into_spare(),
            DepthChunk::Nodes(chunk) => chunk.into_spare(),
            DepthChunk::Tree(chunk) => chunk.leaves.into_spare(),
            DepthChunk::Blocks(chunk) => chunk.into_spare(),
            DepthChunk::Predictive(chunk) => chunk.into_spare(),
        }
    }
}
