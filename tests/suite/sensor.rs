//! Footage of a depth sensor with a known camera. If it has few planar depths, they stay planar and streams have levels; all
//! commands that read such a container support it.

use std::fs;
use std::path::Path;

use codec::container::Reader;
use codec::decode::Decoder;
use codec::image::{DepthKind, Plane, ReadLimits};
use codec::streams::{CodecHeader, DepthCoding};
use footage::image_files::png;
use tempfile::TempDir;

use crate::commands::fine;
use crate::samples::Random;

const MANIFEST: &str = r#"{ "lightfield": 1, "name": "sensor", "fps": 30, "frames": [0, 1], "projection": "perspective",
    "size": [80, 60], "depth": { "kind": "planar", "unit": "mm", "background": 0 },
    "files": { "depth": "z.%d.png", "color": "c.%d.png" },
    "probes": [{ "name": "a", "position": [0, 0, 0], "intrinsics": [60, 60, 39.5, 29.5] }] }"#;

/// Writes footage of a wall with a box in front of it, in depth steps of the sensor. `noise` is in millimetres, 0 for a sensor
/// with few depths.
fn footage(noise: u32) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("lightfield.json"), MANIFEST).unwrap();
    let mut random = Random(9);
    for frame in 0..2 {
        let depth = Plane::from_fn(80, 60, |x, y| {
            let (is_box, is_hole) = ((20..50).contains(&x) && (15..45).contains(&y), x < 3);
            let step = if is_box { 0 } else { 12 + y / 6 } + random.below(2);
            let millimetres = 1000 + 40 * step + noise * random.below(30) + frame;
            if is_hole { 0 } else { millimetres as u16 }
        });
        png::write_depth16(&folder.path().join(format!("z.{frame}.png")), &depth).unwrap();
        let color = Plane::from_fn(80, 60, |x, y| [(3 * x) as u8, (4 * y) as u8, 100]);
        png::write_color8(&folder.path().join(format!("c.{frame}.png")), &color).unwrap();
    }
    folder
}

/// Returns a container's kind of depth and its number of levels.
fn depth_of(path: &Path) -> (DepthKind, usize) {
    let decoder = Decoder::new(Reader::open(path).unwrap()).unwrap();
    let depth = decoder.streams().iter().find_map(|stream| match &stream.header {
        CodecHeader::Depth(header) => Some(header),
        _ => None,
    });
    let header = depth.unwrap();
    let DepthCoding::Predictive(predictive) = &header.coding else { panic!("prediction expected") };
    (header.kind, predictive.levels.codes().len())
}

#[test]
fn few_planar_depths_stay_planar_and_exact() {
    let folder = footage(0);
    let root = folder.path();
    fine("encode . -o few.lfold", root);
    // Per frame, two steps of the box, and eleven of the wall: ten by row, and one more by the random step.
    assert_eq!(depth_of(&root.join("few.lfold")), (DepthKind::Planar, 2 * (2 + 11)));
    fine("diff . few.lfold --stream depth --max-error 0", root);
    fine("diff few.lfold . --stream depth --max-error 0", root);
    fine("diff few.lfold z.%d.png --stream depth --depth-scale 0.001 --background 0 --max-error 0", root);
    fine("decode few.lfold -o decoded", root);
    fine("diff few.lfold decoded --max-error 0", root);
    fine("diff . decoded --stream depth --max-error 0", root);
    fine("encode decoded -o again.lfold --stream depth", root);
    fine("diff few.lfold again.lfold --stream depth --max-error 0", root);
}

#[test]
fn planar_depth_becomes_distance_where_it_has_no_levels() {
    let few = footage(0);
    fine("encode . -o range.lfold --near 0.5 --far 9", few.path());
    assert_eq!(depth_of(&few.path().join("range.lfold")), (DepthKind::Distance, 0));
    let many = footage(7);
    fine("encode . -o many.lfold", many.path());
    assert_eq!(depth_of(&many.path().join("many.lfold")), (DepthKind::Distance, 0));
    fine("diff . many.lfold --stream depth --max-error 100", many.path());
}

#[test]
fn pictures_of_planar_depth_are_those_of_distances() {
    let folder = footage(0);
    let root = folder.path();
    fine("encode . -o planar.lfold", root);
    fine("encode . -o distance.lfold --near 0.5 --far 9 --max-error 0", root);
    let picture = |name: &str| {
        fine(
            &format!("render {name}.lfold --eye 0.1,0.05,0 --look-at 0.1,0,-1 --size 60 --holes blank -o {name}.png"),
            root,
        );
        png::read_rgba8(&root.join(format!("{name}.png")), &ReadLimits::default()).unwrap()
    };
    let (planar, distance) = (picture("planar"), picture("distance"));
    let pairs = planar.data().iter().zip(distance.data());
    let differ = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 6)).count();
    assert!(differ * 50 < planar.data().len(), "{differ} of {} pixels", planar.data().len());
    let lit = planar.data().iter().filter(|pixel| pixel[2] > 50).count();
    assert!(2 * lit > planar.data().len(), "{lit} pixels show something");
}
