//! Sets `cfg` flags for footage, ffmpeg and long tests, so that tests without them are reported as ignored; links the C++ library.

fn main() {
    build::find_data(".");
    println!("cargo::rustc-check-cfg=cfg(ffmpeg_at_hand)");
    let folders = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&folders).any(|folder| folder.join("ffmpeg").is_file()) {
        println!("cargo::rustc-cfg=ffmpeg_at_hand");
    }
    // Long tests: `scripts/test all`.
    println!("cargo::rustc-check-cfg=cfg(all_tests)");
    println!("cargo::rerun-if-env-changed=LIGHTFOLD_TESTS");
    if std::env::var_os("LIGHTFOLD_TESTS").is_some_and(|which| which == "all") {
        println!("cargo::rustc-cfg=all_tests");
    }
    build::link_cxx();
}
