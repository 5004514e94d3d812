//! OpenEXR files: reads selected channels as planes; writes planes as ZIP compressed files of half or float channels.
//!
//! Every size that a file states is checked before it is used: a header may claim only as many pixels as the file could hold
//! (`guard`), and a chunk only as many bytes as its pixels take (`chunks`, `payload`). Chunks of unused parts are neither read
//! nor decompressed. A file is decoded on the calling thread; callers read several files in parallel.

use std::path::Path;

use exr::block::UncompressedBlock;
use exr::math::Vec2;
use exr::meta::attribute::{Chromaticities, SampleType};
use exr::meta::header::Header;
use half::f16;

use codec::error::{Error, Result};
use codec::image::ReadLimits;
use codec::image::channels::{
    ChannelName, ChannelSelect, find_alpha, find_alpha_channel, find_color, find_depth, find_named, find_picture_color,
};
use codec::image::plane::{AlphaPlane, ColorPlane, DepthPlane, MaterialPlane, Plane};
use codec::image::primaries::Primaries;

mod chunks;
mod errors;
mod guard;
mod payload;
mod work;
mod write;

pub use chunks::reading_bytes;
use guard::{Opened, open};
pub use write::{
    rgba_bytes, triple_bytes, write_alpha, write_color, write_color_of, write_depth, write_material, write_rgba,
    write_rgba_and,
};

/// Reads colour, rounded to half floats (nearest, ties to even). A single luminance channel is read as gray.
pub fn read_color(path: &Path, select: &ChannelSelect, limits: &ReadLimits) -> Result<ColorPlane> {
    read_planes(path, limits, f16::ZERO, |names| find_color(names, select))
}

/// Reads colour as [`read_color`] does, and the primaries of the `chromaticities` attribute; Rec. 709 if the file has none.
pub fn read_color_and_primaries(
    path: &Path,
    select: &ChannelSelect,
    limits: &ReadLimits,
) -> Result<(ColorPlane, Primaries)> {
    let opened = open(path)?;
    let primaries = stated_primaries(opened.headers()).map(|stated| stated.unwrap_or(Primaries::REC709));
    let plane = decode(opened, limits, f16::ZERO, |names| find_color(names, select));
    plane.and_then(|plane| Ok((plane, primaries?))).map_err(|error| named(error, path))
}

/// Reads the primaries of the `chromaticities` attribute; Rec. 709 if the file has none.
pub fn read_primaries(path: &Path) -> Result<Primaries> {
    Ok(read_stated_primaries(path)?.unwrap_or(Primaries::REC709))
}

/// Reads the primaries of the `chromaticities` attribute; `None` if the file has none.
pub fn read_stated_primaries(path: &Path) -> Result<Option<Primaries>> {
    let opened = open(path)?;
    stated_primaries(opened.headers()).map_err(|error| named(error, path))
}

fn stated_primaries(headers: &[Header]) -> Result<Option<Primaries>> {
    let stated = headers.first().and_then(|header| header.shared_attributes.chromaticities);
    let Some(Chromaticities { red, green, blue, white }) = stated else { return Ok(None) };
    let values = [red, green, blue, white].map(|Vec2(x, y)| [x, y]);
    Primaries::from_array(std::array::from_fn(|at| values[at / 2][at % 2]))
        .map(Some)
        .map_err(|error| error.context("`color_space` takes their place"))
}

/// Reads colour as [`read_color`] does with [`ChannelSelect::Auto`], and the alpha of its layer; alpha is 1 if the layer has
/// none. Colour is premultiplied by alpha, as OpenEXR defines it.
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

/// Reads alpha: the channel that `select` names, or the alpha channel of the layer of colour; 0 outside the data window.
pub fn read_alpha(
    path: &Path,
    select: &ChannelSelect,
    color: &ChannelSelect,
    limits: &ReadLimits,
) -> Result<AlphaPlane> {
    let plane = read_planes(path, limits, 0.0, |names| Ok([find_alpha_channel(names, select, color)?]))?;
    Plane::new(plane.width(), plane.height(), plane.into_data().into_flattened())
}

/// Reads depth unchanged, in the unit and kind of the file; `+inf` outside the data window. Fails if a layer holds depth as R, G
/// and B and the three differ.
pub fn read_depth(path: &Path, select: &ChannelSelect, limits: &ReadLimits) -> Result<DepthPlane> {
    let opened = open(path)?;
    let found = find_depth(&channel_names(opened.headers()), select).map_err(|error| error.in_file(path))?;
    let Some([green, blue]) = found.copies else {
        let plane = decode(opened, limits, f32::INFINITY, |_| Ok([found.channel]));
        let plane = plane.map_err(|error| named(error, path))?;
        return Plane::new(plane.width(), plane.height(), plane.into_data().into_flattened());
    };
    let plane = decode(opened, limits, f32::INFINITY, |_| Ok([found.channel, green, blue]));
    let plane = plane.map_err(|error| named(error, path))?;
    if let Some(at) = plane.data().iter().position(|&[r, g, b]| (r != g || r != b) && !r.is_nan()) {
        let [x, y] = [at as u32 % plane.width(), at as u32 / plane.width()];
        let message = format!(
            "R, G and B of the depth layer differ at pixel ({x}, {y}), so they are not depth: select a channel with \
            `depth_channel` or the manifest's depth.channel"
        );
        return Err(Error::invalid(message).in_file(path));
    }
    Ok(plane.map(|pixel| pixel[0]))
}

/// Reads reflection weight, refraction weight and index of refraction from the channels called `names`.
pub fn read_material(path: &Path, names: [&str; 3], limits: &ReadLimits) -> Result<MaterialPlane> {
    read_channels(path, names, limits)
}

/// Reads the channels called `names`, in which a name may occur twice; 0 outside the data window.
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
    let opened = open(path)?;
    guard::check(&opened, 1, limits).map_err(|error| error.in_file(path))?;
    let window = opened.headers()[0].shared_attributes.display_window.size;
    Ok((window.width() as u32, window.height() as u32))
}

/// Properties that the header of a file states.
#[derive(Debug, Clone)]
pub struct FileHeader {
    pub size: (u32, u32),
    pub(crate) channels: Vec<ChannelName>,
    /// Frames per second, above 0.
    pub fps: Option<f64>,
    /// Width of a pixel over its height, if the file states another than 1.
    pub pixel_aspect: Option<f64>,
    /// `worldToCamera`, row-major, for row vectors; the camera's x axis points right and y up.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`, row-major, for row vectors; it maps the image to −1 to 1, or to 0 to 1.
    pub world_to_ndc: Option<[f32; 16]>,
}

pub fn read_header(path: &Path, limits: &ReadLimits) -> Result<FileHeader> {
    let opened = open(path)?;
    let headers = opened.headers();
    guard::check(&opened, 1, limits).map_err(|error| error.in_file(path))?;
    let shared = &headers[0].shared_attributes;
    let (window, aspect) = (shared.display_window.size, f64::from(shared.pixel_aspect));
    let rate = headers.iter().find_map(|header| header.own_attributes.frames_per_second);
    Ok(FileHeader {
        size: (window.width() as u32, window.height() as u32),
        channels: channel_names(headers),
        fps: rate
            .map(|(frames, seconds)| f64::from(frames) / f64::from(seconds))
            .filter(|fps| *fps > 0.0 && fps.is_finite()),
        pixel_aspect: Some(aspect).filter(|aspect| (aspect - 1.0).abs() > 1e-3 && *aspect > 0.0 && aspect.is_finite()),
        world_to_camera: headers.iter().find_map(|header| header.own_attributes.world_to_camera),
        world_to_ndc: headers.iter().find_map(|header| header.own_attributes.world_to_normalized_device),
    })
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
        // Converted through f64: a conversion to f32 first would round twice.
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

/// Returns the names of the channels of all parts, in file order.
pub(crate) fn channel_names(headers: &[Header]) -> Vec<ChannelName> {
    let mut names = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let own = &header.own_attributes;
        let layer = own.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        let views: Vec<String> = own.multi_view_names.iter().flatten().map(ToString::to_string).collect();
        for channel in &header.channels.list {
            let name = channel.name.to_string();
            // Channels of the first of several views have no view in their name.
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
    /// Bytes per pixel of all channels before this one.
    bytes_before: usize,
    slot: usize,
}

fn read_planes<T: Sample, const N: usize>(
    path: &Path,
    limits: &ReadLimits,
    fill: T,
    choose: impl FnOnce(&[ChannelName]) -> Result<[usize; N]>,
) -> Result<Plane<[T; N]>> {
    let opened = open(path)?;
    decode(opened, limits, fill, choose).map_err(|error| named(error, path))
}

fn named(error: Error, path: &Path) -> Error {
    match error {
        Error::Io { source, .. } => Error::io(path, source),
        other => other.in_file(path),
    }
}

fn decode<T: Sample, const N: usize>(
    mut opened: Opened,
    limits: &ReadLimits,
    fill: T,
    choose: impl FnOnce(&[ChannelName]) -> Result<[usize; N]>,
) -> Result<Plane<[T; N]>> {
    guard::check(&opened, size_of::<[T; N]>() as u64, limits)?;
    let wanted = select(opened.headers(), choose)?;
    let display = opened.headers()[0].shared_attributes.display_window;
    let (width, height) = (display.size.width() as u32, display.size.height() as u32);

    let is_wanted = |part: usize| wanted.iter().any(|channel| channel.part == part);
    let places = chunks::places(&mut opened, is_wanted)?;

    let mut plane = Plane::filled(width, height, [fill; N]);
    let mut seen = Vec::with_capacity(places.len());
    for place in places {
        let block = chunks::read(&mut opened, place, is_wanted)?;
        let index = block.index;
        let header = &opened.headers()[index.layer];
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
        // A subsampled channel shifts the bytes of all channels of its layer.
        if headers[part].channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(Error::unsupported(
                "EXR layers with subsampled channels are not supported: save all channels at full resolution",
            ));
        }
        wanted.push(Wanted { part, sample_type, bytes_before, slot });
    }
    Ok(wanted)
}

/// Copies the samples of one channel of a block into the plane, clipped to the plane. `origin` is the upper left corner of the
/// data window relative to that of the display window.
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

/// Converts samples, in native byte order as the `exr` crate returns them, to one component of the pixels.
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
