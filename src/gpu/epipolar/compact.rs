//! Compaction on a device (Epipolar 3.3.2): reads back only the pixels of a layer that show a triangle.

use crate::Gpu;
use crate::drawing::{Band, copy_rows};
use crate::harness::dispatch;
use codec::error::Result;
use epipolar::compact::ActivePixel;
use kernels::layout::{PixelRows, words_of};

/// Bytes per texel: the triangle number plus 1, and its depth.
const TEXEL_BYTES: usize = 8;

/// Returns the active pixels of a texture of [`crate::drawing::INDEX_FORMAT`], in order.
pub fn active_pixels(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<ActivePixel>> {
    let mut active = Vec::new();
    copy_rows(gpu, texture, TEXEL_BYTES, |shown, band| {
        let first = band.top * texture.width();
        let of_band = active_of_band(gpu, shown, (&band, texture.width()))?;
        active.extend(of_band.into_iter().map(|[pixel, shown]| [first + pixel, shown]));
        Ok(())
    })?;
    Ok(active)
}

fn active_of_band(gpu: &Gpu, shown: &wgpu::Buffer, (band, width): (&Band, u32)) -> Result<Vec<ActivePixel>> {
    let rows = band.rows as usize;
    let block = PixelRows { width, rows: band.rows, stride: band.pitch / TEXEL_BYTES as u32, spare: 0 };
    let block = gpu.filled("block", &words_of(&[block]))?;
    let counts = gpu.buffer("counts", rows, wgpu::BufferUsages::empty())?;
    let named = |name: &str| match name {
        "block" => Some(&block),
        "shown" => Some(shown),
        "counts" => Some(&counts),
        _ => None,
    };
    dispatch(gpu, &kernels::ACTIVE_COUNTS, rows, named)?;
    let count = gpu.read(&counts, rows)?.into_iter().sum::<u32>() as usize;
    if count == 0 {
        return Ok(Vec::new());
    }
    let active = gpu.buffer("active_pixels", 2 * count, wgpu::BufferUsages::empty())?;
    dispatch(gpu, &kernels::COMPACT, rows, |name| if name == "active_pixels" { Some(&active) } else { named(name) })?;
    Ok(gpu.read(&active, 2 * count)?.as_chunks().0.to_vec())
}
