//! Search effort.

use clap::Args;

use super::choice::{Choices, one_of};
use codec::effort::Effort;
use footage::encode::EncodeSettings;

pub const EFFORTS: &Choices<Effort> = &[
    ("fast", Effort::Fast, "Faster, slightly worse result"),
    ("normal", Effort::Normal, "Result close to exhaustive"),
    ("exhaustive", Effort::Exhaustive, "Full search: the reference"),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct EffortArgs {
    /// Search effort for colour partitions, quantisation steps and keyframes, and for blocks of all kinds [default:
    /// normal]
    #[arg(long, value_parser = one_of(EFFORTS))]
    pub effort: Option<Effort>,
}

impl EffortArgs {
    pub fn apply(self, settings: &mut EncodeSettings) {
        settings.search.effort = self.effort.unwrap_or_default();
        settings.depth.effort = self.effort.unwrap_or_default();
    }
}
