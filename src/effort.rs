//! Search effort.

/// Effort of every search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Effort {
    /// Faster, with a stated loss.
    Fast,
    /// Close to the result of exhaustive.
    #[default]
    Normal,
    /// Full search: the reference.
    Exhaustive,
}

impl Effort {
    /// `fast`, `normal` or `exhaustive`.
    pub fn name(self) -> &'static str {
        match self {
            Effort::Fast => "fast",
            Effort::Normal => "normal",
            Effort::Exhaustive => "exhaustive",
        }
    }
}
