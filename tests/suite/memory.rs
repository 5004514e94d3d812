//! Memory of commands: `--memory` is respected, long sequences are streamed, and repeated runs do not leak.
//!
//! The peak of a process is the `peak_memory_bytes` that `--json` reports, so every command runs as a child process.

use std::path::Path;
use std::process::Command;

use codec::color::SearchSettings;
use codec::color::cells::builder::CellBuilder;
use codec::container::{ChunkKey, Compression, PackedChunk, PayloadKind, Reader, Writer};
use codec::decode::Decoder;
use codec::depth::TemporalSettings;
use codec::image::{Face, Plane};
use codec::monitor::Silent;
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::{self, EncodeSettings};
use footage::image_files::png;
use half::f16;
use serde_json::Value;
use tempfile::TempDir;

use crate::footage::Footage;
use crate::samples::{self, Shape};

/// Writes a dataset of one face with `frames` frames. Those from `distinct` on are hard links to the first `distinct`, in
/// rotation.
fn footage(folder: &Path, size: u32, distinct: u32, frames: u32, depth_keys: &str) {
    let depth = |_: Face, frame: u32| {
        Plane::from_fn(size, size, |x, y| {
            let moves = if x / 16 == frame % 8 && y / 16 == 3 { 0.5 } else { 0.0 };
            2.0 + (x * 3 + y * 5) as f32 / size as f32 - moves
        })
    };
    let color = |_: Face, frame: u32| {
        Plane::from_fn(size, size, |x, y| {
            let noise = ((x * 7919 + y * 104_729 + frame * 6151) % 256) as f32 / 512.0;
            [noise, (x + y) as f32 / (4 * size) as f32, 0.25].map(f16::from_f32)
        })
    };
    let material = |_: Face, frame: u32| {
        Plane::from_fn(size, size, |x, y| [if (x / 8 + y / 8 + frame).is_multiple_of(5) { 1.0 } else { 0.0 }, 0.5, 1.5])
    };
    Footage {
        frames: [0, distinct - 1],
        depth: Some(&depth),
        color: Some(&color),
        material: Some(&material),
        depth_keys,
        ..Footage::new(size, size)
    }
    .write(folder);
    for kind in ["depth", "color", "material"] {
        let of = |frame: u32| folder.join(format!("probe_00/face_px/{kind}.{frame:04}.exr"));
        for frame in distinct..frames {
            std::fs::hard_link(of(frame % distinct), of(frame)).unwrap();
        }
    }
    let path = folder.join("lightfield.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let (old, new) = (format!("\"frames\": [0, {}]", distinct - 1), format!("\"frames\": [0, {}]", frames - 1));
    assert!(text.contains(&old));
    std::fs::write(path, text.replace(&old, &new)).unwrap();
}

/// Writes a dataset of four faces as PNG files with alpha.
fn transparent(folder: &Path, size: u32) {
    std::fs::create_dir(folder).unwrap();
    for (at, face) in Face::CUBE.into_iter().take(4).enumerate() {
        let codes = Plane::from_fn(size, size, |x, y| [x as u8, y as u8, (x ^ y) as u8, (x + y + 9 * at as u32) as u8]);
        png::write_rgba8(&folder.join(format!("{}.0000.png", face.name())), &codes).unwrap();
    }
    let manifest = serde_json::json!({
        "lightfield": 1, "name": "rgba", "fps": 24, "frames": [0, 0], "projection": "cubemap", "size": [size, size],
        "faces_present": ["px", "nx", "py", "ny"],
        "files": { "color": "{face}.%04d.png", "alpha": "{face}.%04d.png" },
        "probes": [{ "name": "a", "position": [0, 0, 0] }],
    });
    std::fs::write(folder.join("lightfield.json"), manifest.to_string()).unwrap();
}

/// Exit code, JSON report and standard error of a command line.
struct Ran {
    code: i32,
    report: Value,
    said: String,
}

fn run(line: &str, folder: &Path) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.args(line.split(' ')).args(["--json", "--quiet"]).current_dir(folder);
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let report = serde_json::from_slice(&output.stdout).unwrap_or(Value::Null);
    Ran { code: output.status.code().unwrap(), report, said }
}

/// Runs a command that must succeed and returns its peak in bytes. `diff` may find differences.
#[track_caller]
fn peak(line: &str, folder: &Path) -> u64 {
    let ran = run(line, folder);
    assert!(ran.code == 0 || line.starts_with("diff") && ran.code == 1, "{line}: {}", ran.said);
    ran.report["peak_memory_bytes"].as_u64().unwrap()
}

/// Parses the MB that a refused command asks for.
#[cfg(target_os = "linux")]
fn asked_mb(said: &str) -> u64 {
    let (_, after) = said.split_once("needs up to ").unwrap_or_else(|| panic!("{said}"));
    after.split_once(" MB").unwrap().0.parse().unwrap()
}

/// Runs a command line with budgets of 1 to 384 MiB. Each run is either refused before it writes anything, or stays within the
/// budget and gives the same result. The budget that a refusal asks for suffices.
#[cfg(target_os = "linux")]
fn check_budgets(line: &str, output: Option<&str>, folder: &Path) {
    let result = |name: &str| std::fs::read(folder.join(name)).ok();
    assert_eq!(run(line, folder).code, 0, "{line}");
    let expected = output.map(|name| result(name).unwrap());
    let (mut refused, mut kept, mut asked) = (0, 0, 0);
    for budget in [1u64, 24, 48, 64, 96, 192, 384] {
        if let Some(name) = output {
            std::fs::remove_file(folder.join(name)).ok();
        }
        let ran = run(&format!("{line} --memory {budget}MiB --threads 4"), folder);
        if ran.code == 2 {
            assert!(ran.said.contains("--memory") && ran.said.contains("increase it to that"), "{line}: {}", ran.said);
            assert_eq!(ran.said.lines().filter(|line| line.starts_with("lightfold: ")).count(), 1, "{}", ran.said);
            assert!(output.is_none_or(|name| result(name).is_none()), "{line}: something was written");
            assert_eq!(kept, 0, "{line}: {budget} MiB are refused, and less was not");
            asked = asked_mb(&ran.said);
            refused += 1;
            continue;
        }
        assert_eq!(ran.code, 0, "{line}: {}", ran.said);
        let peak = ran.report["peak_memory_bytes"].as_u64().unwrap();
        assert!(peak <= budget << 20, "{line}: {peak} bytes with a budget of {budget} MiB");
        assert_eq!(output.map(|name| result(name).unwrap()), expected, "{line}: another result");
        kept += 1;
    }
    assert!(refused > 0 && kept > 0, "{line}: {refused} refused, {kept} kept");
    Least::of(&format!("{line} --threads 4"), asked, folder);
}

/// Run of a command with the smallest budget that it asks for.
#[cfg(target_os = "linux")]
struct Least {
    asked_mb: u64,
    peak_bytes: u64,
    /// Number of refusals before the run.
    refusals: u32,
}

#[cfg(target_os = "linux")]
impl Least {
    /// Tries a budget of `mb` MB first, then those that refusals ask for: several stages may ask one after the other.
    fn of(line: &str, mb: u64, folder: &Path) -> Least {
        let within = |mb: u64| run(&format!("{line} --memory {mb}M"), folder);
        let (mut asked, mut refusals, mut ran) = (mb, 0, within(mb));
        while ran.code == 2 {
            let more = asked_mb(&ran.said);
            assert!(more > asked, "{line}: {asked} MB are refused, and asked for: {}", ran.said);
            (asked, refusals, ran) = (more, refusals + 1, within(more));
        }
        assert_eq!(ran.code, 0, "{line}: {}", ran.said);
        let peak = ran.report["peak_memory_bytes"].as_u64().unwrap();
        assert!(peak <= asked * 1_000_000, "{line}: {peak} bytes, where {asked} MB were asked for");
        Least { asked_mb: asked, peak_bytes: peak, refusals }
    }

    /// True if the budget is at most twice the peak.
    fn is_near(&self) -> bool {
        2 * self.peak_bytes >= self.asked_mb * 1_000_000
    }
}

#[cfg(target_os = "linux")]
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn budgets_of_simplifying_and_rendering_are_at_most_twice_what_is_taken() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let cameras = "--position -0.1,1.5,0.3 --position 0.1,1.5,0.3 --projection perspective --fov 60 --size 512x512";
    let captured = run(&format!("capture interior {cameras} --samples 1 --frames 0 --aov depth,material -o views"), at);
    assert_eq!(captured.code, 0, "{}", captured.said);
    assert_eq!(run("encode views --clip -o film.lfold", at).code, 0);
    let eye = "--eye 0.05,1.5,0.3 --look-at 0,1.2,-3 --fov 60";
    for (line, max_refusals, is_known) in [
        // The memory of textures is known only after the tiles are selected.
        ("simplify views --effort fast -o scene.glb".to_owned(), 3, true),
        (format!("render film.lfold {eye} --size 512 --steps 64 --effects none -o picture.png"), 1, true),
        // Memory for maps of sixteen glass spheres is reserved, although there are none.
        (format!("render film.lfold {eye} --size 512 --steps 64 -o picture.png"), 1, false),
    ] {
        for threads in [1, 4] {
            let line = format!("{line} --threads {threads}");
            let least = Least::of(&line, 1, at);
            let Least { asked_mb, peak_bytes, refusals } = least;
            assert!(!is_known || least.is_near(), "{line}: {asked_mb} MB asked for, {peak_bytes} bytes taken");
            assert!(refusals <= max_refusals, "{line}: {refusals} refusals");
        }
    }
    // A run whose budget suffices for the tiles only leaves no file.
    let line = "simplify views --effort fast -o other.glb --threads 1";
    let early = asked_mb(&run(&format!("{line} --memory 1M"), at).said);
    if run(&format!("{line} --memory {early}M"), at).code == 2 {
        let left: Vec<_> = std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(left.iter().all(|name| !name.to_string_lossy().contains("other")), "{left:?}");
    }
}

#[cfg(target_os = "linux")]
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn a_budget_is_kept_or_refused_by_every_command() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    footage(at, 384, 4, 40, "");
    for (kind, options) in [
        ("color", "--lookahead 16"),
        ("depth", "--depth-codec aabb"),
        ("depth", "--depth-codec quadtree --effort fast --max-error 2000"),
        ("material", "--keyframe-interval 8"),
    ] {
        check_budgets(&format!("encode . -o a.lfold --stream {kind} {options}"), Some("a.lfold"), at);
    }
    let sequence = "probe_00/face_px/depth.%04d.exr --frames 0-7";
    check_budgets(&format!("bc4w {sequence} --effort fast -o b.lfold"), Some("b.lfold"), at);
    check_budgets(&format!("quadtree {sequence} --effort fast -o t.lfold"), Some("t.lfold"), at);
    check_budgets("pack t.lfold --max-error 200 --effort fast -o p.lfold", Some("p.lfold"), at);
    run("encode . -o all.lfold --depth-codec aabb --lookahead 16", at);
    check_budgets("pack all.lfold --lzma2=1 -o q.lfold", Some("q.lfold"), at);
    check_budgets("inspect q.lfold --verify", None, at);
    check_budgets("decode q.lfold --null", None, at);
    check_budgets("decode q.lfold --frames 0-3 -o frames", None, at);
    check_budgets("diff . q.lfold --frames 0-9 --ssim none", None, at);
    transparent(&at.join("rgba"), 512);
    check_budgets("encode rgba -o rgba.lfold", Some("rgba.lfold"), at);
    check_budgets("decode rgba.lfold -o back", None, at);
    // The estimate for rendering counts all chunks that views may load, so this container has few frames.
    run("encode . -o r.lfold --frames 0-3 --depth-codec aabb", at);
    let eye = "--eye 0.1,1,2 --look-at 1,1,2 --fov 60 --steps 8";
    for (line, output) in [
        (format!("render r.lfold {eye} --frames 0-3 --size 384 -o view.%04d.png"), "view.0003.png"),
        (
            format!("render r.lfold {eye} --frames 1 --size 768 --stereo side-by-side --effects none -o two.exr"),
            "two.exr",
        ),
        (format!("render r.lfold {eye} --frames 1 --size 768 --method splat -o points.png"), "points.png"),
        (
            "render r.lfold --reference . --reference-probe 00 --frames 0 --steps 8 --effects none -o again.png"
                .to_owned(),
            "again.png",
        ),
        // One row has two million rays.
        (format!("render r.lfold {eye} --frames 1 --size 8192x4 --samples 16 --effects none -o wide.png"), "wide.png"),
    ] {
        check_budgets(&line, Some(output), at);
    }
    for line in [
        "decode q.lfold --null --memory 64M --device gpu",
        &format!("render r.lfold {eye} --null --memory 64M --device gpu"),
    ] {
        let refused = run(line, at);
        assert_eq!(refused.code, 2, "{}", refused.said);
        assert!(refused.said.contains("leave out one of them"), "{}", refused.said);
    }
    assert_eq!(run("encode . -o a.lfold --memory lots", at).code, 2);
}

/// Inspects a chunk of one pixel and a million frames that have a weight.
#[cfg(target_os = "linux")]
#[test]
fn a_chunk_of_many_weights_is_inspected_within_its_budget() {
    let folder = TempDir::new().unwrap();
    let mut cell = CellBuilder::default();
    cell.push_keyframe(&[0u8; 3]);
    cell.push_weight(7, 1_000_000);
    cell.push_keyframe(&[9u8; 3]);
    let frame_count = cell.frame_count();
    let shape = Shape { face: 0, size: [1, 1], unit: [1, 1], first_frame: 0, frame_count };
    let stream = samples::cells_by_hand(shape, &samples::color8_header(&SearchSettings::default()), vec![cell]);
    let film = samples::container(0, samples::probe("a", frame_count - 1), &[stream], Compression::None);
    std::fs::write(folder.path().join("film.lfold"), film).unwrap();
    for line in ["inspect film.lfold --verify --threads 1", "inspect film.lfold --per-frame --frames 9 --threads 4"] {
        let least = Least::of(line, 1, folder.path());
        assert!(least.peak_bytes > 48 << 20, "{line}: {} bytes, without its events", least.peak_bytes);
    }
}

/// Writes a dataset of one face that shows a grid of glass balls in front of a wall.
fn beads(folder: &Path, size: u32, grid: u32) {
    const AWAY_M: f64 = 2.0;
    const WALL_M: f64 = 5.0;
    let radius_m = 0.6 * AWAY_M / f64::from(grid);
    // Returns the distance in metres of the nearest ball in a pixel, if there is one.
    let bead_m = |face: Face, x: u32, y: u32| {
        let to = face.direction(x, y, size).normalize();
        let [forward, right, down] = face.axes();
        let met_m = |at: u32| {
            let [u, v] = [at % grid, at / grid].map(|at| f64::from(2 * at + 1) / f64::from(grid) - 1.0);
            let centre = AWAY_M * (forward + u * right + v * down);
            let along_m = centre.dot(to);
            let squared = radius_m * radius_m - (centre.length_squared() - along_m * along_m);
            (squared > 0.0).then(|| along_m - squared.sqrt())
        };
        (0..grid * grid).filter_map(met_m).reduce(f64::min)
    };
    let wall_m = |face: Face, x: u32, y: u32| WALL_M / face.direction(x, y, size).normalize().dot(face.axes()[0]);
    let depth = |face: Face, _: u32| {
        Plane::from_fn(size, size, |x, y| bead_m(face, x, y).unwrap_or_else(|| wall_m(face, x, y)) as f32)
    };
    let color = |_: Face, _: u32| {
        Plane::from_fn(size, size, |x, y| [x, y, x + y].map(|at| f16::from_f32(at as f32 / (2 * size) as f32)))
    };
    let material = |face: Face, _: u32| {
        let of = |bead_m: Option<f64>| if bead_m.is_some() { [0.0, 1.0, 1.5] } else { [0.0, 0.0, 1.0] };
        Plane::from_fn(size, size, |x, y| of(bead_m(face, x, y)))
    };
    Footage {
        frames: [0, 0],
        depth: Some(&depth),
        color: Some(&color),
        material: Some(&material),
        depth_keys: ", \"near\": 1, \"far\": 12",
        ..Footage::new(size, size)
    }
    .write(folder);
}

#[cfg(target_os = "linux")]
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn a_budget_is_kept_where_there_is_glass() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    beads(at, 256, 4);
    assert_eq!(run("encode . -o beads.lfold", at).code, 0);
    let line = "render beads.lfold --eye 0.1,1,2 --look-at 1,1,2 --fov 80 --steps 16 --size 20 --samples 8 --stats -o beads.png";
    let all = run(line, at);
    assert!(all.report["secondary_rays"].as_u64() > Some(1000), "{}", all.report);
    check_budgets(line, Some("beads.png"), at);
}

#[cfg(target_os = "linux")]
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn a_thousand_frames_take_no_more_memory_than_a_hundred() {
    // A hundred frames fill everything that is bounded: lookahead, keyframe interval and batches.
    let [short, long] = [100u32, 1000].map(|frames| {
        let folder = TempDir::new().unwrap();
        footage(folder.path(), 64, 5, frames, ", \"near\": 1, \"far\": 12");
        folder
    });
    let sequence = "probe_00/face_px/depth.%04d.exr --near 1 --far 12 --effort fast";
    let lines = [
        "encode . --stream color -o color.lfold".to_owned(),
        "encode . --stream depth --depth-codec aabb -o depth.lfold".to_owned(),
        "encode . --stream material -o material.lfold".to_owned(),
        format!("encode-depth {sequence} -o nodes.lfold"),
        format!("quadtree {sequence} -o tree.lfold"),
        format!("bc4w {sequence} -o bc4w.lfold"),
        "pack color.lfold depth.lfold material.lfold --lzma2=1 -o all.lfold --memory 128M".to_owned(),
        "pack tree.lfold --max-error 200 --effort fast -o packed.lfold --memory 128M".to_owned(),
        "inspect all.lfold".to_owned(),
        "decode all.lfold --memory 128M --null".to_owned(),
        "decode all.lfold -o frames".to_owned(),
        "diff . all.lfold --ssim none".to_owned(),
    ];
    for line in lines {
        let [few, many] = [&short, &long].map(|folder| peak(&line, folder.path()));
        // All images of one kind take 15 to 40 MB; allocators and rows of the index may differ by a few MB.
        assert!(many <= few + (6 << 20), "{line}: {few} bytes for 100 frames, {many} for 1000");
    }
}

/// Returns a container of `count` probes of six faces, each with one depth image.
fn many_probes(count: u16) -> Vec<u8> {
    let settings = TemporalSettings::default();
    let shape = Shape { face: 0, size: [8, 8], unit: [8, 8], first_frame: 0, frame_count: 1 };
    let mut writer = Writer::new(Vec::new(), "many", 24.0, 0).unwrap();
    for probe in 0..count {
        writer.add_probe(samples::probe(&format!("p{probe}"), 0)).unwrap();
        for face in 0..6 {
            let codes = (0..64).map(|at| at + probe * 6 + u16::from(face)).collect();
            let mut stream = samples::depth(Shape { face, ..shape }, [0.5, 8.0], &[codes], settings);
            stream.entry.probe = probe;
            let index = writer.add_stream(stream.entry);
            for (unit, chunk) in stream.chunks {
                let key = ChunkKey { stream: index, unit, first_frame: 0, frame_count: 1 };
                writer
                    .push(&PackedChunk::new(key, chunk.payload, (Compression::None, PayloadKind::Mixed)).unwrap())
                    .unwrap();
            }
        }
    }
    writer.finish().unwrap().0
}

#[test]
fn one_probe_of_720_costs_what_it_holds() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("many.lfold"), many_probes(720)).unwrap();
    let one = run("decode many.lfold --probe p700 --null", folder.path());
    assert_eq!((one.code, one.report["frames"].as_u64()), (0, Some(6)), "{}", one.said);
    let all = run("decode many.lfold --null", folder.path());
    assert_eq!(all.report["frames"], 720 * 6);
    let bytes = |ran: &Ran| ran.report["bytes_read"].as_u64().unwrap();
    assert_eq!(bytes(&one) * 720, bytes(&all));
    // A dataset of as many probes is opened without reading its images: most of these files are empty.
    assert_eq!(run("decode many.lfold --probe p700 -o frames", folder.path()).code, 0);
    let at = folder.path().join("frames");
    let manifest = std::fs::read_to_string(at.join("lightfield.json")).unwrap();
    let mut manifest: Value = serde_json::from_str(&manifest).unwrap();
    let named = |probe: u16| serde_json::json!({ "name": format!("p{probe}"), "position": [f64::from(probe), 0, 0] });
    manifest["probes"] = (0..720).map(named).collect();
    std::fs::write(at.join("lightfield.json"), manifest.to_string()).unwrap();
    for probe in (0..720).filter(|probe| *probe != 700) {
        for face in Face::CUBE {
            let folder = at.join(format!("probe_p{probe}/face_{}", face.name()));
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join("depth.0000.exr"), "").unwrap();
        }
    }
    let source = Source::open(&at, &SourceOptions::default()).unwrap();
    assert_eq!((source.probes().len(), source.groups().len()), (720, 720 * 6));
    let compared = run("diff frames many.lfold --probe p700 --max-error 0", folder.path());
    assert_eq!(compared.code, 0, "{}", compared.said);
}

/// Writes a dataset of `count` probes: the first has four frames, the others are static.
fn static_probes(folder: &Path, count: u32) {
    footage(folder, 16, 4, 4, ", \"near\": 1, \"far\": 12");
    let path = folder.join("lightfield.json");
    let mut manifest: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let mut first = manifest["probes"][0].clone();
    let named = |probe: u32| {
        first["name"] = format!("{probe:02}").into();
        first["position"] = serde_json::json!([probe, 0, 0]);
        first["frames"] = serde_json::json!([0, if probe == 0 { 3 } else { 0 }]);
        first.clone()
    };
    manifest["probes"] = (0..count).map(named).collect();
    std::fs::write(path, manifest.to_string()).unwrap();
    for probe in 1..count {
        let face = folder.join(format!("probe_{probe:02}/face_px"));
        std::fs::create_dir_all(&face).unwrap();
        for kind in ["depth", "color", "material"] {
            let name = format!("{kind}.0000.exr");
            std::fs::hard_link(folder.join("probe_00/face_px").join(&name), face.join(&name)).unwrap();
        }
    }
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn memory_of_720_probes_is_in_proportion_to_them() {
    // Bytes per probe: three streams with their rows of tables, one chunk each, and file names.
    const PROBE_BYTES: u64 = 16 << 10;
    // Bytes per probe if each stream is reported: its figures, and two copies as JSON with about fifty keys of 100 bytes.
    const REPORTED_BYTES: u64 = PROBE_BYTES + 3 * (16 << 10);
    let lines = [
        ("encode . -o all.lfold", PROBE_BYTES),
        ("inspect all.lfold", REPORTED_BYTES),
        ("decode all.lfold --null", PROBE_BYTES),
        ("decode all.lfold --probe 07 --null", PROBE_BYTES),
        ("diff . all.lfold --ssim none", REPORTED_BYTES),
    ];
    let peaks = [72u32, 720].map(|count| {
        let folder = TempDir::new().unwrap();
        static_probes(folder.path(), count);
        let start = std::time::Instant::now();
        let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
        let opened = start.elapsed();
        assert_eq!((source.probes().len(), source.groups().len()), (count as usize, 3 * count as usize));
        let peaks = lines.map(|(line, _)| peak(line, folder.path()));
        let start = std::time::Instant::now();
        let decoder = Decoder::open(folder.path().join("all.lfold")).unwrap();
        assert_eq!(decoder.streams().len(), 3 * count as usize);
        // Printed for the README; no test reads it.
        eprintln!(
            "{count} probes: dataset opened in {opened:.1?}, container in {:.1?}, peaks {peaks:?}",
            start.elapsed()
        );
        peaks
    });
    for (((line, bytes), few), many) in lines.iter().zip(peaks[0]).zip(peaks[1]) {
        assert!(many <= few + 648 * bytes, "{line}: {few} bytes for 72 probes, {many} for 720");
    }
}

/// Returns the resident memory of this process in bytes.
fn resident_bytes() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

const SOAK_CYCLES: usize = 400;
const SOAK_SLACK_BYTES: u64 = 3 << 20;

/// Run by `encoding_and_decoding_again_and_again_does_not_grow` in a process of its own.
#[test]
#[ignore = "run by another test, in a process of its own"]
fn soak_child() {
    let folder = TempDir::new().unwrap();
    footage(folder.path(), 48, 3, 6, "");
    let mut settings = EncodeSettings { cell: 16, compression: Compression::Lzma2(1), ..EncodeSettings::default() };
    settings.depth.effort = codec::effort::Effort::Fast;
    let mut settled = 0;
    for cycle in 0..SOAK_CYCLES {
        let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
        let (file, _) = encode::encode(&source, &settings, Vec::new(), &Silent).unwrap();
        let decoder = Decoder::new(Reader::from_memory(file.clone()).unwrap()).unwrap();
        assert_eq!(decoder.streams().len(), 3);
        assert!(samples::decode_all(file).unwrap().iter().all(|images| images.len() == 6));
        if cycle == SOAK_CYCLES / 4 {
            settled = resident_bytes();
        }
    }
    println!("soak: {settled} bytes settled, {} in the end", resident_bytes());
}

#[cfg(target_os = "linux")]
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn encoding_and_decoding_again_and_again_does_not_grow() {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "memory::soak_child", "--ignored", "--nocapture", "--test-threads", "1"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let line = said.lines().find(|line| line.contains("soak: ")).unwrap();
    let figures: Vec<u64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [settled, end] = figures[..] else { panic!("{line}") };
    assert!(settled > 1 << 20 && end <= settled + SOAK_SLACK_BYTES, "{line}");
}
