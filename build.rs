//! Sets `cfg` flags for the measured footage, the Seurat data and ffmpeg, so that tests that need them are reported as ignored if
//! they are missing; passes a hash of the encoder's sources to the crate; generates Rust from the kernel table; lists the files
//! of the player; and links the C++ library that the block encoder needs.

#![allow(clippy::disallowed_methods)]

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

#[cfg(feature = "gpu")]
use serde_json::Value;

/// Files that determine an encoder's output: two builds with the same contents of these write the same bytes.
const SOURCES: [&str; 4] = ["Cargo.lock", "src", "formats/color-tables.txt", "formats/depth-tables.txt"];

/// Returns the files below a path, or the path itself if it is a file. Links are not followed.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_symlink() {
        return Vec::new();
    }
    let Ok(entries) = fs::read_dir(path) else { return vec![path.to_path_buf()] };
    entries.flatten().flat_map(|entry| files(&entry.path())).collect()
}

/// Hashes names and contents of the sources. Unreadable files are skipped, like missing ones.
fn hash_of_sources(root: &Path) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut files: Vec<PathBuf> = SOURCES.iter().flat_map(|name| files(&root.join(name))).collect();
    files.sort();
    for path in files {
        let Ok(bytes) = fs::read(&path) else { continue };
        for part in [path.strip_prefix(root).unwrap_or(&path).as_os_str().as_encoded_bytes(), &bytes] {
            hasher.write_usize(part.len());
            hasher.write(part);
        }
    }
    hasher.finish()
}

#[cfg(feature = "gpu")]
fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not a string"))
}

#[cfg(feature = "gpu")]
fn rows(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not an array"))
}

/// Splits a struct member or binding, written `name: type`, into name and type.
#[cfg(feature = "gpu")]
fn name_and_type(value: &Value) -> (&str, &str) {
    text(value).split_once(": ").unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not 'name: type'"))
}

/// Returns the structs and constants of the kernel table as input of the macros of `gpu/layout.rs`.
#[cfg(feature = "gpu")]
fn layout_source(table: &Value) -> String {
    let member = |value| {
        let (name, kind) = name_and_type(value);
        let kind = match kind {
            "vec2<f32>" => "[f32; 2]",
            "vec3<f32>" => "[f32; 3]",
            "array<u32, 8>" => "[u32; 8]",
            scalar => scalar,
        };
        format!("{name}: {kind}")
    };
    let mut out = String::from("structs! {\n");
    for row in rows(&table["structs"]) {
        let members: Vec<String> = rows(&row["members"]).iter().map(member).collect();
        out += &format!("{} {{ {} }}\n", text(&row["name"]), members.join(", "));
    }
    out += "}\nconstants! {\n";
    for (name, value) in table["constants"].as_object().into_iter().flatten() {
        out += &format!("{name} = {value};\n");
    }
    out + "}\n"
}

/// Returns the files of a row as elements of a list of `ShaderFile`.
#[cfg(feature = "gpu")]
fn file_source(row: &Value) -> String {
    let file = |path: &str| {
        let include = format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/shaders/{path}\"))");
        format!("ShaderFile {{ path: {path:?}, text: {include} }}, ")
    };
    rows(&row["files"]).iter().map(text).map(file).collect()
}

/// Returns the bindings of a row as elements of a list of `Binding`.
#[cfg(feature = "gpu")]
fn binding_source(row: &Value) -> String {
    let binding = |(name, kind): (&str, &str)| {
        let kind = match kind {
            "read-only-storage" => "ReadOnlyStorage",
            "storage" => "Storage",
            "uint" => "Uint",
            "unfilterable-float" => "UnfilterableFloat",
            other => panic!("shaders/kernels.json: {other} is no kind of binding"),
        };
        format!("Binding {{ name: {name:?}, kind: BindingKind::{kind} }}, ")
    };
    rows(&row["bindings"]).iter().map(name_and_type).map(binding).collect()
}

/// Returns the name of the static of a kernel or drawing.
#[cfg(feature = "gpu")]
fn constant_name(name: &str) -> String {
    name.to_uppercase().replace('-', "_")
}

/// Returns the kernels of the kernel table as statics of `gpu/kernels.rs`, and `KERNELS`, which lists them.
#[cfg(feature = "gpu")]
fn kernel_source(table: &Value) -> String {
    let (mut out, mut names) = (String::new(), Vec::new());
    for row in rows(&table["kernels"]) {
        let name = text(&row["name"]);
        let constant = constant_name(name);
        let (files, bindings) = (file_source(row), binding_source(row));
        let reader = row.get("reader").map_or("None".into(), |name| format!("Some(&{})", constant_name(text(name))));
        out += &format!(
            "/// {}\npub static {constant}: Kernel = Kernel {{ name: {name:?}, entry: {:?}, files: &[{files}], \
             bindings: &[{bindings}], workgroup: {}, reader: {reader} }};\n",
            text(&row["about"]),
            text(&row["entry"]),
            row["workgroup"],
        );
        names.push(format!("&{constant}"));
    }
    out + &format!("/// All kernels.\npub static KERNELS: [&Kernel; {}] = [{}];\n", names.len(), names.join(", "))
}

/// Returns the drawings of the kernel table as statics of `gpu/kernels.rs`, and `DRAWINGS`, which lists them.
#[cfg(feature = "gpu")]
fn drawing_source(table: &Value) -> String {
    let (mut out, mut names) = (String::new(), Vec::new());
    for row in rows(&table["drawings"]) {
        let name = text(&row["name"]);
        let constant = constant_name(name);
        let mut targets = String::new();
        for (name, blending) in rows(&row["targets"]).iter().map(name_and_type) {
            let blending = match blending {
                "over" => "Over",
                "add" => "Add",
                "nearest" => "Nearest",
                "index" => "Index",
                other => panic!("shaders/kernels.json: {other} is no kind of blending"),
            };
            targets += &format!("Target {{ name: {name:?}, blending: Blending::{blending} }}, ");
        }
        out += &format!(
            "/// {}\npub static {constant}: Drawing = Drawing {{ name: {name:?}, vertex: {:?}, fragment: {:?}, files: &[{}], \
             bindings: &[{}], targets: &[{targets}] }};\n",
            text(&row["about"]),
            text(&row["vertex"]),
            text(&row["fragment"]),
            file_source(row),
            binding_source(row),
        );
        names.push(format!("&{constant}"));
    }
    out + &format!("/// All drawings.\npub static DRAWINGS: [&Drawing; {}] = [{}];\n", names.len(), names.join(", "))
}

#[cfg(feature = "gpu")]
fn write_kernel_table() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=shaders/kernels.json");
    let table: Value = serde_json::from_str(&fs::read_to_string("shaders/kernels.json")?)?;
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(folder.join("kernels.rs"), kernel_source(&table) + &drawing_source(&table))?;
    fs::write(folder.join("layout.rs"), layout_source(&table))
}

/// Folder to which the bundler of viewer/ writes the player.
#[cfg(feature = "cli")]
const PLAYER: &str = "viewer/dist";

/// Writes the files of the player as `FILES` of `serve/player.rs`.
#[cfg(feature = "cli")]
fn write_player() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed={PLAYER}");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(PLAYER);
    assert!(folder.join("index.html").is_file(), "{PLAYER}/index.html is not there: run `node build.mjs` in viewer/");
    let name = |path: &PathBuf| -> String {
        let parts = path.strip_prefix(&folder).unwrap_or(path).iter().map(|part| part.to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    };
    let mut names: Vec<String> = files(&folder).iter().map(name).collect();
    names.sort();
    let mut out = format!("/// The files of the player.\npub static FILES: [PlayerFile; {}] = [\n", names.len());
    for name in names {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '/');
        assert!(name.chars().all(is_plain), "{PLAYER}/{name}: letters, digits, -, _ and . were expected");
        let include = format!("include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{PLAYER}/{name}\"))");
        out += &format!("PlayerFile {{ name: {name:?}, bytes: {include} }},\n");
    }
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(folder.join("player.rs"), out + "];\n")
}

fn main() {
    #[cfg(feature = "gpu")]
    write_kernel_table().expect("shaders/kernels.json becomes Rust");
    #[cfg(feature = "cli")]
    write_player().expect("viewer/dist is listed");
    for name in SOURCES {
        println!("cargo::rerun-if-changed={name}");
    }
    println!("cargo::rustc-env=LIGHTFOLD_SOURCES=#{:016x}", hash_of_sources(Path::new(env!("CARGO_MANIFEST_DIR"))));
    println!("cargo::rustc-check-cfg=cfg(footage_at_hand)");
    println!("cargo::rustc-check-cfg=cfg(seurat_at_hand)");
    println!("cargo::rustc-check-cfg=cfg(ffmpeg_at_hand)");
    let folders = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&folders).any(|folder| folder.join("ffmpeg").is_file()) {
        println!("cargo::rustc-cfg=ffmpeg_at_hand");
    }
    println!("cargo::rerun-if-env-changed=LIGHTFOLD_DATA");
    println!("cargo::rerun-if-changed=build.rs");
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("LIGHTFOLD_DATA").map_or(beside, Into::into);
    if data.join("sponza/lightfield.json").is_file() {
        println!("cargo::rustc-cfg=footage_at_hand");
        println!("cargo::rustc-env=LIGHTFOLD_DATA={}", data.display());
        if data.join("seurat/manifest_v3.json").is_file() {
            println!("cargo::rustc-cfg=seurat_at_hand");
        }
    }
    // The kernels of `intel_tex_2` include an object file compiled from C++, which references `__gxx_personality_v0`, but the
    // crate does not link the library that defines it. The library is named by its file, which is installed even without the
    // packages of a C++ compiler. It is passed as a linker argument, and so comes after all objects, as linkers that read each
    // input once require.
    let target = |name| std::env::var(name).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-l:libstdc++.so.6");
    }
}
