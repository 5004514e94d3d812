//! Results of checks.

use serde::{Serialize, Serializer};

use crate::json::Number;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The data fit the manifest and would not fit an alternative.
    Fine,
    /// Another hypothesis fits far better, or the data contradict themselves.
    Suspect,
    /// The data are inconclusive.
    CannotTell,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the check, such as `depth.kind`.
    pub check: &'static str,
    pub verdict: Verdict,
    /// The finding as one sentence.
    pub says: String,
    /// Measured values by name.
    #[serde(serialize_with = "by_name")]
    pub figures: Vec<(&'static str, f64)>,
}

fn by_name<S: Serializer>(figures: &[(&'static str, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(figures.iter().map(|(name, value)| (name, Number(*value))))
}

impl Finding {
    pub fn new(check: &'static str, verdict: Verdict, says: impl Into<String>) -> Finding {
        Finding { check, verdict, says: says.into(), figures: Vec::new() }
    }

    #[must_use]
    pub fn with(mut self, figures: &[(&'static str, f64)]) -> Finding {
        self.figures.extend_from_slice(figures);
        self
    }
}

pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 10.0 { format!("{percent:.0}%") } else { format!("{percent:.2}%") }
}

/// Joins words: `a`, `a and b`, `a, b and c`.
pub(super) fn listed(words: &[String], last: &str) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [most @ .., end] => format!("{} {last} {end}", most.join(", ")),
    }
}
