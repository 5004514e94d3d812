//! Findings of papers, as tested on the points of a sweep.

use serde::{Serialize, Serializer};

/// Outcome of testing a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The points agree.
    Found,
    /// The points disagree.
    NotFound,
    /// The points do not tell.
    NotMeasured,
}

impl Verdict {
    /// `found`, `not found` or `not measured`.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Found => "found",
            Verdict::NotFound => "not found",
            Verdict::NotMeasured => "not measured",
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.name().serialize(to)
    }
}

/// A finding of a paper, tested.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub name: &'static str,
    /// What the paper found, and where.
    pub sentence: &'static str,
    /// Whether the points agree.
    pub verdict: Verdict,
    pub rule: &'static str,
    /// The values that it was judged by, a sentence; or what would have to be measured.
    pub rests_on: String,
}
