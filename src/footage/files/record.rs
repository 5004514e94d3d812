//! Records the operations on files below a folder, for tests that replay them as crashes.

use std::io::Result;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A successful operation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operation {
    /// Opens a file for writing; creates it if it is missing.
    Open {
        handle: u64,
        path: PathBuf,
        is_emptied: bool,
    },
    Write {
        handle: u64,
        at: u64,
        bytes: Vec<u8>,
    },
    SetLen {
        handle: u64,
        bytes: u64,
    },
    Sync {
        handle: u64,
    },
    SyncFile {
        path: PathBuf,
    },
    SyncFolder {
        path: PathBuf,
    },
    Rename {
        from: PathBuf,
        to: PathBuf,
    },
    /// Removes a file or an empty folder.
    Remove {
        path: PathBuf,
    },
    CreateFolder {
        path: PathBuf,
    },
}

impl Operation {
    fn is_below(&self, root: &Path, handles: &[u64]) -> bool {
        match self {
            Operation::Open { path, .. }
            | Operation::SyncFile { path }
            | Operation::SyncFolder { path }
            | Operation::Rename { to: path, .. }
            | Operation::Remove { path }
            | Operation::CreateFolder { path } => path.starts_with(root),
            Operation::Write { handle, .. } | Operation::SetLen { handle, .. } | Operation::Sync { handle } => {
                handles.contains(handle)
            }
        }
    }
}

/// Number of an open file in recorded operations.
#[derive(Debug, Clone)]
pub struct Handle {
    number: u64,
    is_recorded: bool,
}

static NEXT: AtomicU64 = AtomicU64::new(0);

impl Handle {
    pub(super) fn new() -> Handle {
        Handle { number: NEXT.fetch_add(1, Ordering::Relaxed), is_recorded: false }
    }

    /// Returns the handle of a file that was opened at `path`; recorded if the path is below the folder of a recorder.
    pub(super) fn of(self, path: &Path) -> Handle {
        Handle { is_recorded: recorders().iter().any(|recorder| path.starts_with(&recorder.root)), ..self }
    }

    pub(super) fn number(&self) -> u64 {
        self.number
    }

    pub(super) fn is_recorded(&self) -> bool {
        self.is_recorded
    }
}

struct Recorder {
    root: PathBuf,
    handles: Vec<u64>,
    operations: Vec<Operation>,
}

static RECORDERS: Mutex<Vec<Recorder>> = Mutex::new(Vec::new());

fn recorders() -> MutexGuard<'static, Vec<Recorder>> {
    RECORDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls the system, and records the operation if it succeeded. One call at a time, so that the recorded order is the actual
/// one.
pub(super) fn done<T>(call: impl FnOnce() -> Result<T>, operation: impl FnOnce(&T) -> Operation) -> Result<T> {
    let mut recorders = recorders();
    if recorders.is_empty() {
        drop(recorders);
        return call();
    }
    let result = call()?;
    let operation = operation(&result);
    for recorder in recorders.iter_mut().filter(|recorder| operation.is_below(&recorder.root, &recorder.handles)) {
        if let Operation::Open { handle, .. } = operation {
            recorder.handles.push(handle);
        }
        recorder.operations.push(operation.clone());
    }
    Ok(result)
}

/// Runs `work`, and returns the operations on files below an absolute folder, in their order.
pub fn record<T>(root: &Path, work: impl FnOnce() -> T) -> (T, Vec<Operation>) {
    recorders().push(Recorder { root: root.to_path_buf(), handles: Vec::new(), operations: Vec::new() });
    let result = work();
    let mut recorders = recorders();
    let at = recorders.iter().position(|recorder| recorder.root == root);
    (result, at.map_or_else(Vec::new, |at| recorders.remove(at).operations))
}
