//! Splits containers into parts and reassembles them, with correct CRC-32s around what a test changes.

use std::collections::HashMap;

use codec::container::serialize::PutFields;
use codec::container::{ChunkEntry, Index, Reader, Storage};

/// Assembles a container from an index whose rows state every field and are not checked. `stored` are the bytes between header and
/// index at which the chunks' offsets point; `patch` may corrupt the bytes of the index.
pub fn assemble(index: &Index, stored: &[u8], patch: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = Vec::new();
    [index.probes.len(), index.streams.len(), index.chunks.len()].iter().for_each(|&n| bytes.put_varint(n as u64));
    bytes.extend_from_slice(&[0, index.projection, 0, 0, 0]);
    bytes.put_f64(index.fps);
    bytes.put_string("a name", &index.name).unwrap();
    put_probes(&mut bytes, index);
    put_streams(&mut bytes, index);
    let mut file = b"\x89LFLD\r\n\x1a\x01\x00\x00\x00\x00\x00\x00\x00".to_vec();
    put_chunks(&mut bytes, index, |chunk| {
        let start = usize::try_from(chunk.offset).unwrap_or(usize::MAX).wrapping_sub(16).min(stored.len());
        let end = start.saturating_add(chunk.stored_bytes as usize).min(stored.len());
        file.extend_from_slice(&stored[start..end]);
    });
    for (name, value) in index.attributes.iter() {
        bytes.put_string("a name", name).unwrap();
        bytes.put_varint(value.len() as u64);
        bytes.extend_from_slice(value);
    }
    patch(&mut bytes);
    with_foot(file, &bytes)
}

fn put_probes(bytes: &mut Vec<u8>, index: &Index) {
    for probe in &index.probes {
        bytes.push(7);
        bytes.put_string("a name", &probe.name).unwrap();
        probe.position.iter().chain(&probe.orientation).for_each(|&value| bytes.put_f64(value));
        probe.frames.iter().for_each(|&frame| bytes.put_varint(frame.into()));
        probe.intrinsics.iter().for_each(|&value| bytes.put_f64(value));
    }
}

fn put_streams(bytes: &mut Vec<u8>, index: &Index) {
    for stream in &index.streams {
        bytes.extend_from_slice(&[0xff, stream.kind]);
        bytes.extend_from_slice(&stream.codec);
        bytes.put_varint(stream.probe.into());
        bytes.push(stream.face);
        let sizes = [stream.width, stream.height, stream.first_frame, stream.frame_count];
        sizes.iter().for_each(|&value| bytes.put_varint(value.into()));
        let header_bytes = stream.codec_header.len() as u32;
        [stream.unit_width, stream.unit_height, 0, header_bytes]
            .iter()
            .for_each(|&value| bytes.put_varint(value.into()));
        bytes.extend_from_slice(&stream.codec_header);
        bytes.push(0);
    }
}

/// Appends a row for each chunk, and calls `store` for each chunk that does not have the stored bytes of an earlier one.
fn put_chunks(bytes: &mut Vec<u8>, index: &Index, mut store: impl FnMut(&ChunkEntry)) {
    let mut first_units = vec![0u64];
    for stream in &index.streams {
        let [columns, rows] = [(stream.width, stream.unit_width), (stream.height, stream.unit_height)]
            .map(|(size, unit)| u64::from(size.div_ceil(unit.max(1)).min(1 << 24)));
        first_units.push(first_units[first_units.len() - 1] + columns * rows);
    }
    let units = first_units[index.streams.len()].max(1);
    let (mut predicted, mut rows) = (0, HashMap::new());
    for (at, chunk) in index.chunks.iter().enumerate() {
        let first = first_units.get(chunk.key.stream as usize).copied().unwrap_or(units);
        let unit = (first + u64::from(chunk.key.unit)) % units;
        let step = (unit + units - predicted) % units;
        let place = (chunk.offset, chunk.stored_bytes, chunk.raw_bytes, chunk.crc32, chunk.storage);
        let shared = rows.insert(place, at).map(|earlier| at - earlier - 1);
        let (kind, value) = shared.map_or((chunk.storage as u64, chunk.stored_bytes.into()), |back| (3, back as u64));
        bytes.put_varint(value << 3 | u64::from(step > 0) << 2 | kind);
        if step > 0 {
            bytes.put_varint(step);
        }
        bytes.put_varint(chunk.key.frame_count.into());
        if shared.is_none() {
            if chunk.storage != Storage::Raw {
                bytes.put_varint(chunk.raw_bytes.into());
            }
            bytes.put_u32(chunk.crc32);
            store(chunk);
        }
        predicted = (unit + 1) % units;
    }
}

/// Appends an index, and a footer with correct CRC-32s, to header and chunks.
pub fn with_foot(mut file: Vec<u8>, index: &[u8]) -> Vec<u8> {
    let offset = file.len() as u64;
    file.extend_from_slice(index);
    let mut foot = Vec::new();
    foot.extend_from_slice(&offset.to_le_bytes());
    foot.extend_from_slice(&(index.len() as u64).to_le_bytes());
    foot.extend_from_slice(&crc32fast::hash(index).to_le_bytes());
    foot.extend_from_slice(&[0; 4]);
    foot.extend_from_slice(&(offset + index.len() as u64 + 40).to_le_bytes());
    file.extend_from_slice(&foot_end(foot));
    file
}

/// Returns a container whose index `patch` may corrupt.
pub fn with_index(file: &[u8], patch: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let index = index_bytes(file);
    let start = file.len() - 40 - index.len();
    let mut index = index.to_vec();
    patch(&mut index);
    with_foot(file[..start].to_vec(), &index)
}

/// Returns the bytes of a container's index.
pub fn index_bytes(file: &[u8]) -> &[u8] {
    let foot = file.len() - 40;
    let start = u64::from_le_bytes(file[foot..foot + 8].try_into().unwrap()) as usize;
    &file[start..foot]
}

/// Returns the container with an index whose rows state every field.
pub fn stated(file: &[u8]) -> Vec<u8> {
    let (index, stored) = take_apart(file);
    assemble(&index, &stored, |_| ())
}

/// Appends CRC-32 and magic to the first 32 bytes of a footer.
pub fn foot_end(mut foot: Vec<u8>) -> Vec<u8> {
    foot.truncate(32);
    foot.extend_from_slice(&crc32fast::hash(&foot).to_le_bytes());
    foot.extend_from_slice(b"LFND");
    foot
}

/// Returns the index of a container, and the bytes between header and index.
pub fn take_apart(file: &[u8]) -> (Index, Vec<u8>) {
    let index = Reader::from_memory(file.to_vec()).unwrap().index().clone();
    let end = file.len() - 40 - index_bytes(file).len();
    (index, file[16..end].to_vec())
}

/// Replaces the payloads of all chunks: `change` takes a chunk's index in the table and its payload.
pub fn with_payloads(file: &[u8], mut change: impl FnMut(usize, &mut Vec<u8>)) -> Vec<u8> {
    let reader = Reader::from_memory(file.to_vec()).unwrap();
    let mut index = reader.index().clone();
    let mut stored = Vec::new();
    for (at, chunk) in index.chunks.iter_mut().enumerate() {
        let mut payload = reader.fetch(chunk).unwrap().into_vec();
        change(at, &mut payload);
        chunk.offset = 16 + stored.len() as u64;
        chunk.stored_bytes = payload.len() as u32;
        chunk.raw_bytes = payload.len() as u32;
        chunk.crc32 = crc32fast::hash(&payload);
        chunk.storage = Storage::Raw;
        stored.extend_from_slice(&payload);
    }
    assemble(&index, &stored, |_| ())
}
