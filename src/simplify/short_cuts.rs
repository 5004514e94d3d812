//! Switch for skipping work whose result is known.

/// Setting that skips work whose result is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShortCuts {
    #[default]
    Taken,
    /// No work is skipped: the result is the same, but takes longer.
    Off,
}
