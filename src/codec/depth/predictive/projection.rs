//! Effect of the projection on planes (depth.md 15.3): the logarithm of distance over depth at each pixel, for distances in a
//! cube face; and the curvature of planes in the logarithm of depth.

use std::sync::{Arc, Mutex, PoisonError};

use crate::depth::domain::integer_log2;

/// Position of a unit in its image: its rectangle and the size of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitArea {
    /// Left, top, width and height in pixels.
    pub rect: [u32; 4],
    /// Width and height of the image.
    pub image: [u32; 2],
}

impl UnitArea {
    /// Returns the area of a unit that is its whole image.
    pub fn whole(size: [u32; 2]) -> UnitArea {
        UnitArea { rect: [0, 0, size[0], size[1]], image: size }
    }

    pub fn size(&self) -> [u32; 2] {
        [self.rect[2], self.rect[3]]
    }
}

/// Range of codes per factor of two of depth in which the term is used.
pub const OCTAVES: std::ops::RangeInclusive<u32> = 512..=131_071;

/// Relation of a stream's depth to the viewing axis. The discriminants are the values of the stream's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Shape {
    /// Unknown: no term.
    #[default]
    None = 0,
    /// Planar depth of a pinhole camera or a cube face: planes are curved.
    Planar = 1,
    /// Distances in a cube face.
    CubeDistance = 2,
}

impl Shape {
    pub fn from_byte(byte: u8) -> Option<Shape> {
        [Shape::None, Shape::Planar, Shape::CubeDistance].get(usize::from(byte)).copied()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Projection {
    pub shape: Shape,
    /// Codes per factor of two of depth; 0 without a term.
    pub octave: u32,
}

impl Projection {
    /// Returns true if a header may contain this projection: octave 0 without a shape, otherwise an octave within [`OCTAVES`].
    pub fn is_legal(self) -> bool {
        if self.shape == Shape::None { self.octave == 0 } else { OCTAVES.contains(&self.octave) }
    }

    /// Returns the corrections of a unit's pixels, row by row: the 256ths of a code by which distance exceeds planar depth.
    pub fn corrections(self, area: UnitArea) -> Vec<i32> {
        let [left, top, width, height] = area.rect;
        let count = width as usize * height as usize;
        if self.shape != Shape::CubeDistance {
            return vec![0; count];
        }
        let side = area.image[0];
        let mut out = Vec::with_capacity(count);
        let face = FaceLogs::of(side);
        for y in top..top + height {
            match &face {
                Some(face) => {
                    let row = &face.logs[(y * side + left) as usize..][..width as usize];
                    out.extend(row.iter().map(|&log| self.correction(log.into())));
                }
                None => out.extend((left..left + width).map(|x| self.correction(log_at(side, [x, y])))),
            }
        }
        out
    }

    /// Converts half of a Q14 logarithm to 256ths of a code.
    fn correction(self, log: u32) -> i32 {
        ((log * self.octave) >> 7) as i32
    }

    pub fn curvature(self) -> Curvature {
        // Codes per factor of e of depth: octave / ln 2.
        let codes = (self.octave * 2955) >> 11;
        Curvature { codes: codes as i32, factor: (1u32 << 22).checked_div(codes).unwrap_or(0) }
    }
}

/// Returns log2, in Q14, of the square of distance over depth at a pixel of a cube face.
fn log_at(side: u32, pixel: [u32; 2]) -> u32 {
    let [x, y] = pixel.map(|at| {
        let twice = (2 * at + 1).abs_diff(side);
        twice * twice
    });
    (integer_log2(side * side + x + y) - integer_log2(side * side)) >> 10
}

/// Table of [`log_at`] for all pixels of a face, row by row, shared by the units of all streams.
struct FaceLogs {
    side: u32,
    logs: Vec<u16>,
}

impl FaceLogs {
    /// Maximum side of a face whose table is kept: 8 MiB.
    const MAX_SIDE: u32 = 2048;
    /// Maximum number of tables kept; the oldest one is replaced.
    const KEPT: usize = 2;

    fn of(side: u32) -> Option<Arc<FaceLogs>> {
        static KEPT: Mutex<Vec<Arc<FaceLogs>>> = Mutex::new(Vec::new());
        if side > FaceLogs::MAX_SIDE {
            return None;
        }
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|face| face.side == side) {
            return Some(Arc::clone(&kept[at]));
        }
        let logs = (0..side * side).map(|at| log_at(side, [at % side, at / side]) as u16).collect();
        let face = Arc::new(FaceLogs { side, logs });
        if kept.len() == FaceLogs::KEPT {
            kept.remove(0);
        }
        kept.push(Arc::clone(&face));
        Some(face)
    }
}

/// Second-order terms of planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Curvature {
    /// Codes per factor of e of depth; 0 without a term.
    pub codes: i32,
    /// 2²² / `codes`; 0 without a term.
    pub factor: u32,
}

#[cfg(feature = "encode")]
impl Projection {
    /// Returns the term of a stream with this shape and depth range; without a shape if the range is too narrow or too wide for
    /// it.
    pub fn new(shape: Shape, range: crate::depth::DepthRange) -> Projection {
        let octave = (libm::log1p(1.0) / libm::log1p(range.step_ratio())).round();
        if shape != Shape::None && octave >= f64::from(*OCTAVES.start()) && octave <= f64::from(*OCTAVES.end()) {
            Projection { shape, octave: octave as u32 }
        } else {
            Projection::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrections_are_the_logarithm_of_distance_over_depth() {
        let area = UnitArea { rect: [3, 400, 90, 112], image: [512, 512] };
        for octave in [512, 9_731, 131_071] {
            let projection = Projection { shape: Shape::CubeDistance, octave };
            let corrections = projection.corrections(area);
            for (at, &correction) in corrections.iter().enumerate() {
                let [x, y] = [3 + at % 90, 400 + at / 90].map(|at| (2.0 * at as f64 + 1.0) / 512.0 - 1.0);
                let expected = f64::from(octave) * 0.5 * (1.0 + x * x + y * y).log2();
                let error = (f64::from(correction) / 256.0 - expected).abs();
                assert!(error < 0.01 + f64::from(octave) / 16_384.0, "{octave} {at}: {error}");
            }
        }
        // The largest face with the largest octave does not overflow.
        let corner = UnitArea { rect: [16_380, 16_380, 4, 4], image: [16_384, 16_384] };
        let projection = Projection { shape: Shape::CubeDistance, octave: 131_071 };
        assert!(projection.corrections(corner).iter().all(|&correction| correction < 1 << 25));
        assert!(Projection { shape: Shape::Planar, octave: 600 }.corrections(area).iter().all(|&c| c == 0));
    }

    #[test]
    fn curvature_is_defined_over_all_octaves() {
        for octave in [512, 10_000, 131_071] {
            let curvature = Projection { shape: Shape::Planar, octave }.curvature();
            let codes = f64::from(octave) / std::f64::consts::LN_2;
            assert!((f64::from(curvature.codes) / codes - 1.0).abs() < 0.002);
            assert!(curvature.factor <= 1 << 13);
        }
        assert_eq!(Projection::default().curvature(), Curvature { codes: 0, factor: 0 });
        assert!(!Projection { shape: Shape::Planar, octave: 0 }.is_legal());
        assert!(!Projection { shape: Shape::None, octave: 600 }.is_legal());
    }
}
