//! Camera files of other programs: parsed, and if accepted, written in every format.

use codec::error::Result;
use evaluate::cameras::{self, CameraFormat, Content, FileCameras, ReadSettings, WriteSettings};
use tempfile::TempDir;

use super::{Judged, judge, models};

/// Separates cameras.txt and images.txt in an input.
pub const BETWEEN: &[u8] = b"====\n";
pub const FORMATS: [CameraFormat; 5] =
    [CameraFormat::Lightfold, CameraFormat::Transforms, CameraFormat::Colmap, CameraFormat::Gltf, CameraFormat::Usd];
pub const SETTINGS: WriteSettings = WriteSettings { size: (480, None), fps: 24.0 };

thread_local! {
    static FOLDER: TempDir = TempDir::new().expect("a temporary folder");
}

fn look(read: &Result<FileCameras>) -> Judged {
    if let Ok(FileCameras { cameras: all, .. }) = read {
        if let Some(camera) = all.iter().find(|camera| !camera.timed.camera.eye().is_finite()) {
            return Err(format!("a camera stands nowhere: {camera:?}"));
        }
        // Writing more cameras would test nothing new.
        for format in FORMATS.into_iter().filter(|_| all.len() <= 64) {
            judge(&cameras::write(all, format, &SETTINGS))?;
        }
    }
    judge(read)
}

/// Parses an input as a camera file of any format except COLMAP; the format is recognised by the content.
pub fn run(bytes: &[u8]) -> Judged {
    FOLDER.with(|folder| {
        let path = folder.path().join("none/cameras");
        look(&cameras::parse(&Content { path: &path, bytes, settings: ReadSettings::with_fps(24.0) }))
    })
}

/// Reads a COLMAP folder with cameras.txt and images.txt.
pub fn run_colmap(bytes: &[u8]) -> Judged {
    let place = bytes.windows(BETWEEN.len()).position(|window| window == BETWEEN);
    let (lenses, images) = place.map_or((bytes, &[][..]), |at| (&bytes[..at], &bytes[at + BETWEEN.len()..]));
    FOLDER.with(|folder| {
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("a file");
        write("cameras.txt", lenses);
        write("images.txt", images);
        look(&cameras::read(folder.path(), ReadSettings::with_fps(24.0)))
    })
}

/// The bound of meshes, because glTF camera files are parsed by the same reader; animated cameras have a pose for each frame.
pub fn bound(bytes: &[u8]) -> u64 {
    models::bound(bytes)
}
