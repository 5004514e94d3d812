//! Choice of the animation, and notes that are safe to print.

/// Maximum characters of a note.
const MAX_NOTE: usize = 400;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Play<'a> {
    /// All animations that do not move what an earlier one moves.
    #[default]
    All,
    /// The first animation of this name, as listed in `Model::animations`.
    Named(&'a str),
}

impl<'a> Play<'a> {
    /// Returns the choice of a command line: the name of an animation; `all` or nothing for all.
    pub fn of(name: Option<&'a str>) -> Play<'a> {
        name.filter(|name| *name != "all").map_or(Play::All, Play::Named)
    }
}

/// Escapes control characters in a note, which quotes names from the file.
pub(super) fn printable(note: &str) -> String {
    let plain = |c: char| if c.is_control() { c.escape_default().collect() } else { c.to_string() };
    note.chars().take(MAX_NOTE).map(plain).collect()
}
