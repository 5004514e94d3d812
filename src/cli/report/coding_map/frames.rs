//! Pictures of the coded data of one depth or material frame: its image in grey, overlaid with nodes, boxes or blocks
//! (GDC figure 1b).

use super::subject::{Subject, What, percent};
use super::tints;
use crate::report::picture::raster::{MAX_SIDE, Scale, filled, hatch, outline, render, unit_borders};
use crate::report::picture::sheet::{Bar, Entry, Panel, Sheet, Swatch};
use crate::report::plot::palette::{self, Rgb};
use codec::decode::Picture;
use codec::depth::nodes::Function;
use codec::depth::predictive::modes::BlockCoding;
use codec::depth::quantise::{BACKGROUND_CODE, DepthRange};
use codec::error::counted;
use codec::image::StreamKind;
use codec::image::plane::Plane;
use codec::streams::{CodecHeader, ColorBlocks, DepthCoding, DepthHeader, convert};
use footage::inspect::{CodingMap, Writing};

pub(super) struct Shades {
    /// Grey level of each pixel, 0 (light) to 1 (dark). `None` for pixels without a surface.
    pub pixels: Plane<Option<f32>>,
    pub bar: Option<Bar>,
    pub entry: Option<Entry>,
}

impl Shades {
    /// Returns the grey levels of a picture: depth from nearest to farthest surface, material by the mean of its
    /// weights from largest to smallest, alpha from opaque to transparent. Colour is drawn by `keyframes`.
    pub fn of(subject: &Subject<'_>, picture: &Picture) -> Shades {
        match (picture, &subject.stream.header) {
            (Picture::Depth(codes), CodecHeader::Depth(header)) => of_depth(codes, header.range),
            (Picture::Material(codes), _) => of_material(codes),
            (Picture::Alpha(codes), _) => {
                Shades::plain(codes.map(|&code| Some(1.0 - convert::alpha_value(code.into()))))
            }
            _ => Shades::plain(Plane::filled(subject.size()[0], subject.size()[1], None)),
        }
    }

    pub fn plain(pixels: Plane<Option<f32>>) -> Shades {
        Shades { pixels, bar: None, entry: None }
    }

    fn has_background(&self) -> bool {
        self.pixels.data().iter().any(Option::is_none)
    }
}

const QUARTERS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Builds `Shades` with a colour bar labelled by `value`, or, if all pixels are equal, with a key entry that states
/// their value.
fn explained(
    pixels: Plane<Option<f32>>,
    one_value: Option<String>,
    (color, label): (fn(f64) -> Rgb, &str),
    value: impl Fn(f64) -> String,
) -> Shades {
    let bar = || {
        let ticks = QUARTERS.into_iter().map(|part| (part, value(part))).collect();
        Bar { color, ticks, label: label.to_owned(), mark: None }
    };
    let bar = one_value.is_none().then(bar);
    let entry = one_value.map(|words| Entry { swatch: Swatch::Flat(palette::grey(0.0)), words });
    Shades { pixels, bar, entry }
}

fn of_depth(codes: &Plane<u16>, range: DepthRange) -> Shades {
    let surfaces = || codes.data().iter().copied().filter(|&code| code != BACKGROUND_CODE);
    let (Some(near), Some(far)) = (surfaces().min(), surfaces().max()) else {
        return Shades::plain(codes.map(|_| None));
    };
    let span = f32::from(far - near).max(1.0);
    let pixels = codes.map(|&code| (code != BACKGROUND_CODE).then(|| f32::from(code - near) / span));
    let metres = |part: f64| significant(f64::from(range.metres(near + (part * f64::from(far - near)).round() as u16)));
    let one = (near == far).then(|| format!("all surfaces: {} m away", metres(0.0)));
    explained(pixels, one, (palette::grey, "Depth in metres, on a logarithmic scale:"), metres)
}

fn of_material(codes: &Plane<[u8; 3]>) -> Shades {
    let sums = codes.map(|pixel| pixel.iter().map(|&code| u16::from(code)).sum::<u16>());
    let least = sums.data().iter().copied().min().unwrap_or(0);
    let most = sums.data().iter().copied().max().unwrap_or(0);
    let span = f32::from(most - least).max(1.0);
    // Large weights are drawn light, as near surfaces are.
    let pixels = sums.map(|&sum| Some(f32::from(most - sum) / span));
    let mean = |part: f64| format!("{:.1}", (f64::from(least) + part * f64::from(most - least)) / 3.0);
    let one =
        (least == most).then(|| format!("all pixels: {} in 8-bit codes, the mean of the three weights", mean(0.0)));
    explained(pixels, one, (|part| palette::grey(1.0 - part), "Mean of the three weights in 8-bit codes:"), mean)
}

fn significant(value: f64) -> String {
    let digits = value.abs().max(1e-9).log10().floor() as i32;
    format!("{value:.*}", (2 - digits).clamp(0, 9) as usize)
}

pub(super) fn tinted(subject: &Subject<'_>, scale: Scale, shades: &Shades, map: &CodingMap) -> Plane<Rgb> {
    let size = subject.size();
    let writings = filled(size, &map.patches, None, |patch| Some(patch.writing));
    let mut drawn = render(size, scale, |x, y| {
        let color = shades.pixels.get(x, y).map_or(palette::BACKGROUND, |part| palette::grey(f64::from(part)));
        writings.get(x, y).map_or(color, |writing| tints::tinted(color, writing))
    });
    outline(&mut drawn, scale, &filled(size, &map.patches, 0, |patch| patch.part + 1));
    let entry = &subject.stream.entry;
    unit_borders(&mut drawn, scale, (0..entry.unit_count()).map(|unit| entry.unit_rect(unit)));
    hatch(&mut drawn, scale, |x, y| shades.pixels.get(x, y).is_none());
    drawn
}

fn name(header: &CodecHeader, writing: Writing) -> String {
    let (color, blocks) = match header {
        CodecHeader::Depth(_) | CodecHeader::Alpha(_) => (false, "BC5"),
        CodecHeader::Material(_) => (false, "BC1"),
        CodecHeader::Color(header) => match header.blocks() {
            Some(ColorBlocks::Bc1) => (true, "BC1"),
            Some(ColorBlocks::Bc6h) => (true, "BC6H"),
            _ => (true, "BC7"),
        },
    };
    match writing {
        Writing::Function(Function::Raw) => "raw codes".to_owned(),
        Writing::Function(Function::Platelet) => "platelet".to_owned(),
        Writing::Function(Function::Biquadratic) => "biquadratic, plane or constant".to_owned(),
        Writing::Function(Function::Bc4w) => "BC4w block".to_owned(),
        Writing::OneValue => "one value for a whole tile".to_owned(),
        Writing::Values if color => "keyframe in samples".to_owned(),
        Writing::Blocks if color => format!("keyframe in {blocks} blocks"),
        Writing::Values => "values as they are".to_owned(),
        Writing::Blocks => format!("pieces in {blocks} blocks"),
        Writing::Blend => "between two keyframes".to_owned(),
        Writing::Transform => "transformed block".to_owned(),
        Writing::Palette => "palette".to_owned(),
        Writing::Predicted(BlockCoding::Same | BlockCoding::Background) => "background".to_owned(),
        Writing::Predicted(BlockCoding::Plane) => "plane carried on".to_owned(),
        Writing::Predicted(BlockCoding::ChangedPlane) => "plane with a change".to_owned(),
        Writing::Predicted(BlockCoding::Quarters) => "quarters of 4x4 pixels".to_owned(),
        Writing::Predicted(BlockCoding::Pixels) => "pixel by pixel".to_owned(),
    }
}

/// Name of the coding unit of a depth or alpha stream. `None` for boxes.
fn part_word(header: &CodecHeader) -> Option<&'static str> {
    let header = match header {
        CodecHeader::Depth(header) => header,
        CodecHeader::Alpha(_) => return Some("block"),
        CodecHeader::Color(_) | CodecHeader::Material(_) => return None,
    };
    match header.coding {
        DepthCoding::Boxes(_) | DepthCoding::BoxesInBlocks(_) => None,
        DepthCoding::Blocks | DepthCoding::Predictive(_) => Some("block"),
        DepthCoding::Nodes(_) | DepthCoding::Tree(_) => Some("node"),
    }
}

pub(super) fn key(subject: &Subject<'_>, map: &CodingMap) -> Vec<Entry> {
    let pixels = subject.pixels();
    let word = |writing| match (subject.stream.kind, writing) {
        (StreamKind::Color, Writing::Transform | Writing::Palette) => Some("block"),
        (StreamKind::Color, _) => Some("cell"),
        _ => part_word(&subject.stream.header),
    };
    let line = |writing: Writing, parts: u64, written: u64| {
        let count = word(writing).map_or_else(String::new, |word| format!("{}, ", counted(parts, word)));
        let swatch = Swatch::Flat(tints::tinted(palette::grey(0.4), writing));
        let name = name(&subject.stream.header, writing);
        Entry { swatch, words: format!("{name}: {count}{} of the image", percent(written, pixels)) }
    };
    let extents = map.extents().into_iter();
    let mut key: Vec<Entry> = extents.map(|(writing, extent)| line(writing, extent.parts, extent.pixels)).collect();
    let rest = pixels - map.updated_pixels();
    if rest > 0 {
        let words = format!("not written, as before: {} of the image", percent(rest, pixels));
        key.push(Entry { swatch: Swatch::Flat(palette::grey(0.4)), words });
    }
    if subject.stream.entry.unit_count() > 1 {
        let words = format!("{} border", subject.unit_word());
        key.push(Entry { swatch: Swatch::Dashed(palette::grey(0.4)), words });
    }
    key
}

pub(super) fn sentence(subject: &Subject<'_>, map: &CodingMap, parts: Option<&str>) -> String {
    if map.patches.is_empty() {
        return "No pixel is written in this frame: the image is that of an earlier one.".to_owned();
    }
    let (units, word) = (subject.stream.entry.unit_count(), subject.unit_word());
    let pixels = subject.pixels();
    let in_units = match units {
        1 => format!(" in one {word}"),
        _ => format!(" in {} of {}", map.written_units, counted(u64::from(units), word)),
    };
    let keyframes = match (units, map.keyframe_units) {
        (_, 0) => String::new(),
        (1, _) => ", as a keyframe".to_owned(),
        (_, count) => format!(", {count} of them keyframes"),
    };
    let parts = parts.map_or_else(String::new, |parts| format!(" by {parts}"));
    let updated = map.updated_pixels();
    format!("{updated} of {pixels} pixels ({}) are written{parts}{in_units}{keyframes}.", percent(updated, pixels))
}

pub(super) fn sheet(subject: &Subject<'_>, map: &CodingMap, picture: &Picture) -> (What, Sheet) {
    let scale = Scale::of(subject.size(), MAX_SIDE);
    let shades = Shades::of(subject, picture);
    let (what, part) = match part_word(&subject.stream.header) {
        Some(part @ "block") => (What::Blocks, part),
        Some(part) => (What::Nodes, part),
        None => (What::Boxes, "box"),
    };
    // A keyframe in box coding covers a whole tile and contains no box.
    let whole = what == What::Boxes && map.keyframe_units == map.written_units;
    let parts = (!whole).then(|| counted(u64::from(map.parts), part));
    let mut facts = vec![subject.fact(scale), sentence(subject, map, parts.as_deref())];
    if let CodecHeader::Depth(DepthHeader { coding: DepthCoding::Tree(_), .. }) = &subject.stream.header {
        let note = "The intermediate form writes raw leaves; outlined and tinted is the coarsest function that it holds for \
                    them.";
        facts.push(note.to_owned());
    }
    let mut key = key(subject, map);
    if shades.has_background() {
        key.push(Entry { swatch: Swatch::Hatched(palette::BACKGROUND), words: "background: no surface".to_owned() });
    }
    key.extend(shades.entry.clone());
    let image = match subject.stream.kind {
        StreamKind::Material => "Material",
        StreamKind::Alpha => "Alpha",
        _ => "Depth",
    };
    let caption = match what {
        _ if map.patches.is_empty() => format!("{image}; nothing is written"),
        _ if whole => format!("{image}, and the whole tiles that the frame writes"),
        What::Boxes => format!("{image}, and the boxes that the frame writes"),
        _ => format!("{image}, and the {part}s that the frame writes"),
    };
    let panel = Panel { caption, image: tinted(subject, scale, &shades, map), key, bar: shades.bar };
    let title = format!("{}, frame {}", subject.name, map.frame);
    (what, Sheet { title, facts, panels: vec![panel] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metres_have_three_digits() {
        assert_eq!(
            [0.0123, 0.5, 1.0, 12.34, 123.4, 98765.0].map(significant),
            ["0.0123", "0.500", "1.00", "12.3", "123", "98765"]
        );
    }

    #[test]
    fn depth_is_light_where_it_is_near_and_has_no_shade_where_nothing_is() {
        let range = DepthRange::new(1.0, 100.0).unwrap();
        let shades = of_depth(&Plane::new(4, 1, vec![100, 300, 200, BACKGROUND_CODE]).unwrap(), range);
        assert_eq!(shades.pixels.data(), [Some(0.0), Some(1.0), Some(0.5), None]);
        assert!(shades.has_background() && shades.bar.unwrap().ticks.len() == 5);
        let empty = of_depth(&Plane::filled(2, 2, BACKGROUND_CODE), range);
        assert!(empty.bar.is_none() && empty.pixels.data().iter().all(Option::is_none));
        let flat = of_depth(&Plane::filled(2, 2, 7), range);
        assert!(flat.bar.is_none() && flat.entry.is_some_and(|entry| entry.words.contains(" m ")));
        assert_eq!(flat.pixels.get(1, 1), Some(0.0));
    }
}
