//! Filling of output pixels that lines do not show: holes, mirrors and glass (Epipolar 7.1).

use half::f16;
use rayon::prelude::*;

use super::interpolate::{Coverage, InterpolatedView};
use super::views::OutputViews;
use codec::error::Result;
use codec::image::Plane;
use codec::monitor::Monitor;
use render::rendered_image::RenderedImage;
use scene::SceneAtTime;
use scene::capture::{PixelTracer, SamplePattern};

/// Number of columns that share a list of objects in view.
const TILE: usize = PixelTracer::TILE as usize;

/// Scene and sample positions for ray casting.
#[derive(Debug, Clone, Copy)]
pub struct Truth<'a> {
    pub scene: &'a SceneAtTime,
    pub samples: &'a SamplePattern,
}

/// How holes are filled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum HoleFilling {
    /// Holes are ray cast.
    #[default]
    Trace,
    /// Holes copy the nearest covered pixel of their scanline.
    Nearest,
    /// Holes are black and have an alpha of 0.
    Blank,
}

/// Fills the pixels that lines do not show, and returns the number of pixels that were ray cast. Mirrors and glass are always ray
/// cast if the scene is known.
pub fn fill(
    view: &mut InterpolatedView,
    truth: Option<Truth<'_>>,
    (views, offset_m): (&OutputViews, f64),
    filling: HoleFilling,
    monitor: &dyn Monitor,
) -> Result<u64> {
    let from = views.viewpoint(offset_m);
    let width = views.size[0] as usize;
    let is_open = |coverage: Coverage| match coverage {
        Coverage::Covered => false,
        Coverage::Hole => filling == HoleFilling::Trace,
        Coverage::Optical => true,
    };
    let fill_row = |(row, (color, coverage)): (usize, (&mut [[f16; 3]], &mut [Coverage]))| -> Result<u64> {
        monitor.check()?;
        let mut count = 0;
        for (tile, (color, coverage)) in color.chunks_mut(TILE).zip(coverage.chunks_mut(TILE)).enumerate() {
            let Some(truth) = truth.filter(|_| coverage.iter().any(|coverage| is_open(*coverage))) else { continue };
            let pixels = PixelTracer::new(truth.scene, &from);
            let corner = [(tile * TILE) as f64, row as f64];
            let candidates = pixels.in_view(corner, [corner[0] + color.len() as f64, corner[1] + 1.0]);
            for (column, (color, coverage)) in color.iter_mut().zip(coverage).enumerate() {
                if is_open(*coverage) {
                    *color = pixels.color([corner[0] + column as f64, corner[1]], truth.samples, &candidates);
                    *coverage = Coverage::Covered;
                    count += 1;
                }
            }
        }
        if filling == HoleFilling::Nearest {
            repeat_nearest(color, coverage);
        }
        Ok(count)
    };
    let colors = view.color.data_mut().par_chunks_mut(width);
    let rows = colors.zip(view.coverage.data_mut().par_chunks_mut(width));
    rows.enumerate().map(fill_row).sum()
}

fn repeat_nearest(color: &mut [[f16; 3]], coverage: &mut [Coverage]) {
    let covered: Vec<usize> = (0..coverage.len()).filter(|&at| coverage[at] == Coverage::Covered).collect();
    let holes: Vec<usize> = (0..coverage.len()).filter(|&at| coverage[at] == Coverage::Hole).collect();
    for at in holes {
        let after = covered.partition_point(|&other| other < at);
        let beside = [after.checked_sub(1), Some(after)].into_iter().flatten().filter_map(|index| covered.get(index));
        if let Some(&nearest) = beside.min_by_key(|&&other| other.abs_diff(at)) {
            (color[at], coverage[at]) = (color[nearest], Coverage::Covered);
        }
    }
}

/// Returns the picture of a view; alpha is 0 in pixels that were not filled.
pub fn picture(view: &InterpolatedView) -> Result<RenderedImage> {
    let alpha = view.coverage.map(|coverage| f32::from(u8::from(*coverage == Coverage::Covered)));
    let color: Plane<[f32; 3]> = view.color.map(|light| light.map(f16::to_f32));
    Ok(RenderedImage::new(color, alpha))
}
