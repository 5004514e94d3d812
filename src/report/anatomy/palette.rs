//! Colours of the pictures. Tints are those of Okabe and Ito, which are told apart without red or green; scales grow lighter
//! all the way, so that they can be read in grey.

use crate::depth::nodes::Function;
use crate::inspect::Writing;
use crate::report::plot::{Ink, palette};

/// sRGB codes.
pub type Rgb = [u8; 3];

/// Behind everything.
pub const PAPER: Rgb = [255, 255, 255];
/// Text.
pub const INK: Rgb = [24, 24, 24];
/// Text that matters less, and thin lines.
pub const SOFT_INK: Rgb = [96, 96, 96];
/// Where there is no surface; hatched.
pub const BACKGROUND: Rgb = [30, 30, 30];
/// Background on one side only, and depth outside of the range; hatched.
pub const MISMATCH: Rgb = [213, 60, 0];
/// A cell without any error.
pub const EXACT: Rgb = [236, 236, 236];
/// Grey of the nearest and of the farthest surface.
const GREYS: [f64; 2] = [240.0, 84.0];

/// The tint of what is written in one way.
pub fn tint(writing: Writing) -> Rgb {
    let ink = match writing {
        Writing::Function(Function::Raw) | Writing::Values => palette::VERMILION,
        Writing::Function(Function::Platelet) | Writing::Blend => palette::BLUE,
        Writing::Function(Function::Biquadratic) => palette::YELLOW,
        Writing::Function(Function::Bc4w) | Writing::Blocks => palette::PURPLE,
        Writing::OneValue => palette::GREEN,
    };
    ink.rgb
}

/// The colour `part` of the way from one to another, 0 to 1.
pub fn mix(from: Rgb, to: Rgb, part: f64) -> Rgb {
    std::array::from_fn(|at| {
        let (from, to) = (f64::from(from[at]), f64::from(to[at]));
        (from + (to - from) * part.clamp(0.0, 1.0)).round() as u8
    })
}

/// A colour under a tint.
pub fn tinted(color: Rgb, writing: Writing) -> Rgb {
    mix(color, tint(writing), 0.55)
}

/// How light a colour is, 0 to 255.
pub fn lightness([red, green, blue]: Rgb) -> u32 {
    (54 * u32::from(red) + 183 * u32::from(green) + 19 * u32::from(blue)) / 256
}

/// A colour for text or lines on this one.
pub fn contrast(ground: Rgb) -> Rgb {
    palette::legible_on(Ink::opaque(ground)).rgb
}

/// A colour as an outline over it shows it.
pub fn outlined(color: Rgb) -> Rgb {
    if lightness(color) > 72 { mix(color, [0, 0, 0], 0.75) } else { mix(color, [255, 255, 255], 0.5) }
}

/// A colour as hatching over it shows it.
pub fn hatched(color: Rgb) -> Rgb {
    mix(color, contrast(color), 0.28)
}

/// Grey from near (0) to far (1).
pub fn grey(part: f64) -> Rgb {
    [(GREYS[0] + (GREYS[1] - GREYS[0]) * part.clamp(0.0, 1.0)).round() as u8; 3]
}

/// A scale from dark violet (0) by green to yellow (1): viridis.
pub fn heat(part: f64) -> Rgb {
    palette::viridis(part).rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_grow_lighter_or_darker_all_the_way() {
        let steps = || (0..=100).map(|step| f64::from(step) / 100.0);
        assert!(steps().map(|part| lightness(heat(part))).is_sorted());
        assert!(steps().map(|part| lightness(grey(part))).is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn an_outline_is_seen_on_every_tint_and_grey() {
        let writings = Function::ALL.map(Writing::Function).into_iter();
        for writing in writings.chain([Writing::OneValue, Writing::Values, Writing::Blocks, Writing::Blend]) {
            for ground in [grey(0.0), grey(0.5), grey(1.0), BACKGROUND] {
                let color = tinted(ground, writing);
                let line = outlined(color);
                assert!(lightness(color).abs_diff(lightness(line)) >= 50, "{writing:?} {color:?} {line:?}");
                assert!(lightness(color).abs_diff(lightness(hatched(color))) >= 28, "{writing:?} {color:?}");
            }
        }
    }
}
