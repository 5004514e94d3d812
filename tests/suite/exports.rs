//! Output for other programs: streams of pictures on standard output, and point clouds.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};

const EYE: &str = "--eye 0.05,1.52,0 --look-at -2,1.2,0.8 --fov 80";
const FACE: &str = "--probe 00 --face nx --stream color";

/// Captures and encodes two probes and three frames at 29.97 frames per second.
fn film(folder: &Path) {
    let probes = "--position=-0.3,1.5,0 --position=0.3,1.5,0";
    fine(&format!("capture courtyard {probes} --frames 0-2 --fps 29.97 --size 32 -o captured"), folder);
    fine("encode captured --clip -o a.lfold", folder);
}

fn stdout(line: &str, folder: &Path) -> Vec<u8> {
    fine(line, folder).stdout
}

/// Splits a stream into its first line, without the newline, and the rest.
fn head(bytes: &[u8]) -> (String, &[u8]) {
    let end = bytes.iter().position(|&byte| byte == b'\n').unwrap();
    (String::from_utf8(bytes[..end].to_vec()).unwrap(), &bytes[end + 1..])
}

fn joined(folder: &Path, names: &[&str]) -> Vec<u8> {
    names.iter().flat_map(|name| std::fs::read(folder.join(name)).unwrap()).collect()
}

#[test]
fn pictures_of_one_stream_go_to_standard_output() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    for (stream, name) in [("color", "c"), ("depth", "d")] {
        let selected = format!("--probe 00 --face nx --stream {stream}");
        fine(&format!("decode a.lfold {selected} --format png -o {name}.%04d.png"), at);
        let files = ["0000", "0001", "0002"].map(|number| format!("{name}.{number}.png"));
        let files = joined(at, &files.each_ref().map(String::as_str));
        assert!(stdout(&format!("decode a.lfold {selected} -o -"), at) == files, "{stream}");
    }
    let colors: Vec<u8> = ["c.0000.png", "c.0001.png", "c.0002.png"]
        .iter()
        .flat_map(|name| image::open(at.join(name)).unwrap().into_rgb8().into_raw())
        .collect();
    let raw = stdout(&format!("decode a.lfold {FACE} --stream-format raw -o -"), at);
    let (words, codes) = head(&raw);
    assert_eq!(words, "width=32 height=32 pixel_format=rgb24 fps=30000/1001");
    assert!(codes == colors);
    let depths = image::open(at.join("d.0001.png")).unwrap().into_luma16().into_raw();
    let raw = stdout("decode a.lfold --probe 00 --face nx --stream depth --frames 1 --stream-format raw -o -", at);
    let (words, codes) = head(&raw);
    assert_eq!(words, "width=32 height=32 pixel_format=gray16le fps=30000/1001");
    assert!(codes == depths.iter().flat_map(|code| code.to_le_bytes()).collect::<Vec<u8>>());
    let y4m = stdout(&format!("decode a.lfold {FACE} --stream-format y4m -o -"), at);
    let (words, mut frames) = head(&y4m);
    assert_eq!(words, "YUV4MPEG2 W32 H32 F30000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED");
    for colors in colors.chunks(3 * 1024) {
        let (words, rest) = head(frames);
        let (planes, rest) = rest.split_at(3 * 1024);
        assert_eq!(words, "FRAME");
        for (pixel, rgb) in colors.chunks(3).enumerate() {
            // The inverse BT.709 conversion of limited range: luma 16 to 235, chroma 16 to 240.
            let [y, cb, cr] = [0, 1, 2].map(|plane| f64::from(planes[1024 * plane + pixel]));
            let (y, cb, cr) = ((y - 16.0) / 219.0, (cb - 128.0) / 224.0, (cr - 128.0) / 224.0);
            let (r, b) = (y + 1.5748 * cr, y + 1.8556 * cb);
            let g = (y - 0.2126 * r - 0.0722 * b) / 0.7152;
            let apart = [r, g, b].into_iter().zip(rgb).map(|(is, &was)| (255.0 * is - f64::from(was)).abs());
            assert!(apart.fold(0.0, f64::max) < 2.5, "{rgb:?} is {y} {cb} {cr}");
        }
        frames = rest;
    }
    assert!(frames.is_empty());
}

#[test]
fn rendered_pictures_go_to_standard_output() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    fine(&format!("render a.lfold {EYE} --size 40x24 --frames 0-2 -o v.%04d.png"), at);
    let printed = fine(&format!("render a.lfold {EYE} --size 40x24 --frames 0-2 -o - --stats"), at);
    assert!(printed.stdout == joined(at, &["v.0000.png", "v.0001.png", "v.0002.png"]));
    assert!(String::from_utf8(printed.stderr).unwrap().contains("primary"), "figures are beside the pictures");
    let raw =
        stdout(&format!("render a.lfold {EYE} --size 40x24 --frames 0-2 --stream-format raw -o - --threads 1"), at);
    let (words, codes) = head(&raw);
    assert_eq!(words, "width=40 height=24 pixel_format=rgb24 fps=30000/1001");
    let last = image::open(at.join("v.0002.png")).unwrap().into_rgba8();
    for (x, y, pixel) in last.enumerate_pixels().filter(|(.., pixel)| pixel[3] == 255) {
        let place = 3 * (2 * 40 * 24 + (y * 40 + x) as usize);
        assert_eq!(codes[place..place + 3], pixel.0[..3]);
    }
    let y4m = stdout(&format!("render a.lfold {EYE} --size 40x24 --frames 0-2 --stream-format y4m -o -"), at);
    let (words, frames) = head(&y4m);
    assert!(words.starts_with("YUV4MPEG2 W40 H24 F30000:1001 "), "{words}");
    assert_eq!(frames.len(), 3 * (6 + 3 * 40 * 24));
    let beside =
        stdout(&format!("render a.lfold {EYE} --size 40x24 --stereo side-by-side --stream-format raw -o -"), at);
    assert!(head(&beside).0.starts_with("width=80 height=24 "));
}

#[test]
fn streams_that_make_no_sense_are_refused() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    for (line, words) in [
        ("decode a.lfold -o -".to_owned(), "24 are selected (color of 00 px, "),
        ("decode a.lfold --stream color --face px -o -".to_owned(), "(color of 00 px, color of 01 px)"),
        (
            "decode a.lfold --probe 00 --face px --stream depth --stream-format y4m -o -".to_owned(),
            "--stream-format png or raw",
        ),
        (format!("decode a.lfold {FACE} --stream-format y4m -o frames"), "-o -"),
        (format!("decode a.lfold {FACE} --keep-going -o -"), "--keep-going"),
        (format!("decode a.lfold {FACE} --json -o -"), "--json"),
        (format!("render a.lfold {EYE} --size 8 --stream-format y4m -o a.png"), "-o -"),
        (format!("render a.lfold {EYE} --size 8 --json -o -"), "only one result"),
    ] {
        let said = refused(&line, at);
        assert!(said.contains(words), "{line}: {said}");
        assert!(!at.join("frames").exists() && !at.join("a.png").exists());
    }
}

#[test]
fn a_reader_that_leaves_ends_the_program_quietly() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let line = format!("render a.lfold {EYE} --size 400 --steps 8 --frames 0-2 --stream-format raw -o -");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.args(line.split(' ')).current_dir(at).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut start = [0; 10];
    child.stdout.take().unwrap().read_exact(&mut start).unwrap();
    assert_eq!(&start, b"width=400 ");
    let ended = child.wait_with_output().unwrap();
    assert!(ended.stderr.is_empty(), "{}", String::from_utf8_lossy(&ended.stderr));
    assert_ne!(ended.status.code(), Some(2));
}

/// Runs ffmpeg on `input`. Returns its standard output.
#[cfg(ffmpeg_at_hand)]
pub fn ffmpeg(arguments: &str, input: Vec<u8>) -> Vec<u8> {
    use std::io::Write;

    let mut command = Command::new("ffmpeg");
    command.args(["-hide_banner", "-loglevel", "error"]).args(arguments.split(' '));
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || pipe.write_all(&input));
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "ffmpeg {arguments}");
    writer.join().unwrap().unwrap();
    output.stdout
}

/// Replaces `ffmpeg` on machines without it; never called, because the tests that need it are ignored.
#[cfg(not(ffmpeg_at_hand))]
pub fn ffmpeg(_arguments: &str, _input: Vec<u8>) -> Vec<u8> {
    panic!("there is no ffmpeg")
}

#[test]
#[cfg_attr(not(ffmpeg_at_hand), ignore = "no ffmpeg at hand")]
fn ffmpeg_reads_the_streams() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let line = format!("decode a.lfold {FACE} -o -");
    let colors = stdout(&format!("{line} --stream-format raw"), at);
    let (_, colors) = head(&colors);
    // ffmpeg detects the input format by itself.
    let png = ffmpeg("-i - -f rawvideo -pix_fmt rgb24 -", stdout(&line, at));
    assert!(png == colors);
    let y4m = stdout(&format!("{line} --stream-format y4m"), at);
    let matrix = "-vf scale=in_color_matrix=bt709:in_range=limited:out_range=full:flags=accurate_rnd+full_chroma_int";
    let from_y4m = ffmpeg(&format!("-i - {matrix} -f rawvideo -pix_fmt rgb24 -"), y4m.clone());
    assert_eq!(from_y4m.len(), colors.len());
    let worst = from_y4m.iter().zip(colors).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(4), "{worst:?}");
    // ffmpeg takes the frame rate as its time base, so the header that it writes has the same rate.
    let (words, _) = head(&y4m);
    let again = ffmpeg("-i - -f yuv4mpegpipe -", y4m.clone());
    let (written, _) = head(&again);
    assert!(words.contains(" F30000:1001 ") && written.contains(" F30000:1001 "), "{written}");
}

/// Returns position in metres and colour of each vertex of a binary PLY file.
fn vertices(bytes: &[u8]) -> Vec<([f32; 3], [u8; 3])> {
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|part| part == end).unwrap() + end.len();
    let words = String::from_utf8(bytes[..start].to_vec()).unwrap();
    assert!(words.starts_with("ply\nformat binary_little_endian 1.0\n"), "{words}");
    let count: usize = words.split("element vertex ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
    assert_eq!(bytes.len() - start, 15 * count);
    let float = |bytes: &[u8]| f32::from_le_bytes(*bytes.first_chunk().unwrap());
    let vertex = |bytes: &[u8]| ([0, 4, 8].map(|at| float(&bytes[at..])), [bytes[12], bytes[13], bytes[14]]);
    bytes[start..].chunks(15).map(vertex).collect()
}

#[test]
fn frames_become_point_clouds() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    film(at);
    let report: Value =
        serde_json::from_slice(&stdout("decode a.lfold --probe 00 --face nx --frames 1 -o nx.ply --json", at)).unwrap();
    let points = vertices(&std::fs::read(at.join("nx.ply")).unwrap());
    assert_eq!(report["points"], points.len());
    fine("decode a.lfold --probe 00 --face nx --frames 1 -o decoded", at);
    fine("decode a.lfold --probe 00 --face nx --stream color --frames 1 --format png -o c.png", at);
    let depth = footage::image_files::exr::read_depth(
        &at.join("decoded/probe_00/face_nx/depth.0001.exr"),
        &codec::image::ChannelSelect::default(),
        &codec::image::ReadLimits::default(),
    )
    .unwrap();
    let color = image::open(at.join("c.png")).unwrap().into_rgb8();
    let mut points = points.into_iter();
    for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
        let metres = depth.get(x, y);
        if metres.is_infinite() {
            continue;
        }
        // Face nx looks along −X, with +Z to its right and −Y down (manifest.md 1).
        let [u, v] = [x, y].map(|at| (2.0 * (at as f32 + 0.5)) / 32.0 - 1.0);
        let scale = metres / (1.0 + u * u + v * v).sqrt();
        let expected = [-0.3 - scale, 1.5 - v * scale, u * scale];
        let (place, code) = points.next().unwrap();
        let apart = place.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-4 * metres, "{x} {y}: {place:?} {expected:?}");
        assert_eq!(code, color.get_pixel(x, y).0);
    }
    assert!(points.next().is_none());
    // All probes, faces and frames.
    fine("decode a.lfold -o all/f.%04d.ply", at);
    let all = vertices(&std::fs::read(at.join("all/f.0002.ply")).unwrap());
    assert!(all.len() > 3 * 1024 && at.join("all/f.0000.ply").exists());
    for (options, words) in [
        ("-o b.ply", "one file for 3 frames"),
        ("--frames 1 --stream depth -o b.ply", "--stream"),
        ("--frames 1 --eye 0,0,0 --look-at 1,0,0 -o b.ply", "--eye"),
        ("--frames 1 --memory 1K -o b.ply", "--memory"),
    ] {
        let said = refused(&format!("decode a.lfold {options}"), at);
        assert!(said.contains(words) && !at.join("b.ply").exists(), "{options}: {said}");
    }
}
