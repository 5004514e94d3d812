//! `capture` against footage of another renderer: the same scene from the same positions has the same depths.

use std::path::PathBuf;

use codec::image::{Face, StreamKind};
use footage::dataset::source::{Source, SourceOptions};
use tempfile::TempDir;

use crate::commands::fine;

fn data() -> PathBuf {
    PathBuf::from(option_env!("LIGHTFOLD_DATA").unwrap_or("no data")).canonicalize().unwrap()
}

/// Returns the relative differences of the depths of a face, sorted, of the pixels with a surface in both; and the fraction of
/// pixels with a surface in only one.
fn differences(a: &[f32], b: &[f32]) -> (Vec<f32>, f64) {
    let both = a.iter().zip(b).filter(|(a, b)| a.is_finite() && b.is_finite());
    let mut found: Vec<f32> = both.map(|(a, b)| (a / b - 1.0).abs()).collect();
    found.sort_by(f32::total_cmp);
    let one = a.iter().zip(b).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    (found, one as f64 / a.len() as f64)
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn sponza_has_the_depths_of_its_footage() {
    let place = TempDir::new().unwrap();
    let (scene, footage) = (data().join("meshes/sponza.glb"), data().join("sponza"));
    let line = format!(
        "capture {} --cameras {}/lightfield.json --size 256 --samples 1 --no-color -q -o cap",
        scene.display(),
        footage.display()
    );
    fine(&line, place.path());
    let sources =
        [footage, place.path().join("cap")].map(|path| Source::open(&path, &SourceOptions::default()).unwrap());
    let depth = |source: &Source, probe: usize, face: Face| {
        let mut groups = source.groups().iter();
        let of = groups.find(|group| group.kind == StreamKind::Depth && group.probe == probe && group.faces[0] == face);
        source.read_depth(of.unwrap(), 0).unwrap().swap_remove(0).into_data()
    };
    for probe in 0..3 {
        for face in Face::CUBE {
            let [theirs, ours] = sources.each_ref().map(|source| depth(source, probe, face));
            let (found, one) = differences(&theirs, &ours);
            let median = found[found.len() / 2];
            // The footage has a bunny and three balls that the scene file does not have.
            let alike = found.iter().filter(|found| **found < 1e-3).count() as f64 / found.len() as f64;
            println!("{probe} {face:?}: median {median:e}, {alike:.3} alike, {one:.4} in one only");
            assert!(median < 1e-4 && alike > 0.8 && one < 0.02, "{probe} {face:?}: {median} {alike} {one}");
        }
    }
}
