//! Storage of output views while they are assembled from strips of scanlines: in memory, or in a file if they need more than
//! that.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use half::f16;
use rayon::prelude::*;

use super::interpolate::{Coverage, InterpolatedView};
use codec::error::{Error, Result};
use codec::image::Plane;
use footage::files::DiskFile;

/// Bytes per pixel in a file: three half floats, and the coverage.
const PIXEL_BYTES: usize = 8;

/// Minimum number of pixels that a job reads.
const PIXELS_A_JOB: usize = 1 << 16;

/// Storage of output views until their last strip is complete.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Storage {
    #[default]
    Memory,
    /// Unlinked temporary file in this folder: 8 bytes per pixel of all views.
    File(PathBuf),
}

/// Output views that are assembled from strips.
pub(super) struct ViewStore {
    size: [u32; 2],
    held: Held,
}

enum Held {
    Memory(Vec<InterpolatedView>),
    File { file: File, folder: PathBuf },
}

impl ViewStore {
    pub fn new(storage: &Storage, size: [u32; 2], count: usize) -> Result<ViewStore> {
        let held = match storage {
            Storage::Memory => Held::Memory(vec![blank(size); count]),
            Storage::File(folder) => {
                let file = DiskFile::scratch(folder).map_err(|error| Error::io(folder, error))?;
                Held::File { file, folder: folder.clone() }
            }
        };
        Ok(ViewStore { size, held })
    }

    /// Writes one strip into each view, starting at view `first_view`.
    pub fn put(&mut self, [first_view, first_row]: [usize; 2], strips: &[InterpolatedView]) -> Result<()> {
        let width = self.size[0] as usize;
        match &mut self.held {
            Held::Memory(views) => views[first_view..].par_iter_mut().zip(strips).for_each(|(view, strip)| {
                let pixels = first_row * width..first_row * width + strip.color.data().len();
                view.color.data_mut()[pixels.clone()].copy_from_slice(strip.color.data());
                view.coverage.data_mut()[pixels].copy_from_slice(strip.coverage.data());
            }),
            Held::File { file, folder } => {
                let strips: Vec<Vec<u8>> = strips.par_iter().map(bytes_of).collect();
                for (view, bytes) in (first_view..).zip(&strips) {
                    let row = view as u64 * u64::from(self.size[1]) + first_row as u64;
                    access(file, folder, (PIXEL_BYTES * width) as u64 * row, |file| file.write_all(bytes))?;
                }
            }
        }
        Ok(())
    }

    /// Returns a view whose strips are all complete. Each view can be taken once.
    pub fn take(&mut self, view: usize) -> Result<InterpolatedView> {
        match &mut self.held {
            Held::Memory(views) => Ok(std::mem::replace(&mut views[view], blank([0; 2]))),
            Held::File { file, folder } => {
                let mut bytes = vec![0; PIXEL_BYTES * self.size.map(|side| side as usize).iter().product::<usize>()];
                access(file, folder, view as u64 * bytes.len() as u64, |file| file.read_exact(&mut bytes))?;
                view_of(&bytes, self.size)
            }
        }
    }
}

fn access(
    file: &mut File,
    folder: &Path,
    start: u64,
    access: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> Result<()> {
    let done = file.seek(SeekFrom::Start(start)).and_then(|_| access(file));
    done.map_err(|error| Error::io(folder.join("(views that wait for others)"), error))
}

fn blank([width, height]: [u32; 2]) -> InterpolatedView {
    InterpolatedView {
        color: Plane::filled(width, height, [f16::ZERO; 3]),
        coverage: Plane::filled(width, height, Coverage::Hole),
    }
}

fn code_of(coverage: Coverage) -> u16 {
    match coverage {
        Coverage::Covered => 0,
        Coverage::Hole => 1,
        Coverage::Optical => 2,
    }
}

/// Inverse of [`code_of`].
fn coverage_of(code: u16) -> Coverage {
    match code {
        0 => Coverage::Covered,
        1 => Coverage::Hole,
        _ => Coverage::Optical,
    }
}

fn bytes_of(strip: &InterpolatedView) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PIXEL_BYTES * strip.color.data().len());
    for (color, coverage) in strip.color.data().iter().zip(strip.coverage.data()) {
        let [red, green, blue] = color.map(f16::to_bits);
        bytes.extend_from_slice([red, green, blue, code_of(*coverage)].map(u16::to_le_bytes).as_flattened());
    }
    bytes
}

fn view_of(bytes: &[u8], [width, height]: [u32; 2]) -> Result<InterpolatedView> {
    let pixel = |bytes: &[u8; PIXEL_BYTES]| {
        let [red, green, blue, coverage] =
            std::array::from_fn(|at| u16::from_le_bytes([bytes[2 * at], bytes[2 * at + 1]]));
        ([red, green, blue].map(f16::from_bits), coverage_of(coverage))
    };
    let (color, coverage) = bytes.as_chunks().0.par_iter().with_min_len(PIXELS_A_JOB).map(pixel).unzip();
    Ok(InterpolatedView { color: Plane::new(width, height, color)?, coverage: Plane::new(width, height, coverage)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_the_same_from_memory_and_from_a_file() {
        let size = [5, 7];
        let all = [Coverage::Covered, Coverage::Hole, Coverage::Optical];
        let strip = |view: u16, rows: std::ops::Range<u16>| InterpolatedView {
            color: Plane::from_fn(5, u32::from(rows.end - rows.start), |x, y| {
                [x as u16, rows.start + y as u16, view].map(|value| f16::from_bits(value * 97 + 1))
            }),
            coverage: Plane::from_fn(5, u32::from(rows.end - rows.start), |x, y| {
                all[(x as usize + usize::from(rows.start) + y as usize) % 3]
            }),
        };
        let folder = tempfile::tempdir().unwrap();
        for storage in [Storage::Memory, Storage::File(folder.path().to_owned())] {
            let mut store = ViewStore::new(&storage, size, 3).unwrap();
            for rows in [3..7, 0..3] {
                let strips: Vec<_> = (0..3).map(|view| strip(view, rows.clone())).collect();
                store.put([0, usize::from(rows.start)], &strips[..1]).unwrap();
                store.put([1, usize::from(rows.start)], &strips[1..]).unwrap();
            }
            for view in [2, 0, 1] {
                let (found, expected) = (store.take(usize::from(view)).unwrap(), strip(view, 0..7));
                assert!(found.color == expected.color && found.coverage == expected.coverage, "{storage:?} {view}");
            }
        }
        // The file is unlinked.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let missing = ViewStore::new(&Storage::File(folder.path().join("none")), size, 1);
        assert!(missing.is_err());
    }
}
