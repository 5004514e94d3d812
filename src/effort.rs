//! How hard an encoder looks, wherever it searches.

/// Three efforts; what each means is said where the search is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Effort {
    /// Little time, at a stated loss.
    Fast,
    /// What the exhaustive search would find, or close to it, in reasonable time.
    #[default]
    Normal,
    /// The literal search, which the others are measured against.
    Exhaustive,
}
