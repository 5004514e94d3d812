//! Model of a disk that loses power: the synced state, and the states that a file system may have written since.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Component, Path, PathBuf};

use footage::files::record::Operation;

/// File contents by path; `None` for folders.
pub type Names = BTreeMap<PathBuf, Option<Vec<u8>>>;

type Inode = usize;

#[derive(Clone)]
struct Content {
    /// Content as programs read it.
    now: Vec<u8>,
    /// Content at the last sync; `None` if the file was never synced.
    synced: Option<Vec<u8>>,
}

/// A change of directory entries that a crash may undo.
#[derive(Clone)]
enum Change {
    Put(PathBuf, Option<Inode>),
    Remove(PathBuf),
    Rename(PathBuf, PathBuf),
}

impl Change {
    fn is_in(&self, folder: &Path) -> bool {
        match self {
            Change::Put(path, _) | Change::Remove(path) => parent(path) == folder,
            Change::Rename(from, to) => parent(from) == folder || parent(to) == folder,
        }
    }
}

/// Part of the unsynced bytes that a crash loses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    Nothing,
    Everything,
    SecondHalf,
    /// The new length was written, but all unsynced bytes are zero.
    Values,
}

pub const LOSSES: [Lost; 4] = [Lost::Nothing, Lost::Everything, Lost::SecondHalf, Lost::Values];

type Tree = BTreeMap<PathBuf, Option<Inode>>;

pub struct Disk {
    contents: Vec<Content>,
    handles: HashMap<u64, Inode>,
    now: Tree,
    synced: Tree,
    pending: Vec<Change>,
}

fn parent(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Returns a path relative to the working directory, without `.`.
fn plain(path: &Path) -> PathBuf {
    let here = std::env::current_dir().unwrap();
    path.strip_prefix(here).unwrap_or(path).components().filter(|part| *part != Component::CurDir).collect()
}

/// Applies one change of directory entries. Changes reach the disk independently: an entry whose folder did not reach the disk is
/// kept, and found once the folder exists ([`reachable`]).
fn apply(tree: &mut Tree, change: &Change) {
    match change {
        Change::Put(path, inode) => {
            tree.entry(path.clone()).or_insert(*inode);
        }
        Change::Remove(path) => {
            tree.retain(|name, _| !name.starts_with(path));
        }
        Change::Rename(from, to) => {
            let moved: Vec<PathBuf> = tree.keys().filter(|name| name.starts_with(from)).cloned().collect();
            for name in moved {
                let inode = tree.remove(&name).unwrap();
                // Joining an empty path would append a slash.
                let below = name.strip_prefix(from).unwrap();
                tree.insert(if below == Path::new("") { to.clone() } else { to.join(below) }, inode);
            }
        }
    }
}

/// Returns the entries whose folders exist.
fn reachable(tree: &Tree) -> Tree {
    let has_folders = |path: &Path| {
        let mut above = path.ancestors().skip(1).filter(|above| *above != Path::new(""));
        above.all(|folder| tree.get(folder) == Some(&None))
    };
    tree.iter().filter(|(path, _)| has_folders(path)).map(|(path, inode)| (path.clone(), *inode)).collect()
}

impl Disk {
    /// Returns a disk with the files that exist before a command, all synced.
    pub fn of(names: &Names) -> Disk {
        let mut disk = Disk {
            contents: Vec::new(),
            handles: HashMap::new(),
            now: Tree::new(),
            synced: Tree::new(),
            pending: Vec::new(),
        };
        for (path, bytes) in names {
            let inode = bytes.as_ref().map(|bytes| disk.add(bytes.clone(), Some(bytes.clone())));
            disk.now.insert(path.clone(), inode);
        }
        disk.synced = disk.now.clone();
        disk
    }

    fn add(&mut self, now: Vec<u8>, synced: Option<Vec<u8>>) -> Inode {
        self.contents.push(Content { now, synced });
        self.contents.len() - 1
    }

    fn change(&mut self, change: Change) {
        apply(&mut self.now, &change);
        self.pending.push(change);
    }

    fn sync(&mut self, inode: Inode) {
        self.contents[inode].synced = Some(self.contents[inode].now.clone());
    }

    /// Applies a recorded operation.
    pub fn perform(&mut self, operation: &Operation) {
        match operation {
            Operation::Open { handle, path, is_emptied } => {
                let path = plain(path);
                let inode = match self.now.get(&path) {
                    Some(inode) => inode.unwrap_or_else(|| panic!("{} is a folder", path.display())),
                    None => {
                        let inode = self.add(Vec::new(), None);
                        self.change(Change::Put(path, Some(inode)));
                        inode
                    }
                };
                if *is_emptied {
                    self.contents[inode].now.clear();
                }
                self.handles.insert(*handle, inode);
            }
            Operation::Write { handle, at, bytes } => {
                let content = &mut self.contents[self.handles[handle]].now;
                let (at, end) = (*at as usize, *at as usize + bytes.len());
                content.resize(content.len().max(end), 0);
                content[at..end].copy_from_slice(bytes);
            }
            Operation::SetLen { handle, bytes } => {
                self.contents[self.handles[handle]].now.resize(*bytes as usize, 0);
            }
            Operation::Sync { handle } => self.sync(self.handles[handle]),
            Operation::SyncFile { path } => {
                let inode = self.now[&plain(path)].unwrap();
                self.sync(inode);
            }
            Operation::SyncFolder { path } => {
                let folder = plain(path);
                let (synced, pending): (Vec<Change>, Vec<Change>) =
                    std::mem::take(&mut self.pending).into_iter().partition(|change| change.is_in(&folder));
                synced.iter().for_each(|change| apply(&mut self.synced, change));
                self.pending = pending;
            }
            Operation::Rename { from, to } => self.change(Change::Rename(plain(from), plain(to))),
            Operation::Remove { path } => self.change(Change::Remove(plain(path))),
            Operation::CreateFolder { path } => self.change(Change::Put(plain(path), None)),
        }
    }

    /// Returns a file's content as programs read it.
    pub fn content(&self, path: &Path) -> Option<&[u8]> {
        let inode = (*self.now.get(&plain(path))?)?;
        Some(&self.contents[inode].now)
    }

    /// Returns all files and folders as programs see them.
    pub fn names(&self) -> Names {
        let content = |inode: &Option<Inode>| inode.map(|inode| self.contents[inode].now.clone());
        self.now.iter().map(|(path, inode)| (path.clone(), content(inode))).collect()
    }

    /// Returns the possible states after a crash: a subset of the pending changes of directory entries, with each kind of loss of
    /// unsynced bytes. Each has a description.
    pub fn crashes(&self) -> Vec<(String, Names)> {
        let all = self.pending.len();
        let mut chosen: Vec<(String, Vec<usize>)> = vec![
            ("all names".into(), (0..all).collect()),
            ("no names".into(), Vec::new()),
            ("all names but the last".into(), (0..all.saturating_sub(1)).collect()),
            ("all names but the first".into(), (1..all).collect()),
        ];
        chosen.extend((all.saturating_sub(4)..all).map(|one| (format!("only change {one} of {all}"), vec![one])));
        let mut found = Vec::new();
        for (words, chosen) in chosen {
            let mut tree = self.synced.clone();
            chosen.iter().for_each(|&change| apply(&mut tree, &self.pending[change]));
            let tree = reachable(&tree);
            for lost in LOSSES {
                let content = |inode: Inode| after(&self.contents[inode], lost);
                let names = tree.iter().map(|(path, inode)| (path.clone(), inode.map(content))).collect();
                found.push((format!("{words}, {lost:?} lost"), names));
            }
        }
        found
    }
}

fn after(content: &Content, lost: Lost) -> Vec<u8> {
    if content.synced.as_ref() == Some(&content.now) {
        return content.now.clone();
    }
    // Synced bytes survive if the file has only grown since the sync.
    let kept = content.synced.as_ref().filter(|synced| content.now.starts_with(synced)).map_or(0, Vec::len);
    match lost {
        Lost::Nothing => content.now.clone(),
        Lost::Everything => content.synced.clone().unwrap_or_default(),
        Lost::SecondHalf => content.now[..kept.midpoint(content.now.len())].to_vec(),
        Lost::Values => {
            let mut bytes = content.now.clone();
            bytes[kept..].fill(0);
            bytes
        }
    }
}

/// Returns all files and folders below a folder.
pub fn read(folder: &Path) -> Names {
    fn add(folder: &Path, below: &Path, names: &mut Names) {
        for entry in fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let below = below.join(entry.file_name());
            if entry.file_type().unwrap().is_dir() {
                names.insert(below.clone(), None);
                add(&entry.path(), &below, names);
            } else {
                names.insert(below, Some(fs::read(entry.path()).unwrap()));
            }
        }
    }
    let mut names = Names::new();
    add(folder, Path::new(""), &mut names);
    names
}

/// Replaces the content of a folder by these files and folders.
pub fn write(folder: &Path, names: &Names) {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).unwrap();
    for (path, bytes) in names {
        let path = folder.join(path);
        match bytes {
            None => fs::create_dir(path).unwrap(),
            Some(bytes) => fs::write(path, bytes).unwrap(),
        }
    }
}
