//! OpenEXR files: reads selected channels as planes; writes planes as half or float ZIP files.
//!
//! A header may claim only as many pixels as its file could hold, which is checked before memory is allocated. Chunks of other
//! layers are neither read nor decompressed. Files are decoded on the calling thread; callers read several at once.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Cursor, Read, Seek, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{Chromaticities, LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    WritableImage,
};
use half::f16;

use super::channels::{
    ChannelName, ChannelSelect, find_alpha, find_alpha_channel, find_color, find_depth, find_named, find_picture_color,
};
use super::limits::ReadLimits;
use super::plane::{AlphaPlane, ColorPlane, DepthPlane, MaterialPlane, Plane};
use super::primaries::Primaries;
use crate::error::{Error, Result};
use crate::files::DiskFile;

/// Any file may claim this much; see [`ReadLimits`].
const PIXEL_FLOOR: u64 = 16 << 20;
/// A display window may be larger than its data (an autocropped render), so it may claim more.
const DISPLAY_FLOOR: u64 = 64 << 20;
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Longer attributes of a header are not passed over in search of its windows.
const MAX_ATTRIBUTE_BYTES: u64 = 16 << 20;
/// No side of an image or tile may be longer; keeps all products of sides and sample sizes inside 64 bits.
const MAX_SIDE: usize = 1 << 24;

/// Colour of a file, rounded to half floats to nearest, ties to even. A single luminance channel is read as gray.
pub fn read_color(path: &Path, select: &ChannelSelect, limits: &ReadLimits) -> Result<ColorPlane> {
    read_planes(path, limits, f16::ZERO, |names| find_color(names, select))
}

/// As [`read_color`], with the primaries of the file's `chromaticities`; those of Rec. 709 where it has none.
pub fn read_color_and_primaries(
    path: &Path,
    select: &ChannelSelect,
    limits: &ReadLimits,
) -> Result<(ColorPlane, Primaries)> {
    let (reader, file_len) = open(path)?;
    let primaries = stated_primaries(reader.headers()).map(|stated| stated.unwrap_or(Primaries::REC709));
    let plane = decode(reader, file_len, limits, f16::ZERO, |names| find_color(names, select));
    plane.and_then(|plane| Ok((plane, primaries?))).map_err(|error| named(error, path))
}

/// The primaries of a file's `chromaticities`; those of Rec. 709 where it has none.
pub fn read_primaries(path: &Path) -> Result<Primaries> {
    Ok(read_stated_primaries(path)?.unwrap_or(Primaries::REC709))
}

/// The primaries of a file's `chromaticities`, where it has any.
pub fn read_stated_primaries(path: &Path) -> Result<Option<Primaries>> {
    let (reader, _) = open(path)?;
    stated_primaries(reader.headers()).map_err(|error| named(error, path))
}

fn stated_primaries(headers: &[Header]) -> Result<Option<Primaries>> {
    let stated = headers.first().and_then(|header| header.shared_attributes.chromaticities);
    let Some(Chromaticities { red, green, blue, white }) = stated else { return Ok(None) };
    let values = [red, green, blue, white].map(|Vec2(x, y)| [x, y]);
    Primaries::from_array(std::array::from_fn(|at| values[at / 2][at % 2]))
        .map(Some)
        .map_err(|error| error.context("`color_space` takes their place"))
}

/// Colour as [`read_color`] finds it, with the alpha of its layer; alpha is 1 where the layer has none. Colour is multiplied by
/// alpha already, as the format has it.
pub fn read_rgba(path: &Path, limits: &ReadLimits) -> Result<Plane<[f16; 4]>> {
    let mut has_alpha = false;
    let mut plane = read_planes(path, limits, f16::ZERO, |names| {
        let [red, green, blue] = find_picture_color(names)?;
        let alpha = find_alpha(names, red);
        has_alpha = alpha.is_some();
        Ok([red, green, blue, alpha.unwrap_or(red)])
    })?;
    if !has_alpha {
        plane.data_mut().iter_mut().for_each(|pixel| pixel[3] = f16::ONE);
    }
    Ok(plane)
}

/// Alpha of a file: the channel of that name, else that of the layer of colour; 0 outside the data window.
pub fn read_alpha(
    path: &Path,
    select: &ChannelSelect,
    color: &ChannelSelect,
    limits: &ReadLimits,
) -> Result<AlphaPlane> {
    let plane = read_planes(path, limits, 0.0, |names| Ok([find_alpha_channel(names, select, color)?]))?;
    Plane::new(plane.width(), plane.height(), plane.into_data().into_flattened())
}

/// Depth of a file as it is stored, in whatever unit and kind the file has; `+inf` outside the data window. Of a layer that
/// holds depth three times, all three must be equal.
pub fn read_depth(path: &Path, select: &ChannelSelect, limits: &ReadLimits) -> Result<DepthPlane> {
    let (reader, file_len) = open(path)?;
    let found = find_depth(&channel_names(reader.headers()), select).map_err(|error| error.in_file(path))?;
    let Some([green, blue]) = found.copies else {
        let plane = decode(reader, file_len, limits, f32::INFINITY, |_| Ok([found.channel]));
        let plane = plane.map_err(|error| named(error, path))?;
        return Plane::new(plane.width(), plane.height(), plane.into_data().into_flattened());
    };
    let plane = decode(reader, file_len, limits, f32::INFINITY, |_| Ok([found.channel, green, blue]));
    let plane = plane.map_err(|error| named(error, path))?;
    if let Some(at) = plane.data().iter().position(|&[r, g, b]| (r != g || r != b) && !r.is_nan()) {
        let [x, y] = [at as u32 % plane.width(), at as u32 / plane.width()];
        let message = format!(
            "R, G and B of the layer of depth differ at pixel ({x}, {y}), so they are no depth: name a channel with \
             `depth_channel` or the manifest's depth.channel"
        );
        return Err(Error::invalid(message).in_file(path));
    }
    Ok(plane.map(|pixel| pixel[0]))
}

/// Reflection weight, refraction weight and index of refraction from the channels of the three `names`.
pub fn read_material(path: &Path, names: [&str; 3], limits: &ReadLimits) -> Result<MaterialPlane> {
    read_channels(path, names, limits)
}

/// The channels of these names, of which any may occur twice; 0 outside the data window.
pub fn read_channels<const N: usize>(path: &Path, names: [&str; N], limits: &ReadLimits) -> Result<Plane<[f32; N]>> {
    read_planes(path, limits, 0.0, |all| {
        let mut found = [0; N];
        for (index, name) in found.iter_mut().zip(names) {
            *index = find_named(all, name)?;
        }
        Ok(found)
    })
}

pub fn read_size(path: &Path, limits: &ReadLimits) -> Result<(u32, u32)> {
    let (reader, file_len) = open(path)?;
    guard(reader.headers(), 1, limits, file_len).map_err(|error| error.in_file(path))?;
    let window = reader.headers()[0].shared_attributes.display_window.size;
    Ok((window.width() as u32, window.height() as u32))
}

/// What the header of a file says of footage.
#[derive(Debug, Clone)]
pub struct FileHeader {
    pub size: (u32, u32),
    pub(crate) channels: Vec<ChannelName>,
    /// Frames per second, above 0.
    pub fps: Option<f64>,
    /// `worldToCamera`, row by row, for row vectors: the camera's x is right and y is up.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`, in the same way: the image is −1 to 1, or 0 to 1.
    pub world_to_ndc: Option<[f32; 16]>,
}

pub fn read_header(path: &Path, limits: &ReadLimits) -> Result<FileHeader> {
    let (reader, file_len) = open(path)?;
    let headers = reader.headers();
    guard(headers, 1, limits, file_len).map_err(|error| error.in_file(path))?;
    let window = headers[0].shared_attributes.display_window.size;
    let rate = headers.iter().find_map(|header| header.own_attributes.frames_per_second);
    Ok(FileHeader {
        size: (window.width() as u32, window.height() as u32),
        channels: channel_names(headers),
        fps: rate
            .map(|(frames, seconds)| f64::from(frames) / f64::from(seconds))
            .filter(|fps| *fps > 0.0 && fps.is_finite()),
        world_to_camera: headers.iter().find_map(|header| header.own_attributes.world_to_camera),
        world_to_ndc: headers.iter().find_map(|header| header.own_attributes.world_to_normalized_device),
    })
}

/// Bytes that reading a file takes beside the plane: its largest chunk, as it is stored, as it is decompressed, and as it is sorted
/// by channels.
pub(crate) fn chunk_bytes(path: &Path, limits: &ReadLimits) -> Result<u64> {
    let (reader, file_len) = open(path)?;
    guard(reader.headers(), 1, limits, file_len).map_err(|error| error.in_file(path))?;
    let of_header =
        |header: &Header| header.max_block_pixel_size().area() as u64 * header.channels.bytes_per_pixel as u64;
    Ok(3 * reader.headers().iter().map(of_header).max().unwrap_or(0))
}

trait Sample: Copy {
    fn from_half(value: f16) -> Self;
    fn from_float(value: f32) -> Self;
    fn from_uint(value: u32) -> Self;
}

impl Sample for f16 {
    fn from_half(value: f16) -> Self {
        value
    }
    fn from_float(value: f32) -> Self {
        f16::from_f32(value)
    }
    fn from_uint(value: u32) -> Self {
        // Through f64: rounding to f32 first would round twice.
        f16::from_f64(f64::from(value))
    }
}

impl Sample for f32 {
    fn from_half(value: f16) -> Self {
        value.to_f32()
    }
    fn from_float(value: f32) -> Self {
        value
    }
    fn from_uint(value: u32) -> Self {
        value as f32
    }
}

type Reader = exr::block::reader::Reader<BufReader<File>>;

fn open(path: &Path) -> Result<(Reader, u64)> {
    let file = crate::files::open_regular(path)?;
    let meta = file.metadata().map_err(|error| Error::io(path, error))?;
    let mut file = BufReader::with_capacity(1 << 16, file);
    let start = file.fill_buf().map_err(|error| Error::io(path, error))?;
    if start.is_empty() {
        return Err(Error::invalid("this file is empty, where an OpenEXR file was expected").in_file(path));
    }
    if !start.starts_with(&MAGIC) {
        return Err(Error::invalid("this is not an OpenEXR file").in_file(path));
    }
    if let Some((name, [left, top, right, bottom])) = inverted_window(&mut file) {
        let message = format!(
            "the {name} ({left}, {top})-({right}, {bottom}) is inverted: its first corner lies beyond its second"
        );
        return Err(Error::invalid(message).in_file(path));
    }
    file.rewind().map_err(|error| Error::io(path, error))?;
    let reader = exr::block::read(file, false).map_err(|error| translate(error).in_file(path))?;
    Ok((reader, meta.len()))
}

/// The first window of the headers whose corners are exchanged, which the `exr` crate would exchange back; None also where the
/// headers cannot be followed, which that crate reports.
fn inverted_window(file: &mut impl BufRead) -> Option<(&'static str, [i32; 4])> {
    let mut start = [0; 8];
    file.read_exact(&mut start).ok()?;
    let is_multipart = start[5] & 0x10 != 0;
    loop {
        let mut is_empty = true;
        loop {
            let name = text(file)?;
            if name.is_empty() {
                break;
            }
            is_empty = false;
            let kind = text(file)?;
            let mut length = [0; 4];
            file.read_exact(&mut length).ok()?;
            let length = u64::from(u32::from_le_bytes(length));
            let window = ["dataWindow", "displayWindow"].into_iter().find(|window| window.as_bytes() == name);
            match window.filter(|_| kind == b"box2i" && length == 16) {
                Some(window) => {
                    let mut corners = [[0; 4]; 4];
                    file.read_exact(corners.as_flattened_mut()).ok()?;
                    let corners = corners.map(i32::from_le_bytes);
                    if corners[0] > corners[2] || corners[1] > corners[3] {
                        return Some((window, corners));
                    }
                }
                None if length <= MAX_ATTRIBUTE_BYTES => {
                    std::io::copy(&mut file.take(length), &mut std::io::sink()).ok()?;
                }
                None => return None,
            }
        }
        if !is_multipart || is_empty {
            return None;
        }
    }
}

/// A text of a header up to its final 0, without it.
fn text(file: &mut impl BufRead) -> Option<Vec<u8>> {
    let mut text = Vec::new();
    file.take(256).read_until(0, &mut text).ok()?;
    (text.pop() == Some(0)).then_some(text)
}

fn translate(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::NotSupported(what) => Error::unsupported(format!("the EXR file cannot be read: {what}")),
        exr::error::Error::Invalid(what) => Error::invalid(format!("the EXR file is damaged: {what}")),
        exr::error::Error::Io(source) => Error::io("", source),
        exr::error::Error::Aborted => Error::Interrupted,
    }
}

fn guard(headers: &[Header], wanted_bytes: u64, limits: &ReadLimits, file_len: u64) -> Result<()> {
    let refuse = |bytes: u64| {
        Error::invalid(format!(
            "the header claims {bytes} bytes of pixels, more than a file of {file_len} bytes may ({} bytes)",
            limits.believable(file_len, PIXEL_FLOOR)
        ))
    };
    let mut total = 0u64;
    for header in headers {
        if header.deep {
            return Err(Error::unsupported("deep EXR images are not read: flatten the image first"));
        }
        let tile = header.max_block_pixel_size();
        let display = header.shared_attributes.display_window.size;
        for Vec2(width, height) in [header.layer_size, tile, display] {
            if width > MAX_SIDE || height > MAX_SIDE {
                let message = format!("the header claims a window or tile of {width}x{height} pixels");
                return Err(Error::invalid(message));
            }
        }
        if header.layer_size.area() == 0 || display.area() == 0 || tile.area() == 0 {
            return Err(Error::invalid("the header has an empty window or tile"));
        }
        // Mip maps take at most a third more, rip maps four times as much.
        let levels = match header.blocks {
            BlockDescription::Tiles(tiles) if tiles.level_mode != LevelMode::Singular => 4,
            _ => 1,
        };
        let pixel_bytes = header.channels.bytes_per_pixel as u64;
        let pixels = header.layer_size.area() as u64;
        total = total.saturating_add(pixels.saturating_mul(pixel_bytes).saturating_mul(levels));
    }
    if total > limits.believable(file_len, PIXEL_FLOOR) {
        return Err(refuse(total));
    }
    let display = headers.first().map_or(0, |header| header.shared_attributes.display_window.size.area() as u64);
    let bytes = display.saturating_mul(wanted_bytes);
    if bytes > limits.believable(file_len, DISPLAY_FLOOR) {
        return Err(refuse(bytes));
    }
    Ok(())
}

/// Names of the channels of all parts, in order.
pub(crate) fn channel_names(headers: &[Header]) -> Vec<ChannelName> {
    let mut names = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let own = &header.own_attributes;
        let layer = own.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        let views: Vec<String> = own.multi_view_names.iter().flatten().map(ToString::to_string).collect();
        for channel in &header.channels.list {
            let name = channel.name.to_string();
            // Channels of the first of several views are called as if there was one.
            let named = views.iter().find(|view| name.rsplit('.').skip(1).any(|part| part == view.as_str()));
            let view = own.view_name.as_ref().map(ToString::to_string).or(named.or(views.first()).cloned());
            names.push(ChannelName { layer: layer.clone(), part, view: view.unwrap_or_default(), name });
        }
    }
    names
}

struct Wanted {
    part: usize,
    sample_type: SampleType,
    /// Bytes of all channels before this one, for one pixel.
    bytes_before: usize,
    slot: usize,
}

fn read_planes<T: Sample, const N: usize>(
    path: &Path,
    limits: &ReadLimits,
    fill: T,
    choose: impl FnOnce(&[ChannelName]) -> Result<[usize; N]>,
) -> Result<Plane<[T; N]>> {
    let (reader, file_len) = open(path)?;
    decode(reader, file_len, limits, fill, choose).map_err(|error| named(error, path))
}

fn named(error: Error, path: &Path) -> Error {
    match error {
        Error::Io { source, .. } => Error::io(path, source),
        other => other.in_file(path),
    }
}

fn decode<T: Sample, const N: usize>(
    reader: Reader,
    file_len: u64,
    limits: &ReadLimits,
    fill: T,
    choose: impl FnOnce(&[ChannelName]) -> Result<[usize; N]>,
) -> Result<Plane<[T; N]>> {
    guard(reader.headers(), size_of::<[T; N]>() as u64, limits, file_len)?;
    let wanted = select(reader.headers(), choose)?;
    let display = reader.headers()[0].shared_attributes.display_window;
    let (width, height) = (display.size.width() as u32, display.size.height() as u32);

    let is_wanted = |part: usize| wanted.iter().any(|channel| channel.part == part);
    let chunks = reader
        .filter_chunks(false, |_, _, block| block.level == Vec2(0, 0) && is_wanted(block.layer))
        .map_err(translate)?;
    let headers = chunks.meta_data().headers.clone();

    let mut plane = Plane::filled(width, height, [fill; N]);
    let mut seen = Vec::with_capacity(chunks.len());
    let mut blocks = chunks.sequential_decompressor(false);
    // Damaged B44 data makes that crate subtract past zero, which panics where overflow is checked (debug builds).
    // After such a panic the iterator is dropped, so nothing half-done is seen again.
    while let Some(block) = catch_unwind(AssertUnwindSafe(|| blocks.next()))
        .map_err(|_| Error::invalid("the EXR file is damaged: a chunk of pixels cannot be decompressed"))?
    {
        let block = block.map_err(translate)?;
        let index = block.index;
        // A damaged offset table may lead to a chunk that was not asked for, or to the same chunk twice.
        let header = headers
            .get(index.layer)
            .filter(|_| is_wanted(index.layer) && index.level == Vec2(0, 0))
            .ok_or_else(|| Error::invalid("the EXR file is damaged: a chunk belongs to another layer"))?;
        seen.push((index.layer, index.pixel_position.0, index.pixel_position.1));
        let (own, shown) = (header.own_attributes.layer_position, display.position);
        let origin = [i64::from(own.x()) - i64::from(shown.x()), i64::from(own.y()) - i64::from(shown.y())];
        for channel in wanted.iter().filter(|channel| channel.part == index.layer) {
            paste(&block, header, channel, origin, &mut plane)?;
        }
    }
    let count = seen.len();
    seen.sort_unstable();
    seen.dedup();
    if seen.len() != count {
        return Err(Error::invalid("the EXR file is damaged: a chunk occurs twice"));
    }
    Ok(plane)
}

fn select<const N: usize>(
    headers: &[Header],
    choose: impl FnOnce(&[ChannelName]) -> Result<[usize; N]>,
) -> Result<Vec<Wanted>> {
    let names = channel_names(headers);
    let mut places = Vec::with_capacity(names.len());
    for (part, header) in headers.iter().enumerate() {
        let mut bytes_before = 0;
        for channel in &header.channels.list {
            places.push((part, channel.sample_type, bytes_before));
            bytes_before += channel.sample_type.bytes_per_sample();
        }
    }
    let chosen = choose(&names)?;
    let mut wanted = Vec::with_capacity(N);
    for (slot, index) in chosen.into_iter().enumerate() {
        let (part, sample_type, bytes_before) = places[index];
        // One subsampled channel shifts the bytes of all channels of its layer.
        if headers[part].channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(Error::unsupported("EXR layers with subsampled channels are not read: save all at full size"));
        }
        wanted.push(Wanted { part, sample_type, bytes_before, slot });
    }
    Ok(wanted)
}

/// Copies what a block has of one channel into the plane, leaving out what lies outside.
/// `origin` is the corner of the data window, seen from the corner of the display window.
fn paste<T: Sample, const N: usize>(
    block: &UncompressedBlock,
    header: &Header,
    channel: &Wanted,
    origin: [i64; 2],
    plane: &mut Plane<[T; N]>,
) -> Result<()> {
    let Vec2(columns, rows) = block.index.pixel_size;
    let line_bytes = columns * header.channels.bytes_per_pixel;
    let sample_bytes = channel.sample_type.bytes_per_sample();
    if block.data.len() != line_bytes * rows {
        return Err(Error::invalid("the EXR file is damaged: a chunk has the wrong size"));
    }
    let left = origin[0] + block.index.pixel_position.x() as i64;
    let top = origin[1] + block.index.pixel_position.y() as i64;
    let skip = left.min(0).unsigned_abs() as usize;
    let start = left.max(0) as usize;
    let end = (left + columns as i64).min(i64::from(plane.width()));
    if end <= start as i64 {
        return Ok(());
    }
    let count = end as usize - start;
    for row in 0..rows {
        let y = top + row as i64;
        if y < 0 || y >= i64::from(plane.height()) {
            continue;
        }
        let line = &block.data[row * line_bytes + columns * channel.bytes_before..][..columns * sample_bytes];
        let target = &mut plane.row_mut(y as u32)[start..start + count];
        convert(&line[skip * sample_bytes..], channel, target);
    }
    Ok(())
}

/// Converts samples, native-endian as the `exr` crate hands them over, into one component of the pixels.
fn convert<T: Sample, const N: usize>(bytes: &[u8], channel: &Wanted, target: &mut [[T; N]]) {
    match channel.sample_type {
        SampleType::F16 => fill(bytes, channel.slot, target, |sample| T::from_half(f16::from_ne_bytes(sample))),
        SampleType::F32 => fill(bytes, channel.slot, target, |sample| T::from_float(f32::from_ne_bytes(sample))),
        SampleType::U32 => fill(bytes, channel.slot, target, |sample| T::from_uint(u32::from_ne_bytes(sample))),
    }
}

fn fill<T, const N: usize, const B: usize>(
    bytes: &[u8],
    slot: usize,
    target: &mut [[T; N]],
    convert: impl Fn([u8; B]) -> T,
) {
    for (pixel, &sample) in target.iter_mut().zip(bytes.as_chunks().0) {
        pixel[slot] = convert(sample);
    }
}

/// Writes channels R, G, B as halves, ZIP compressed. The bytes depend on the pixels alone.
pub fn write_color(path: &Path, plane: &ColorPlane) -> Result<()> {
    write_color_of(path, plane, Primaries::REC709)
}

/// As [`write_color`], with `chromaticities` unless they are those of Rec. 709, which files without that attribute have.
pub fn write_color_of(path: &Path, plane: &ColorPlane, primaries: Primaries) -> Result<()> {
    write(path, plane, (halves(plane, ["R", "G", "B"], |value| value), primaries))
}

/// Writes channels R, G, B and A as halves, ZIP compressed; colour is multiplied by alpha already, as the format has it.
pub fn write_rgba(path: &Path, plane: &Plane<[f16; 4]>) -> Result<()> {
    write_rgba_and(path, plane, std::iter::empty(), Primaries::REC709)
}

/// As [`write_rgba`], with more channels of the same size as floats, and `chromaticities` as [`write_color_of`].
pub fn write_rgba_and<'a>(
    path: &Path,
    plane: &Plane<[f16; 4]>,
    others: impl IntoIterator<Item = (&'a str, &'a Plane<f32>)>,
    primaries: Primaries,
) -> Result<()> {
    let mut channels = halves(plane, ["R", "G", "B", "A"], |value| value);
    channels.extend(others.into_iter().map(|(name, other)| (name, FlatSamples::F32(other.data().to_vec()))));
    write(path, plane, (channels, primaries))
}

/// Writes channel A as halves, ZIP compressed.
pub fn write_alpha(path: &Path, plane: &Plane<f16>) -> Result<()> {
    write(path, plane, (vec![("A", FlatSamples::F16(plane.data().to_vec()))], Primaries::REC709))
}

/// Writes channel Z as 32-bit floats, ZIP compressed.
pub fn write_depth(path: &Path, plane: &DepthPlane) -> Result<()> {
    write(path, plane, (vec![("Z", FlatSamples::F32(plane.data().to_vec()))], Primaries::REC709))
}

/// Writes three channels of the given names as halves (rounded to nearest), ZIP compressed.
pub fn write_material(path: &Path, plane: &MaterialPlane, names: [&str; 3]) -> Result<()> {
    let [a, b, c] = names;
    if a == b || a == c || b == c || names.contains(&"") {
        return Err(Error::Usage(format!("material channels need three different names, not {}", names.join(", "))));
    }
    write(path, plane, (halves(plane, names, f16::from_f32), Primaries::REC709))
}

/// Bytes of a file of channels R, G, B and A as halves, ZIP compressed, with `chromaticities` as [`write_color_of`].
pub fn rgba_bytes(plane: &Plane<[f16; 4]>, primaries: Primaries) -> Result<Vec<u8>> {
    file_bytes(plane, (halves(plane, ["R", "G", "B", "A"], |value| value), primaries))
}

/// As [`rgba_bytes`], of three channels, rounded to nearest.
pub fn triple_bytes(plane: &Plane<[f32; 3]>, names: [&str; 3]) -> Result<Vec<u8>> {
    file_bytes(plane, (halves(plane, names, f16::from_f32), Primaries::REC709))
}

/// Channels by name, and the primaries of their colours.
type Channels<'a> = (Vec<(&'a str, FlatSamples)>, Primaries);

fn file_bytes<T>(plane: &Plane<T>, channels: Channels<'_>) -> Result<Vec<u8>> {
    let mut file = Cursor::new(Vec::new());
    encode(&mut file, plane, channels).map_err(|error| match error {
        exr::error::Error::Io(source) => Error::io("the EXR file", source),
        other => translate(other),
    })?;
    Ok(file.into_inner())
}

fn halves<'a, T: Copy, const N: usize>(
    plane: &Plane<[T; N]>,
    names: [&'a str; N],
    half: fn(T) -> f16,
) -> Vec<(&'a str, FlatSamples)> {
    let samples = |at: usize| FlatSamples::F16(plane.data().iter().map(|pixel| half(pixel[at])).collect());
    names.into_iter().enumerate().map(|(at, name)| (name, samples(at))).collect()
}

fn write<T>(path: &Path, plane: &Plane<T>, channels: Channels<'_>) -> Result<()> {
    if [plane.width(), plane.height()].contains(&0) {
        return Err(Error::invalid("an image without pixels cannot be written").in_file(path));
    }
    let file = DiskFile::create(path).map_err(|error| Error::io(path, error))?;
    let mut writer = BufWriter::new(file);
    encode(&mut writer, plane, channels).map_err(|error| match error {
        exr::error::Error::Io(source) => Error::io(path, source),
        other => translate(other).in_file(path),
    })?;
    writer.flush().map_err(|error| Error::io(path, error))
}

fn encode<T>(
    writer: &mut (impl Write + Seek),
    plane: &Plane<T>,
    (channels, primaries): Channels<'_>,
) -> exr::error::UnitResult {
    let size = (plane.width() as usize, plane.height() as usize);
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let (blocks, line_order) = (exr::image::Blocks::ScanLines, LineOrder::Increasing);
    let encoding = Encoding { compression: Compression::ZIP16, blocks, line_order };
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list));
    let mut image = Image::from_layer(layer);
    if !primaries.is_rec709() {
        let [red, green, blue, white] =
            [primaries.red, primaries.green, primaries.blue, primaries.white].map(|[x, y]| Vec2(x, y));
        image.attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
    }
    image.write().non_parallel().to_buffered(writer)
}
