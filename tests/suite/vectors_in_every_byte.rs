//! Changes every byte of every valid vector in three ways, and truncates the vector at every byte: decoding fails or returns
//! identical images. The suite tests a subset of the bytes of large files; `scripts/fuzz --vectors` tests all.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::samples;

/// Number of bytes per file that the suite changes: the first and the last ones, and some between them.
const THINNED: usize = 700;

#[derive(Debug, Default)]
struct Counts {
    files: u64,
    refused: AtomicU64,
    identical: AtomicU64,
    truncations: AtomicU64,
}

/// Returns the offsets of the bytes to change, about `most` of `length`.
fn places(length: usize, most: usize) -> Vec<usize> {
    if length <= most {
        return (0..length).collect();
    }
    // All bytes of the header and of the last `most / 2`, with index and footer; the others at a constant step.
    let (head, tail) = (16, most / 2);
    let step = (length - head - tail).div_ceil(most - head - tail);
    (0..head).chain((head..length - tail).step_by(step)).chain(length - tail..length).collect()
}

fn change_all(most: usize) -> Counts {
    let mut counts = Counts::default();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "lfold"));
    paths.sort();
    for path in &paths {
        let file = fs::read(path).unwrap();
        let images = samples::decode_all(file.clone()).unwrap();
        counts.files += 1;
        places(file.len(), most).into_par_iter().for_each(|at| {
            let byte = file[at];
            for changed in [byte ^ 1 << (at % 8), byte.wrapping_add(1), 0xff - byte] {
                let mut damaged = file.clone();
                damaged[at] = changed;
                let counter = match samples::decode_all(damaged) {
                    Err(error) => {
                        assert!(
                            !matches!(error, lightfold::Error::Interrupted) && !error.to_string().contains('\n'),
                            "{error}"
                        );
                        &counts.refused
                    }
                    Ok(shown) => {
                        assert!(shown == images, "{}: byte {at} as {changed}: other pixels", path.display());
                        &counts.identical
                    }
                };
                counter.fetch_add(1, Ordering::Relaxed);
            }
            let cut = samples::decode_all(file[..at].to_vec());
            assert!(cut.is_err(), "{}: {at} bytes of it are taken", path.display());
            counts.truncations.fetch_add(1, Ordering::Relaxed);
        });
    }
    println!("{counts:?}");
    counts
}

#[test]
fn thinned() {
    let counts = change_all(THINNED);
    assert!(counts.files >= 37);
    // Only changes of the minor version are not detected: no byte of the vectors is outside of header, chunks, index and footer.
    let identical = counts.identical.into_inner();
    assert!((counts.files..=6 * counts.files).contains(&identical), "{identical} changes are not seen");
}

#[test]
#[ignore = "takes minutes: scripts/fuzz --vectors"]
fn whole() {
    let counts = change_all(usize::MAX);
    let identical = counts.identical.into_inner();
    assert!((counts.files..=6 * counts.files).contains(&identical), "{identical} changes are not seen");
}
