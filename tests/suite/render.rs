//! `lightfold render` on the command line: pictures, file names, figures and refusals.

use std::path::Path;

use codec::image::{ReadLimits, Transfer};
use footage::image_files::exr;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};

/// Options for four probes and one between them.
const PROBES: &str =
    "--position=-0.3,1.5,0 --position=0.3,1.5,0 --position=0,1.8,0.2 --position=0,1.3,-0.2 --position=0,1.5,0";
pub const EYE: &str = "--eye 0.05,1.52,0 --look-at -2,1.2,0.8 --fov 80 --size 40";

/// Captures three frames of a built-in scene to the dataset `captured` and encodes them to `a.lfold`.
pub fn encoded(scene: &str, folder: &Path) {
    fine(&format!("capture {scene} {PROBES} --frames 0-2 --size 48 --samples 4 -o captured"), folder);
    fine("encode captured --clip -o a.lfold", folder);
}

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

fn number(report: &Value, key: &str) -> f64 {
    report.pointer(key).and_then(Value::as_f64).unwrap_or_else(|| panic!("{key} in {report:#}"))
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn pictures_do_not_depend_on_threads_acceleration_or_what_is_out_of_sight() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} --frames 0-2 -o one/%04d.png --threads 1"), at);
    let names = ["0000.png", "0001.png", "0002.png"];
    assert_eq!(files(&at.join("one")), names);
    for (other, options) in [
        ("threads", "--threads 3"),
        ("steps", "--acceleration none"),
        ("all", "--decode all"),
        ("force", "--effects force"),
    ] {
        fine(&format!("render a.lfold {EYE} --frames 0-2 -o {other}/%04d.png {options}"), at);
        for name in names {
            let read = |folder: &str| std::fs::read(at.join(folder).join(name)).unwrap();
            assert!(read("one") == read(other), "{other}/{name}");
        }
    }
    let read = |name: &str| std::fs::read(at.join("one").join(name)).unwrap();
    assert!(read("0000.png") != read("0002.png"), "what moves is shown");
}

#[test]
fn shards_render_the_pictures_of_one_run() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let line = format!("render a.lfold {EYE} --frames 0-2");
    for (output, name) in [("%04d.png", "pattern"), ("", "folder")] {
        fine(&format!("{line} -o {name}/one/{output}"), at);
        // One shard runs twice.
        let frames = [2, 1, 2].map(|shard| {
            let told = report(&format!("{line} --shard {shard}/2 -o {name}/parts/{output} --stats --json"), at);
            number(&told, "/frames")
        });
        assert_eq!(frames, [2.0, 1.0, 2.0]);
        let read = |folder: &str| {
            let folder = at.join(name).join(folder);
            files(&folder)
                .into_iter()
                .map(|file| (std::fs::read(folder.join(&file)).unwrap(), file))
                .collect::<Vec<_>>()
        };
        assert!(read("one") == read("parts") && read("one").len() == 3, "{name}: other pictures than one run");
    }
    for (more, words) in [
        ("--shard 1/4 -o v/%04d.png", "--shard 1/4: there can be at most 3 shards, one for each frame"),
        ("--shard 1/3 -o v.png", "--shard cannot write to a single file"),
        ("--shard 1/3 -o -", "--shard needs a pattern"),
    ] {
        let said = refused(&format!("{line} {more}"), at);
        assert!(said.contains(words), "{said}");
    }
    assert_eq!(files(at), ["a.lfold", "captured", "folder", "pattern"]);
}

#[test]
fn figures_are_told() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let line = format!("render a.lfold {EYE} --frames 0-2 --null --stats --json");
    let told = report(&line, at);
    assert_eq!(number(&told, "/primary_rays"), 3.0 * 1600.0);
    assert_eq!((number(&told, "/frames"), number(&told, "/views")), (3.0, 5.0));
    for nothing in ["/secondary_rays", "/normal_evals", "/material_samples"] {
        assert_eq!(number(&told, nothing), 0.0, "{nothing}: the scene calls for no effects");
    }
    assert!(number(&told, "/cells_decoded") > 0.0 && number(&told, "/cells_skipped") > 0.0);
    assert!(number(&told, "/pacing/max_ms") >= number(&told, "/pacing/p50_ms"));
    let all = report(&format!("{line} --decode all"), at);
    assert!(number(&told, "/bytes_read") < number(&all, "/bytes_read"));
    let dense = report(&format!("{line} --acceleration none"), at);
    assert!(number(&dense, "/march_steps") > 2.0 * number(&told, "/march_steps"));
    assert_eq!(number(&report(&format!("{line} --views 2"), at), "/views"), 2.0);
    let plain = report(&format!("render a.lfold {EYE} --frames 0-2 --null --json"), at);
    assert!(number(&plain, "/pacing/render_ms/mean_ms") > 0.0 && number(&plain, "/megapixels_per_second") > 0.0);
    for (target_ms, within) in [("0.0001", 0.0), ("1e9", 3.0)] {
        let told = report(&format!("{line} --target-ms {target_ms}"), at);
        assert_eq!(number(&told, "/frames_within_target"), within);
    }
}

/// Messages go to standard output, as those of `decode` do; a quiet command still prints requested figures.
#[test]
fn words_go_where_nothing_else_goes() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let said = |options: &str| {
        let output = fine(&format!("render a.lfold {EYE} {options}"), at);
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
    };
    let [out, _] = said("-o a.png --target-ms 1e9");
    assert!(out.contains("a.png: 1 picture") && out.contains("1 of 1 frame took at most"), "{out}");
    let [out, err] = said("-o a.png -q");
    assert_eq!((out.as_str(), err.as_str()), ("", ""));
    let [out, _] = said("-o a.png -q --stats");
    assert!(out.contains("primary rays") && !out.contains("a.png"), "{out}");
    let [out, err] = said("--null --trace - --stats");
    assert!(out.starts_with('{') && out.lines().count() == 1 && err.contains("primary rays"), "{out}{err}");
    let line = "render a.lfold --reference captured --reference-probe 04 --frames 0 --null -q";
    let out = String::from_utf8(fine(line, at).stdout).unwrap();
    assert!(out.contains("PSNR") && out.contains("a frame of 6 pictures"), "{out}");
}

#[test]
fn planes_beside_a_picture_say_what_its_pixels_are() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("interior", at);
    let line = format!("render a.lfold {EYE} --aov depth,normal,holes,views");
    fine(&format!("{line} -o a.exr"), at);
    let limits = ReadLimits::default();
    let read =
        exr::read_channels(&at.join("a.exr"), ["Z", "N.X", "N.Y", "N.Z", "holes", "views", "A"], &limits).unwrap();
    let mut known = 0;
    for &[z, x, y, normal_z, hole, views, alpha] in read.data() {
        // A closed room of a few metres, seen by five probes; holes are filled.
        assert!(z > 0.1 && z < 20.0 && (0.0..=5.0).contains(&views) && views.fract() == 0.0, "{z} m, {views} views");
        assert!((hole == 0.0 || hole == 1.0) && alpha == 1.0, "hole {hole}, alpha {alpha}");
        let length = (x * x + y * y + normal_z * normal_z).sqrt();
        assert!(length == 0.0 || (length - 1.0).abs() < 1e-3, "a normal of length {length}");
        known += u32::from(length > 0.0 && views > 0.0);
    }
    assert!(known > 1400, "{known} of 1600 pixels have a normal and a view");
    // The mask equals the transparent pixels of blank holes.
    fine(&format!("render a.lfold {EYE} --aov holes --holes blank -o blank.exr"), at);
    let blank = exr::read_channels(&at.join("blank.exr"), ["holes", "A"], &limits).unwrap();
    assert!(blank.data().iter().all(|&[hole, alpha]| hole == 1.0 - alpha));
    for (options, words) in
        [("-o a.png", "exr"), ("-o a.exr --method splat", "--aov"), ("-o a.exr --device gpu", "--device")]
    {
        assert!(refused(&format!("{line} {options}"), at).contains(words), "{options}");
    }
}

/// With a transparent background, pixels without a surface are empty, and pixels at edges have the colour of the surface. PNG
/// stores straight alpha, EXR premultiplied alpha.
#[test]
fn a_transparent_background_leaves_the_colour_of_surfaces() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let line = format!("render a.lfold {EYE} --background transparent --samples 4");
    fine(&format!("{line} -o a.png"), at);
    fine(&format!("{line} -o a.exr"), at);
    let straight = image::open(at.join("a.png")).unwrap().into_rgba8();
    let premultiplied = exr::read_channels(&at.join("a.exr"), ["R", "G", "B", "A"], &ReadLimits::default()).unwrap();
    let mut kinds = [0; 3];
    for (pixel, &[r, g, b, alpha]) in straight.pixels().zip(premultiplied.data()) {
        assert!((f32::from(pixel[3]) / 255.0 - alpha).abs() < 0.003, "alpha {alpha} and {}", pixel[3]);
        kinds[if alpha == 0.0 {
            0
        } else if alpha < 1.0 {
            1
        } else {
            2
        }] += 1;
        for (code, light) in pixel.0.into_iter().zip([r, g, b]) {
            let expected = Transfer::Srgb.decode(f64::from(code) / 255.0) * f64::from(alpha);
            assert!((expected - f64::from(light)).abs() < 0.006, "{code} at alpha {alpha} and {light}");
            assert!(alpha > 0.0 || (code == 0 && light == 0.0));
        }
    }
    assert!(kinds.iter().all(|&pixels| pixels > 20), "{kinds:?} pixels without, with a part of, and with a surface");
    let said = refused(&format!("{line} --reference captured --null"), at);
    assert!(said.contains("--background"), "{said}");
}

#[test]
fn the_algorithm_of_the_paper_is_that_without_refinements() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("fence", at);
    let picture = |options: &str| {
        fine(&format!("render a.lfold {EYE} {options} -o a.png"), at);
        std::fs::read(at.join("a.png")).unwrap()
    };
    let calf = picture("--method calf --holes blank");
    assert!(calf == picture("--refinements none --holes blank"));
    assert!(
        calf != picture("--holes blank") && picture("--refinements all") == picture("--refinements angles+edges+thin")
    );
    let words = refused(&format!("render a.lfold {EYE} --null --refinements edges+all+more"), at);
    assert!(words.contains("more"), "{words}");
}

#[test]
fn a_probe_that_is_left_out_is_rendered_from_the_others() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("interior", at);
    let line =
        "render a.lfold --exclude-probe 04 --reference captured --reference-probe 04 --null --json --holes nearest";
    let psnr = |options: &str| number(&report(&format!("{line} {options}"), at), "/reference/psnr_db");
    let (ours, splat, ceiling) = (psnr("--method march"), psnr("--method splat"), psnr("--method reproject"));
    assert!(ours > splat && ceiling > splat && ours > 20.0, "ours {ours}, splat {splat}, ceiling {ceiling}");
    let with_itself = report("render a.lfold --reference captured --reference-probe 04 --null --json", at);
    assert!(number(&with_itself, "/reference/psnr_db") > ours + 6.0, "{with_itself:#}");
    assert_eq!(with_itself["reference"]["images"].as_array().unwrap().len(), 3 * 6);
    fine("render a.lfold --reference captured --reference-probe 04 --frames 1 -o shown --error-map maps", at);
    assert_eq!(files(&at.join("shown")).len(), 6);
    assert_eq!(files(&at.join("maps"))[0], "04_nx.0001.png");
    let faces = "render a.lfold --reference captured --reference-probe 04 --frames 1 -o faces.%04d.png";
    let said = refused(faces, at);
    assert!(said.contains("6 pictures have only 1 different frame numbers"), "{said}");
}

#[test]
fn two_eyes_lie_beside_each_other_or_in_files_of_their_own() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} --stereo side-by-side --eye-distance 0.1 -o both.png"), at);
    fine(
        &format!(
            "render a.lfold {EYE} --stereo side-by-side --eye-distance 0.1 -o view.%V.png --contact-sheet sheet.png"
        ),
        at,
    );
    let open = |name: &str| image::open(at.join(name)).unwrap().to_rgba8();
    let (both, left, right) = (open("both.png"), open("view.left.png"), open("view.right.png"));
    assert_eq!((both.dimensions(), left.dimensions()), ((80, 40), (40, 40)));
    assert!(left != right);
    assert!((0..40).all(|y| (0..80).all(|x| {
        let eye = if x < 40 { &left } else { &right };
        both.get_pixel(x, y) == eye.get_pixel(x % 40, y)
    })));
    assert!(open("sheet.png").width() > 80);
    fine(&format!("render a.lfold {EYE} --stereo over-under --eye-distance 0.1 --frames 0-1 -o eyes/%V/%04d.png"), at);
    assert_eq!(files(&at.join("eyes")), ["left", "right"]);
    assert_eq!(files(&at.join("eyes/right")), ["0000.png", "0001.png"]);
    assert!(open("eyes/left/0000.png") == left);
    assert!(refused(&format!("render a.lfold {EYE} --stereo over-under -o eyes/%V/all"), at).contains("a folder"));
    assert!(refused(&format!("render a.lfold {EYE} -o eyes/%V/a.png"), at).contains("--stereo"));
}

#[test]
fn standard_output_takes_the_bytes_of_a_picture() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} -o a.png"), at);
    let printed = fine(&format!("render a.lfold {EYE} -o -"), at).stdout;
    assert!(printed == std::fs::read(at.join("a.png")).unwrap());
    fine(&format!("render a.lfold {EYE} -o a.exr"), at);
    assert!(refused(&format!("render a.lfold {EYE} -o - --json"), at).contains("only one result"));
}

#[test]
fn what_cannot_be_rendered_is_refused_in_a_sentence() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    for (options, words) in [
        ("--frames 0-2 -o a.png", "one file for 3 pictures"),
        ("--frames 7 -o a.png", "0-2"),
        ("-o a.jpg", ".png or .exr"),
        ("-o a.%V.png", "--stereo"),
        ("--near 2 --far 1 --null", "must be below --far"),
        ("--method reproject --null", "--reference"),
        ("--probe nobody --null", "nobody"),
        ("--exclude-probe 00,01,02,03,04 --null", "probe"),
        ("--exclude-probe 00 --probe 00 --null", "excludes all probes"),
        ("--max-bounces 9 --null", "0..=8"),
        ("--far 0.001 --null", "set --near"),
        ("--error-map maps --null", "--error-map"),
        ("--reference-probe 00 --null", "--reference-probe"),
    ] {
        let said = refused(&format!("render a.lfold {EYE} {options}"), at);
        assert!(said.contains(words), "{options}: {said}");
        assert_eq!(files(at), ["a.lfold", "captured"], "{options}");
    }
    let said = refused("render a.lfold --eye 0,0,0 --look-at 1,0,0 --fov 60 --aspect 2 --size 4x2 --null", at);
    assert!(said.contains("leave out one"), "{said}");
    for dataset in ["captured", "captured/lightfield.json"] {
        assert!(refused(&format!("render {dataset} {EYE} --null"), at).contains("encode a dataset first"));
    }
    fine("encode-depth captured/probe_00/face_px/depth.%04d.exr -o depth.lfold", at);
    let said = refused(&format!("render depth.lfold {EYE} --null"), at);
    assert!(said.contains("both colour and depth"), "{said}");
}

/// Frames and options that are given but not used are reported, also without `--output`.
#[test]
fn frames_that_are_passed_over_are_told() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let noted = |line: &str| String::from_utf8(fine(&format!("render a.lfold {line}"), at).stderr).unwrap();
    assert!(noted(&format!("{EYE} --contact-sheet sheet.png")).contains("frame 0 of 0-2; --frames selects others"));
    assert_eq!(noted(&format!("{EYE} --frames 0 --trace views.jsonl")), "");
    for ignored in ["--samples 2", "--effects force"] {
        assert!(noted(&format!("{EYE} --frames 0 --null --method splat {ignored}")).contains("ignores --samples"));
    }
    let pose = r#"{"eye": [0.05, 1.52, 0], "look_at": [-2, 1.2, 0.8], "fov_y_deg": 80, "frame": "#;
    std::fs::write(at.join("path.json"), format!(r#"{{"cameras": [{pose} 1}}, {pose} 47}}]}}"#)).unwrap();
    let words = noted("--camera path.json --size 16 --null");
    assert!(words.contains("skipping 45 frames of the cameras; the container has 0-2"), "{words}");
    let words = refused("render a.lfold --camera path.json --frames 0-2 --null", at);
    assert!(words.contains("no camera is defined for frame 0 of 0-2"), "{words}");
    assert!(noted("--reference captured --frames 2-9 --reference-probe 04").contains("of frames 2-9"));
}

#[test]
fn without_a_camera_the_first_probe_s_own_view_is_shown() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let words = fine("render a.lfold --exclude-probe 00 --frames 0 --size 48 -o own.png", at).stderr;
    let words = String::from_utf8(words).unwrap();
    assert!(words.contains("the view of probe 01, face nz; use --eye and --look-at"), "{words}");
    let there = "--eye 0.3,1.5,0 --look-at 0.3,1.5,-1";
    fine(&format!("render a.lfold --exclude-probe 00 {there} --fov 90 --frames 0 --size 48 -o there.png"), at);
    let read = |name: &str| std::fs::read(at.join(name)).unwrap();
    assert!(read("own.png") == read("there.png"));
    fine(&format!("render a.lfold {there} --frames 0 --size 48 -o default.png"), at);
    fine(&format!("render a.lfold {there} --fov 60 --frames 0 --size 48 -o sixty.png"), at);
    assert!(read("default.png") == read("sixty.png"));
    std::fs::write(at.join("cameras.json"), r#"{"lightfold_cameras": 1, "cameras": [{"position": [0, 1, 0]}]}"#)
        .unwrap();
    // In a camera file for `capture`, a probe without a field of view is a cube map of six cameras.
    fine("render a.lfold --camera cameras.json --frames 0 --size 8 -o cube.%d.png", at);
    assert!(at.join("cube.5.png").is_file() && !at.join("cube.6.png").exists());
}

/// Near and far of a camera file are clipping planes for every method.
#[test]
fn near_and_far_of_a_camera_are_honoured() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("interior", at);
    let shown = |name: &str, range: &str, more: &str| {
        let camera = r#"{"eye": [0.05, 1.52, 0], "look_at": [-2, 1.2, 0.8], "fov_y_deg": 80"#;
        std::fs::write(at.join("cam.json"), format!(r#"{{"cameras": [{camera}{range}}}]}}"#)).unwrap();
        let line = format!("render a.lfold --camera cam.json --frames 0 --size 40 -o {name}.png --json {more}");
        let holes = number(&report(&line, at), "/hole_rays");
        (holes, std::fs::read(at.join(format!("{name}.png"))).unwrap())
    };
    for more in ["--method march", "--method march --acceleration none", "--method splat"] {
        let (holes, all) = shown("all", "", more);
        assert!(holes < 400.0, "{more}: {holes}");
        assert_eq!(shown("wide", r#", "near_m": 0.01, "far_m": 1000"#, more), (holes, all), "{more}");
        // The walls of the room are farther than 0.2 m and nearer than 900 m.
        assert_eq!(shown("near", r#", "far_m": 0.2"#, more).0, 1600.0, "{more}");
        assert_eq!(shown("far", r#", "near_m": 900"#, more).0, 1600.0, "{more}");
        let (half, _) = shown("half", r#", "far_m": 2.5"#, more);
        assert!(half > holes && half < 1600.0, "{more}: {half}");
    }
    let words =
        String::from_utf8(fine("render a.lfold --camera cam.json --frames 0 --size 40 --null", at).stdout).unwrap();
    assert!(words.contains("are clipped by near and far"), "{words}");
}

/// The trace lists the probes of each frame, each active one in a slot of its own.
#[test]
fn a_trace_tells_who_took_part() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} --frames 0-2 --views 2 --null --trace views.jsonl"), at);
    let text = std::fs::read_to_string(at.join("views.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3);
    for (frame, line) in lines.iter().enumerate() {
        assert_eq!(line["frame"], frame);
        assert_eq!(line["active"].as_array().unwrap().len(), 2);
        assert_eq!(line["culled"].as_array().unwrap().len(), 3);
        assert_eq!(line["active"][0]["probe"], "04", "the nearest: {line:#}");
    }
}
