//! Maximum pyramids of inverse depth, with which ray marching proves whole segments of a ray empty.
//!
//! A pyramid holds the maximum inverse depth, which is the nearest surface, of squares of 2×2 texels, 4×4 texels and so on. It
//! also holds the maximum of every 2×2 neighbourhood of texels, for [`Footprint::Around`](crate::march::Footprint).

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::views::{Change, FaceTexels, LightField, UNKNOWN, View};
use codec::image::{Face, StreamKind};

/// Minimum depth in metres whose inverse is reliable in single precision.
pub const MIN_M: f32 = 1e-18;

/// Maximum inverse depths of squares of texels, in 1/m; [`UNKNOWN`] if any texel of the square is. An empty pyramid proves no
/// segment empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DepthPyramid {
    /// Level `at` has squares of 2^(`at` + 1) texels a side; the last column and row may have fewer.
    pub levels: Vec<Level>,
    /// For each texel, the maximum of it and its right, lower and lower right neighbours in the image.
    pub around: Vec<f32>,
}

/// Squares of one size, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Columns and rows of squares.
    pub size: [u32; 2],
    pub greatest: Vec<f32>,
}

impl DepthPyramid {
    /// Returns the maximum inverse depth of all texels; [`UNKNOWN`] for an empty pyramid.
    pub fn greatest(&self) -> f32 {
        match self.levels.last() {
            Some(level) => level.greatest.iter().copied().fold(0.0, f32::max),
            None => UNKNOWN,
        }
    }

    /// Creates the pyramid of a face of `size` unknown texels, at least 1 in each direction.
    pub fn unknown(size: [u32; 2]) -> DepthPyramid {
        let level = |size: [u32; 2]| Level { size, greatest: vec![UNKNOWN; size[0] as usize * size[1] as usize] };
        let around = vec![UNKNOWN; size[0] as usize * size[1] as usize];
        DepthPyramid { levels: DepthPyramid::sizes(size).into_iter().map(level).collect(), around }
    }

    /// Returns the columns and rows of squares of each level above an image of `size` texels.
    pub fn sizes(size: [u32; 2]) -> Vec<[u32; 2]> {
        let (mut sizes, mut of) = (Vec::new(), size);
        while of != [1, 1] || sizes.is_empty() {
            of = of.map(|texels| texels.div_ceil(2).max(1));
            sizes.push(of);
        }
        sizes
    }

    /// Updates the pyramid after changes to the texels in these columns and rows. An empty pyramid is built from all texels.
    pub fn update(&mut self, size: [u32; 2], inverse_depth: &[f32], columns: Range<u32>, rows: Range<u32>) {
        if inverse_depth.is_empty() {
            *self = DepthPyramid::default();
            return;
        }
        let mut changed = [columns, rows];
        if self.levels.is_empty() {
            *self = DepthPyramid::unknown(size);
            changed = size.map(|texels| 0..texels);
        }
        let [width, height] = size.map(|texels| texels as usize);
        let [columns, rows] =
            [0, 1].map(|axis| changed[axis].start.saturating_sub(1) as usize..changed[axis].end as usize);
        for row in rows {
            let [upper, lower] = [row, (row + 1).min(height - 1)].map(|row| &inverse_depth[row * width..][..width]);
            for column in columns.clone() {
                let right = (column + 1).min(width - 1);
                self.around[row * width + column] =
                    upper[column].max(upper[right]).max(lower[column].max(lower[right]));
            }
        }
        let (mut below_size, mut below) = (size, inverse_depth);
        for level in &mut self.levels {
            changed = [0, 1].map(|axis| changed[axis].start / 2..changed[axis].end.div_ceil(2).min(level.size[axis]));
            for row in changed[1].clone() {
                let lower = [2 * row, (2 * row + 1).min(below_size[1] - 1)];
                for column in changed[0].clone() {
                    let right = [2 * column, (2 * column + 1).min(below_size[0] - 1)];
                    let four = lower.map(|row| right.map(|at| below[(row * below_size[0] + at) as usize]));
                    level.greatest[(row * level.size[0] + column) as usize] =
                        four[0][0].max(four[0][1]).max(four[1][0].max(four[1][1]));
                }
            }
            (below_size, below) = (level.size, &level.greatest);
        }
    }
    /// Returns an upper bound on the inverse depths of the texels from one corner to the other, inclusive.
    ///
    /// Covers the rectangle with squares of half to all of its longer side: at most three per row, in at most three rows.
    pub(crate) fn greatest_between(
        &self,
        texels: &FaceTexels,
        [left, top]: [u32; 2],
        [right, bottom]: [u32; 2],
    ) -> f32 {
        let level = (right - left).max(bottom - top).checked_ilog2().unwrap_or(0);
        let (size, values) = match level.checked_sub(1) {
            None => (texels.size, &texels.inverse_depth[..]),
            Some(above) => match self.levels.get(above as usize) {
                Some(level) => (level.size, &level.greatest[..]),
                None => return UNKNOWN,
            },
        };
        let mut greatest = 0f32;
        for row in top >> level..=bottom >> level {
            let from = (row * size[0]) as usize;
            for column in left >> level..=right >> level {
                greatest = greatest.max(values[from + column as usize]);
            }
        }
        greatest
    }
}

/// Pyramids of a view's faces, by face index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ViewPyramids {
    pub faces: [DepthPyramid; 7],
}

impl ViewPyramids {
    /// Builds the pyramids of a view from all its texels; they are empty for faces whose texels are kept on a device.
    pub fn of(view: &View) -> ViewPyramids {
        let mut pyramids = ViewPyramids::default();
        for (pyramid, texels) in pyramids.faces.iter_mut().zip(&view.faces) {
            if let Some(texels) = texels {
                pyramid.update(texels.size, &texels.inverse_depth, 0..texels.size[0], 0..texels.size[1]);
            }
        }
        pyramids
    }

    /// Returns the maximum inverse depth of all texels if the view has texels in every direction; else [`UNKNOWN`].
    pub fn greatest(&self, view: &View) -> f32 {
        if view.faces[Face::View as usize].is_some() || view.near_m < MIN_M {
            return UNKNOWN;
        }
        self.faces[..Face::View as usize].iter().map(DepthPyramid::greatest).fold(0.0, f32::max)
    }
}

/// Pyramids of a light field, by view index. They follow the changes that a player reports.
#[derive(Debug, Clone, Default)]
pub struct Pyramids {
    views: Vec<Arc<ViewPyramids>>,
}

impl Pyramids {
    /// Returns the pyramids of a view; empty ones if it has none.
    pub fn view(&self, at: usize) -> Arc<ViewPyramids> {
        self.views.get(at).cloned().unwrap_or_default()
    }

    /// Applies the changes of depth since the last call, views in parallel. Views without faces lose their pyramids.
    pub fn update(&mut self, field: &LightField, changes: &[Change]) {
        self.views.resize_with(field.views.len(), Arc::default);
        self.views.par_iter_mut().zip(&field.views).enumerate().for_each(|(at, (pyramids, view))| {
            if view.faces.iter().all(Option::is_none) {
                *pyramids = Arc::default();
                return;
            }
            let of_view = || changes.iter().filter(|change| change.view == at && change.kind == StreamKind::Depth);
            if of_view().next().is_none() {
                return;
            }
            let faces = Arc::make_mut(pyramids).faces.par_iter_mut().zip(&view.faces).enumerate();
            faces.for_each(|(face, (pyramid, texels))| {
                let Some(texels) = texels else { return };
                for Change { rect: [left, top, width, height], .. } in of_view().filter(|change| change.face == face) {
                    pyramid.update(texels.size, &texels.inverse_depth, *left..left + width, *top..top + height);
                }
            });
        });
    }
}
