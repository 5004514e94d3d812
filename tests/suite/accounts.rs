//! Accounts of inputs: all that a command reads is used or left out by name.

use std::path::Path;

use footage::account::Account;
use serde_json::Value;

use crate::commands::fine;

/// Names in an account: of what is used, and of what is left out.
struct Names {
    used: Vec<String>,
    left_out: Vec<String>,
}

impl Names {
    fn of(report: &[u8]) -> Names {
        let report: Value = serde_json::from_slice(report).unwrap();
        let texts = |list: &Value| -> Vec<String> {
            list.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
        };
        let account = &report["account"];
        let used = account["used"].as_array().unwrap().iter().flat_map(|used| texts(&used["names"])).collect();
        Names { used, left_out: texts(&account["left_out"]) }
    }

    /// True if a name is used, or a word or the whole of a sentence has it.
    fn has(&self, name: &str) -> bool {
        let words = self.left_out.iter().flat_map(|sentence| sentence.split(' '));
        let mut patterns = self.used.iter().map(String::as_str).chain(words);
        patterns.any(|pattern| matches(pattern, name)) || self.left_out.iter().any(|sentence| sentence.contains(name))
    }
}

/// True if a name fits a pattern of files, in which probes, faces and times are any text and numbers any digits.
fn matches(pattern: &str, name: &str) -> bool {
    for mark in ["{probe}", "{face}", "{time}"] {
        if let Some(rest) = pattern.strip_prefix(mark) {
            return (0..=name.len()).filter(|at| name.is_char_boundary(*at)).any(|at| matches(rest, &name[at..]));
        }
    }
    if let Some(rest) = pattern.strip_prefix("%%") {
        return name.strip_prefix('%').is_some_and(|name| matches(rest, name));
    }
    if let Some((width, rest)) = pattern.strip_prefix('%').and_then(|pattern| pattern.split_once('d'))
        && width.bytes().all(|byte| byte.is_ascii_digit())
    {
        let digits = name.bytes().take_while(u8::is_ascii_digit).count();
        return (1..=digits).any(|count| matches(rest, &name[count..]));
    }
    match (pattern.chars().next(), name.chars().next()) {
        (None, None) => true,
        (Some(one), Some(other)) => one == other && matches(&pattern[one.len_utf8()..], &name[other.len_utf8()..]),
        _ => false,
    }
}

/// Runs `init` on the folder `in` of a folder. Panics if an image file in it is neither used nor left out by name.
pub fn assert_images_are_named(folder: &Path, options: &str) {
    let names = Names::of(&fine(&format!("init in --force --json -o in/lightfield.json {options}"), folder).stdout);
    let files = walkdir(&folder.join("in"), "");
    let images =
        files.iter().filter(|name| [".exr", ".png", ".jpg", ".tif"].iter().any(|ending| name.ends_with(ending)));
    for name in images {
        assert!(names.has(name), "{name}: used {:?}, left out {:?}", names.used, names.left_out);
    }
}

/// Returns the files below a folder, relative to it, with `/` between folders.
fn walkdir(folder: &Path, place: &str) -> Vec<String> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = format!("{place}{}", entry.file_name().to_str().unwrap());
        match entry.path().is_dir() {
            true => files.extend(walkdir(&entry.path(), &format!("{name}/"))),
            false => files.push(name),
        }
    }
    files
}

/// Panics if an object that is drawn, a material, an animation, or a mesh of a scene file is neither used nor left out by name. Files
/// with names that are not printable are passed over.
pub fn assert_parts_are_named(bytes: &[u8], account: &Account) {
    let used = account.used.iter().flat_map(|used| used.names.iter().cloned()).collect();
    let names = Names { used, left_out: account.left_out.clone() };
    for name in parts_of_gltf(bytes).into_iter().chain(parts_of_obj(bytes)) {
        if name.len() <= 80 && name.chars().all(|c| c.is_alphanumeric() || c == ' ') {
            assert!(names.has(&name), "{name}: {account:?}");
        }
    }
}

fn parts_of_gltf(bytes: &[u8]) -> Vec<String> {
    let is_glb = bytes.starts_with(b"glTF");
    let json =
        if is_glb { &bytes[20..20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize] } else { bytes };
    let Ok(root) = serde_json::from_slice::<Value>(json) else { return Vec::new() };
    let all = |list: &str, word: &str| -> Vec<(String, Value)> {
        let rows = root[list].as_array().into_iter().flatten().enumerate();
        rows.map(|(at, row)| (row["name"].as_str().map_or(format!("{word} {at}"), str::to_owned), row.clone()))
            .collect()
    };
    let is_drawn = |(_, row): &(String, Value)| {
        ["mesh", "camera"].iter().any(|key| !row[key].is_null()) || !row["extensions"]["KHR_lights_punctual"].is_null()
    };
    let nodes = all("nodes", "node").into_iter().filter(is_drawn);
    let others = [("materials", "material"), ("animations", "animation")].map(|(list, word)| all(list, word));
    let parts = nodes.chain(others.into_iter().flatten()).map(|(name, _)| name);
    // A mesh that a node shows is named by the node.
    let shown = |at: usize| root["nodes"].as_array().into_iter().flatten().any(|node| node["mesh"] == at);
    let meshes = all("meshes", "mesh").into_iter().enumerate().filter(|(at, _)| !shown(*at)).map(|(_, (name, _))| name);
    parts.chain(meshes).collect()
}

/// Returns the names of the materials that faces of an OBJ file use.
fn parts_of_obj(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    let names = text.lines().filter_map(|line| line.strip_prefix("usemtl ")).map(str::trim);
    names.filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

#[test]
fn names_match_patterns() {
    for (pattern, name, expected) in [
        ("{probe}/{face}.%04d.exr", "00/px.0012.exr", true),
        ("{probe}.%d.exr", "a.exr", false),
        ("100%%.png", "100%.png", true),
        ("rgb/{time}.png", "rgb/1305031102.17.png", true),
        ("rgb.%d.png", "rgb.1.png.bak", false),
    ] {
        assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
    }
}
