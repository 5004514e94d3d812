//! Tells the tests whether the measured footage is at hand, so that those which need it say "ignored" where it is not.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(footage_at_hand)");
    println!("cargo::rerun-if-env-changed=LIGHTFOLD_DATA");
    println!("cargo::rerun-if-changed=build.rs");
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("LIGHTFOLD_DATA").map_or(beside, Into::into);
    if data.join("sponza/lightfield.json").is_file() {
        println!("cargo::rustc-cfg=footage_at_hand");
        println!("cargo::rustc-env=LIGHTFOLD_DATA={}", data.display());
    }
}
