//! Image files. They are read from a file, so each thread has one to write to.

use std::path::Path;

use lightfold::image::{ChannelSelect, ColorSpace, ReadLimits, exr, png};
use tempfile::NamedTempFile;

use super::{Judged, Verdict, judge};

thread_local! {
    static FILE: NamedTempFile = new_file();
}

/// In memory, where the system has a place for that.
fn new_file() -> NamedTempFile {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    tempfile::Builder::new().prefix("fuzz").tempfile_in(folder).expect("a temporary file")
}

fn with_file<T>(bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    FILE.with(|file| {
        std::fs::write(file.path(), bytes).expect("the temporary file is written");
        read(file.path())
    })
}

/// The verdict of several readings: taken if any took it.
fn all(verdicts: impl IntoIterator<Item = Judged>) -> Judged {
    let mut all = Verdict::Refused;
    for verdict in verdicts {
        if verdict? == Verdict::Accepted {
            all = Verdict::Accepted;
        }
    }
    Ok(all)
}

/// An OpenEXR file, read in all ways that there are.
pub fn run_exr(bytes: &[u8]) -> Judged {
    let limits = ReadLimits::default();
    with_file(bytes, |path| {
        let depth = exr::read_depth(path, &ChannelSelect::Auto, &limits);
        if let Ok(plane) = &depth
            && exr::read_size(path, &limits).ok() != Some((plane.width(), plane.height()))
        {
            return Err("the size is another than that of the image".into());
        }
        let depth_again = exr::read_depth(path, &ChannelSelect::Auto, &limits);
        let bits = |plane: &lightfold::image::DepthPlane| plane.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        if depth.as_ref().ok().map(bits) != depth_again.as_ref().ok().map(bits) {
            return Err("read twice, it is not the same".into());
        }
        all([
            judge(&exr::read_size(path, &limits)),
            judge(&depth),
            judge(&exr::read_color(path, &ChannelSelect::Auto, &limits)),
            judge(&exr::read_material(path, ["reflect", "refract", "ior"], &limits)),
        ])
    })
}

/// A PNG file, read in all ways that there are.
pub fn run_png(bytes: &[u8]) -> Judged {
    let limits = ReadLimits::default();
    with_file(bytes, |path| {
        all([
            judge(&png::read_size(path, &limits)),
            judge(&png::read_depth(path, 0.001, &limits)),
            judge(&png::read_color(path, ColorSpace::Srgb, &limits)),
            judge(&png::read_color(path, ColorSpace::LinearRec709, &limits)),
        ])
    })
}

/// Bytes for a pixel of the largest planes that are read, and of two of depth with their bits.
const PIXEL_BYTES: u64 = 32;

/// What an OpenEXR file may take: its headers, a chunk and the planes; where the headers are refused, texts and lists of them.
pub fn bound_exr(bytes: &[u8]) -> u64 {
    let limits = ReadLimits::default();
    with_file(bytes, |path| {
        let pixels = exr::read_size(path, &limits).map_or(0, |(width, height)| u64::from(width) * u64::from(height));
        let reading = exr::reading_bytes(path, 1, &limits).unwrap_or((1 << 20) + 64 * bytes.len() as u64);
        reading + pixels * (PIXEL_BYTES - 1)
    })
}

/// What one image file may take: see `ReadLimits`.
pub fn bound(bytes: &[u8]) -> u64 {
    ReadLimits::default().memory_bound(bytes.len() as u64)
}
