//! Tints of the coding modes of pixels.

use crate::report::plot::palette::{self, Rgb, mix};
use codec::depth::nodes::Function;
use codec::depth::predictive::modes::BlockCoding;
use footage::inspect::Writing;

pub fn tint(writing: Writing) -> Rgb {
    let ink = match writing {
        Writing::Function(Function::Raw) | Writing::Values => palette::VERMILION,
        Writing::Function(Function::Platelet) | Writing::Blend => palette::BLUE,
        Writing::Function(Function::Biquadratic) => palette::YELLOW,
        Writing::Function(Function::Bc4w) | Writing::Blocks => palette::PURPLE,
        Writing::Transform => palette::BLUE,
        Writing::Palette => palette::YELLOW,
        Writing::OneValue => palette::GREEN,
        Writing::Predicted(coding) => match coding {
            BlockCoding::Same | BlockCoding::Background => palette::GREEN,
            BlockCoding::Plane => palette::YELLOW,
            BlockCoding::ChangedPlane => palette::BLUE,
            BlockCoding::Quarters => palette::PURPLE,
            BlockCoding::Pixels => palette::VERMILION,
        },
    };
    ink.rgb
}

pub fn tinted(color: Rgb, writing: Writing) -> Rgb {
    mix(color, tint(writing), 0.55)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::palette::{BACKGROUND, grey, hatched, lightness, outlined};

    #[test]
    fn an_outline_is_seen_on_every_tint_and_grey() {
        let writings = Function::ALL.map(Writing::Function).into_iter();
        for writing in writings
            .chain([Writing::OneValue, Writing::Values, Writing::Blocks, Writing::Blend])
            .chain([Writing::Transform, Writing::Palette])
            .chain(BlockCoding::ALL.map(Writing::Predicted))
        {
            for ground in [grey(0.0), grey(0.5), grey(1.0), BACKGROUND] {
                let color = tinted(ground, writing);
                let line = outlined(color);
                assert!(lightness(color).abs_diff(lightness(line)) >= 50, "{writing:?} {color:?} {line:?}");
                assert!(lightness(color).abs_diff(lightness(hatched(color))) >= 28, "{writing:?} {color:?}");
            }
        }
    }
}
