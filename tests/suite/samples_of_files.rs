//! Splits containers into parts and reassembles them, with correct CRC-32s around what a test changes.

use codec::container::{Index, Reader, Storage};

/// Assembles a container of version 1.0 from an index, with correct CRC-32s: `stored` are the bytes between header and index,
/// `patch` may corrupt the bytes of the index.
pub fn assemble(index: &Index, stored: &[u8], patch: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut index = index.write_rows().unwrap();
    patch(&mut index);
    let head = b"\x89LFLD\r\n\x1a\x01\x00\x00\x00\x00\x00\x00\x00";
    with_foot([head, stored].concat(), &index, 0)
}

/// Appends an index, and a footer with correct CRC-32s, to header and chunks.
pub fn with_foot(mut file: Vec<u8>, index: &[u8], form: u8) -> Vec<u8> {
    let offset = file.len() as u64;
    file.extend_from_slice(index);
    let mut foot = Vec::new();
    foot.extend_from_slice(&offset.to_le_bytes());
    foot.extend_from_slice(&(index.len() as u64).to_le_bytes());
    foot.extend_from_slice(&crc32fast::hash(index).to_le_bytes());
    foot.extend_from_slice(&[form, 0, 0, 0]);
    foot.extend_from_slice(&(offset + index.len() as u64 + 40).to_le_bytes());
    file.extend_from_slice(&foot_end(foot));
    file
}

/// Returns a container whose index `patch` may corrupt; the form of the index is kept.
pub fn with_index(file: &[u8], patch: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let (index, form) = index_bytes(file);
    let start = file.len() - 40 - index.len();
    let mut index = index.to_vec();
    patch(&mut index);
    with_foot(file[..start].to_vec(), &index, form)
}

/// Returns the bytes of a container's index, and its form.
pub fn index_bytes(file: &[u8]) -> (&[u8], u8) {
    let foot = file.len() - 40;
    let start = u64::from_le_bytes(file[foot..foot + 8].try_into().unwrap()) as usize;
    (&file[start..foot], file[foot + 20])
}

/// Rewrites a container of minor version 1 or 2 as version 1.0; others are returned unchanged.
pub fn in_rows(file: Vec<u8>) -> Vec<u8> {
    if !matches!(file.get(10), Some(1 | 2)) {
        return file;
    }
    let (index, stored) = take_apart(&file);
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
    let end = index.chunks.iter().map(|chunk| chunk.offset as usize + chunk.stored_bytes as usize).max().unwrap_or(16);
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
