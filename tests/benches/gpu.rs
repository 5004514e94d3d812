//! Decoding of many streams at once on a graphics device (GDC 6.3, table 1): 54 streams, key frames and later frames.
//!
//! `cargo bench --bench gpu -- CONTAINER.lfold… [--streams N] [--gpu INDEX|NAME]`. The depth streams of a container are
//! repeated, each as a stream of its own with its own bytes on the device, until there are N. Times are of a whole call,
//! from the list of units to the end of the device's work, medians over turns; the share of pixels that change stands
//! beside them, without which a time means nothing. `copy` is a copy between two buffers of the device of as many bytes
//! as the pictures have, counted as bytes written, as decoding is.
//!
//! `cargo bench --bench gpu -- --render CONTAINER.lfold… [--gpu INDEX|NAME]`: pictures of 90 degrees from the middle of the
//! probes (CALF 6). `update` is decoding on the CPU and sending what changed, `march` the device's work, both medians over
//! the frames but the first, which compiles the kernel.

use std::time::Instant;

use lightfold::container::{ChunkKey, PackedChunk, ProbeEntry, Reader, StreamEntry, Writer};
use lightfold::dataset::stream::StreamKind;
use lightfold::gpu::DeviceRenderer;
use lightfold::gpu::decode::{GpuDecoder, picture_words};
use lightfold::gpu::device::{Gpu, Pick};
use lightfold::math::Camera;
use lightfold::math::camera::Lens;
use lightfold::monitor::Silent;
use lightfold::reconstruct::path::Shot;
use lightfold::reconstruct::playback::{PictureOptions, Playback, PlaybackOptions};
use lightfold::video::decode::{Decoder, StreamInfo};
use lightfold::{Error, Result};

/// Times that all frames are shown.
const TURNS: usize = 9;

struct Args {
    containers: Vec<String>,
    streams: usize,
    pick: Pick,
    render: bool,
}

/// Pixels along a side of pictures, each with a number of steps.
const PICTURES: [(u32, u32); 4] = [(256, 64), (256, 256), (512, 256), (1024, 256)];
/// Frames that are rendered.
const FRAMES: usize = 6;

fn main() {
    let outcome = arguments().and_then(|args| {
        let gpu = Gpu::open(&args.pick)?;
        println!("{} ({}, {})", gpu.info.name, gpu.info.driver, gpu.info.backend);
        if args.render {
            return args.containers.iter().try_for_each(|path| measure_pictures(&gpu, path));
        }
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
    let mut args = Args { containers: Vec::new(), streams: 54, pick: Pick::Best, render: false };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--bench" => {}
            "--render" => args.render = true,
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

/// Pictures of some frames, in several sizes.
fn measure_pictures(gpu: &Gpu, path: &str) -> Result<()> {
    let decoder = Decoder::open(path)?;
    println!(
        "{:<24} {:>6} {:>6} {:>6} {:>11} {:>10} {:>9} {:>9} {:>12}",
        "container", "views", "pixels", "steps", "steps/pixel", "update ms", "sent MB", "march ms", "Mpixel/s"
    );
    for (side, steps) in PICTURES {
        let mut playback = Playback::new(&decoder, PlaybackOptions::default())?;
        let views = &playback.player().field().views;
        let eye = views.iter().map(|view| view.position).sum::<glam::DVec3>() / views.len() as f64;
        let camera = Camera::look_at(eye, eye + glam::DVec3::NEG_Z, glam::DVec3::Y, Lens::new(90.0))?;
        let options = PictureOptions { size: [side, side], steps, ..PictureOptions::default() };
        let mut renderer = DeviceRenderer::new(gpu, options);
        let (mut update, mut sent, mut march, mut marched) = (Vec::new(), Vec::new(), Vec::new(), 0);
        let frames = playback.player().frames();
        for (at, frame) in (frames.first..=frames.last).cycle().take(FRAMES).enumerate() {
            let before = renderer.cost();
            let shown = playback.show(&Shot { frame, cameras: vec![camera] }, &mut renderer, &Silent)?;
            let after = renderer.cost();
            marched = shown.pictures.iter().map(|picture| picture.counters.march_steps).sum();
            // The first picture compiles the kernel.
            if at > 0 {
                update.push(shown.trace.update_ms);
                sent.push((after.bytes_sent - before.bytes_sent) as f64 / 1e6);
                march.push(1e3 * (after.marching - before.marching).as_secs_f64());
            }
        }
        let pixels = f64::from(side) * f64::from(side);
        let march_ms = median(&mut march);
        println!(
            "{:<24} {:>6} {:>6} {:>6} {:>11.1} {:>10.2} {:>9.2} {:>9.2} {:>12.2}",
            path.rsplit('/').next().unwrap_or(path),
            playback.summary().most_views,
            side,
            steps,
            marched as f64 / pixels,
            median(&mut update),
            median(&mut sent),
            march_ms,
            pixels / 1e3 / march_ms,
        );
    }
    Ok(())
}
