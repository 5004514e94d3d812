//! Decoding of many streams at once on a GPU (GDC 6.3, table 1): 54 streams, keyframes and later frames.
//!
//! `cargo bench --bench gpu -- CONTAINER.lfold… [--streams N] [--gpu INDEX|NAME]`. The depth streams of a container are repeated
//! until there are N; each copy is a separate stream with its own bytes on the GPU. A time is that of a whole call, from the list
//! of units to the end of the GPU's work, as a median over the runs. The fraction of pixels that change is printed with it,
//! because the time depends on it. `copy` is a copy between two GPU buffers of as many bytes as the images have; like decoding,
//! it is counted in bytes written.
//!
//! `cargo bench --bench gpu -- --render CONTAINER.lfold… [--gpu INDEX|NAME]`: images of 90 degrees field of view from the mean
//! position of the probes (CALF 6). `update` is the time to decode and upload what changed, `march` the time of the GPU; both are
//! medians over all frames but the first, which compiles the kernel. A second table shows the stages of an update with decoding
//! on the CPU and on the GPU, measured alternately frame by frame, and the ratio of the two in the same run: `fetch` reads,
//! decompresses, checks and uploads chunks; `decode`, `texels` (inverse depths) and `squares` (pyramids) are waited for one by
//! one, and so take longer than in playback; `textures` uploads or copies changes into textures. For the CPU, `decode` includes
//! all stages before `textures`.

use std::time::{Duration, Instant};

use codec::container::{ChunkKey, PackedChunk, ProbeEntry, Reader, StreamEntry, Writer};
use codec::decode::{Decoder, StreamInfo};
use codec::image::StreamKind;
use codec::math::Camera;
use codec::math::camera::Lens;
use codec::monitor::Silent;
use gpu::decode::{GpuDecoder, picture_words};
use gpu::device::{Gpu, Pick};
use gpu::render::RenderCost;
use gpu::render::playback::DeviceRenderer;
use lightfold::{Error, Result};
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{PictureOptions, Playback, PlaybackOptions};

/// Number of runs over all frames.
const TURNS: usize = 9;

struct Args {
    containers: Vec<String>,
    streams: usize,
    pick: Pick,
    render: bool,
}

/// Width and height of images in pixels, and number of steps.
const PICTURES: [(u32, u32); 4] = [(256, 64), (256, 256), (512, 256), (1024, 256)];
/// Number of rendered frames.
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

/// Returns a container with the depth streams of a container, repeated until there are `count`, each with its own chunks.
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
    let bytes = 4 * streams.iter().map(|stream| picture_words(stream, 1)).sum::<u64>();
    let copy = copy_seconds(gpu, bytes)?;
    let (mut key_times, mut later_times) = (Vec::new(), Vec::new());
    let (mut key_pixels, mut later_pixels) = (0, 0);
    for turn in 0..=TURNS {
        for frame in frames.iter() {
            let before = on_gpu.cost.updated_pixels;
            let start = Instant::now();
            on_gpu.decode(frame)?;
            on_gpu.wait()?;
            let seconds = start.elapsed().as_secs_f64();
            let updated = on_gpu.cost.updated_pixels - before;
            // The first run uploads the chunks and compiles the kernels.
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

/// Returns the seconds to copy `bytes` from one GPU buffer to another, including submission and waiting.
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

/// Times of updates in milliseconds, and transfers in megabytes, per frame.
#[derive(Default)]
struct Updates {
    whole_ms: Vec<f64>,
    parts_ms: [Vec<f64>; 5],
    sent_mb: Vec<f64>,
    copied_mb: Vec<f64>,
}

impl Updates {
    /// Adds a frame: its total time, and the renderer's costs before and after it.
    fn add(&mut self, whole_ms: f64, [before, after]: [&RenderCost; 2]) {
        let ms = |of: fn(&RenderCost) -> Duration| 1e3 * (of(after) - of(before)).as_secs_f64();
        let parts = [
            ms(|cost| cost.units.fetching),
            ms(|cost| cost.units.decoding),
            ms(|cost| cost.units.texels),
            ms(|cost| cost.units.pyramids),
            ms(|cost| cost.sending),
        ];
        self.whole_ms.push(whole_ms);
        self.parts_ms.iter_mut().zip(parts).for_each(|(all, part)| all.push(part));
        self.sent_mb.push((after.bytes_sent - before.bytes_sent) as f64 / 1e6);
        self.copied_mb.push((after.bytes_copied - before.bytes_copied) as f64 / 1e6);
    }

    fn print(&mut self, decodes: bool) -> f64 {
        let whole_ms = median(&mut self.whole_ms);
        let [fetch, decode, texels, squares, textures] = self.parts_ms.each_mut().map(|part| median(part));
        let (sent, copied) = (median(&mut self.sent_mb), median(&mut self.copied_mb));
        let (on, fetch, decode) = match decodes {
            true => ("device", format!("{fetch:.2}"), format!("{decode:.2}")),
            false => ("cpu", "-".to_owned(), format!("{:.2}", whole_ms - textures)),
        };
        println!(
            "{on:<24} {whole_ms:>10.2} {fetch:>9} {decode:>9} {texels:>9.2} {squares:>9.2} {textures:>9.2} {sent:>9.2} \
             {copied:>9.2}"
        );
        whole_ms
    }
}

/// Measures updates with decoding on the CPU and on the GPU.
fn measure_updates(gpu: &Gpu, decoder: &Decoder) -> Result<()> {
    println!(
        "{:<24} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "decoded on", "update ms", "fetch", "decode", "texels", "squares", "textures", "sent MB", "copied MB"
    );
    let options = PictureOptions { size: [8, 8], steps: 8, ..PictureOptions::default() };
    let (mut sends, mut decodes) = (DeviceRenderer::new(gpu, options.clone()), DeviceRenderer::new(gpu, options));
    let mut playbacks =
        [Playback::new(decoder, PlaybackOptions::default())?, Playback::new(decoder, PlaybackOptions::default())?];
    let field = &playbacks[0].player.field;
    let eye = field.views.iter().map(|view| view.position).sum::<glam::DVec3>() / field.views.len() as f64;
    decodes = decodes.decoding(decoder, field.coding);
    match decodes.gpu_backend() {
        Some(units) => units.waits = true,
        None => return Err(Error::Usage("the device does not decode this container".into())),
    }
    let camera = Camera::look_at(eye, eye + glam::DVec3::NEG_Z, glam::DVec3::Y, Lens::new(90.0))?;
    let frames = playbacks[0].player.frames();
    let mut updates = [Updates::default(), Updates::default()];
    for (at, frame) in (frames.first..=frames.last).cycle().take(1 + TURNS).enumerate() {
        let request = FrameRequest { frame, cameras: vec![camera] };
        for (turn, renderer) in [&mut sends, &mut decodes].into_iter().enumerate() {
            let before = renderer.cost();
            let shown = playbacks[turn].show(&request, renderer, &Silent)?;
            if at > 0 {
                updates[turn].add(shown.trace.update_ms, [&before, &renderer.cost()]);
            }
        }
    }
    let [on_cpu, on_device] = &mut updates;
    let ratio = on_cpu.print(false) / on_device.print(true);
    println!("an update takes 1/{ratio:.2} of the time where the device decodes");
    Ok(())
}

/// Measures the rendering of some frames in several sizes.
fn measure_pictures(gpu: &Gpu, path: &str) -> Result<()> {
    let decoder = Decoder::open(path)?;
    measure_updates(gpu, &decoder)?;
    println!(
        "{:<24} {:>6} {:>6} {:>6} {:>11} {:>10} {:>9} {:>9} {:>12}",
        "container", "views", "pixels", "steps", "steps/pixel", "update ms", "sent MB", "march ms", "Mpixel/s"
    );
    for (side, steps) in PICTURES {
        let mut playback = Playback::new(&decoder, PlaybackOptions::default())?;
        let views = &playback.player.field.views;
        let eye = views.iter().map(|view| view.position).sum::<glam::DVec3>() / views.len() as f64;
        let camera = Camera::look_at(eye, eye + glam::DVec3::NEG_Z, glam::DVec3::Y, Lens::new(90.0))?;
        let options = PictureOptions { size: [side, side], steps, ..PictureOptions::default() };
        let mut renderer = DeviceRenderer::new(gpu, options).decoding(&decoder, playback.player.field.coding);
        let (mut update, mut sent, mut march, mut marched) = (Vec::new(), Vec::new(), Vec::new(), 0);
        let frames = playback.player.frames();
        for (at, frame) in (frames.first..=frames.last).cycle().take(FRAMES).enumerate() {
            let before = renderer.cost();
            let shown = playback.show(&FrameRequest { frame, cameras: vec![camera] }, &mut renderer, &Silent)?;
            let after = renderer.cost();
            marched = shown.pictures.iter().map(|picture| picture.counters.march_steps).sum();
            // Rendering the first image compiles the kernel.
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
            playback.summary().max_views,
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
