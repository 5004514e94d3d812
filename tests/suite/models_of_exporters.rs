//! Scene files as exporters write them: one animation for each object, instances, hidden nodes, textures of other formats, and
//! materials of OBJ files that are neither mirrors nor glass.

use glam::DVec3;
use image::{ImageBuffer, Rgba};
use scene::{MeshMaterial, Model, Optics, Play};
use serde_json::{Value, json};

use crate::model_files::{Gltf, TRIANGLE, png};
use crate::models::{first, on_node, open, open_beside};

/// Returns the first corner of each triangle, sorted.
fn corners(model: &Model, time_s: f64) -> Vec<[f64; 3]> {
    let scene = model.at(time_s);
    let of_mesh = |mesh: &scene::mesh::Mesh| -> Vec<[f64; 3]> {
        mesh.triangles.iter().map(|triangle| mesh.positions[triangle[0] as usize].to_array()).collect()
    };
    let mut all: Vec<[f64; 3]> = scene.meshes.iter().flat_map(|mesh| of_mesh(&mesh.mesh)).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

/// Two nodes, each moved along X by an animation of its own, and a third animation that moves the first node again.
fn of_objects() -> Gltf {
    let mut file = Gltf::new();
    let mesh = file.triangle();
    let nodes = [0, 1].map(|_| file.root_node(json!({ "mesh": mesh })));
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    for (node, x) in [(nodes[0], 2.0), (nodes[1], 6.0), (nodes[0], 9.0)] {
        let output = file.floats("VEC3", &[0.0, 0.0, 0.0, x, 0.0, 0.0]);
        file.animate(node, "translation", json!({ "input": times, "output": output }));
    }
    for (at, name) in ["one", "two", "again"].into_iter().enumerate() {
        file.root["animations"][at]["name"] = json!(name);
    }
    file
}

#[test]
fn animations_of_different_objects_play_together() {
    let file = of_objects();
    let (model, notes) = open(&file);
    assert!(notes.len() == 1 && notes[0].contains("“again”") && notes[0].contains("left out"), "{notes:?}");
    assert_eq!(corners(&model, 1.0), [[2.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    assert_eq!(model.animations, ["one", "two", "again"]);
    let named = |name: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        std::fs::write(&path, file.glb()).unwrap();
        Model::open(&path, Play::of(Some(name)))
            .map(|(model, _)| corners(&model, 1.0))
            .map_err(|error| error.to_string())
    };
    assert_eq!(named("two").unwrap(), [[0.0; 3], [6.0, 0.0, 0.0]]);
    assert_eq!(named("again").unwrap(), [[0.0; 3], [9.0, 0.0, 0.0]]);
    assert_eq!(named("all").unwrap(), [[2.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    assert!(named("three").unwrap_err().contains("one, two, again"));
    // Translation and scale of one node do not overlap.
    let mut file = on_node(&json!({}));
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let output = file.floats("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    file.animate(0, "translation", json!({ "input": times, "output": output }));
    let output = file.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    file.animate(0, "scale", json!({ "input": times, "output": output }));
    let (model, notes) = open(&file);
    let far = model.at(1.0).meshes[0].mesh.positions[1];
    assert!(notes.is_empty() && (far - DVec3::new(6.0, 0.0, 0.0)).length() < 1e-6, "{far} {notes:?}");
}

#[test]
fn instances_and_hidden_nodes() {
    let mut file = on_node(&json!({ "translation": [0.0, 0.0, 1.0] }));
    let places = file.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 7.0, 0.0]);
    let scales = file.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0]);
    let attributes = json!({ "TRANSLATION": places, "SCALE": scales });
    file.root["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    file.push("extensionsRequired", json!("EXT_mesh_gpu_instancing"));
    let (model, notes) = open(&file);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(corners(&model, 0.0), [[0.0, 0.0, 1.0], [0.0, 7.0, 1.0], [5.0, 0.0, 1.0]]);
    let short = file.floats("VEC3", &[0.0; 3]);
    file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(short);
    let said = open_beside("a.glb", &file.glb(), &[]).unwrap_err().to_string();
    assert!(said.contains("node 0") && said.contains("different lengths"), "{said}");

    let mut file = on_node(&json!({}));
    let child = file.push("nodes", json!({ "mesh": 0, "translation": [3.0, 0.0, 0.0] }));
    let hidden = json!({ "KHR_node_visibility": { "visible": false } });
    file.root_node(json!({ "children": [child], "extensions": hidden }));
    let (model, notes) = open(&file);
    assert_eq!(corners(&model, 0.0), [[0.0; 3]]);
    assert_eq!(notes, ["node 1 is hidden, or not in the scene that is shown"]);
    file.root["nodes"][2]["extensions"]["KHR_node_visibility"]["visible"] = json!(true);
    assert_eq!(corners(&open(&file).0, 0.0), [[0.0; 3], [3.0, 0.0, 0.0]]);
}

/// Returns the material and the notes of a file whose only texture is `texture`, with an image of these bytes.
fn textured(texture: &Value, image: &[u8], used: &[&str]) -> (MeshMaterial, Vec<String>) {
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &TRIANGLE);
    let uvs = file.floats("VEC2", &[0.0; 6]);
    let view = file.view(image);
    file.push("images", json!({ "bufferView": view }));
    file.push("textures", texture.clone());
    file.push(
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }),
    );
    for name in used {
        file.push("extensionsUsed", json!(name));
    }
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
    let mesh = file.mesh(json!({ "attributes": attributes, "material": 0 }));
    file.root_node(json!({ "mesh": mesh }));
    let (model, notes) = open(&file);
    let mesh = first(&model);
    (mesh.materials[mesh.material_of[0] as usize].clone(), notes)
}

#[test]
fn a_texture_that_cannot_be_read_costs_one_texture() {
    let mut webp = Vec::new();
    let picture = ImageBuffer::from_pixel(2, 2, Rgba([255u8, 0, 0, 255]));
    picture.write_to(&mut std::io::Cursor::new(&mut webp), image::ImageFormat::WebP).unwrap();
    let of_webp = json!({ "extensions": { "EXT_texture_webp": { "source": 0 } } });
    let (painted, notes) = textured(&of_webp, &webp, &["EXT_texture_webp"]);
    let pixel = painted.plain.base_texture.unwrap().pixels[0];
    assert!(notes.is_empty() && pixel == [255, 0, 0, 255], "{notes:?} {pixel:?}");
    // An image in PNG beside the extension is read, too.
    let both = json!({ "source": 0, "extensions": { "EXT_texture_webp": { "source": 7 } } });
    assert!(textured(&both, &png(1, 1, &[[9, 9, 9, 255]]), &[]).0.plain.base_texture.is_some());
    for (texture, image) in [
        (json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } }), &b"\xabKTX 20\xbb"[..]),
        (json!({}), b"none"),
        (json!({ "source": 0 }), b"none"),
    ] {
        let (painted, notes) = textured(&texture, image, &["KHR_texture_basisu"]);
        assert!(painted.plain.base_texture.is_none() && notes.len() == 1, "{notes:?}");
        assert!(notes[0].contains("0 is ignored"), "{notes:?}");
    }
}

#[test]
fn extensions_that_are_ignored_are_named() {
    let mut file = on_node(&json!({}));
    for name in ["KHR_materials_clearcoat", "KHR_materials_ior", "VENDOR_x"] {
        file.push("extensionsUsed", json!(name));
    }
    let (_, notes) = open(&file);
    assert_eq!(
        notes,
        ["the extension KHR_materials_clearcoat is ignored", "the extension VENDOR_x is ignored"].map(str::to_owned)
    );
}

/// Returns the material of an OBJ file with this material file, and the texture coordinates of its corners.
fn obj_material(mtl: &str) -> (MeshMaterial, Vec<[f32; 2]>, Vec<String>) {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    let picture = png(2, 1, &[[255, 255, 255, 255], [0, 0, 0, 255]]);
    let mtl = format!("newmtl a\n{mtl}\n");
    let others: [(&str, &[u8]); 2] = [("a.mtl", mtl.as_bytes()), ("p.png", &picture)];
    let (model, notes) = open_beside("a.obj", obj.as_bytes(), &others).unwrap();
    let mesh = first(&model);
    let uvs = mesh.triangles[0].iter().map(|&at| mesh.uvs[at as usize].to_array()).collect();
    (mesh.materials[mesh.material_of[0] as usize].clone(), uvs, notes)
}

#[test]
fn illumination_models_of_exporters_are_neither_mirrors_nor_glass() {
    let optics = |mtl: &str| obj_material(mtl).0.optics;
    let kd = "Kd 0.8 0.1 0.1\n";
    // A metallic material of Blender: a rough red metal.
    let metal = obj_material(&format!("{kd}Ks 0.5 0.5 0.5\nNs 250\nNi 1.5\nd 1\nillum 3\nPm 1\nPr 0.5")).0;
    assert_eq!(metal.optics, Optics::Opaque);
    assert!((metal.phong.weight.x - 0.8).abs() < 1e-6 && (metal.phong.weight.y - 0.1).abs() < 1e-6, "{metal:?}");
    assert_eq!(metal.plain.base_color, DVec3::ZERO);
    let plastic = obj_material(&format!("{kd}Pr 0.5\nillum 2")).0;
    assert!((plastic.plain.base_color.x - 0.8).abs() < 1e-6 && plastic.phong.weight.x < 0.05, "{plastic:?}");
    let polished = optics(&format!("{kd}Pm 1\nPr 0\nillum 3"));
    assert!(matches!(polished, Optics::Mirror { tint } if (tint.x - 0.8).abs() < 1e-6), "{polished:?}");
    for opaque in ["Ni 1.0\nd 1\nillum 4", "Ni 1.45\nd 0.9\nillum 9", "Tr 0.1\nillum 6", "Ks 0.5 0.5 0.5\nillum 3"] {
        let (painted, ..) = obj_material(&format!("{kd}{opaque}"));
        assert_eq!(painted.optics, Optics::Opaque, "{opaque}");
        assert!((painted.plain.base_color.x - 0.8).abs() < 1e-6, "{opaque}");
    }
    for glass in ["Ni 1.5\nd 0.1\nillum 7", "Ni 1.5\nillum 4", "Tr 0.9\nillum 9"] {
        assert!(matches!(optics(&format!("{kd}{glass}")), Optics::Glass { .. }), "{glass}");
    }
    for mirror in ["Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3", "Ks 0.9 0.9 0.9\nillum 5", "illum 3"] {
        assert!(matches!(optics(mirror), Optics::Mirror { .. }), "{mirror}");
    }
}

#[test]
fn maps_are_scaled_and_moved() {
    // v points down in a mesh.
    let uvs = |map: &str| obj_material(&format!("map_Kd {map} p.png")).1;
    assert_eq!(uvs(""), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(uvs("-o 0.5 0.5 -s 0.5 0.5"), [[0.5, 0.5], [1.0, 0.5], [0.5, 0.0]]);
    assert_eq!(uvs("-s 4 2 1"), [[0.0, 1.0], [4.0, 1.0], [0.0, -1.0]]);
    assert_eq!(uvs("-o 0.25"), [[0.25, 1.0], [1.25, 1.0], [0.25, 0.0]]);
    let (_, _, notes) = obj_material("map_Kd -s 2 2 p.png\nmap_Ke p.png");
    assert!(notes.len() == 1 && notes[0].contains("-o or -s"), "{notes:?}");
}

#[test]
fn material_files_are_listed_and_tr_of_meshlab_is_opaque() {
    let obj = "mtllib gone.mtl b.mtl\\ x a\\ b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl \nf 1 2 3\n";
    let mtl = "newmtl a\nKd 0.2 0.4 0.6\nTr 1.000000\n";
    let (model, notes) = open_beside("a.obj", obj.as_bytes(), &[("a b.mtl", mtl.as_bytes())]).unwrap();
    let mesh = first(&model);
    assert_eq!(mesh.triangles.len(), 2);
    let material = &mesh.materials[mesh.material_of[0] as usize];
    assert!((material.plain.base_color.y - 0.4).abs() < 1e-6, "{material:?}");
    let named = |name: &str| notes.iter().any(|note| note.contains(name));
    assert!(named("gone.mtl") && named("b.mtl x") && !named("alpha"), "{notes:?}");
    // A space in a name of its own.
    let obj = obj.replace("gone.mtl b.mtl\\ x a\\ b.mtl", "a b.mtl");
    let (model, notes) = open_beside("a.obj", obj.as_bytes(), &[("a b.mtl", mtl.as_bytes())]).unwrap();
    assert!(notes.is_empty() && first(&model).materials.len() == 2, "{notes:?}");
}
