//! Sizes of textures for an atlas of bounded size (Seurat 5.3, equation 3).
//!
//! Takes the textures of all tiles, and returns a size for each, such that all of them fit and the sum of squared differences is
//! small. Each tile takes the size with the smallest sum of distortion and λ times its texels (Everett); λ is the smallest at
//! which the layout fits.

use rayon::prelude::*;

use super::textures::TileTexture;
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use guillotiere::{SimpleAtlasAllocator, Size};

/// Sides are multiples of this, so that no two tiles share a block of a compressed texture.
pub const BLOCK: usize = 4;
/// Number of bisections of λ, on a scale of octaves.
const BISECTIONS: usize = 30;

/// Part of the messages about an atlas that is too small.
const INFEASIBLE: &str = "do not fit into an atlas of";

/// Returns true if a message, of this process or of another one, reports that an atlas is too small.
pub fn says_infeasible(message: &str) -> bool {
    message.contains(INFEASIBLE)
}

/// A size, and its distortion.
#[derive(Debug, Clone, Copy)]
struct Representation {
    side: usize,
    distortion: f64,
}

/// Positions of the textures in the atlas.
#[derive(Debug)]
pub struct Layout {
    /// Side and top left corner of each tile's texture.
    pub places: Vec<Place>,
    /// Width and height of the used part of the atlas.
    pub size: [u32; 2],
    /// Number of tiles that have fewer texels than their input textures.
    pub reduced: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    pub side: u32,
    pub corner: [u32; 2],
}

/// Choice of sizes if not all textures fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sizing {
    /// By distortion (Seurat 5.3).
    Adaptive,
    /// All sides are scaled by one factor.
    Uniform,
}

/// Sets the number of sizes that are compared for large textures, which is 40 to 79.
const SIZE_DIVISOR: usize = 64;

/// Places textures in an atlas of at most `most` texels a side.
pub fn layout(textures: &[TileTexture], most: u32, sizing: Sizing, monitor: &dyn Monitor) -> Result<Layout> {
    let full: Vec<usize> = textures.iter().map(|texture| texture.side).collect();
    if let Some(layout) = pack(&full, &full, most) {
        return Ok(layout);
    }
    let too_many = || {
        let least = (1u32..).find(|&blocks| (blocks as usize).pow(2) >= textures.len()).unwrap_or(u32::MAX);
        let least = least.saturating_mul(BLOCK as u32);
        Error::Usage(format!("{} tiles {INFEASIBLE} {most} texels a side: the minimum is {least}", textures.len()))
    };
    let sides_at: Box<dyn Fn(f64) -> Vec<usize>> = match sizing {
        Sizing::Adaptive => {
            let alpha_weight = 2.0 * variance(textures);
            let of = |texture: &TileTexture| representations(texture, alpha_weight, monitor);
            let choices: Vec<Vec<Representation>> = textures.par_iter().map(of).collect::<Result<_>>()?;
            Box::new(move |octaves: f64| {
                let lambda = octaves.exp2();
                let cost = |of: &&Representation| of.distortion + lambda * (of.side * of.side) as f64;
                let best = |of: &Vec<Representation>| {
                    of.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).map_or(BLOCK, |of| of.side)
                };
                choices.iter().map(best).collect()
            })
        }
        Sizing::Uniform => {
            let full = full.clone();
            // From −40 to 40 octaves the factor decreases from 1 to 0.
            Box::new(move |octaves: f64| {
                let factor = (40.0 - octaves) / 80.0;
                full.iter().map(|&side| ((side as f64 * factor) as usize / BLOCK * BLOCK).max(BLOCK)).collect()
            })
        }
    };
    let (mut low, mut high) = (-40.0, 40.0);
    let mut best = pack(&sides_at(high), &full, most).ok_or_else(too_many)?;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        match pack(&sides_at(middle), &full, most) {
            Some(layout) => (best, high) = (layout, middle),
            None => low = middle,
        }
    }
    Ok(best)
}

/// Packs squares into an atlas that is about as wide as it is high, the largest first; `None` if they do not fit.
fn pack(sides: &[usize], full: &[usize], most: u32) -> Option<Layout> {
    let most = most as usize / BLOCK * BLOCK;
    let area: usize = sides.iter().map(|&side| side * side).sum();
    let widest = sides.iter().copied().max().unwrap_or(BLOCK);
    if area > most * most || widest > most {
        return None;
    }
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by_key(|&at| std::cmp::Reverse(sides[at]));
    let of_width = |width: usize| {
        let mut atlas = SimpleAtlasAllocator::new(Size::new(width as i32, width as i32));
        let mut places = vec![Place { side: 0, corner: [0; 2] }; sides.len()];
        let mut size = [BLOCK as u32; 2];
        for &at in &order {
            let found = atlas.allocate(Size::splat(sides[at] as i32))?;
            places[at] = Place { side: sides[at] as u32, corner: [found.min.x as u32, found.min.y as u32] };
            size = [size[0].max(found.max.x as u32), size[1].max(found.max.y as u32)];
        }
        let reduced = sides.iter().zip(full).filter(|(side, full)| side < full).count();
        Some(Layout { places, size, reduced })
    };
    let least = ((area as f64).sqrt().ceil() as usize).max(widest);
    let widths = std::iter::successors(Some(least), |width| Some(width + width / 64 + 1));
    let widths = widths.map(|width| width.next_multiple_of(BLOCK)).take_while(|&width| width < most);
    widths.chain([most]).find_map(of_width)
}

/// Returns the variance of display values over all texels, summed over the three channels.
fn variance(textures: &[TileTexture]) -> f64 {
    let (mut count, mut sums, mut squares) = (0.0, [0.0; 3], 0.0);
    for &[r, g, b, _] in textures.iter().flat_map(|texture| &texture.texels) {
        let shown = [r, g, b].map(|light| f64::from(light.clamp(0.0, 1.0)).sqrt());
        count += 1.0;
        (0..3).for_each(|channel| sums[channel] += shown[channel]);
        squares += shown.iter().map(|shown| shown * shown).sum::<f64>();
    }
    let count = f64::max(count, 1.0);
    squares / count - sums.iter().map(|sum| (sum / count).powi(2)).sum::<f64>()
}

/// Returns the sizes of a texture that are compared, and their distortions: all multiples of [`BLOCK`] up to 256 texels a side,
/// 40 to 79 sizes for larger textures. Where alpha is wrong, another surface shows; the mean square of that change is
/// `alpha_weight`, twice the variance of display values.
fn representations(texture: &TileTexture, alpha_weight: f64, monitor: &dyn Monitor) -> Result<Vec<Representation>> {
    let full = encoded(texture);
    let step = (texture.side / SIZE_DIVISOR).next_multiple_of(BLOCK).max(BLOCK);
    let sides = (1..).map(|at| at * step).take_while(|&side| side < texture.side).chain([texture.side]);
    let of = |side: usize| {
        monitor.check()?;
        if side == texture.side {
            return Ok(Representation { side, distortion: 0.0 });
        }
        let small = resize(&full, texture.side, side, Filter::Tent);
        let shown = resize(&small, side, texture.side, Filter::Linear);
        let square = |a: &[f32; 4], b: &[f32; 4], at: usize| f64::from(a[at] - b[at]).powi(2);
        let difference = |(a, b): (&[f32; 4], &[f32; 4])| {
            (0..3).map(|channel| square(a, b, channel)).sum::<f64>() + alpha_weight * square(a, b, 3)
        };
        Ok(Representation { side, distortion: full.iter().zip(&shown).map(difference).sum() })
    };
    sides.map(of).collect()
}

/// Returns texels as display values: the square root of linear RGB, multiplied by alpha, and alpha.
fn encoded(texture: &TileTexture) -> Vec<[f32; 4]> {
    let of = |&[r, g, b, alpha]: &[f32; 4]| {
        let [r, g, b] = [r, g, b].map(|light| light.clamp(0.0, 1.0).sqrt() * alpha);
        [r, g, b, alpha]
    };
    texture.texels.iter().map(of).collect()
}

/// Returns a texture in another size. Colour is multiplied by alpha while it is filtered.
pub fn resized(texture: TileTexture, side: usize) -> TileTexture {
    if side == texture.side {
        return texture;
    }
    // Transparent texels have a small weight, so that their colour is kept under transparent texels of the result.
    let weighted: Vec<[f32; 4]> = (texture.texels.iter())
        .map(|&[r, g, b, alpha]| {
            let weight = alpha.max(1e-3);
            [r * weight, g * weight, b * weight, weight]
        })
        .collect();
    let small = resize(&weighted, texture.side, side, Filter::Tent);
    let mut texels: Vec<[f32; 4]> =
        small.iter().map(|&[r, g, b, weight]| [r / weight, g / weight, b / weight, 1.0]).collect();
    if !texture.is_opaque {
        let alpha: Vec<[f32; 4]> = texture.texels.iter().map(|&[.., alpha]| [alpha, 0.0, 0.0, 0.0]).collect();
        let alpha = resize(&alpha, texture.side, side, Filter::Tent);
        texels.iter_mut().zip(alpha).for_each(|(texel, [alpha, ..])| texel[3] = alpha);
    }
    TileTexture { side, texels, is_opaque: texture.is_opaque }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Filter {
    /// As wide as the spacing of the new texels.
    Tent,
    /// Between two texels, as a texture unit does.
    Linear,
}

/// Resizes a square texture. The centres of the corner texels do not move.
fn resize(texels: &[[f32; 4]], from: usize, to: usize, filter: Filter) -> Vec<[f32; 4]> {
    let step = (from - 1) as f32 / (to - 1).max(1) as f32;
    let reach = if filter == Filter::Tent { step.max(1.0) } else { 1.0 };
    let taps = |at: usize| -> Vec<(usize, f32)> {
        let middle = at as f32 * step;
        let first = (middle - reach).ceil().max(0.0) as usize;
        let last = ((middle + reach).floor() as usize).min(from - 1);
        let weights: Vec<f32> =
            (first..=last).map(|tap| (1.0 - (tap as f32 - middle).abs() / reach).max(0.0)).collect();
        let sum: f32 = weights.iter().sum();
        (first..=last).zip(weights).map(|(tap, weight)| (tap, weight / sum)).collect()
    };
    let taps: Vec<Vec<(usize, f32)>> = (0..to).map(taps).collect();
    let mut wide = vec![[0.0f32; 4]; to * from];
    for row in 0..from {
        for (column, taps) in taps.iter().enumerate() {
            let sum = &mut wide[row * to + column];
            for &(tap, weight) in taps {
                (0..4).for_each(|at| sum[at] += weight * texels[row * from + tap][at]);
            }
        }
    }
    let mut out = vec![[0.0f32; 4]; to * to];
    for (row, taps) in taps.iter().enumerate() {
        for &(tap, weight) in taps {
            for column in 0..to {
                (0..4).for_each(|at| out[row * to + column][at] += weight * wide[tap * to + column][at]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::math::random::Random;
    use codec::monitor::Silent;

    /// Returns textures of noise and flat textures.
    fn textures() -> Vec<TileTexture> {
        let mut random = Random::new(9);
        let mut noise = || f32::from(random.word() as u16) / 65535.0;
        let of = |at: usize| {
            let side = 16 + 4 * (at % 3);
            let mut texel = || if at.is_multiple_of(2) { noise() } else { 0.3 };
            let texels = (0..side * side).map(|_| [texel(); 4]).map(|[r, g, b, _]| [r, g, b, 1.0]).collect();
            TileTexture { side, texels, is_opaque: at % 4 != 3 }
        };
        (0..40).map(of).collect()
    }

    fn distortion(textures: &[TileTexture], layout: &Layout) -> f64 {
        let of = |(texture, place): (&TileTexture, &Place)| {
            representations(texture, 2.0 * variance(std::slice::from_ref(texture)), &Silent)
                .unwrap()
                .into_iter()
                .find(|of| of.side == place.side as usize)
                .map_or(0.0, |of| of.distortion)
        };
        textures.iter().zip(&layout.places).map(of).sum()
    }

    #[test]
    fn atlases_keep_their_bound_and_flat_textures_pay_for_the_others() {
        let textures = textures();
        for most in [256, 100, 64] {
            let [adaptive, uniform] =
                [Sizing::Adaptive, Sizing::Uniform].map(|sizing| layout(&textures, most, sizing, &Silent).unwrap());
            for layout in [&adaptive, &uniform] {
                assert!(layout.size.iter().all(|side| *side <= most));
                for (at, a) in layout.places.iter().enumerate() {
                    assert!(
                        (0..2).all(
                            |axis| a.corner[axis] + a.side <= layout.size[axis] && a.corner[axis].is_multiple_of(4)
                        )
                    );
                    let apart = |b: &Place| {
                        (0..2).any(|axis| {
                            a.corner[axis] + a.side <= b.corner[axis] || b.corner[axis] + b.side <= a.corner[axis]
                        })
                    };
                    assert!(layout.places[..at].iter().all(apart));
                }
            }
            let [adaptive, uniform] = [&adaptive, &uniform].map(|layout| distortion(&textures, layout));
            assert!(
                if most == 256 { uniform == 0.0 } else { adaptive < 0.8 * uniform },
                "{most}: {adaptive} {uniform}"
            );
        }
        let said = layout(&textures, 24, Sizing::Adaptive, &Silent).unwrap_err().to_string();
        assert!(said.contains("40 tiles") && said.ends_with("is 28"), "{said}");
    }

    #[test]
    fn a_ramp_keeps_its_ends_in_any_size() {
        let ramp = |at: usize| (at % 12) as f32 / 11.0;
        let texels = (0..12 * 12).map(|at| [ramp(at), ramp(at), ramp(at), 1.0]).collect();
        let texture = TileTexture { side: 12, texels, is_opaque: true };
        let small = resized(texture, 4);
        for row in small.texels.chunks_exact(4) {
            assert!(row[0][0] < 0.1 && row[3][0] > 0.9 && row.is_sorted_by(|a, b| a[0] < b[0]), "{row:?}");
        }
    }
}
