//! Chunks of an OpenEXR file: located by the offset tables, read, and checked against the size of their pixels before the `exr`
//! crate decompresses them.
//!
//! Every size that a chunk states is bounded by the length of the file or by the raw size of the chunk, which follows from the
//! header. `payload` checks the counters inside compressed payloads.

use std::io::{BufRead, Read, Seek, SeekFrom};
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates};
use exr::math::Vec2;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, compute_block_count};
use exr::prelude::Compression;

use super::errors::translate;
use super::guard::{CHUNK_ENTRY_BYTES, HEADER_SHARE, Opened, check, display_pixels, open};
use super::payload::{self, Room};
use crate::guard::guarded;
use codec::error::{Error, Result};
use codec::image::ReadLimits;

/// Bytes of the PIZ tables: a bitmap and its inverse, code lengths, and a decoding table with a list of long codes.
const PIZ_TABLE_BYTES: u64 = 4 << 20;
/// Bytes of the tables for inflating and for half floats.
const TABLE_BYTES: u64 = 1 << 20;

/// Returns the file offsets of the full-resolution chunks of the wanted parts, in ascending order.
pub fn places(opened: &mut Opened, is_wanted: impl Fn(usize) -> bool) -> Result<Vec<u64>> {
    let mut places = Vec::new();
    let mut table_at = opened.tables_at;
    for (part, header) in opened.meta.headers.iter().enumerate() {
        if is_wanted(part) {
            opened.file.seek(SeekFrom::Start(table_at)).map_err(read_error)?;
            for _ in 0..full_resolution_chunks(header) {
                places.push(u64::from_le_bytes(bytes(&mut opened.file)?));
            }
        }
        // `guard::open` has checked that the tables fit into the file.
        table_at += 8 * header.chunk_count as u64;
    }
    places.sort_unstable();
    Ok(places)
}

/// Returns the number of chunks of the largest level; they come first in the offset table of a part.
fn full_resolution_chunks(header: &Header) -> usize {
    match header.blocks {
        BlockDescription::ScanLines => header.chunk_count,
        BlockDescription::Tiles(tiles) => {
            let Vec2(columns, rows) = header.layer_size;
            let Vec2(width, height) = tiles.tile_size;
            compute_block_count(columns, width) * compute_block_count(rows, height)
        }
    }
}

/// Reads and decompresses the chunk at byte `place`.
pub fn read(opened: &mut Opened, place: u64, is_wanted: impl Fn(usize) -> bool) -> Result<UncompressedBlock> {
    let chunk = read_chunk(opened, place, is_wanted)?;
    let meta = &opened.meta;
    // No payload is known that passes the checks of this module and makes the crate panic.
    let decoded = guarded(|| UncompressedBlock::decompress_chunk(chunk, meta, false));
    let decoded = decoded.ok_or_else(|| damaged(place, "cannot be decompressed"))?;
    decoded.map_err(|error| match error {
        exr::error::Error::Invalid(what) => damaged(place, &format!("cannot be decompressed: {what}")),
        other => translate(other),
    })
}

fn damaged(place: u64, what: &str) -> Error {
    Error::invalid(format!("the EXR file is damaged: the chunk at byte {place} {what}"))
}

fn read_chunk(opened: &mut Opened, place: u64, is_wanted: impl Fn(usize) -> bool) -> Result<Chunk> {
    if place >= opened.file_len {
        return Err(Error::invalid(format!(
            "the EXR file is damaged: an offset table leads to byte {place} of a file of {} bytes",
            opened.file_len
        )));
    }
    let now = opened.file.stream_position().map_err(read_error)?;
    // A seek discards the read buffer, even if the position does not change.
    if now != place {
        opened.file.seek(SeekFrom::Start(place)).map_err(read_error)?;
    }
    let file = &mut opened.file;
    let part = if opened.meta.requirements.is_multilayer() { i32::from_le_bytes(bytes(file)?) } else { 0 };
    let part = usize::try_from(part).ok().filter(|part| *part < opened.meta.headers.len() && is_wanted(*part));
    // A damaged offset table may point to a chunk of a part that is not wanted.
    let part = part.ok_or_else(|| damaged(place, "belongs to another part"))?;
    let header = &opened.meta.headers[part];
    let (coordinates, line) = match header.blocks {
        BlockDescription::ScanLines => {
            let line = i32::from_le_bytes(bytes(file)?);
            (header.get_scan_line_block_tile_coordinates(line).map_err(translate)?, line)
        }
        BlockDescription::Tiles(_) => (TileCoordinates::read(file).map_err(translate)?, 0),
    };
    if coordinates.level_index != Vec2(0, 0) {
        return Err(damaged(place, "belongs to a smaller level of the image"));
    }
    let area = header.get_absolute_block_pixel_coordinates(coordinates).map_err(translate)?;
    let claimed = i32::from_le_bytes(bytes(file)?);
    let left = opened.file_len.saturating_sub(file.stream_position().map_err(read_error)?);
    let size = u64::try_from(claimed).unwrap_or(u64::MAX);
    if size > left {
        return Err(damaged(place, &format!("claims {claimed} bytes, and {left} bytes are left in the file")));
    }
    let room = Room::new(header, area.size);
    if size > header.max_block_byte_size() as u64 {
        return Err(damaged(place, &format!("claims {size} bytes, where its pixels take {} bytes", room.raw_bytes)));
    }
    let mut compressed_pixels_le = vec![0; size as usize];
    file.read_exact(&mut compressed_pixels_le).map_err(read_error)?;
    payload::check(header, &room, &compressed_pixels_le).map_err(|what| damaged(place, &what))?;
    let counted = opened.work.add(part, header, &room, &compressed_pixels_le);
    counted.map_err(|what| Error::unsupported(format!("the chunk at byte {place} of the EXR file {what}")))?;
    let compressed_block = match header.blocks {
        BlockDescription::ScanLines => {
            CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate: line, compressed_pixels_le })
        }
        BlockDescription::Tiles(_) => CompressedBlock::Tile(CompressedTileBlock { coordinates, compressed_pixels_le }),
    };
    Ok(Chunk { layer_index: part, compressed_block })
}

/// Returns an upper bound of the bytes allocated to read a file: its headers and offset tables, one chunk while it is decoded,
/// and the display window at `wanted_bytes` per pixel. Fails if the headers cannot be read or claim too many pixels.
pub fn reading_bytes(path: &Path, wanted_bytes: u64, limits: &ReadLimits) -> Result<u64> {
    let opened = open(path)?;
    check(&opened, wanted_bytes, limits).map_err(|error| error.in_file(path))?;
    let plane = display_pixels(&opened).saturating_mul(wanted_bytes);
    let chunk = opened.headers().iter().map(|header| decoding_bytes(header, opened.file_len)).max();
    let entries: u64 = opened.headers().iter().map(|header| header.chunk_count as u64).sum();
    let fixed = opened.tables_at.saturating_mul(HEADER_SHARE).saturating_add(entries * CHUNK_ENTRY_BYTES);
    Ok(plane.saturating_add(chunk.unwrap_or(0)).saturating_add(fixed))
}

/// Returns an upper bound of the bytes allocated to decode one chunk of a part, including its payload.
pub fn decoding_bytes(header: &Header, file_len: u64) -> u64 {
    let Vec2(width, height) = header.max_block_pixel_size();
    let room = Room::new(header, Vec2(width.min(header.layer_size.x()), height.min(header.layer_size.y())));
    let raw = room.raw_bytes;
    let payload = file_len.min(header.max_block_byte_size() as u64);
    // A vector that grows to a size takes three times that size while it is reallocated.
    let decoded = match header.compression {
        Compression::Uncompressed => 0,
        Compression::B44 | Compression::B44A => 2 * raw,
        Compression::PIZ => PIZ_TABLE_BYTES.saturating_add(2 * raw),
        // The bytes before and after interleaving.
        Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => 4 * raw,
        Compression::PXR24 => 6 * raw,
        Compression::DWAA(_) | Compression::DWAB(_) => 12u64.saturating_mul(raw).saturating_add(room.dct_bytes()),
        _ => raw,
    };
    payload.saturating_add(decoded).saturating_add(TABLE_BYTES)
}

fn bytes<const N: usize>(file: &mut impl BufRead) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes).map_err(read_error)?;
    Ok(bytes)
}

fn read_error(error: std::io::Error) -> Error {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => Error::invalid("the EXR file is damaged: it ends within a chunk or table"),
        _ => Error::io("", error),
    }
}
