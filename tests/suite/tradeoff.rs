//! `lightfold tradeoff`, run as a program on a small scene; and the points of a baseline, which may not become worse.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use cli::report::tradeoff::coding::CODING;
use cli::report::tradeoff::store::{Store, StoredPoint};
use codec::monitor::Silent;
use scene::{DemoKind, FootagePlan};
use serde_json::Value;
use tempfile::TempDir;

const FILE_NAME: &str = "tradeoff.csv";
const BASELINE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/baselines/tradeoff.csv");

/// Returns a folder with `scene`, which is created once; tests write into the same folder.
fn place() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let make = || {
        let folder = TempDir::new().unwrap();
        let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 6, face_size: 32, probes: 1 };
        plan.write(&folder.path().join("scene"), &Silent).unwrap();
        folder
    };
    FOLDER.get_or_init(make).path()
}

/// Returns the points stored in a folder.
fn rows(folder: &Path) -> Vec<StoredPoint> {
    Store::open(&CODING, folder, None).unwrap().rows
}

/// Runs `lightfold tradeoff` with the arguments of a line.
fn tradeoff(line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.arg("tradeoff").args(line.split(' ')).current_dir(place()).output().unwrap()
}

#[track_caller]
fn json(line: &str) -> Value {
    let output = tradeoff(line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Returns the message of a command that must be refused.
#[track_caller]
fn refused(line: &str) -> String {
    let output = tradeoff(line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(crate::commands::code_of(&said)), "{line}: {said}");
    assert!(output.stdout.is_empty(), "{line}");
    said
}

/// True if a measure is the same in every run.
fn is_steady(name: &str) -> bool {
    !["seconds", "runs", "passes", "ms", "megapixels", "peak"].iter().any(|word| name.contains(word))
}

fn steady(point: &Value) -> BTreeMap<&str, &Value> {
    let names = CODING.measures.iter().map(|measure| measure.name);
    names.filter(|name| is_steady(name)).map(|name| (name, &point[name])).collect()
}

#[test]
fn bytes_and_decibels_are_the_same_on_every_run_and_kept_runs_are_not_repeated() {
    let sweep = "scene --sweep psnr=30,50 --sweep max-error=0,100 --repeats 2 --json -o";
    let first = json(&format!("{sweep} same-1"));
    let second = json(&format!("{sweep} same-2"));
    let points = |report: &Value| report["points"].as_array().unwrap().clone();
    assert_eq!(points(&first).len(), 4);
    for (a, b) in points(&first).iter().zip(&points(&second)) {
        assert_eq!((&a["kind"], &a["settings"], steady(a)), (&b["kind"], &b["settings"], steady(b)));
        for name in ["encode_runs", "decode_runs"] {
            assert_eq!(a[name].as_array().unwrap().len(), 2);
        }
        assert!(a["ratio_percent"].as_f64().unwrap() > 0.0);
        assert_eq!((a["frames"].as_u64(), a["images"].as_u64()), (Some(6), Some(36)));
        let is_color = a["kind"] == "color";
        assert_eq!((a["ssim"].is_number(), a["max_error_codes"].is_number()), (is_color, !is_color));
    }
    // The depth point with the default bound is first, followed by the colour points; lossless depth is last.
    assert_eq!(points(&first)[0]["settings"]["max-error"], "100");
    assert_eq!(points(&first)[3]["psnr_db_is"], "inf");
    let csv = std::fs::read(place().join("same-1").join(FILE_NAME)).unwrap();
    let again = json(&format!("{sweep} same-1"));
    assert_eq!(points(&again), points(&first), "seconds would have changed");
    assert_eq!(std::fs::read(place().join("same-1").join(FILE_NAME)).unwrap(), csv);
    for name in ["index.html", "tradeoff.json", "color-rate-distortion.svg", "color-rate-distortion.png"] {
        assert!(place().join("same-1").join(name).is_file(), "{name}");
    }
    assert!(first["findings"].as_array().unwrap().len() >= 5);
    // A sweep of another parameter keeps the existing points.
    let cells = json("scene --sweep color-cell=8,64 --repeats 1 --json -o same-1");
    assert_eq!(points(&cells)[0]["studies"], serde_json::json!(["color-color-cell"]));
    let listed: Vec<_> = cells["files"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    for name in ["color-psnr.svg", "color-color-cell.svg", "tradeoff.csv", "tradeoff.json", "index.html"] {
        assert!(listed.contains(&name) && place().join("same-1").join(name).is_file(), "{name}: {listed:?}");
    }
    let rows = rows(&place().join("same-1"));
    assert_eq!(rows.iter().filter(|row| row.studies == ["color-psnr"]).count(), 2);
}

#[test]
fn what_is_of_something_else_is_refused_or_replaced() {
    json("scene --sweep psnr=30,50 --repeats 1 --json -o other");
    let folder = place().join("other");
    std::fs::write(folder.join("notes.txt"), "mine").unwrap();
    let csv = std::fs::read(folder.join(FILE_NAME)).unwrap();
    // An option that applies to all points makes them points of another sweep.
    let sweep = "scene --sweep max-error=0,90 --repeats 1 -o other";
    let said = refused(&format!("{sweep} -- --near 0.01"));
    assert!(
        said.contains("2 points are of other footage, options, machine or version of lightfold: use another folder"),
        "{said}"
    );
    assert!(said.contains("--overwrite"), "{said}");
    assert_eq!(std::fs::read(folder.join(FILE_NAME)).unwrap(), csv);
    assert!(folder.join("color-psnr.png").is_file());
    json(&format!("{sweep} --overwrite --json -- --near 0.01"));
    assert_eq!(rows(&folder).len(), 2);
    assert!(!folder.join("color-psnr.png").exists() && !folder.join("color-rate-distortion.svg").exists());
    assert!(folder.join("depth-max-error.png").is_file() && folder.join("notes.txt").is_file());
    // The modification time does not identify footage: points of a touched manifest are reused.
    let file = std::fs::File::options().write(true).open(place().join("scene/lightfield.json")).unwrap();
    file.set_modified(std::time::SystemTime::UNIX_EPOCH).unwrap();
    json(&format!("{sweep} --json -- --near 0.01"));
}

#[test]
fn a_folder_is_for_one_at_a_time() {
    let folder = place().join("locked");
    std::fs::create_dir_all(folder.join(".lightfold.old.partial")).unwrap();
    let lock = std::fs::File::create(folder.join(".tradeoff.lock")).unwrap();
    lock.lock().unwrap();
    let said = refused("scene --sweep color-cell=8 --repeats 1 -o locked");
    assert!(said.contains("another tradeoff process writes to it"), "{said}");
    drop(lock);
    json("scene --sweep color-cell=8 --repeats 1 --json -o locked");
    let hidden = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    let hidden: Vec<_> = hidden.filter(|name| name.to_string_lossy().starts_with('.')).collect();
    assert!(hidden.is_empty(), "{hidden:?}");
}

#[test]
fn one_point_that_fails_is_told_and_the_others_are_measured() {
    let line = "scene --sweep color-cell=6,8 --repeats 1 -o hole --json -- --color-block bc7";
    let output = tradeoff(line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("lightfold: 1 of 2 points failed") && said.contains("color with color-cell=6"), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["points"].as_array().unwrap().len(), 1);
    assert!(report["failed"][0]["error"].as_str().unwrap().contains("multiple of 4"), "{report}");
    assert!(
        report["left_out"][0].as_str().unwrap().starts_with("Point color with color-cell=6 color-block=bc7 failed: "),
        "{report}"
    );
    assert!(place().join("hole/index.html").is_file());
}

#[test]
fn settings_that_a_knob_brings_along_are_told() {
    let said = |line: &str| {
        let output = tradeoff(line);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        said
    };
    let told = said("scene --sweep max-aabbs=1,2 --repeats 1 -o implied");
    assert_eq!(told, "depth is measured with --depth-codec aabb, because max-aabbs needs it\n");
    assert_eq!(said("scene --sweep max-aabbs=1,2 --repeats 1 -q -o implied"), "");
    assert_eq!(said("scene --sweep max-aabbs=1,2 --repeats 1 -o given -- --depth-codec aabb"), "");
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn tiles_are_modelled_as_the_options_say() {
    let of = |name: &str, more: &str| {
        let preset = "scene/probe_00/face_nz/depth.%04d.exr --preset paper --stream depth --budget-seconds 0.001";
        // A third of the budget is too short to model any tile.
        let late = json(&format!("{preset} -o {name}-late --json -- --face nz --frames 0-0{more}"));
        let told = late["left_out"].as_array().unwrap();
        let is_told = |said: &Value| said.as_str().unwrap().starts_with("The statistics of tiles were left out");
        assert!(told.iter().any(is_told) && late["tiles"].is_null(), "{told:?}");
        let preset = preset.replace("0.001", "60");
        json(&format!("{preset} --repeats 1 -o {name} --json -- --face nz --frames 0-0{more}"))["tiles"].clone()
    };
    let (usual, inverse) = (of("tiles-1", ""), of("tiles-2", " --depth-domain inverse --effort normal"));
    assert_eq!(usual["how"], "effort fast, domain log");
    assert_eq!(inverse["how"], "effort normal, domain inverse");
    assert_ne!(usual["models"], inverse["models"]);
}

#[test]
fn what_makes_no_sense_is_refused_in_a_sentence_before_anything_runs() {
    for (line, said) in [
        ("scene --sweep cells=8 -o no", "'cells' is not a knob"),
        ("scene --sweep color-cell=0 -o no", "'0' for '--color-cell"),
        ("scene --sweep color-cell=8,8 -o no", "value 8 twice"),
        ("scene --sweep psnr=30,loud -o no", "'loud' for '--psnr"),
        ("scene --sweep psnr=300 -o no", "color with psnr=300: --psnr 300: 0 to 200 dB"),
        (
            "scene --sweep depth-codec=aabb --sweep max-error=0 -o no",
            "depth with depth-codec=aabb max-error=0: --max-error does not apply",
        ),
        ("scene --sweep psnr --stream depth -o no", "for color streams"),
        ("scene --sweep psnr --stream material -o no", "--stream material: scene has no such streams"),
        ("scene --sweep psnr -o no -- --psnr 40", "--psnr: study color-psnr sweeps it"),
        ("scene --sweep psnr -o no -- --stream color", "tradeoff sets this option"),
        ("scene --sweep psnr -o no -- --pnsr 40", "unexpected argument '--pnsr'"),
        ("scene -o no", "nothing to measure"),
        ("nowhere --sweep psnr -o no", "--stream depth or --stream color"),
        ("scene/lightfield.json --sweep psnr -o scene/lightfield.json", "scene/lightfield.json"),
        ("-o no", "MANIFEST"),
        ("--recommend -o no", "--recommend needs a limit"),
        ("--recommend --max-error 3 -o no -- --hdr", "need footage to measure"),
        ("--recommend --max-error 3 --budget-seconds 3 -o no", "need footage to measure"),
        ("scene --sweep psnr --weights 1e308,1e308 -o no", "two numbers"),
        ("scene --sweep psnr -o no -- --help", "before --"),
        ("--recommend --max-error 3 -o no", "no points have been measured"),
        ("scene --sweep psnr --max-error 3 -o no", "--recommend"),
        ("scene --sweep psnr --weights 0,0 -o no", "not both 0"),
        ("scene --sweep psnr --budget-seconds 0 -o no", "more than 0"),
    ] {
        let words = refused(line);
        assert!(words.contains(said), "{line}: {words}");
    }
    assert!(!place().join("no").exists());
}

#[test]
fn a_failing_point_is_an_error_that_names_its_command() {
    // Cells in texture blocks must consist of whole blocks, which only encoding checks.
    let said = refused("scene --sweep color-cell=6 -o fails -- --color-block bc7");
    assert!(
        said.starts_with("lightfold: lightfold encode scene --stream=color --color-cell=6 --color-block=bc7"),
        "{said}"
    );
    assert!(said.contains("multiple of 4"), "{said}");
    let left: Vec<_> = std::fs::read_dir(place().join("fails")).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_lone_sequence_is_measured_and_recommended_from() {
    let sequence = "scene/probe_00/face_px/depth.%04d.exr --stream depth";
    let options = "--repeats 1 -o alone --json -- --face px --frames 1-3";
    let ask = "--recommend --max-error 60 --min-psnr 99";
    let report = json(&format!("{sequence} --sweep max-error=0,50,200 {ask} {options}"));
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 3);
    assert_eq!((points[0]["frames"].as_u64(), points[0]["images"].as_u64()), (Some(3), Some(3)));
    assert_eq!(points[0]["max_error_codes"], 0);
    let command = points[0]["command"].as_str().unwrap();
    assert!(
        command.starts_with("lightfold encode-depth scene/probe_00/face_px/depth.%04d.exr --max-error=0 "),
        "{command}"
    );
    let words = command.split(' ').skip(1);
    let done = Command::new(env!("CARGO_BIN_EXE_lightfold")).args(words).current_dir(place()).output().unwrap();
    assert!(done.status.success(), "{command}: {}", String::from_utf8_lossy(&done.stderr));
    let bytes = std::fs::metadata(place().join("point.lfold")).unwrap().len();
    assert_eq!(points[0]["bytes_container"], bytes);
    let allowed = points.iter().filter(|point| point["max_error_codes"].as_u64() <= Some(60));
    let smallest = allowed.min_by_key(|point| point["bytes_container"].as_u64()).unwrap();
    assert_eq!(report["recommended"][0]["point"], *smallest);
    assert_ne!(smallest["settings"]["max-error"], "200");
    // The recommendation is the same from the stored points.
    let later = json("--recommend --max-error 60 -o alone --json");
    assert_eq!(later["recommended"], report["recommended"]);
    let none = tradeoff("--recommend --max-error 60 --max-bytes 10 -o alone");
    assert_eq!(none.status.code(), Some(1));
    let said = String::from_utf8(none.stdout).unwrap();
    assert!(said.contains("no point meets all limits") && said.contains("misses --max-bytes 10: it has "), "{said}");
}

#[test]
fn a_budget_is_kept_by_leaving_out_what_is_named() {
    let report =
        json("scene --sweep psnr=30,40,50 --sweep max-error=0,100 --repeats 2 --budget-seconds 0.001 --json -o budget");
    let left_out = report["left_out"].as_array().unwrap();
    assert!(left_out[0].as_str().unwrap().contains("Study depth-max-error was left out"), "{left_out:?}");
    assert!(left_out[1].as_str().unwrap().contains("psnr 40, 50 did not fit"), "{left_out:?}");
    let values: Vec<_> = report["points"].as_array().unwrap().iter().map(|point| &point["settings"]["psnr"]).collect();
    assert_eq!(values, ["30"]);
    assert!(
        report["points"].as_array().unwrap().iter().all(|point| point["encode_runs"].as_array().unwrap().len() == 1)
    );
}

#[test]
#[cfg(unix)]
fn an_interrupted_sweep_goes_on_where_it_was() {
    let arguments = ["tradeoff", "scene", "--sweep", "psnr=30,35,40,45", "--repeats", "3", "-o", "stopped"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let child =
        command.args(arguments).current_dir(place()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let folder = place().join("stopped");
    let start = std::time::Instant::now();
    while Store::open(&CODING, &folder, None).map_or(0, |store| store.rows.len()) < 2 {
        assert!(start.elapsed().as_secs() < 60, "no point was measured within a minute");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let stopped = child.wait_with_output().unwrap();
    let said = String::from_utf8(stopped.stderr).unwrap();
    assert_eq!(stopped.status.code(), Some(130), "{said}");
    assert!(said.contains("; the same command continues from there"), "{said}");
    let kept = rows(&folder);
    assert!((2..=4).contains(&kept.len()));
    let left = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let left: Vec<String> = left.filter(|name| !name.starts_with("crop-color-")).collect();
    assert_eq!(left.len(), 1, "only the CSV and the pictures of its points are left: {left:?}");
    let report = json("scene --sweep psnr=30,35,40,45 --repeats 3 --json -o stopped");
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 4);
    let all = rows(&folder);
    for (before, after) in kept.iter().zip(&all) {
        assert_eq!(before.measured.point, after.measured.point);
        assert!(after.measured.runs("encode_runs").starts_with(before.measured.runs("encode_runs")));
        assert_eq!(
            before.measured.count("encode_peak_bytes"),
            after.measured.count("encode_peak_bytes"),
            "surveyed once"
        );
        assert_eq!(after.measured.runs("decode_runs").len(), 3);
    }
}

#[test]
fn a_process_ends_with_the_one_that_started_it() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let words = ["tradeoff", "scene", "--sweep", "psnr", "--repeats", "1000", "-o", "orphan"];
    command.args(words).env("LIGHTFOLD_ENDS_WITH_INPUT", "1").current_dir(place());
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none());
    drop(child.stdin.take());
    let start = std::time::Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if start.elapsed().as_secs() > 10 => {
                child.kill().unwrap();
                panic!("it still runs");
            }
            None => std::thread::sleep(std::time::Duration::from_millis(5)),
        }
    };
    assert_eq!(status.code(), Some(130));
}

/// Infeasible budgets are listed with the measured points.
#[test]
fn budgets_of_simplify_are_swept_and_what_is_infeasible_is_no_failure() {
    let plan = FootagePlan { kind: DemoKind::Interior, frames: 1, face_size: 16, probes: 2 };
    plan.write(&place().join("room"), &Silent).unwrap();
    let sweep = "room --sweep sizing=adaptive,uniform --sweep triangles=4,40,400 --repeats 1 -o simplified";
    let report = json(&format!("{sweep} --json -- --effort fast --atlas 96"));
    let points = report["points"].as_array().unwrap();
    assert!(points.len() == 4 && points.iter().all(|point| point["triangles"].as_u64().unwrap() <= 400), "{report}");
    let failed = report["failed"].as_array().unwrap();
    assert!(failed.len() == 2 && failed.iter().all(|point| point["is_infeasible"] == true), "{report}");
    let said = failed[0]["error"].as_str().unwrap();
    assert!(said.contains("the minimum is 12"), "{said}");
    let findings = report["findings"].as_array().unwrap();
    let verdict = |name: &str| findings.iter().find(|finding| finding["name"] == name).unwrap()["verdict"].clone();
    assert_ne!(verdict("triangles_close_cracks"), "not measured");
    assert_eq!(verdict("area_closes_cracks"), "not measured");
    let folder = place().join("simplified");
    for name in ["simplification.csv", "simplification.json", "simplification.svg", "index.html"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains("triangles=4 atlas=96 effort=fast sizing=adaptive is infeasible"), "{page}");
    let all = refused("room --sweep triangles=2,4 --repeats 1 -o none -- --effort fast");
    assert!(all.contains("the minimum is 12"), "{all}");
}

/// A rendering sweep writes all files that its report names, including the page; a different kind of sweep into the same folder
/// is refused.
#[test]
fn options_of_render_are_swept_over_a_probe_that_is_left_out() {
    let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 1, face_size: 24, probes: 3 };
    plan.write(&place().join("three"), &Silent).unwrap();
    let sweep = "three --sweep views=1,2 --sweep steps=4,16 --repeats 1 -o rendered";
    let report = json(&format!("{sweep} --json -- --reference-probe 02"));
    assert_eq!((report["probe"].as_str(), report["points"].as_array().unwrap().len()), (Some("02"), 4));
    let folder = place().join("rendered");
    let mut names: Vec<_> =
        folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let pictures = ["rendering-time-psnr.png", "rendering-time-psnr.svg", "rendering.png", "rendering.svg"];
    let expected = [&["index.html"][..], &pictures[..2], &["rendering.csv", "rendering.json"], &pictures[2..]].concat();
    assert_eq!(names, expected);
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(
        page.contains("What rendering costs: three") && page.contains("4 points in 1 grid. Probe 02 was left out"),
        "{page}"
    );
    assert_eq!((page.matches("<svg ").count(), page.matches("<tr>").count()), (2, 1 + 4));
    assert!(page.contains("--views=1 --steps=4 --null"), "{page}");
    assert!(refused(&format!("{sweep} -- --reference-probe 02")).contains("--overwrite"));
    let other = refused("scene --sweep color-cell=8 --repeats 1 -o rendered");
    assert!(other.contains("index.html") && other.contains("another folder"), "{other}");
    let mine = place().join("mine");
    std::fs::create_dir(&mine).unwrap();
    std::fs::write(mine.join("index.html"), "mine").unwrap();
    let said = refused(&format!("{sweep} -- --reference-probe 02").replace("-o rendered", "-o mine"));
    assert!(said.contains("index.html") && std::fs::read(mine.join("index.html")).unwrap() == b"mine", "{said}");
    let words = tradeoff(&format!("{sweep} --overwrite -- --reference-probe 02"));
    let said = String::from_utf8(words.stdout).unwrap();
    assert!(said.contains("rendered/index.html") && said.contains("PSNR dB"), "{said}");
}

#[test]
fn the_knobs_are_listed() {
    let listed = json("--list-knobs --json");
    assert!(listed["knobs"].as_array().unwrap().len() > 15);
    let text = String::from_utf8(tradeoff("--list-knobs").stdout).unwrap();
    assert!(text.contains("max-aabbs") && text.contains("1,2,4,8,16"), "{text}");
}

#[test]
fn a_decoder_is_run_several_times() {
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.args(line.split(' ')).current_dir(place()).output().unwrap()
    };
    assert!(run("encode scene --clip -o repeat.lfold").status.success());
    let report: Value = serde_json::from_slice(&run("decode repeat.lfold --null --repeat 4 --json").stdout).unwrap();
    let mut runs: Vec<f64> =
        report["runs_seconds"].as_array().unwrap().iter().map(|run| run.as_f64().unwrap()).collect();
    runs.sort_by(f64::total_cmp);
    assert_eq!(runs.len(), 4);
    assert_eq!(report["seconds"].as_f64().unwrap(), (runs[1] + runs[2]) / 2.0);
    assert_eq!(report["frames"], 6 * 6 * 2);
    #[cfg(target_os = "linux")]
    assert!(report["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
    assert_eq!(run("decode repeat.lfold --repeat 4 -o x").status.code(), Some(2));
}

/// Runs the sweep of the baseline. Texture block formats are excluded, because their encoders depend slightly on the processor.
fn baseline_rows() -> Vec<(String, [Option<f64>; 3])> {
    let of = |sweeps: &str| json(&format!("scene {sweeps} --repeats 1 -o baseline --json"));
    let cells = of("--sweep color-codec=cells --sweep color-cell=16,64 --sweep psnr=30,45");
    let transform = of("--sweep color-chunk=2,24 --sweep color-cell=16,64 --sweep psnr=30,45");
    let more =
        of("--sweep depth-codec=quadtree,aabb,bc4w --sweep depth-window=1,4 --sweep lzma2=none,6 --stream depth");
    let points = [cells, transform, more].into_iter().flat_map(|report| report["points"].as_array().unwrap().clone());
    let number = |point: &Value, key: &str| {
        point[key].as_f64().or_else(|| (point[format!("{key}_is")] == "inf").then_some(f64::INFINITY))
    };
    let row = |point: &Value| {
        let settings = point["settings"].as_object().unwrap().iter();
        let settings = settings.map(|(name, value)| format!("{name}={}", value.as_str().unwrap())).collect::<Vec<_>>();
        let key = format!("{},{}", point["kind"].as_str().unwrap(), settings.join(" "));
        let quality = if point["kind"] == "color" { "min_psnr_db" } else { "psnr_db" };
        (key, ["bytes_container", quality, "max_error_codes"].map(|key| number(point, key)))
    };
    points.map(|point| row(&point)).collect()
}

const HEAD: &str = "kind,settings,bytes,psnr_db,max_error_codes";

fn baseline_text(rows: &[(String, [Option<f64>; 3])]) -> String {
    let mut text = format!("{HEAD}\n");
    for (key, [bytes, psnr, codes]) in rows {
        let cell = |value: &Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let psnr = psnr.map_or_else(String::new, |db| format!("{db:.3}"));
        writeln!(text, "{key},{},{psnr},{}", cell(bytes), cell(codes)).unwrap();
    }
    text
}

#[test]
fn points_of_the_demo_cost_no_more_and_are_no_worse() {
    let text = std::fs::read_to_string(BASELINE).unwrap();
    let rows = baseline_rows();
    assert_eq!(text.lines().next(), Some(HEAD));
    assert_eq!(text.lines().count(), rows.len() + 1);
    for (key, [bytes, psnr, codes]) in rows {
        let start = format!("{key},");
        let line =
            text.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("{key} has no baseline"));
        let cells: Vec<Option<f64>> = line[start.len()..].split(',').map(|cell| cell.parse().ok()).collect();
        assert_eq!((bytes.is_some(), psnr.is_some(), codes.is_some()), (true, cells[1].is_some(), cells[2].is_some()));
        assert!(bytes <= cells[0], "{key}: {bytes:?} bytes are more than {:?}", cells[0]);
        assert!(codes <= cells[2], "{key}: an error of {codes:?} codes is more than {:?}", cells[2]);
        // The file has three decimals.
        let least = cells[1].map(|db| db - 0.0005);
        assert!(psnr >= least, "{key}: {psnr:?} dB are less than {:?}", cells[1]);
    }
}

#[test]
#[ignore = "writes tests/baselines"]
fn write_baselines() {
    std::fs::write(BASELINE, baseline_text(&baseline_rows())).unwrap();
}
