//! Switch for skipping work whose result is known.

/// Whether work whose result is known is skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShortCuts {
    #[default]
    Taken,
    /// No work is skipped: the result is the same, but takes longer.
    Off,
}
