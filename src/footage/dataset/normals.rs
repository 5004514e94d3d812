//! Normal maps: channels X, Y, Z of EXR files, unit vectors in world axes, zero for the background.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::manifest::{Manifest, NORMAL_CHANNELS};
use super::pixels::pixel;
use crate::image_files::{exr, png};
use codec::error::{Error, Result};
use codec::image::{Face, FrameRange, NormalPlane, ReadLimits, Sequence};

/// Files by probe and first face; empty if the dataset has no normals.
#[derive(Debug, Default)]
pub struct NormalFiles(BTreeMap<(usize, Face), Sequence>);

impl NormalFiles {
    /// The files of all frames.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.0.values().flat_map(Sequence::files)
    }

    /// Finds the normal files of a manifest in `folder`. `first_faces` holds the first face of each file of a frame, `frames` the
    /// frames of each probe.
    pub fn of(manifest: &Manifest, folder: &Path, first_faces: &[Face], frames: &[FrameRange]) -> Result<NormalFiles> {
        let mut files = BTreeMap::new();
        for (at, (probe, &frames)) in manifest.probes.iter().zip(frames).enumerate() {
            for &face in first_faces {
                let Some(pattern) = manifest.normal_pattern(&probe.name, face)? else { continue };
                files.insert((at, face), Sequence::known(pattern.below(folder), frames)?);
            }
        }
        Ok(NormalFiles(files))
    }

    pub fn path(&self, probe: usize, first_face: Face, frame: u32) -> Option<PathBuf> {
        self.0.get(&(probe, first_face)).filter(|files| files.frames.contains(frame)).map(|files| files.path(frame))
    }
}

/// Reads normals from an EXR file. Fails if a normal is not finite.
pub fn read(path: &Path, limits: &ReadLimits) -> Result<NormalPlane> {
    if png::has_codes(path) {
        return Err(Error::unsupported("normals must be EXR files"));
    }
    let plane = exr::read_channels(path, NORMAL_CHANNELS, limits)?;
    match plane.data().iter().position(|normal| normal.iter().any(|part| !part.is_finite())) {
        Some(at) => Err(Error::invalid(format!("the normal at {} is not finite", pixel(at, plane.width())))),
        None => Ok(plane),
    }
}

/// True if at least half of the vectors of an EXR file that are not zero have length 1 within 5%: edges are averages. False for
/// positions, and for files that cannot be read.
pub fn are_unit_vectors(path: &Path, limits: &ReadLimits) -> bool {
    let Ok(plane) = read(path, limits) else { return false };
    let lengths = plane.data().iter().map(|normal| normal.iter().map(|part| part * part).sum::<f32>().sqrt());
    let lengths: Vec<f32> = lengths.filter(|length| *length > 0.0).collect();
    let units = lengths.iter().filter(|length| (**length - 1.0).abs() < 0.05).count();
    units > 0 && 2 * units >= lengths.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_that_are_not_finite_and_png_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("normal.exr");
        let mut plane = NormalPlane::filled(3, 2, [0.0, 1.0, 0.0]);
        exr::write_material(&path, &plane, NORMAL_CHANNELS).unwrap();
        assert_eq!(read(&path, &ReadLimits::default()).unwrap(), plane);
        assert!(are_unit_vectors(&path, &ReadLimits::default()));
        exr::write_material(&path, &plane.map(|normal| normal.map(|part| 3.0 * part)), NORMAL_CHANNELS).unwrap();
        assert!(!are_unit_vectors(&path, &ReadLimits::default()));
        plane.data_mut()[4][1] = f32::NAN;
        exr::write_material(&path, &plane, NORMAL_CHANNELS).unwrap();
        let said = read(&path, &ReadLimits::default()).unwrap_err().to_string();
        assert!(said.contains("normal at pixel (1, 1)"), "{said}");
        let said = read(Path::new("a.png"), &ReadLimits::default()).unwrap_err().to_string();
        assert!(said.contains("must be EXR files"), "{said}");
    }
}
