//! Every byte of every valid vector changed in three ways, and every truncation: an error, or the very same images. The
//! suite thins the large ones; `scripts/fuzz --vectors` changes all bytes.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::samples;

/// Bytes of a file that the suite changes: the first and last ones, and some between.
const THINNED: usize = 700;

#[derive(Debug, Default)]
struct Counts {
    files: u64,
    refused: AtomicU64,
    identical: AtomicU64,
    truncations: AtomicU64,
}

/// Places in a file that are changed.
fn places(length: usize, most: usize) -> Vec<usize> {
    if length <= most {
        return (0..length).collect();
    }
    // Head, index and foot in full; every so many of the rest.
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
    // The minor version alone may be any; bytes that no chunk names do not occur in the vectors.
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
