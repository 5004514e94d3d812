//! Findings of papers, tested on the points of a sweep.

use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Verdict {
    #[serde(rename = "found")]
    Found,
    #[serde(rename = "not found")]
    NotFound,
    /// The points do not allow a verdict.
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
    /// Claim of the paper, with its location.
    pub sentence: &'static str,
    pub verdict: Verdict,
    pub rule: &'static str,
    /// Sentence with the values on which the verdict rests, or with what would have to be measured.
    pub rests_on: String,
}

/// Verdict of a test, before it is attached to its finding.
#[derive(Debug, Clone)]
pub struct Judged {
    pub verdict: Verdict,
    pub rests_on: String,
}

impl Judged {
    pub fn new(is_found: bool, rests_on: String) -> Judged {
        Judged { verdict: if is_found { Verdict::Found } else { Verdict::NotFound }, rests_on }
    }

    /// Returns `Found` if most rows satisfy a rule. `None` without rows. `rests_on` builds the sentence from the number
    /// of rows that do.
    pub fn majority<T>(
        rows: &[T],
        keeps: impl Fn(&T) -> bool,
        rests_on: impl FnOnce(usize) -> String,
    ) -> Option<Judged> {
        let kept = rows.iter().filter(|row| keeps(row)).count();
        (!rows.is_empty()).then(|| Judged::new(2 * kept > rows.len(), rests_on(kept)))
    }
}

/// Claim of a paper with the function that tests it. The function returns `None` if the data was not measured.
#[derive(Debug, Clone, Copy)]
pub struct Test<J> {
    pub name: &'static str,
    pub sentence: &'static str,
    pub rule: &'static str,
    /// Measurements that the test needs.
    pub needs: &'static str,
    pub judge: J,
}

impl<J> Test<J> {
    pub fn finding(&self, judged: Option<Judged>) -> Finding {
        let nothing = || Judged { verdict: Verdict::NotMeasured, rests_on: self.needs.to_owned() };
        let Judged { verdict, rests_on } = judged.unwrap_or_else(nothing);
        Finding { name: self.name, sentence: self.sentence, verdict, rule: self.rule, rests_on }
    }
}
