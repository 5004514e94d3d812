//! Tells the tests whether the measured footage is at hand, so that those which need it say "ignored" where it is not; tells
//! the encoder by a hash from which sources it is built; and tells the linker of the C++ library that the encoder of blocks
//! wants.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

/// What an encoder is made of: two builds that agree in these write the same bytes.
const SOURCES: [&str; 2] = ["Cargo.lock", "src"];

/// Files below a path, or the file that it is.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(path) else { return vec![path.to_path_buf()] };
    entries.flatten().flat_map(|entry| files(&entry.path())).collect()
}

/// A hash of names and contents. A file that cannot be read is as one that is not there.
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

fn main() {
    for name in SOURCES {
        println!("cargo::rerun-if-changed={name}");
    }
    println!("cargo::rustc-env=LIGHTFOLD_SOURCES=#{:016x}", hash_of_sources(Path::new(env!("CARGO_MANIFEST_DIR"))));
    println!("cargo::rustc-check-cfg=cfg(footage_at_hand)");
    println!("cargo::rerun-if-env-changed=LIGHTFOLD_DATA");
    println!("cargo::rerun-if-changed=build.rs");
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("LIGHTFOLD_DATA").map_or(beside, Into::into);
    if data.join("sponza/lightfield.json").is_file() {
        println!("cargo::rustc-cfg=footage_at_hand");
        println!("cargo::rustc-env=LIGHTFOLD_DATA={}", data.display());
    }
    // The kernels of `intel_tex_2` come with an object made from C++, which names `__gxx_personality_v0` and does not say
    // where it is. The library is named by its file, which is there without the packages that compile C++; and as an
    // argument, which stands behind all objects, where linkers that read once need it.
    let target = |name| std::env::var(name).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-l:libstdc++.so.6");
    }
}
