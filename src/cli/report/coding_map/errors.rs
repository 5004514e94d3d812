//! Pictures of the difference between a decoded image and its source (GDC figure 1c): the error of each pixel and, for
//! colour, the PSNR of each cell.

use super::keyframes::{CellMark, draw_cells};
use super::subject::{Subject, percent};
use crate::report::picture::raster::{HALF_SIDE, MAX_SIDE, Scale, hatch, render};
use crate::report::picture::sheet::{Bar, Entry, Panel, Sheet, Swatch};
use crate::report::plot::palette::{self, Rgb};
use codec::color::quality::PU_STEPS;
use codec::error::{Result, counted};
use codec::image::StreamKind;
use codec::image::plane::Plane;
use codec::streams::{CodecHeader, ColorFormat};
use footage::compare::{CellPsnr, Coding, ErrorMap, LargestError};
use footage::metrics::depth_error::PixelError;

pub(super) fn sheet(subject: &Subject<'_>, map: &ErrorMap, source: &str, frame: u32) -> Result<Sheet> {
    let size = subject.size();
    let scale = Scale::of(size, if map.cells.is_empty() { MAX_SIDE } else { HALF_SIDE });
    let LargestError { steps: largest, background_pixels: background, outside_pixels: outside } = map.largest();
    let scale_of = ErrorScale::of(largest, bound(subject));
    let (unit, steps) = match map.domain.coding {
        Coding::Depth(_) => ("16-bit log codes", 1.0),
        Coding::Color(ColorFormat::Half { .. }, _) => ("PU21 codes, the largest of R, G and B", PU_STEPS),
        Coding::Color(..) => ("8-bit codes, the largest of R, G and B", 1.0),
        Coding::Bytes if subject.stream.kind == StreamKind::Material => {
            ("8-bit codes, the largest of the three weights", 1.0)
        }
        Coding::Bytes => ("8-bit codes", 1.0),
    };
    let told = |error: u32| trimmed(f64::from(error) / steps);
    let odd = background + outside;
    let mut key = Vec::new();
    if odd > 0 {
        let words = format!("{}: background on one side only, or a depth outside of the range", counted(odd, "pixel"));
        key.push(Entry { swatch: Swatch::Hatched(palette::MISMATCH), words });
    }
    let mark = bound(subject).filter(|&bound| bound > 0 && bound <= scale_of.top);
    let how = if scale_of.logarithmic { ", on a logarithmic scale" } else { "" };
    let errors = Panel {
        caption: "Error of each pixel".to_owned(),
        image: draw_errors(size, scale, map, scale_of),
        key,
        bar: Some(Bar {
            color: palette::heat,
            ticks: scale_of.ticks().into_iter().map(|error| (scale_of.part(error), told(error))).collect(),
            label: format!("Error in {unit}{how}:"),
            mark: mark.map(|bound| (scale_of.part(bound), format!("the stream's bound, {} codes", told(bound)))),
        }),
    };
    let mut panels = vec![errors];
    if !map.cells.is_empty() {
        panels.push(cells(subject, scale, map)?);
    }
    let found = match map.differing_pixels() {
        0 => "No pixel differs.".to_owned(),
        count => {
            let verb = if count == 1 { "differs" } else { "differ" };
            let of_others = if odd > 0 { " of the others" } else { "" };
            let worst = match largest {
                0 => String::new(),
                error => format!(", the largest error{of_others} is {} codes", told(error)),
            };
            format!("{} ({}) {verb}{worst}.", counted(count, "pixel"), percent(count, subject.pixels()))
        }
    };
    let facts = vec![subject.fact(scale), format!("Compared with {source}. {found}")];
    let title = format!("{}, frame {frame}, error against the source", subject.name);
    Ok(Sheet { title, facts, panels })
}

fn bound(subject: &Subject<'_>) -> Option<u32> {
    match &subject.stream.header {
        CodecHeader::Depth(header) => header.error_bound().map(u32::from),
        CodecHeader::Material(header) => Some(u32::from(header.temporal.epsilon)),
        CodecHeader::Alpha(_) => Some(0),
        CodecHeader::Color(_) => None,
    }
}

#[derive(Debug, Clone, Copy)]
struct ErrorScale {
    top: u32,
    logarithmic: bool,
}

impl ErrorScale {
    /// Returns a linear scale up to `bound` if no error exceeds it, else a scale up to the largest error. The latter is
    /// logarithmic above 255: on a linear scale a few large errors would make all others invisible.
    fn of(largest: u32, bound: Option<u32>) -> ErrorScale {
        match bound.filter(|&bound| largest <= bound) {
            Some(bound) => ErrorScale { top: bound.max(1), logarithmic: false },
            None => ErrorScale { top: largest.max(1), logarithmic: largest > 255 },
        }
    }

    fn part(self, error: u32) -> f64 {
        match self.logarithmic {
            true => f64::from(error).ln_1p() / f64::from(self.top).ln_1p(),
            false => f64::from(error) / f64::from(self.top),
        }
    }

    fn ticks(self) -> Vec<u32> {
        if self.logarithmic {
            let tens = (0..).map(|power| 10u32.saturating_pow(power)).take_while(|&ten| ten < self.top);
            return [0].into_iter().chain(tens).chain([self.top]).collect();
        }
        let count = self.top.min(4);
        (0..=count).map(|at| (u64::from(self.top) * u64::from(at) / u64::from(count)) as u32).collect()
    }
}

fn draw_errors(size: [u32; 2], scale: Scale, map: &ErrorMap, errors: ErrorScale) -> Plane<Rgb> {
    let mut drawn = render(size, scale, |x, y| match map.pixels.get(x, y) {
        PixelError::Steps(steps) => palette::heat(errors.part(steps)),
        PixelError::Background | PixelError::Outside => palette::MISMATCH,
    });
    hatch(&mut drawn, scale, |x, y| !matches!(map.pixels.get(x, y), PixelError::Steps(_)));
    drawn
}

fn cells(subject: &Subject<'_>, scale: Scale, map: &ErrorMap) -> Result<Panel> {
    let finite = || map.cells.iter().map(|cell| cell.psnr_db).filter(|db| db.is_finite());
    let asked = match &subject.stream.header {
        CodecHeader::Color(header) => Some(header.min_psnr_db),
        _ => None,
    };
    let least = finite().chain(asked).fold(f64::INFINITY, f64::min).floor();
    let most = finite().chain(asked).fold(f64::NEG_INFINITY, f64::max).ceil().max(least + 1.0);
    // Cells of lower PSNR are brighter, like pixels of larger error in the adjacent panel.
    let part = |db: f64| 1.0 - (db - least) / (most - least);
    let mark = |cell: &CellPsnr| {
        let (color, words) = match cell.psnr_db {
            db if db.is_finite() => (palette::heat(part(db)), format!("{db:.1}")),
            _ => (palette::EXACT, String::new()),
        };
        CellMark { rect: cell.rect, color, words, corner: asked.is_some_and(|asked| cell.psnr_db < asked) }
    };
    let marks: Vec<CellMark> = map.cells.iter().map(mark).collect();
    let exact = map.cells.len() - finite().count();
    let below = marks.iter().filter(|mark| mark.corner).count() as u64;
    let mut key = Vec::new();
    if exact > 0 {
        let words = format!("{}: nothing differs", counted(exact as u64, "cell"));
        key.push(Entry { swatch: Swatch::Flat(palette::EXACT), words });
    }
    if below > 0 {
        let words = format!("{} below what was asked for", counted(below, "cell"));
        key.push(Entry { swatch: Swatch::Corner(palette::heat(1.0)), words });
    }
    let bar = (exact < map.cells.len()).then(|| Bar {
        color: |part| palette::heat(1.0 - part),
        ticks: (0..=4).map(|at| f64::from(at) / 4.0).map(|at| (at, trimmed(least + at * (most - least)))).collect(),
        label: "PSNR in dB:".to_owned(),
        mark: asked.map(|asked| ((asked - least) / (most - least), format!("asked for, {} dB", trimmed(asked)))),
    });
    let caption = "PSNR of each cell".to_owned();
    Ok(Panel { caption, image: draw_cells(subject.size(), scale, &marks)?, key, bar })
}

/// Formats with at most two decimals and no trailing zeros.
fn trimmed(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_whole_numbers_with_both_ends() {
        let ticks = |largest, bound| ErrorScale::of(largest, bound).ticks();
        assert_eq!(ticks(0, Some(0)), [0, 1]);
        assert_eq!(ticks(97, Some(100)), [0, 25, 50, 75, 100]);
        assert_eq!(ticks(3, None), [0, 1, 2, 3]);
        assert_eq!(ticks(2791, None), [0, 1, 10, 100, 1000, 2791]);
        assert_eq!(ticks(2791, Some(100)), [0, 1, 10, 100, 1000, 2791]);
        for (largest, bound) in [(0, None), (7, Some(100)), (65535, None), (u32::MAX, Some(1))] {
            let scale = ErrorScale::of(largest, bound);
            assert_eq!((scale.part(0), scale.part(scale.top)), (0.0, 1.0));
            assert!(scale.ticks().is_sorted_by(|a, b| a < b));
        }
        assert_eq!([40.0, 42.25, 0.5, 100.0].map(trimmed), ["40", "42.25", "0.5", "100"]);
    }
}
