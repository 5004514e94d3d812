//! Sets the folder of the table files and the hash of sources; links the C++ library.

fn main() {
    let formats = build::shared_folder("formats", "../../formats");
    println!("cargo::rustc-env=LIGHTFOLD_FORMATS={}", formats.display());
    let tables = ["color-tables.txt", "depth-tables.txt"].map(|name| formats.join(name));
    build::hash_sources(&tables);
    if std::env::var_os("CARGO_FEATURE_ENCODE").is_some() {
        build::link_cxx();
    }
}
