//! Colours of all pictures: viridis for values, the colour-blind safe colours of Okabe and Ito for categories. Scales
//! are monotonic in lightness, so that they can be read in greyscale.

use super::drawing::Ink;

/// Viridis in sRGB at equal steps, from dark to bright.
const VIRIDIS: [[u8; 3]; 20] = [
    [68, 1, 84],
    [72, 21, 103],
    [72, 38, 119],
    [69, 55, 129],
    [64, 71, 136],
    [57, 86, 140],
    [51, 99, 141],
    [45, 112, 142],
    [40, 125, 142],
    [35, 138, 141],
    [31, 150, 139],
    [32, 163, 135],
    [41, 175, 127],
    [60, 187, 117],
    [85, 198, 103],
    [115, 208, 85],
    [149, 216, 64],
    [184, 222, 41],
    [220, 227, 25],
    [253, 231, 37],
];

/// Okabe and Ito's blue.
pub const BLUE: Ink = Ink::opaque([0, 114, 178]);
pub const VERMILION: Ink = Ink::opaque([213, 94, 0]);
pub const GREEN: Ink = Ink::opaque([0, 158, 115]);
pub const PURPLE: Ink = Ink::opaque([204, 121, 167]);
pub const SKY: Ink = Ink::opaque([86, 180, 233]);
pub const ORANGE: Ink = Ink::opaque([230, 159, 0]);
/// Okabe and Ito's yellow, for areas; too bright for lines on white.
pub const YELLOW: Ink = Ink::opaque([240, 228, 66]);

/// Colours of series in order of use. Yellow is darkened; the near black comes last.
const SERIES: [Ink; 8] =
    [BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, Ink::opaque([148, 128, 0]), Ink::opaque([60, 60, 60])];

/// Text and axis lines.
pub const TEXT: Ink = Ink::opaque([34, 34, 34]);
pub const FAINT_TEXT: Ink = Ink::opaque([96, 96, 96]);
/// Faint lines, such as those to missing values.
pub const FAINT_LINE: Ink = Ink::opaque([165, 165, 165]);
pub const GRID: Ink = Ink::opaque([226, 226, 226]);
pub const MISSING: Ink = Ink::opaque([240, 240, 240]);
/// Highlights: the best cell of a heat map, the lossless line.
pub const MARK: Ink = Ink::opaque([214, 39, 40]);

pub type Rgb = [u8; 3];

pub const PAPER: Rgb = [255, 255, 255];
pub const INK: Rgb = [24, 24, 24];
/// Faint text and thin lines of sheets.
pub const SOFT_INK: Rgb = FAINT_TEXT.rgb;
/// Background (no surface); hatched.
pub const BACKGROUND: Rgb = [30, 30, 30];
/// Background in only one of the two images, or depth outside the range; hatched.
pub const MISMATCH: Rgb = [213, 60, 0];
/// A cell without error.
pub const EXACT: Rgb = [236, 236, 236];
const GREYS: [f64; 2] = [240.0, 84.0];

/// Returns the viridis colour of a value from 0 (dark) to 1 (bright). NaN maps to 0.
pub fn viridis(value: f64) -> Ink {
    let last = VIRIDIS.len() - 1;
    let place = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) * last as f64 };
    let below = (place as usize).min(last - 1);
    Ink::opaque(mix(VIRIDIS[below], VIRIDIS[below + 1], place - below as f64))
}

/// Returns black or white, whichever has the higher contrast with `ground` (WCAG 2: relative luminance).
pub fn legible_on(ground: Ink) -> Ink {
    let linear = |code: u8| {
        let value = f64::from(code) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let [red, green, blue] = ground.rgb.map(linear);
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    // Luminance at which (1.05 / (luminance + 0.05)) equals ((luminance + 0.05) / 0.05).
    if luminance > 0.179 { Ink::BLACK } else { Ink::WHITE }
}

pub fn series(number: usize) -> Ink {
    SERIES[number % SERIES.len()]
}

pub fn mix(from: Rgb, to: Rgb, part: f64) -> Rgb {
    std::array::from_fn(|at| {
        let (from, to) = (f64::from(from[at]), f64::from(to[at]));
        (from + (to - from) * part.clamp(0.0, 1.0)).round() as u8
    })
}

pub fn lightness([red, green, blue]: Rgb) -> u32 {
    (54 * u32::from(red) + 183 * u32::from(green) + 19 * u32::from(blue)) / 256
}

pub fn contrast(ground: Rgb) -> Rgb {
    legible_on(Ink::opaque(ground)).rgb
}

pub fn outlined(color: Rgb) -> Rgb {
    if lightness(color) > 72 { mix(color, [0, 0, 0], 0.75) } else { mix(color, [255, 255, 255], 0.5) }
}

pub fn hatched(color: Rgb) -> Rgb {
    mix(color, contrast(color), 0.28)
}

/// Returns the grey of a depth from near (0, light) to far (1, dark).
pub fn grey(part: f64) -> Rgb {
    [(GREYS[0] + (GREYS[1] - GREYS[0]) * part.clamp(0.0, 1.0)).round() as u8; 3]
}

/// Returns the viridis colour of a value from 0 (dark violet) to 1 (yellow).
pub fn heat(part: f64) -> Rgb {
    viridis(part).rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_goes_from_dark_to_bright_and_takes_any_number() {
        let sum = |ink: Ink| ink.rgb.iter().map(|&code| u32::from(code)).sum::<u32>();
        assert_eq!(viridis(0.0).rgb, VIRIDIS[0]);
        assert_eq!(viridis(1.0).rgb, VIRIDIS[19]);
        assert!((0..100).all(|at| sum(viridis(f64::from(at) / 100.0)) <= sum(viridis(f64::from(at + 1) / 100.0)) + 2));
        assert_eq!(viridis(f64::NAN), viridis(0.0));
        assert_eq!(viridis(f64::INFINITY), viridis(1.0));
        assert_eq!(viridis(-3.0), viridis(0.0));
    }

    #[test]
    fn text_is_legible_on_both_ends() {
        assert_eq!(legible_on(viridis(0.0)), Ink::WHITE);
        assert_eq!(legible_on(viridis(1.0)), Ink::BLACK);
    }

    #[test]
    fn scales_grow_lighter_or_darker_all_the_way() {
        let steps = || (0..=100).map(|step| f64::from(step) / 100.0);
        assert!(steps().map(|part| lightness(heat(part))).is_sorted());
        assert!(steps().map(|part| lightness(grey(part))).is_sorted_by(|a, b| a >= b));
    }
}
