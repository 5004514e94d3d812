//! Camera files of lightfold and of other programs: format detection, reading and writing, with one module per format.
//!
//! Input: a file or folder, whose content determines the format. Output: [`FileCameras`]. Writing is the reverse.
//!
//! Cameras of lightfold are in a right-handed world with +Y up, and look along −Z with +Y up. Coordinates of other programs are
//! used unchanged, except for the unit and the up axis if a format states them. A camera that is mirrored or not perspective is left out,
//! and the distortion of a lens, both with a note. Clip planes of other programs are not read: they limit what a program draws, not the extent of the
//! scene.

mod colmap;
mod colmap_binary;
mod colmap_model;
mod document;
mod formats;
mod gltf;
mod lens;
mod own;
mod paths;
mod poses;
mod probes;
mod transforms;
mod usd;

pub use document::{Content, FileCamera, FileCameras, ReadSettings, WriteSettings, Written, picture_stem};
pub use formats::{CameraFormat, parse, read, write};
pub use probes::of_probes;

#[cfg(test)]
mod tests;
