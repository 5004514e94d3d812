//! Fuzz targets: functions that take arbitrary bytes and return a verdict. The test's runner and the `cargo fuzz` package share
//! them.

use codec::color::transform::Transform;
use codec::depth::predictive::Predictive;
use codec::error::{Error, Result};

pub mod cameras;
pub mod container;
pub mod images;
pub mod journal;
pub mod models;
pub mod stream;
pub mod texts;
pub mod transform;

/// Result of a parser that handled an input correctly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The input was accepted.
    Accepted,
    /// The input was refused with a well-formed error.
    Refused,
}

/// A verdict, or a description of the failure.
pub type Judged = std::result::Result<Verdict, String>;

/// A parser under test.
#[derive(Clone, Copy)]
pub struct Target {
    /// Name on command lines.
    pub name: &'static str,
    /// Number of inputs that the test runs, for about two seconds on a desktop computer.
    pub execs: u64,
    /// Runs an input; a panic is a failure too.
    pub run: fn(&[u8]) -> Judged,
    /// Returns the maximum bytes of memory for an input.
    pub bound: fn(&[u8]) -> u64,
}

/// Defines a target for the payloads of one codec.
macro_rules! payloads {
    ($codec:literal, $execs:literal) => {{
        const CODEC: [u8; 4] = *$codec;
        let Ok(name) = std::str::from_utf8(&CODEC) else { panic!("a codec is four letters") };
        Target {
            name,
            execs: $execs,
            run: |bytes| stream::run(CODEC, bytes),
            bound: |bytes| stream::bound(CODEC, bytes),
        }
    }};
}

pub const TARGETS: &[Target] = &[
    Target { name: "container", execs: 2000, run: container::run, bound: container::bound },
    Target { name: "index", execs: 2000, run: container::run, bound: container::bound },
    Target { name: "lzma2", execs: 2000, run: container::run_lzma2, bound: container::bound_lzma2 },
    Target { name: "zstd", execs: 2000, run: container::run_zstd, bound: container::bound_lzma2 },
    payloads!(b"DQPN", 2000),
    payloads!(b"DQTR", 1000),
    payloads!(b"DAAB", 2000),
    payloads!(b"DB4W", 2000),
    payloads!(b"DPRD", 1000),
    payloads!(b"DAB5", 2000),
    payloads!(b"MAAB", 2000),
    payloads!(b"MAB1", 2000),
    payloads!(b"CCL8", 2000),
    payloads!(b"CCB1", 2000),
    payloads!(b"CCB7", 2000),
    payloads!(b"CCLH", 2000),
    payloads!(b"CCB6", 2000),
    payloads!(b"CTR8", 2000),
    payloads!(b"CTRH", 2000),
    Target { name: "transform", execs: 20_000, run: transform::run, bound: transform::bound },
    Target { name: "journal", execs: 4000, run: journal::run, bound: journal::bound },
    Target { name: "exr", execs: 2000, run: images::run_exr, bound: images::bound_exr },
    Target { name: "png", execs: 4000, run: images::run_png, bound: images::bound },
    Target { name: "jpeg", execs: 2000, run: images::run_jpeg, bound: images::bound },
    Target { name: "texture", execs: 2000, run: images::run_texture, bound: images::bound },
    Target { name: "seurat-exr", execs: 1000, run: images::run_seurat_exr, bound: images::bound_seurat },
    Target { name: "seurat-png", execs: 2000, run: images::run_seurat_png, bound: images::bound_seurat },
    Target { name: "manifest", execs: 4000, run: texts::run_manifest, bound: texts::bound },
    Target { name: "seurat", execs: 4000, run: texts::run_seurat, bound: texts::bound },
    Target { name: "cameras", execs: 4000, run: texts::run_cameras, bound: texts::bound },
    Target { name: "transforms", execs: 4000, run: cameras::run, bound: cameras::bound },
    Target { name: "cameras-gltf", execs: 2000, run: cameras::run, bound: cameras::bound },
    Target { name: "cameras-glb", execs: 2000, run: cameras::run, bound: cameras::bound },
    Target { name: "colmap", execs: 4000, run: cameras::run_colmap, bound: cameras::bound },
    Target { name: "scan", execs: 2000, run: texts::run_scan, bound: texts::bound },
    Target { name: "shard", execs: 4000, run: container::run_shard, bound: texts::bound },
    Target { name: "usda", execs: 4000, run: texts::run_usda, bound: texts::bound },
    Target { name: "sweep", execs: 4000, run: texts::run_sweep, bound: texts::bound },
    Target { name: "patterns", execs: 4000, run: texts::run_patterns, bound: texts::bound },
    Target { name: "cube", execs: 4000, run: texts::run_cube, bound: texts::bound },
    Target { name: "color-tables", execs: 2000, run: texts::run_tables::<Transform>, bound: texts::bound },
    Target { name: "depth-tables", execs: 2000, run: texts::run_tables::<Predictive>, bound: texts::bound },
    Target { name: "gltf", execs: 2000, run: models::run_gltf, bound: models::bound },
    Target { name: "glb", execs: 2000, run: models::run_gltf, bound: models::bound },
    Target { name: "quads", execs: 1000, run: models::run_quads, bound: models::bound },
    Target { name: "obj", execs: 2000, run: models::run_obj, bound: models::bound },
    Target { name: "mtl", execs: 2000, run: models::run_mtl, bound: models::bound },
];

/// Returns `Refused` if the error is a short printable sentence about the input; otherwise fails.
pub fn refused(error: &Error) -> Judged {
    let text = error.to_string();
    if text.trim().is_empty() {
        return Err(format!("an error without words: {error:?}"));
    }
    if text.contains(char::is_control) {
        return Err(format!("an error with control characters: {text:?}"));
    }
    if text.chars().count() > 2000 {
        return Err(format!("an error without end: {}", text.chars().take(200).collect::<String>()));
    }
    match error {
        Error::Interrupted | Error::Unfinished { .. } => Err(format!("not an error of the input: {text}")),
        _ => Ok(Verdict::Refused),
    }
}

/// Returns the verdict for a parser's result.
pub fn judge<T>(result: &Result<T>) -> Judged {
    result.as_ref().map_or_else(refused, |_| Ok(Verdict::Accepted))
}
