//! Sets `cfg` flags for footage and ffmpeg, so that tests that need them are reported as ignored if they are missing; links the C++
//! library.

fn main() {
    build::find_data(".");
    println!("cargo::rustc-check-cfg=cfg(ffmpeg_at_hand)");
    let folders = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&folders).any(|folder| folder.join("ffmpeg").is_file()) {
        println!("cargo::rustc-cfg=ffmpeg_at_hand");
    }
    build::link_cxx();
}
