//! Films of `render`, which ffmpeg encodes.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::exports::ffmpeg;
use crate::render::encoded;

const EYE: &str = "--eye 0.05,1.52,0 --look-at -2,1.2,0.8 --fov 80";
const SIZE: usize = 160;

/// Renders a film of three frames. Returns its report.
fn film(name: &str, at: &Path) -> Value {
    let line = format!("render a.lfold {EYE} --size {SIZE} --frames 0-2 -o {name} --stats --json");
    serde_json::from_slice(&fine(&line, at).stdout).unwrap()
}

/// Returns the frames of a film as RGB codes.
fn decoded(name: &str, at: &Path) -> Vec<u8> {
    let matrix = "-vf scale=in_color_matrix=bt709:in_range=limited:out_range=full:flags=accurate_rnd+full_chroma_int";
    ffmpeg(&format!("-i {} {matrix} -f rawvideo -pix_fmt rgb24 -", at.join(name).display()), Vec::new())
}

/// Returns what ffmpeg says about a file.
fn described(name: &str, at: &Path) -> String {
    let output = Command::new("ffmpeg").args(["-hide_banner", "-i", name]).current_dir(at).output().unwrap();
    String::from_utf8(output.stderr).unwrap()
}

fn files(at: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
#[cfg_attr(not(ffmpeg_at_hand), ignore = "no ffmpeg at hand")]
fn a_film_has_the_colours_of_the_pictures() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} --size {SIZE} --frames 0-2 -o %04d.png"), at);
    for name in ["a.mp4", "a.mov", "a.mkv", "a.webm"] {
        let report = film(name, at);
        assert_eq!(report["bytes_out"], std::fs::metadata(at.join(name)).unwrap().len(), "{name}: {report:#}");
        let words = described(name, at);
        let codec = if name == "a.webm" { "vp9" } else { "h264" };
        let tags = [codec, "yuv420p(tv, bt709", "160x160", "24 fps"];
        assert!(tags.iter().all(|tag| words.contains(tag)), "{name}: {words}");
        let frames = decoded(name, at);
        assert_eq!(frames.len(), 3 * SIZE * SIZE * 3, "{name}");
        for (frame, found) in frames.chunks(SIZE * SIZE * 3).enumerate() {
            let picture = image::open(at.join(format!("{frame:04}.png"))).unwrap().into_rgb8();
            // By channel, so that a wrong matrix or range shows as an offset.
            for channel in 0..3 {
                let each =
                    |values: &[u8]| values.iter().skip(channel).step_by(3).map(|&code| f64::from(code)).collect();
                let [found, expected]: [Vec<f64>; 2] = [each(found), each(picture.as_raw())];
                let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / (SIZE * SIZE) as f64;
                let offset = mean(&mut found.iter().zip(&expected).map(|(a, b)| a - b));
                let apart = mean(&mut found.iter().zip(&expected).map(|(a, b)| (a - b).abs()));
                assert!(offset.abs() < 0.7 && apart < 6.0, "{name} {frame} {channel}: {offset:.2} {apart:.2}");
            }
        }
    }
    // The index of MP4 stands before the pictures.
    let bytes = std::fs::read(at.join("a.mp4")).unwrap();
    let find = |word: &[u8; 4]| bytes.windows(4).position(|at| at == word).unwrap();
    assert!(find(b"moov") < find(b"mdat"));
    fine(&format!("render a.lfold {EYE} --size 40x24 --stereo side-by-side --exposure 1 -o both.mp4"), at);
    assert!(described("both.mp4", at).contains("80x24"));
    assert!(!files(at).iter().any(|name| name.starts_with('.')), "{:?}", files(at));
}

#[test]
fn films_that_make_no_sense_are_refused() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    for (options, words) in [
        ("--size 41x24 -o a.mp4", "41x24 pixels, where a film needs an even width and height"),
        ("-o a.%04d.mp4", "a film is one file"),
        ("--shard 1/2 --frames 0-1 -o a.mp4", "--shard"),
        ("--stream-format y4m -o a.mp4", "-o -"),
        ("--aov depth -o a.mp4", ".exr"),
        ("-o nowhere/b/a.avi", ".mp4, .mov, .mkv or .webm"),
    ] {
        let said = refused(&format!("render a.lfold {EYE} {options}"), at);
        assert!(said.contains(words), "{options}: {said}");
        assert_eq!(files(at), ["a.lfold", "captured"], "{options}");
    }
}

/// Runs `render -o a.mp4` with the programs of a folder alone.
fn with_programs(programs: &Path, more: &str, at: &Path) -> Output {
    let line = format!("render a.lfold {EYE} --size 40 --frames 0-2 {more}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.args(line.split(' ')).current_dir(at).env("PATH", programs).output().unwrap()
}

#[test]
fn without_ffmpeg_the_command_that_pipes_is_shown() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let output = with_programs(&at.join("captured"), "-o a.mp4 --json", at);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("is not installed"), "{said}");
    assert!(said.contains("--stream-format y4m -o - | ffmpeg -i - -vf format=yuv420p,setparams=range=tv"), "{said}");
    assert!(said.trim_end().ends_with("-c:v libx264 -crf 16 -movflags +faststart a.mp4"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    let failure: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(failure["error"]["code"], 2);
    assert_eq!(files(at), ["a.lfold", "captured"]);
}

/// Writes a program in place of ffmpeg.
#[cfg(unix)]
fn program(script: &str, at: &Path) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;

    let folder = at.join("programs");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("ffmpeg");
    std::fs::write(&path, format!("#!/bin/sh\nfor last; do :; done; file=\"${{last#file:}}\"\n{script}\n")).unwrap();
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
    folder
}

#[test]
#[cfg(unix)]
fn failures_of_ffmpeg_are_told_with_its_last_lines() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    for (script, words, code) in [
        ("echo one >&2; echo \"$file: no encoder\" >&2; exit 1", "a.mp4: ffmpeg failed: one; a.mp4: no encoder\n", 2),
        ("exec >&2; for n in 1 2 3 4 5; do echo $n; done; exit 1", "a.mp4: ffmpeg failed: 3; 4; 5\n", 2),
        ("/bin/cat > /dev/null; exit 3", "a.mp4: ffmpeg failed: exit status: 3\n", 2),
        ("echo av_write: No space left on device >&2; exit 1", "a.mp4: no storage space", 75),
    ] {
        let programs = program(script, at);
        let output = with_programs(&programs, "-o a.mp4", at);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{script}: {said}");
        assert!(said.to_lowercase().contains(words), "{script}: {said}");
        assert_eq!(files(at), ["a.lfold", "captured", "programs"], "{script}");
    }
}

/// An interrupt ends ffmpeg too, also while it takes no pictures, and leaves no file.
#[test]
#[cfg(unix)]
fn an_interrupt_ends_both() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    let begun = at.join("begun");
    for (script, size) in [("/bin/cat > \"$file\"", 1200), ("/bin/cat > /dev/null; exec /bin/sleep 600", 8)] {
        let programs = program(&format!("echo $$ > {}.new; /bin/mv {0}.new {0}\n{script}", begun.display()), at);
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        let line = format!("render a.lfold {EYE} --size {size} --frames 0-2 -o a.mp4");
        command.args(line.split(' ')).current_dir(at).env("PATH", &programs).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        let limit = Instant::now() + Duration::from_secs(60);
        while !begun.exists() && Instant::now() < limit {
            std::thread::sleep(Duration::from_millis(5));
        }
        let id: u32 = std::fs::read_to_string(&begun).unwrap().trim().parse().unwrap();
        // The handler is set after ffmpeg has started.
        std::thread::sleep(Duration::from_millis(500));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.contains("interrupted"), "{said}");
        std::fs::remove_file(&begun).unwrap();
        assert_eq!(files(at), ["a.lfold", "captured", "programs"]);
        let is_alive = Command::new("kill").args(["-0", &id.to_string()]).stderr(Stdio::null()).status().unwrap();
        assert!(!is_alive.success(), "{script} goes on");
    }
}
