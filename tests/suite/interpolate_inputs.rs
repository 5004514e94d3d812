//! `interpolate` of animated scenes, grids of views and containers, and its camera files for `capture`.

use std::path::Path;

use codec::image::ReadLimits;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{
    AcquireSettings, Acquisition, Hierarchy, SourcePlacement, StoppingRule, acquire, hierarchical,
};
use epipolar::backend::Cpu;
use epipolar::views::{OutputViews, Spread};
use footage::image_files::{exr, png};
use scene::capture::SamplePattern;
use scene::{Play, Scene, SceneAtTime};
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};

const LINE: &str = "interpolate interior --eye 0,1.5,0 --look-at 2,1.4,0 --size 24x32 --samples 1";

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

#[test]
fn frames_are_sequences_of_views_or_of_quilts() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let line = format!("{} --views 4 --baseline 0.3", LINE.replace("interior", "mirrors"));
    let said = report(&format!("{line} --frames 1-2 --quilt 2x2 -o q.%04d.png --json"), at);
    assert_eq!((&said["views"], &said["frames"]), (&Value::from(8), &Value::from(2)), "{said}");
    fine(&format!("{line} --frames 1-2 -o %V/v.%02d.png"), at);
    // The frames differ, and each equals the frame rendered alone.
    let quilts = ["0001", "0002"].map(|frame| bytes(&at.join(format!("q.{frame}_qs2x2a0.75.png"))));
    assert!(quilts[0] != quilts[1]);
    fine(&format!("{line} --frames 2 --quilt 2x2 -o one.png"), at);
    assert!(bytes(&at.join("one_qs2x2a0.75.png")) == quilts[1]);
    fine(&format!("{line} --frames 2 --view-range 3 -o last.png"), at);
    assert!(bytes(&at.join("0003/v.02.png")) == bytes(&at.join("last.png")));
    // `--reduce-layers` removes layers that cover few pixels from later frames.
    let reduced = report(&format!("{line} --frames 0-3 --layers 4 --reduce-layers 50,90 --null --json"), at);
    let all = report(&format!("{line} --frames 0-3 --layers 4 --null --json"), at);
    let pixels = |said: &Value| said["counters"]["source_pixels"].as_u64().unwrap();
    assert!(pixels(&reduced) < pixels(&all), "{reduced} {all}");
    assert!(refused(&format!("{line} --frames 0-1 -o q.png"), at).contains("several frames"));
    assert!(refused(&format!("{line} --frames 0-1 --quilt 2x2 -o %V/%02d.png"), at).contains("a quilt"));
}

#[test]
fn rows_of_a_grid_are_lines_at_their_heights() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let focus = "--views 3 --baseline 0.3 --focus 2";
    let said = report(&format!("{LINE} {focus} --rows 3 --baseline-y 0.2 --compare --null --json"), at);
    assert!(said["views"] == 9 && said["quality"]["psnr_db"]["min"].as_f64().unwrap() > 25.0, "{said}");
    // `--grid rows` interpolates each row as a line of views.
    fine(&format!("{LINE} {focus} --rows 3 --baseline-y 0.2 --grid rows -o plain/%d.png"), at);
    fine(&format!("{LINE} {focus} -o middle/%d.png"), at);
    fine(&format!("{LINE} {focus} --rows 3 --baseline-y 0.2 -o v/%d.png"), at);
    for view in 0..3 {
        let [of_grid, of_line] =
            [format!("plain/{}.png", 3 + view), format!("middle/{view}.png")].map(|name| bytes(&at.join(name)));
        assert!(of_grid == of_line, "view {view}");
    }
    // A range of views has the pictures of the whole grid. A quilt stores the rows from bottom to top.
    fine(&format!("{LINE} {focus} --rows 3 --baseline-y 0.2 --view-range 2-6 -o part/%d.png"), at);
    assert!(bytes(&at.join("part/6.png")) == bytes(&at.join("v/6.png")));
    assert!(!at.join("part/7.png").exists() && !at.join("part/1.png").exists());
    fine(&format!("{LINE} {focus} --rows 3 --baseline-y 0.2 -o q.png"), at);
    fine("quilt v/%d.png --quilt 3x3 -o joined.png", at);
    assert!(bytes(&at.join("q_qs3x3a0.75.png")) == bytes(&at.join("joined_qs3x3a0.75.png")));
    assert!(
        refused(&format!("{LINE} --views 100 --baseline 1 --rows 64 --baseline-y 1 --null"), at).contains("6400 views")
    );
}

#[test]
fn columns_between_two_rows_are_close_to_rows_of_their_own_from_fewer_sources() {
    let folder = TempDir::new().unwrap();
    let line = "interpolate courtyard --eye=-1.5,1.4,-1.5 --look-at=-1.3,1.2,4 --size 112x80 --samples 4 --views 5 --baseline 0.6 \
                --rows 5 --baseline-y 0.6 --compare --null --json";
    let of = |grid: &str| report(&format!("{line} --grid {grid}"), folder.path());
    let [columns, rows] = ["columns", "rows"].map(of);
    let mean_db = |said: &Value| said["quality"]["psnr_db"]["mean"].as_f64().unwrap();
    assert!(mean_db(&columns) > mean_db(&rows) - 1.5, "{columns} {rows}");
    let sources = |said: &Value| said["counters"]["source_views"].as_u64().unwrap();
    assert_eq!([sources(&columns), sources(&rows)], [4, 10]);
    // Surfaces behind the pixels of the outer rows become visible between these rows; one layer leaves holes.
    let first = report(&format!("{line} --layers 1"), folder.path());
    let holes = |said: &Value| said["counters"]["hole_pixels"].as_u64().unwrap();
    assert!(holes(&first) > 2 * holes(&columns).max(20), "{first} {columns}");
    let focused = report(&format!("{line} --focus 2"), folder.path());
    assert!(mean_db(&focused) > mean_db(&rows) - 1.5, "{focused}");
}

#[test]
fn capture_renders_the_views_of_the_cameras_that_interpolate_writes() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let views = "--views 3 --baseline 0.3 --focus 2 --rows 2 --baseline-y 0.1 --brute-force";
    fine(&format!("{LINE} {views} -o v/%04d.exr --cameras-out cams.json"), at);
    fine(
        "capture interior --cameras cams.json --projection perspective --size 24x32 --samples 1 --frames 0 -o truth",
        at,
    );
    for view in 0..6 {
        let limits = ReadLimits::default();
        let made = exr::read_rgba(&at.join(format!("v/{view:04}.exr")), &limits).unwrap();
        let captured = exr::read_rgba(&at.join(format!("truth/probe_{view:04}/color.0000.exr")), &limits).unwrap();
        let changed = made.data().iter().zip(captured.data()).filter(|(a, b)| a != b).count();
        // The file stores the field of view in degrees, rounded, so a few pixels may differ.
        assert!(changed <= 8, "view {view}: {changed}");
    }
    // The manifest stores the shift, so its probes can be used as cameras again.
    fine("capture interior --cameras truth --projection perspective --size 24x32 --samples 1 --frames 0 -o again", at);
    let name = "probe_0002/color.0000.exr";
    let [once, twice] =
        ["truth", "again"].map(|set| exr::read_rgba(&at.join(set).join(name), &ReadLimits::default()).unwrap());
    let changed = once.data().iter().zip(twice.data()).filter(|(a, b)| a != b).count();
    assert!(changed <= 8, "{changed}");
    // Its images can be sources, because their windows have one focus.
    let between = "interpolate truth --probe 0002,0000 --views 3";
    let said = report(&format!("{between} -o between/%d.exr --json"), at);
    let focus_m = said["focus_m"].as_f64().unwrap();
    assert!((focus_m - 2.0).abs() < 1e-3 && (said["baseline_m"].as_f64().unwrap() - 0.3).abs() < 1e-9, "{said}");
    for (view, probe) in [(0, "0000"), (1, "0001"), (2, "0002")] {
        let [made, captured] = [format!("between/{view}.exr"), format!("truth/probe_{probe}/color.0000.exr")]
            .map(|name| exr::read_rgba(&at.join(name), &ReadLimits::default()).unwrap());
        let wrong =
            made.data().iter().zip(captured.data()).filter(|(a, b)| (a[0].to_f32() - b[0].to_f32()).abs() > 0.1);
        let wrong = wrong.count();
        assert!(if view == 1 { wrong < 40 } else { made == captured }, "view {view}: {wrong}");
    }
    assert!(refused(&format!("{between} --focus 3 --null"), at).contains("is 2.0"));
    assert!(refused("interpolate truth --probe 0000,0001,0005 --views 3 --null", at).contains("off the line"));
    assert!(refused("capture interior --cameras cams.json --size 8 -o cube", at).contains("shift"));
    assert!(
        refused(&format!("{LINE} --views 2 --baseline 0.3 -o cams.json --cameras-out cams.json"), at)
            .contains("cams.json")
    );
}

#[test]
fn containers_are_rendered_at_the_places_of_sources() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine("capture interior --position=0,1.5,0 --position=0.2,1.6,0.3 --size 48 --samples 1 --frames 0 -o room", at);
    fine("encode room --clip -o room.lfold -q", at);
    let line =
        "interpolate room.lfold --eye 0.1,1.55,0.1 --look-at 2,1.4,0 --size 24x32 --samples 1 --views 5 --baseline 0.1";
    let said = report(&format!("{line} -o v/%d.png --compare --json"), at);
    let quality = &said["quality"]["psnr_db"];
    assert!(quality["mean"].as_f64().unwrap() > 20.0, "{said}");
    assert_eq!(said["sources"].as_array().unwrap().len(), 2);
    // The first and last views equal rendered views.
    fine(&format!("{line} --brute-force -o rendered/%d.png"), at);
    for view in [0, 4] {
        let read =
            |folder: &str| png::read_rgba8(&at.join(format!("{folder}/{view}.png")), &ReadLimits::default()).unwrap();
        let (made, rendered) = (read("v"), read("rendered"));
        let seen = rendered.data().iter().zip(made.data()).filter(|(pixel, _)| pixel[3] == 255);
        assert!(seen.clone().count() > 600);
        // Source pixels store colour as half floats, so codes may differ by 1.
        let is_same = |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(seen.into_iter().all(is_same), "view {view}");
    }
    let center = report(&format!("{line} --acquire center --null --json"), at);
    assert_eq!(center["sources"].as_array().unwrap().len(), 1);
    // The window of the central source is wider than that of a view.
    assert!(center["counters"]["source_pixels"].as_u64().unwrap() > 24 * 32, "{center}");
    assert!(refused(&format!("{} --null", line.replace("--samples 1", "--samples 8")), at).contains("4 or 9"));
    assert!(refused(&format!("{line} --holes trace --null"), at).contains("needs a scene"));
    assert!(refused(&format!("{line} --frames 3 --null"), at).contains("no frame 3"));
    let of_dataset = line.replace("room.lfold", "room");
    assert!(refused(&format!("{of_dataset} --null"), at).contains("lightfold encode"));
}

#[test]
fn light_and_triangles_change_alike_in_both_ways_of_rendering() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let line = format!("{LINE} --views 2 --baseline 0.3");
    let plain = |name: &str, more: &str| {
        fine(&format!("{line}{more} -o {name}/%d.png"), at);
        fine(&format!("{line}{more} --brute-force -o {name}-cast/%d.png"), at);
        let [made, cast] = ["", "-cast"].map(|end| bytes(&at.join(format!("{name}{end}/1.png"))));
        assert!(made == cast, "{more}");
        made
    };
    let all = [plain("a", ""), plain("b", " --ao-rays 16"), plain("c", " --shadows none")];
    assert!(all[0] != all[1] && all[1] != all[2] && all[0] != all[2]);
    assert!(refused(&format!("{line} --subdivide 1 --null"), at).contains("built-in"));
    // Subdivision does not change the shading of a mesh.
    let obj = "v -1 -1 -2\nv 1 -1 -2\nv 0 1 -3\nvn 0 0 1\nvn 0 1 1\nvn 1 0 1\nf 1//1 2//2 3//3\n";
    std::fs::write(at.join("a.obj"), obj).unwrap();
    let of_mesh = "interpolate a.obj --eye 0,0,0 --look-at 0,0,-1 --size 24x32 --views 2 --baseline 0.1";
    let said = |times: u32| report(&format!("{of_mesh} --subdivide {times} -o s{times}/%d.png --json"), at);
    let counters = [said(0), said(2)].map(|said| said["counters"]["lines"].clone());
    assert_eq!(counters[0], counters[1]);
    let read = |times: u32| png::read_rgba8(&at.join(format!("s{times}/0.png")), &ReadLimits::default()).unwrap();
    let (once, finer) = (read(0), read(2));
    let differs = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(b.iter()).any(|(a, b)| a.abs_diff(*b) > 1);
    let changed = once.data().iter().zip(finer.data()).filter(differs).count();
    assert!(changed <= 4, "{changed}");
    assert!(refused(&format!("{of_mesh} --subdivide 8 --null --memory 1k"), at).contains("memory"));
}

#[test]
fn a_stopped_run_is_resumed_to_the_same_files() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine("capture interior --position=-0.2,1.5,0 --position=0.2,1.5,0 --size 16 --samples 1 --frames 0-1 -o room", at);
    let line = "interpolate room --probe 00,01 --face nz --views 3 --frames 0-1";
    fine(&format!("{line} -o whole/%V.%d.png"), at);
    // The second frame is truncated and cannot be read.
    let image = at.join("room/probe_01/face_nz/color.0001.exr");
    let whole = bytes(&image);
    std::fs::write(&image, &whole[..100]).unwrap();
    let run = |more: &str| {
        let output = lightfold(&format!("{line} -o v/%V.%d.png {more}").split(' ').collect::<Vec<_>>(), at);
        (output.status.success(), String::from_utf8(output.stderr).unwrap())
    };
    // With `--reduce-layers`, layers depend on earlier frames, so no images are kept and `--resume` is not suggested.
    let (is_fine, said) = run("--reduce-layers 0.1,1");
    let names = std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert!(
        !is_fine && !said.contains("--resume") && !names.into_iter().any(|name| name.contains("partial")),
        "{said}"
    );
    let (is_fine, said) = run("--resume");
    assert!(!is_fine && said.contains("3 of 6 images are kept"), "{said}");
    assert!(!at.join("v").exists());
    std::fs::write(&image, &whole).unwrap();
    let (is_fine, said) = run("--resume --views 4");
    assert!(!is_fine && said.contains("cannot be used multiple times"), "{said}");
    let (is_fine, said) = run("--resume --splits 1");
    assert!(!is_fine && said.contains("cannot resume") && said.contains("--splits was 8 and is 1 now"), "{said}");
    let said = refused(&format!("{line} -o v/%V-%d.png --resume"), at);
    assert!(said.contains("--output was v/%V.%d.png and is v/%V-%d.png now"), "{said}");
    // One of the kept images is all zeros, as after a disk that lost its last write.
    let kept = at.join(".v.f0-1.views.partial/files/0000.0.png");
    std::fs::write(&kept, vec![0; bytes(&kept).len()]).unwrap();
    let resumed = fine(&format!("{line} -o v/%V.%d.png --resume --json"), at);
    let said = String::from_utf8(resumed.stderr).unwrap();
    assert!(said.contains("resuming with 2 of 6 images; 1 damaged image is rewritten"), "{said}");
    // Only views of this run are counted.
    assert_eq!(serde_json::from_slice::<Value>(&resumed.stdout).unwrap()["views"], 4);
    for name in ["0000.0.png", "0002.0.png", "0000.1.png", "0002.1.png"] {
        assert!(bytes(&at.join("v").join(name)) == bytes(&at.join("whole").join(name)), "{name}");
    }
    assert_eq!(std::fs::read_dir(at.join("v")).unwrap().count(), 6);
    assert!(refused(&format!("{line} --null --resume"), at).contains("--output"));
}

fn courtyard() -> (SceneAtTime, OutputViews) {
    let camera =
        Camera::look_at([-1.5, 1.4, -1.5].into(), [-1.3, 1.2, 4.0].into(), [0.0, 1.0, 0.0].into(), Lens::new(60.0));
    let camera = camera.unwrap().with_aspect(1.4);
    let views = OutputViews::new(camera, [112, 80], 9, Spread::Baseline(1.5), f64::INFINITY).unwrap();
    (Scene::open("courtyard", Play::All).unwrap().0.at(0.0), views)
}

#[test]
fn sources_are_added_until_little_is_missing() {
    let (scene, views) = courtyard();
    let places = |hierarchy: Hierarchy| {
        let settings = AcquireSettings {
            acquisition: Acquisition::Hierarchical,
            hierarchy,
            ..AcquireSettings::new(SamplePattern::new(1).unwrap())
        };
        let (sources, _) = acquire(&scene, &views, &settings, (&Cpu, &Silent)).unwrap();
        sources.iter().map(|source| source.offset_m).collect::<Vec<f64>>()
    };
    for stop in [StoppingRule::Holes, StoppingRule::Erosion] {
        for placement in [SourcePlacement::Midpoint, SourcePlacement::Clusters] {
            let with = |hole_threshold_percent: f64, max_sources: usize| {
                places(Hierarchy { stop, placement, hole_threshold_percent, max_sources, time: None })
            };
            assert_eq!(with(100.0, 9), [-0.75, 0.75], "{stop:?} {placement:?}");
            let many = with(0.01, 9);
            assert!(many.len() > 3 && many.len() <= 9, "{stop:?} {placement:?}: {many:?}");
            assert_eq!(with(0.01, 3).len(), 3);
        }
    }
    // A time limit of 0 allows no third source.
    let none = Hierarchy { hole_threshold_percent: 0.0, time: Some(std::time::Duration::ZERO), ..Hierarchy::default() };
    assert_eq!(places(none), [-0.75, 0.75]);
    // An error of the function that makes a source is returned.
    let failed = hierarchical(&views, &none, &Cpu, |_| Err(codec::error::Error::Interrupted));
    assert!(failed.is_err());
}

#[test]
fn no_file_of_a_dataset_is_overwritten() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine("capture interior --position=0,1.5,0 --position=0.3,1.5,0 --size 16 --samples 1 --frames 0 -o room", at);
    let before = bytes(&at.join("room/probe_00/face_pz/depth.0000.exr"));
    for output in ["-o room/probe_00/face_pz/depth.%04d.exr", "--null --cameras-out room/lightfield.json"] {
        for input in ["room", "room/lightfield.json"] {
            let said = refused(&format!("interpolate {input} --probe 00,01 --face pz --views 2 {output}"), at);
            assert!(said.contains("would be overwritten"), "{said}");
        }
    }
    assert_eq!(before, bytes(&at.join("room/probe_00/face_pz/depth.0000.exr")));
}

#[test]
fn a_film_is_interpolated_from_its_first_frame_on() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let capture =
        "capture courtyard --position=-0.2,1.5,0 --position 0.2,1.5,0 --size 16 --samples 1 --frames 3-4 -o footage";
    fine(capture, at);
    fine("encode footage -o film.lfold --max-error 100 --clip", at);
    let eye = "--eye 0,1.5,0 --look-at 2,1.4,0 --size 12x8 --samples 1 --baseline 0.1";
    for (input, from) in
        [("film.lfold", eye), ("footage", "--probe 00,01 --face nz"), ("film.lfold", "--probe 00,01 --face nz")]
    {
        let line = format!("interpolate {input} {from} --views 2");
        let said = fine(&format!("{line} -o first/%02d.exr"), at).stderr;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains("interpolating frame 3 of 3-4; --frames selects others"), "{said}");
        fine(&format!("{line} --frames 3 -o %V/v.%02d.exr"), at);
        for view in [0, 1] {
            assert!(bytes(&at.join(format!("first/{view:02}.exr"))) == bytes(&at.join(format!("{view:04}/v.03.exr"))));
        }
    }
    assert!(refused(&format!("interpolate film.lfold {eye} --views 2 --frames 0 --null"), at).contains("no frame 0"));
}

/// Runs `lightfold cameras` on a file and returns the cameras of its output.
fn converted(from: &str, at: &Path) -> Vec<render::camera_path::TimedCamera> {
    fine(&format!("cameras {from} -o read.json"), at);
    evaluate::camera_file::CameraFile::parse(&bytes(&at.join("read.json"))).unwrap()
}

#[test]
fn files_of_cameras_that_commands_write_are_read_by_all_others() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let grid = "--views 3 --baseline 0.3 --focus 2 --rows 2 --baseline-y 0.1";
    fine(&format!("{LINE} {grid} --null --cameras-out cams.json"), at);
    let cameras = converted("cams.json", at);
    assert_eq!(cameras.len(), 6);
    // The eyes are on a grid of 0.15 by 0.1 m, and all windows share one rectangle at the focus distance.
    let first = cameras[0].camera;
    let [forward, right, down] = first.axes();
    for (number, timed) in cameras.iter().enumerate() {
        let (camera, moved) = (timed.camera, timed.camera.eye() - first.eye());
        let (column, row) = ((number % 3) as f64, (number / 3) as f64);
        assert!((moved - right * 0.15 * column + down * 0.1 * row).length() < 1e-9, "{number}");
        assert!((camera.axes()[0] - forward).length() < 1e-12 && (camera.aspect() - 0.75).abs() < 1e-12, "{number}");
        for at in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let seen =
                |camera: &Camera| camera.eye() + camera.direction(at) * (2.0 / camera.direction(at).dot(forward));
            assert!((seen(&camera) - seen(&first)).length() < 1e-9, "{number}");
        }
    }
    // Conversion to lightfold's own camera file is lossless: a second conversion gives the same bytes.
    fine("cameras read.json -o again.json", at);
    assert!(bytes(&at.join("read.json")) == bytes(&at.join("again.json")));
    // Cameras with off-axis windows can be captured.
    let capture = "capture interior --projection perspective --size 24x32 --samples 1 --frames 0";
    fine(&format!("{capture} --cameras cams.json -o one"), at);
    fine(&format!("{capture} --cameras read.json -o two"), at);
    for view in 0..6 {
        let [one, two] = [format!("one/probe_{view:04}"), format!("two/probe_{view:02}")]
            .map(|probe| exr::read_rgba(&at.join(probe).join("color.0000.exr"), &ReadLimits::default()).unwrap());
        assert!(one.data().iter().zip(two.data()).filter(|(a, b)| a != b).count() <= 8, "{view}");
    }
    assert!(
        refused(&format!("{} --cameras cams.json -o three", capture.replace("24x32", "32x32")), at).contains("aspect")
    );
    // The manifest that `capture` writes and its container have the same cameras.
    let of_manifest = converted("one", at);
    fine("encode one -o one.lfold --max-error 100 --clip", at);
    for (name, others) in
        [("one/lightfield.json", converted("one/lightfield.json", at)), ("one.lfold", converted("one.lfold", at))]
    {
        assert_eq!(others.len(), 6, "{name}");
        for (other, written) in others.iter().zip(&of_manifest) {
            assert!((other.camera.eye() - written.camera.eye()).length() < 1e-9, "{name}");
        }
    }
    for (written, timed) in of_manifest.iter().zip(&cameras) {
        let (a, b) = (written.camera, timed.camera);
        assert!((a.eye() - b.eye()).length() < 1e-9 && (a.half()[1] - b.half()[1]).abs() < 1e-9);
        assert!(
            a.middle().iter().zip(b.middle()).all(|(a, b)| (a - b).abs() < 1e-9),
            "{:?} {:?}",
            a.middle(),
            b.middle()
        );
    }
    // `render` accepts each of these files.
    for file in ["cams.json", "read.json", "one", "one/lightfield.json", "one.lfold"] {
        fine(
            &format!("render one.lfold --camera {file} --size 32 -o {}/v.%02d.exr", file.replace(['.', '/'], "_")),
            at,
        );
    }
    let [from_placed, from_read] = ["cams_json", "read_json"].map(|folder| bytes(&at.join(folder).join("v.05.exr")));
    assert!(from_placed == from_read);
    // A probe without a field of view is a cube map: six cameras.
    std::fs::write(
        at.join("placed.json"),
        r#"{"lightfold_cameras": 1, "cameras": [{"name": "a", "position": [0, 1.5, 0], "frames": [2, 3]}]}"#,
    )
    .unwrap();
    let cube = converted("placed.json", at);
    assert_eq!(cube.len(), 6);
    let is_square = |camera: &Camera| camera.half().iter().all(|half| (half - 1.0).abs() < 1e-12);
    assert!(cube.iter().all(|timed| is_square(&timed.camera) && timed.frames.unwrap().last == 3));
    let ahead: [f64; 3] = [0, 1, 2].map(|axis| cube.iter().map(|timed| timed.camera.axes()[0][axis]).sum());
    assert!(ahead.iter().all(|sum| sum.abs() < 1e-12), "{ahead:?}");
}
