//! Turns the rows and constants of the kernel table that prepared chunks use into Rust, for `src/gpu/layout.rs`.

#![allow(clippy::disallowed_methods)]

use std::error::Error;
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

/// Returns a struct with its members, each `name: type`.
fn struct_source(table: &Value, name: &str) -> Result<String, String> {
    let rows = table["structs"].as_array().into_iter().flatten();
    let row = rows.into_iter().find(|row| row["name"] == name).ok_or(format!("{TABLE} has no struct {name}"))?;
    let members: Vec<&str> = row["members"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    Ok(format!("{name} {{ {} }}\n", members.join(", ")))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={TABLE}");
    println!("cargo::rerun-if-changed=build.rs");
    let table: Value = serde_json::from_str(&fs::read_to_string(TABLE)?)?;
    let structs: String = STRUCTS.iter().map(|name| struct_source(&table, name)).collect::<Result<_, _>>()?;
    let constants = CONSTANTS.map(|name| format!("{name} = {};\n", table["constants"][name])).concat();
    let source = format!("structs! {{\n{structs}}}\nconstants! {{\n{constants}}}\n");
    fs::write(PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("layout.rs"), source)?;
    Ok(())
}
