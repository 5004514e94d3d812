//! Conversion of depth codes to the inverse planar depths of texels.

use rayon::prelude::*;

use crate::views::FaceTexels;
use codec::depth::DepthRange;
use codec::image::DepthKind;

#[derive(Debug, Clone)]
pub struct InverseDepth {
    /// Inverse depth of each code, in 1/m.
    pub of_code: Vec<f32>,
    pub range: DepthRange,
    pub kind: DepthKind,
}

impl InverseDepth {
    pub fn new(range: DepthRange, kind: DepthKind) -> InverseDepth {
        let codes = (0..=u16::MAX).into_par_iter();
        InverseDepth { of_code: codes.map(|code| 1.0 / range.metres(code)).collect(), range, kind }
    }

    /// Returns the inverse planar depth of a texel that shows `code`, in 1/m.
    pub fn of(&self, code: u16, face: &FaceTexels, column: u32, row: u32) -> f32 {
        let inverse = self.of_code[usize::from(code)];
        match self.kind {
            DepthKind::Planar => inverse,
            DepthKind::Distance => inverse * face.map.ray_length_factor(column, row),
        }
    }

    /// Writes the texels of `codes` into a row, which has to hold them all, from a column on. Returns the first and last index
    /// that changed.
    pub fn write_row(&self, codes: &[u16], face: &mut FaceTexels, [column, row]: [u32; 2]) -> Option<[u32; 2]> {
        let start = row as usize * face.size[0] as usize + column as usize;
        let mut differ = None;
        for (at, &code) in (0u32..).zip(codes) {
            let inverse_depth = self.of(code, face, column + at, row);
            let texel = &mut face.inverse_depth[start + at as usize];
            if *texel != inverse_depth {
                *texel = inverse_depth;
                differ = Some([differ.map_or(at, |[first, _]: [u32; 2]| first), at]);
            }
        }
        differ
    }
}
