//! Reports of commands validate against their schemas in formats/schemas/.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// Command lines with the names of their reports' schemas, in an order in which each finds its input files.
const REPORTS: &[(&str, &str)] = &[
    ("demo", "demo -o demo --frame-count 2 --size 16 --json"),
    ("place", "place courtyard --region=-0.5,1,-0.5,0.5,2,0.5 --cameras 2 --effort fast --json -o cams.json"),
    (
        "place",
        "place courtyard --region=-0.5,1,-0.5,0.5,2,0.5 --cameras 2 --effort fast --lighting specular --compare-k 1 --csv p.csv --json \
         -o cams.json",
    ),
    (
        "capture",
        "capture interior --position=-0.3,1.5,0 --position=0.3,1.5,0 --size 24 --frames 0-2 --aov depth,material -o room --json",
    ),
    ("encode", "encode room -o room.lfold --clip --json"),
    ("encode", "encode room -o exact.lfold --clip --max-error 0 --depth-codec quadtree --color-codec cells --json"),
    ("encode", "encode-color room/probe_00/face_px/color.%04d.exr -o c.lfold --clip --json"),
    ("encode", "encode-depth room/probe_00/face_px/depth.%04d.exr -o d.lfold --json"),
    ("encode", "quadtree room/probe_00/face_px/depth.%04d.exr --effort fast -o q.lfold --json"),
    ("encode", "bc4w room/probe_00/face_px/depth.%04d.exr -o b.lfold --json"),
    ("bc4w", "bc4w room/probe_00/face_px/depth.%04d.exr --stats --json"),
    ("bc4w", "bc4w room/probe_00/face_px/depth.%04d.exr --stats -o b.lfold --json"),
    ("pack", "pack room.lfold -o p.lfold --lzma2 --json"),
    ("train-color", "train-color room.lfold -o t.txt --held-out c.lfold --json"),
    ("train-depth", "train-depth room.lfold -o t.txt --json"),
    ("scan", "scan room -o scan.json --json"),
    ("inspect", "inspect room.lfold --json"),
    ("inspect", "inspect exact.lfold --json --per-frame --verify"),
    ("inspect", "inspect b.lfold --json --streams"),
    ("inspect-scene", "inspect interior --json"),
    ("init", "init room -o room/other.json --json"),
    ("cameras", "cameras room -o room.usda --json"),
    ("inspect-check", "inspect room --check --json"),
    ("decode", "decode room.lfold -o decoded --json"),
    ("decode", "decode room.lfold --null --repeat 2 --json"),
    ("decode", "decode room.lfold --null --keep-going --json"),
    ("decode", "decode room.lfold --eye 0,1.5,0 --look-at 2,1.5,0 --fov 90 --null --stats --json"),
    ("diff", "diff room decoded --json"),
    ("diff", "diff room exact.lfold --json --streams --max-error 0 --ssim every --ssimulacra2"),
    ("diff", "diff decoded decoded --exact --json"),
    ("render", "render room.lfold --eye 0,1.5,0.1 --look-at 2,1.3,0 --size 16 --null --json"),
    ("render", "render room.lfold --reference room --reference-probe 00 --null --stats --json"),
    ("simplify", "simplify room --triangles 500 --effort fast -o room.glb --held-out room --json"),
    ("render", "render room.glb --eye 0,1.5,0.1 --look-at 2,1.3,0 --size 16 --null --json"),
    (
        "interpolate",
        "interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 4 --baseline 0.3 --size 16 --null --json",
    ),
    (
        "interpolate",
        "interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 4 --baseline 0.3 --size 16 -o v/%04d.png --compare --json",
    ),
    ("quilt", "quilt v/%04d.png -o q.png --json"),
    ("view", "view room.lfold --export site --json"),
    ("view", "view room.glb --export site --json"),
    ("view", "view q_qs2x2a1.png --export site --json"),
    ("tradeoff-knobs", "tradeoff --list-knobs --json"),
    ("tradeoff", "tradeoff room --sweep depth-window=1,2 --repeats 1 -o t1 --json"),
    (
        "tradeoff",
        "tradeoff courtyard --sweep k=1,2 --repeats 1 -o t2 --json -- --region=-0.5,1,-0.5,0.5,2,0.5 --cameras 2 --effort fast",
    ),
    ("tradeoff-recommend", "tradeoff -o t1 --recommend --max-error 500 --json"),
    ("selftest", "selftest --hard-cases --family geometry --json"),
    ("devices", "decode --list-devices --json"),
    ("error", "decode missing.lfold --null --json"),
    ("error", "decode room.lfold --json --frames 9-3 --null"),
    ("error", "pack room.lfold -o - --json"),
];

/// Schemas that do not describe a report, or whose input is not available everywhere.
const OTHERS: &[&str] = &["inspect-seurat", "manifest"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/schemas")
}

pub fn schema(name: &str) -> Value {
    let path = folder().join(format!("{name}.json"));
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub fn faults(schema: &Value, report: &Value) -> Vec<String> {
    let validator = jsonschema::validator_for(schema).unwrap_or_else(|error| panic!("{}: {error}", schema["title"]));
    validator.iter_errors(report).map(|error| error.to_string()).collect()
}

/// Returns the keys of a report that its schema does not have; words of infinite numbers need none.
fn undescribed(root: &Value, schema: &Value, report: &Value) -> Vec<String> {
    let schema = schema["$ref"].as_str().map_or(schema, |path| root.pointer(&path[1..]).unwrap());
    let choices = ["anyOf", "oneOf", "allOf"].iter().filter_map(|key| schema[key].as_array()).flatten();
    let branches: Vec<&Value> = [schema].into_iter().chain(choices).collect();
    match report {
        Value::Object(fields) => {
            let keys = fields.iter().flat_map(|(key, value)| {
                let inner = branches.iter().find_map(|branch| {
                    let named = [&branch["properties"][key.as_str()], &branch["additionalProperties"]];
                    named.into_iter().find(|inner| inner.is_object())
                });
                match inner {
                    Some(inner) => {
                        let within = undescribed(root, inner, value);
                        within.into_iter().map(|rest| format!("{key}.{rest}")).collect()
                    }
                    None if key.ends_with("_is") => vec![],
                    None => vec![key.clone()],
                }
            });
            keys.collect()
        }
        Value::Array(items) => {
            let inner = || branches.iter().map(|branch| &branch["items"]).filter(|inner| inner.is_object());
            items.iter().flat_map(|item| inner().flat_map(|inner| undescribed(root, inner, item))).collect()
        }
        _ => vec![],
    }
}

#[test]
fn reports_are_as_their_schemas_say() {
    let place = TempDir::new().unwrap();
    for (name, line) in REPORTS {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        let output = command.args(line.split_whitespace()).current_dir(place.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let report: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{line}: {error}\n{said}"));
        let schema = schema(name);
        assert_eq!(faults(&schema, &report), [""; 0], "{line}\n{report:#}");
        assert_eq!(undescribed(&schema, &schema, &report), [""; 0], "{name} does not describe all keys of {line}");
        assert_eq!(*name == "error", report.get("error").is_some(), "{line}\n{said}");
        // Each key in `required` is needed: a schema that requires nothing would accept anything.
        let required = schema["required"].as_array().unwrap_or_else(|| panic!("{name} requires no key"));
        for key in required.iter().map(|key| key.as_str().unwrap()) {
            let mut without = report.clone();
            without.as_object_mut().unwrap().remove(key);
            assert!(!faults(&schema, &without).is_empty(), "{name} does not require {key}");
        }
    }
}

#[test]
fn every_schema_is_one_of_a_report() {
    let files = fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let files: BTreeSet<String> = files.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    let known: BTreeSet<&str> = REPORTS.iter().map(|(name, _)| *name).chain(OTHERS.iter().copied()).collect();
    for name in &files {
        assert!(known.contains(name.as_str()), "{name} is the schema of no report");
        assert!(jsonschema::meta::is_valid(&schema(name)), "{name} is no JSON Schema");
    }
}

#[cfg(seurat_at_hand)]
#[test]
fn a_seurat_manifest_is_reported_as_its_schema_says() {
    let manifest = Path::new(env!("LIGHTFOLD_DATA")).join("seurat/manifest_v3.json");
    let output =
        Command::new(env!("CARGO_BIN_EXE_lightfold")).arg("inspect").arg(manifest).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(faults(&schema("inspect-seurat"), &report), [""; 0], "{report:#}");
}
