//! Generates Rust from the kernel table; sets the hash of sources; links the C++ library.

#![allow(clippy::disallowed_methods)]

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not a string"))
}

fn rows(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not an array"))
}

/// Splits a struct member or binding, written `name: type`, into name and type.
fn name_and_type(value: &Value) -> (&str, &str) {
    text(value).split_once(": ").unwrap_or_else(|| panic!("shaders/kernels.json: {value} is not 'name: type'"))
}

/// Returns the structs and constants of the kernel table as input of the macros of `layout.rs`.
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
fn file_source(row: &Value) -> String {
    let file = |path: &str| {
        let include = format!("include_str!(concat!(env!(\"LIGHTFOLD_SHADERS\"), \"/{path}\"))");
        format!("ShaderFile {{ path: {path:?}, text: {include} }}, ")
    };
    rows(&row["files"]).iter().map(text).map(file).collect()
}

/// Returns the bindings of a row as elements of a list of `Binding`.
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
fn constant_name(name: &str) -> String {
    name.to_uppercase().replace('-', "_")
}

/// Returns the kernels of the kernel table as statics of `table.rs`, and `KERNELS`, which lists them.
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

/// Returns the drawings of the kernel table as statics of `table.rs`, and `DRAWINGS`, which lists them.
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

fn write_kernel_table() -> std::io::Result<()> {
    let shaders = build::shared_folder("shaders", "../../shaders");
    println!("cargo::rerun-if-changed={}", shaders.display());
    println!("cargo::rustc-env=LIGHTFOLD_SHADERS={}", shaders.display());
    let table: Value = serde_json::from_str(&fs::read_to_string(shaders.join("kernels.json"))?)?;
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(folder.join("kernels.rs"), kernel_source(&table) + &drawing_source(&table))?;
    fs::write(folder.join("layout.rs"), layout_source(&table))
}

fn main() {
    write_kernel_table().expect("shaders/kernels.json becomes Rust");
    build::hash_sources(&build::files(&build::shared_folder("shaders", "../../shaders")));
    build::link_cxx();
}
