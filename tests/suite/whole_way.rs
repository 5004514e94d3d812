//! The pipeline from a scene to a container: `capture`, `encode`, `diff` and `inspect --check` accept the cameras that `place`
//! writes.

use std::path::Path;

use footage::convention::Verdict;
use scene::{DemoKind, DemoScene};
use serde_json::json;
use tempfile::TempDir;

use crate::commands::fine;
use crate::convention::checked;
use crate::model_files::Gltf;

/// Places cameras, captures two frames, encodes them and compares the container with the capture; `inspect` may not suspect a
/// fault.
#[track_caller]
fn all_the_way(scene: &str, region: &str, cameras: u32, folder: &Path) {
    fine(
        &format!(
            "place {scene} --region={region} --effort fast --candidates 96 --surface-samples 1024 --frames 0-1 \
             --cameras {cameras} -o cameras.json"
        ),
        folder,
    );
    fine(&format!("capture {scene} --cameras cameras.json --frames 0-1 --size 64 --samples 2 -o captured"), folder);
    fine("encode captured --clip --max-error 0 --psnr 50 -o a.lfold", folder);
    fine("diff captured a.lfold --allow-clipping --max-error 1 --min-cell-psnr 49.9", folder);
    let report = checked(&folder.join("captured"));
    let suspected: Vec<_> = report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect).collect();
    assert!(suspected.is_empty() && report.findings.len() > 4, "{scene}: {report:#?}");
    // The command reports the same.
    fine("inspect captured --check", folder);
}

#[test]
fn every_built_in_scene_goes_all_the_way() {
    for kind in DemoKind::ALL {
        let folder = TempDir::new().unwrap();
        let (middle, half) = DemoScene::new(kind).probe_region();
        let corners = [middle - half, middle + half].map(|corner| corner.to_array().map(|value| value.to_string()));
        all_the_way(kind.name(), &corners.concat().join(","), 3, folder.path());
    }
}

/// Probes on all sides of an object see few common surfaces, which is not a fault.
#[test]
fn cameras_around_an_object_go_all_the_way() {
    let folder = TempDir::new().unwrap();
    for cameras in [2, 3, 5] {
        all_the_way("object", "-2.5,-1.5,-2.5,2.5,1.5,2.5", cameras, folder.path());
        std::fs::remove_dir_all(folder.path().join("captured")).unwrap();
        std::fs::remove_file(folder.path().join("a.lfold")).unwrap();
    }
}

/// Returns a room of four walls and a floor, 4 m wide and 3 m high, with a slanted board in it.
fn room() -> Gltf {
    let mut file = Gltf::new();
    let mut corners: Vec<f32> = Vec::new();
    let mut quad = |points: [[f32; 3]; 4]| [0, 1, 2, 0, 2, 3].iter().for_each(|&at| corners.extend(points[at]));
    for [x0, z0, x1, z1] in
        [[-2.0, -2.0, 2.0, -2.0], [2.0, -2.0, 2.0, 2.0], [2.0, 2.0, -2.0, 2.0], [-2.0, 2.0, -2.0, -2.0]]
    {
        quad([[x0, 0.0, z0], [x0, 3.0, z0], [x1, 3.0, z1], [x1, 0.0, z1]]);
    }
    quad([[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]]);
    quad([[0.9, 0.0, 0.4], [1.5, 0.0, 0.9], [1.4, 1.1, 1.3], [0.8, 1.1, 0.8]]);
    let position = file.floats("VEC3", &corners);
    file.mesh(json!({ "attributes": { "POSITION": position } }));
    file.root_node(json!({ "mesh": 0 }));
    file
}

#[test]
fn a_room_in_a_file_goes_all_the_way() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("room.glb"), room().glb()).unwrap();
    all_the_way("room.glb", "-0.7,1,-0.7,0.5,2,0.3", 3, folder.path());
}
