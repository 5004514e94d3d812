//! Which animation is shown, and notes that are safe to print.

/// Most characters of a note.
const MAX_NOTE: usize = 400;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Play<'a> {
    /// The first, if there is any.
    #[default]
    First,
    /// The first of this name, as `Model::animations` has it.
    Named(&'a str),
}

/// A note with control characters escaped: it quotes names of the file.
pub(super) fn printable(note: &str) -> String {
    let plain = |c: char| if c.is_control() { c.escape_default().collect() } else { c.to_string() };
    note.chars().take(MAX_NOTE).map(plain).collect()
}
