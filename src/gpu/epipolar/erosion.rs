//! Erosion on a device (Epipolar 3.3.1).

use crate::Gpu;
use crate::harness::dispatch;
use codec::error::Result;
use epipolar::erosion::Moves;
use kernels::layout::{PixelRows, words_of};

/// Maximum pixels that are processed at once; a single scanline may have more. 32 MiB of moves, and as much of edge counts.
const PIXELS: usize = 8 << 20;

/// Computes [`Moves::eroded`] on a device.
pub fn eroded(gpu: &Gpu, moves: &Moves) -> Result<u64> {
    let at_once = (PIXELS / moves.width.max(1)).max(1) * moves.width;
    let parts = moves.columns.chunks(at_once.max(1)).map(|part| eroded_rows(gpu, part, moves.width));
    parts.sum()
}

fn eroded_rows(gpu: &Gpu, moves: &[i32], width: usize) -> Result<u64> {
    let rows = moves.len() / width;
    let block = PixelRows { width: width as u32, rows: rows as u32, stride: width as u32, spare: 0 };
    let buffer = |label, words| gpu.buffer(label, words, wgpu::BufferUsages::empty());
    let block = gpu.filled("block", &words_of(&[block]))?;
    let edges = buffer("edges", moves.len())?;
    let eroded = buffer("eroded", rows)?;
    let moves = gpu.filled("moves", &words_of(moves))?;
    let named = |name: &str| match name {
        "block" => Some(&block),
        "moves" => Some(&moves),
        "edges" => Some(&edges),
        "eroded" => Some(&eroded),
        _ => None,
    };
    dispatch(gpu, &kernels::EROSION_EDGES, rows, named)?;
    dispatch(gpu, &kernels::EROSION, rows, named)?;
    Ok(gpu.read(&eroded, rows)?.into_iter().map(u64::from).sum())
}
