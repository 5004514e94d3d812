//! Image files. The readers take paths, so each thread has a temporary file.

use std::path::Path;

use codec::image::{ChannelSelect, ReadLimits};
use footage::dataset::seurat::SeuratCapture;
use footage::image_files::{ColorSpace, exr, png};
use scene::mesh::budget::Budget;
use scene::mesh::{ImageTexture, Wrap};
use tempfile::NamedTempFile;

use super::{Judged, Verdict, judge, refused};

thread_local! {
    static FILE: NamedTempFile = new_file(".exr");
    static PNG_FILE: NamedTempFile = new_file(".png");
    static JPEG_FILE: NamedTempFile = new_file(".jpg");
}

/// Creates a temporary file, in memory if the system has `/dev/shm`.
fn new_file(suffix: &str) -> NamedTempFile {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    tempfile::Builder::new().prefix("fuzz").suffix(suffix).tempfile_in(folder).expect("a temporary file")
}

fn with_file<T>(bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    FILE.with(|file| {
        std::fs::write(file.path(), bytes).expect("the temporary file is written");
        read(file.path())
    })
}

/// Combines the verdicts of several readers: accepted if any of them accepts.
fn all(verdicts: impl IntoIterator<Item = Judged>) -> Judged {
    let mut all = Verdict::Refused;
    for verdict in verdicts {
        if verdict? == Verdict::Accepted {
            all = Verdict::Accepted;
        }
    }
    Ok(all)
}

/// Reads an OpenEXR file by every reader.
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
        let bits = |plane: &codec::image::DepthPlane| plane.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        if depth.as_ref().ok().map(bits) != depth_again.as_ref().ok().map(bits) {
            return Err("read twice, it is not the same".into());
        }
        all([
            judge(&exr::read_size(path, &limits)),
            judge(&depth),
            judge(&exr::read_color(path, &ChannelSelect::Auto, &limits)),
            judge(&exr::read_material(path, ["reflect", "refract", "ior"], &limits)),
            judge(&exr::read_rgba(path, &limits)),
            judge(&exr::read_alpha(path, &ChannelSelect::Auto, &ChannelSelect::Auto, &limits)),
            judge(&exr::read_header(path, &limits)),
            judge(&exr::read_primaries(path)),
        ])
    })
}

/// Reads a PNG file by every reader.
pub fn run_png(bytes: &[u8]) -> Judged {
    let limits = ReadLimits::default();
    with_file(bytes, |path| {
        all([
            judge(&png::read_size(path, &limits)),
            judge(&png::read_depth(path, 0.001, &limits)),
            judge(&png::read_color(path, ColorSpace::Srgb, &limits)),
            judge(&png::read_color(path, ColorSpace::LinearRec709, &limits)),
            judge(&png::read_alpha(path, &limits)),
            judge(&png::has_alpha(path, &limits)),
            judge(&png::is_gray16(path, &limits)),
            judge(&png::read_rgba8(path, &limits)),
            judge(&png::read_rgba16(path, &limits)),
        ])
    })
}

/// Reads a JPEG file by every reader.
pub fn run_jpeg(bytes: &[u8]) -> Judged {
    let limits = ReadLimits::default();
    JPEG_FILE.with(|file| {
        let path = file.path();
        std::fs::write(path, bytes).expect("the temporary file is written");
        all([
            judge(&png::read_size(path, &limits)),
            judge(&png::read_color(path, ColorSpace::Srgb, &limits)),
            judge(&png::has_color(path, &limits)),
            judge(&png::read_rgba8(path, &limits)),
        ])
    })
}

/// Bytes per pixel: the largest planes that are read, and two depth planes with their bit patterns.
const PIXEL_BYTES: u64 = 32;

/// Returns the maximum bytes used to read an OpenEXR file: headers, a chunk and the planes; if the headers are refused, their
/// texts and lists.
pub fn bound_exr(bytes: &[u8]) -> u64 {
    let limits = ReadLimits::default();
    with_file(bytes, |path| {
        let pixels = exr::read_size(path, &limits).map_or(0, |(width, height)| u64::from(width) * u64::from(height));
        let reading = exr::reading_bytes(path, 1, &limits).unwrap_or((1 << 20) + 64 * bytes.len() as u64);
        reading + pixels * (PIXEL_BYTES - 1)
    })
}

/// Returns the maximum bytes used to read an image file: see `ReadLimits`.
pub fn bound(bytes: &[u8]) -> u64 {
    ReadLimits::default().memory_bound(bytes.len() as u64)
}

/// Decodes a texture of a mesh file: PNG or JPEG.
pub fn run_texture(bytes: &[u8]) -> Judged {
    let read = ImageTexture::decode(bytes, [Wrap::Clamp; 2], &mut Budget::new(bytes.len() as u64));
    match &read {
        Ok(texture) if texture.pixels.len() as u64 != u64::from(texture.width) * u64::from(texture.height) => {
            Err("the size is another than that of the pixels".into())
        }
        _ => judge(&read),
    }
}

/// Maximum width and height of images whose rays are generated, and size of the seeds.
const MAX_SEURAT_SIDE: u32 = 256;
const SEURAT_SIZE: (u32, u32) = (20, 15);

/// Reads an OpenEXR file as a view of a Seurat capture.
pub fn run_seurat_exr(bytes: &[u8]) -> Judged {
    let limits = ReadLimits::default();
    with_file(bytes, |path| seurat(path, exr::read_size(path, &limits).unwrap_or(SEURAT_SIZE)))
}

/// Reads a PNG file as a view of a Seurat capture.
pub fn run_seurat_png(bytes: &[u8]) -> Judged {
    PNG_FILE.with(|file| {
        std::fs::write(file.path(), bytes).expect("the temporary file is written");
        seurat(file.path(), png::read_size(file.path(), &ReadLimits::default()).unwrap_or(SEURAT_SIZE))
    })
}

/// Reads colour and depth from one path, and from two.
fn seurat(path: &Path, (width, height): (u32, u32)) -> Judged {
    let (width, height) = match width.max(height) <= MAX_SEURAT_SIDE {
        true => (width.max(1), height.max(1)),
        false => SEURAT_SIZE,
    };
    let file = path.display().to_string();
    let view = |depth: &str, kind: &str| {
        serde_json::json!({
            "projective_camera": {
                "image_width": width, "image_height": height, "depth_type": kind,
                "clip_from_eye_matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -0.2, 0, 0, -1, 0],
                "world_from_eye_matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
            },
            "depth_image_file": {
                "color": { "path": file, "channel_0": "R", "channel_1": "G", "channel_2": "B", "channel_alpha": "CONSTANT_ONE" },
                "depth": { "path": depth, "channel_0": "R" },
            },
        })
    };
    // A different path to the same file.
    let folder = path.parent().unwrap_or(Path::new("/"));
    let again = folder.join("..").join(folder.file_name().unwrap_or_default());
    let other = again.join(path.file_name().unwrap_or_default());
    let views = [view(&file, "EYE_Z"), view(&other.display().to_string(), "RAY_DEPTH")];
    let manifest = serde_json::json!({ "view_groups": [{ "views": views }] }).to_string();
    let capture = SeuratCapture::from_json(manifest.as_bytes(), Path::new("/")).map_err(|error| error.to_string())?;
    all(capture.views.iter().map(|view| {
        let image = match view.image(&ReadLimits::default()) {
            Ok(image) => image,
            Err(error) => return refused(&error),
        };
        all((0..height).map(|row| {
            let rays = image.row(row);
            let is_bad = |rays: &Vec<footage::dataset::seurat::CaptureRay>| {
                rays.iter()
                    .any(|ray| !ray.direction.is_normalized() || ray.distance_m.is_nan() || ray.distance_m <= 0.0)
            };
            match rays.as_ref().is_ok_and(is_bad) {
                true => Err("a ray of no direction or distance".into()),
                false => judge(&rays),
            }
        }))
    }))
}

/// Twice the larger bound of the two readers, which includes a row of rays.
pub fn bound_seurat(bytes: &[u8]) -> u64 {
    bound_exr(bytes).max(bound(bytes)).saturating_mul(2)
}
