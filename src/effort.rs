//! How hard an encoder searches.

/// The three efforts that every search of the toolkit offers under `--effort`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Effort {
    /// A stated loss for speed.
    Fast,
    /// The default: what the reference finds, or close to it, in reasonable time.
    #[default]
    Normal,
    /// The literal search: the reference that the others are measured against.
    Exhaustive,
}
