//! Findings of papers, as tested on the points of a sweep.

use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Verdict {
    #[serde(rename = "found")]
    Found,
    #[serde(rename = "not found")]
    NotFound,
    /// The points do not tell.
    #[serde(rename = "not measured")]
    NotMeasured,
}

impl Verdict {
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Found => "found",
            Verdict::NotFound => "not found",
            Verdict::NotMeasured => "not measured",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub name: &'static str,
    /// What the paper found, and where.
    pub sentence: &'static str,
    pub verdict: Verdict,
    pub rule: &'static str,
    /// The values that it was judged by, a sentence; or what would have to be measured.
    pub rests_on: String,
}
