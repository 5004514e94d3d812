//! The command line: help and error texts, exit codes, pipes and interruptions.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::Parser;
use cli::Cli;
use codec::container::Reader;
use codec::monitor::Silent;
use scene::{DemoKind, FootagePlan};
use tempfile::TempDir;

/// Help and error messages are equal to those under tests/cmd/.
#[test]
#[cfg(unix)]
fn words() {
    trycmd::TestCases::new().case("tests/cmd/*.trycmd");
}

/// Each option has one name.
#[test]
fn other_names_of_options_are_refused() {
    let place = "place courtyard --region=0,0,0,1,1,1 -o c.json";
    let encode_depth = "encode-depth z.exr -o b";
    for (line, option) in [
        ("encode a -o b", "--error=9"),
        ("encode a -o b", "--error-relative=1%"),
        ("encode a -o b", "--epsilon=9"),
        ("encode a -o b", "--tiles=4"),
        ("encode a -o b", "--keyframe-reach=9"),
        (encode_depth, "--decide=size"),
        (encode_depth, "--channel=Z"),
        ("quadtree a -o b", "--decide=size"),
        ("encode-color a -o b", "--cell=8"),
        ("pack a -o b", "--error=9"),
        ("pack a -o b", "--max-error-relative=1%"),
        ("pack a -o b", "--no-lzma2"),
        ("diff a b", "--channel=Z"),
        ("inspect a --per-frame", "--range=2-3"),
        (place, "--spread=9"),
    ] {
        let refused = Cli::try_parse_from(format!("lightfold {line} {option}").split(' ')).unwrap_err().to_string();
        let name = option.split('=').next().unwrap();
        assert!(refused.starts_with(&format!("error: unexpected argument '{name}' found")), "{refused}");
    }
    let refused = |line: &str| Cli::try_parse_from(format!("lightfold {line}").split(' ')).unwrap_err().to_string();
    let bound = refused("pack a -o b --max-error-relative 1%");
    assert!(bound.contains("tip: a similar argument exists: '--max-error'"), "{bound}");
    let goal = refused("encode a -o b --optimize mse");
    assert!(goal.contains("invalid value 'mse'") && goal.contains("quality, size"), "{goal}");
    assert!(refused("inspect a --frames").contains("a value is required"));
}

#[test]
fn usual_tiles_are_those_of_the_codec() {
    let folder = TempDir::new().unwrap();
    let encoded = |options: &[&str]| {
        let file = folder.path().join("a.lfold");
        succeeded(&output(lightfold().arg("encode").arg("--clip").arg(dataset()).args(options).arg("-o").arg(&file)));
        fs::read(&file).unwrap()
    };
    // Faces have 32x32 pixels.
    let quadtree = ["--depth-codec", "quadtree"];
    assert!(encoded(&quadtree) == encoded(&[&quadtree[..], &["--depth-tile", "16"]].concat()));
    assert!(encoded(&[]) == encoded(&["--depth-tile", "128"]));
    assert!(encoded(&["--depth-tile", "32"]) == encoded(&["--depth-tile", "16384"]));
}

#[test]
fn frames_of_inspect_need_rows_of_frames() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.lfold");
    succeeded(&output(lightfold().arg("encode").arg("--clip").arg(dataset()).arg("-o").arg(&file)));
    let rows = |options: &[&str]| output(lightfold().arg("inspect").arg(&file).arg("--csv").args(options));
    let [all, some] = [&["--per-frame"][..], &["--per-frame", "--frames", "2-3"]].map(|options| {
        let rows = rows(options);
        succeeded(&rows);
        String::from_utf8(rows.stdout).unwrap()
    });
    assert!(some.lines().count() > 1 && some.lines().all(|line| all.lines().any(|other| other == line)), "{some}");
    assert!(some.lines().count() < all.lines().count());
    let refused = rows(&["--frames", "2-3"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("needs --per-frame"), "{}", stderr(&refused));
}

fn lightfold() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.stdin(Stdio::null());
    command
}

/// Runs a command to its end, and captures standard output and standard error.
fn output(command: &mut Command) -> Output {
    command.output().unwrap()
}

#[track_caller]
fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Returns a dataset that all tests share: written once, then only read.
fn dataset() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let make = || {
        let folder = TempDir::new().unwrap();
        let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 6, face_size: 32, probes: 1 };
        plan.write(folder.path(), &Silent).unwrap();
        folder
    };
    FOLDER.get_or_init(make).path()
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn bytes_below(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_path_buf(), fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// Waits for a process to end, for at most two minutes.
fn wait(child: &mut Child) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if start.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            panic!("it did not end within two minutes");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_container_goes_through_a_pipe_whole() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.lfold");
    succeeded(&output(lightfold().arg("encode").arg("--clip").arg(dataset()).arg("-o").arg(&file)));
    let piped = output(lightfold().arg("encode").arg("--clip").arg(dataset()).args(["-o", "-"]));
    succeeded(&piped);
    assert!(piped.stdout == fs::read(&file).unwrap(), "a pipe gets other bytes than a file");

    let mut decode = lightfold()
        .args(["decode", "-", "--null", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    decode.stdin.take().unwrap().write_all(&piped.stdout).unwrap();
    let mut report = String::new();
    decode.stdout.take().unwrap().read_to_string(&mut report).unwrap();
    assert!(wait(&mut decode).success());
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["frames"], 6 * 6 * 2);
}

#[test]
fn results_go_to_standard_output_and_words_to_standard_error() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("a.lfold");
    let encoded = output(lightfold().arg("encode").arg("--clip").arg(dataset()).arg("-o").arg(&file));
    assert!(encoded.stdout.is_empty() && stderr(&encoded).contains("a.lfold"), "{encoded:?}");
    let quiet = output(lightfold().arg("encode").arg("--clip").arg(dataset()).arg("--quiet").arg("-o").arg(&file));
    // --quiet keeps warnings about clipped pixels.
    let is_clipping = |line: &str| line.contains("were clipped to 8 bits");
    assert!(quiet.stdout.is_empty() && stderr(&quiet).lines().all(is_clipping), "{quiet:?}");
    let json =
        output(lightfold().arg("encode").arg("--clip").arg(dataset()).args(["--quiet", "--json", "-o"]).arg(&file));
    let report: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(report["bytes"], fs::metadata(&file).unwrap().len());
    for key in ["seconds", "bytes", "raw_bytes", "frames"] {
        assert!(report[key].is_number(), "{key}");
    }
    let both = output(lightfold().arg("encode").arg("--clip").arg(dataset()).args(["--json", "-o", "-"]));
    assert_eq!(both.status.code(), Some(2));
    let refusal: serde_json::Value = serde_json::from_slice(&both.stdout).unwrap();
    assert_eq!(refusal["error"]["code"], 2);
}

#[test]
fn a_reader_that_goes_away_ends_a_command_quietly() {
    let (folder, dataset) = (TempDir::new().unwrap(), dataset().to_str().unwrap());
    let file = folder.path().join("a.lfold");
    succeeded(&output(lightfold().args(["encode", dataset, "--clip", "-o"]).arg(&file)));
    let file = file.to_str().unwrap();
    for arguments in [
        vec!["encode", dataset, "--clip", "-o", "-"],
        vec!["pack", file, "-o", "-"],
        vec!["inspect", file, "--json"],
        vec!["diff", dataset, file],
        vec!["render", file, "--size", "16", "-o", "-"],
        vec!["completions", "bash"],
        vec!["encode", "--help"],
    ] {
        let mut child = lightfold().args(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        assert_eq!(wait(&mut child).code(), Some(141), "{arguments:?}");
        let mut words = String::new();
        child.stderr.take().unwrap().read_to_string(&mut words).unwrap();
        assert!(!words.contains("panicked") && !words.to_lowercase().contains("pipe"), "{words}");
    }
}

/// Runs a command line on a pseudo-terminal and returns its output, with its exit code at the end; `None` without the `script`
/// command.
#[cfg(target_os = "linux")]
fn on_a_terminal(words: &str) -> Option<String> {
    let line = format!("{} {words}; echo code $?", env!("CARGO_BIN_EXE_lightfold"));
    let script = Command::new("script").args(["-qec", &line, "/dev/null"]).stdin(Stdio::null()).output().ok()?;
    Some(String::from_utf8_lossy(&script.stdout).into_owned())
}

#[test]
#[cfg(target_os = "linux")]
fn a_terminal_gets_no_binary_output() {
    let (folder, dataset) = (TempDir::new().unwrap(), dataset().display());
    let file = folder.path().join("a.lfold");
    succeeded(&output(lightfold().args(["encode", &dataset.to_string(), "--clip", "-o"]).arg(&file)));
    let file = file.display();
    for words in [
        format!("encode {dataset} --clip -o -"),
        format!("encode {dataset} --clip -o /dev/stdout"),
        format!("encode-depth {dataset}/probe_00/face_px/depth.%04d.exr -o -"),
        format!("pack {file} -o -"),
        format!("render {file} -o -"),
        format!("render {file} -o {}/a.png --contact-sheet -", folder.path().display()),
        format!("simplify {dataset} -o -"),
    ] {
        let Some(said) = on_a_terminal(&words) else { return };
        assert!(said.contains("a terminal") && said.contains("code 2") && said.len() < 200, "{words}: {said:?}");
    }
}

#[test]
fn failures_are_json_where_reports_are() {
    let folder = TempDir::new().unwrap();
    let failed = |words: &[&str]| {
        let output = output(lightfold().args(words).current_dir(folder.path()));
        let code = output.status.code().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["error"]["code"], code, "{report}");
        let message = report["error"]["message"].as_str().unwrap();
        assert!(stderr(&output).contains(message.lines().next().unwrap()), "{report} {}", stderr(&output));
        (code, report["error"].clone())
    };
    let (code, missing) = failed(&["decode", "missing.lfold", "--null", "--json"]);
    assert_eq!((code, &missing["retry"], &missing["file"]), (2, &false.into(), &"missing.lfold".into()));
    let (code, missing) = failed(&["encode-depth", "missing.%04d.exr", "-o", "a.lfold", "--json"]);
    assert_eq!((code, &missing["retry"], &missing["file"]), (75, &true.into(), &"missing.%04d.exr".into()));
    fs::write(folder.path().join("text.lfold"), "text").unwrap();
    let (code, bad) = failed(&["inspect", "text.lfold", "--json"]);
    assert_eq!((code, &bad["retry"], &bad["file"]), (2, &false.into(), &"text.lfold".into()));
    let (code, usage) = failed(&["decode", "text.lfold", "--null", "--json", "--frames", "9-3"]);
    assert_eq!((code, &usage["file"]), (2, &serde_json::Value::Null));
    assert!(usage["message"].as_str().unwrap().starts_with("invalid value '9-3'"), "{usage}");
}

#[test]
fn progress_is_told_as_lines() {
    let folder = TempDir::new().unwrap();
    let encode = |form: &str, more: &[&str]| {
        let mut command = lightfold();
        command.args(["encode", dataset().to_str().unwrap(), "--clip", "--quiet", "--progress", form]).args(more);
        let encoded = output(command.current_dir(folder.path()));
        succeeded(&encoded);
        (encoded.stdout.clone(), stderr(&encoded))
    };
    let (out, said) = encode("json", &["-o", "a.lfold"]);
    let is_progress = |line: &&str| line.starts_with('{');
    let lines: Vec<serde_json::Value> =
        said.lines().filter(is_progress).map(|line| serde_json::from_str(line).unwrap()).collect();
    let last = lines.last().unwrap();
    assert_eq!((&last["stage"], &last["done"], &last["total"]), (&"encoding".into(), &72.into(), &72.into()));
    assert!(last["seconds"].is_f64() && lines[0]["done"] == 0 && out.is_empty(), "{said}");
    let (out, said) = encode("openjd", &["-o", "a.lfold"]);
    let out = String::from_utf8(out).unwrap();
    assert!(out.ends_with("openjd_progress: 100.0\nopenjd_status: encoding 72/72\n"), "{out}");
    assert!(!said.contains("openjd"), "{said}");
    for more in [["-o", "-"], ["--json", "-oa.lfold"]] {
        let (out, said) = encode("openjd", &more);
        assert!(said.contains("openjd_status: encoding 72/72\n"), "{said}");
        assert!(!String::from_utf8_lossy(&out).contains("openjd"));
    }
    let (out, said) = encode("none", &["-o", "a.lfold"]);
    assert!(out.is_empty() && !said.contains("encoding"), "{said}");
}

#[test]
fn no_stage_of_the_demo_has_more_steps_than_it_told() {
    let folder = TempDir::new().unwrap();
    let run = demo(folder.path(), &["--progress", "json"]);
    succeeded(&run);
    let said = stderr(&run);
    let lines: Vec<serde_json::Value> = said.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    assert!(lines.iter().any(|line| line["stage"] == "measuring"), "{said}");
    for line in &lines {
        assert!(line["done"].as_u64() <= line["total"].as_u64(), "{line}");
    }
    // A stage may begin within another one, which continues afterwards.
    for stage in lines.iter().map(|line| &line["stage"]) {
        let last = lines.iter().rfind(|line| line["stage"] == *stage).unwrap();
        assert_eq!(last["done"], last["total"], "{said}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named() {
    let folder = TempDir::new().unwrap();
    let container = folder.path().join("a.lfold");
    succeeded(&output(lightfold().arg("encode").arg("--clip").arg(dataset()).arg("-o").arg(&container)));
    for arguments in [vec!["encode", "--clip", dataset().to_str().unwrap()], vec!["pack", container.to_str().unwrap()]]
    {
        let full = output(lightfold().args(&arguments).args(["-o", "/dev/full"]));
        assert_eq!(full.status.code(), Some(75), "{arguments:?}");
        assert!(stderr(&full).contains("/dev/full") && stderr(&full).contains("No space left"), "{}", stderr(&full));
    }
}

/// Writes a dataset that repeats the frames of the shared one, by symbolic links: slow to encode, and quick to make.
#[cfg(unix)]
fn long_dataset(folder: &Path) {
    use codec::image::StreamKind;
    use footage::dataset::manifest::{MANIFEST_NAME, Manifest};

    const FRAMES: u32 = 1200;
    let mut manifest = Manifest::read(dataset()).unwrap();
    let (last, faces) = (manifest.frames[1], manifest.faces());
    for kind in [StreamKind::Color, StreamKind::Depth] {
        for face in &faces {
            let pattern = manifest.pattern(kind, &manifest.probes[0].name, *face).unwrap().unwrap();
            fs::create_dir_all(folder.join(pattern.path(0)).parent().unwrap()).unwrap();
            for frame in 0..FRAMES {
                let target = dataset().join(pattern.path(frame % (last + 1)));
                std::os::unix::fs::symlink(target, folder.join(pattern.path(frame))).unwrap();
            }
        }
    }
    manifest.frames = [0, FRAMES - 1];
    fs::write(folder.join(MANIFEST_NAME), manifest.to_json().unwrap()).unwrap();
}

/// Starts an encode that takes long enough to be stopped midway, and waits until it has created a file.
#[cfg(unix)]
fn encode_at_work(folder: &Path) -> Child {
    let scene = folder.join("scene");
    fs::create_dir(&scene).unwrap();
    long_dataset(&scene);
    let out = folder.join("out");
    fs::create_dir(&out).unwrap();
    let mut child = lightfold()
        .arg("encode")
        .arg(&scene)
        .args(["--clip", "--near", "0.1", "--far", "100", "--threads", "1", "-o"])
        .arg(out.join("a.lfold"))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while names_in(&out).is_empty() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it began");
        assert!(start.elapsed() < Duration::from_secs(60), "it did not begin");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

#[test]
#[cfg(unix)]
fn an_interrupted_encode_leaves_nothing_under_the_final_name() {
    for signal in ["-INT", "-TERM"] {
        let folder = TempDir::new().unwrap();
        let mut child = encode_at_work(folder.path());
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let status = wait(&mut child);
        let mut words = String::new();
        child.stderr.take().unwrap().read_to_string(&mut words).unwrap();
        assert_eq!(status.code(), Some(130), "{signal}: {words}");
        assert!(words.contains("interrupted"), "{words}");
        let left = names_in(&folder.path().join("out"));
        let state = [".a.lfold.journal", ".a.lfold.partial"];
        assert_eq!(left, if words.contains("safe in") { state.to_vec() } else { vec![] }, "{signal}: {words}");
    }
}

#[test]
#[cfg(unix)]
fn a_killed_encode_leaves_nothing_that_opens() {
    let folder = TempDir::new().unwrap();
    let mut child = encode_at_work(folder.path());
    child.kill().unwrap();
    wait(&mut child);
    let out = folder.path().join("out");
    for name in names_in(&out) {
        assert!(name.ends_with(".partial") || name.ends_with(".journal"), "{name}");
        assert!(Reader::open(out.join(&name)).is_err(), "{name} opens");
    }
}

#[test]
fn a_container_that_was_cut_off_does_not_open() {
    let whole = output(lightfold().arg("encode").arg("--clip").arg(dataset()).args(["-o", "-"])).stdout;
    assert!(Reader::from_memory(whole.clone()).is_ok());
    for length in (0..whole.len()).step_by(whole.len() / 40).chain([whole.len() - 1]) {
        assert!(Reader::from_memory(whole[..length].to_vec()).is_err(), "{length} of {} bytes open", whole.len());
    }
}

fn demo(folder: &Path, more: &[&str]) -> Output {
    let mut command = lightfold();
    command.args(["demo", "--frame-count", "4", "--size", "24", "--probes", "2", "-o"]).arg(folder).args(more);
    output(&mut command)
}

#[test]
fn the_demo_does_not_depend_on_threads() {
    let folder = TempDir::new().unwrap();
    let run = |threads: &str| {
        let to = folder.path().join(threads);
        succeeded(&demo(&to, &["--quiet", "--threads", threads]));
        bytes_below(&to)
    };
    let one = run("1");
    assert!(one.iter().any(|(path, _)| path == Path::new("demo.lfold")));
    for threads in ["2", "4"] {
        assert!(run(threads) == one, "{threads} threads write other bytes than one");
    }
}

#[test]
fn the_demo_is_what_its_commands_say() {
    let folder = TempDir::new().unwrap();
    let to = folder.path().join("a demo");
    let run = demo(&to, &["--json"]);
    succeeded(&run);
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(report["depth"]["max_error_codes"].as_u64().is_some_and(|codes| (1..=100).contains(&codes)), "{report}");
    assert!(report["color"]["min_quality"].as_f64().unwrap() >= 79.0, "{report}");
    assert_eq!(report["bytes"], fs::metadata(to.join("demo.lfold")).unwrap().len());
    let made = bytes_below(&to);
    fs::remove_file(to.join("demo.lfold")).unwrap();
    fs::remove_dir_all(to.join("decoded")).unwrap();
    let commands = report["commands"].as_array().unwrap().iter();
    let mut commands: Vec<_> =
        commands.map(|command| crate::repository_rules::shell_words(command.as_str().unwrap())).collect();
    // The last command is a server, which would not end.
    let view = commands.pop().unwrap();
    assert_eq!(view, ["lightfold", "view", to.join("demo.lfold").to_str().unwrap(), "--open"]);
    for words in commands {
        assert_eq!(words[0], "lightfold");
        succeeded(&output(lightfold().args(&words[1..])));
    }
    assert!(bytes_below(&to) == made, "the commands that the demo prints make other bytes than the demo");
}
