//! Speeds as ratios within one run: decoding against a plain copy of the same bytes.
//!
//! `cargo bench --bench ratios -- [CONTAINER.lfold…]` measures decoding of the given containers; without any, of a
//! procedural depth stream. Copies and decodes take turns, so that drift of the machine hits both; medians of the
//! turns' ratios are printed, with the fraction of pixels that changed, without which a speed means nothing.
//!
//! Containers lie in memory, as `decode --null` reads them beforehand; CRCs are checked, payloads parsed. Two copies are measured, by as many threads: `plain`, from memory to other memory, both as large as what decoding
//! writes; and `hot`, into pictures of the units' size as decoding does it, which stay in the caches.

use std::time::Instant;

use lightfold::Result;
use lightfold::container::{ChunkKey, PackedChunk, ProbeEntry, Reader, StreamEntry, Writer};
use lightfold::dataset::stream::{DepthKind, StreamKind};
use lightfold::depth::quantise::DepthRange;
use lightfold::depth::temporal::{TemporalEncoder, TemporalSettings};
use lightfold::monitor::Silent;
use lightfold::video::codec::{CodecHeader, DepthHeader};
use lightfold::video::decode::Decoder;
use lightfold::video::export::{self, Chosen, Selection, decoded_pixel_bytes};
use rayon::prelude::*;

/// Turns of two copies and a decode.
const TURNS: usize = 15;

fn main() {
    let containers: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    println!("threads: {}", rayon::current_num_threads());
    println!(
        "{:<24} {:<9} {:>8} {:>9} {:>11} {:>11} {:>12} {:>9} {:>8}",
        "container", "streams", "Mpixel", "changed", "plain MB/s", "hot MB/s", "decode MB/s", "of plain", "of hot"
    );
    let outcome = if containers.is_empty() {
        synthetic().and_then(|bytes| measure("synthetic depth 1024²", Decoder::new(Reader::from_memory(bytes)?)?))
    } else {
        containers.iter().try_for_each(|path| {
            let name = path.rsplit('/').next().unwrap_or(path);
            let mut reader = Reader::open(path)?;
            reader.load(u64::MAX)?;
            measure(name, Decoder::new(reader)?)
        })
    };
    if let Err(error) = outcome {
        eprintln!("{error}");
        std::process::exit(2);
    }
}

fn measure(name: &str, decoder: Decoder) -> Result<()> {
    for kind in StreamKind::ALL {
        let selection = Selection { kinds: vec![kind], ..Selection::default() };
        let Ok(chosen) = selection.choose(&decoder) else { continue };
        let units = unit_bytes(&decoder, &chosen)?;
        let largest = units.iter().map(|unit| unit.0).max().unwrap_or(0);
        let source = vec![7u8; largest + units.iter().map(|unit| unit.1).sum::<usize>().min(1 << 30)];
        let total = units.iter().map(|unit| unit.1).sum::<usize>().min(1 << 30);
        let mut destination = vec![1u8; total];
        let mut turns = Vec::new();
        let mut summary = export::DecodeSummary::default();
        for _ in 0..TURNS {
            let start = Instant::now();
            copy_plainly(&mut destination, &source);
            let plain = start.elapsed().as_secs_f64();
            let start = Instant::now();
            copy_into_pictures(&units, &source);
            let hot = start.elapsed().as_secs_f64();
            let start = Instant::now();
            summary = export::decode_to_nothing(&decoder, &chosen, &Silent)?;
            turns.push([plain, hot, start.elapsed().as_secs_f64()]);
        }
        let median = |value: &dyn Fn(&[f64; 3]) -> f64| {
            let mut values: Vec<f64> = turns.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let speed = |at: usize| summary.bytes_out as f64 / 1e6 / median(&|turn| turn[at]);
        println!(
            "{:<24} {:<9} {:>8.1} {:>8.2}% {:>11.0} {:>11.0} {:>12.0} {:>8.1}% {:>7.1}%",
            name,
            kind.name(),
            summary.pixels as f64 / 1e6,
            100.0 * summary.cost.updated_pixels as f64 / summary.pixels as f64,
            speed(0),
            speed(1),
            speed(2),
            100.0 * median(&|turn| turn[0] / turn[2]),
            100.0 * median(&|turn| turn[1] / turn[2]),
        );
    }
    Ok(())
}

/// Bytes of a unit's picture and bytes that decoding writes into it, for every unit.
type UnitBytes = Vec<(usize, usize)>;

fn unit_bytes(decoder: &Decoder, chosen: &[Chosen<'_>]) -> Result<UnitBytes> {
    chosen
        .par_iter()
        .flat_map_iter(|&(stream, frames)| (0..stream.entry.unit_count()).map(move |unit| (stream, frames, unit)))
        .map(|(stream, frames, unit)| {
            let mut unit = decoder.unit(stream, unit);
            frames.iter().try_for_each(|frame| unit.decode(frame).map(|_| ()))?;
            let [_, _, width, height] = unit.rect();
            let pixel = decoded_pixel_bytes(&stream.header) as usize;
            Ok((width as usize * height as usize * pixel, unit.cost().updated_pixels as usize * pixel))
        })
        .collect()
}

/// Copies from memory to memory, a piece for each thread.
fn copy_plainly(destination: &mut [u8], source: &[u8]) {
    let piece = destination.len().div_ceil(rayon::current_num_threads()).max(1);
    destination.par_chunks_mut(piece).zip(source.par_chunks(piece)).for_each(|(to, from)| {
        to.copy_from_slice(&from[..to.len()]);
    });
    std::hint::black_box(destination);
}

/// Copies as many bytes as decoding writes, unit by unit into fresh memory of the unit's size, by as many threads.
fn copy_into_pictures(units: &UnitBytes, source: &[u8]) {
    units.par_iter().for_each(|&(size, mut left)| {
        let mut picture = vec![0u8; size];
        let mut from = 0;
        while left > 0 {
            let count = left.min(size);
            picture[..count].copy_from_slice(&source[from..from + count]);
            from = (from + count) % (source.len() - size).max(1);
            left -= count;
        }
        std::hint::black_box(&picture);
    });
}

/// A container of one 1024x1024 depth stream of 64 frames: bumpy ground, over which a square of a quarter of the
/// width wanders.
fn synthetic() -> Result<Vec<u8>> {
    const SIZE: u32 = 1024;
    const TILE: u32 = 512;
    const FRAMES: u32 = 64;
    let temporal = TemporalSettings { keyframe_interval: 16, ..TemporalSettings::default() };
    let header = CodecHeader::Depth(DepthHeader {
        range: DepthRange::new(1.0, 100.0)?,
        background: f32::INFINITY,
        kind: DepthKind::Distance,
        temporal,
    });
    let mut writer = Writer::new(Vec::new(), "synthetic", 24.0, 0)?;
    writer.add_probe(ProbeEntry {
        name: "00".into(),
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        frames: [0, FRAMES - 1],
        intrinsics: [0.0; 4],
    })?;
    writer.add_stream(StreamEntry {
        kind: StreamKind::Depth as u8,
        face: 0,
        probe: 0,
        codec: header.codec(),
        width: SIZE,
        height: SIZE,
        first_frame: 0,
        frame_count: FRAMES,
        unit_width: TILE,
        unit_height: TILE,
        codec_header: header.write(),
    });
    for unit in 0..4 {
        let [left, top] = [unit % 2 * TILE, unit / 2 * TILE];
        let mut encoder = TemporalEncoder::<u16>::new(TILE, temporal);
        let mut chunks = Vec::new();
        for frame in 0..FRAMES {
            let pixels: Vec<u16> = (0..TILE * TILE)
                .map(|at| {
                    let (x, y) = (left + at % TILE, top + at / TILE);
                    let wandering = (x.wrapping_sub(frame * 8) < 256) && y.wrapping_sub(frame * 5) < 256;
                    if wandering { (9000 + x * 3 + frame) as u16 } else { (20_000 + y * 17 + x * x % 61) as u16 }
                })
                .collect();
            chunks.extend(encoder.push(&pixels)?);
        }
        chunks.extend(encoder.finish()?);
        for chunk in chunks {
            let key = ChunkKey { stream: 0, unit, first_frame: chunk.first_frame, frame_count: chunk.frame_count };
            writer.push(&PackedChunk::new(key, chunk.payload, None)?)?;
        }
    }
    Ok(writer.finish()?.0)
}
