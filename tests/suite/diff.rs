//! `lightfold diff`: comparisons of datasets, containers, image sequences and single files.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use codec::color::Target;
use codec::decode;
use codec::decode::Decoder;
use codec::image::{ColorPlane, DepthPlane, Face, Plane, ReadLimits};
use codec::monitor::Silent;
use codec::streams::ColorFormat;
use footage::dataset::{Source, SourceOptions};
use footage::encode::{DepthCodec, EncodeSettings, encode};
use footage::export;
use footage::image_files::{exr, png};
use half::f16;
use serde_json::Value;
use tempfile::TempDir;

const SIZE: u32 = 32;
const FRAMES: u32 = 4;
const LAST: u32 = FRAMES - 1;

struct Bench {
    folder: TempDir,
}

fn color(probe: u32, face: u32, frame: u32) -> ColorPlane {
    Plane::from_fn(SIZE, SIZE, |x, y| {
        let value = (x * 3 + y * 5 + face * 40 + probe * 17) % 97;
        let moving = if x.abs_diff(frame * 4) < 3 { 0.5 } else { 0.0 };
        [value as f32 / 97.0, moving, (y + frame) as f32 / 60.0].map(f16::from_f32)
    })
}

fn depth(probe: u32, face: u32, frame: u32) -> DepthPlane {
    Plane::from_fn(SIZE, SIZE, |x, y| match (x + y) % 11 {
        0 => f32::INFINITY,
        _ => 1.0 + (x * 7 + y * 13 + face * 31 + probe + frame * u32::from(x < 5)) as f32 * 0.05,
    })
}

impl Bench {
    /// Writes the dataset `set` of two probes with two faces each, with colour and depth.
    fn new() -> Bench {
        let bench = Bench { folder: TempDir::new().unwrap() };
        bench.write_set("set", LAST);
        bench
    }

    fn write_set(&self, name: &str, last: u32) {
        let files = r#""color": "p{probe}/{face}/color.%04d.exr", "depth": "p{probe}/{face}/depth.%04d.exr""#;
        for (probe, name_of_probe) in ["a", "b"].iter().enumerate() {
            for face in [Face::Px, Face::Nz] {
                let folder = self.path(name).join(format!("p{name_of_probe}/{}", face.name()));
                std::fs::create_dir_all(&folder).unwrap();
                for frame in 0..=last {
                    let at = (probe as u32, face as u32, frame);
                    exr::write_color(&folder.join(format!("color.{frame:04}.exr")), &color(at.0, at.1, at.2)).unwrap();
                    exr::write_depth(&folder.join(format!("depth.{frame:04}.exr")), &depth(at.0, at.1, at.2)).unwrap();
                }
            }
        }
        self.write_manifest(name, last, files);
    }

    fn write_manifest(&self, name: &str, last: u32, files: &str) {
        let manifest = format!(
            r#"{{"lightfield": 1, "name": "t", "fps": 24, "frames": [0, {last}], "projection": "cubemap",
                "size": [{SIZE}, {SIZE}], "faces_present": ["px", "nz"], "files": {{{files}}},
                "probes": [{{"name": "a", "position": [0, 0, 0]}}, {{"name": "b", "position": [1, 0, 0]}}]}}"#
        );
        std::fs::write(self.path(name).join("lightfield.json"), manifest).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn encode(&self, set: &str, name: &str, change: impl FnOnce(&mut EncodeSettings)) {
        let source = Source::open(&self.path(set), &SourceOptions::default()).unwrap();
        let mut settings = EncodeSettings { cell: 16, ..EncodeSettings::default() };
        settings.search.target = Target::Psnr(200.0);
        settings.depth.codec = DepthCodec::Boxes;
        change(&mut settings);
        let (bytes, _) = encode(&source, &settings, Vec::new(), &Silent).unwrap();
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn decode(&self, container: &str, folder: &str) {
        let decoder = Decoder::open(self.path(container)).unwrap();
        let chosen = decode::Selection::default().choose(&decoder).unwrap();
        let destination = export::Destination::Dataset(self.path(folder));
        let format = export::FileFormat::Exr;
        let request = decode::Request::all(&chosen);
        {
            let coding = export::FileCoding { format, space: None };
            export::decode_to_files(&decode::OnCpu::default(), &decoder, request, &destination, coding, &Silent)
        }
        .unwrap();
    }

    /// Runs `diff`. Returns its exit code, standard output and standard error.
    fn run(&self, arguments: &str) -> (i32, String, String) {
        let mut command = Command::cargo_bin("lightfold").unwrap();
        let output = command.current_dir(&self.folder).arg("diff").args(arguments.split(' ')).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }

    #[track_caller]
    fn json(&self, arguments: &str) -> (i32, Value) {
        let (code, out, err) = self.run(&format!("{arguments} --json"));
        match serde_json::from_str(&out) {
            Ok(value) => (code, value),
            Err(_) => panic!("{arguments}: exit code {code}: {err}"),
        }
    }

    #[track_caller]
    fn refused(&self, arguments: &str, word: &str) {
        let (code, _, err) = self.run(arguments);
        assert_eq!(code, crate::commands::code_of(&err), "{err}");
        assert!(err.contains(word), "\"{err}\" does not say \"{word}\"");
    }

    /// Changes one depth pixel of a file.
    fn poke(&self, file: &Path, [x, y]: [u32; 2], z: f32) {
        let mut plane = exr::read_depth(file, &Default::default(), &ReadLimits::default()).unwrap();
        plane.row_mut(y)[x as usize] = z;
        exr::write_depth(file, &plane).unwrap();
    }
}

#[test]
fn lossless_containers_and_folders_are_equal_to_their_source() {
    let bench = Bench::new();
    bench.encode("set", "set.lfold", |_| {});
    bench.decode("set.lfold", "out");
    for (a, b) in [("set", "set.lfold"), ("set.lfold", "set"), ("set/lightfield.json", "out"), ("out", "set.lfold")] {
        let (code, report) = bench.json(&format!("{a} {b} --max-error 0 --min-psnr 99 --min-cell-psnr 99"));
        assert_eq!(code, 0, "{report}");
        assert_eq!((&report["equal"], &report["within_bounds"]), (&true.into(), &true.into()));
        assert_eq!(report["depth"]["max_error_codes"], 0);
        // Files of two datasets may have equal colour codes but different half floats; their PSNR is then NaN, not infinite.
        let are_files = [a, b] == ["set/lightfield.json", "out"];
        let infinite = if are_files { Value::Null } else { "inf".into() };
        assert_eq!(report["depth"]["psnr_db_is"], "inf");
        let color = &report["color"];
        assert_eq!((&color["min_psnr_db"], &color["min_psnr_db_is"]), (&Value::Null, &infinite));
        assert_eq!(report["color"]["ssim"], 1.0);
        assert_eq!(report["worst"], Value::Null);
        assert!(report.get("material").is_none());
        assert_eq!(report["streams"].as_array().unwrap().len(), 8);
        // Half a step of the codes, because the metres of the files are compared.
        let metres = report["depth"]["max_error_m"].as_f64().unwrap();
        if [a, b].contains(&"out") && b == "set.lfold" {
            assert_eq!(metres, 0.0);
        } else {
            assert!(metres > 0.0 && metres < 3e-3, "{metres}");
        }
    }
    let domains = bench.json("out set").1["domains"].clone();
    assert_eq!((&domains["depth"][0]["of"], &domains["depth"][0]["from"]), (&"A".into(), &"manifest".into()));
    assert_eq!(domains["color"][0]["cell"], 16);
}

#[test]
fn light_above_one_is_compared_as_half_floats_and_clipping_is_said() {
    let bench = Bench::new();
    for (name, gain) in [("one", 1.0), ("ten", 10.0)] {
        std::fs::create_dir(bench.path(name)).unwrap();
        let light =
            Plane::from_fn(SIZE, SIZE, |x, y| [2.0, 2.0 + x as f32, 2.0 + y as f32].map(|v| f16::from_f32(gain * v)));
        exr::write_color(&bench.path(name).join("color.0000.exr"), &light).unwrap();
    }
    let sides = "one/color.%04d.exr ten/color.%04d.exr --min-cell-psnr 90";
    assert_eq!(bench.run(sides).0, 1);
    let (code, _, said) = bench.run(&format!("{sides} --allow-clipping"));
    assert_eq!(code, 0);
    let clipped = 2 * SIZE * SIZE;
    assert!(said.contains(&format!("{clipped} colour pixels")) && said.contains("--hdr"), "{said}");
    assert_eq!(bench.json(sides).1["color"]["clipped_pixels"], clipped);
    let psnr = |white: &str| {
        let (code, report) = bench.json(&format!("{sides} --hdr{white}"));
        assert_eq!((code, &report["color"]["clipped_pixels"]), (1, &0.into()), "{report}");
        report["color"]["min_cell_psnr_db"].as_f64().unwrap()
    };
    let [usual, hundred, bright] = ["", " --white 100", " --white 1000"].map(psnr);
    assert!(usual < 20.0 && usual == hundred && usual != bright, "{usual} {hundred} {bright}");
    let same = "one/color.%04d.exr one/color.%04d.exr --min-cell-psnr 90 --hdr";
    let (code, _, said) = bench.run(same);
    assert_eq!((code, said.as_str()), (0, ""));
    bench.refused(&format!("{sides} --white 100"), "--hdr");
    bench.refused(&format!("{sides} --hdr --white 0"), "positive");
}

#[test]
fn half_floats_of_containers_keep_their_white_unless_another_is_given() {
    let bench = Bench::new();
    bench.encode("set", "codes.lfold", |_| {});
    bench.encode("set", "half.lfold", |settings| settings.color = ColorFormat::Half { white_cd_m2: 300.0 });
    let white = |line: &str| bench.json(line).1["domains"]["color"][0]["white_cd_m2"].clone();
    assert_eq!(white("set half.lfold"), 300.0);
    assert_eq!(white("set half.lfold --hdr"), 300.0);
    assert_eq!(white("set half.lfold --hdr --white 50"), 50.0);
    assert_eq!(white("set codes.lfold"), Value::Null);
    assert_eq!(white("set codes.lfold --hdr"), 100.0);
}

#[test]
fn one_pixel_is_found() {
    let bench = Bench::new();
    bench.encode("set", "set.lfold", |_| {});
    bench.write_set("copy", LAST);
    let file = bench.path("copy/pb/nz/depth.0002.exr");
    let before = depth(1, Face::Nz as u32, 2).get(9, 20);
    let before_m = f64::from(before);
    bench.poke(&file, [9, 20], before + 0.5);
    for (a, b) in [("set.lfold", "copy"), ("copy", "set.lfold"), ("set", "copy")] {
        let (code, report) = bench.json(&format!("{a} {b} --max-error 3"));
        assert_eq!(code, 1);
        assert_eq!((&report["equal"], &report["within_bounds"]), (&false.into(), &false.into()));
        let worst = &report["worst"];
        assert_eq!((&worst["stream"], &worst["frame"]), (&"depth b/nz".into(), &2.into()));
        assert_eq!((&worst["x"], &worst["y"]), (&9.into(), &20.into()));
        assert_eq!(report["depth"]["worst"], *worst);
        assert_eq!(report["depth"]["differing_pixels"], 1);
        let metres = report["depth"]["max_error_m"].as_f64().unwrap();
        assert!((metres - 0.5).abs() < 2e-3, "{metres}");
        let domain = &report["domains"]["depth"][1];
        let [near, far] = ["near_m", "far_m"].map(|key| domain[key].as_f64().unwrap());
        let codes = ((before_m + 0.5) / before_m).ln() / (far / near).ln() * 65534.0;
        let found = report["depth"]["max_error_codes"].as_f64().unwrap();
        assert!((found - codes).abs() <= 1.0, "{found} {codes}");
        let expected = 10.0 * (65535.0 * 65535.0 * f64::from(16 * SIZE * SIZE) / (found * found)).log10();
        assert!((report["depth"]["psnr_db"].as_f64().unwrap() - expected).abs() < 1e-6);
        assert_eq!(report["broken"][0]["bound"], "max-error");
        assert_eq!(report["color"]["min_psnr_db_is"], "inf");
    }
    let (code, text, _) = bench.run("set copy --max-error 3");
    assert_eq!(code, 1);
    let last = text.lines().last().unwrap();
    assert!(last.contains("--max-error") && last.contains("depth b/nz, frame 2, pixel (9, 20)"), "{last}");
    assert_eq!(bench.run("set copy").0, 0, "no bound was given");
    assert_eq!(bench.run("set copy --exact").0, 1);
    assert_eq!(bench.run("set copy --exact --frames 0-1").0, 0);
    assert_eq!(bench.run("set copy --exact --probe a").0, 0);
    assert_eq!(bench.run("set copy --exact --face px").0, 0);
    assert_eq!(bench.run("set copy --exact --stream color").0, 0);
    assert_eq!(bench.run("set copy --max-error 0 --probe b --face nz --frames 2").0, 1);
}

#[test]
fn background_and_depth_beyond_the_range_count_as_much_as_can_be() {
    let bench = Bench::new();
    bench.encode("set", "set.lfold", |_| {});
    for (z, key, metres) in [(f32::INFINITY, "background_mismatches", None), (1000.0, "outside_pixels", Some(990.0))] {
        bench.write_set("copy", LAST);
        bench.poke(&bench.path("copy/pa/px/depth.0001.exr"), [3, 4], z);
        for sides in ["copy set.lfold", "set.lfold copy"] {
            let (_, report) = bench.json(&format!("{sides} --max-error 65534"));
            assert_eq!(report["depth"]["max_error_codes"], 65535);
            assert_eq!(report["depth"][key], 1);
            match metres {
                None => assert_eq!(report["depth"]["max_error_m_is"], "inf"),
                Some(least) => assert!(report["depth"]["max_error_m"].as_f64().unwrap() > least),
            }
            assert_eq!(report["within_bounds"], false);
            assert_eq!((&report["worst"]["x"], &report["worst"]["y"]), (&3.into(), &4.into()));
        }
    }
}

#[test]
fn bounds_that_were_encoded_hold_and_tighter_ones_do_not() {
    let bench = Bench::new();
    bench.encode("set", "lossy.lfold", |settings| {
        settings.temporal.epsilon = 40;
        settings.search.target = Target::Psnr(30.0);
    });
    bench.decode("lossy.lfold", "out");
    for b in ["lossy.lfold", "out"] {
        let (code, report) =
            bench.json(&format!("set {b} --max-error 40 --min-psnr 30 --min-cell-psnr 30 --ssim every"));
        assert_eq!(code, 0, "{report}");
        assert_eq!((&report["equal"], &report["within_bounds"]), (&false.into(), &true.into()));
        let number = |group: &str, key: &str| report[group][key].as_f64().unwrap();
        assert!(number("depth", "max_error_codes") > 0.0);
        let [cell, frame, all] = ["min_cell_psnr_db", "min_psnr_db", "psnr_db"].map(|key| number("color", key));
        assert!(30.0 <= cell && cell <= frame && frame <= all, "{cell} {frame} {all}");
        assert_eq!(report["color"]["ssim_frames"], 16);
        assert!(number("color", "ssim") < 1.0);
        assert!((30.0..100.0).contains(&number("color", "psnr_hvs_m_db")), "{report}");
        assert_eq!(report["color"]["ssimulacra2"], Value::Null);
        for broken in [format!("--min-psnr {}", frame + 1e-6), format!("--min-cell-psnr {}", cell + 1e-6)] {
            let (code, report) = bench.json(&format!("set {b} {broken} --ssim none"));
            assert_eq!((code, report["broken"].as_array().unwrap().len()), (1, 1));
            assert_eq!((&report["color"]["ssim"], &report["color"]["psnr_hvs_m_db"]), (&Value::Null, &Value::Null));
        }
        assert_eq!(bench.run(&format!("set {b} --min-cell-psnr {cell}")).0, 0);
    }
    assert_eq!(bench.run("out lossy.lfold --exact").0, 0);
    assert_eq!(bench.run("set lossy.lfold --exact").0, 1);
}

#[test]
fn pictures_are_scored_where_it_is_asked_for() {
    let bench = Bench::new();
    bench.encode("set", "lossy.lfold", |settings| settings.search.target = Target::Psnr(30.0));
    let (code, report) = bench.json("set lossy.lfold --stream color --ssimulacra2");
    assert_eq!(code, 0, "{report}");
    let of = |key: &str| report["color"][key].as_f64().unwrap();
    assert!(of("ssimulacra2_p10") <= of("ssimulacra2") && of("ssimulacra2") < 100.0, "{report}");
    assert!(of("butteraugli_3norm") > 0.0, "{report}");
    let (_, report) = bench.json("lossy.lfold lossy.lfold --stream color --ssimulacra2");
    assert_eq!((&report["color"]["ssimulacra2"], &report["color"]["butteraugli_3norm"]), (&100.0.into(), &0.0.into()));
    for refused in ["--ssim none", "--hdr"] {
        bench.refused(&format!("set lossy.lfold --ssimulacra2 {refused}"), "leave out --hdr and --ssim none");
    }
}

#[test]
fn what_one_side_lacks_is_a_difference_unless_only_the_common_is_asked_for() {
    let bench = Bench::new();
    bench.write_set("short", LAST - 1);
    bench.encode("set", "depth.lfold", |settings| settings.kinds = vec![footage::dataset::StreamKind::Depth]);
    let (code, report) = bench.json("set short --max-error 0");
    assert_eq!(code, 1);
    assert_eq!((&report["equal"], &report["within_bounds"]), (&false.into(), &false.into()));
    let missing = report["missing"].as_array().unwrap();
    assert_eq!(missing.len(), 8);
    assert_eq!((&missing[0]["only_in"], &missing[0]["stream"]), (&"A".into(), &"color a/px".into()));
    assert_eq!(missing[0]["frames"], serde_json::json!([LAST, LAST]));
    assert_eq!(bench.run("set short").0, 0);
    assert_eq!(bench.run("set short --exact").0, 1);
    assert_eq!(bench.run("set short --exact --common").0, 0);
    assert_eq!(bench.run("set short --exact --frames 0-2").0, 0);
    let (code, report) = bench.json("depth.lfold set --max-error 0");
    assert_eq!(code, 1);
    assert_eq!((&report["missing"][0]["only_in"], report.get("color")), (&"B".into(), None));
    assert_eq!(bench.run("depth.lfold set --max-error 0 --stream depth").0, 0);
    assert_eq!(bench.run("depth.lfold set --max-error 0 --common").0, 0);
}

#[test]
fn half_floats_are_measured_as_the_encoder_measures_them() {
    let bench = Bench::new();
    for (name, psnr) in [("exact.lfold", 200.0), ("lossy.lfold", 35.0)] {
        bench.encode("set", name, |settings| {
            settings.color = ColorFormat::Half { white_cd_m2: 100.0 };
            settings.search.target = Target::Psnr(psnr);
        });
    }
    let (code, report) = bench.json("set exact.lfold --exact --stream color");
    assert_eq!((code, &report["equal"], &report["exact"]["differing_pixels"]), (0, &true.into(), &0.into()));
    assert_eq!((&report["color"]["ssim"], &report["domains"]["color"][0]["codes"]), (&Value::Null, &"half".into()));
    let (code, report) = bench.json("set lossy.lfold --min-cell-psnr 35");
    assert_eq!(code, 0);
    assert_eq!(report["equal"], false);
    bench.encode("set", "eight.lfold", |_| {});
    // Sides of different formats are converted through linear RGB to the format of side A.
    assert_eq!(bench.json("eight.lfold exact.lfold").1["color"]["psnr_db_is"], "inf");
    let (_, report) = bench.json("exact.lfold eight.lfold");
    assert_eq!(report["domains"]["color"][0]["codes"], "half");
    assert!(report["color"]["psnr_db"].as_f64().unwrap() > 45.0);
}

#[test]
fn containers_of_two_ranges_are_compared_by_way_of_metres() {
    let bench = Bench::new();
    bench.encode("set", "narrow.lfold", |_| {});
    bench.encode("set", "wide.lfold", |settings| (settings.near_m, settings.far_m) = (Some(0.1), Some(500.0)));
    for sides in ["narrow.lfold wide.lfold", "wide.lfold narrow.lfold"] {
        let (code, report) = bench.json(&format!("{sides} --max-error 4 --stream depth"));
        assert_eq!(code, 0, "{}", report["depth"]);
        assert_eq!(report["domains"]["depth"][0]["of"], "A");
        assert!(report["depth"]["max_error_m"].as_f64().unwrap() > 0.0);
        assert_eq!(report["depth"]["outside_pixels"], 0);
    }
}

#[test]
fn panoramas_take_the_face_size_of_the_container() {
    let bench = Bench::new();
    let folder = bench.path("pano");
    std::fs::create_dir(&folder).unwrap();
    for frame in 0..2 {
        let light = Plane::from_fn(64, 32, |x, y| [x as f32 / 64.0, y as f32 / 32.0, frame as f32].map(f16::from_f32));
        exr::write_color(&folder.join(format!("color.{frame:04}.exr")), &light).unwrap();
        let metres = Plane::from_fn(64, 32, |x, y| if y < 4 { f32::INFINITY } else { 1.0 + (x + y) as f32 });
        exr::write_depth(&folder.join(format!("depth.{frame:04}.exr")), &metres).unwrap();
    }
    let manifest = r#"{"lightfield": 1, "name": "p", "fps": 24, "frames": [0, 1], "projection": "equirect",
        "size": [64, 32], "files": {"color": "color.%04d.exr", "depth": "depth.%04d.exr"},
        "probes": [{"name": "a", "position": [0, 0, 0]}]}"#;
    std::fs::write(folder.join("lightfield.json"), manifest).unwrap();
    let options = SourceOptions { face_size: Some(24), ..SourceOptions::default() };
    let source = Source::open(&folder, &options).unwrap();
    let mut settings = EncodeSettings::default();
    settings.search.target = Target::Psnr(200.0);
    settings.depth.codec = DepthCodec::Boxes;
    let (bytes, _) = encode(&source, &settings, Vec::new(), &Silent).unwrap();
    std::fs::write(bench.path("pano.lfold"), bytes).unwrap();
    bench.decode("pano.lfold", "faces");
    for sides in ["pano pano.lfold", "pano.lfold pano", "pano faces", "faces pano", "pano pano"] {
        let (code, report) = bench.json(&format!("{sides} --max-error 0 --min-psnr 99"));
        assert_eq!((code, &report["equal"]), (0, &true.into()), "{sides}");
        assert_eq!(report["streams"].as_array().unwrap().len(), 12);
        assert_eq!(report["streams"][0]["width"], if sides == "pano pano" { 32 } else { 24 });
    }
    let (code, report) = bench.json("pano/depth.%04d.exr pano.lfold --layout equirect --max-error 0");
    assert_eq!((code, report["streams"].as_array().unwrap().len()), (0, 6));
}

#[test]
fn lone_sequences() {
    let bench = Bench::new();
    bench.encode("set", "set.lfold", |_| {});
    bench.write_set("copy", LAST);
    for b in ["copy/pa/px/depth.####.exr", "set.lfold --probe a --face px", "copy --probe a --face px"] {
        let (code, report) = bench.json(&format!("set/pa/px/depth.%04d.exr {b} --max-error 0"));
        assert_eq!((code, &report["equal"]), (0, &true.into()), "{b}: {report}");
        assert_eq!(report["streams"].as_array().unwrap().len(), 1);
    }
    let (code, report) = bench.json("set/pa/px/depth.0000.exr set/pa/px/depth.0001.exr --max-error 0");
    assert_eq!((code, &report["missing"]), (1, &serde_json::json!([])));
    let [first, second] = [0, 1].map(|frame| depth(0, Face::Px as u32, frame));
    let differing = first.data().iter().zip(second.data()).filter(|(a, b)| a != b).count();
    assert_eq!(report["depth"]["differing_pixels"], differing);
    assert_eq!(bench.run("set/pa/px/color.0000.exr set/pa/px/color.0000.exr --exact").0, 0);
    // `--kind` replaces the words in the file name that state the kind; without either, channels do.
    std::fs::copy(bench.path("set/pa/px/depth.0000.exr"), bench.path("z.exr")).unwrap();
    std::fs::copy(bench.path("set/pa/px/depth.0000.exr"), bench.path("y.exr")).unwrap();
    assert_eq!(bench.run("z.exr y.exr --exact").0, 0);
    assert_eq!(bench.run("z.exr y.exr --kind depth --exact").0, 0);
    assert_eq!(bench.run("z.exr set.lfold --stream depth --probe a --face px --frames 0 --max-error 0").0, 0);
    // Integer files with their own scale.
    let codes = Plane::from_fn(SIZE, SIZE, |x, y| (x * 10 + y) as u16);
    png::write_depth16(&bench.path("depth_mm.0000.png"), &codes).unwrap();
    let scaled = codes.map(|&code| if code == 0 { f32::INFINITY } else { (f64::from(code) * 0.001) as f32 });
    exr::write_depth(&bench.path("depth_m.0000.exr"), &scaled).unwrap();
    bench.refused("depth_mm.0000.png depth_mm.0000.png", "--depth-scale");
    bench.refused("depth_mm.0000.png depth_mm.0000.png --depth-scale 0.001", "--invalid-depth to far or near");
    assert_eq!(bench.run("depth_mm.0000.png depth_mm.0000.png --background 0 --depth-scale 0.001 --exact").0, 0);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let bench = Bench::new();
    bench.encode("set", "set.lfold", |_| {});
    bench.refused("nowhere set", "nowhere");
    bench.refused("set set.lfold --probe zz", "zz");
    bench.refused("set set.lfold --frames 90-99", "frames");
    bench.refused("set/pa/px/depth.%04d.exr set.lfold", "--probe");
    bench.refused("set set.lfold --max-error many", "--max-error");
    for (bound, stream, words) in [
        ("--max-error 9", "color", "--max-error: no stream of depth, material or alpha is compared"),
        ("--min-psnr 30", "depth", "--min-psnr: no stream of colour is compared"),
        ("--min-quality 30", "depth", "--min-quality: no stream of colour is compared"),
    ] {
        let line = format!("set set.lfold --stream {stream} {bound}");
        bench.refused(&line, words);
        assert_eq!(bench.run(&line).0, 2, "{line}");
    }
    // A stream of one side is a difference, unless it is left out.
    bench.encode("set", "depth.lfold", |settings| settings.kinds = vec![footage::dataset::StreamKind::Depth]);
    assert_eq!(bench.run("set depth.lfold --min-psnr 30").0, 1);
    bench.refused("set depth.lfold --min-psnr 30 --common", "no stream of colour is compared");
    bench.refused("- -", "standard input");
    let small: ColorPlane = Plane::filled(8, 8, [f16::ONE; 3]);
    exr::write_color(&bench.path("color.exr"), &small).unwrap();
    bench.refused("color.exr set --probe a --face px", "8x8");
    std::fs::write(bench.path("junk.lfold"), "junk").unwrap();
    bench.refused("junk.lfold set", "junk.lfold");
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let bench = Bench::new();
    bench.encode("set", "lossy.lfold", |settings| {
        settings.temporal.epsilon = 9;
        settings.search.target = Target::Psnr(30.0);
    });
    let report = |threads: u32| {
        let (_, report, _) = bench.run(&format!("set lossy.lfold --json --threads {threads}"));
        let mut report: serde_json::Value = serde_json::from_str(&report).unwrap();
        assert!(report["depth"]["max_error_codes"].is_number());
        report.as_object_mut().unwrap().remove("peak_memory_bytes");
        report
    };
    assert_eq!(report(1), report(7));
}
