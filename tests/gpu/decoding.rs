//! Playback in which the GPU decodes depth and colour. The texels in its textures equal those of the CPU, bit for bit, and its
//! images equal those rendered from uploaded texels.

use std::path::Path;

use codec::decode::{AllUnits, Decoder};
use codec::math::Camera;
use codec::math::camera::Lens;
use codec::monitor::Silent;
use codec::streams::CodecHeader;
use glam::DVec3;
use gpu::Gpu;
use gpu::render::backend::{GpuBackend, buffer_bytes};
use gpu::render::depth_planes::ROW_WORDS;
use gpu::render::playback::DeviceRenderer;
use gpu::render::scene::{ImageId, Origin};
use gpu::render::texels::{DeviceTexels, Textures};
use libtest_mimic::Failed;
use lightfold::{Error, Result};
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions};
use render::march::playback::selection::SelectionSettings;
use render::march::pyramid::{DepthPyramid, Level, ViewPyramids};
use render::march::settings::SpecularMode;
use render::views::catalogue::ProbeChoice;
use render::views::light_field::{ColorTexels, FaceTexels, LightField};
use render::views::player::{Player, UnitRequest};

use crate::{lightfold, pick, with_gpu};

fn said(error: Error) -> String {
    error.to_string()
}

/// Reads a rectangle of a texture with 32-bit texels, row by row.
fn read(gpu: &Gpu, texture: &wgpu::Texture, [x, y, z]: [u32; 3], [width, height]: [u32; 2]) -> Result<Vec<u32>> {
    let pitch = width.next_multiple_of(ROW_WORDS);
    let words = (pitch * height) as usize;
    let buffer = gpu.buffer("texels of a test", words, wgpu::BufferUsages::empty())?;
    gpu.guard("texels of a test", || {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * pitch), rows_per_image: None },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        gpu.queue.submit([encoder.finish()]);
    })?;
    let all = gpu.read(&buffer, words)?;
    Ok(all.chunks(pitch as usize).flat_map(|row| &row[..width as usize]).copied().collect())
}

/// Describes the first texel of an image that differs between GPU and CPU; `None` if all are equal.
fn differing(
    gpu: &Gpu,
    texels: &DeviceTexels,
    origin: Origin,
    face: &FaceTexels,
    pyramid: &DepthPyramid,
) -> Result<Option<String>> {
    let Some(Textures { inverse_depths, colors, pyramids, materials, .. }) = &texels.textures else {
        return Ok(Some("no textures".into()));
    };
    let [x, y] = origin.texels;
    let image = [x, y, origin.layer];
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<u32>>();
    let packed = |texels: &[[u8; 4]]| texels.iter().map(|texel| u32::from_le_bytes(*texel)).collect::<Vec<u32>>();
    let ColorTexels::Codes(codes) = &face.color else { return Ok(Some("colours are no codes".into())) };
    let mut planes = vec![
        ("inverse depth".to_owned(), read(gpu, inverse_depths, image, face.size)?, bits(&face.inverse_depth)),
        ("colour".to_owned(), read(gpu, colors, image, face.size)?, packed(codes)),
    ];
    if let Some(material) = &face.material {
        planes.push(("material".to_owned(), read(gpu, materials, image, face.size)?, packed(material)));
    }
    for (level, Level { size, greatest: values }) in pyramid.levels.iter().enumerate() {
        let [column, row] = origin.pyramid;
        let rows = texels.pyramid_rows();
        let place = [column, row + rows - (rows >> level), origin.layer];
        planes.push((format!("pyramid {level}"), read(gpu, pyramids, place, *size)?, bits(values)));
    }
    let wrong = |(what, found, expected): (String, Vec<u32>, Vec<u32>)| {
        let at = (0..expected.len()).find(|&at| found.get(at) != Some(&expected[at]))?;
        Some(format!("{what}, texel {at} is {:#x?} and not {:#x}", found.get(at), expected[at]))
    };
    Ok(planes.into_iter().find_map(wrong))
}

/// Returns the requests of a walk: positions on a line through the mean position of the probes, with a turning camera.
fn walk(playback: &Playback<'_>, count: u32) -> Result<Vec<FrameRequest>> {
    let views = &playback.player.field.views;
    let middle = views.iter().map(|view| view.position).sum::<DVec3>() / views.len() as f64;
    let frames = playback.player.frames();
    let request = |at: u32| {
        let (turn, part) = (1.1 * f64::from(at), f64::from(at) / f64::from(count) - 0.5);
        let eye = middle + part * DVec3::new(0.6, 0.2, 0.4);
        let camera = Camera::look_at(eye, eye + DVec3::new(turn.cos(), -0.2, turn.sin()), DVec3::Y, Lens::new(60.0))?;
        // Advances by one or two frames, and wraps around to the first.
        let frame = frames.first + (at + at / 3) % frames.count() as u32;
        Ok(FrameRequest { frame, cameras: vec![camera] })
    };
    (0..count).map(request).collect()
}

/// Numbers of compared images, and of their texels of known and unknown depth.
#[derive(Debug, Default, PartialEq)]
struct Walked {
    images: usize,
    known: usize,
    unknown: usize,
}

/// Compares all images of the active views.
fn compare(gpu: &Gpu, renderer: &DeviceRenderer<'_>, field: &LightField, probes: &[usize]) -> Result<Walked, Failed> {
    let texels = &renderer.renderer.as_ref().ok_or("nothing was rendered")?.texels;
    let mut walked = Walked::default();
    for view in field.views.iter().filter(|view| probes.contains(&view.probe)) {
        let pyramids = ViewPyramids::of(view);
        for (number, face) in view.faces.iter().enumerate() {
            let Some(face) = face else { continue };
            let origin = texels.origin(ImageId { probe: view.probe, face: number });
            if let Some(wrong) = differing(gpu, texels, origin, face, &pyramids.faces[number]).map_err(said)? {
                return Err(format!("{}, face {number}: {wrong}", view.name).into());
            }
            walked.images += 1;
            let unknown = face.inverse_depth.iter().filter(|depth| depth.is_infinite()).count();
            walked.unknown += unknown;
            walked.known += face.inverse_depth.len() - unknown;
        }
    }
    Ok(walked)
}

/// Plays a walk through a container in three ways: decoded on the GPU, uploaded to the GPU, and on the CPU.
fn compare_walk(
    gpu: &Gpu,
    container: &Path,
    count: u32,
    (most, specular, kept_words): (Option<usize>, SpecularMode, Option<usize>),
) -> Result<Walked, Failed> {
    let decoder = Decoder::open(container).map_err(said)?;
    let selection = SelectionSettings { most, ..SelectionSettings::default() };
    let settings = PlaybackOptions { selection, ..PlaybackOptions::default() };
    let options = PictureOptions { size: [40, 30], steps: 48, specular, ..PictureOptions::default() };
    let mut playbacks = Vec::new();
    for _ in 0..3 {
        playbacks.push(Playback::new(&decoder, settings.clone()).map_err(said)?);
    }
    let coding = playbacks[0].player.field.coding;
    let mut decodes = DeviceRenderer::new(gpu, options.clone()).decoding(&decoder, coding);
    if !decodes.decodes() {
        return Err("the device does not decode it".into());
    }
    let is_entropy_coded =
        |header: &CodecHeader| matches!(header, CodecHeader::Color(color) if color.tables().is_some());
    let is_coded = decoder.streams().iter().any(|stream| is_entropy_coded(&stream.header));
    if DeviceRenderer::new(gpu, options.clone()).decoding_unless_entropy_coded(&decoder, coding).decodes() == is_coded {
        return Err(format!("entropy-coded colour: {is_coded}, and the choice is for the other").into());
    }
    if let (Some(words), Some(units)) = (kept_words, decodes.gpu_backend()) {
        units.kept_words = words;
    }
    let mut is_sent = DeviceRenderer::new(gpu, options.clone());
    let mut on_cpu = CpuRenderer::new(options);
    let mut all = Walked::default();
    for (at, request) in walk(&playbacks[0], count).map_err(said)?.iter().enumerate() {
        let [first, second, third] = &mut playbacks[..] else { return Err("three playbacks".into()) };
        let on_device = first.show(request, &mut decodes, &Silent).map_err(said)?;
        let sent = second.show(request, &mut is_sent, &Silent).map_err(said)?;
        let shown = third.show(request, &mut on_cpu, &Silent).map_err(said)?;
        let field = &third.player.field;
        let names: Vec<&String> = shown.trace.active.iter().map(|active| &active.probe).collect();
        let active: Vec<usize> =
            field.views.iter().filter(|view| names.contains(&&view.name)).map(|view| view.probe).collect();
        let walked = compare(gpu, &decodes, field, &active)
            .map_err(|wrong| format!("request {at}: {}", wrong.message().unwrap_or_default()))?;
        all.images += walked.images;
        all.known += walked.known;
        all.unknown += walked.unknown;
        // Both use the same texels and the same kernel.
        if on_device.pictures != sent.pictures {
            return Err(format!("request {at}: pictures differ").into());
        }
        let counts = |of: &render::views::player::ShowCounts| {
            [of.cells_decoded, of.cells_unchanged, of.cells_unseen, of.bytes_all]
        };
        if counts(&on_device.counts) != counts(&shown.counts) {
            return Err(format!("request {at}: {:?} and not {:?}", on_device.counts, shown.counts).into());
        }
    }
    Ok(all)
}

/// Tests all codecs of depth and 8-bit colour, sizes that are not multiples of tiles or cells, planar depth and distance,
/// materials, and changing sets of active views.
pub fn texels() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = tempfile::tempdir()?;
        let path = |name: &str| folder.path().join(name).display().to_string();
        let cube = |name: &str, scene: &str, options: &[&str]| -> Result<(), Failed> {
            let cameras = path("cameras.json");
            let (to, fixed) = (path(name), ["--samples", "1", "--frames", "0-5", "-q"]);
            let arguments = [&["capture", scene, "--cameras", &cameras, "-o", &to], &fixed[..], options].concat();
            lightfold(&arguments).map(|_| ())
        };
        std::fs::write(
            path("cameras.json"),
            r#"{"lightfold_cameras": 1, "cameras": [{"position": [0.0, 1.5, 0.0]}, {"position": [0.4, 1.6, 0.2]}, {"position": [-0.3, 1.5, 0.3]}]}"#,
        )?;
        cube("planar", "courtyard", &["--size", "44", "--depth", "planar"])?;
        cube("distance", "mirrors", &["--size", "50", "--depth", "distance", "--aov", "depth,material"])?;
        let (none, auto) = (SpecularMode::None, SpecularMode::Auto);
        for (set, options, count, how) in [
            ("planar", "", 8, (Some(2), auto, None)),
            ("planar", "--keyframe-interval 2 --color-codec cells", 8, (Some(2), auto, Some(0))),
            ("planar", "--color-cell 36 --color-chunk 2 --keyframe-interval 2", 5, (Some(2), none, Some(0))),
            ("planar", "--color-cell 64 --depth-tile 48", 3, (None, none, None)),
            (
                "planar",
                "--color-cell 12 --depth-tile 16 --depth-codec aabb --color-block bc1",
                5,
                (None, none, Some(2000)),
            ),
            (
                "planar",
                "--color-cell 16 --depth-tile 24 --depth-codec aabb --depth-block bc5 --color-block bc7",
                5,
                (None, none, None),
            ),
            (
                "planar",
                "--color-codec cells --color-cell 8 --depth-codec bc4w --transfer linear --exposure 1",
                4,
                (None, none, Some(0)),
            ),
            ("distance", "--color-cell 20 --depth-tile 32", 6, (Some(2), none, None)),
            (
                "distance",
                "--color-codec cells --color-cell 15 --depth-tile 32 --material-block bc1",
                4,
                (None, none, None),
            ),
        ] {
            let container = path("film.lfold");
            let manifest = path(set);
            let words: Vec<&str> = options.split_whitespace().collect();
            let fixed = ["encode", &manifest, "--clip", "--effort", "fast", "--quiet", "-o", &container];
            lightfold(&[&fixed[..], &words].concat())?;
            let walked = compare_walk(gpu, Path::new(&container), count, how)
                .map_err(|wrong| format!("{set} {options}: {}", wrong.message().unwrap_or_default()))?;
            println!("{set} {options} on {}: {walked:?}", gpu.info.name);
            if walked.images == 0 || walked.known == 0 || walked.unknown == 0 {
                return Err(format!("{set} {options}: {walked:?}").into());
            }
        }
        stays_on_the_cpu(gpu, &path("planar"), &path("film.lfold"), &["--hdr"])?;
        stays_on_the_cpu(gpu, &path("distance"), &path("film.lfold"), &[])
    })
}

/// Checks that half-float colour, and footage with reflections and refractions, is decoded on the CPU and rendered on the GPU.
fn stays_on_the_cpu(gpu: &Gpu, manifest: &str, container: &str, options: &[&str]) -> Result<(), Failed> {
    let fixed = ["encode", manifest, "--clip", "--effort", "fast", "--quiet", "-o", container];
    lightfold(&[&fixed[..], options].concat())?;
    let decoder = Decoder::open(container).map_err(said)?;
    let mut playback = Playback::new(&decoder, PlaybackOptions::default()).map_err(said)?;
    let picture = PictureOptions { size: [16, 16], steps: 16, ..PictureOptions::default() };
    let mut renderer = DeviceRenderer::new(gpu, picture).decoding(&decoder, playback.player.field.coding);
    let requests = walk(&playback, 1).map_err(said)?;
    let shown = playback.show(&requests[0], &mut renderer, &Silent).map_err(said)?;
    match renderer.decodes() || shown.pictures[0].image.color.data().iter().all(|color| *color == [0.0; 3]) {
        false => Ok(()),
        true => Err(format!("{manifest} {options:?}: black, or decoded on the device").into()),
    }
}

/// A chunk that consecutive frames need is read once, even if no other chunks are kept in memory. At the end, no more chunks are
/// kept than the last frame needs.
pub fn chunks_that_are_needed() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = tempfile::tempdir()?;
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (set, container) = (path("set"), path("film.lfold"));
        let fixed = ["capture", "courtyard", "--samples", "1", "--size", "44", "--frames", "0-11", "--quiet"];
        lightfold(&[&fixed[..], &["--position", "0,1.5,0", "-o", &set]].concat())?;
        let fixed = ["encode", &set, "--clip", "--effort", "fast", "--quiet", "-o", &container];
        lightfold(&[&fixed[..], &["--color-cell", "12", "--depth-tile", "24", "--keyframe-interval", "4"]].concat())?;
        let decoder = Decoder::open(Path::new(&container)).map_err(said)?;
        let mut read = Vec::new();
        for kept_words in [usize::MAX, 0] {
            let mut backend = GpuBackend::new(gpu, &decoder);
            backend.kept_words = kept_words;
            let mut player = Player::new(&decoder, &ProbeChoice::default()).map_err(said)?;
            let views: Vec<usize> = (0..player.field.views.len()).collect();
            let request = UnitRequest { visible: &AllUnits, secondary_rays: false };
            let mut bytes = Vec::new();
            for frame in (0..12).flat_map(|frame| [frame, frame]) {
                let counts = player.show_on(frame, &views, request, &mut backend).map_err(said)?;
                bytes.push(counts.bytes_read);
            }
            // Showing a frame again reads no chunk.
            if bytes.iter().skip(1).step_by(2).any(|bytes| *bytes > 0) {
                return Err(format!("of {kept_words} words kept, bytes read: {bytes:?}").into());
            }
            read.push(bytes.iter().sum::<u64>());
        }
        println!("bytes read of each film: {read:?}");
        match read[0] > 0 && read[0] == read[1] {
            true => Ok(()),
            false => Err(format!("with all chunks kept, and with none: {read:?}").into()),
        }
    })
}

/// The CPU decodes if a buffer would exceed the device's limit; the GPU decodes if the buffer has exactly that size. The largest
/// buffer is that of images in one case, and of depth planes in the other.
pub fn buffers_of_any_size() -> Result<(), Failed> {
    let mut gpu = Gpu::open(&pick()).map_err(said)?;
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("cameras.json"), r#"{"lightfold_cameras": 1, "cameras": [{"position": [0.0, 1.5, 0.0]}]}"#)?;
    for (size, cell) in [("44", "4"), ("100", "64")] {
        let fixed = ["capture", "courtyard", "--depth", "planar", "--samples", "1", "--frames", "0-1", "-q"];
        let (cameras, set) = (path("cameras.json"), path(size));
        lightfold(&[&fixed[..], &["--size", size, "--cameras", &cameras, "-o", &set]].concat())?;
        let (container, fixed) = (path("film.lfold"), ["--depth-tile", "104", "--effort", "fast", "--quiet"]);
        lightfold(&[&["encode", &set, "--clip", "--color-cell", cell, "-o", &container], &fixed[..]].concat())?;
        let decoder = Decoder::open(Path::new(&container)).map_err(said)?;
        let needed = buffer_bytes(&decoder);
        let mut pictures = Vec::new();
        for (most, decodes) in [(needed, true), (needed - 16, false)] {
            gpu.info.max_binding_bytes = most;
            let mut playback = Playback::new(&decoder, PlaybackOptions::default()).map_err(said)?;
            let options = PictureOptions { size: [24, 24], steps: 32, ..PictureOptions::default() };
            let coding = playback.player.field.coding;
            let mut renderer = DeviceRenderer::new(&gpu, options).decoding(&decoder, coding);
            if renderer.decodes() != decodes {
                return Err(format!("{size}, cells of {cell}: {needed} bytes needed, {most} allowed").into());
            }
            for request in walk(&playback, 3).map_err(said)? {
                pictures.push(playback.show(&request, &mut renderer, &Silent).map_err(said)?.pictures);
            }
        }
        if pictures[..3] != pictures[3..] {
            return Err(format!("{size}, cells of {cell}: pictures differ").into());
        }
    }
    Ok(())
}

/// State from before an error is not reused: playback after an error gives the same images as a new playback.
pub fn after_errors() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("demo").display().to_string();
        lightfold(&["demo", "--frame-count", "3", "--size", "32", "--probes", "2", "--quiet", "-o", &path])?;
        let decoder = Decoder::open(folder.path().join("demo/demo.lfold")).map_err(said)?;
        let options = PictureOptions { size: [24, 24], steps: 32, ..PictureOptions::default() };
        let settings = PlaybackOptions { probes: ProbeChoice::default(), ..PlaybackOptions::default() };
        let mut playback = Playback::new(&decoder, settings.clone()).map_err(said)?;
        let coding = playback.player.field.coding;
        let mut renderer = DeviceRenderer::new(gpu, options.clone()).decoding(&decoder, coding);
        let requests = walk(&playback, 3).map_err(said)?;
        playback.show(&requests[0], &mut renderer, &Silent).map_err(said)?;
        // Another renderer of the same playback has no state for the probes that are already active, so it fails.
        let mut other = DeviceRenderer::new(gpu, options.clone()).decoding(&decoder, coding);
        if playback.show(&requests[1], &mut other, &Silent).is_ok() {
            return Err("units of a probe that is not shown were decoded".into());
        }
        let mut fresh = Playback::new(&decoder, settings).map_err(said)?;
        let expected = fresh.show(&requests[2], &mut DeviceRenderer::new(gpu, options), &Silent).map_err(said)?;
        let found = playback.show(&requests[2], &mut other, &Silent).map_err(said)?;
        match found.pictures == expected.pictures {
            true => Ok(()),
            false => Err("pictures after an error differ".into()),
        }
    })
}
