//! Files and folders that appear whole or not at all, and locks between processes.
//!
//! Results are written under a temporary name that ends in `.partial` and renamed at the end, so an interrupted command
//! leaves the previous file. Single files are locked and reach the disk before they are renamed. Folders of images are
//! neither locked (except [`PartialFolder`]) nor synced: thousands of files would each wait for the disk. After a loss of
//! power, files written just before may be empty.
//!
//! | type | content | lock | left by a killed process |
//! | --- | --- | --- | --- |
//! | [`write_whole`] | one small file | no | a temporary file |
//! | [`OutputFile`] | one file, a pipe or a device | yes | a file and its journal, to resume from |
//! | [`OutputFolder`] | a folder | no | a temporary folder |
//! | [`PartialFolder`] | a folder of images | yes | a folder, to resume from |

mod atomic;
mod lock;
mod output_file;
mod output_folder;
mod partial_file;
mod partial_folder;
mod regular;

pub use atomic::{parent_of, write_whole};
pub use lock::open_locked;
pub use output_file::OutputFile;
pub use output_folder::OutputFolder;
pub use partial_file::IntactBytes;
pub use partial_folder::{FolderKind, PartialFolder};
pub use regular::open_regular;
