//! Decoding of many streams at once on a graphics device (GDC 6.3, table 1): 54 streams, key frames and later frames.
//!
//! `cargo bench --bench gpu -- CONTAINER.lfold… [--streams N] [--gpu INDEX|NAME]`. The depth streams of a container are
//! repeated, each as a stream of its own with its own bytes on the device, until there are N. Times are of a whole call,
//! from the list of units to the end of the device's work, medians over turns; the share of pixels that change stands
//! beside them, without which a time means nothing. `copy` is a copy between two buffers of the device of as many bytes
//! as the pictures have, counted as bytes written, as decoding is.

use std::time::Instant;

use lightfold::container::{ChunkKey, PackedChunk, ProbeEntry, Reader, StreamEntry, Writer};
use lightfold::dataset::stream::StreamKind;
use lightfold::gpu::decode::{GpuDecoder, picture_words};
use lightfold::gpu::device::{Gpu, Pick};
use lightfold::video::decode::{Decoder, StreamInfo};
use lightfold::{Error, Result};

/// Times that all frames are shown.
const TURNS: usize = 9;

struct Args {
    containers: Vec<String>,
    streams: usize,
    pick: Pick,
}

fn main() {
    let outcome = arguments().and_then(|args| {
        let gpu = Gpu::open(&args.pick)?;
        println!("{} ({}, {})", gpu.info.name, gpu.info.driver, gpu.info.backend);
        println!(
            "{:<24} {:>7} {:>9} {:>8} {:>9} {:>10} {:>12} {:>12} {:>9}",
            "container", "streams", "frames", "Mpixel", "changed", "ms", "decode MB/s", "copy MB/s", "of copy"
        );
        args.containers.iter().try_for_each(|path| measure(&gpu, path, args.streams))
    });
    if let Err(error) = outcome {
        eprintln!("{error}");
        std::process::exit(2);
    }
}

fn arguments() -> Result<Args> {
    let mut args = Args { containers: Vec::new(), streams: 54, pick: Pick::Best };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--bench" => {}
            "--streams" => {
                let count = words.next().and_then(|count| count.parse().ok()).filter(|&count| count > 0);
                args.streams = count.ok_or_else(|| Error::Usage("--streams takes a number of streams".into()))?;
            }
            "--gpu" => args.pick = Pick::parse(&words.next().unwrap_or_default()),
            _ => args.containers.push(word),
        }
    }
    if args.containers.is_empty() {
        return Err(Error::Usage("name a container with depth, such as one of faces of 1024x1024 pixels".into()));
    }
    Ok(args)
}

/// The depth streams of a container, repeated until there are `count`, each with its own chunks.
fn repeated(path: &str, count: usize) -> Result<Vec<u8>> {
    let reader = Reader::open(path)?;
    let index = reader.index();
    let depth: Vec<(u32, &StreamEntry)> =
        (0..).zip(&index.streams).filter(|(_, stream)| stream.kind == StreamKind::Depth as u8).collect();
    if depth.is_empty() {
        return Err(Error::Usage(format!("{path}: has no depth")));
    }
    let mut writer = Writer::new(Vec::new(), &index.name, index.fps, index.projection)?;
    for at in 0..count {
        let (_, stream) = depth[at % depth.len()];
        writer.add_probe(ProbeEntry { name: format!("{at}"), ..index.probes[usize::from(stream.probe)].clone() })?;
    }
    for at in 0..count {
        let (source, stream) = depth[at % depth.len()];
        let number = writer.add_stream(StreamEntry { probe: at as u16, ..stream.clone() });
        for chunk in index.stream_chunks(source) {
            let key = ChunkKey { stream: number, ..chunk.key };
            writer.push(&PackedChunk::stored(chunk, key, reader.fetch_stored(chunk)?)?)?;
        }
    }
    Ok(writer.finish()?.0)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn measure(gpu: &Gpu, path: &str, count: usize) -> Result<()> {
    let decoder = Decoder::new(Reader::from_memory(repeated(path, count)?)?)?;
    let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
    let frames = streams[0].frames;
    let mut on_gpu = GpuDecoder::new(gpu, &decoder, &streams)?;
    let pixels: u64 = streams.iter().map(|s| u64::from(s.entry.width) * u64::from(s.entry.height)).sum();
    let bytes = 4 * streams.iter().map(|stream| picture_words(stream)).sum::<u64>();
    let copy = copy_seconds(gpu, bytes)?;
    let (mut key_times, mut later_times) = (Vec::new(), Vec::new());
    let (mut key_pixels, mut later_pixels) = (0, 0);
    for turn in 0..=TURNS {
        for frame in frames.iter() {
            let before = on_gpu.cost().updated_pixels;
            let start = Instant::now();
            on_gpu.decode(frame)?;
            on_gpu.wait()?;
            let seconds = start.elapsed().as_secs_f64();
            let updated = on_gpu.cost().updated_pixels - before;
            // The first turn brings the chunks onto the device and builds kernels.
            if turn == 0 {
                continue;
            }
            if frame == frames.first {
                key_times.push(seconds);
                key_pixels += updated;
            } else {
                later_times.push(seconds);
                later_pixels += updated;
            }
        }
    }
    for (label, times, updated) in [("key", &mut key_times, key_pixels), ("later", &mut later_times, later_pixels)] {
        if times.is_empty() {
            continue;
        }
        let share = updated as f64 / (pixels as f64 * times.len() as f64);
        let seconds = median(times);
        let speed = share * bytes as f64 / 1e6 / seconds;
        println!(
            "{:<24} {:>7} {:>9} {:>8.1} {:>8.2}% {:>10.3} {:>12.0} {:>12.0} {:>8.1}%",
            path.rsplit('/').next().unwrap_or(path),
            count,
            label,
            pixels as f64 / 1e6,
            100.0 * share,
            1e3 * seconds,
            speed,
            bytes as f64 / 1e6 / copy,
            100.0 * speed / (bytes as f64 / 1e6 / copy),
        );
    }
    Ok(())
}

/// Seconds for copying `bytes` from one buffer of the device to another, submission and waiting included.
fn copy_seconds(gpu: &Gpu, bytes: u64) -> Result<f64> {
    let words = (bytes / 4) as usize;
    let none = wgpu::BufferUsages::empty();
    let (from, to) = (gpu.buffer("copy from", words, none)?, gpu.buffer("copy to", words, none)?);
    let mut times = Vec::new();
    for turn in 0..=TURNS {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&from, 0, &to, 0, 4 * words as u64);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        if turn > 0 {
            times.push(start.elapsed().as_secs_f64());
        }
    }
    Ok(median(&mut times))
}
