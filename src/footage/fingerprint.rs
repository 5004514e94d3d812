//! Configuration hash: the inputs and settings that a result depends on. Work can be resumed only with the same
//! configuration.

use std::fs::Metadata;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const SOURCES: &str = "the sources of lightfold";
const ANOTHER_VERSION: &str = "it was started by another version of lightfold";

/// True if a value is a [`digest`], which messages do not show.
fn is_digest(value: &str) -> bool {
    value.starts_with('#')
}

/// Names and values in a fixed order. Settings are named as in messages: `` `depth_window` ``.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fingerprint(pub Vec<(String, String)>);

impl Fingerprint {
    /// Returns the version of the program and the hashes of the sources that determine its output: `SOURCES` of packages.
    pub fn of_program(sources: &[&str]) -> Vec<(&'static str, String)> {
        vec![("the version of lightfold", env!("CARGO_PKG_VERSION").to_owned()), (SOURCES, sources.join(" "))]
    }

    /// Returns the names of the values that differ, or all names (up to the shorter list) if the two lists differ in their
    /// names.
    pub fn differing(&self, now: &Fingerprint) -> Vec<&str> {
        let has_same_names = self.0.len() == now.0.len() && self.0.iter().zip(&now.0).all(|((a, _), (b, _))| a == b);
        let pairs = self.0.iter().zip(&now.0);
        pairs.filter(|(old, new)| !has_same_names || old != new).map(|((name, _), _)| name.as_str()).collect()
    }

    /// Describes the first difference between unfinished work (`self`) and the current work (`now`); `None` if they are
    /// equal.
    pub fn difference(&self, now: &Fingerprint) -> Option<String> {
        let mut pairs = self.0.iter().zip(&now.0);
        match pairs.find(|(old, new)| old != new) {
            Some(((name, _), (of, _))) if name == of && name == SOURCES => Some(ANOTHER_VERSION.to_owned()),
            Some(((name, old), (of, new))) if name == of => Some(match (is_digest(old), is_digest(new)) {
                (true, true) => format!("{name} has changed"),
                (true, false) => format!("{name} was given and is {new} now"),
                (false, true) => format!("{name} was {old} and is given now"),
                (false, false) => format!("{name} was {old} and is {new} now"),
            }),
            None if self.0.len() == now.0.len() => None,
            _ => Some(ANOTHER_VERSION.to_owned()),
        }
    }
}

/// Path, size in bytes and modification time of a file; size 0 and no time if the path is not a file.
pub fn file_state(path: &Path) -> (PathBuf, u64, Option<SystemTime>) {
    let meta = path.metadata().ok().filter(|meta| meta.is_file());
    (path.to_owned(), meta.as_ref().map_or(0, Metadata::len), meta.and_then(|meta| meta.modified().ok()))
}

pub fn digest(bytes: &[u8]) -> String {
    format!("#{:032x}", u128::from_be_bytes(digest_bytes(bytes)))
}

/// Returns a 128-bit hash: two runs of [`DefaultHasher`] with different first bytes.
pub fn digest_bytes(bytes: &[u8]) -> [u8; 16] {
    let hash = |part: u8| {
        let mut hasher = DefaultHasher::new();
        hasher.write_u8(part);
        hasher.write(bytes);
        hasher.finish()
    };
    (u128::from(hash(1)) << 64 | u128::from(hash(2))).to_be_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(fields: &[(&str, &str)]) -> Fingerprint {
        Fingerprint(fields.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect())
    }

    #[test]
    fn the_first_difference_is_reported() {
        let begun = of(&[("`size`", "8"), ("the file of cameras", "#01")]);
        assert_eq!(begun.difference(&begun.clone()), None);
        let says = |now: &[(&str, &str)]| begun.difference(&of(now)).unwrap();
        assert_eq!(says(&[("`size`", "9"), ("the file of cameras", "#02")]), "`size` was 8 and is 9 now");
        let cameras = |value| says(&[("`size`", "8"), ("the file of cameras", value)]);
        assert_eq!(cameras("#02"), "the file of cameras has changed");
        assert_eq!(cameras("none"), "the file of cameras was given and is none now");
        for now in [&[("`size`", "8")][..], &[("`fps`", "8"), ("the file of cameras", "#01")]] {
            assert!(says(now).contains("another version of lightfold"), "{now:?}");
        }
    }

    #[test]
    fn digests_tell_bytes_apart() {
        assert_eq!(digest(b"a"), digest(b"a"));
        assert_ne!(digest(b"a"), digest(b"b"));
        assert_eq!(digest(b"").len(), 33);
    }
}
