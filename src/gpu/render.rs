//! Renders a light field on a graphics device, with the same steps as `march::render` (CALF 6).
//!
//! Takes active views with their texels, a camera and settings; returns a picture in linear RGB with alpha, and counters. The
//! device keeps the texels (`texels`), so a picture only sends the texels that changed and a few words (`scene`).
//!
//! Colours and hits equal the CPU's up to single-precision rounding, which differs between devices: a ray that grazes a surface
//! may hit it on one device and miss it on another.

pub mod agreement;
pub mod backend;
pub mod depth_planes;
pub mod playback;
pub mod scene;
pub mod texels;

use std::collections::HashMap;
use std::time::{Duration, Instant};

use crate::Gpu;
use crate::render::backend::{GpuBackend, UnitCost};
use crate::render::scene::{FIRST_ROW_WORD, ImageId, ROWS_WORD, SceneRows};
use crate::render::texels::{DeviceTexels, Transferred};
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::math::Camera;
use codec::monitor::Monitor;
use kernels::Kernel;
use kernels::layout::{Face, View, words_of};
use render::march::render::has_secondary_rays;
use render::march::specular::secondary_rays::MIN_SHARE;
use render::march::{
    Acceleration, ActiveViews, Counters, MAX_BOUNCES, MIN_M, Proxies, Proxy, RenderSettings, Rendered, SphereFit,
    proxies_in_sight,
};
use render::rendered_image::RenderedImage;
use render::views::{ColorCoding, FaceTexels};

/// Alpha of a pixel whose loops were terminated by the device.
pub const GIVEN_UP: f32 = -1.0;

/// Width and height of a workgroup in pixels.
const TILE: u32 = 8;
type Counter = fn(&mut Counters) -> &mut u64;

const COUNTERS: usize = COUNTED.len();
/// Counters, with their names in `shaders/march/counters.wgsl`.
const COUNTED: [(&str, Counter); 8] = [
    ("PRIMARY_RAYS", |counters| &mut counters.primary_rays),
    ("MARCH_STEPS", |counters| &mut counters.march_steps),
    ("REFINE_STEPS", |counters| &mut counters.refine_steps),
    ("SECONDARY_RAYS", |counters| &mut counters.secondary_rays),
    ("NORMAL_EVALS", |counters| &mut counters.normal_evals),
    ("MATERIAL_SAMPLES", |counters| &mut counters.material_samples),
    ("HOLE_RAYS", |counters| &mut counters.hole_rays),
    ("BACKGROUND_RAYS", |counters| &mut counters.background_rays),
];
/// Maximum comparisons of ray samples with views in a dispatch of more than one row of workgroups: operating systems reset a
/// device that is busy for seconds. With secondary rays, the first dispatch is sized for the worst case, and the next ones grow
/// while they are short.
const WORK_OF_DEVICE: u64 = 1 << 31;
/// As [`WORK_OF_DEVICE`], for a software device, so that it responds to a stop request in time.
const WORK_OF_SOFTWARE: u64 = 1 << 25;
/// After a dispatch that took less than this, the next one may have twice as many rows.
const SHORT: Duration = Duration::from_millis(50);

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RenderCost {
    pub sending: Duration,
    /// Bytes sent: texels, and the input of decoding on the device.
    pub bytes_sent: u64,
    /// Bytes of texels that were decoded and copied on the device.
    pub bytes_copied: u64,
    pub units: UnitCost,
    /// CPU time for fitting refractive proxies.
    pub proxies: Duration,
    /// Time from the first dispatch to the end of the last one.
    pub marching: Duration,
    pub reading: Duration,
}

pub struct GpuRenderer<'a> {
    gpu: &'a Gpu,
    pub texels: DeviceTexels,
    /// Decodes depth and colour on the device; `None` if the CPU decodes them.
    pub backend: Option<GpuBackend<'a>>,
    /// Buffers of the last picture by name; reused if the size is the same.
    buffers: HashMap<&'static str, wgpu::Buffer>,
    cost: RenderCost,
}

struct Target {
    scene: wgpu::Buffer,
    pixels: wgpu::Buffer,
    counts: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl<'a> GpuRenderer<'a> {
    /// Creates a renderer for views in this coding. Nothing is sent until a picture needs it.
    pub fn new(gpu: &'a Gpu, coding: ColorCoding) -> GpuRenderer<'a> {
        let (texels, cost) = (DeviceTexels::new(coding), RenderCost::default());
        GpuRenderer { gpu, texels, backend: None, buffers: HashMap::new(), cost }
    }

    pub fn cost(&self) -> RenderCost {
        let units = self.backend.as_ref().map(GpuBackend::cost).unwrap_or_default();
        RenderCost { units, bytes_sent: self.cost.bytes_sent + units.bytes_sent, ..self.cost }
    }

    pub fn kernel(views: &ActiveViews<'_>, settings: &RenderSettings) -> &'static Kernel {
        match settings.acceleration {
            _ if has_secondary_rays(views, settings.specular) => &kernels::RENDER_EFFECTS,
            Acceleration::None => &kernels::RENDER,
            Acceleration::Pyramid => &kernels::RENDER_PYRAMID,
        }
    }

    /// Sends the missing texels of these views, as [`GpuRenderer::render`] does.
    pub fn upload(&mut self, views: &ActiveViews<'_>) -> Result<()> {
        let start = Instant::now();
        let Transferred { bytes_sent, bytes_copied } = self.texels.update(self.gpu, views, self.backend.as_ref())?;
        if bytes_sent + bytes_copied > 0 {
            // Wait for the transfer here; otherwise it would run with the first dispatch and count as marching.
            self.gpu.queue.submit([]);
            self.gpu.wait()?;
        }
        self.cost.bytes_sent += bytes_sent;
        self.cost.bytes_copied += bytes_copied;
        self.cost.sending += start.elapsed();
        Ok(())
    }

    /// Sends the missing texels of these views, and those of environment maps, which are new for each picture.
    fn upload_all(&mut self, views: &ActiveViews<'_>, proxies: &Proxies) -> Result<()> {
        for view in proxies.proxies.iter().map(|proxy| &proxy.environment) {
            for (face, texels) in view.faces.iter().enumerate() {
                let Some(FaceTexels { size: [width, height], .. }) = texels else { continue };
                for kind in [StreamKind::Depth, StreamKind::Color] {
                    self.texels.change(ImageId { probe: view.probe, face }, kind, [0, 0, *width, *height]);
                }
            }
        }
        let environments = proxies.proxies.iter().map(Proxy::environment_view);
        let all = views.views.iter().cloned().chain(environments).collect();
        self.upload(&ActiveViews { views: all, coding: views.coding })
    }

    /// Renders a picture. The monitor advances by one per row.
    pub fn render(
        &mut self,
        views: &ActiveViews<'_>,
        camera: &Camera,
        settings: &RenderSettings,
        monitor: &dyn Monitor,
    ) -> Result<Rendered> {
        monitor.check()?;
        let start = Instant::now();
        let proxies = match has_secondary_rays(views, settings.specular) {
            true => proxies_in_sight(&SphereFit, views, camera, monitor)?,
            false => Proxies::none(views.coding),
        };
        self.cost.proxies += start.elapsed();
        self.upload_all(views, &proxies)?;
        let origin = |image| self.texels.origin(image);
        let rows = SceneRows::new(views, &proxies, camera, settings, self.texels.pyramid_rows(), origin);
        let [width, height] = settings.size;
        let kernel = Self::kernel(views, settings);
        let target = self.target(kernel, &rows, settings.size)?;
        self.copy_greatest(views)?;
        let mut start = Instant::now();
        let [least, most] = rows_of_dispatch(self.gpu, views.views.len(), kernel, settings);
        let (mut first_row, mut count) = (0, least);
        while first_row < height && width > 0 {
            monitor.check()?;
            let begun = Instant::now();
            self.dispatch(kernel, &target, [width, height], [first_row, count])?;
            monitor.advance(count.min(height - first_row).into());
            first_row = first_row.saturating_add(count);
            count = if begun.elapsed() < SHORT { count.saturating_mul(2).min(most) } else { least };
        }
        self.cost.marching += start.elapsed();
        start = Instant::now();
        let pixels = self.gpu.read(&target.pixels, 4 * width as usize * height as usize)?;
        let counts = self.gpu.read(&target.counts, count_words(settings.size))?;
        let pixels = pixels.as_chunks::<4>().0.iter().map(|rgba| rgba.map(f32::from_bits));
        let image = RenderedImage::of_pixels(settings.size, pixels)?;
        let rendered = Rendered { image, counters: counters(&counts) };
        self.cost.reading += start.elapsed();
        let alphas = rendered.image.alpha.data();
        match alphas.iter().filter(|&&alpha| alpha == GIVEN_UP).count() {
            0 => Ok(rendered),
            missing => Err(Error::unsupported(format!(
                "{}: it aborted loops, and {missing} of {} pixels are missing: use fewer `samples` or `steps`, or \
                `device` cpu",
                self.gpu.info.name,
                alphas.len()
            ))),
        }
    }

    /// Returns a buffer of `words` words with undefined content.
    fn buffer(&mut self, label: &'static str, words: usize) -> Result<wgpu::Buffer> {
        if let Some(buffer) = self.buffers.get(label).filter(|buffer| buffer.size() == 4 * words as u64) {
            return Ok(buffer.clone());
        }
        // Drop the old buffer first: both may not fit in memory.
        self.buffers.remove(label);
        let buffer = self.gpu.buffer(label, words, wgpu::BufferUsages::empty())?;
        self.buffers.insert(label, buffer.clone());
        Ok(buffer)
    }

    /// Creates the buffers of a picture. The kernel writes every word of those that are read back.
    fn target(&mut self, kernel: &'static Kernel, rows: &SceneRows, [width, height]: [u32; 2]) -> Result<Target> {
        let gpu = self.gpu;
        let mut filled = |label: &'static str, words: &[u32], least: usize| {
            let buffer = self.buffer(label, words.len().max(least))?;
            gpu.write(label, &buffer, words)?;
            Ok::<_, Error>(buffer)
        };
        let scene = filled("scene", &words_of(&[rows.scene]), 0)?;
        filled("views", &words_of(&rows.views), View::WORDS)?;
        filled("faces", &words_of(&rows.faces), Face::WORDS)?;
        filled("distances_m", &words_of(&rows.distances_m), 1)?;
        let pixels = self.buffer("pixels", 4 * width as usize * height as usize)?;
        let counts = self.buffer("counts", count_words([width, height]))?;
        let pipeline = gpu.pipeline(kernel)?;
        let view = |name| Some((name, self.texels.view(name)?));
        let textures: HashMap<&str, _> = kernel.bindings.iter().filter_map(|binding| view(binding.name)).collect();
        let resource = |name: &str| match textures.get(name) {
            Some(texture) => Some(wgpu::BindingResource::TextureView(texture)),
            None => self.buffers.get(name).map(wgpu::Buffer::as_entire_binding),
        };
        let group = gpu.guard(kernel.name, || gpu.bind(&pipeline, resource))?;
        Ok(Target { scene, pixels, counts, group })
    }

    /// Copies the maximum inverse depths of views decoded on the device into their `View` rows; the CPU does not know them.
    fn copy_greatest(&self, views: &ActiveViews<'_>) -> Result<()> {
        let (Some(backend), Some(words)) = (&self.backend, self.buffers.get("views")) else { return Ok(()) };
        let decoded = views.views.iter().enumerate().filter_map(|(at, active)| {
            let planes = backend.planes(active.view.probe)?;
            (planes.has_greatest() && active.view.near_m >= MIN_M).then_some((at, planes))
        });
        self.gpu.submit("views", |encoder| {
            for (at, planes) in decoded {
                let from = 4 * u64::from(depth_planes::GREATEST_WORD);
                let to = 4 * (at * View::WORDS + scene::GREATEST_WORD) as u64;
                encoder.copy_buffer_to_buffer(&planes.planes, from, words, to, 4);
            }
        })
    }

    fn dispatch(
        &self,
        kernel: &'static Kernel,
        target: &Target,
        [width, height]: [u32; 2],
        [first_row, rows]: [u32; 2],
    ) -> Result<()> {
        let (gpu, rows) = (self.gpu, rows.min(height - first_row));
        let pipeline = gpu.pipeline(kernel)?;
        gpu.compute(kernel.name, |pass| {
            for (word, value) in [(FIRST_ROW_WORD, first_row), (ROWS_WORD, rows)] {
                gpu.queue.write_buffer(&target.scene, 4 * word as u64, &value.to_le_bytes());
            }
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &target.group, &[]);
            pass.dispatch_workgroups(width.div_ceil(TILE), rows.div_ceil(TILE), 1);
        })?;
        gpu.wait()
    }
}

/// Returns the number of counter words of a picture: one set per workgroup.
fn count_words([width, height]: [u32; 2]) -> usize {
    width.div_ceil(TILE) as usize * height.div_ceil(TILE) as usize * COUNTERS
}

/// Returns the initial and maximum number of rows per dispatch, as multiples of a workgroup: for the maximum number of
/// secondary rays, and for none.
fn rows_of_dispatch(gpu: &Gpu, views: usize, kernel: &Kernel, settings: &RenderSettings) -> [u32; 2] {
    let points = settings.steps.distances_m.len() as u64 + u64::from(settings.steps.refine());
    let rays = u64::from(settings.samples.max(1)).pow(2) * u64::from(settings.size[0].max(1));
    let row = (rays * points).saturating_mul(views.max(1) as u64);
    let work = if gpu.info.is_software() { WORK_OF_SOFTWARE } else { WORK_OF_DEVICE };
    let secondary =
        if kernel.name == kernels::RENDER_EFFECTS.name { max_secondary_rays(settings.max_bounces) } else { 0 };
    [1 + secondary, 1].map(|rays| {
        let groups = work / row.saturating_mul(rays).saturating_mul(TILE.into()).max(1);
        groups.clamp(1, u64::from(u32::MAX / TILE)) as u32 * TILE
    })
}

/// Returns the maximum number of secondary rays per camera ray. A surface emits up to four rays and searches for the back of a
/// solid along up to three. The number of surfaces per bounce is at most `1 / MIN_SHARE`, because rays with a smaller share are
/// not traced.
fn max_secondary_rays(max_bounces: u32) -> u64 {
    let most = (1.0 / MIN_SHARE) as u64;
    let surfaces = |bounce: u32| most.min(4u64.pow(bounce));
    (0..max_bounces.min(MAX_BOUNCES)).map(|bounce| 3 * surfaces(bounce) + surfaces(bounce + 1)).sum()
}

fn counters(counts: &[u32]) -> Counters {
    let mut sums = Counters::default();
    for (&count, (_, counter)) in counts.iter().zip(COUNTED.iter().cycle()) {
        *counter(&mut sums) += u64::from(count);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secondary_rays_are_bounded() {
        // 85 surfaces cast 4 + 16 + 64 + 256 rays, and each casts three rays through a solid.
        assert_eq!(max_secondary_rays(0), 0);
        assert_eq!(max_secondary_rays(1), 3 + 4);
        assert_eq!(max_secondary_rays(4), 3 * 85 + 340);
        assert_eq!(max_secondary_rays(5), max_secondary_rays(4) + 4 * 256);
        assert_eq!(max_secondary_rays(u32::MAX), max_secondary_rays(MAX_BOUNCES));
    }
}
