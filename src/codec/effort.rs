//! Search effort.

/// Search effort; one setting for all searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Effort {
    /// Faster, with a documented loss.
    Fast,
    /// Close to the result of [`Effort::Exhaustive`].
    #[default]
    Normal,
    /// Full search, the reference.
    Exhaustive,
}

impl Effort {
    /// Returns `fast`, `normal` or `exhaustive`.
    pub fn name(self) -> &'static str {
        match self {
            Effort::Fast => "fast",
            Effort::Normal => "normal",
            Effort::Exhaustive => "exhaustive",
        }
    }
}
