//! Shared parts of the build scripts.

#![allow(clippy::disallowed_methods)]

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

/// Links the C++ library that the block encoder needs. The kernels of `intel_tex_2` include an object file compiled from C++,
/// which references `__gxx_personality_v0`, but the crate does not link the library that defines it. The library is named by its
/// file, which is installed even without the packages of a C++ compiler. It is passed as a linker argument, and so comes after
/// all objects, as linkers that read each input once require; such an argument holds for one package, so that every package with
/// tests or a program passes it.
pub fn link_cxx() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = |name| std::env::var(name).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-l:libstdc++.so.6");
    }
}

/// Returns the folder of the package that is built.
pub fn package_folder() -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default()
}

/// Returns the files below a path, or the path itself if it is a file. Links are not followed.
pub fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_symlink() {
        return Vec::new();
    }
    let Ok(entries) = fs::read_dir(path) else { return vec![path.to_path_buf()] };
    entries.flatten().flat_map(|entry| files(&entry.path())).collect()
}

/// Sets the variable `LIGHTFOLD_SOURCES` of the package to a hash of names and contents of its Rust sources and of `others`. Unreadable files are skipped, like missing ones.
pub fn hash_sources(others: &[PathBuf]) {
    let folder = package_folder();
    println!("cargo::rerun-if-changed=.");
    let mut hasher = DefaultHasher::new();
    let mut files: Vec<PathBuf> = files(&folder);
    files.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
    for other in others {
        println!("cargo::rerun-if-changed={}", other.display());
        files.push(other.clone());
    }
    // Names do not depend on the place of the checkout.
    let name = |path: &Path| match path.strip_prefix(&folder) {
        Ok(inside) => inside.as_os_str().to_owned(),
        Err(_) => path.file_name().unwrap_or_default().to_owned(),
    };
    files.sort_by_key(|path| name(path));
    for path in files {
        let Ok(bytes) = fs::read(&path) else { continue };
        for part in [name(&path).as_encoded_bytes(), &bytes] {
            hasher.write_usize(part.len());
            hasher.write(part);
        }
    }
    println!("cargo::rustc-env=LIGHTFOLD_SOURCES=#{:016x}", hasher.finish());
}

/// Sets `cfg` flags for the measured footage and the Seurat data, so that tests that need them are reported as ignored if they
/// are missing. They are in the folder `LIGHTFOLD_DATA`.
pub fn find_data(root: &str) {
    println!("cargo::rustc-check-cfg=cfg(footage_at_hand)");
    println!("cargo::rustc-check-cfg=cfg(seurat_at_hand)");
    println!("cargo::rerun-if-env-changed=LIGHTFOLD_DATA");
    let beside = package_folder().join(root).join("../shared/data");
    let data = std::env::var_os("LIGHTFOLD_DATA").map_or(beside, Into::into);
    if data.join("sponza/lightfield.json").is_file() {
        println!("cargo::rustc-cfg=footage_at_hand");
        println!("cargo::rustc-env=LIGHTFOLD_DATA={}", data.display());
        if data.join("seurat/manifest_v3.json").is_file() {
            println!("cargo::rustc-cfg=seurat_at_hand");
        }
    }
}

/// Returns the folder of the repository that a package shares, by its link in the package's folder. `path` leads to it from there
/// where the link is a file, on systems without links.
pub fn shared_folder(link: &str, path: &str) -> PathBuf {
    let linked = package_folder().join(link);
    let folder = if linked.is_dir() { linked } else { package_folder().join(path) };
    // The folder itself: `files` follows no links.
    folder.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
}
