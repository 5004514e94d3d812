//! Tells the tests whether the measured footage is at hand, and whether they may mount a disk of their own, so that those
//! which need it say "ignored" where it is not; and tells the linker of the C++ library that the encoder of blocks wants.

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
    println!("cargo::rustc-check-cfg=cfg(own_disk_at_hand)");
    let mount = ["-rm", "sh", "-c", "mount -t tmpfs -o size=64k none /tmp"];
    if std::process::Command::new("unshare").args(mount).output().is_ok_and(|done| done.status.success()) {
        println!("cargo::rustc-cfg=own_disk_at_hand");
    }
    // The kernels of `intel_tex_2` come with an object made from C++, which names `__gxx_personality_v0` and does not say
    // where it is. The library is named by its file, which is there without the packages that compile C++; and as an
    // argument, which stands behind all objects, where linkers that read once need it.
    let target = |name| std::env::var(name).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-l:libstdc++.so.6");
    }
}
