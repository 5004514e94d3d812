//! Mutated inputs of each target, generated deterministically: seed and input number determine the bytes.

use std::sync::Arc;

use codec::container::journal::MAGIC;
use codec::container::{ChunkEntry, ChunkKey, Index, StreamEntry};
use evaluate::cameras::CameraFormat;
use serde_json::Value;

use crate::mutate::{self, number, pick, place};
use crate::samples::{self, Random};
use crate::seeds;
use crate::targets::stream::Case;
use crate::targets::{Target, journal};

/// Generator of the inputs of one target.
pub struct Inputs {
    kind: Kind,
    seeds: Vec<Vec<u8>>,
    /// Parsed seeds: index and stored payloads of containers, and the values of JSON files.
    parts: Vec<(Index, Vec<u8>)>,
    values: Vec<Value>,
    seed: u64,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Bytes,
    Index,
    Case,
    Journal,
    Header(usize),
    Exr,
    Png,
    Json,
}

impl Inputs {
    /// Creates the generator of a target. `seed` determines all its inputs.
    pub fn new(target: &Target, seed: u64) -> Inputs {
        let (kind, seeds) = match target.name {
            "container" => {
                (Kind::Bytes, [seeds::containers(), seeds::vectors("invalid"), seeds::vectors("limits")].concat())
            }
            "index" => (Kind::Index, seeds::containers()),
            "lzma2" => (Kind::Header(24), seeds::lzma2()),
            "zstd" => (Kind::Header(24), seeds::zstd()),
            "transform" => (Kind::Header(64), seeds::transforms()),
            "journal" => (Kind::Journal, seeds::journals()),
            "exr" => (Kind::Exr, seeds::exr()),
            "png" => (Kind::Png, seeds::png()),
            "manifest" => (Kind::Json, seeds::manifests()),
            "seurat" => (Kind::Json, seeds::seurat_manifests()),
            "cameras" => (Kind::Json, seeds::cameras()),
            "jpeg" => (Kind::Header(700), seeds::jpeg()),
            "texture" => (Kind::Header(700), seeds::textures()),
            "seurat-exr" => (Kind::Exr, seeds::exr()),
            "seurat-png" => (Kind::Png, seeds::png()),
            "transforms" => (Kind::Json, seeds::camera_files(CameraFormat::Transforms)),
            "cameras-gltf" => (Kind::Json, seeds::cameras_gltf()),
            "cameras-glb" => (Kind::Header(4000), seeds::camera_files(CameraFormat::Gltf)),
            "colmap" => (Kind::Bytes, seeds::camera_files(CameraFormat::Colmap)),
            "scan" => (Kind::Json, seeds::scans()),
            "shard" => (Kind::Bytes, seeds::shards()),
            "usda" => (Kind::Bytes, vec![include_bytes!("../data/cameras/shot.usda").to_vec()]),
            "sweep" => (Kind::Bytes, seeds::sweeps()),
            "patterns" => (Kind::Bytes, seeds::patterns()),
            "cube" => (Kind::Bytes, seeds::lookup_tables()),
            "color-tables" => (Kind::Bytes, vec![include_bytes!("../../formats/color-tables.txt").to_vec()]),
            "depth-tables" => (Kind::Bytes, vec![include_bytes!("../../formats/depth-tables.txt").to_vec()]),
            "gltf" => (Kind::Json, seeds::gltf()),
            "glb" => (Kind::Header(4000), seeds::glb()),
            "quads" => (Kind::Header(4000), seeds::quads()),
            "obj" => (Kind::Bytes, seeds::obj()),
            "mtl" => (Kind::Bytes, seeds::mtl()),
            codec => (Kind::Case, codec.as_bytes().try_into().map(seeds::cases).unwrap_or_default()),
        };
        assert!(!seeds.is_empty(), "no seeds for {}", target.name);
        let parts =
            if kind == Kind::Index { seeds.iter().map(|file| samples::take_apart(file)).collect() } else { vec![] };
        let value = |text: &Vec<u8>| serde_json::from_slice(text).expect("a seed is JSON");
        let values = if kind == Kind::Json { seeds.iter().map(value).collect() } else { vec![] };
        Inputs { kind, seeds, parts, values, seed: seed ^ u64::from(crc32fast::hash(target.name.as_bytes())) << 32 }
    }

    /// Returns input `at`. The first inputs are the seeds, unchanged.
    pub fn get(&self, at: u64) -> Vec<u8> {
        if let Some(seed) = self.seeds.get(at as usize) {
            return seed.clone();
        }
        let random = &mut Random(self.seed.wrapping_add(at.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        random.below(2);
        let chosen = place(self.seeds.len(), random);
        let other = pick(&self.seeds, random);
        let mut input = self.seeds[chosen].clone();
        match self.kind {
            Kind::Bytes => mutate::bytes(&mut input, other, random),
            Kind::Header(front) => mutate::header(&mut input, front, other, random),
            Kind::Index => input = self.index(chosen, random),
            Kind::Case => input = case(&input, other, random),
            Kind::Exr if random.below(2) == 0 => exr_chunk(&mut input, random),
            Kind::Exr => mutate::header(&mut input, 700, other, random),
            Kind::Png => {
                mutate::header(&mut input, 60, other, random);
                if random.below(4) > 0 {
                    repair_png(&mut input);
                }
            }
            Kind::Journal => {
                mutate::header(&mut input, 600, other, random);
                if random.below(4) > 0 {
                    repair_journal(&mut input);
                }
            }
            Kind::Json => input = crate::json::mutate(&self.values[chosen], random),
        }
        input
    }

    /// Returns a container with a mutated index, mutated payloads or both, and correct CRC-32s.
    fn index(&self, chosen: usize, random: &mut Random) -> Vec<u8> {
        if random.below(3) == 0 {
            let from: &Vec<u8> = pick(&self.seeds, random);
            let other = samples::index_bytes(from);
            return samples::with_index(&self.seeds[chosen], |bytes| mutate::bytes(bytes, other, random));
        }
        let (mut index, mut stored) = self.parts[chosen].clone();
        let rounds = 1 + random.below(3);
        for _ in 0..rounds {
            match random.below(8) {
                0..=2 => change_index(&mut index, random),
                3..=5 if !stored.is_empty() => {
                    let length = stored.len();
                    mutate::bytes(&mut stored, &self.parts[place(self.parts.len(), random)].1, random);
                    stored.resize(length, 0);
                }
                6 => splice(&mut index, &mut stored, pick(&self.parts, random)),
                _ => {}
            }
        }
        for chunk in &mut index.chunks {
            let start = usize::try_from(chunk.offset).unwrap_or(usize::MAX).wrapping_sub(16);
            let end = start.saturating_add(chunk.stored_bytes as usize);
            if let Some(bytes) = stored.get(start..end) {
                chunk.crc32 = crc32fast::hash(bytes);
            }
        }
        let spoil = random.below(3) == 0;
        samples::assemble(&index, &stored, |bytes| {
            if spoil {
                mutate::bytes(bytes, &[], random);
            }
        })
    }
}

/// Changes a field of the index, or swaps rows.
fn change_index(index: &mut Index, random: &mut Random) {
    let value = number(random);
    let word = value as u32;
    if index.streams.is_empty() || random.below(12) == 0 {
        match random.below(3) {
            0 => index.fps = f64::from_bits(value),
            1 => index.projection = value as u8,
            _ => index.name = "n".repeat(random.below(70_000) as usize % 65_535),
        }
        return;
    }
    let at = place(index.streams.len(), random);
    if random.below(2) == 0 {
        change_stream(&mut index.streams[at], word, random);
        if random.below(3) > 0 {
            cover(index, at as u32, random);
        }
        return;
    }
    if index.chunks.is_empty() {
        return;
    }
    let at = place(index.chunks.len(), random);
    let other = place(index.chunks.len(), random);
    let taken = index.chunks[other];
    let chunk = &mut index.chunks[at];
    match random.below(8) {
        0 => chunk.offset = value,
        1 => chunk.stored_bytes = word,
        2 => chunk.raw_bytes = word,
        3 => chunk.key.first_frame = word,
        4 => chunk.key.frame_count = word,
        // The chunk takes the stored bytes of another: streams swap payloads.
        5 | 6 => *chunk = ChunkEntry { key: chunk.key, ..taken },
        _ => index.chunks.swap(at, other),
    }
}

fn change_stream(stream: &mut StreamEntry, word: u32, random: &mut Random) {
    let small = 1 + random.below(300);
    let any = if random.below(2) == 0 { small } else { word };
    match random.below(10) {
        0 => stream.width = any,
        1 => stream.height = any,
        2 => stream.unit_width = any,
        3 => stream.unit_height = any,
        4 => stream.frame_count = any,
        5 => stream.first_frame = any,
        6 => stream.face = word as u8,
        7 => {
            stream.codec = *pick(
                &[*b"DQPN", *b"DQTR", *b"DAAB", *b"DB4W", *b"DPRD", *b"DAB5", *b"MAAB", *b"CCL8", *b"CCLH"],
                random,
            )
        }
        8 => stream.kind = random.below(3) as u8,
        _ => mutate::bytes(Arc::make_mut(&mut stream.codec_header), &[], random),
    }
}

/// Gives a stream as many chunks as its sizes require, taken from its existing chunks.
fn cover(index: &mut Index, stream: u32, random: &mut Random) {
    let entry = &index.streams[stream as usize];
    if [entry.width, entry.height, entry.unit_width, entry.unit_height, entry.frame_count].contains(&0) {
        return;
    }
    let units = u64::from(entry.width.div_ceil(entry.unit_width)) * u64::from(entry.height.div_ceil(entry.unit_height));
    let old: Vec<_> = index.chunks.iter().filter(|chunk| chunk.key.stream == stream).copied().collect();
    if units > 400 || old.is_empty() {
        return;
    }
    let (first_frame, frame_count) = (entry.first_frame, entry.frame_count);
    index.chunks.retain(|chunk| chunk.key.stream != stream);
    for unit in 0..units as u32 {
        let key = ChunkKey { stream, unit, first_frame, frame_count };
        index.chunks.push(ChunkEntry { key, ..*pick(&old, random) });
    }
    index.chunks.sort_by_key(|chunk| chunk.key);
}

/// Appends the first stream of another container to this one.
fn splice(index: &mut Index, stored: &mut Vec<u8>, (other, other_stored): &(Index, Vec<u8>)) {
    let Some(stream) = other.streams.first() else { return };
    if index.probes.is_empty() {
        return;
    }
    let free = (0..7).find(|face| index.streams.iter().all(|held| (held.kind, held.face) != (stream.kind, *face)));
    let at = index.streams.len() as u32;
    let behind = stored.len() as u64;
    index.streams.push(StreamEntry { probe: 0, face: free.unwrap_or(0), ..stream.clone() });
    stored.extend_from_slice(other_stored);
    for chunk in other.stream_chunks(0) {
        let key = ChunkKey { stream: at, ..chunk.key };
        index.chunks.push(ChunkEntry { key, offset: chunk.offset + behind, ..*chunk });
    }
}

fn case(input: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let (mut case, other) = (Case::read(input), Case::read(other));
    if random.below(24) == 0 {
        let mut bytes = case.write();
        mutate::bytes(&mut bytes, &other.write(), random);
        return bytes;
    }
    for _ in 0..=random.below(2) {
        match random.below(12) {
            0 => case.sizes[random.below(4) as usize] = random.below(192) as u16,
            1 => {
                // Units of 4x4 pixels, of which an image has many.
                case.sizes = [random.below(64), random.below(64), 3, 3].map(|side| side as u16);
            }
            2 => case.frames = number(random) as u8,
            3 => case.chunks = random.below(8) as u8,
            4 => mutate::bytes(&mut case.header, &other.header, random),
            5 if !other.payloads.is_empty() => case.payloads.push(pick(&other.payloads, random).clone()),
            6 if case.payloads.len() > 1 => {
                let (one, two) = (place(case.payloads.len(), random), place(case.payloads.len(), random));
                case.payloads.swap(one, two);
            }
            _ if !case.payloads.is_empty() => {
                let at = place(case.payloads.len(), random);
                let from = other.payloads.first().cloned().unwrap_or_default();
                if random.below(3) == 0 {
                    mutate::header(&mut case.payloads[at], 48, &from, random);
                } else {
                    mutate::bytes(&mut case.payloads[at], &from, random);
                }
            }
            _ => {}
        }
    }
    case.write()
}

/// Changes the header of a chunk of an OpenEXR file, the counters after it, or bytes of its payload.
fn exr_chunk(file: &mut [u8], random: &mut Random) {
    let places = seeds::exr_chunks(file);
    for _ in 0..=random.below(3) {
        let start = *pick(&places, random);
        // The payload is preceded by up to five 4-byte words; a DWA payload starts with eleven 8-byte counters.
        let (at, width) = match random.below(4) {
            0 => (start + 4 * random.below(7) as usize, 4),
            1 | 2 => (start + 4 * random.below(28) as usize, 8),
            _ => (start + random.below(400) as usize, *pick(&[1, 1, 2, 4], random)),
        };
        let Some(field) = file.get_mut(at..at + width) else { continue };
        let mut word = [0; 8];
        word[..width].copy_from_slice(field);
        let old = u64::from_le_bytes(word);
        let new = match random.below(4) {
            0 => old.wrapping_add(u64::from(random.below(9))).wrapping_sub(4),
            1 => old ^ 1 << random.below(8 * width as u32),
            _ => number(random),
        };
        field.copy_from_slice(&new.to_le_bytes()[..width]);
    }
}

/// Gives each chunk of a PNG file its correct CRC-32.
fn repair_png(file: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = file.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map(u32::from_be_bytes) {
        let end = at.saturating_add(8).saturating_add(length as usize);
        if file.len() < end.saturating_add(4) {
            return;
        }
        let crc = crc32fast::hash(&file[at + 4..end]).to_be_bytes();
        file[end..end + 4].copy_from_slice(&crc);
        at = end + 4;
    }
}

/// Gives each record of a journal its correct CRC-32, up to the first record that exceeds the journal.
fn repair_journal(input: &mut [u8]) {
    let length = journal::parts(input).0.len();
    let Some(journal) = input.get_mut(4..4 + length) else { return };
    let mut at = MAGIC.len();
    while let Some(head) = journal.get(at..at + 9) {
        let end = at + 9 + u32::from_le_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(kind_and_body) = journal.get(at + 8..end) else { return };
        let crc32 = crc32fast::hash(kind_and_body).to_le_bytes();
        journal[at + 4..at + 8].copy_from_slice(&crc32);
        at = end;
    }
}
