//! A face of a probe that is shown: its units as they are decoded, and its texels (CALF 6.2).
//!
//! Enters: which units are wanted in a frame. Leaves: texels, and the rectangles of them that changed.
//!
//! The rule is that a texel is either right for the frame in all its kinds, or its depth is [`UNKNOWN`]. So a cell of colour
//! that is not wanted makes the depths of its texels unknown too, unless it is known to show the frame all the same.
//!
//! Where a device decodes depth and colour ([`crate::views::units_on_device`]), the rule is the same, and what would be written is told.

use std::collections::BTreeMap;
use std::sync::Arc;

use half::f16;

use crate::color::HalfKey;
use crate::container::StreamEntry;
use crate::dataset::stream::StreamKind;
use crate::decode::{Decoder, StreamInfo, UnitDecoder, UnitFilter, UnitPixels};
use crate::error::Result;
use crate::streams::DepthHeader;
use crate::views::light_field::{ColorTexels, FaceTexels, InverseDepth, UNKNOWN, sends_on};
use crate::views::rects::{Rect, bounds, joined, overlap};
use crate::views::units_on_device::{DepthPart, UnitId, UnitsOnDevice};

/// The streams of a face; all of its images have the same size.
#[derive(Debug, Clone)]
pub struct FaceStreams<'a> {
    /// Depth.
    pub depth: &'a StreamInfo,
    /// How it is coded.
    pub header: DepthHeader,
    /// Colour.
    pub color: &'a StreamInfo,
    /// Material, where there is one.
    pub material: Option<&'a StreamInfo>,
}

impl<'a> FaceStreams<'a> {
    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &'a StreamInfo> {
        [self.depth, self.color].into_iter().chain(self.material)
    }

    /// Whether all of them have a frame.
    pub fn have(&self, frame: u32) -> bool {
        self.all().all(|stream| stream.frames.contains(frame))
    }
}

/// A unit, and whether what texels have of it is right.
#[derive(Debug)]
pub struct ShownUnit<'a> {
    id: UnitId,
    /// Knows the unit, and decodes it where no device does.
    decoder: UnitDecoder<'a>,
    right: bool,
    was_right: bool,
    /// Pixels that decoding the frame has written.
    written: u64,
    /// Whether a weight of the material that it shows is above 0.
    calls: bool,
    /// Chunk that was counted last as one that a whole frame takes.
    counted: Option<usize>,
}

impl ShownUnit<'_> {
    /// Decodes a frame.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn decode(&mut self, frame: u32) -> Result<()> {
        self.written = self.decoder.decode(frame)?;
        self.right = true;
        if let UnitPixels::Material(pixels) = self.decoder.pixels()
            && self.is_new()
        {
            self.calls = pixels.iter().any(sends_on);
        }
        Ok(())
    }

    /// Which unit it is.
    pub fn id(&self) -> UnitId {
        self.id
    }

    /// A device has decoded the frame, and written so many pixels.
    pub fn was_decoded(&mut self, written: u64) {
        self.written = written;
        self.right = true;
    }

    fn is_new(&self) -> bool {
        self.right && (self.written > 0 || !self.was_right)
    }
}

/// The units of a stream.
#[derive(Debug)]
struct Units<'a> {
    stream: &'a StreamInfo,
    /// Units that were wanted last.
    wanted: u64,
    units: Vec<ShownUnit<'a>>,
}

impl<'a> Units<'a> {
    fn new(decoder: &'a Decoder, stream: &'a StreamInfo) -> Units<'a> {
        let unit = |unit| ShownUnit {
            id: UnitId { probe: stream.probe, stream: stream.index, unit },
            decoder: decoder.unit(stream, unit),
            right: false,
            was_right: false,
            written: 0,
            calls: false,
            counted: None,
        };
        Units { stream, wanted: 0, units: (0..stream.entry.unit_count()).map(unit).collect() }
    }

    fn rect(&self, unit: usize) -> Rect {
        self.units[unit].decoder.rect()
    }

    /// The units that a frame wants; see [`ShownFace::want`].
    fn want(
        &mut self,
        frame: u32,
        filter: Option<&dyn UnitFilter>,
        device: Option<&dyn UnitsOnDevice>,
    ) -> Vec<&mut ShownUnit<'a>> {
        let shows = |unit: &ShownUnit<'_>| match device {
            Some(device) => device.shows(unit.id, frame),
            None => unit.decoder.shows(frame),
        };
        let mut wanted = Vec::new();
        for (at, unit) in (0..).zip(&mut self.units) {
            unit.written = 0;
            unit.was_right = unit.right;
            if filter.is_some_and(|filter| filter.wants(self.stream, at, frame)) {
                wanted.push(unit);
            } else {
                unit.right = unit.right && shows(unit);
            }
        }
        self.wanted = wanted.len() as u64;
        wanted
    }

    /// Units that a rectangle is in, with what they have in common.
    fn under(&self, rect: Rect) -> impl Iterator<Item = (usize, Rect)> {
        units_under(&self.stream.entry, rect).filter_map(move |unit| Some((unit, overlap(self.rect(unit), rect)?)))
    }
}

/// Numbers of the units that a rectangle of an image lies in.
pub fn units_under(entry: &StreamEntry, [left, top, width, height]: Rect) -> impl Iterator<Item = usize> + use<> {
    let columns = entry.width.div_ceil(entry.unit_width);
    let span = |from: u32, length: u32, unit: u32| from / unit..(from + length).div_ceil(unit);
    let across = span(left, width, entry.unit_width);
    span(top, height, entry.unit_height)
        .flat_map(move |row| across.clone().map(move |column| (row * columns + column) as usize))
}

/// What changed in a face.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FaceChanges {
    /// Rectangles of its texels, none of them twice.
    pub rects: Vec<(StreamKind, Rect)>,
    /// Units that were decoded, and wrote something.
    pub decoded: u64,
    /// Units that were wanted and showed the frame already.
    pub unchanged: u64,
    /// Units that were not wanted.
    pub unseen: u64,
    /// What a device is to write, where depths lie on one.
    pub depth_parts: Vec<DepthPart>,
}

/// A face that is shown.
#[derive(Debug)]
pub struct ShownFace<'a> {
    inverse: Arc<InverseDepth>,
    depth: Units<'a>,
    color: Units<'a>,
    material: Option<Units<'a>>,
}

impl<'a> ShownFace<'a> {
    /// A face of which nothing was decoded yet.
    pub fn new(decoder: &'a Decoder, streams: &FaceStreams<'a>, inverse: Arc<InverseDepth>) -> ShownFace<'a> {
        ShownFace {
            inverse,
            depth: Units::new(decoder, streams.depth),
            color: Units::new(decoder, streams.color),
            material: streams.material.map(|stream| Units::new(decoder, stream)),
        }
    }

    /// What codes of its depth become.
    pub fn inverse(&self) -> &Arc<InverseDepth> {
        &self.inverse
    }

    fn all(&self) -> impl Iterator<Item = &Units<'a>> {
        [&self.depth, &self.color].into_iter().chain(&self.material)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Units<'a>> {
        [&mut self.depth, &mut self.color].into_iter().chain(&mut self.material)
    }

    /// The units of depth and colour that a frame wants, which are to be decoded; the others keep what is right for it.
    /// `None` wants none; `device` is what decodes them, where the player does not.
    pub fn want(
        &mut self,
        frame: u32,
        filter: Option<&dyn UnitFilter>,
        device: Option<&dyn UnitsOnDevice>,
    ) -> Vec<&mut ShownUnit<'a>> {
        [&mut self.depth, &mut self.color].into_iter().flat_map(|units| units.want(frame, filter, device)).collect()
    }

    /// The same of material.
    pub fn want_material(&mut self, frame: u32, filter: Option<&dyn UnitFilter>) -> Vec<&mut ShownUnit<'a>> {
        self.material.iter_mut().flat_map(|units| units.want(frame, filter, None)).collect()
    }

    /// Whether a weight of the materials that are shown is above 0.
    pub fn calls_for_effects(&self) -> bool {
        self.material.iter().flat_map(|units| &units.units).any(|unit| unit.right && unit.calls)
    }

    /// Brings the texels to what the units show.
    pub fn update(&mut self, texels: &mut FaceTexels) -> FaceChanges {
        let mut changes = FaceChanges::default();
        for unit in self.all().flat_map(|units| &units.units) {
            changes.decoded += u64::from(unit.written > 0);
        }
        let wanted: u64 = self.all().map(|units| units.wanted).sum();
        changes.unchanged = wanted - changes.decoded;
        changes.unseen = self.all().map(|units| units.units.len() as u64).sum::<u64>() - wanted;
        let mut push = |kind: StreamKind, rects: Vec<Rect>| {
            changes.rects.extend(rects.into_iter().map(|rect| (kind, rect)));
        };
        if texels.is_on_device() {
            changes.depth_parts = self.depth_parts();
            push(StreamKind::Depth, joined(changes.depth_parts.iter().map(|part| part.rect).collect()));
            let new = self.color.units.iter().filter(|unit| unit.is_new());
            push(StreamKind::Color, joined(new.map(|unit| unit.decoder.rect()).collect()));
        } else {
            push(StreamKind::Depth, joined(self.update_depth(texels)));
            push(StreamKind::Color, joined(update_color(&self.color, texels)));
        }
        if let Some(material) = &self.material {
            push(StreamKind::Material, joined(update_material(material, texels)));
            texels.calls_for_effects = self.calls_for_effects();
        }
        changes
    }

    /// Forgets what is right; to be followed by a face of which nothing is known.
    pub fn forget(&mut self) {
        for unit in self.all_mut().flat_map(|units| &mut units.units) {
            (unit.right, unit.was_right, unit.written) = (false, false, 0);
        }
    }

    /// Stored bytes that were read so far.
    pub fn bytes_read(&self) -> u64 {
        self.all().flat_map(|units| &units.units).map(|unit| unit.decoder.cost().bytes_read).sum()
    }

    /// Stored bytes of the chunks that hold a frame, as far as they were not those of the frame before.
    pub fn count_bytes(&mut self, frame: u32) -> u64 {
        let mut bytes = 0;
        for unit in self.all_mut().flat_map(|units| &mut units.units) {
            if let Ok((chunk, stored)) = unit.decoder.chunk_of(frame)
                && unit.counted.replace(chunk) != Some(chunk)
            {
                bytes += u64::from(stored);
            }
        }
        bytes
    }

    /// Tiles, or rectangles of them, in which a unit of any kind became right, ceased to be, or has other pixels.
    fn stale_depths(&self) -> Vec<(usize, Rect)> {
        let turned = |unit: &ShownUnit<'_>| unit.right != unit.was_right;
        let mut stale = Vec::new();
        let mut whole = vec![false; self.depth.units.len()];
        for (at, unit) in self.depth.units.iter().enumerate() {
            if unit.is_new() || turned(unit) {
                whole[at] = true;
                stale.push((at, self.depth.rect(at)));
            }
        }
        for units in [&self.color].into_iter().chain(&self.material) {
            for (at, _) in units.units.iter().enumerate().filter(|(_, unit)| turned(unit)) {
                stale.extend(self.depth.under(units.rect(at)).filter(|(tile, _)| !whole[*tile]));
            }
        }
        stale
    }

    /// The parts of a rectangle of a tile that are right in all kinds, and those that are not.
    fn parts(&self, tile: usize, rect: Rect) -> Vec<(bool, Rect)> {
        let tile = &self.depth.units[tile];
        let mut parts = Vec::new();
        for (cell, rect) in self.color.under(rect) {
            let right = tile.right && self.color.units[cell].right;
            match &self.material {
                None => parts.push((right, rect)),
                Some(material) => {
                    parts.extend(material.under(rect).map(|(at, rect)| (right && material.units[at].right, rect)));
                }
            }
        }
        parts
    }

    /// What [`ShownFace::update_depth`] writes, for a device to write it: in as few parts as there can be, none twice.
    fn depth_parts(&self) -> Vec<DepthPart> {
        let mut stale: BTreeMap<usize, Vec<(bool, Rect)>> = BTreeMap::new();
        for (tile, rect) in self.stale_depths() {
            stale.entry(tile).or_default().extend(self.parts(tile, rect));
        }
        // A cell and a material that turn together lie over the same texels.
        if self.material.is_some() {
            stale.values_mut().for_each(once);
        }
        let mut all = Vec::new();
        for (tile, parts) in stale {
            for is_known in [false, true] {
                let alike = parts.iter().filter(|part| part.0 == is_known).map(|part| part.1);
                let rects = joined(alike.collect()).into_iter();
                all.extend(rects.map(|rect| DepthPart { unit: tile as u32, rect, is_known }));
            }
        }
        all
    }

    /// Writes depths that are stale; answers what became different.
    fn update_depth(&self, texels: &mut FaceTexels) -> Vec<Rect> {
        let mut changed = Vec::new();
        for (tile, rect) in self.stale_depths() {
            changed.extend(self.write_depth(tile, rect, texels));
        }
        changed
    }

    /// Writes depths of a tile in a rectangle of it; answers what became different.
    fn write_depth(&self, tile: usize, rect: Rect, texels: &mut FaceTexels) -> Option<Rect> {
        let decoder = &self.depth.units[tile].decoder;
        let UnitPixels::Depth(codes) = decoder.pixels() else { return None };
        let mut changed = None;
        for (right, [left, top, width, height]) in self.parts(tile, rect) {
            let [tile_left, tile_top, tile_width, _] = decoder.rect();
            for row in top..top + height {
                let start = row as usize * texels.size[0] as usize + left as usize;
                let differ = if right {
                    let from = (row - tile_top) as usize * tile_width as usize + (left - tile_left) as usize;
                    self.inverse.write_row(&codes[from..from + width as usize], texels, [left, row])
                } else {
                    fill_unknown(&mut texels.inverse_depth[start..start + width as usize])
                };
                if let Some([first, last]) = differ {
                    changed = Some(bounds(changed, [left + first, row, last - first + 1, 1]));
                }
            }
        }
        changed
    }
}

/// Leaves each part once.
fn once(parts: &mut Vec<(bool, Rect)>) {
    parts.sort_unstable();
    parts.dedup();
}

/// Makes texels unknown; answers the first and the last that were not.
fn fill_unknown(texels: &mut [f32]) -> Option<[u32; 2]> {
    let known = |texel: &f32| *texel != UNKNOWN;
    let ends = [texels.iter().position(known)?, texels.iter().rposition(known)?];
    texels.fill(UNKNOWN);
    Some(ends.map(|end| end as u32))
}

/// Writes rows of a unit into an image of `width` pixels.
fn write<T: Copy, U>(pixels: &[T], rect: Rect, image: &mut [U], width: u32, convert: impl Fn(T) -> U) {
    let [left, top, unit_width, _] = rect;
    for (row, pixels) in (top..).zip(pixels.chunks_exact(unit_width as usize)) {
        let start = row as usize * width as usize + left as usize;
        image[start..start + pixels.len()].iter_mut().zip(pixels).for_each(|(texel, &pixel)| *texel = convert(pixel));
    }
}

/// The light of a key, as encoders take it: black for what is no number, the largest half for what is infinite. Containers may
/// hold both, and weights of 0 would make no number of the second.
fn light_of(key: HalfKey) -> f16 {
    let light = key.to_half();
    if light.is_nan() { f16::ZERO } else { light.clamp(f16::MIN, f16::MAX) }
}

fn update_color(units: &Units<'_>, texels: &mut FaceTexels) -> Vec<Rect> {
    let width = texels.size[0];
    let new = units.units.iter().filter(|unit| unit.is_new());
    new.filter_map(|unit| {
        let rect = unit.decoder.rect();
        match (unit.decoder.pixels(), &mut texels.color) {
            (UnitPixels::Color8(pixels), ColorTexels::Codes(image)) => {
                write(pixels, rect, image, width, |[r, g, b]| [r, g, b, 0]);
            }
            (UnitPixels::ColorHalf(pixels), ColorTexels::Light(image)) => {
                let light = |[r, g, b]: [HalfKey; 3]| [light_of(r), light_of(g), light_of(b), f16::ZERO];
                write(pixels, rect, image, width, light);
            }
            _ => return None,
        }
        Some(rect)
    })
    .collect()
}

fn update_material(units: &Units<'_>, texels: &mut FaceTexels) -> Vec<Rect> {
    let width = texels.size[0];
    let Some(image) = &mut texels.material else { return Vec::new() };
    let new = units.units.iter().filter(|unit| unit.is_new());
    new.filter_map(|unit| {
        let UnitPixels::Material(pixels) = unit.decoder.pixels() else { return None };
        write(pixels, unit.decoder.rect(), image, width, |[a, b, c]| [a, b, c, 0]);
        Some(unit.decoder.rect())
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_many_small_cells_are_left_once() {
        // As many as cells of 4 pixels under a tile of 2048: comparing all with all would take minutes.
        let cell = |at: u32| (at.is_multiple_of(3), [at % 512 * 4, at / 512 * 4, 4, 4]);
        let mut parts: Vec<(bool, Rect)> = (0..512 * 512).chain(0..512 * 512).map(cell).collect();
        once(&mut parts);
        assert_eq!(parts.len(), 512 * 512);
        assert_eq!(parts.iter().filter(|part| part.0).count(), (512 * 512usize).div_ceil(3));
    }

    #[test]
    fn light_is_always_finite() {
        let (mut infinite, mut none) = (0, 0);
        for half in (0..=u16::MAX).map(f16::from_bits) {
            let light = light_of(HalfKey::from_bits(half.to_bits()));
            if half.is_finite() {
                assert_eq!(light.to_bits(), half.to_bits());
            } else if half.is_nan() {
                assert_eq!(light.to_bits(), 0);
                none += 1;
            } else {
                assert_eq!(light, if half.is_sign_positive() { f16::MAX } else { f16::MIN });
                infinite += 1;
            }
        }
        assert_eq!([infinite, none], [2, 2046]);
    }
}
