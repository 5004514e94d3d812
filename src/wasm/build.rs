//! Turns the rows and constants of the kernel table that prepared chunks use into Rust, for `src/gpu/layout.rs`.

#![allow(clippy::disallowed_methods)]

use std::path::PathBuf;
use std::{env, fs};

use serde_json::Value;

const TABLE: &str = "../../shaders/kernels.json";
const STRUCTS: [&str; 2] = ["Record", "BoxRow"];
const CONSTANTS: [&str; 7] = [
    "BOX_BLOCKS",
    "BOX_CONSTANT",
    "BOX_VALUES",
    "KEYFRAME_BLOCKS",
    "KEYFRAME_SAMPLES",
    "PASS_ITERATIONS",
    "STEP_ITERATIONS",
];

/// Returns the members of a struct, each `name: type`, separated by commas.
fn members(table: &Value, name: &str) -> String {
    let rows = table["structs"].as_array().into_iter().flatten();
    let row = rows.into_iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{TABLE} has no {name}"));
    let members: Vec<&str> = row["members"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    members.join(", ")
}

fn main() {
    println!("cargo::rerun-if-changed={TABLE}");
    println!("cargo::rerun-if-changed=build.rs");
    let text = fs::read_to_string(TABLE).expect("shaders/kernels.json is there");
    let table: Value = serde_json::from_str(&text).expect("shaders/kernels.json is JSON");
    let structs = STRUCTS.map(|name| format!("{name} {{ {} }}\n", members(&table, name))).concat();
    let constants = CONSTANTS.map(|name| format!("{name} = {};\n", table["constants"][name])).concat();
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let source = format!("structs! {{\n{structs}}}\nconstants! {{\n{constants}}}\n");
    fs::write(out.join("layout.rs"), source).expect("OUT_DIR can be written");
}
