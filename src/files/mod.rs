//! Files and folders that appear whole or not at all, also where the power fails, and locks between processes.
//!
//! Every output of every command is written here. The order is always the same: bytes go to a temporary name, they reach the disk,
//! the name is changed, and the name reaches the disk. So there is at any time the previous file, the whole new one, or none; and what
//! a command has written stays once it ends. What a stopped command keeps has lengths and checksums, and a later one with `--resume`
//! reads it again before it goes on.
//!
//! | type | content | left by a killed process |
//! | --- | --- | --- |
//! | [`write_whole`] | one small file | an empty or unfinished file, which the next run replaces |
//! | [`OutputFile`] | one file, a pipe or a device | a file and its journal, to resume from |
//! | [`OutputFolder`] | a folder | a temporary folder, which the next run removes |
//! | [`PartialFolder`] | a folder of images | a folder, to resume from |
//! | [`WorkFolder`] | a temporary folder | the same, which the next run removes |
//!
//! All are locked, so that no process takes what another still writes for left over. Files of a folder reach the disk together, several
//! at once: one by one, thousands would each wait for it. `disk` has the operations, of which tests can make a `record`.

#![allow(clippy::disallowed_methods)]

mod disk;
mod file_folder;
mod lock;
mod names;
mod output_file;
mod output_folder;
mod partial_file;
mod partial_folder;
#[cfg(feature = "internals")]
pub mod record;
mod regular;
mod standard_output;
mod work_folder;

pub use disk::{DiskFile, create_folders, remove_file};
pub use file_folder::FileFolder;
pub use lock::{Locked, open_locked};
pub use names::{check_file, check_name, parent_of};
pub use output_file::{OutputFile, write_whole};
pub use output_folder::OutputFolder;
pub use partial_file::IntactBytes;
pub use partial_folder::{FolderKind, Kept, Left, PartialFolder};
pub use regular::open_regular;
pub use standard_output::standard_output;
pub use work_folder::WorkFolder;
