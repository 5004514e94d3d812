//! Decoding speed relative to a plain copy of the same bytes, measured in one run.
//!
//! `cargo bench --bench ratios -- [CONTAINER.lfold…]` measures decoding of the given containers, by default of a procedural depth
//! stream. Copies and decodes alternate, so that drift of the machine affects both. The ratios are medians over the runs. The
//! fraction of pixels that changed is printed with them, because the speed depends on it.
//!
//! Interpolation of colour is measured separately, on one thread.
//!
//! Containers are read into memory before the measurement, as by `decode --null`; the measured time includes CRC checks and
//! payload parsing. Two copies with the same number of threads are measured: `plain`, from one buffer to another, each at least
//! as large as the output of decoding; and `hot`, into images of the units' size as decoding writes them, which stay in the
//! caches.

use std::time::Instant;

use codec::color::blend::lerp_all;
use codec::container::{ChunkKey, Compression, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer};
use codec::decode::{self, Decoder, Selection, StreamFrames, decoded_pixel_bytes};
use codec::depth::node_chunk::NodeChunk;
use codec::depth::quantise::DepthRange;
use codec::depth::{TemporalEncoder, TemporalSettings};
use codec::image::{DepthKind, StreamKind};
use codec::monitor::Silent;
use codec::streams::{CodecHeader, DepthChunk, DepthCoding, DepthHeader, PictureChunk};
use lightfold::Result;
use rayon::prelude::*;

/// Number of runs; each consists of two copies and a decode.
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
    println!();
    measure_lerp();
    let outcome = outcome.and_then(|()| {
        println!();
        println!(
            "{:<24} {:<9} {:>8} {:>8} {:>9} {:>11} {:>12} {:>9}",
            "packed nodes", "frames", "threads", "Mpixel", "changed", "copy MB/s", "decode MB/s", "of copy"
        );
        containers.iter().try_for_each(|path| measure_nodes(path.rsplit('/').next().unwrap_or(path), path))
    });
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
        let mut summary = decode::DecodeSummary::default();
        for _ in 0..TURNS {
            let start = Instant::now();
            copy_plainly(&mut destination, &source);
            let plain = start.elapsed().as_secs_f64();
            let start = Instant::now();
            copy_into_pictures(&units, &source);
            let hot = start.elapsed().as_secs_f64();
            let start = Instant::now();
            summary =
                decode::decode_units(&decoder, decode::Request::all(&chosen), decode::OnDamage::Stop, &Silent)?.summary;
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

/// Measures interpolation of cells of 64x64 8-bit RGB pixels between two keyframes on one thread, compared with copies of as many
/// bytes: for one cell that stays in the cache, and for so many cells that each is fetched from memory.
fn measure_lerp() {
    const CELL: usize = 64 * 64 * 3;
    println!("{:<24} {:>11} {:>12} {:>9}", "lerp, one thread", "copy MB/s", "lerp MB/s", "of copy");
    for (name, cells, rounds) in [("cells in the cache", 1, 4096), ("cells in memory", 4096, 1)] {
        let bytes = cells * CELL;
        let [a, b] = [3u32, 7].map(|step| (0..bytes as u32).map(|at| ((at * step) >> 3) as u8).collect::<Vec<u8>>());
        let mut shown = vec![1u8; bytes];
        let mut turns = Vec::new();
        for turn in 0..TURNS {
            let start = Instant::now();
            for _ in 0..rounds {
                shown.copy_from_slice(std::hint::black_box(&a));
                std::hint::black_box(&shown);
            }
            let copied = start.elapsed().as_secs_f64();
            let start = Instant::now();
            for round in 0..rounds {
                let cells = shown.chunks_mut(CELL).zip(std::hint::black_box(&a).chunks(CELL).zip(b.chunks(CELL)));
                cells.for_each(|(shown, (a, b))| lerp_all(a, b, (turn + round) as u8 | 1, shown));
                std::hint::black_box(&shown);
            }
            turns.push([copied, start.elapsed().as_secs_f64()]);
        }
        let median = |value: &dyn Fn(&[f64; 2]) -> f64| {
            let mut values: Vec<f64> = turns.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let speed = |at: usize| (bytes * rounds) as f64 / 1e6 / median(&|turn| turn[at]);
        let ratio = 100.0 * median(&|turn| turn[0] / turn[1]);
        println!("{name:<24} {:>11.0} {:>12.0} {ratio:>8.1}%", speed(0), speed(1));
    }
}

/// Bytes of a unit's image, and bytes that decoding writes into it, for every unit.
type UnitBytes = Vec<(usize, usize)>;

fn unit_bytes(decoder: &Decoder, chosen: &[StreamFrames<'_>]) -> Result<UnitBytes> {
    chosen
        .par_iter()
        .flat_map_iter(|&StreamFrames { stream, frames }| {
            (0..stream.entry.unit_count()).map(move |unit| (stream, frames, unit))
        })
        .map(|(stream, frames, unit)| {
            let mut unit = decoder.unit(stream, unit);
            frames.iter().try_for_each(|frame| unit.decode(frame).map(|_| ()))?;
            let [_, _, width, height] = unit.rect();
            let pixel = decoded_pixel_bytes(&stream.header) as usize;
            Ok((width as usize * height as usize * pixel, unit.cost().updated_pixels as usize * pixel))
        })
        .collect()
}

/// Returns the chunks of packed nodes of a container, checked and in the runtime form, with the pixel count of their units.
fn node_chunks(decoder: &Decoder) -> Result<Vec<(NodeChunk, usize)>> {
    let mut chunks = Vec::new();
    for stream in decoder.streams() {
        let CodecHeader::Depth(header) = &stream.header else { continue };
        for entry in decoder.reader().index().stream_chunks(stream.index) {
            let [_, _, width, height] = stream.entry.unit_rect(entry.key.unit);
            let payload = decoder.reader().fetch(entry)?;
            let area = stream.unit_area(entry.key.unit);
            let parsed = DepthChunk::parse(header, payload, area, entry.key.frame_count)?;
            if let DepthChunk::Nodes(chunk) = parsed {
                chunks.push((chunk, width as usize * height as usize));
            }
        }
    }
    Ok(chunks)
}

/// Measures decoding from the runtime form, separately for keyframes and for later frames, with one thread and with all; compared
/// with copies of as many bytes as decoding writes, from separate memory, with the same number of threads.
fn measure_nodes(name: &str, path: &str) -> Result<()> {
    let mut reader = Reader::open(path)?;
    reader.load(u64::MAX)?;
    let chunks = node_chunks(&Decoder::new(reader)?)?;
    if chunks.is_empty() {
        return Ok(());
    }
    let all = rayon::current_num_threads();
    for (frames, later) in [("key", false), ("later", true)] {
        for threads in [1, all] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let decode = |(chunk, pixels): &(NodeChunk, usize)| {
                let mut picture = vec![0u16; *pixels];
                let records = &chunk.runtime.frames;
                let records = if later { &records[1..] } else { &records[..1] };
                let written: u64 = records.iter().map(|&record| chunk.apply(&mut picture, record)).sum();
                std::hint::black_box(&picture);
                written
            };
            let written: Vec<u64> = pool.install(|| chunks.par_iter().map(decode).collect());
            let total: u64 = written.iter().sum();
            let of: u64 = chunks
                .iter()
                .map(|(chunk, pixels)| (*pixels * if later { chunk.runtime.frames.len() - 1 } else { 1 }) as u64)
                .sum();
            if total == 0 {
                continue;
            }
            let source: Vec<Vec<u16>> = written.iter().map(|&written| vec![7; written as usize]).collect();
            let copy = |(source, (_, pixels)): (&Vec<u16>, &(NodeChunk, usize))| {
                let mut picture = vec![0u16; *pixels];
                source.chunks(*pixels).for_each(|piece| picture[..piece.len()].copy_from_slice(piece));
                std::hint::black_box(&picture);
            };
            let mut turns = Vec::new();
            for _ in 0..TURNS {
                let start = Instant::now();
                pool.install(|| source.par_iter().zip(&chunks).for_each(copy));
                let copied = start.elapsed().as_secs_f64();
                let start = Instant::now();
                pool.install(|| chunks.par_iter().map(decode).sum::<u64>());
                turns.push([copied, start.elapsed().as_secs_f64()]);
            }
            let median = |value: &dyn Fn(&[f64; 2]) -> f64| {
                let mut values: Vec<f64> = turns.iter().map(value).collect();
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            };
            let speed = |at: usize| 2.0 * total as f64 / 1e6 / median(&|turn| turn[at]);
            println!(
                "{:<24} {:<9} {:>8} {:>8.1} {:>8.2}% {:>11.0} {:>12.0} {:>8.1}%",
                name,
                frames,
                threads,
                total as f64 / 1e6,
                100.0 * total as f64 / of as f64,
                speed(0),
                speed(1),
                100.0 * median(&|turn| turn[0] / turn[1]),
            );
        }
    }
    Ok(())
}

/// Copies one buffer to another, one piece per thread.
fn copy_plainly(destination: &mut [u8], source: &[u8]) {
    let piece = destination.len().div_ceil(rayon::current_num_threads()).max(1);
    destination.par_chunks_mut(piece).zip(source.par_chunks(piece)).for_each(|(to, from)| {
        to.copy_from_slice(&from[..to.len()]);
    });
    std::hint::black_box(destination);
}

/// Copies as many bytes as decoding writes, per unit into newly allocated memory of the unit's size, on all threads.
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

/// Returns a container of one 1024x1024 depth stream of 64 frames: rough ground, in front of which a square of a quarter of the
/// width moves.
fn synthetic() -> Result<Vec<u8>> {
    const SIZE: u32 = 1024;
    const TILE: u32 = 512;
    const FRAMES: u32 = 64;
    let temporal = TemporalSettings { keyframe_interval: 16, ..TemporalSettings::default() };
    let header = CodecHeader::Depth(DepthHeader {
        range: DepthRange::new(1.0, 100.0)?,
        background: f32::INFINITY,
        kind: DepthKind::Distance,
        coding: DepthCoding::Boxes(temporal),
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
        codec_header: header.write().into(),
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
            writer.push(&PackedChunk::new(key, chunk.payload, (Compression::None, PayloadKind::Mixed))?)?;
        }
    }
    Ok(writer.finish()?.0)
}
