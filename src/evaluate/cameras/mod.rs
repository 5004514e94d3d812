//! Files of cameras, of this and of other programs: recognised, read and written, one file here for each format.
//!
//! Enters: a file or a folder, by its content. Leaves: [`FileCamera`]s in the order of the file; and back.
//!
//! Cameras of this program stand in a right-handed world with +Y up, and look along −Z with +Y up. Coordinates of other programs are taken
//! as they are, except for units and the up axis where a format states them. A camera that is distorted, mirrored or not perspective is
//! refused. Clip planes of other programs are not read: they say what a program draws, and not what is there.

mod colmap;
mod document;
mod formats;
mod gltf;
mod own;
mod poses;
mod probes;
mod transforms;
mod usd;
mod usda;

pub use document::{Content, FileCamera, WriteSettings, Written};
pub use formats::{CameraFormat, parse, read, write};
pub use probes::of_probes;

#[cfg(test)]
mod tests;
