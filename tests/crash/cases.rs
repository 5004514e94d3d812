//! Command lines that write files, with minimal inputs.

/// A command line, which runs in its own folder.
pub struct Case {
    pub line: &'static str,
    /// True if the command has `--resume`.
    pub resumes: bool,
    /// True if the command may run again over its outputs.
    pub is_repeatable: bool,
    /// Commands that run first, in the same folder.
    pub before: &'static [&'static str],
    /// Files that are removed after `before`.
    pub without: &'static [&'static str],
}

const fn case(line: &'static str) -> Case {
    Case { line, resumes: false, is_repeatable: true, before: &[], without: &[] }
}

const fn resumed(line: &'static str) -> Case {
    Case { resumes: true, ..case(line) }
}

/// Commands that create the inputs.
pub const INPUTS: &[&str] = &[
    "capture interior --position=-0.3,1.5,0 --size 16 --frames 0-2 --aov depth,material -o room -q",
    "encode room -o room.lfold --clip -q",
    "encode-color room/probe_00/face_px/color.%04d.exr -o c.lfold --clip -q",
    "encode-depth room/probe_00/face_px/depth.%04d.exr -o d.lfold -q",
    "interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 4 --baseline 0.3 --size 16 -o v/%04d.png -q",
];

pub const CAMERAS: &str = r#"{"cameras": [{"eye": [0, 1, 0], "look_at": [2, 1, 0], "fov_y_deg": 60}, {"eye": [0, 2, 0], "look_at": [2, 1, 0], "fov_y_deg": 60}]}"#;

pub const CASES: &[Case] = &[
    case("demo -o demo --size 16 --frame-count 2 -q"),
    case(
        "place courtyard --region=-0.5,1,-0.5,0.5,2,0.5 --cameras 2 --effort fast --csv p.csv --plot plots -o cams.json -q",
    ),
    resumed("capture interior --position=-0.3,1.5,0 --size 8 --frames 0-1 --aov depth -o cap -q"),
    Case {
        before: &["capture interior --position=0,1.5,0 --size 8 --frames 0-0 --aov depth -o in -q"],
        without: &["lightfield.json"],
        ..case("init in --force -q")
    },
    resumed("encode ../inputs/room -o a.lfold --clip --keyframe-interval 1 -q"),
    resumed("encode-color ../inputs/room/probe_00/face_px/color.%04d.exr -o c.lfold --clip -q"),
    resumed("encode-depth ../inputs/room/probe_00/face_px/depth.%04d.exr -o d.lfold -q"),
    resumed("quadtree ../inputs/room/probe_00/face_px/depth.%04d.exr --effort fast -o q.lfold -q"),
    case("bc4w ../inputs/room/probe_00/face_px/depth.%04d.exr -o b.lfold -q"),
    case("pack ../inputs/room.lfold -o p.lfold --lzma2 -q"),
    case("scan ../inputs/room -o scan.json -q"),
    case("train-color ../inputs/room.lfold -o t.txt -q"),
    case("train-depth ../inputs/room.lfold -o t.txt -q"),
    case("decode ../inputs/room.lfold -o out -q"),
    case("decode ../inputs/c.lfold -o c.%04d.png -q"),
    case("decode ../inputs/d.lfold --frames 1 -o sub/d.exr -q"),
    case("decode ../inputs/room.lfold --frames 0-1 -o points.%04d.ply -q"),
    case("inspect ../inputs/room.lfold --plot maps --source ../inputs/room -q"),
    case("render ../inputs/room.lfold --eye 0,1.5,0.1 --look-at 2,1.3,0 --size 8 --frames 0-1 -o pics -q"),
    case(
        "render ../inputs/room.lfold --eye 0,1.5,0.1 --look-at 2,1.3,0 --size 8 --frames 0-1 -o %V.%04d.exr --stereo side-by-side \
         --contact-sheet sheet.png --trace trace.jsonl -q",
    ),
    case("render ../inputs/room.lfold --reference ../inputs/room --reference-probe 00 --error-map maps --null -q"),
    case("cameras ../inputs/path.json -o shot.usda -q"),
    case("cameras ../inputs/path.json --format colmap -o colmap -q"),
    case("quilt ../inputs/v/%04d.png -o q.png -q"),
    resumed("simplify ../inputs/room --triangles 300 --effort fast -o room.glb -q"),
    resumed("simplify ../inputs/room --triangles 300 --effort fast -o room.obj -q"),
    // Not resumed: the charts show times, which differ between runs.
    case("simplify ../inputs/room --triangles 300 --effort fast -o room.glb --plot plots -q"),
    resumed("interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 4 --baseline 0.3 --size 8 -o v/%04d.png -q"),
    resumed(
        "interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 4 --baseline 0.3 --size 8 --frames 0-1 -o q.%04d.exr --quilt 2x2 -q",
    ),
    case(
        "interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 2 --baseline 0.3 --size 8 -o v/%04d.png --compare --csv q.csv \
         --error-map maps --cameras-out cams.json -q",
    ),
    case("view ../inputs/room.lfold --export site -q"),
    Case { is_repeatable: false, ..case("tradeoff ../inputs/room --sweep depth-window=1 --repeats 1 -o t1 -q") },
    case("man pages"),
];
