//! Links the C++ library that the block encoder needs, as `build.rs` of `lightfold` does for the program.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = |name| std::env::var(name).unwrap_or_default();
    let is_encoder = std::env::var_os("CARGO_FEATURE_ENCODE").is_some();
    if is_encoder && target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-l:libstdc++.so.6");
    }
}
