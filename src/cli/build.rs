//! Lists the files of the player; sets the folder of the formats; links the C++ library.

#![allow(clippy::disallowed_methods)]

use std::fs;
use std::path::PathBuf;

/// Folder to which the bundler of viewer/ writes the player.
const PLAYER: &str = "viewer/dist";

/// Writes the files of the player as `FILES` of `serve/player.rs`.
fn write_player() -> std::io::Result<()> {
    let folder = build::shared_folder("player", "../../viewer/dist");
    println!("cargo::rerun-if-changed={}", folder.display());
    println!("cargo::rustc-env=LIGHTFOLD_PLAYER={}", folder.display());
    assert!(folder.join("index.html").is_file(), "{PLAYER}/index.html is not there: run `node build.mjs` in viewer/");
    let name = |path: &PathBuf| -> String {
        let parts = path.strip_prefix(&folder).unwrap_or(path).iter().map(|part| part.to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    };
    let mut names: Vec<String> = build::files(&folder).iter().map(name).collect();
    names.sort();
    let mut out = format!("/// The files of the player.\npub static FILES: [PlayerFile; {}] = [\n", names.len());
    for name in names {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '/');
        assert!(name.chars().all(is_plain), "{PLAYER}/{name}: letters, digits, -, _ and . were expected");
        let include = format!("include_bytes!(concat!(env!(\"LIGHTFOLD_PLAYER\"), \"/{name}\"))");
        out += &format!("PlayerFile {{ name: {name:?}, bytes: {include} }},\n");
    }
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(folder.join("player.rs"), out + "];\n")
}

fn main() {
    write_player().expect("viewer/dist is listed");
    println!("cargo::rustc-env=LIGHTFOLD_FORMATS={}", build::shared_folder("formats", "../../formats").display());
    build::link_cxx();
}
