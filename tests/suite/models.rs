//! Scenes from mesh files: geometry, animation, and notes about content that is ignored or damaged.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use scene::mesh::Mesh;
use scene::{MeshMaterial, Model, Play, SceneAtTime};
use serde_json::{Value, json};

use crate::accounts::assert_parts_are_named;
use crate::model_files::{Gltf, MTL, OBJ, TRIANGLE, rich};

pub const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Opens a file of these bytes in a folder with some others. Returns the model and its notes.
pub fn open_beside(name: &str, bytes: &[u8], others: &[(&str, &[u8])]) -> codec::error::Result<(Model, Vec<String>)> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in others {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Model::open(&path, Play::All).map(|(model, account)| {
        assert_parts_are_named(bytes, &account);
        (model, account.left_out)
    })
}

pub fn open(file: &Gltf) -> (Model, Vec<String>) {
    open_beside("a.glb", &file.glb(), &[]).unwrap()
}

fn refusal(file: &Gltf) -> String {
    open_beside("a.glb", &file.glb(), &[]).unwrap_err().to_string()
}

/// Returns the only mesh of a scene.
fn only(scene: &SceneAtTime) -> &Mesh {
    assert_eq!(scene.meshes.len(), 1);
    &scene.meshes[0].mesh
}

/// Mesh with its materials.
pub struct Painted {
    pub mesh: Mesh,
    pub materials: Arc<[MeshMaterial]>,
}

impl std::ops::Deref for Painted {
    type Target = Mesh;

    fn deref(&self) -> &Mesh {
        &self.mesh
    }
}

/// Returns the only mesh at time 0.
pub fn first(model: &Model) -> Painted {
    let scene = model.at(0.0);
    Painted { mesh: only(&scene).clone(), materials: scene.meshes[0].materials.clone() }
}

#[track_caller]
fn assert_corners(mesh: &Mesh, expected: &[[f64; 3]]) {
    let corners: Vec<DVec3> = mesh.triangles.as_flattened().iter().map(|&at| mesh.positions[at as usize]).collect();
    assert_eq!(corners.len(), expected.len(), "{corners:?}");
    for (corner, expected) in corners.iter().zip(expected) {
        let expected = DVec3::from_array(*expected);
        assert!(
            (*corner - expected).length() <= 1e-6 * expected.length().max(1.0),
            "{corners:?} instead of {expected}"
        );
    }
}

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Returns a document of one node with the triangle.
pub fn on_node(node: &Value) -> Gltf {
    let mut file = Gltf::new();
    let mut node = node.clone();
    node["mesh"] = json!(file.triangle());
    file.root_node(node);
    file
}

/// File name, bytes, and other files in the same folder.
type Files<'a> = (&'a str, Vec<u8>, Vec<(&'a str, &'a [u8])>);

#[test]
fn a_triangle_comes_out_of_each_kind_of_file() {
    let file = on_node(&json!({}));
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let cases: [Files; 5] = [
        ("a.glb", file.glb(), vec![]),
        ("a.gltf", file.text(), vec![]),
        ("a.gltf", [b"\xef\xbb\xbf \n".to_vec(), file.text()].concat(), vec![]),
        ("a.gltf", file.text_with("b%20c.bin"), vec![("b c.bin", &file.buffer)]),
        ("a.OBJ", obj.to_vec(), vec![]),
    ];
    for (name, bytes, others) in cases {
        let (model, notes) = open_beside(name, &bytes, &others).unwrap();
        assert_eq!((model.duration_s(), model.animations.len(), notes.len()), (0.0, 0, 0), "{name} {notes:?}");
        let mesh = first(&model);
        assert_corners(&mesh, &CORNERS);
        assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
        assert_eq!((mesh.materials[0].plain.base_color, &mesh.material_of[..]), (DVec3::splat(0.8), &[0][..]));
        assert_eq!(model.at(0.0).light.suns.len(), 1, "a day, as the file has no light");
    }
}

#[test]
fn nodes_move_turn_scale_and_mirror() {
    let matrix = json!([0.0, 0.0, -2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 5.0, 6.0, 7.0, 1.0]);
    let moved = [[5.0, 6.0, 7.0], [5.0, 6.0, 5.0], [5.0, 8.0, 7.0]];
    let parts = json!({ "translation": [5, 6, 7], "rotation": [0.0, HALF, 0.0, HALF], "scale": [2, 2, 2] });
    assert_corners(&first(&open(&on_node(&json!({ "matrix": matrix }))).0), &moved);
    assert_corners(&first(&open(&on_node(&parts)).0), &moved);
    // Mirroring reverses the order of the corners, so that the front of a triangle stays its front.
    let mirrored = first(&open(&on_node(&json!({ "scale": [-1, 1, 1] }))).0);
    assert_corners(&mirrored, &[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    // The rotation of a node moves its child.
    let mut file = Gltf::new();
    let mesh = file.triangle();
    let leaf = file.push("nodes", json!({ "mesh": mesh, "translation": [1, 0, 0] }));
    let middle = file.push("nodes", json!({ "children": [leaf], "rotation": [0.0, 0.0, HALF, HALF] }));
    file.root_node(json!({ "children": [middle], "scale": [3, 3, 3] }));
    assert_corners(&first(&open(&file).0), &[[0.0, 3.0, 0.0], [0.0, 6.0, 0.0], [-3.0, 3.0, 0.0]]);
}

#[test]
fn normals_stay_across_their_surfaces() {
    for scale in [[1.0, 2.0, 4.0], [-1.0, 2.0, 4.0], [1e-6, 1e-6, 1e-6], [1e6, 1e6, -1e6]] {
        let mut file = Gltf::new();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0]);
        let normals = file.floats("VEC3", &[HALF, 0.0, HALF].repeat(3));
        let mesh = file.mesh(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
        file.root_node(json!({ "mesh": mesh, "scale": scale, "rotation": [0.0, 0.0, HALF, HALF] }));
        let mesh = first(&open(&file).0);
        let [a, b, c] = mesh.corners(0);
        let across = (b - a).cross(c - a).normalize();
        for normal in &mesh.normals {
            assert!((normal.as_dvec3() - across).length() < 1e-6, "{scale:?}: {normal} instead of {across}");
        }
    }
}

#[test]
fn parts_without_normals_are_flat_beside_parts_with_some() {
    let mut file = Gltf::new();
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0];
    let positions = file.floats("VEC3", &square);
    let smooth =
        file.floats("VEC3", &[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [f32::NAN, 0.0, 1.0]].concat());
    let flat = json!({ "mode": 6, "attributes": { "POSITION": positions } });
    let round = json!({ "mode": 6, "attributes": { "POSITION": positions, "NORMAL": smooth } });
    let mesh = file.push("meshes", json!({ "primitives": [flat, round] }));
    file.root_node(json!({ "mesh": mesh }));
    let mesh = first(&open(&file).0);
    assert_eq!((mesh.triangles.len(), mesh.positions.len(), mesh.normals.len()), (4, 6 + 4, 6 + 4));
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        let across = (b - a).cross(c - a).normalize().as_vec3();
        for (number, &corner) in corners.iter().enumerate() {
            let normal = mesh.normals[corner as usize];
            assert!((normal.length() - 1.0).abs() < 1e-6);
            assert!(triangle >= 2 || (normal - across).length() < 1e-6, "{triangle} {number}");
        }
    }
}

/// Property, interpolation, accessor type and values of an animation curve, and the position of a corner at 1, 1.5 and 3 seconds.
type Moved<'a> = (&'a str, &'a str, &'a str, &'a [f32], [[f64; 3]; 3]);

#[test]
fn a_node_turns_steps_and_eases_and_stays_at_the_ends() {
    let cases: [Moved; 4] = [
        (
            "translation",
            "LINEAR",
            "VEC3",
            &[0.0, 0.0, 0.0, 4.0, 0.0, 8.0],
            [[0.0; 3], [1.0, 0.0, 2.0], [4.0, 0.0, 8.0]],
        ),
        (
            "translation",
            "STEP",
            "VEC3",
            &[1.0, 0.0, 0.0, 4.0, 0.0, 8.0],
            [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [4.0, 0.0, 8.0]],
        ),
        (
            "translation",
            "CUBICSPLINE",
            "VEC3",
            &[[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [64.0, 0.0, 0.0], [0.0; 3]].concat(),
            // At a quarter of the interval the curve is 3/16 − 2/64 of the way.
            [[0.0; 3], [10.0, 0.0, 0.0], [64.0, 0.0, 0.0]],
        ),
        // Rotation does not move corner (0, 0, 0); another corner is checked below.
        ("rotation", "LINEAR", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, HALF, HALF], [[0.0; 3]; 3]),
    ];
    for (path, how, kind, values, expected) in cases {
        let mut file = on_node(&json!({}));
        let times = file.floats("SCALAR", &[1.0, 3.0]);
        let output = file.floats(kind, values);
        file.animate(0, path, json!({ "input": times, "output": output, "interpolation": how }));
        let (model, notes) = open(&file);
        assert_eq!((model.duration_s(), notes.len()), (3.0, 0));
        assert_eq!(model.animations, ["animation 0"]);
        for (time, expected) in
            [(-5.0, 0), (0.0, 0), (1.0, 0), (1.5, 1), (3.0, 2), (1e30, 2)].map(|(t, at)| (t, expected[at]))
        {
            let corner = only(&model.at(time)).positions[0];
            assert!((corner - DVec3::from_array(expected)).length() < 1e-6, "{path} {how} at {time}: {corner}");
        }
        if path == "rotation" {
            let corner = only(&model.at(2.0)).positions[1];
            let angle = 45f64.to_radians();
            assert!((corner - DVec3::new(angle.cos(), angle.sin(), 0.0)).length() < 1e-6, "{corner}");
        }
        let bits = |time: f64| {
            only(&model.at(time)).positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(bits(1.7), bits(1.7));
        assert_eq!(bits(f64::NAN), bits(0.0));
    }
}

#[test]
fn what_stays_is_shared_by_all_times_and_what_moves_is_not() {
    let mut file = on_node(&json!({}));
    let child = file.push("nodes", json!({ "mesh": 0 }));
    let parent = file.root_node(json!({ "children": [child] }));
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let output = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 2.0]);
    let still = file.floats("VEC3", &[0.0, 0.0, 5.0, 0.0, 0.0, 5.0]);
    let sampler = |output: usize| json!({ "input": times, "output": output });
    let channel =
        |sampler: usize, node: usize| json!({ "sampler": sampler, "target": { "node": node, "path": "translation" } });
    // The channel of the first node has two equal values, so the node is static.
    file.push(
        "animations",
        json!({ "name": "go", "samplers": [sampler(output), sampler(still)],
                                    "channels": [channel(0, parent), channel(1, 0)] }),
    );
    file.push("animations", json!({ "name": "stay", "samplers": [sampler(still)], "channels": [channel(0, 0)] }));
    let (model, notes) = open(&file);
    assert!(notes.len() == 1 && notes[0].contains("“stay”"), "{notes:?}");
    let (one, two) = (model.at(0.0), model.at(0.5));
    assert_eq!((one.meshes.len(), two.meshes.len()), (2, 2));
    assert!(std::sync::Arc::ptr_eq(&one.meshes[0], &two.meshes[0]));
    assert_corners(&one.meshes[0].mesh, &CORNERS.map(|[x, y, _]| [x, y, 5.0]));
    assert_corners(&one.meshes[1].mesh, &CORNERS.map(|[x, y, _]| [x, y, 1.0]));
    assert_corners(&two.meshes[1].mesh, &CORNERS.map(|[x, y, _]| [x, y, 1.5]));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    std::fs::write(&path, file.glb()).unwrap();
    let (model, account) = Model::open(&path, Play::Named("stay")).unwrap();
    assert_eq!(
        (model.duration_s(), &account.left_out[..], &model.animations[..]),
        (
            0.0,
            &["the animation “go” was left out: another was chosen".to_string()][..],
            &["go".to_string(), "stay".to_string()][..]
        )
    );
    let corners = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
    assert_corners(only(&model.at(0.0)), &[corners, CORNERS].concat());
    let message = Model::open(&path, Play::Named("run")).unwrap_err().to_string();
    assert!(message.contains("“run”") && message.contains("go, stay"), "{message}");
}

#[test]
fn a_skin_bends_corners_as_its_joints_turn() {
    // An arm along Y: its elbow at y = 1 rotates by 90° around Z. The corner at y = 2 moves with the elbow to x = −1 relative to
    // the shoulder; the corner beside the elbow is blended between both joints.
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.5, 1.0, 0.0]);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let joints = file.shorts("VEC4", &[[0, 9, 9, 9], [0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]].concat());
    let one = [1.0, 0.0, 0.0, 0.0];
    // The weights of the last corner add up to 2 and are normalised to a half each.
    let weights = file.floats("VEC4", &[one, one, one, [1.0, 1.0, 0.0, 0.0]].concat());
    let order = file.shorts("SCALAR", &[0, 1, 3, 0, 3, 2]);
    let mesh = file.mesh(json!({ "indices": order, "attributes":
        { "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights } }));
    let elbow = file.push("nodes", json!({ "translation": [0, 1, 0] }));
    let shoulder = file.root_node(json!({ "children": [elbow], "translation": [10, 0, 0] }));
    let mut bind = [0.0f32; 32];
    for (at, down) in [(0, 0.0), (16, -1.0)] {
        for cell in [0, 5, 10, 15] {
            bind[at + cell] = 1.0;
        }
        bind[at + 13] = down;
    }
    let bind = file.floats("MAT4", &bind);
    let skin = file.push("skins", json!({ "joints": [shoulder, elbow], "inverseBindMatrices": bind }));
    // The transform of the node does not affect a skinned mesh.
    file.root_node(json!({ "mesh": mesh, "skin": skin, "translation": [77, 77, 77] }));
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let turn = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, HALF, HALF]);
    file.animate(elbow, "rotation", json!({ "input": times, "output": turn }));
    let (model, _) = open(&file);
    let at = |time: f64| only(&model.at(time)).clone();
    let straight =
        [[10.0, 0.0, 0.0], [10.5, 0.0, 0.0], [10.5, 1.0, 0.0], [10.0, 0.0, 0.0], [10.5, 1.0, 0.0], [10.0, 2.0, 0.0]];
    assert_corners(&at(0.0), &straight);
    // The corner beside the elbow is half on each joint, at the mean of (10.5, 1) and (10, 1.5).
    let bent =
        [[10.0, 0.0, 0.0], [10.5, 0.0, 0.0], [10.25, 1.25, 0.0], [10.0, 0.0, 0.0], [10.25, 1.25, 0.0], [9.0, 1.0, 0.0]];
    assert_corners(&at(1.0), &bent);
    assert!(at(1.0).normals.iter().all(|normal| (*normal - glam::Vec3::Z).length() < 1e-6));
}

#[test]
fn morph_targets_add_what_their_weights_say() {
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &TRIANGLE);
    let up = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tilt = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    // The second target is sparse: it moves only corner 1.
    let indices = file.view(&[1, 0, 0, 0]);
    let values = file.view(&[0.0f32, 4.0, 0.0].map(f32::to_le_bytes).concat());
    let sparse = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } });
    let aside = file.push("accessors", json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse }));
    let mesh = file.push(
        "meshes",
        json!({ "weights": [0.5, 0.25], "primitives": [{ "attributes": { "POSITION": positions, "NORMAL": normals },
        "targets": [{ "POSITION": up, "NORMAL": tilt }, { "POSITION": aside }] }] }),
    );
    let node = file.root_node(json!({ "mesh": mesh }));
    let still = first(&open(&file).0);
    assert_corners(&still, &[[0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]);
    let tilted = glam::Vec3::new(0.5, 0.0, 1.0).normalize();
    assert!(still.normals.iter().all(|normal| (*normal - tilted).length() < 1e-6));
    let times = file.floats("SCALAR", &[0.0, 2.0]);
    let weights = file.floats("SCALAR", &[0.0, 0.0, 1.0, 1.0]);
    file.animate(node, "weights", json!({ "input": times, "output": weights }));
    let (model, _) = open(&file);
    for (time, weight) in [(0.0, 0.0), (0.5, 0.25), (2.0, 1.0)] {
        let corners = [[0.0, 0.0, 2.0 * weight], [1.0, 4.0 * weight, 2.0 * weight], [0.0, 1.0, 2.0 * weight]];
        assert_corners(only(&model.at(time)), &corners);
    }
    // The weights of a node override those of its mesh.
    file.root["nodes"][node]["weights"] = json!([1.0, 0.0]);
    file.root["animations"] = json!([]);
    assert_corners(&first(&open(&file).0), &[[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]]);
}

#[test]
fn integers_become_what_their_type_says() {
    let mut file = Gltf::new();
    // Three of every four bytes are a position; the fourth is padding.
    let view = file.view(&[0, 0, 0, 99, 127, 0, 0, 99, 0, 0x81, 0, 99]);
    file.root["bufferViews"][view]["byteStride"] = json!(4);
    let accessor = json!({ "bufferView": view, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" });
    let positions = file.push("accessors", accessor);
    let mesh = file.mesh(json!({ "attributes": { "POSITION": positions } }));
    file.root_node(json!({ "mesh": mesh }));
    file.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_corners(&first(&open(&file).0), &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    file.root["accessors"][positions]["normalized"] = json!(false);
    assert_corners(&first(&open(&file).0), &[[0.0; 3], [127.0, 0.0, 0.0], [0.0, -127.0, 0.0]]);
}

#[test]
fn sizes_from_a_micrometre_to_a_thousand_kilometres_are_kept() {
    for scale in [1e-6, 1.0, 1e6] {
        let (model, notes) = open(&on_node(&json!({ "scale": [scale, scale, scale] })));
        assert!(notes.is_empty(), "{notes:?}");
        let mesh = first(&model);
        assert_eq!(mesh.triangles.len(), 1);
        assert!((mesh.positions[1].x / scale - 1.0).abs() < 1e-6);
        let text = format!("v 0 0 0\nv {scale} 0 0\nv 0 {scale} 0\nf 1 2 3\n");
        let (model, notes) = open_beside("a.obj", text.as_bytes(), &[]).unwrap();
        assert!(notes.is_empty() && (first(&model).positions[1].x / scale - 1.0).abs() < 1e-6);
    }
}

#[test]
fn triangles_that_cannot_be_met_are_counted() {
    let mut file = Gltf::new();
    let inf = f32::INFINITY;
    let positions = file.floats("VEC3", &[TRIANGLE, [f32::NAN, 0.0, 0.0, inf, 0.0, 0.0, 2.0, 0.0, 0.0]].concat());
    let order = file.shorts("SCALAR", &[0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 5, 0, 0, 1, 2, 2, 2]);
    let mesh = file.mesh(json!({ "attributes": { "POSITION": positions }, "indices": order }));
    file.root_node(json!({ "mesh": mesh }));
    let (model, notes) = open(&file);
    assert_corners(&first(&model), &CORNERS);
    assert_eq!(first(&model).positions.len(), 3, "corners of what is left out go with it");
    assert_eq!(notes.len(), 2);
    assert!(notes[0].contains(": 2 triangles") && notes[1].contains(": 3 triangles"), "{notes:?}");
    // Without any triangle that has an area, the scene is refused as empty.
    file.root["nodes"][0]["scale"] = json!([0, 0, 0]);
    assert!(refusal(&file).contains("no triangles"));
}

#[test]
fn points_and_lines_are_left_out_with_a_note() {
    let mut file = on_node(&json!({}));
    let positions = file.floats("VEC3", &TRIANGLE);
    for mode in 0..4 {
        let mesh = file.mesh(json!({ "attributes": { "POSITION": positions }, "mode": mode }));
        file.root_node(json!({ "mesh": mesh }));
    }
    let (model, notes) = open(&file);
    assert_eq!(first(&model).triangles.len(), 1);
    assert!(notes.len() == 1 && notes[0].starts_with("4 primitives"), "{notes:?}");
}

#[test]
fn only_the_default_scene_is_shown() {
    let mut file = on_node(&json!({}));
    let hidden = file.push("nodes", json!({ "mesh": 0, "translation": [9, 9, 9] }));
    assert_corners(&first(&open(&file).0), &CORNERS);
    file.push("scenes", json!({ "nodes": [hidden] }));
    file.root["scene"] = json!(1);
    assert_corners(&first(&open(&file).0), &[[9.0, 9.0, 9.0], [10.0, 9.0, 9.0], [9.0, 10.0, 9.0]]);
    file.root.as_object_mut().unwrap().retain(|key, _| key != "scene" && key != "scenes");
    assert_eq!(first(&open(&file).0).triangles.len(), 2);
}

#[test]
fn a_tree_of_nodes_may_be_deep() {
    let mut file = Gltf::new();
    let mesh = file.triangle();
    let depth = 100_000;
    let nodes: Vec<Value> =
        (0..depth).map(|at| json!({ "children": [at + 1], "translation": [0.0, 0.0, 0.001] })).collect();
    file.root["nodes"] = json!(nodes);
    file.push("nodes", json!({ "mesh": mesh }));
    file.root["scenes"] = json!([{ "nodes": [0] }]);
    let mesh = first(&open(&file).0);
    assert!((mesh.positions[0].z - 100.0).abs() < 1e-4, "{}", mesh.positions[0]);
}

#[test]
fn obj_files_without_their_materials_are_grey() {
    let (model, notes) = open_beside("a.obj", OBJ.as_bytes(), &[]).unwrap();
    assert!(notes[0].contains("2 points, lines"), "{notes:?}");
    assert!(notes[1].contains("none.mtl"), "{notes:?}");
    let mesh = first(&model);
    assert_eq!((mesh.triangles.len(), mesh.materials.len()), (4, 1));
    assert!(mesh.material_of.iter().all(|&material| material == 0));
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    let (model, _) = open_beside("a.obj", OBJ.as_bytes(), &[("none.mtl", MTL.as_bytes())]).unwrap();
    assert_eq!(first(&model).materials.len(), 3);
    let broken = "newmtl a\nKd x\n";
    let (_, notes) = open_beside("a.obj", OBJ.as_bytes(), &[("none.mtl", broken.as_bytes())]).unwrap();
    assert!(notes[1].contains("damaged"), "{notes:?}");
    for bad in ["..", "/etc/passwd", "../a.mtl", "c:\\a.mtl"] {
        let text = format!("mtllib {bad}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let (_, notes) = open_beside("a.obj", text.as_bytes(), &[]).unwrap();
        assert_eq!(notes.len(), 1, "{bad}: {notes:?}");
    }
}

#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
#[test]
fn the_meshes_beside_the_footage_are_whole() {
    let data = option_env!("LIGHTFOLD_DATA").unwrap_or_default();
    // Name, number of triangles, and number of those without area.
    for (name, triangles, no_area) in [("sponza.glb", 262_267, 1), ("dragon.glb", 202_520, 0), ("bunny.obj", 69_451, 0)]
    {
        let (model, account) = Model::open(&Path::new(data).join("meshes").join(name), Play::All).unwrap();
        let (mesh, notes) = (first(&model), account.left_out);
        assert_eq!((mesh.triangles.len(), notes.len()), (triangles - no_area, no_area), "{name}: {notes:?}");
        assert_eq!(model.duration_s(), 0.0);
        let textures = mesh.materials.iter().filter(|material| material.plain.base_texture.is_some()).count();
        assert_eq!(textures, if name == "sponza.glb" { 24 } else { 0 }, "{name}");
    }
}

#[test]
fn the_rich_document_has_everything() {
    let (model, notes) = open(&rich());
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!((model.duration_s(), &model.animations[..]), (2.0, &["all".to_string()][..]));
    assert_eq!(only(&model.at(1.0)).triangles.len(), 4);
    assert_eq!(open_beside("a.gltf", &rich().text(), &[]).unwrap().0.at(1.0).light.lamps.len(), 1);
}
