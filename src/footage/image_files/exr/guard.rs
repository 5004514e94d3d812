//! Limits of the sizes that the header of an OpenEXR file may claim.
//!
//! [`open`] checks the windows, names and channels of all parts before the `exr` crate computes with them. [`check`] compares the
//! pixels that a header claims with the length of the file before memory is allocated for them.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use exr::math::Vec2;
use exr::meta::attribute::LevelMode;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::errors::{translate, way_out};
use super::work::Work;
use codec::error::{Error, Result};
use codec::image::ReadLimits;

/// Bytes of decoded pixels that are allowed for a file of any size; see [`ReadLimits`].
const PIXEL_FLOOR: u64 = 16 << 20;
/// Bytes of the display window that are allowed for a file of any size. It is larger than [`PIXEL_FLOOR`], since the display
/// window may exceed the stored pixels (an autocropped render).
const DISPLAY_FLOOR: u64 = 64 << 20;
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Maximum side of an image or tile in pixels; products of sides and sample sizes then fit 64 bits.
const MAX_SIDE: usize = 1 << 24;
/// Maximum number of channels of all parts. The crate and `channels` compare channels with each other.
const MAX_CHANNELS: usize = 4096;
/// Maximum number of names in `multiView`; every channel is compared with each of them.
const MAX_VIEWS: usize = 256;
/// Maximum length in bytes of the name of a part or view. The name is copied for every channel.
const MAX_NAME_BYTES: usize = 1024;
/// Bytes of memory per byte of a header: parsed parts, channels and attributes, and copies of names.
pub(super) const HEADER_SHARE: u64 = 64;
/// Bytes of memory per entry of an offset table: the entry, and the position of the chunk.
pub(super) const CHUNK_ENTRY_BYTES: u64 = 64;

/// An open file whose headers have been read; the file position is at the offset tables.
pub(super) struct Opened {
    pub file: BufReader<File>,
    pub meta: MetaData,
    pub file_len: u64,
    /// File offset of the first offset table.
    pub tables_at: u64,
    pub work: Work,
}

impl Opened {
    pub fn headers(&self) -> &[Header] {
        &self.meta.headers
    }
}

pub(super) fn open(path: &Path) -> Result<Opened> {
    let file = crate::files::open_regular(path)?;
    let file_len = file.metadata().map_err(|error| Error::io(path, error))?.len();
    let mut file = BufReader::with_capacity(1 << 16, file);
    let start = file.fill_buf().map_err(|error| Error::io(path, error))?;
    if start.is_empty() {
        return Err(Error::invalid("this file is empty, where an OpenEXR file was expected").in_file(path));
    }
    if !start.starts_with(&MAGIC) {
        return Err(Error::invalid("this is not an OpenEXR file").in_file(path));
    }
    if let Some((name, corners)) = wrong_window(&mut file) {
        return Err(refused_window(name, corners).in_file(path));
    }
    file.rewind().map_err(|error| Error::io(path, error))?;
    let meta = MetaData::read_from_buffered(&mut file, true).map_err(|error| translate(error).in_file(path))?;
    MetaData::validate(&meta.headers, false).map_err(|error| translate(error).in_file(path))?;
    let tables_at = file.stream_position().map_err(|error| Error::io(path, error))?;
    let mut opened = Opened { file, meta, file_len, tables_at, work: Work::default() };
    check_lists(&opened).map_err(|error| error.in_file(path))?;
    opened.work = Work::new(&opened.meta.headers);
    Ok(opened)
}

fn refused_window(name: &str, [left, top, right, bottom]: [i32; 4]) -> Error {
    if left > right || top > bottom {
        return Error::invalid(format!(
            "the {name} ({left}, {top})-({right}, {bottom}) is inverted: its first corner lies beyond its second"
        ));
    }
    let side = |first: i32, last: i32| i64::from(last) - i64::from(first) + 1;
    refused_size(name, side(left, right), side(top, bottom))
}

fn refused_size(name: &str, width: i64, height: i64) -> Error {
    Error::invalid(format!(
        "the header states a {name} of {width}x{height} pixels, but at most {MAX_SIDE} a side are supported"
    ))
}

/// Returns the first window in the headers whose corners are swapped, which the `exr` crate would silently swap back, or which is
/// too large for the crate's arithmetic. Returns `None` also if the headers cannot be parsed; the crate reports that error.
fn wrong_window(file: &mut impl BufRead) -> Option<(&'static str, [i32; 4])> {
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
            // The crate reads the first 16 bytes of a window, whatever the length of the attribute.
            match window.filter(|_| kind == b"box2i" && length >= 16) {
                Some(window) => {
                    let mut corners = [[0; 4]; 4];
                    file.read_exact(corners.as_flattened_mut()).ok()?;
                    let corners = corners.map(i32::from_le_bytes);
                    let [left, top, right, bottom] = corners.map(i64::from);
                    let sides = [right - left, bottom - top];
                    if sides.iter().any(|side| !(0..MAX_SIDE as i64).contains(side)) {
                        return Some((window, corners));
                    }
                    std::io::copy(&mut file.take(length - 16), &mut std::io::sink()).ok()?;
                }
                None => {
                    std::io::copy(&mut file.take(length), &mut std::io::sink()).ok()?;
                }
            }
        }
        if !is_multipart || is_empty {
            return None;
        }
    }
}

/// Reads a NUL-terminated string of a header, without the NUL.
fn text(file: &mut impl BufRead) -> Option<Vec<u8>> {
    let mut text = Vec::new();
    file.take(260).read_until(0, &mut text).ok()?;
    (text.pop() == Some(0)).then_some(text)
}

/// Checks the lengths of lists and names, the sides of windows and tiles, and the size of the offset tables.
fn check_lists(opened: &Opened) -> Result<()> {
    let mut table_bytes = 0u64;
    let channels: usize = opened.headers().iter().map(|header| header.channels.list.len()).sum();
    if channels > MAX_CHANNELS {
        return Err(Error::invalid(format!(
            "the EXR file has {channels} channels, but at most {MAX_CHANNELS} are supported"
        )));
    }
    for header in opened.headers() {
        let own = &header.own_attributes;
        let tile = header.max_block_pixel_size();
        let display = header.shared_attributes.display_window.size;
        for (name, Vec2(width, height)) in [("window", header.layer_size), ("tile", tile), ("window", display)] {
            if width > MAX_SIDE || height > MAX_SIDE {
                return Err(refused_size(name, width as i64, height as i64));
            }
        }
        let views = own.multi_view_names.as_deref().unwrap_or_default();
        if views.len() > MAX_VIEWS {
            let message = format!("the EXR file has {} views, but at most {MAX_VIEWS} are supported", views.len());
            return Err(Error::invalid(message));
        }
        let names = views.iter().chain(&own.layer_name).chain(&own.view_name);
        if let Some(length) = names.map(|name| name.bytes().len()).find(|length| *length > MAX_NAME_BYTES) {
            return Err(Error::invalid(format!(
                "the name of a part or view of the EXR file has {length} bytes, but at most {MAX_NAME_BYTES} are \
                supported"
            )));
        }
        table_bytes = table_bytes.saturating_add((header.chunk_count as u64).saturating_mul(8));
    }
    let left = opened.file_len.saturating_sub(opened.tables_at);
    if table_bytes > left {
        return Err(Error::invalid(format!(
            "the EXR file is damaged: its windows and tiles call for offset tables of {table_bytes} bytes, and {left} bytes \
             follow the header"
        )));
    }
    Ok(())
}

/// Rejects headers that claim more pixels than the file could hold. `wanted_bytes` is the size of a pixel of the result.
pub(super) fn check(opened: &Opened, wanted_bytes: u64, limits: &ReadLimits) -> Result<()> {
    let file_len = opened.file_len;
    let refuse = |bytes: u64| {
        Error::invalid(format!(
            "the header claims {bytes} bytes of pixels, more than a file of {file_len} bytes may ({} bytes)",
            limits.believable(file_len, PIXEL_FLOOR)
        ))
    };
    let mut total = 0u64;
    for header in opened.headers() {
        if header.deep {
            return Err(Error::unsupported(format!("deep EXR images are not supported{}", way_out("deep"))));
        }
        let tile = header.max_block_pixel_size();
        let display = header.shared_attributes.display_window.size;
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
    let bytes = display_pixels(opened).saturating_mul(wanted_bytes);
    if bytes > limits.believable(file_len, DISPLAY_FLOOR) {
        return Err(refuse(bytes));
    }
    Ok(())
}

pub(super) fn display_pixels(opened: &Opened) -> u64 {
    opened.headers().first().map_or(0, |header| header.shared_attributes.display_window.size.area() as u64)
}
