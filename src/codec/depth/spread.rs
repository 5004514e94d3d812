//! Distribution of depth in images, and the few pixels that take much of the precision of all others: codes are uniform in the
//! logarithm of depth from near to far, so a single stray pixel makes every step between codes larger.
//!
//! Input: images in metres, in any order and on any machine. Output: [`Spread`], which can be merged, and its [`Strays`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::depth::DepthRange;
use crate::image::{DepthPlane, Face};

/// Depths that agree in all bits from this one up share a bin: there are eight bins per power of two.
const BIN_SHIFT: u32 = 20;
const BINS: usize = (f32::INFINITY.to_bits() >> BIN_SHIFT) as usize;
/// Pixels are few if at most one in this many of all, or if [`FEW_OF_SMALL_IMAGES`] applies.
const FEW: u64 = 10_000;
/// Pixels are also few if at most one per image, and at most one in this many of all.
const FEW_OF_SMALL_IMAGES: u64 = 1000;
/// Few pixels are reported if the error bound without them is at most this part of the bound with them.
const WORTH_NAMING: f64 = 0.75;
/// Maximum number of pixels reported at each end.
const NAMED: usize = 3;

/// Position of a pixel and its depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlacedDepth {
    pub frame: u32,
    /// Number of the face ([`Face`]).
    pub face: u8,
    pub x: u32,
    pub y: u32,
    pub depth_m: f32,
}

impl PlacedDepth {
    fn order(&self) -> (u32, u8, u32, u32) {
        (self.frame, self.face, self.y, self.x)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Bin {
    pixels: u64,
    near_m: f32,
    far_m: f32,
    /// First pixel of the bin in the order of frame, face, row and column.
    first: PlacedDepth,
}

/// Number of pixels by depth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Number of pixels of all images, including background.
    pixels: u64,
    images: u64,
    bins: BTreeMap<u32, Bin>,
}

/// Few pixels that take at least a quarter of the precision.
#[derive(Debug, Clone, PartialEq)]
pub struct Strays {
    pub pixels: u64,
    pub of_pixels: u64,
    /// First pixels of the nearest and of the farthest bins, up to three bins each.
    pub named: Vec<PlacedDepth>,
    /// Depth range of all other surfaces.
    pub without: DepthRange,
}

impl Spread {
    /// Returns the spread of one image of distances; 0 and +inf are not surfaces.
    pub fn of(plane: &DepthPlane, frame: u32, face: Face) -> Spread {
        let mut bins: Vec<Option<(Bin, usize)>> = vec![None; BINS];
        for (at, &depth_m) in plane.data().iter().enumerate() {
            if !(depth_m > 0.0 && depth_m < f32::INFINITY) {
                continue;
            }
            match &mut bins[(depth_m.to_bits() >> BIN_SHIFT) as usize] {
                Some((bin, _)) => {
                    bin.pixels += 1;
                    bin.near_m = bin.near_m.min(depth_m);
                    bin.far_m = bin.far_m.max(depth_m);
                }
                empty => {
                    let first = PlacedDepth { frame, face: face as u8, x: 0, y: 0, depth_m };
                    *empty = Some((Bin { pixels: 1, near_m: depth_m, far_m: depth_m, first }, at));
                }
            }
        }
        let width = plane.width().max(1) as usize;
        let placed = |(number, bin): (u32, Option<(Bin, usize)>)| {
            let (bin, at) = bin?;
            let first = PlacedDepth { x: (at % width) as u32, y: (at / width) as u32, ..bin.first };
            Some((number, Bin { first, ..bin }))
        };
        let bins = (0..).zip(bins).filter_map(placed).collect();
        Spread { pixels: plane.data().len() as u64, images: 1, bins }
    }

    #[must_use]
    pub fn union(mut self, other: &Spread) -> Spread {
        // Saturating, because the numbers may come from a damaged file.
        self.pixels = self.pixels.saturating_add(other.pixels);
        self.images = self.images.saturating_add(other.images);
        for (&number, more) in &other.bins {
            let merge = |bin: &mut Bin| {
                bin.pixels = bin.pixels.saturating_add(more.pixels);
                bin.near_m = bin.near_m.min(more.near_m);
                bin.far_m = bin.far_m.max(more.far_m);
                if more.first.order() < bin.first.order() {
                    bin.first = more.first;
                }
            };
            self.bins.entry(number).and_modify(merge).or_insert(*more);
        }
        self
    }

    /// Returns the range from the nearest to the farthest surface; `None` if there is none.
    pub fn range(&self) -> Option<DepthRange> {
        let (first, last) = (self.bins.first_key_value()?.1, self.bins.last_key_value()?.1);
        DepthRange::new(first.near_m, last.far_m).ok()
    }

    /// Returns the pixels within `range` without which the error bound would be at most three quarters as large; `None` if they
    /// are not few.
    pub fn strays(&self, range: DepthRange) -> Option<Strays> {
        let (near, far) = (range.near_m(), range.far_m());
        let bins: Vec<Bin> = self.bins.values().filter(|bin| bin.far_m >= near && bin.near_m <= far).copied().collect();
        let few = (self.pixels / FEW).max(self.images.min(self.pixels / FEW_OF_SMALL_IMAGES));
        let span = |first: &Bin, last: &Bin| {
            let [low, high] = [first.near_m.max(near), last.far_m.min(far)].map(f64::from);
            libm::log(high.max(low) / low)
        };
        let whole = libm::log(f64::from(far) / f64::from(near));
        // Tries every combination of bins left out at both ends, as long as their pixels are few.
        let mut best: Option<(f64, usize, usize)> = None;
        let mut before = 0u64;
        for first in 0..bins.len() {
            let mut behind = 0u64;
            for last in (first..bins.len()).rev() {
                let left_out = before.saturating_add(behind);
                if left_out > few {
                    break;
                }
                let rest = span(&bins[first], &bins[last]);
                // More pixels are left out only if that shortens the range by more than 2% of the whole.
                if best.is_none_or(|(least, ..)| rest < least - 0.02 * whole) {
                    best = Some((rest, first, last));
                }
                behind = behind.saturating_add(bins[last].pixels);
            }
            before = before.saturating_add(bins[first].pixels);
            if before > few {
                break;
            }
        }
        let (rest, first, last) = best?;
        let (nearer, farther) = (&bins[..first], &bins[last + 1..]);
        if rest > WORTH_NAMING * whole || (nearer.is_empty() && farther.is_empty()) {
            return None;
        }
        let named = nearer.iter().take(NAMED).chain(farther.iter().rev().take(NAMED)).map(|bin| bin.first).collect();
        let without = DepthRange::new(bins[first].near_m.max(near), bins[last].far_m.min(far)).ok()?;
        let pixels = nearer.iter().chain(farther).map(|bin| bin.pixels).sum();
        Some(Strays { pixels, of_pixels: self.pixels, named, without })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 64x64 pixels from 2 m to 20 m.
    fn ramp() -> DepthPlane {
        DepthPlane::from_fn(64, 64, |x, y| 2.0 + (x + 64 * y) as f32 * 18.0 / 4095.0)
    }

    fn with(strays: &[(u32, u32, f32)]) -> DepthPlane {
        let mut plane = ramp();
        strays.iter().for_each(|&(x, y, depth_m)| plane.row_mut(y)[x as usize] = depth_m);
        plane
    }

    fn range_of(plane: &DepthPlane) -> DepthRange {
        let surfaces = || plane.data().iter().copied().filter(|z| z.is_finite());
        DepthRange::new(surfaces().fold(f32::MAX, f32::min), surfaces().fold(0.0, f32::max)).unwrap()
    }

    fn strays_of(plane: &DepthPlane) -> Option<Strays> {
        Spread::of(plane, 7, Face::Pz).strays(range_of(plane))
    }

    #[test]
    fn names_single_pixels_at_either_end() {
        for depth_m in [1e-40, 1e-6, 0.01, 5000.0, 9e9, f32::MAX] {
            let found = strays_of(&with(&[(13, 40, depth_m)])).unwrap();
            let place = PlacedDepth { frame: 7, face: Face::Pz as u8, x: 13, y: 40, depth_m };
            assert_eq!((found.pixels, found.of_pixels, found.named), (1, 4096, vec![place]), "{depth_m}");
            assert_eq!((found.without.near_m(), found.without.far_m()), (2.0, 20.0));
        }
    }

    #[test]
    fn names_both_ends_of_many_images() {
        let images: Vec<DepthPlane> = (0..6)
            .map(|frame| match frame {
                2 => with(&[(1, 1, 1e-6)]),
                4 => with(&[(3, 2, 1e6), (9, 9, 2e-6)]),
                _ => ramp(),
            })
            .collect();
        let spreads: Vec<Spread> =
            (0..).zip(&images).map(|(frame, plane)| Spread::of(plane, frame, Face::Nx)).collect();
        let ascending = spreads.iter().fold(Spread::default(), Spread::union);
        let descending = spreads.iter().rev().fold(Spread::default(), Spread::union);
        assert_eq!(ascending, descending);
        let found = ascending.strays(DepthRange::new(1e-6, 1e6).unwrap()).unwrap();
        let places: Vec<_> = found.named.iter().map(|place| (place.frame, place.x, place.y, place.depth_m)).collect();
        assert_eq!((found.pixels, places), (3, vec![(2, 1, 1, 1e-6), (4, 9, 9, 2e-6), (4, 3, 2, 1e6)]));
        let back: Spread = serde_json::from_slice(&serde_json::to_vec(&ascending).unwrap()).unwrap();
        assert_eq!(back, ascending);
    }

    #[test]
    fn leaves_usual_depth_alone() {
        assert_eq!(strays_of(&ramp()), None);
        assert_eq!(strays_of(&DepthPlane::filled(64, 64, 3.0)), None);
        assert_eq!(strays_of(&DepthPlane::filled(64, 64, f32::from_bits(1))), None);
        // A stray with little effect.
        assert_eq!(strays_of(&with(&[(0, 0, 1.5)])), None);
        // Too many pixels of a small image.
        assert_eq!(strays_of(&with(&[1, 2, 3, 4, 5].map(|x| (x, 0, 1e-6)))), None);
        // In tiny images no number of pixels is few.
        let tiny = DepthPlane::from_fn(4, 4, |x, y| 10f32.powi((x + 4 * y) as i32 - 8));
        assert_eq!(strays_of(&tiny), None);
        assert_eq!(Spread::default().strays(DepthRange::empty()), None);
        // Background is not a stray.
        assert_eq!(strays_of(&with(&[(5, 5, f32::INFINITY)])), None);
    }

    #[test]
    fn counts_only_pixels_within_a_given_range() {
        let plane = with(&[(13, 40, 1e-6), (1, 2, 1e6)]);
        let spread = Spread::of(&plane, 0, Face::View);
        let strays = |near, far| spread.strays(DepthRange::new(near, far).unwrap());
        assert_eq!(strays(0.5, 1e6).unwrap().named[0].depth_m, 1e6);
        assert_eq!(strays(1e-6, 30.0).unwrap().named[0].depth_m, 1e-6);
        assert_eq!(strays(0.5, 30.0), None);
    }
}
