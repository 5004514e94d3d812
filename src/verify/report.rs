//! Results of hard cases, and the table row of each pipeline.

use serde::Serialize;

use crate::case::{Bound, Family, HardCase, Measured, number};
use footage::json;

pub(super) const CONDITION: &str = "condition number";

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseReport {
    pub name: String,
    pub family: Family,
    pub pipeline: String,
    pub unit: &'static str,
    #[serde(flatten)]
    pub bound: Bound,
    #[serde(serialize_with = "json::number")]
    pub measured: f64,
    pub place: Option<String>,
    pub note: Option<String>,
    pub streams: usize,
    pub pictures: usize,
    pub seconds: f64,
}

impl CaseReport {
    pub fn new(case: &HardCase, measured: &Measured, seconds: f64) -> CaseReport {
        CaseReport {
            name: case.name.clone(),
            family: case.family,
            pipeline: case.pipeline.clone(),
            unit: case.unit,
            bound: case.bound,
            measured: measured.figure,
            place: measured.place.clone(),
            note: measured.note.clone(),
            streams: measured.inputs.clips.len(),
            pictures: measured.inputs.picture_count(),
            seconds,
        }
    }

    pub fn passed(&self) -> bool {
        self.bound.holds(self.measured)
    }

    pub fn sentence(&self) -> String {
        let verdict = if self.passed() { "" } else { " FAILED" };
        let place = self.place.as_ref().map_or(String::new(), |place| format!(", {place}"));
        let (family, measured) = (self.family.name(), number(self.measured));
        format!("{family}: {} ({}): {measured} {}, {}{verdict}{place}", self.name, self.pipeline, self.unit, self.bound)
    }
}

/// A case measured on the CPU and, if it has streams or pictures, decoded or rendered on a device.
#[derive(Debug, Serialize)]
pub struct CaseRow<'a> {
    #[serde(flatten)]
    case: &'a CaseReport,
    device: Option<&'a str>,
    mismatched_words: Option<u64>,
    passed: bool,
}

impl<'a> CaseRow<'a> {
    pub fn new(case: &'a CaseReport, device: Option<&'a str>, mismatched_words: Option<u64>) -> CaseRow<'a> {
        let passed = case.passed() && mismatched_words.is_none_or(|words| words == 0);
        CaseRow { case, device, mismatched_words, passed }
    }
}

#[derive(Debug, Clone)]
pub struct FamilyRow<'a> {
    pub cases: usize,
    pub failed: usize,
    /// Case that is closest to its bound; the first of equals.
    pub worst: &'a CaseReport,
}

#[derive(Debug, Serialize)]
pub struct FamilyReport<'a> {
    family: &'static str,
    pipeline: &'a str,
    cases: usize,
    failed: usize,
    worst: &'a str,
    bound: String,
    measured: String,
    unit: &'static str,
}

impl<'a> FamilyRow<'a> {
    pub fn report(&self) -> FamilyReport<'a> {
        FamilyReport {
            family: self.worst.family.name(),
            pipeline: &self.worst.pipeline,
            cases: self.cases,
            failed: self.failed,
            worst: &self.worst.name,
            bound: self.worst.bound.to_string(),
            measured: number(self.worst.measured),
            unit: self.worst.unit,
        }
    }
}

pub fn family_rows(reports: &[CaseReport]) -> Vec<FamilyRow<'_>> {
    let mut rows: Vec<FamilyRow<'_>> = Vec::new();
    for report in reports {
        let same = |row: &&mut FamilyRow<'_>| {
            let known = row.worst;
            (known.family, &known.pipeline, known.unit) == (report.family, &report.pipeline, report.unit)
        };
        let failed = usize::from(!report.passed());
        let Some(row) = rows.iter_mut().find(same) else {
            rows.push(FamilyRow { cases: 1, failed, worst: report });
            continue;
        };
        row.cases += 1;
        row.failed += failed;
        if report.bound.share(report.measured) > row.worst.bound.share(row.worst.measured) {
            row.worst = report;
        }
    }
    rows
}

/// Returns notes, one line each: of the case that each row shows, and of all condition numbers.
pub fn notes(reports: &[CaseReport]) -> Vec<String> {
    let rows = family_rows(reports);
    let shown = |report: &CaseReport| rows.iter().any(|row| std::ptr::eq(row.worst, report));
    let line = |report: &CaseReport| {
        let note = report.note.as_ref().filter(|_| report.unit == CONDITION || shown(report))?;
        Some(format!("{}, {}: {note}", report.pipeline, report.name))
    };
    reports.iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_shows_the_case_that_is_closest_to_its_bound() {
        let report = |name: &str, bound, measured| CaseReport {
            name: name.into(),
            family: Family::Fits,
            pipeline: "p".into(),
            bound,
            measured,
            unit: "codes",
            place: None,
            note: None,
            streams: 0,
            pictures: 0,
            seconds: 0.0,
        };
        let reports = [
            report("a", Bound::AtMost(10.0), 4.0),
            report("b", Bound::AtMost(100.0), 99.0),
            report("c", Bound::AtMost(0.0), 0.0),
        ];
        let rows = family_rows(&reports);
        assert_eq!((rows.len(), rows[0].cases, rows[0].failed, rows[0].worst.name.as_str()), (1, 3, 0, "b"));
        let noted = |report: &CaseReport, unit| CaseReport { note: Some("n".into()), unit, ..report.clone() };
        let mut all = vec![noted(&reports[0], "codes"), noted(&reports[1], "codes")];
        all.extend([noted(&reports[2], CONDITION), noted(&reports[0], CONDITION)]);
        assert_eq!(notes(&all), ["p, b: n", "p, c: n", "p, a: n"], "not of the first, which no row shows");
        let broken = [reports[1].clone(), report("d", Bound::AtMost(0.0), 1.0)];
        let said = broken[1].sentence();
        assert!(said.starts_with("fits: d (p)") && said.contains("1 codes, <= 0 FAILED"), "{said}");
        assert_eq!((family_rows(&broken)[0].failed, family_rows(&broken)[0].worst.name.as_str()), (1, "d"));
    }
}
