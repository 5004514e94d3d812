//! Images rendered on the GPU, compared with the CPU: playback with changing sets of views, footage, and refusals.

use std::path::Path;

use codec::decode::Decoder;
use codec::math::Camera;
use codec::math::camera::Lens;
use codec::monitor::{Monitor, Silent};
use glam::DVec3;
use gpu::Gpu;
use gpu::render::GpuRenderer;
use gpu::render::agreement::Agreement;
use gpu::render::playback::DeviceRenderer;
use gpu::selftest::pictures;
use kernels::KERNELS;
use libtest_mimic::Failed;
use lightfold::{Error, Result};
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions, Renderer, Stage};
use render::march::playback::selection::SelectionSettings;
use render::march::render::{Rendered, render};
use render::march::settings::{Acceleration, SpecularMode};
use render::views::light_field::BACKGROUND;
use render::views::player::Change;

use crate::{lightfold, with_gpu};

/// Renderer that renders each image on both devices and records their agreement.
struct Both<'a> {
    on_device: DeviceRenderer<'a>,
    on_cpu: CpuRenderer,
    found: Vec<Agreement>,
}

impl Renderer for Both<'_> {
    fn specular(&self) -> SpecularMode {
        self.on_cpu.specular()
    }

    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.on_cpu.update(stage, changes)?;
        self.on_device.update(stage, changes)
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let on_cpu = self.on_cpu.render(stage, camera, monitor)?;
        let on_device = self.on_device.render(stage, camera, monitor)?;
        self.found.push(Agreement::of(&on_device, &on_cpu)?);
        Ok(on_cpu)
    }
}

/// Returns the requests of a walk along a diagonal through the mean position of the probes, with a turning camera and consecutive
/// frames.
fn walk(playback: &Playback<'_>, requests: u32, stride_m: f64) -> Result<Vec<FrameRequest>> {
    let views = &playback.player.field.views;
    let middle = views.iter().map(|view| view.position).sum::<DVec3>() / views.len() as f64;
    let frames = playback.player.frames();
    let request = |at: u32| {
        let (turn, part) = (0.9 * f64::from(at), f64::from(at) / f64::from(requests) - 0.5);
        let eye = middle + part * stride_m * DVec3::new(1.0, 0.3, 0.7);
        let target = eye + DVec3::new(turn.cos(), -0.1, turn.sin());
        let camera = Camera::look_at(eye, target, DVec3::Y, Lens::new(75.0))?;
        Ok(FrameRequest { frame: frames.first + at % frames.count() as u32, cameras: vec![camera] })
    };
    (0..requests).map(request).collect()
}

/// Renders a walk through a container on both devices; returns the bytes uploaded for each request.
fn compare(gpu: &Gpu, container: &str, requests: u32, most: Option<usize>) -> Result<Vec<u64>, Failed> {
    let said = |error: Error| error.to_string();
    let decoder = Decoder::open(container).map_err(said)?;
    let mut sent = Vec::new();
    for (acceleration, specular) in
        [(Acceleration::Pyramid, SpecularMode::Auto), (Acceleration::None, SpecularMode::None)]
    {
        let selection = SelectionSettings { most, ..SelectionSettings::default() };
        let settings = PlaybackOptions { selection, ..PlaybackOptions::default() };
        let mut playback = Playback::new(&decoder, settings).map_err(said)?;
        let options =
            PictureOptions { size: [160, 120], steps: 128, acceleration, specular, ..PictureOptions::default() };
        let on_cpu = CpuRenderer::new(options.clone());
        let mut both = Both { on_device: DeviceRenderer::new(gpu, options), on_cpu, found: Vec::new() };
        let mut before = 0;
        for request in walk(&playback, requests, 0.5).map_err(said)? {
            playback.show(&request, &mut both, &Silent).map_err(said)?;
            let all = both.on_device.cost().bytes_sent;
            sent.push(all - before);
            before = all;
        }
        for (at, agreement) in both.found.iter().enumerate() {
            println!("{container}, {acceleration:?}, request {at} on {}: {agreement:?}", gpu.info.name);
            if agreement.mismatches() > 0 {
                return Err(format!("{container}, {acceleration:?}, request {at}: {agreement:?}").into());
            }
        }
        if both.found.len() != requests as usize {
            return Err(format!("{} pictures", both.found.len()).into());
        }
    }
    Ok(sent)
}

/// Frames and views change; only texels that changed are uploaded.
pub fn playback() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("demo").display().to_string();
        lightfold(&["demo", "--frame-count", "4", "--size", "64", "--probes", "4", "--quiet", "-o", &path])?;
        let container = folder.path().join("demo/demo.lfold").display().to_string();
        let sent = compare(gpu, &container, 8, None)?;
        // The container has four frames, so the requests from the fifth on repeat them.
        if sent[0] == 0 || sent[1..8].iter().any(|&bytes| bytes >= sent[0]) {
            return Err(format!("bytes of texels that went to {}: {sent:?}", gpu.info.name).into());
        }
        compare(gpu, &container, 8, Some(2)).map(|_| ())
    })
}

/// Compares footage encoded with the default codecs.
pub fn footage() -> Result<(), Failed> {
    let Some(data) = option_env!("LIGHTFOLD_DATA") else { return Err("no footage at hand".into()) };
    with_gpu(|gpu| {
        let folder = tempfile::tempdir()?;
        let container = folder.path().join("film.lfold").display().to_string();
        for set in ["sponza9", "glass"] {
            let manifest = Path::new(data).join(set).join("lightfield.json").display().to_string();
            lightfold(&[
                "encode", &manifest, "--clip", "--effort", "fast", "--frames", "0-1", "--quiet", "-o", &container,
            ])?;
            compare(gpu, &container, 2, None)?;
        }
        Ok(())
    })
}

/// An image larger than the device's limit is refused with a message, and rendering can be interrupted.
pub fn refusals() -> Result<(), Failed> {
    /// Requests an interruption immediately.
    struct Stopped;
    impl Monitor for Stopped {
        fn advance(&self, _steps: u64) {}
        fn interrupted(&self) -> bool {
            true
        }
    }
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        let mut case = pictures::cases().map_err(said)?.swap_remove(0);
        let mut renderer = GpuRenderer::new(gpu, case.field.coding);
        match renderer.render(&case.active(), &case.camera, &case.settings, &Stopped) {
            Err(Error::Interrupted) => {}
            other => return Err(format!("{:?}", other.map(|picture| picture.counters)).into()),
        }
        let face = case.field.views[0].faces.iter_mut().flatten().next().ok_or("no image")?;
        face.size = [gpu.device.limits().max_texture_dimension_2d + 1, 1];
        face.inverse_depth = vec![BACKGROUND; face.size[0] as usize];
        let refused =
            GpuRenderer::new(gpu, case.field.coding).upload(&case.active()).map_err(said).err().unwrap_or_default();
        match refused.contains(&gpu.info.name) && refused.contains("`device` cpu") {
            true => Ok(()),
            false => Err(format!("it said '{refused}'").into()),
        }
    })
}

/// Later images may be larger than all previous ones, or be the first with materials: textures are reallocated, and no image is
/// lost.
pub fn larger_images() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        for label in ["turned perspective images", "mirrors and glass"] {
            let mut cases = pictures::cases().map_err(said)?;
            cases.retain(|case| case.label == label);
            let case = cases.pop().ok_or(label)?;
            // The first request has one view with images, small and without materials.
            let mut start = case.clone();
            start.views.truncate(1);
            start.field.views[1..].iter_mut().for_each(|view| view.faces = Default::default());
            start.field.views[0].faces.iter_mut().flatten().for_each(|face| face.material = None);
            let mut renderer = GpuRenderer::new(gpu, start.field.coding);
            for case in [&start, &case] {
                let views = case.active();
                let on_device = renderer.render(&views, &case.camera, &case.settings, &Silent).map_err(said)?;
                let on_cpu = render(&views, &case.camera, &case.settings, &Silent).map_err(said)?;
                let agreement = Agreement::of(&on_device, &on_cpu).map_err(said)?;
                let (seen, size) = (case.views.len(), start.field.views[0].faces.iter().flatten().next());
                println!("{label}, {seen} views: {agreement:?}, first {:?}", size.map(|face| face.size));
                if agreement.mismatches() > 0 {
                    return Err(format!("{label}, {seen} views on {}: {agreement:?}", gpu.info.name).into());
                }
            }
        }
        Ok(())
    })
}

/// For light fields without materials, the kernel has no code for reflection and refraction, and their counters are zero.
pub fn no_effects() -> Result<(), Failed> {
    let plain = KERNELS.iter().filter(|kernel| kernel.entry == "render" && !kernel.name.contains("effects"));
    for kernel in plain {
        let source = kernel.source();
        if ["reflect", "refract", "materials"].iter().any(|word| source.contains(word)) {
            return Err(format!("{} has code for effects", kernel.name).into());
        }
    }
    with_gpu(|gpu| {
        let mut case = pictures::cases().map_err(|error| error.to_string())?.swap_remove(0);
        case.settings.specular = SpecularMode::Auto;
        let found = pictures::run(gpu, &case).map_err(|error| error.to_string())?;
        let counters = found.on_device.counters;
        let effects = [counters.secondary_rays, counters.normal_evals, counters.material_samples];
        let kernel = GpuRenderer::kernel(&case.active(), &case.settings);
        match effects == [0; 3] && !kernel.name.contains("effects") && counters.primary_rays > 0 {
            true => Ok(()),
            false => Err(format!("{}: {counters:?}", kernel.name).into()),
        }
    })
}
