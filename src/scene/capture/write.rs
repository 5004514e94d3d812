//! Writes the images of a capture. Their bytes depend only on the plan and the scene; images of an earlier run are kept.

use std::collections::BTreeMap;
use std::path::Path;

use super::images::Images;
use super::pixels::Viewpoint;
use super::plan::{CapturePlan, FrameRequest};
use super::reference::Reference;
use super::samples::SamplePattern;
use super::view::{Pass, PassSettings, capture_view_after};
use crate::{Scene, SceneAtTime};
use codec::error::{Error, Result};
use codec::image::{ChannelSelect, ColorPlane, DepthPlane, Plane, ReadLimits};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use footage::dataset::manifest::{Keep, MANIFEST_NAME, MaterialChannels, NORMAL_CHANNELS};
use footage::files::{FileFolder, FolderKind, OutputFolder};
use footage::image_files::exr;

/// Folder of an unfinished capture.
pub const UNFINISHED: FolderKind = FolderKind { suffix: ".capture.partial", state: ".capture.json" };
/// Maximum memory of images in progress, unless there is only one.
const MEMORY_BYTES: u64 = 1 << 30;
/// Maximum memory of the images of the first frame, from which others copy what is equal.
const REFERENCE_BYTES: u64 = MEMORY_BYTES / 4;
/// Bytes per pixel with all passes, twice: a copy is made while an image is written.
const PIXEL_BYTES: u64 = 2 * (6 + 4 + 12 + 12);
/// Maximum time samples of a scene in memory.
const MAX_TIME_SAMPLES: usize = 16;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureSummary {
    pub images: u64,
    pub kept_images: u64,
    /// Camera rays of all pixels, also of those copied from another frame; without reflected, refracted and shadow rays.
    pub rays: u64,
    pub bytes: u64,
    /// Minimum and maximum stored depth in metres; (+inf, 0) without any.
    pub depth_range_m: [f32; 2],
    /// Storage of colour in containers: half floats if a value exceeds 1, and for all built-in scenes, whose lights do.
    pub keep: Option<Keep>,
}

/// Statistics of a capture, as JSON.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct CaptureReport {
    /// Duration of the command.
    pub seconds: f64,
    /// Time until the scene was open.
    pub loading_seconds: f64,
    frames: u64,
    probes: usize,
    images: u64,
    resumed_images: u64,
    rays: u64,
    /// Excludes the time for opening the scene.
    pub rays_per_second: f64,
    bytes: u64,
    near_m: Option<f64>,
    far_m: Option<f64>,
}

impl CaptureSummary {
    pub fn report(&self, plan: &CapturePlan, loading_seconds: f64, seconds: f64) -> CaptureReport {
        let [near_m, far_m] = self.depth_range_m;
        let has_depth = near_m <= far_m;
        CaptureReport {
            seconds,
            loading_seconds,
            frames: plan.frames.count(),
            probes: plan.cameras.cameras.len(),
            images: self.images,
            resumed_images: self.kept_images,
            rays: self.rays,
            rays_per_second: self.rays as f64 / (seconds - loading_seconds).max(1e-9),
            bytes: self.bytes,
            near_m: has_depth.then_some(near_m.into()),
            far_m: has_depth.then_some(far_m.into()),
        }
    }

    const NOTHING: CaptureSummary = CaptureSummary {
        images: 0,
        kept_images: 0,
        rays: 0,
        bytes: 0,
        depth_range_m: [f32::INFINITY, 0.0],
        keep: None,
    };

    fn and(self, other: CaptureSummary) -> CaptureSummary {
        let ([near, far], [other_near, other_far]) = (self.depth_range_m, other.depth_range_m);
        CaptureSummary {
            images: self.images + other.images,
            kept_images: self.kept_images + other.kept_images,
            rays: self.rays + other.rays,
            bytes: self.bytes + other.bytes,
            depth_range_m: [near.min(other_near), far.max(other_far)],
            keep: self.keep.or(other.keep),
        }
    }

    fn of_color(color: &ColorPlane) -> CaptureSummary {
        let exceeds = color.data().iter().flatten().any(|value| value.to_f32() > 1.0);
        CaptureSummary { keep: exceeds.then_some(Keep::Hdr), ..Self::NOTHING }
    }

    fn of_depth(depth: &DepthPlane) -> CaptureSummary {
        let finite = depth.data().iter().filter(|depth| depth.is_finite());
        let range = finite.fold(Self::NOTHING.depth_range_m, |[near, far], &depth| [near.min(depth), far.max(depth)]);
        CaptureSummary { depth_range_m: range, ..Self::NOTHING }
    }

    /// Counts an image with these values.
    fn in_file(self, bytes: u64) -> CaptureSummary {
        CaptureSummary { images: 1, bytes, ..self }
    }
}

/// Passes of a frame request that are still to be captured.
struct Job {
    request: FrameRequest,
    passes: Vec<Pass>,
    /// Summary of the passes that exist already.
    kept: CaptureSummary,
}

impl CapturePlan {
    /// Captures everything into a folder, which is published when complete.
    pub fn write(&self, scene: &Scene, path: &Path, monitor: &dyn Monitor) -> Result<CaptureSummary> {
        let folder = OutputFolder::create(path)?;
        let summary = self.write_images(scene, &folder, monitor)?;
        let manifest = self.manifest_keeping(summary.keep)?;
        folder.write_bytes(Path::new(MANIFEST_NAME), manifest.to_json()?.as_bytes())?;
        folder.commit().map(|()| summary)
    }

    /// Captures the images of the plan's part, without the manifest. Existing images are kept if they can be read and have the
    /// right size. The monitor advances by one per image. At most sixteen time samples are in memory, at most 1 GiB of
    /// images or one face, and at most 256 MiB of the first frame.
    pub fn write_images(
        &self,
        scene: &Scene,
        folder: &dyn FileFolder,
        monitor: &dyn Monitor,
    ) -> Result<CaptureSummary> {
        let run = CaptureRun { plan: self, samples: SamplePattern::new(self.samples)?, folder, monitor };
        let is_built_in = matches!(scene, Scene::Procedural(_));
        let mut sum = CaptureSummary { keep: is_built_in.then_some(Keep::Hdr), ..CaptureSummary::NOTHING };
        let frames: Vec<u32> = self.frames.iter().filter(|&frame| self.requests(frame).next().is_some()).collect();
        let mut first = FirstFrame { is_open: self.keeps_first(), ..FirstFrame::default() };
        let static_scene = if scene.duration_s() > 0.0 { None } else { Some(scene.at(0.0)) };
        // The first frame is captured alone.
        let (alone, others) = frames.split_at(frames.len().min(1));
        for frames in alone.chunks(1).chain(others.chunks(self.frames_at_once(frames.len()))) {
            let requests = frames.iter().flat_map(|&frame| self.requests(frame)).collect();
            let jobs = try_map_at_once(requests, self.images_at_once(), |request| run.missing(request))?;
            let is_needed = |frame: u32| jobs.iter().any(|job| job.request.frame == frame && !job.passes.is_empty());
            let moves = |frame: u32| static_scene.is_none() && is_needed(frame);
            let at = |&frame: &u32| moves(frame).then(|| (frame, scene.at(f64::from(frame) / self.fps)));
            let mut times: BTreeMap<u32, SceneAtTime> = frames.iter().filter_map(at).collect();
            let done = try_map_at_once(jobs, self.images_at_once(), |job| {
                run.make(times.get(&job.request.frame).or(static_scene.as_ref()), &job, &first)
            })?;
            for (summary, view) in done {
                sum = sum.and(summary);
                first.views.extend(view);
            }
            if first.is_open {
                first.scene = times.pop_first().map(|(_, scene)| scene).or_else(|| static_scene.clone());
                first.is_open = false;
            }
        }
        Ok(sum)
    }

    /// True if the images of the first frame are kept for others to copy from.
    fn keeps_first(&self) -> bool {
        let pixels = self.size.map(u64::from).iter().product::<u64>();
        let views = self.image_count() / (self.passes.len() as u64 * self.frames.count()).max(1);
        views.saturating_mul(pixels).saturating_mul(PIXEL_BYTES / 2) <= REFERENCE_BYTES
    }

    /// Returns how many of `frames` frames are captured together, so that all threads have work.
    fn frames_at_once(&self, frames: usize) -> usize {
        let images = self.image_count() / (self.passes.len() * frames).max(1) as u64;
        (2 * rayon::current_num_threads()).div_ceil(images.max(1) as usize).clamp(1, MAX_TIME_SAMPLES)
    }

    fn images_at_once(&self) -> usize {
        let bytes = self.size.map(u64::from).iter().product::<u64>() * PIXEL_BYTES;
        let fit = usize::try_from(MEMORY_BYTES / bytes.max(1)).unwrap_or(usize::MAX);
        fit.clamp(1, rayon::current_num_threads().max(1))
    }
}

/// The first frame that is captured.
#[derive(Default)]
struct FirstFrame {
    /// True while its images are kept.
    is_open: bool,
    scene: Option<SceneAtTime>,
    views: Vec<(Viewpoint, Images)>,
}

impl FirstFrame {
    fn reference(&self, from: &Viewpoint) -> Option<Reference<'_>> {
        let (_, images) = self.views.iter().find(|(viewpoint, _)| viewpoint == from)?;
        Some(Reference { scene: self.scene.as_ref()?, images })
    }
}

struct CaptureRun<'a> {
    plan: &'a CapturePlan,
    samples: SamplePattern,
    folder: &'a dyn FileFolder,
    monitor: &'a dyn Monitor,
}

impl CaptureRun<'_> {
    fn missing(&self, request: FrameRequest) -> Result<Job> {
        let mut job = Job { request, passes: Vec::new(), kept: CaptureSummary::NOTHING };
        for &pass in &self.plan.passes {
            self.monitor.check()?;
            let path = self.folder.made(Path::new(&self.plan.file(&request, pass)?));
            match path.and_then(|path| Some((self.read(&path, pass)?, std::fs::metadata(path).ok()?.len()))) {
                None => job.passes.push(pass),
                Some((values, bytes)) => {
                    job.kept = job.kept.and(CaptureSummary { kept_images: 1, ..values.in_file(bytes) });
                    self.monitor.advance(1);
                }
            }
        }
        Ok(job)
    }

    /// Returns the values of an image; `None` if it cannot be read or has the wrong size.
    fn read(&self, path: &Path, pass: Pass) -> Option<CaptureSummary> {
        let limits = ReadLimits::default();
        let triple = |names| exr::read_material(path, names, &limits).ok().map(|plane| size_of(&plane));
        let (size, values) = match pass {
            Pass::Color => {
                let plane = exr::read_color(path, &ChannelSelect::Auto, &limits).ok()?;
                (size_of(&plane), CaptureSummary::of_color(&plane))
            }
            Pass::Depth => {
                let plane = exr::read_depth(path, &ChannelSelect::Auto, &limits).ok()?;
                (size_of(&plane), CaptureSummary::of_depth(&plane))
            }
            Pass::Normal => (triple(NORMAL_CHANNELS)?, CaptureSummary::NOTHING),
            Pass::Material => (triple(names(&MaterialChannels::default()))?, CaptureSummary::NOTHING),
        };
        (size == self.plan.size).then_some(values)
    }

    /// Captures and writes images. Also returns the images if others may copy from them.
    fn make(
        &self,
        scene: Option<&SceneAtTime>,
        job: &Job,
        first: &FirstFrame,
    ) -> Result<(CaptureSummary, Option<(Viewpoint, Images)>)> {
        let (Some(scene), false) = (scene, job.passes.is_empty()) else { return Ok((job.kept, None)) };
        self.monitor.check()?;
        let CapturePlan { depth, far_m, .. } = *self.plan;
        let settings = PassSettings { passes: &job.passes, samples: &self.samples, depth, far_m };
        let from = self.plan.viewpoint(&job.request);
        let images = capture_view_after(first.reference(&from), scene, &from, &settings, self.monitor)?;
        let mut sum = job.kept;
        for &pass in &job.passes {
            let mut values = CaptureSummary::NOTHING;
            let mut write = |path: &Path| {
                values = write_image(path, &images, pass)?;
                Ok(())
            };
            let bytes = self.folder.write_file(Path::new(&self.plan.file(&job.request, pass)?), &mut write)?;
            sum = sum.and(values.in_file(bytes));
            self.monitor.advance(1);
        }
        let pixels = self.plan.size.map(u64::from).iter().product::<u64>();
        sum.rays += pixels * settings.rays_per_pixel();
        Ok((sum, first.is_open.then_some((from, images))))
    }
}

fn size_of<T: Copy>(plane: &Plane<T>) -> [u32; 2] {
    [plane.width(), plane.height()]
}

fn names(channels: &MaterialChannels) -> [&str; 3] {
    [&channels.reflection, &channels.refraction, &channels.ior].map(String::as_str)
}

/// Writes an image file. Returns its values.
fn write_image(path: &Path, images: &Images, pass: Pass) -> Result<CaptureSummary> {
    let missing = || Error::invalid(format!("no {} was captured", pass.name()));
    match pass {
        Pass::Color => {
            let color = images.color.as_ref().ok_or_else(missing)?;
            exr::write_color(path, color)?;
            return Ok(CaptureSummary::of_color(color));
        }
        Pass::Depth => {
            let depth = images.depth.as_ref().ok_or_else(missing)?;
            exr::write_depth(path, depth)?;
            return Ok(CaptureSummary::of_depth(depth));
        }
        Pass::Normal => {
            exr::write_material(path, images.normal.as_ref().ok_or_else(missing)?, NORMAL_CHANNELS)?;
        }
        Pass::Material => {
            let channels = MaterialChannels::default();
            exr::write_material(path, images.material.as_ref().ok_or_else(missing)?, names(&channels))?;
        }
    }
    Ok(CaptureSummary::NOTHING)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::{DemoKind, DemoScene};
    use codec::image::{DepthKind, FrameRange, Projection};
    use codec::monitor::Silent;
    use footage::dataset::cameras::{CameraSet, PlacedCamera};
    use footage::files::{Kept, PartialFolder};

    fn plan() -> CapturePlan {
        CapturePlan {
            name: "a".into(),
            fps: 24.0,
            frames: FrameRange { first: 3, last: 5 },
            projection: Projection::Cubemap,
            size: [8, 8],
            cameras: CameraSet::new(vec![PlacedCamera::at([0.0, 1.5, 0.0])]),
            fov_y_deg: None,
            passes: Pass::ALL.to_vec(),
            samples: 2,
            depth: DepthKind::Distance,
            far_m: f64::INFINITY,
            part: None,
        }
    }

    fn scene() -> Scene {
        Scene::Procedural(DemoScene::new(DemoKind::Courtyard))
    }

    fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                found.extend(files(&path));
            } else {
                found.push((path.clone(), std::fs::read(&path).unwrap()));
            }
        }
        found.sort();
        found
    }

    fn begun(base: &Path) -> PartialFolder {
        PartialFolder::open(&base.join("cap"), UNFINISHED).unwrap()
    }

    #[test]
    fn keeps_sound_images_and_makes_all_others_again() {
        let base = tempfile::tempdir().unwrap();
        let whole = base.path().join("whole");
        let first = plan().write(&scene(), &whole, &Silent).unwrap();
        assert_eq!((first.images, first.kept_images, first.rays), (72, 0, 18 * 64 * 3));
        assert!(first.depth_range_m[0] > 0.9 && first.depth_range_m[1].is_finite());
        assert_eq!(files(&whole).len(), 73);
        let images = files(&whole).into_iter().filter(|(path, _)| path.extension().unwrap() == "exr");
        assert_eq!(first.bytes, images.map(|file| file.1.len() as u64).sum::<u64>());
        let mut folder = begun(base.path());
        folder.start_over("words").unwrap();
        plan().write_images(&scene(), &folder, &Silent).unwrap();
        // Wrong size, though the file matches its record.
        let small = |path: &Path| exr::write_depth(path, &DepthPlane::filled(4, 4, 1.0));
        folder.write_file(Path::new("probe_00/face_nx/depth.0005.exr"), &mut |path: &Path| small(path)).unwrap();
        folder.keep();
        let image = |name: &str| folder.work_path().join("files/probe_00/face_nx").join(name);
        // Missing, truncated, empty.
        std::fs::remove_file(image("color.0004.exr")).unwrap();
        std::fs::write(image("depth.0003.exr"), &std::fs::read(image("depth.0003.exr")).unwrap()[..100]).unwrap();
        std::fs::write(image("normal.0005.exr"), "").unwrap();
        drop(folder);
        let mut folder = begun(base.path());
        assert_eq!(folder.resume().unwrap(), Kept { intact: 69, damaged: 3 });
        let again = plan().write_images(&scene(), &folder, &Silent).unwrap();
        assert_eq!((again.images, again.kept_images), (72, 68));
        assert_eq!(again.depth_range_m, first.depth_range_m);
        assert_eq!((again.keep, first.keep), (Some(Keep::Hdr), Some(Keep::Hdr)));
        let manifest = plan().manifest_keeping(again.keep).unwrap().to_json().unwrap();
        folder.commit(Some((MANIFEST_NAME, manifest.as_bytes()))).unwrap();
        let relative = |folder: &str| {
            let folder = base.path().join(folder);
            let name = |(path, bytes): (PathBuf, Vec<u8>)| (path.strip_prefix(&folder).unwrap().to_owned(), bytes);
            files(&folder).into_iter().map(name).collect::<Vec<_>>()
        };
        assert_eq!(relative("cap"), relative("whole"));
    }

    #[test]
    fn bytes_do_not_depend_on_threads() {
        let captures = [1, 3].map(|threads| {
            let folder = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| plan().write(&scene(), folder.path(), &Silent)).unwrap();
            let relative =
                |(path, bytes): (PathBuf, Vec<u8>)| (path.strip_prefix(folder.path()).unwrap().to_owned(), bytes);
            files(folder.path()).into_iter().map(relative).collect::<Vec<_>>()
        });
        assert_eq!(captures[0], captures[1]);
    }

    #[test]
    fn images_at_work_fit_into_memory() {
        assert_eq!(CapturePlan { size: [16_384; 2], ..plan() }.images_at_once(), 1);
        assert!(plan().images_at_once() >= 1 && plan().frames_at_once(3) <= MAX_TIME_SAMPLES);
    }

    #[test]
    fn what_is_done_stays_when_it_is_stopped() {
        struct Stops(std::sync::atomic::AtomicU64);
        impl Monitor for Stops {
            fn advance(&self, steps: u64) {
                self.0.fetch_add(steps, std::sync::atomic::Ordering::Relaxed);
            }

            fn interrupted(&self) -> bool {
                self.0.load(std::sync::atomic::Ordering::Relaxed) >= 30
            }
        }
        let base = tempfile::tempdir().unwrap();
        let mut folder = begun(base.path());
        folder.start_over("words").unwrap();
        let stopped = plan().write_images(&scene(), &folder, &Stops(0.into()));
        assert!(matches!(stopped, Err(Error::Interrupted)));
        assert!((30..72).contains(&folder.keep()));
    }
}
