//! Font of all charts: DejaVu Sans, embedded in the program, so charts do not depend on system fonts.
//!
//! Sizes are CSS font sizes: the em in pixels.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, point};

use codec::error::{Error, Result};

/// Font families for viewers of SVG files, in order of preference. Verdana has almost the same widths as DejaVu Sans.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
pub const CAP_PER_EM: f64 = 0.729;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    Regular,
    Bold,
}

fn font(weight: Weight) -> Option<&'static FontRef<'static>> {
    static REGULAR: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    static BOLD: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    let read = |bytes: &'static [u8]| FontRef::try_from_slice(bytes).ok();
    match weight {
        Weight::Regular => REGULAR.get_or_init(|| read(dejavu::sans::regular())).as_ref(),
        Weight::Bold => BOLD.get_or_init(|| read(dejavu::sans::bold())).as_ref(),
    }
}

/// Lays out a text: returns each glyph with its start on the baseline, and the end of the text, both in font units, and
/// the factor from font units to pixels.
fn set(font: &FontRef<'_>, text: &str, em: f64) -> (Vec<(ab_glyph::GlyphId, f32)>, f32, f64) {
    let mut at = 0.0;
    let mut last = None;
    let mut letters = Vec::new();
    for letter in text.chars().map(|letter| font.glyph_id(letter)) {
        at += last.map_or(0.0, |last| font.kern_unscaled(last, letter));
        letters.push((letter, at));
        at += font.h_advance_unscaled(letter);
        last = Some(letter);
    }
    (letters, at, em / f64::from(font.units_per_em().unwrap_or(2048.0)))
}

/// Returns the width of a one-line text in pixels at `em` pixels per em. 0 if the font cannot be parsed.
pub fn width(text: &str, em: f64, weight: Weight) -> f64 {
    font(weight).map_or(0.0, |font| {
        let (_, end, pixels) = set(font, text, em);
        f64::from(end) * pixels
    })
}

/// Calls `cover` for each pixel that a one-line text touches, with the coverage of the pixel, 0 to 1. Pixel coordinates
/// are relative to the start of the baseline, x to the right, y down.
pub fn rasterise(
    text: &str,
    em: f64,
    weight: Weight,
    mut cover: impl FnMut([i32; 2], f64) -> Result<()>,
) -> Result<()> {
    let font = font(weight).ok_or_else(|| Error::unsupported("the font of the charts cannot be read"))?;
    let (letters, _, pixels) = set(font, text, em);
    let scale = PxScale::from((f64::from(font.height_unscaled()) * pixels) as f32);
    let mut outcome = Ok(());
    for (id, at) in letters {
        let glyph = Glyph { id, scale, position: point((f64::from(at) * pixels) as f32, 0.0) };
        let Some(outline) = font.outline_glyph(glyph) else { continue };
        let corner = outline.px_bounds().min;
        outline.draw(|x, y, share| {
            if outcome.is_ok() && share > 0.0 {
                outcome = cover([corner.x as i32 + x as i32, corner.y as i32 + y as i32], f64::from(share.min(1.0)));
            }
        });
    }
    outcome
}

/// Returns the text, with its middle replaced by an ellipsis if it is wider than `room` pixels.
pub fn fit(text: &str, em: f64, weight: Weight, room: f64) -> String {
    if width(text, em, weight) <= room {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let kept = |count: usize| -> String {
        let head = count.div_ceil(2);
        letters[..head].iter().chain(['…'].iter()).chain(&letters[letters.len() - (count - head)..]).collect()
    };
    let fitting = (0..letters.len()).rev().map(kept).find(|shorter| width(shorter, em, weight) <= room);
    fitting.unwrap_or_else(|| "…".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_font() {
        // Advances of DejaVu Sans: 1303 of 2048 units for a digit, 651 for a space.
        assert!((width("0", 100.0, Weight::Regular) - 63.6).abs() < 0.2);
        assert!((width("0123456789", 10.0, Weight::Regular) - 63.6).abs() < 0.2);
        assert!((width(" ", 100.0, Weight::Regular) - 31.8).abs() < 0.2);
        assert!(width("bold", 12.0, Weight::Bold) > width("bold", 12.0, Weight::Regular));
        assert_eq!(width("", 12.0, Weight::Regular), 0.0);
    }

    #[test]
    fn long_texts_lose_their_middle() {
        let text = "a label that goes on and on until nobody reads its middle";
        let fitted = fit(text, 12.0, Weight::Regular, 120.0);
        assert!(width(&fitted, 12.0, Weight::Regular) <= 120.0 && fitted.contains('…'), "{fitted}");
        assert!(fitted.starts_with("a label") && fitted.ends_with("middle"), "{fitted}");
        assert_eq!(fit("short", 12.0, Weight::Regular, 120.0), "short");
        assert_eq!(fit("short", 12.0, Weight::Regular, 0.0), "…");
    }
}
