//! formats/schemas/manifest.json accepts every manifest that the parser accepts, and defines every key.

use std::collections::{BTreeMap, BTreeSet};

use codec::image::{Eye, StereoLayout};
use codec::streams::StartView;
use footage::dataset::manifest::{
    AlphaInfo, Background, ColorInfo, DepthInfo, FaceFiles, FileDepth, Files, Keep, MaterialChannels, MaterialInfo,
    Pose, Probe, Unit,
};
use footage::dataset::{Manifest, Missing, Projection};
use footage::image_files::ColorSpace;
use jsonschema::Validator;
use serde_json::{Value, json};

use crate::commands::fine;
use crate::repository_rules::{blocks, read, root};

const SCHEMA: &str = "formats/schemas/manifest.json";

fn schema() -> Value {
    serde_json::from_str(&read(SCHEMA)).unwrap()
}

fn validator() -> Validator {
    let schema = schema();
    jsonschema::draft202012::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

/// Returns a valid manifest of a cube map.
fn cube() -> Value {
    json!({ "lightfield": 1, "name": "t", "fps": 24, "frames": [0, 1], "projection": "cubemap", "size": [4, 4],
        "depth": { "kind": "distance", "unit": "m", "background": "inf", "near": 0.5, "far": 9 },
        "files": { "depth": "{probe}/{face}.%04d.exr" }, "probes": [{ "name": "a", "position": [0, 0, 0] }] })
}

/// Returns a valid manifest of a perspective camera.
fn view() -> Value {
    json!({ "lightfield": 1, "name": "t", "fps": 24, "frames": [0, 1], "projection": "perspective", "size": [4, 3],
        "files": { "color": "{probe}.%04d.exr" }, "probes": [{ "name": "a", "position": [0, 0, 0], "fov_y_deg": 60 }] })
}

/// Returns the manifest with another value at a JSON pointer such as `/depth/kind`; null removes the key.
fn with(mut manifest: Value, place: &str, value: Value) -> Value {
    let (parent, key) = place.rsplit_once('/').unwrap();
    let parent = manifest.pointer_mut(parent).unwrap_or_else(|| panic!("{place}")).as_object_mut().unwrap();
    match value {
        Value::Null => drop(parent.remove(key)),
        value => drop(parent.insert(key.to_owned(), value)),
    }
    manifest
}

fn poses(frames: &[u32]) -> Value {
    frames.iter().map(|frame| json!({ "frame": frame, "position": [frame, 0, 0] })).collect()
}

fn parses(manifest: &Value) -> lightfold::Result<Manifest> {
    Manifest::from_json(manifest.to_string().as_bytes())
}

#[test]
fn the_command_prints_it() {
    let printed = fine("schema manifest", root()).stdout;
    assert_eq!(String::from_utf8(printed).unwrap(), read(SCHEMA));
}

#[test]
fn what_the_parser_accepts_is_accepted() {
    let validator = validator();
    let moving = |poses: Value| with(with(view(), "/probes/0/position", Value::Null), "/probes/0/poses", poses);
    let stereo = |eye: &str| with(with(view(), "/stereo", json!("side-by-side")), "/probes/0/eye", json!(eye));
    let mut valid =
        vec![cube(), view(), moving(poses(&[0, 1])), moving(poses(&[1, 0, 7])), stereo("left"), stereo("right")];
    for text in ["formats/manifest.md", "README.md"] {
        valid.extend(blocks(&read(text), "json").iter().map(|block| serde_json::from_str::<Value>(block).unwrap()));
    }
    assert!(valid.len() > 9);
    for (place, values) in [
        ("/fps", vec![json!(23.976), json!("24"), json!("24000/1001"), json!("30000 / 1001")]),
        ("/faces", vec![json!("opengl-cube")]),
        ("/faces_present", vec![json!(["px"]), json!(["nz", "px"])]),
        ("/face_names", vec![json!({}), json!({ "px": "right side", "nx": "left/b" })]),
        ("/extra", vec![json!([1]), json!({ "a": {} })]),
        ("/$schema", vec![json!("x")]),
        ("/depth", vec![Value::Null, json!({})]),
        ("/depth/scale", vec![json!(0.001), json!(-1)]),
        ("/depth/unit", vec![json!("m"), json!("cm"), json!("mm")]),
        ("/depth/background", vec![json!(0), json!(-1.5), json!(1e30), json!("inf")]),
        ("/depth/kind", vec![json!("planar")]),
        ("/depth/channel", vec![json!("Pz"), json!("{probe}")]),
        ("/missing", ["error", "hold", "skip", "black"].map(Value::from).to_vec()),
        ("/color", ColorSpace::ALL.map(|space| json!({ "space": space.name() })).to_vec()),
        ("/color", vec![json!({}), json!({ "space": "srgb" }), json!({ "layer": "a", "space": "linear-rec709" })]),
        ("/material", vec![json!({ "channels": { "reflection": "a", "refraction": "b", "ior": "c" } })]),
        ("/files/normal", vec![json!("{face}n.####.exr")]),
        (
            "/files/depth",
            ["{face}.$F4.exr", "{face}.<f>.exr", "{face}${F}.exr", "{face}@@.exr", "a%%{face}#.exr"]
                .map(Value::from)
                .to_vec(),
        ),
        ("/probes/0/frames", vec![json!([0, 0]), json!([5, 9])]),
        ("/probes/0/orientation", vec![json!([0, 0.6, 0, 0.8])]),
        ("/probes/0/size", vec![json!([1, 1]), json!([65_536, 65_536])]),
        ("/probes/0/extra", vec![json!(7)]),
        ("/probes/0/poses", vec![json!([])]),
    ] {
        valid.extend(values.into_iter().map(|value| with(cube(), place, value)));
    }
    for intrinsics in [json!([2, 3, 1.5, 1]), json!([2, 3, -1, 0])] {
        valid.push(with(with(view(), "/probes/0/fov_y_deg", Value::Null), "/probes/0/intrinsics", intrinsics));
    }
    for manifest in valid {
        parses(&manifest).unwrap_or_else(|error| panic!("{error}: {manifest}"));
        if let Err(error) = validator.validate(&manifest) {
            panic!("{error}: {manifest}");
        }
    }
}

#[test]
fn what_the_schema_refuses_is_refused() {
    let validator = validator();
    let mut invalid = Vec::new();
    for key in ["lightfield", "name", "fps", "frames", "projection", "size", "files", "probes"] {
        invalid.push(with(cube(), &format!("/{key}"), Value::Null));
    }
    for (place, values) in [
        ("/lightfield", vec![json!(2), json!("1")]),
        ("/name", vec![json!(""), json!("a\nb"), json!(7)]),
        ("/fps", vec![json!(0), json!(-24), json!("x"), json!("24/"), json!(true), json!("-24/1")]),
        ("/frames", vec![json!([0]), json!([0, 1, 2]), json!([-1, 1]), json!([0.5, 1]), json!([0, 4_294_967_296u64])]),
        ("/projection", vec![json!("fisheye"), json!("perspective ")]),
        ("/size", vec![json!([4]), json!([0, 0]), json!([65_537, 65_537]), json!("4x4")]),
        ("/faces", vec![json!("opengl")]),
        ("/faces_present", vec![json!([]), json!(["up"]), json!(["px", "px"]), json!("px")]),
        ("/face_names", vec![json!({ "up": "u" }), json!({ "px": "" }), json!({ "px": "a#" }), json!({ "px": 1 })]),
        ("/stereo", vec![json!("over-under"), json!("left")]),
        ("/missing", vec![json!("repeat")]),
        ("/depth/knd", vec![json!(1)]),
        ("/depth/kind", vec![json!("z")]),
        ("/depth/unit", vec![json!("ft")]),
        ("/depth/scale", vec![json!(0), json!("1")]),
        ("/depth/background", vec![json!("far"), json!(1e300), json!(true)]),
        ("/depth/near", vec![json!(0), json!(-1)]),
        ("/depth/channel", vec![json!(7)]),
        ("/color", vec![json!({ "space": "acid" }), json!({ "channel": "a" })]),
        ("/material", vec![json!({}), json!({ "channels": { "reflection": "a" } })]),
        ("/files/depth", vec![json!("{face}.exr"), json!(7)]),
        ("/files", vec![json!({}), json!({ "normal": "{face}.%d.exr" })]),
        ("/probes", vec![json!([]), json!([{}]), json!({})]),
        ("/probes/0/name", vec![json!("../a"), json!(".a"), json!(""), json!("a".repeat(101)), Value::Null]),
        ("/probes/0/position", vec![json!([0, 0]), json!("0"), Value::Null]),
        ("/probes/0/frames", vec![json!([1]), json!([-1, 1])]),
        ("/probes/0/orientation", vec![json!([0, 0, 0, 2]), json!([0, 0, 1])]),
        ("/probes/0/size", vec![json!([4]), json!([0, 0]), json!([65_537, 65_537]), json!(4)]),
        ("/probes/0/eye", vec![json!("left")]),
        ("/probes/0/fov_y_deg", vec![json!(60)]),
        ("/probes/0/intrinsics", vec![json!([1, 1, 1, 1])]),
        ("/probes/0/poses", vec![json!([{}]), json!([{ "frame": 0, "position": [0, 0, 0], "time": 1 }])]),
        ("/colour", vec![json!({})]),
    ] {
        invalid.extend(values.into_iter().map(|value| with(cube(), place, value)));
    }
    for (place, values) in [
        ("/faces", vec![json!("opengl-cube")]),
        ("/faces_present", vec![json!(["px"])]),
        ("/face_names", vec![json!({ "px": "a" })]),
        ("/stereo", vec![json!("side-by-side")]),
        ("/probes/0/fov_y_deg", vec![json!(0), json!(180), json!("60")]),
        ("/probes/0/intrinsics", vec![json!([1, 1, 1, 1])]),
    ] {
        invalid.extend(values.into_iter().map(|value| with(view(), place, value)));
    }
    let turned = with(view(), "/probes/0/orientation", json!([0, 0, 0, 1]));
    invalid.push(with(turned, "/probes/0/poses", poses(&[0, 1])));
    let strip = with(with(cube(), "/faces", json!("opengl-cube-strip")), "/size", json!([24, 4]));
    let strip = with(strip, "/files/depth", json!("z.%d.exr"));
    parses(&strip).unwrap();
    invalid.push(with(strip, "/face_names", json!({ "px": "a" })));
    let panorama = with(
        with(with(cube(), "/projection", json!("equirect")), "/size", json!([8, 4])),
        "/files/depth",
        json!("z.%d.exr"),
    );
    parses(&panorama).unwrap();
    invalid.push(with(panorama, "/depth/kind", json!("planar")));
    for manifest in invalid {
        assert!(!validator.is_valid(&manifest), "{manifest}");
        assert!(parses(&manifest).is_err(), "{manifest}");
    }
}

/// Manifests that the schema accepts and the parser refuses, as listed in formats/manifest.md 2.6.
#[test]
fn what_a_schema_cannot_say_is_left_to_the_parser() {
    let validator = validator();
    let moving =
        |frames: &[u32]| with(with(view(), "/probes/0/position", Value::Null), "/probes/0/poses", poses(frames));
    let twice = json!([{ "name": "a", "position": [0, 0, 0] }, { "name": "a", "position": [0, 0, 0] }]);
    for manifest in [
        with(cube(), "/frames", json!([3, 1])),
        with(cube(), "/depth/near", json!(10)),
        with(cube(), "/size", json!([4, 8])),
        with(cube(), "/probes/0/size", json!([4, 8])),
        with(cube(), "/probes", twice),
        with(cube(), "/probes/0/orientation", json!([0, 0, 0, 0.5])),
        with(cube(), "/face_names", json!({ "px": "nx" })),
        with(cube(), "/files/depth", json!("{face}.%d.%d.exr")),
        with(cube(), "/files/depth", json!("{probe}.%d.exr")),
        moving(&[0]),
        moving(&[0, 1, 1]),
    ] {
        assert!(validator.is_valid(&manifest), "{manifest}");
        assert!(parses(&manifest).is_err(), "{manifest}");
    }
}

/// Returns a manifest with a value in each field of the types.
fn whole() -> Manifest {
    let text = |text: &str| Some(text.to_owned());
    let pose = Pose { frame: 0, position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] };
    Manifest {
        schema: text("s"),
        lightfield: 1,
        name: "t".into(),
        fps: 24.0,
        frames: [0, 1],
        projection: Projection::Cubemap,
        size: [4, 4],
        faces: Some(FaceFiles::Six),
        faces_present: Some(vec!["px".into()]),
        face_names: Some(BTreeMap::from([("px".into(), "right".into())])),
        stereo: Some(StereoLayout::OverUnder),
        depth: Some(DepthInfo {
            kind: FileDepth::Planar,
            channel: text("Z"),
            unit: Some(Unit::Cm),
            scale: Some(1.0),
            background: Background::default(),
            near: Some(1.0),
            far: Some(2.0),
            size: Some([2, 2]),
        }),
        color: Some(ColorInfo { space: Some(ColorSpace::Srgb), layer: text("rgba"), keep: Some(Keep::Hdr) }),
        material: Some(MaterialInfo { channels: MaterialChannels::default() }),
        alpha: Some(AlphaInfo { channel: text("A") }),
        missing: Some(Missing::Hold),
        view: Some(StartView { eye: [0.0, 1.5, 0.0], look_at: [0.0, 1.5, -1.0], fov_y_deg: 50.0 }),
        files: Files { color: text("c"), depth: text("d"), material: text("m"), alpha: text("a"), normal: text("n") },
        probes: vec![Probe {
            name: "a".into(),
            position: Some([0.0; 3]),
            frames: Some([0, 1]),
            size: Some([8, 8]),
            orientation: Some([0.0, 0.0, 0.0, 1.0]),
            poses: vec![pose],
            eye: Some(Eye::Left),
            fov_y_deg: Some(60.0),
            intrinsics: Some([1.0; 4]),
            extra: Some(json!(1)),
        }],
        extra: Some(json!(1)),
    }
}

/// Collects the keys of objects as paths such as `depth.kind`. Keys inside `face_names` are data and are left out.
fn keys_of(value: &Value, place: &str, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) if place != "face_names." => {
            for (key, inner) in map {
                keys.insert(format!("{place}{key}"));
                keys_of(inner, &format!("{place}{key}."), keys);
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| keys_of(inner, place, keys)),
        _ => {}
    }
}

/// Collects the keys that a schema defines, as the same paths.
fn keys_of_schema(whole: &Value, part: &Value, place: &str, keys: &mut BTreeSet<String>) {
    let part = match part.get("$ref").and_then(Value::as_str) {
        Some(name) => whole.pointer(name.trim_start_matches('#')).unwrap(),
        None => part,
    };
    for (key, inner) in part.get("properties").and_then(Value::as_object).into_iter().flatten() {
        keys.insert(format!("{place}{key}"));
        keys_of_schema(whole, inner, &format!("{place}{key}."), keys);
    }
    if let Some(items) = part.get("items") {
        keys_of_schema(whole, items, place, keys);
    }
}

#[test]
fn the_schema_and_the_document_name_the_keys_of_the_types() {
    let (mut of_types, mut of_schema) = (BTreeSet::new(), BTreeSet::new());
    keys_of(&serde_json::to_value(whole()).unwrap(), "", &mut of_types);
    keys_of_schema(&schema(), &schema(), "", &mut of_schema);
    assert_eq!(of_types, of_schema);
    let document = read("formats/manifest.md");
    for key in of_types {
        let last = key.rsplit('.').next().unwrap();
        assert!(
            document.contains(&format!("`{last}`")) || document.contains(&format!("`{key}")),
            "manifest.md lacks {key}"
        );
    }
}
