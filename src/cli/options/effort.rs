//! Search effort.

use clap::{Args, ValueEnum};

use crate::effort::Effort;
use crate::encode::EncodeSettings;

/// Search effort.
#[derive(Debug, Clone, Copy, Args)]
pub struct EffortArgs {
    /// Search effort: for the farthest keyframe of colour, and for blocks of all kinds
    #[arg(long, value_enum, default_value_t = EffortArg::Normal)]
    pub effort: EffortArg,
}

impl EffortArgs {
    /// The effort.
    pub fn get(self) -> Effort {
        self.effort.into()
    }

    /// Puts the option where the encoder reads it; after those of depth and colour.
    pub fn apply(self, settings: &mut EncodeSettings) {
        settings.search.effort = self.get();
        settings.depth.effort = self.get();
    }
}

/// `--effort`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EffortArg {
    /// Faster, with a small loss
    Fast,
    /// Close to the result of exhaustive
    Normal,
    /// Full search: the reference
    Exhaustive,
}

impl From<EffortArg> for Effort {
    fn from(effort: EffortArg) -> Effort {
        match effort {
            EffortArg::Fast => Effort::Fast,
            EffortArg::Normal => Effort::Normal,
            EffortArg::Exhaustive => Effort::Exhaustive,
        }
    }
}
