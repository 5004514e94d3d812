//! Cache of the units and texels of one face of a probe in the current frame (CALF 6.2).
//!
//! Takes the units that a frame needs. Returns texels, and the rectangles of texels that changed.
//!
//! Invariant: a texel is valid for the frame in all its kinds, or its depth is [`UNKNOWN`]. Therefore a colour cell or an alpha
//! unit outside the visible set makes the depths of its texels unknown too, unless it is known to show the frame anyway. A
//! [`backend`](crate::views::backend) that stores texels itself follows the same rule: [`FaceCache::depth_parts`] lists what it
//! has to write.

use std::collections::BTreeMap;
use std::sync::Arc;

use half::f16;

use crate::views::rects::joined;
use crate::views::{
    ColorTexels, FaceTexels, InverseDepth, Rect, StraightCodes, UNKNOWN, bounds, finite_half, has_specular_weight,
    overlap, straight_half,
};
use codec::color::HalfKey;
use codec::container::StreamEntry;
use codec::decode::{Decoder, StreamInfo, UnitDecoder, UnitFilter, UnitPixels};
use codec::error::Result;
use codec::image::StreamKind;
use codec::ordered::try_map_ordered;
use codec::streams::DepthHeader;
use codec::streams::convert::alpha_byte;

/// Streams of a face; all of its images have the same size.
#[derive(Debug, Clone)]
pub struct FaceStreams<'a> {
    pub depth: &'a StreamInfo,
    pub header: DepthHeader,
    pub color: &'a StreamInfo,
    pub alpha: Option<&'a StreamInfo>,
    pub material: Option<&'a StreamInfo>,
}

impl<'a> FaceStreams<'a> {
    pub fn all(&self) -> impl Iterator<Item = &'a StreamInfo> {
        [self.depth, self.color].into_iter().chain(self.alpha).chain(self.material)
    }

    pub fn have(&self, frame: u32) -> bool {
        self.all().all(|stream| stream.frames.contains(frame))
    }
}

/// Identifier of a tile or cell of a container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct UnitId {
    pub probe: usize,
    pub stream: u32,
    pub unit: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct DepthPart {
    pub unit: u32,
    /// True if its depths become those of the tile; otherwise they become unknown.
    pub is_known: bool,
    /// Left, top, width and height in texels of the face, inside the tile.
    pub rect: Rect,
}

#[derive(Debug)]
pub struct CachedUnit<'a> {
    pub id: UnitId,
    /// Describes the unit, and decodes it unless a backend does.
    decoder: UnitDecoder<'a>,
    is_valid: bool,
    was_valid: bool,
    /// Number of pixels that decoding the frame has written.
    written: u64,
    /// True if a weight of its material is above 0.
    is_specular: bool,
    /// Index of the last chunk that [`FaceCache::count_bytes`] counted.
    counted: Option<usize>,
    /// True if its decoder keeps only pixels from frame to frame.
    forgets: bool,
}

impl CachedUnit<'_> {
    pub fn decode(&mut self, frame: u32) -> Result<()> {
        let written = self.decoder.decode(frame)?;
        self.set_decoded(written);
        if let UnitPixels::Material(pixels) = self.decoder.pixels()
            && self.is_new()
        {
            self.is_specular = pixels.iter().any(has_specular_weight);
        }
        if self.forgets {
            self.decoder.forget();
        }
        Ok(())
    }

    /// True if its own decoder is known to show a frame.
    pub fn shows(&self, frame: u32) -> bool {
        self.decoder.shows(frame)
    }

    /// Marks the unit as decoded by a backend, with the number of pixels written.
    pub fn set_decoded(&mut self, written: u64) {
        (self.written, self.is_valid) = (written, true);
    }

    fn is_new(&self) -> bool {
        self.is_valid && (self.written > 0 || !self.was_valid)
    }

    fn has_turned(&self) -> bool {
        self.is_valid != self.was_valid
    }
}

/// Decodes a frame of units in parallel.
pub fn decode_on_cpu(frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()> {
    try_map_ordered(units, |unit: &mut CachedUnit<'_>| unit.decode(frame)).map(|_| ())
}

#[derive(Debug)]
struct StreamUnits<'a> {
    stream: &'a StreamInfo,
    /// Number of units that the frame needs.
    needed: u64,
    units: Vec<CachedUnit<'a>>,
}

impl<'a> StreamUnits<'a> {
    fn new(decoder: &'a Decoder, stream: &'a StreamInfo) -> StreamUnits<'a> {
        let unit = |unit| CachedUnit {
            id: UnitId { probe: stream.probe, stream: stream.index, unit },
            decoder: decoder.unit(stream, unit),
            is_valid: false,
            was_valid: false,
            written: 0,
            is_specular: false,
            counted: None,
            forgets: false,
        };
        StreamUnits { stream, needed: 0, units: (0..stream.entry.unit_count()).map(unit).collect() }
    }

    fn rect(&self, unit: usize) -> Rect {
        self.units[unit].decoder.rect()
    }

    fn begin_frame(
        &mut self,
        frame: u32,
        filter: Option<&dyn UnitFilter>,
        shows: &dyn Fn(&CachedUnit<'_>) -> bool,
    ) -> Vec<&mut CachedUnit<'a>> {
        let mut needed = Vec::new();
        for (at, unit) in (0..).zip(&mut self.units) {
            unit.written = 0;
            unit.was_valid = unit.is_valid;
            if filter.is_some_and(|filter| filter.wants(self.stream, at, frame)) {
                needed.push(unit);
            } else {
                unit.is_valid = unit.is_valid && shows(unit);
            }
        }
        self.needed = needed.len() as u64;
        needed
    }

    /// Returns the units that do not pass the filter of [`Self::begin_frame`], which are needed from now on.
    fn need_others(&mut self, frame: u32, filter: &dyn UnitFilter) -> Vec<&mut CachedUnit<'a>> {
        let units = (0..).zip(&mut self.units).filter(|(at, _)| !filter.wants(self.stream, *at, frame));
        let others: Vec<_> = units.map(|(_, unit)| unit).collect();
        self.needed += others.len() as u64;
        others
    }

    /// Returns the units that overlap a rectangle, with the overlap.
    fn under(&self, rect: Rect) -> impl Iterator<Item = (usize, Rect)> {
        units_under(&self.stream.entry, rect).filter_map(move |unit| Some((unit, overlap(self.rect(unit), rect)?)))
    }
}

/// Returns the indices of the units that overlap a rectangle of an image.
pub fn units_under(entry: &StreamEntry, [left, top, width, height]: Rect) -> impl Iterator<Item = usize> + use<> {
    let columns = entry.width.div_ceil(entry.unit_width);
    let span = |from: u32, length: u32, unit: u32| from / unit..(from + length).div_ceil(unit);
    let across = span(left, width, entry.unit_width);
    span(top, height, entry.unit_height)
        .flat_map(move |row| across.clone().map(move |column| (row * columns + column) as usize))
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FaceChanges {
    /// Changed rectangles of texels; those of one kind do not overlap.
    pub rects: Vec<(StreamKind, Rect)>,
    /// Number of units that were decoded and wrote pixels.
    pub decoded: u64,
    /// Number of needed units that already showed the frame.
    pub unchanged: u64,
    pub unseen: u64,
}

#[derive(Debug)]
pub struct FaceCache<'a> {
    pub inverse: Arc<InverseDepth>,
    depth: StreamUnits<'a>,
    color: StreamUnits<'a>,
    alpha: Option<StreamUnits<'a>>,
    material: Option<StreamUnits<'a>>,
    /// Present if colours are codes and the face has alpha.
    straight: Option<Arc<StraightCodes>>,
}

impl<'a> FaceCache<'a> {
    /// Creates a cache without decoded units. `straight` is required if colours are codes and the face has alpha.
    pub fn new(
        decoder: &'a Decoder,
        streams: &FaceStreams<'a>,
        inverse: Arc<InverseDepth>,
        straight: Option<Arc<StraightCodes>>,
    ) -> FaceCache<'a> {
        FaceCache {
            inverse,
            depth: StreamUnits::new(decoder, streams.depth),
            color: StreamUnits::new(decoder, streams.color),
            alpha: streams.alpha.map(|stream| StreamUnits::new(decoder, stream)),
            material: streams.material.map(|stream| StreamUnits::new(decoder, stream)),
            straight,
        }
    }

    /// Sets whether decoders keep only pixels from frame to frame, which takes less memory and more time.
    pub fn set_forgetting(&mut self, forgets: bool) {
        let streams = [&mut self.depth, &mut self.color].into_iter().chain(&mut self.alpha).chain(&mut self.material);
        for unit in streams.flat_map(|units| &mut units.units).filter(|unit| unit.forgets != forgets) {
            unit.forgets = forgets;
            if forgets {
                unit.decoder.forget();
            }
        }
    }

    fn all(&self) -> impl Iterator<Item = &StreamUnits<'a>> {
        [&self.depth].into_iter().chain(self.all_but_depth())
    }

    fn all_but_depth(&self) -> impl Iterator<Item = &StreamUnits<'a>> {
        [&self.color].into_iter().chain(&self.alpha).chain(&self.material)
    }

    /// Begins a frame. Returns the units of depth, colour and alpha that pass the filter and have to be decoded. Other units stay
    /// valid if they show the frame. Without a filter no unit is needed.
    pub fn begin_frame(
        &mut self,
        frame: u32,
        filter: Option<&dyn UnitFilter>,
        shows: &dyn Fn(&CachedUnit<'_>) -> bool,
    ) -> Vec<&mut CachedUnit<'a>> {
        let streams = [&mut self.depth, &mut self.color].into_iter().chain(&mut self.alpha);
        streams.flat_map(|units| units.begin_frame(frame, filter, shows)).collect()
    }

    /// Like [`Self::begin_frame`] for material, which backends never decode.
    pub fn begin_material(&mut self, frame: u32, filter: Option<&dyn UnitFilter>) -> Vec<&mut CachedUnit<'a>> {
        let units = self.material.iter_mut();
        units.flat_map(|units| units.begin_frame(frame, filter, &|unit| unit.shows(frame))).collect()
    }

    /// Returns the other units of material, which have to be decoded after those of [`Self::begin_material`] with this filter.
    pub fn begin_other_material(&mut self, frame: u32, filter: &dyn UnitFilter) -> Vec<&mut CachedUnit<'a>> {
        self.material.iter_mut().flat_map(|units| units.need_others(frame, filter)).collect()
    }

    /// True if a decoded unit of material that passes the filter has a specular texel.
    pub fn is_specular(&self, frame: u32, filter: &dyn UnitFilter) -> bool {
        self.material.iter().any(|material| {
            let units = (0..).zip(&material.units).filter(|(_, unit)| unit.is_valid && unit.is_specular);
            units.into_iter().any(|(at, _)| filter.wants(material.stream, at, frame))
        })
    }

    /// Updates the texels from the decoded units.
    pub fn update(&self, texels: &mut FaceTexels) -> FaceChanges {
        let depth = joined(self.update_depth(texels));
        let color = joined(self.update_color(texels));
        self.changes(depth, color, texels)
    }

    /// Like [`Self::update`], for a backend that stores depth and colour and writes the depths of `parts`; only materials are
    /// written to `texels`.
    pub fn update_in_backend(&self, parts: &[DepthPart], texels: &mut FaceTexels) -> FaceChanges {
        let depth = joined(parts.iter().map(|part| part.rect).collect());
        let new = self.color.units.iter().filter(|unit| unit.is_new());
        self.changes(depth, joined(new.map(|unit| unit.decoder.rect()).collect()), texels)
    }

    fn changes(&self, depth: Vec<Rect>, color: Vec<Rect>, texels: &mut FaceTexels) -> FaceChanges {
        let mut rects = Vec::new();
        let mut push = |kind: StreamKind, of: Vec<Rect>| rects.extend(of.into_iter().map(|rect| (kind, rect)));
        push(StreamKind::Depth, depth);
        push(StreamKind::Color, color);
        if let Some(material) = &self.material {
            push(StreamKind::Material, joined(update_material(material, texels)));
            texels.is_specular = material.units.iter().any(|unit| unit.is_valid && unit.is_specular);
        }
        let units = self.all().flat_map(|units| &units.units);
        let decoded = units.filter(|unit| unit.written > 0).count() as u64;
        let needed: u64 = self.all().map(|units| units.needed).sum();
        let count = self.all().map(|units| units.units.len() as u64).sum::<u64>();
        FaceChanges { rects, decoded, unchanged: needed - decoded, unseen: count - needed }
    }

    pub fn bytes_read(&self) -> u64 {
        self.all().flat_map(|units| &units.units).map(|unit| unit.decoder.cost().bytes_read).sum()
    }

    /// Returns the stored bytes of the chunks that hold a frame and were not counted for the previous frame.
    pub fn count_bytes(&mut self, frame: u32) -> u64 {
        let mut bytes = 0;
        let streams = [&mut self.depth, &mut self.color].into_iter().chain(&mut self.alpha).chain(&mut self.material);
        for unit in streams.flat_map(|units| &mut units.units) {
            if let Ok((chunk, stored)) = unit.decoder.chunk_of(frame)
                && unit.counted.replace(chunk) != Some(chunk)
            {
                bytes += u64::from(stored);
            }
        }
        bytes
    }

    /// Returns the tiles with new pixels and the tiles that became valid or invalid, and the rectangles of other tiles under
    /// units of other kinds that became valid or invalid.
    fn stale_depths(&self) -> Vec<(usize, Rect)> {
        let mut stale = Vec::new();
        let mut whole = vec![false; self.depth.units.len()];
        for (at, unit) in self.depth.units.iter().enumerate() {
            if unit.is_new() || unit.has_turned() {
                whole[at] = true;
                stale.push((at, self.depth.rect(at)));
            }
        }
        for units in self.all_but_depth() {
            for (at, _) in units.units.iter().enumerate().filter(|(_, unit)| unit.has_turned()) {
                stale.extend(self.depth.under(units.rect(at)).filter(|(tile, _)| !whole[*tile]));
            }
        }
        stale
    }

    /// Splits a rectangle of a tile into parts that are valid in all kinds, and parts that are not.
    fn parts(&self, unit: usize, rect: Rect) -> Vec<DepthPart> {
        let tile = &self.depth.units[unit];
        let mut parts = vec![DepthPart { unit: unit as u32, is_known: tile.is_valid, rect }];
        for units in self.all_but_depth() {
            let under = |part: DepthPart| {
                let is_known = move |at: usize| part.is_known && units.units[at].is_valid;
                units.under(part.rect).map(move |(at, rect)| DepthPart { is_known: is_known(at), rect, ..part })
            };
            parts = parts.into_iter().flat_map(under).collect();
        }
        parts
    }

    /// Returns the depths that [`FaceCache::update`] writes, for a backend, as few parts that do not overlap.
    pub fn depth_parts(&self) -> Vec<DepthPart> {
        let mut stale: BTreeMap<usize, Vec<DepthPart>> = BTreeMap::new();
        for (tile, rect) in self.stale_depths() {
            stale.entry(tile).or_default().extend(self.parts(tile, rect));
        }
        // Units of two kinds that become valid or invalid together cover the same texels.
        if self.all_but_depth().count() > 1 {
            stale.values_mut().for_each(sort_and_dedup);
        }
        let mut all = Vec::new();
        for (tile, parts) in stale {
            for is_known in [false, true] {
                let alike = parts.iter().filter(|part| part.is_known == is_known).map(|part| part.rect);
                let rects = joined(alike.collect()).into_iter();
                all.extend(rects.map(|rect| DepthPart { unit: tile as u32, is_known, rect }));
            }
        }
        all
    }

    /// Returns the colour cells, or rectangles of them, that are new or have new alpha; they do not overlap.
    fn stale_colors(&self) -> Vec<(usize, Rect)> {
        let mut stale = Vec::new();
        for (at, cell) in self.color.units.iter().enumerate().filter(|(_, cell)| cell.is_valid) {
            let rect = self.color.rect(at);
            if cell.is_new() {
                stale.push((at, rect));
            } else if let Some(alpha) = &self.alpha {
                let new = alpha.under(rect).filter(|(unit, _)| alpha.units[*unit].is_new());
                stale.extend(new.map(|(_, rect)| (at, rect)));
            }
        }
        stale
    }

    fn update_color(&self, texels: &mut FaceTexels) -> Vec<Rect> {
        let stale = self.stale_colors();
        for &(cell, rect) in &stale {
            let cell = &self.color.units[cell];
            match &self.alpha {
                None => write_color(cell, texels),
                Some(alpha) => {
                    let units = alpha.under(rect).filter(|(unit, _)| alpha.units[*unit].is_valid);
                    units.for_each(|(unit, rect)| self.write_color_and_alpha([cell, &alpha.units[unit]], rect, texels));
                }
            }
        }
        stale.into_iter().map(|(_, rect)| rect).collect()
    }

    /// Writes the rectangle that a colour cell and an alpha unit have in common.
    fn write_color_and_alpha(&self, [color, alpha]: [&CachedUnit<'_>; 2], rect: Rect, texels: &mut FaceTexels) {
        let UnitPixels::Alpha(alphas) = alpha.decoder.pixels() else { return };
        let alphas = pixels_in(alphas, alpha.decoder.rect(), rect).map(alpha_byte);
        let [left, top, width, height] = rect.map(|length| length as usize);
        let rows = texels.size[0] as usize;
        let places = (top..top + height).flat_map(|row| row * rows + left..row * rows + left + width);
        let of = color.decoder.rect();
        match (color.decoder.pixels(), &mut texels.color, &self.straight) {
            (UnitPixels::Color8(pixels), ColorTexels::Codes(image), Some(straight)) => {
                for ((at, color), alpha) in places.zip(pixels_in(pixels, of, rect)).zip(alphas) {
                    image[at] = straight.texel(color, alpha);
                }
            }
            (UnitPixels::ColorHalf(pixels), ColorTexels::Light(image), _) => {
                for ((at, color), alpha) in places.zip(pixels_in(pixels, of, rect)).zip(alphas) {
                    let alpha = f32::from(alpha) / 255.0;
                    let [r, g, b] = color.map(|key| straight_half(light_of(key), alpha));
                    image[at] = [r, g, b, f16::from_f32(alpha)];
                }
            }
            _ => {}
        }
    }

    fn update_depth(&self, texels: &mut FaceTexels) -> Vec<Rect> {
        let stale = self.stale_depths().into_iter();
        stale.filter_map(|(tile, rect)| self.write_depth(tile, rect, texels)).collect()
    }

    fn write_depth(&self, tile: usize, rect: Rect, texels: &mut FaceTexels) -> Option<Rect> {
        let decoder = &self.depth.units[tile].decoder;
        let UnitPixels::Depth(codes) = decoder.pixels() else { return None };
        let [tile_left, tile_top, tile_width, _] = decoder.rect();
        let mut changed = None;
        for DepthPart { is_known, rect: [left, top, width, height], .. } in self.parts(tile, rect) {
            for row in top..top + height {
                let start = row as usize * texels.size[0] as usize + left as usize;
                let differ = if is_known {
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

fn sort_and_dedup(parts: &mut Vec<DepthPart>) {
    parts.sort_unstable();
    parts.dedup();
}

/// Sets texels to unknown. Returns the first and the last one that was known.
fn fill_unknown(texels: &mut [f32]) -> Option<[u32; 2]> {
    let known = |texel: &f32| *texel != UNKNOWN;
    let ends = [texels.iter().position(known)?, texels.iter().rposition(known)?];
    texels.fill(UNKNOWN);
    Some(ends.map(|end| end as u32))
}

/// Writes the rows of a unit into an image of `width` pixels.
fn write<T: Copy, U>(pixels: &[T], rect: Rect, image: &mut [U], width: u32, convert: impl Fn(T) -> U) {
    let [left, top, unit_width, _] = rect;
    for (row, pixels) in (top..).zip(pixels.chunks_exact(unit_width as usize)) {
        let start = row as usize * width as usize + left as usize;
        image[start..start + pixels.len()].iter_mut().zip(pixels).for_each(|(texel, &pixel)| *texel = convert(pixel));
    }
}

/// Converts a key to linear light, which is finite.
fn light_of(key: HalfKey) -> f16 {
    finite_half(key.to_half())
}

fn write_color(unit: &CachedUnit<'_>, texels: &mut FaceTexels) {
    let (rect, width) = (unit.decoder.rect(), texels.size[0]);
    match (unit.decoder.pixels(), &mut texels.color) {
        (UnitPixels::Color8(pixels), ColorTexels::Codes(image)) => {
            write(pixels, rect, image, width, |[r, g, b]| [r, g, b, 0]);
        }
        (UnitPixels::ColorHalf(pixels), ColorTexels::Light(image)) => {
            let light = |[r, g, b]: [HalfKey; 3]| [light_of(r), light_of(g), light_of(b), f16::ZERO];
            write(pixels, rect, image, width, light);
        }
        _ => {}
    }
}

/// Returns the pixels of a rectangle inside that of a unit, row by row.
fn pixels_in<T: Copy>(pixels: &[T], [left, top, unit_width, _]: Rect, rect: Rect) -> impl Iterator<Item = T> {
    let [from, first, width, height] = rect;
    (first..first + height).flat_map(move |row| {
        let start = ((row - top) * unit_width + from - left) as usize;
        pixels[start..start + width as usize].iter().copied()
    })
}

fn update_material(units: &StreamUnits<'_>, texels: &mut FaceTexels) -> Vec<Rect> {
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
    fn parts_of_many_small_cells_are_deduplicated() {
        // As many parts as cells of 4 pixels under a tile of 2048: comparing all pairs would take minutes.
        let cell = |at: u32| {
            let rect = [at % 512 * 4, at / 512 * 4, 4, 4];
            DepthPart { unit: 0, is_known: at.is_multiple_of(3), rect }
        };
        let mut parts: Vec<DepthPart> = (0..512 * 512).chain(0..512 * 512).map(cell).collect();
        sort_and_dedup(&mut parts);
        assert_eq!(parts.len(), 512 * 512);
        assert_eq!(parts.iter().filter(|part| part.is_known).count(), (512 * 512usize).div_ceil(3));
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
