//! Colours of all pictures: of values, by viridis, and of what is to be told apart, by the colours of Okabe and Ito, which
//! colour-blind people can tell apart, too.

use super::drawing::Ink;

/// Viridis at even steps from its dark end to its bright one, sRGB.
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

/// Blue of Okabe and Ito.
pub const BLUE: Ink = Ink::opaque([0, 114, 178]);
pub const VERMILION: Ink = Ink::opaque([213, 94, 0]);
/// Their bluish green.
pub const GREEN: Ink = Ink::opaque([0, 158, 115]);
/// Their reddish purple.
pub const PURPLE: Ink = Ink::opaque([204, 121, 167]);
/// Their sky blue.
pub const SKY: Ink = Ink::opaque([86, 180, 233]);
pub const ORANGE: Ink = Ink::opaque([230, 159, 0]);
/// Their yellow, for areas; it is too bright for lines on white.
pub const YELLOW: Ink = Ink::opaque([240, 228, 66]);

/// Colours of series in the order in which they are used; yellow is darkened, and what is almost black comes last.
const SERIES: [Ink; 8] =
    [BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, Ink::opaque([148, 128, 0]), Ink::opaque([60, 60, 60])];

/// Text and lines of axes.
pub const TEXT: Ink = Ink::opaque([34, 34, 34]);
/// Text that matters less.
pub const FAINT_TEXT: Ink = Ink::opaque([96, 96, 96]);
/// A line that says little, such as one to where there is no value.
pub const FAINT_LINE: Ink = Ink::opaque([165, 165, 165]);
/// Lines of a grid.
pub const GRID: Ink = Ink::opaque([226, 226, 226]);
/// Ground of what is missing.
pub const MISSING: Ink = Ink::opaque([240, 240, 240]);
/// What is to be seen first: the best cell of a map, the line of what is lossless.
pub const MARK: Ink = Ink::opaque([214, 39, 40]);

/// The colour of a value between 0, dark, and 1, bright. What is not a number is taken as 0.
pub fn viridis(value: f64) -> Ink {
    let last = VIRIDIS.len() - 1;
    let place = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) * last as f64 };
    let below = (place as usize).min(last - 1);
    let part = place - below as f64;
    let mix = |from: u8, to: u8| (f64::from(from) + (f64::from(to) - f64::from(from)) * part).round() as u8;
    Ink::opaque(std::array::from_fn(|at| mix(VIRIDIS[below][at], VIRIDIS[below + 1][at])))
}

/// Black or white, whichever has more contrast with a ground (WCAG 2: relative luminance).
pub fn legible_on(ground: Ink) -> Ink {
    let linear = |code: u8| {
        let value = f64::from(code) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let [red, green, blue] = ground.rgb.map(linear);
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    // Where (1.05 / (luminance + 0.05)) and ((luminance + 0.05) / 0.05) are equal.
    if luminance > 0.179 { Ink::BLACK } else { Ink::WHITE }
}

/// The colour of the series of a number; colours come again after eight.
pub fn series(number: usize) -> Ink {
    SERIES[number % SERIES.len()]
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
}
