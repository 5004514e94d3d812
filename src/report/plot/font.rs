//! The font of all charts: DejaVu Sans, which the program carries, so that a chart needs no font of the system.
//!
//! Sizes are those of CSS: pixels of an em.

use std::sync::OnceLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use crate::error::{Error, Result};

/// Font family of all text. `plotters` finds the registered font by this name, and in an SVG file it is the list of
/// families that a viewer looks for; Verdana has almost the same widths.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// Height of a line, ascender to descender, in ems: what `plotters` calls the size of a font drawn by ab_glyph.
pub(super) const LINE_PER_EM: f64 = 1.164_062_5;
/// Height of a capital letter or a digit in ems.
pub const CAP_PER_EM: f64 = 0.729;

/// Makes the font known to `plotters`, once for the process.
///
/// # Errors
/// When the font that the program carries cannot be read.
pub fn register() -> Result<()> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let registered = *REGISTERED.get_or_init(|| {
        register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular()).is_ok()
            && register_font(FAMILY, FontStyle::Bold, dejavu::sans::bold()).is_ok()
    });
    if registered { Ok(()) } else { Err(Error::unsupported("the font of the charts cannot be read")) }
}

/// The font in a size in `plotters`' measure.
pub(super) fn sized(size: f64, style: FontStyle) -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FAMILY), size, style)
}

/// Width in pixels of a text of one line, whose ems have `em` pixels; 0 where the font is missing.
pub fn width(text: &str, em: f64, style: FontStyle) -> f64 {
    /// Widths come in whole pixels, so they are taken at a size in which a pixel is little.
    const FINE: f64 = 1000.0;
    if register().is_err() {
        return 0.0;
    }
    let wide = sized(FINE * LINE_PER_EM, style).layout_box(text).map_or(0, |((left, _), (right, _))| right - left);
    f64::from(wide) * em / FINE
}

/// The text, or where it is wider than `room` pixels, its beginning and end around an ellipsis.
pub fn fit(text: &str, em: f64, style: FontStyle, room: f64) -> String {
    if width(text, em, style) <= room {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let kept = |count: usize| -> String {
        let head = count.div_ceil(2);
        letters[..head].iter().chain(['…'].iter()).chain(&letters[letters.len() - (count - head)..]).collect()
    };
    let fitting = (0..letters.len()).rev().map(kept).find(|shorter| width(shorter, em, style) <= room);
    fitting.unwrap_or_else(|| "…".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_font() {
        // Advances of DejaVu Sans: 1303 of 2048 units for a digit, 651 for a space.
        assert!((width("0", 100.0, FontStyle::Normal) - 63.6).abs() < 0.2);
        assert!((width("0123456789", 10.0, FontStyle::Normal) - 63.6).abs() < 0.2);
        assert!((width(" ", 100.0, FontStyle::Normal) - 31.8).abs() < 0.2);
        assert!(width("bold", 12.0, FontStyle::Bold) > width("bold", 12.0, FontStyle::Normal));
        assert_eq!(width("", 12.0, FontStyle::Normal), 0.0);
    }

    #[test]
    fn long_texts_lose_their_middle() {
        let text = "a label that goes on and on until nobody reads its middle";
        let fitted = fit(text, 12.0, FontStyle::Normal, 120.0);
        assert!(width(&fitted, 12.0, FontStyle::Normal) <= 120.0 && fitted.contains('…'), "{fitted}");
        assert!(fitted.starts_with("a label") && fitted.ends_with("middle"), "{fitted}");
        assert_eq!(fit("short", 12.0, FontStyle::Normal, 120.0), "short");
        assert_eq!(fit("short", 12.0, FontStyle::Normal, 0.0), "…");
    }
}
