//! Files and folders that appear whole or not at all, even after a power failure, and locks between processes.
//!
//! All outputs of all commands are written by this module, always in the same order: write under a temporary name, sync,
//! rename, sync the folder. At any time either the previous file, the complete new file or no file exists, and all output is
//! on disk when a command ends. Files that an interrupted command keeps have lengths and checksums; a later run with
//! `--resume` verifies them before it continues.
//!
//! | type | content | after a killed process |
//! | --- | --- | --- |
//! | [`write_whole`] | one small file | an empty or unfinished file, which the next run replaces |
//! | [`OutputFile`] | one file, a pipe or a device | a file and its journal, to resume from |
//! | [`OutputFolder`] | a folder | a temporary folder, which the next run removes |
//! | [`PartialFolder`] | a folder of images | a folder, to resume from |
//! | [`WorkFolder`] | a temporary folder | the same, which the next run removes |
//!
//! Each is locked, so that no process mistakes the unfinished output of a running process for a leftover. Files of a folder
//! are synced together, several at once; one by one, thousands of files would each wait for the disk. `disk` has the
//! operations, which tests can `record`.

#![allow(clippy::disallowed_methods)]

mod disk;
mod file_folder;
mod lock;
mod names;
mod output_file;
mod output_folder;
mod partial_file;
mod partial_folder;
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
