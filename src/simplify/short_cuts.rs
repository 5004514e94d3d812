//! Work that is left out.

/// Whether work is left out whose result is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShortCuts {
    #[default]
    Taken,
    /// The same result takes longer.
    Off,
}
