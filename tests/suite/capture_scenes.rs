//! `capture` with scene files: how scenes are identified, which animation is captured, and errors for files that are not scenes.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use scene::Scene;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::capture::files;
use crate::commands::{fine, refused};
use crate::model_files::{Gltf, OBJ, png};

const RED: [u8; 4] = [200, 0, 0, 255];
const BLUE: [u8; 4] = [0, 0, 200, 255];

/// Returns a triangle with a texture in a separate file.
fn painted() -> Gltf {
    let mut file = Gltf::new();
    let uvs = file.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let mesh = file.triangle();
    file.push("images", json!({ "uri": "paint.png" }));
    file.push("textures", json!({ "source": 0 }));
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    let primitive = &mut file.root["meshes"][mesh]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    file.root_node(json!({ "mesh": mesh }));
    file
}

/// Returns a triangle with two animations: `left` for 1 s, and `up` for 0.5 s.
fn moved() -> Gltf {
    let mut file = Gltf::new();
    let mesh = file.triangle();
    let node = file.root_node(json!({ "mesh": mesh }));
    for (name, end, to) in [("left", 1.0, [-1.0, 0.0, 0.0]), ("up", 0.5, [0.0, 1.0, 0.0])] {
        let input = file.floats("SCALAR", &[0.0, end]);
        file.root["accessors"][input]["max"] = json!([end]);
        file.root["accessors"][input]["min"] = json!([0.0]);
        let output = file.floats("VEC3", &[0.0, 0.0, 0.0, to[0], to[1], to[2]]);
        let number = file.animate(node, "translation", json!({ "input": input, "output": output }));
        file.root["animations"][number]["name"] = json!(name);
    }
    file
}

fn contents(path: &Path) -> String {
    Scene::open(path.to_str().unwrap(), Default::default()).unwrap().0.contents().to_owned()
}

#[test]
fn every_file_of_a_scene_tells_it_apart() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let mut file = painted();
    write("a.glb", &file.glb());
    write("b.gltf", &file.text_with("b.bin"));
    write("b.bin", &file.buffer);
    write("paint.png", &png(1, 1, &[RED]));
    write("c.obj", OBJ.replace("none.mtl", "c.mtl").as_bytes());
    write("c.mtl", b"newmtl red\nKd 1 1 1\nmap_Kd paint.png\n");
    let all = ["a.glb", "b.gltf", "c.obj"];
    let of_all = || all.map(|name| contents(&folder.path().join(name)));
    let first = of_all();
    assert_eq!(of_all(), first);
    // The texture is referenced by all three scenes.
    write("paint.png", &png(1, 1, &[BLUE]));
    let blue = of_all();
    assert!(first.iter().zip(&blue).all(|(first, blue)| first != blue), "{first:?} {blue:?}");
    // A missing texture gives other contents; restoring it gives the first contents again.
    fs::remove_file(folder.path().join("paint.png")).unwrap();
    let none = of_all();
    assert!(none.iter().zip(first.iter().zip(&blue)).all(|(none, (first, blue))| none != first && none != blue));
    write("paint.png", &png(1, 1, &[RED]));
    assert_eq!(of_all(), first);
    // b.bin and c.mtl are each referenced by one scene.
    let last = file.buffer.len() - 1;
    file.buffer[last] ^= 1;
    write("b.bin", &file.buffer);
    write("c.mtl", b"newmtl red\nKd 1 1 0\nmap_Kd paint.png\n");
    let now = of_all();
    assert_eq!(now[0], first[0]);
    assert!(now[1] != first[1] && now[2] != first[2]);
}

#[test]
fn a_capture_does_not_go_on_with_another_texture_beside_its_scene() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.glb"), painted().glb()).unwrap();
    fs::write(at("paint.png"), png(1, 1, &[RED])).unwrap();
    let line = "capture a.glb --position 0.2,0.2,1 --frames 0-4999 --size 16 --samples 1 -q -o cap";
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let mut child = command.args(line.split(' ')).current_dir(folder.path()).stderr(Stdio::null()).spawn().unwrap();
    let (left, start) = (at(".cap.capture.partial"), Instant::now());
    while !left.join("files/probe_00/face_px/depth.0000.exr").exists() {
        assert!(child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(60), "it did not begin");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = files(&left);
    fs::write(at("paint.png"), png(1, 1, &[BLUE])).unwrap();
    let said = refused(&format!("{line} --resume"), folder.path());
    assert!(said.contains("the content of the scene has changed"), "{said}");
    fs::write(at("paint.png"), png(1, 1, &[RED])).unwrap();
    let said = refused(&format!("{line} --resume --animation x"), folder.path());
    assert!(said.contains("no animation “x”"), "{said}");
    // A damaged state file must not cause the loss of images.
    fs::write(left.join(".capture.json"), "").unwrap();
    let said = refused(&format!("{line} --resume"), folder.path());
    assert!(said.contains("its state is damaged"), "{said}");
    assert_eq!(files(&left).len(), before.len());
}

#[test]
fn manifests_keep_colour_above_1() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("paint.png"), png(1, 1, &[[255; 4]])).unwrap();
    for (name, emissive) in [("white.glb", [1.0; 3]), ("grey.glb", [0.0; 3])] {
        let mut file = painted();
        let surface = json!({ "baseColorFactor": [0.2, 0.2, 0.2, 1.0], "metallicFactor": 0.0 });
        file.root["materials"][0] = json!({ "pbrMetallicRoughness": surface, "emissiveFactor": emissive });
        fs::write(folder.path().join(name), file.glb()).unwrap();
    }
    let capture = |scene: &str, to: &str| {
        fine(&format!("capture {scene} --position 0.2,0.2,1 --size 8 --samples 1 -q -o {to}"), folder.path());
        let text = fs::read(folder.path().join(to.split(' ').next().unwrap()).join("lightfield.json")).unwrap();
        serde_json::from_slice::<Value>(&text).unwrap()["color"]["keep"].clone()
    };
    assert_eq!([capture("white.glb", "white"), capture("street", "street")], [json!("hdr"), json!("hdr")]);
    assert_eq!(capture("grey.glb", "grey"), Value::Null);
    for (input, keeps) in [("white", true), ("street", true), ("grey", false)] {
        let said = fine(&format!("encode {input} -o {input}.lfold"), folder.path()).stderr;
        let said = String::from_utf8(said).unwrap();
        assert_eq!(said.contains("colour is kept as half floats, as the manifest says"), keeps, "{input}: {said}");
    }
    // The face that shows the triangle is in one shard alone; in any order, the shards make the files of one run.
    for order in [[1, 2, 3], [3, 2, 1]] {
        for shard in order {
            capture("white.glb", &format!("parts --shard {shard}/3"));
        }
        assert!(files(&folder.path().join("parts")) == files(&folder.path().join("white")), "{order:?}");
        fs::remove_dir_all(folder.path().join("parts")).unwrap();
    }
}

#[test]
fn any_animation_of_a_file_is_captured_by_its_name() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.glb"), moved().glb()).unwrap();
    let line = "capture a.glb --position 0,0,1 --size 8 --samples 1 --fps 4 -q --json";
    let frames = |more: &str| -> Value {
        let done = fine(&format!("{line} {more}"), folder.path());
        serde_json::from_slice::<Value>(&done.stdout).unwrap()["frames"].clone()
    };
    assert_eq!([frames("-o first"), frames("--animation left -o left"), frames("--animation up -o up")], [4, 4, 2]);
    let of = |name: &str| files(&folder.path().join(name));
    assert!(of("first") == of("left") && of("left") != of("up"));
    let said = refused(&format!("{line} --animation down -o out"), folder.path());
    assert!(said.contains("no animation “down”; it has left, up"), "{said}");
    let said = refused("capture courtyard --animation up --position 0,1,0 -o out", folder.path());
    assert!(said.contains("no animation “up”"), "{said}");
    let place = "place a.glb --region=-1,-1,1,1,1,2 --candidates 8 --surface-samples 16 --fps 4 --cameras 1 -q";
    let looked_at = |more: &str| -> Value {
        let done = fine(&format!("{place} -o cameras.json --json{more}"), folder.path());
        serde_json::from_slice::<Value>(&done.stdout).unwrap()["frames_looked_at"].clone()
    };
    assert_eq!([looked_at(""), looked_at(" --animation up")], [json!([0, 1, 2, 3]), json!([0, 1])]);
    assert!(refused(&format!("{place} --animation down -o out"), folder.path()).contains("it has left, up"));
}

#[test]
fn animations_without_an_end_in_sight_are_refused_but_for_frames_that_are_named() {
    let folder = TempDir::new().unwrap();
    let mut file = Gltf::new();
    let mesh = file.triangle();
    let node = file.root_node(json!({ "mesh": mesh }));
    let input = file.floats("SCALAR", &[0.0, 1e7]);
    let output = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    file.animate(node, "translation", json!({ "input": input, "output": output }));
    fs::write(folder.path().join("a.glb"), file.glb()).unwrap();
    let capture = "capture a.glb --position 0.2,0.2,1 --size 8 --samples 1 -q -o cap";
    for line in [capture, "place a.glb --region=-1,-1,1,1,1,2 --cameras 1 -q -o cameras.json"] {
        let said = refused(line, folder.path());
        assert!(said.contains("100000 frames") && said.contains("--frames"), "{said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    fine(&format!("{capture} --frames 7"), folder.path());
}

#[test]
fn folders_hide_no_built_in_scenes_and_what_is_no_scene_is_told_what_would_be() {
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("courtyard")).unwrap();
    let line = "--position 0,1.5,0 --frames 0 --size 8 --samples 1 -q";
    fine(&format!("capture courtyard {line} -o courtyard"), folder.path());
    for (scene, says) in [("castle", "castle: no such file"), (".", ".: a folder")] {
        let said = refused(&format!("capture {scene} {line} -o out"), folder.path());
        assert!(said.contains(says) && said.contains(".glb, .gltf, .obj"), "{said}");
        assert!(said.contains("courtyard, interior, object, mirrors, cornell, fence, street"), "{said}");
    }
    // A file does hide a built-in scene.
    fs::write(folder.path().join("cornell"), "no scene").unwrap();
    assert!(refused(&format!("capture cornell {line} -o out"), folder.path()).contains("neither glTF"));
    assert!(refused(&format!("capture courtyard {line} -o -"), folder.path()).contains("specify a folder"));
}

#[test]
fn a_scene_is_told_by_inspect() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut file = moved();
    file.push("animations", json!({ "name": "nod\u{1b}[0m", "channels": [], "samplers": [] }));
    fs::write(at("a.glb"), file.glb()).unwrap();
    fs::write(at("b.gltf"), painted().text()).unwrap();
    fs::write(at("paint.png"), png(1, 1, &[RED])).unwrap();
    let told = |scene: &str| -> Value {
        serde_json::from_slice(&fine(&format!("inspect {scene} --json"), folder.path()).stdout).unwrap()
    };
    let moved = told("a.glb");
    assert_eq!(moved["bounds_m"], json!({ "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0] }));
    let [left, up, nod] = [0, 1, 2].map(|at| moved["animations"][at].clone());
    assert_eq!(left, json!({ "name": "left", "duration_s": 1.0 }));
    assert_eq!(up, json!({ "name": "up", "duration_s": 0.5 }));
    assert_eq!(nod["name"], "nod?[0m");
    let counts =
        |told: &Value| ["triangles", "objects", "materials", "textures", "suns", "lamps"].map(|key| told[key].clone());
    assert_eq!((counts(&moved), &moved["is_lit_by_default"]), ([1, 0, 1, 0, 0, 0].map(Value::from), &true.into()));
    let painted = told("b.gltf");
    assert_eq!((counts(&painted), &painted["animations"]), ([1, 0, 1, 1, 0, 0].map(Value::from), &json!([])));
    let courtyard = told("courtyard");
    assert!(
        courtyard["objects"].as_u64().unwrap() > 5 && courtyard["animations"][0]["duration_s"] == 4.0,
        "{courtyard}"
    );
    let text = String::from_utf8(fine("inspect a.glb", folder.path()).stdout).unwrap();
    assert!(text.contains("0.000, 0.000, 0.000 to 1.000, 1.000, 0.000, 1.000 x 1.000 x 0.000 m"), "{text}");
    assert!(text.contains("No lights: capture adds a sun and a sky"), "{text}");
    assert!(text.lines().any(|line| line.starts_with("left ") && line.ends_with(" 1.000")), "{text}");
    assert!(refused("inspect a.glb --verify", folder.path()).contains("as a table"));
    // For a dataset, the error names the option to add.
    fine("capture b.gltf --position 0,0,1 --size 8 --samples 1 -q -o cap", folder.path());
    for name in ["cap", "cap/lightfield.json"] {
        assert!(refused(&format!("inspect {name}"), folder.path()).contains("--check"), "{name}");
    }
}

#[test]
fn a_picture_is_taken_towards_a_point() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.obj"), OBJ).unwrap();
    let line = "capture a.obj --size 8 --samples 1 --projection perspective --frames 0";
    let views = r#"{"cameras": [{"eye": [3, 1, 2], "look_at": [0.5, 0.5, 0], "fov_y_deg": 40}]}"#;
    fs::write(folder.path().join("views.json"), views).unwrap();
    fine(&format!("{line} --cameras views.json -o a"), folder.path());
    let there = "--position 3,1,2 --look-at 0.5,0.5,0";
    fine(&format!("{} {there} --fov 40 -o b", line.replace(" --projection perspective", "")), folder.path());
    let of = |name: &str| files(&folder.path().join(name).join("probe_00"));
    assert!(of("a") == of("b"));
    for (more, says) in [(there, "--fov"), ("--position 3,1,2 --look-at 3,1,2 --fov 40", "move one of them")] {
        let said = refused(&format!("{line} {more} -o out"), folder.path());
        assert!(said.contains(says), "{said}");
    }
}

#[test]
fn what_may_surprise_is_noted() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.glb"), moved().glb()).unwrap();
    fs::write(folder.path().join("b.obj"), OBJ).unwrap();
    let said = |line: &str| {
        let done = fine(&format!("capture {line} --size 8 --samples 1 -o cap"), folder.path());
        fs::remove_dir_all(folder.path().join("cap")).unwrap();
        String::from_utf8(done.stderr).unwrap()
    };
    let moving = said("a.glb --position 0,0,1 --fps 4 --frames 2-5");
    assert!(moving.contains("frames 0-3; after the last frame its last pose is held"), "{moving}");
    assert!(moving.contains("has no lights"), "{moving}");
    let still = said("b.obj --position 0,0,1 --frames 0-1 --aov depth,normal");
    assert!(still.contains("all frames are equal") && still.contains("containers do not store them"), "{still}");
    let plain = said("courtyard --position 0,1.5,0 --frames 3");
    assert!(!plain.contains("animation") && !plain.contains("light:") && !plain.contains("alike"), "{plain}");
    let beyond = said("courtyard --position 0,1.5,0 --frames 96");
    assert!(beyond.contains("0-95; after the last frame it repeats"), "{beyond}");
}
