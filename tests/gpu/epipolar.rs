//! Interpolated views on the GPU, which equal those of the CPU bit for bit except in highlights: scenes, sizes, numbers of views,
//! sources, commands.

use std::path::Path;

use codec::image::ReadLimits;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, Acquisition, Hierarchy, StoppingRule, acquire};
use epipolar::backend::{Backend, Cpu};
use epipolar::coalesce::Coalescing;
use epipolar::drawing::{MAX_DRAWN, PixelWindow, TriangleDrawing};
use epipolar::erosion::Moves;
use epipolar::interpolate::InterpolateSettings;
use epipolar::source::SourceView;
use epipolar::views::{OutputViews, Spread};
use footage::image_files::exr;
use gpu::epipolar::GpuInterpolator;
use gpu::render::agreement::Agreement;
use gpu::selftest::slices::{self, InterpolationCase};
use gpu::selftest::triangles;
use gpu::triangles::{GpuTriangles, Readback};
use gpu::{Gpu, device};
use libtest_mimic::Failed;
use lightfold::Error;
use render::rendered_image::RenderedImage;
use scene::capture::SamplePattern;
use scene::{Play, Scene};

use crate::{lightfold, with_gpu};

/// Views of a built-in scene, and the settings of their acquisition.
struct Setup {
    scene: &'static str,
    size: [u32; 2],
    count: u32,
    spread: Spread,
    focus_m: f64,
    acquisition: Acquisition,
}

const DUAL: Setup = Setup {
    scene: "courtyard",
    size: [61, 40],
    count: 9,
    spread: Spread::Baseline(0.6),
    focus_m: f64::INFINITY,
    acquisition: Acquisition::Dual,
};

impl Setup {
    fn views(&self) -> Result<OutputViews, Error> {
        let camera =
            Camera::look_at([0.0, 1.5, 0.2].into(), [2.0, 1.3, 0.0].into(), [0.0, 1.0, 0.0].into(), Lens::new(60.0))?;
        let camera = camera.with_aspect(f64::from(self.size[0]) / f64::from(self.size[1]));
        OutputViews::new(camera, self.size, self.count, self.spread, self.focus_m)
    }

    fn sources(&self, views: &OutputViews) -> Result<Vec<SourceView>, Error> {
        let scene = Scene::open(self.scene, Play::All)?.0.at(0.0);
        let settings =
            AcquireSettings { acquisition: self.acquisition, ..AcquireSettings::new(SamplePattern::new(1)?) };
        Ok(acquire(&scene, views, &settings, (&Cpu, &Silent))?.0)
    }

    /// Compares the GPU with the CPU, with and without coalescing. `change` is applied to the sources first.
    fn same(&self, gpu: &Gpu, change: impl FnOnce(&mut Vec<SourceView>)) -> Result<(), Failed> {
        let said = |error: Error| error.to_string();
        let views = self.views().map_err(said)?;
        let mut sources = self.sources(&views).map_err(said)?;
        change(&mut sources);
        for coalesce in [Coalescing::Off, Coalescing::Disparity(1.5)] {
            let settings = InterpolateSettings { coalesce, ..InterpolateSettings::default() };
            let label = format!("{} {:?} {} {coalesce:?}", self.scene, self.size, self.count);
            let case = InterpolationCase { label, views: views.clone(), sources: sources.clone(), settings };
            // All scanlines and views at once, and in several parts.
            for on_device in [GpuInterpolator::new(gpu), GpuInterpolator::with_limits(gpu, 1500, 700)] {
                let found = slices::run(&on_device, &case).map_err(said)?;
                if found.mismatches > 0 {
                    return Err(format!("{found:?} on {}", gpu.info.name).into());
                }
            }
        }
        Ok(())
    }
}

/// Tests scenes with highlights, mirrors, glass, leaves and plain walls; parallel and sheared views; all kinds of sources.
pub fn scenes() -> Result<(), Failed> {
    with_gpu(|gpu| {
        for scene in ["courtyard", "interior", "mirrors", "cornell"] {
            for acquisition in [Acquisition::Center, Acquisition::Dual, Acquisition::Hierarchical] {
                Setup { scene, acquisition, ..DUAL }.same(gpu, |_| {})?;
            }
            Setup { scene, spread: Spread::Cone(30.0), focus_m: 2.0, ..DUAL }.same(gpu, |_| {})?;
        }
        Ok(())
    })
}

/// Tests one pixel, one column, one row, as many columns as a workgroup and one more, and 1, 2 and 300 views.
pub fn sizes() -> Result<(), Failed> {
    with_gpu(|gpu| {
        for size in [[1, 1], [1, 33], [77, 1], [1024, 3], [1025, 2], [2111, 2]] {
            Setup { size, ..DUAL }.same(gpu, |_| {})?;
        }
        for count in [1, 2, 300] {
            Setup { scene: "interior", count, size: [45, 17], ..DUAL }.same(gpu, |_| {})?;
        }
        Setup { spread: Spread::Baseline(0.0), ..DUAL }.same(gpu, |_| {})
    })
}

/// Tests duplicate sources, for which the order of lines decides, reversed sources, and no sources.
pub fn sources() -> Result<(), Failed> {
    with_gpu(|gpu| {
        DUAL.same(gpu, |sources| *sources = [sources.clone(), sources.clone()].concat())?;
        DUAL.same(gpu, |sources| sources.reverse())?;
        DUAL.same(gpu, Vec::clear)
    })
}

/// `interpolate` writes the same files on both devices, and its report names the device.
pub fn commands() -> Result<(), Failed> {
    let names: Vec<String> = device::list().into_iter().map(|info| info.name).collect();
    let folder = tempfile::tempdir()?;
    for scene in ["courtyard", "interior"] {
        let run = |on: &str| -> Result<serde_json::Value, Failed> {
            let pattern = folder.path().join(scene).join(on).join("%02d.exr").display().to_string();
            let views = ["--views", "5", "--baseline", "0.4", "--size", "50x31", "--samples", "1", "--device", on];
            let from = ["interpolate", scene, "--eye", "0,1.5,0.2", "--look-at", "2,1.3,0", "--json", "--quiet"];
            Ok(serde_json::from_str(&lightfold(&[&from[..], &views, &["-o", &pattern]].concat())?)?)
        };
        let [on_gpu, on_cpu] = [run("gpu")?, run("cpu")?];
        if on_cpu["device"] != "cpu" || !names.iter().any(|name| on_gpu["device"] == name.as_str()) {
            return Err(format!("{} and {}", on_gpu["device"], on_cpu["device"]).into());
        }
        for key in ["lines", "coalesced_pixels", "fragments", "hole_pixels", "traced_pixels", "splits"] {
            if on_gpu["counters"][key] != on_cpu["counters"][key] {
                return Err(format!("{scene}, {key}: {} and {}", on_gpu["counters"], on_cpu["counters"]).into());
            }
        }
        let file = |on: &str, view: usize| folder.path().join(scene).join(on).join(format!("{view:02}.exr"));
        let has_highlights = on_gpu["counters"]["splits"] != 0;
        for view in 0..5 {
            let [found, expected] = ["gpu", "cpu"].map(|on| file(on, view));
            // Highlights are computed in floats on the GPU; all other radiance is equal bit for bit.
            let agrees = match has_highlights {
                true => {
                    let [found, expected] = [found, expected].map(|path| light_of(&path));
                    let agreement = Agreement::of_images(&found?, &expected?, [0; 2]);
                    agreement.map_err(|error| error.to_string())?.mismatches() == 0
                }
                false => std::fs::read(found)? == std::fs::read(expected)?,
            };
            if !agrees {
                return Err(format!("{scene}, view {view} differs").into());
            }
        }
    }
    rasterized(folder.path())?;
    refusals(folder.path())
}

fn light_of(path: &Path) -> Result<RenderedImage, Failed> {
    let read = exr::read_rgba(path, &ReadLimits::default()).map_err(|error| error.to_string())?;
    let color = read.map(|[red, green, blue, _]| [red, green, blue].map(|half| half.to_f32()));
    Ok(RenderedImage::new(color, read.map(|[.., alpha]| alpha.to_f32())))
}

/// Erosion is equal on both devices for one scanline, wide images and no baseline, and a hierarchical acquisition by erosion
/// places the same sources.
pub fn erosion() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        let (on_device, seen) = (GpuInterpolator::new(gpu), Setup { scene: "interior", ..DUAL });
        for (size, spread) in [
            (DUAL.size, DUAL.spread),
            ([1, 1], DUAL.spread),
            ([333, 1], DUAL.spread),
            ([257, 9], Spread::Baseline(1.5)),
            (DUAL.size, Spread::Baseline(0.0)),
        ] {
            let setup = Setup { size, spread, ..seen };
            let views = setup.views().map_err(said)?;
            let sources = setup.sources(&views).map_err(said)?;
            let last = sources.len() - 1;
            let moves = Moves::between(&views, [&sources[0], &sources[last]]);
            let [found, expected] = [&on_device as &dyn Backend, &Cpu].map(|backend| backend.eroded(&moves));
            let (found, expected) = (found.map_err(said)?, expected.map_err(said)?);
            if found != expected || size == [257, 9] && expected == 0 {
                return Err(format!("{size:?} {spread:?}: {found} eroded pixels and not {expected}").into());
            }
        }
        let hierarchy = Hierarchy { stop: StoppingRule::Erosion, hole_threshold_percent: 0.01, ..Hierarchy::default() };
        let settings = AcquireSettings {
            acquisition: Acquisition::Hierarchical,
            hierarchy,
            ..AcquireSettings::new(SamplePattern::new(1).map_err(said)?)
        };
        let scene = Scene::open(seen.scene, Play::All).map_err(said)?.0.at(0.0);
        let views = Setup { spread: Spread::Baseline(1.5), ..seen }.views().map_err(said)?;
        let places = |backend: &dyn Backend| -> Result<Vec<f64>, Failed> {
            let (sources, _) = acquire(&scene, &views, &settings, (backend, &Silent)).map_err(said)?;
            Ok(sources.iter().map(|source| source.offset_m).collect())
        };
        let (found, expected) = (places(&on_device)?, places(&Cpu)?);
        if found != expected || expected.len() < 3 {
            return Err(format!("sources at {found:?} and not {expected:?}").into());
        }
        Ok(())
    })
}

/// Layers of triangles are equal whether all pixels or only the active ones are read back.
pub fn compaction() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        let mut behind = 0;
        for case in triangles::cases().map_err(said)? {
            let [width, height] = case.views.size;
            let from = case.views.viewpoint(0.1);
            for window in [
                PixelWindow { columns: 0..width as i32, rows: 0..height },
                PixelWindow { columns: -7..width as i32 + 30, rows: 3..4 },
                PixelWindow { columns: 5..6, rows: 0..height },
            ] {
                let layers = |readback: Readback| {
                    let triangles = GpuTriangles::new(gpu, &case.scene)?.with_readback(readback);
                    triangles.draw(&from, &window, [0.5; 2], MAX_DRAWN)
                };
                let whole = layers(Readback::Whole).map_err(said)?;
                for readback in [Readback::Compacted, Readback::BySize] {
                    if layers(readback).map_err(said)? != whole {
                        return Err(format!("{}, {window:?}: {readback:?} differs", case.label).into());
                    }
                }
                behind += whole.map_or(0, |layers| layers.len().saturating_sub(1));
            }
        }
        if behind > 20 { Ok(()) } else { Err(format!("only {behind} layers behind the first").into()) }
    })
}

/// Checks that triangles are drawn for source views and for all views, and that the quality is that of ray casting within small
/// bounds.
fn rasterized(folder: &Path) -> Result<(), Failed> {
    let scene = folder.join("room.obj");
    std::fs::write(&scene, room())?;
    let scene = scene.display().to_string();
    let from = ["interpolate", &scene, "--eye", "0.1,0.2,0.3", "--look-at", "-2,0.1,-1.5", "--views", "3"];
    let views = ["--baseline", "0.3", "--size", "90x60", "--samples", "4", "--null", "--json", "--quiet"];
    let run = |more: &[&str]| -> Result<serde_json::Value, Failed> {
        Ok(serde_json::from_str(&lightfold(&[&from[..], &views, more].concat())?)?)
    };
    let on_gpu = ["--device", "gpu", "--rasterize"];
    for acquire in ["dual", "center", "hierarchical"] {
        let report = |more: &[&str]| run(&[&["--acquire", acquire, "--compare"][..], more].concat());
        let (drawn, cast) = (report(&on_gpu)?, report(&[])?);
        let figure = |report: &serde_json::Value, path: &str| {
            report.pointer(path).and_then(serde_json::Value::as_f64).ok_or(format!("no {path}"))
        };
        for (path, bound) in [("/quality/psnr_db/mean", 0.3), ("/quality/ssim/mean", 0.003)] {
            // Above 50 dB, a few edge pixels dominate the PSNR.
            let [found, expected] = [figure(&drawn, path)?, figure(&cast, path)?].map(|figure| figure.min(50.0));
            if (found - expected).abs() > bound {
                return Err(format!("{acquire} {path}: {found}, of rays {expected}").into());
            }
        }
        let [found, expected] = [&drawn, &cast].map(|report| figure(report, "/counters/source_pixels"));
        let (found, expected) = (found?, expected?);
        if (found / expected - 1.0).abs() > 0.01 || expected == 0.0 {
            return Err(format!("{acquire}: {found} source pixels, of rays {expected}").into());
        }
    }
    let all = run(&[&["--brute-force"], &on_gpu[..]].concat())?;
    if all["brute_force"] != true || all["device"] == "cpu" {
        return Err(format!("{all}").into());
    }
    Ok(())
}

/// Returns the inside of a box with slanted boards in it, as OBJ.
fn room() -> String {
    let mut text = String::new();
    let mut quads = 0;
    let mut quad = |corners: [[f64; 3]; 4]| {
        corners.iter().for_each(|[x, y, z]| text.push_str(&format!("v {x} {y} {z}\n")));
        let first = 4 * quads + 1;
        text.push_str(&format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3));
        quads += 1;
    };
    for side in [-3.0, 3.0] {
        quad([[side, -3.0, -3.0], [side, 3.0, -3.0], [side, 3.0, 3.0], [side, -3.0, 3.0]]);
        quad([[-3.0, side, -3.0], [3.0, side, -3.0], [3.0, side, 3.0], [-3.0, side, 3.0]]);
        quad([[-3.0, -3.0, side], [3.0, -3.0, side], [3.0, 3.0, side], [-3.0, 3.0, side]]);
    }
    for board in 0..7 {
        let x = -2.5 + 0.3 * f64::from(board);
        let z = -2.0 + 0.25 * f64::from(board);
        quad([[x, -1.0, z], [x + 0.15, -1.0, z + 0.1], [x + 0.2, 1.2, z + 0.05], [x + 0.05, 1.2, z - 0.05]]);
    }
    text
}

/// Checks that options that the GPU does not support are refused.
fn refusals(folder: &Path) -> Result<(), Failed> {
    let out = folder.join("refused.png").display().to_string();
    let from = ["interpolate", "cornell", "--eye", "0,1,0", "--look-at", "2,1,0", "--views", "2", "--baseline", "0.1"];
    let on = ["--device", "gpu", "-o", &out];
    for (options, words) in [(&["--brute-force"][..], "--rasterize"), (&["--memory", "1G"], "--memory")] {
        let refused = match lightfold(&[&from[..], &on, options].concat()) {
            Ok(text) => return Err(format!("{options:?} was accepted: {text}").into()),
            Err(error) => error.message().unwrap_or_default().to_owned(),
        };
        if !refused.contains(words) || Path::new(&out).exists() {
            return Err(format!("{options:?}: it said '{refused}'").into());
        }
    }
    Ok(())
}
