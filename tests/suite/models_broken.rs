//! Broken or hostile mesh files: an error of one line, no panic, and bounded memory.

use scene::{Model, Play};
use serde_json::{Value, json};

use crate::model_files::{Gltf, rich};

fn open(name: &str, bytes: &[u8]) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Model::open(&path, Play::All).map(|_| ()).map_err(|error| error.to_string())
}

/// Opens the rich document after a change of its JSON.
fn changed(change: impl FnOnce(&mut Value)) -> Result<(), String> {
    let mut file = rich();
    change(&mut file.root);
    open("a.glb", &file.glb())
}

#[track_caller]
fn refused(result: Result<(), String>, words: &str) {
    let message = result.expect_err("it is refused");
    assert!(message.contains(words) && !message.contains('\n'), "{message}");
    assert!(message.contains("a.glb") || message.contains("a.gltf") || message.contains("a.obj"), "{message}");
}

#[test]
fn extras_may_be_anything_and_accessors_without_data_are_zeros() {
    for extras in [json!("text"), json!(3), json!([1, [2]]), json!(true), json!(null), json!({ "a": { "b": 1 } })] {
        let everywhere = |root: &mut Value| {
            root["extras"] = extras.clone();
            for list in ["nodes", "meshes", "accessors", "materials", "scenes", "skins", "animations", "bufferViews"] {
                for thing in root[list].as_array_mut().into_iter().flatten() {
                    thing["extras"] = extras.clone();
                }
            }
            root["asset"]["extras"] = extras.clone();
            root["meshes"][0]["primitives"][0]["extras"] = extras.clone();
        };
        assert_eq!(changed(everywhere), Ok(()), "{extras}");
    }
    // Normals that are zero are replaced by those of the triangles.
    let zeros = |root: &mut Value| {
        root["accessors"][1].as_object_mut().unwrap().remove("bufferView");
        root["accessors"][1].as_object_mut().unwrap().remove("byteOffset");
    };
    assert_eq!(changed(zeros), Ok(()));
    let positions = |root: &mut Value| _ = root["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(changed(positions), Ok(()), "what it moves may be without area");
}

/// Words of the error message, and the change of the document that causes it.
type Case = (&'static str, fn(&mut Value));

#[test]
fn each_broken_document_has_its_sentence() {
    let cases: &[Case] = &[
        ("no triangles", |root| root["scenes"][0]["nodes"] = json!([])),
        ("no triangles", |root| root["nodes"].as_array_mut().unwrap().iter_mut().for_each(|node| *node = json!({}))),
        ("KHR_draco_mesh_compression", |root| root["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
        ("EXT_meshopt_compression", |root| {
            root["extensionsRequired"] = json!(["KHR_materials_ior", "EXT_meshopt_compression"])
        }),
        ("XX_unheard_of", |root| root["extensionsRequired"] = json!(["XX_unheard_of"])),
        ("version", |root| root["asset"]["version"] = json!("1.0")),
        ("mesh 0, primitive 0: 4 normals for 3 positions", |root| root["accessors"][0]["count"] = json!(3)),
        ("mesh 0, primitive 0: a triangle refers to vertex 3", |root| {
            root["accessors"][0]["count"] = json!(3);
            root["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
        }),
        ("elements reach", |root| root["accessors"][0]["count"] = json!(5)),
        ("memory", |root| root["accessors"][0]["count"] = json!(1u64 << 60)),
        ("memory", |root| {
            let sparse = json!({ "count": 0, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 0 } });
            root["accessors"][0] =
                json!({ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3", "sparse": sparse });
        }),
        ("expected", |root| root["accessors"][0]["type"] = json!("VEC2")),
        ("elements reach", |root| root["accessors"][0]["byteOffset"] = json!(u64::MAX)),
        ("unsigned integers", |root| root["accessors"][3]["componentType"] = json!(5122)),
        ("shows", |root| root["bufferViews"][1]["byteLength"] = json!(1 << 30)),
        ("shows", |root| root["bufferViews"][1]["byteOffset"] = json!(u64::MAX)),
        ("bytes apart", |root| root["bufferViews"][1]["byteStride"] = json!(4)),
        ("byteStride", |root| root["bufferViews"][1]["byteStride"] = json!(0)),
        ("bufferViews[1].buffer", |root| root["bufferViews"][1]["buffer"] = json!(7)),
        ("an accessor for positions", |root| root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99)),
        ("POSITION", |root| root["meshes"][0]["primitives"][0]["attributes"] = json!({})),
        ("is an invalid index", |root| root["meshes"][0]["primitives"][0]["indices"] = json!(99)),
        ("is an invalid index", |root| root["meshes"][0]["primitives"][0]["material"] = json!(99)),
        ("3 normals for 4", |root| root["accessors"][1]["count"] = json!(3)),
        ("not allowed", |root| root["meshes"][0]["primitives"][0]["mode"] = json!(9)),
        ("its own ancestor", |root| root["nodes"][1]["children"] = json!([2])),
        ("its own ancestor", |root| root["nodes"].as_array_mut().unwrap().push(json!({ "children": [5] }))),
        ("child of node", |root| root["nodes"][0]["children"] = json!([1])),
        ("a root of the scene", |root| root["scenes"][0]["nodes"] = json!([0, 1])),
        ("is an invalid index", |root| root["nodes"][0]["mesh"] = json!(99)),
        ("is an invalid index", |root| root["scenes"][0]["nodes"] = json!([99])),
        ("is an invalid index", |root| root["skins"][0]["joints"] = json!([99])),
        ("matrices for", |root| root["skins"][0]["joints"] = json!([0, 1, 2])),
        ("refers to joint 1", |root| root["skins"][0]["joints"] = json!([2])),
        ("animates node 99", |root| root["animations"][0]["channels"][0]["target"]["node"] = json!(99)),
        ("animates an unknown property", |root| {
            root["animations"][0]["channels"][0]["target"]["path"] = json!("color")
        }),
        ("is an invalid index", |root| root["animations"][0]["channels"][0]["sampler"] = json!(99)),
        ("not allowed", |root| root["animations"][0]["samplers"][0]["interpolation"] = json!("MAGIC")),
        ("expected", |root| root["animations"][0]["channels"][0]["target"]["path"] = json!("scale")),
        ("numbers for 2 keys", |root| root["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE")),
        ("is an invalid index", |root| root["textures"][0]["source"] = json!(99)),
        ("is an invalid index", |root| root["nodes"][4]["extensions"]["KHR_lights_punctual"]["light"] = json!(99)),
        ("below 0", |root| root["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-1.0)),
    ];
    let wrong: Vec<String> = cases
        .iter()
        .filter_map(|(words, change)| match changed(change) {
            Err(message) if message.contains(words) && message.contains("a.glb") && !message.contains('\n') => None,
            other => Some(format!("{words}: {other:?}")),
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(changed(|_| ()), Ok(()));
}

#[test]
fn each_broken_file_has_its_sentence() {
    let good = rich().glb();
    refused(open("a.glb", b"glTF"), "ends early");
    refused(open("a.glb", b"glTF\x01\0\0\0\x0c\0\0\0"), "version 1");
    refused(open("a.glb", b"glTF\x02\0\0\0\0\0\0\0"), "no JSON chunk");
    refused(open("a.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff"), "ends early");
    refused(open("a.glb", &good[..good.len() - 1]), "ends early");
    refused(open("a.gltf", b"{"), "JSON");
    refused(open("a.gltf", b"{}"), "JSON");
    refused(open("a.gltf", &[b"{\"asset\":".repeat(100_000), b"1".to_vec()].concat()), "JSON");
    refused(open("a.glb", b""), "neither");
    refused(open("a.obj", b""), "no triangles");
    refused(open("a.obj", b"v 1 2 3\n"), "no triangles");
    refused(open("a.obj", b"v 1 2 x\nf 1 1 1\n"), "damaged");
    refused(open("a.obj", b"v 1 2 3\nf 1 2 3\n"), "damaged");
    refused(open("a.obj", b"v 1 2 3\nf -9 1 1\n"), "line 2: “-9” is not a face vertex");
    refused(open("a.obj", b"v 1 2 3\nvt 0 0\nf 1/-9 1 1\n"), "line 3");
    refused(open("a.obj", b"v 1 2 3\nvt 0 0\n\nf 1/9223372036854775807 1 1\n"), "line 4");
    refused(open("a.obj", &[0xff; 3000]), "no triangles");
    // A truncated file is refused at any length, without a panic.
    for end in (0..good.len()).step_by(7) {
        assert!(open("a.glb", &good[..end]).is_err(), "{end}");
    }
}

#[test]
fn external_buffers_stay_in_the_folder() {
    let file = rich();
    for (uri, words) in [
        ("none.bin", "none.bin"),
        ("../a.bin", "leads out"),
        ("a/%2e%2e/%2E%2E/b", "leads out"),
        ("/etc/hostname", "absolute"),
        ("https://example.com/a.bin", "remote"),
        ("data:application/octet-stream;base64,AAAA", "where"),
        ("data:application/octet-stream;base64,@@@@", "base64"),
    ] {
        refused(open("a.gltf", &file.text_with(uri)), words);
    }
}

#[test]
fn counts_that_no_file_can_mean_are_refused() {
    refused(changed(|root| root["nodes"] = json!(vec![json!({}); 300_000])), "300000 nodes");
    refused(changed(|root| root["materials"] = json!(vec![json!({}); 300_000])), "300000 materials");
    // 200,000 nodes that show one mesh of 30,000 triangles.
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &[0.5; 9]);
    let order = file.shorts("SCALAR", &[0, 1, 2].repeat(30_000));
    file.mesh(json!({ "attributes": { "POSITION": positions }, "indices": order }));
    file.root["nodes"] = json!(vec![json!({ "mesh": 0 }); 200_000]);
    file.root.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    refused(open("a.glb", &file.glb()), "memory");
    // 64 directional lights are allowed, 65 are not.
    let sun = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    let suns = |count: usize| {
        changed(|root| {
            root["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({ "type": "directional" });
            root.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
            (1..count).for_each(|_| root["nodes"].as_array_mut().unwrap().push(sun.clone()));
        })
    };
    assert_eq!(suns(64), Ok(()));
    refused(suns(65), "directional lights");
}
