//! Checks kind and scale of depth, positions and orientations by reprojection between probes.
//!
//! A surface of one probe may be hidden from another probe, but must not be seen through. Under a correct hypothesis few samples
//! contradict this; under a wrong one many do, or few agree because almost all are hidden.

use rayon::prelude::*;

use super::finding::{Finding, Verdict, listed, percent};
use super::hypotheses::{Alternative, Extent, Hypothesis, Subject, alternatives};
use super::probe_samples::ProbeSamples;
use super::reproject::{Tally, look_up};
use crate::dataset::{DepthKind, Projection};
use codec::error::Result;
use codec::monitor::Monitor;

pub const KIND: &str = "depth.kind";
/// With fewer compared samples the check is inconclusive.
const MIN_TESTED: u64 = 200;
/// A hypothesis with this share of contradictions is doubtful. Correct ones have a tenth of it on rendered datasets.
const DOUBTFUL: f64 = 0.02;
/// As [`DOUBTFUL`], for the pairs of a single probe.
const DOUBTFUL_PROBE: f64 = 0.04;
/// A hypothesis with less agreement than this share is doubtful, because almost all samples are hidden.
const AGREES_TOO_LITTLE: f64 = 0.02;
/// Minimum agreement of a preferred hypothesis if there are few contradictions but little agreement, as between probes around an
/// object. Any hypothesis that moves surfaces together makes some samples agree by chance.
const FAIR_SHARE: f64 = 0.2;
/// Minimum ratio of misfits for a hypothesis to be preferred.
pub const DECISIVE: f64 = 3.0;
/// Hypotheses with a misfit within this ratio of the lowest are equally good.
const AS_GOOD: f64 = 1.3;
/// Share of contradictions attributed to chance.
const CHANCE: f64 = 0.005;
/// Maximum number of simultaneous mistakes.
const MAX_MISTAKES: usize = 3;
/// Maximum number of probes for which all pairs are compared.
const ALL_PAIRS: usize = 6;
/// With more probes, each is compared with this many nearest ones.
const NEIGHBOURS: usize = 4;

/// Returns the ratio of contradiction to agreement, about 0.01 for a correct hypothesis.
pub fn misfit(tally: &Tally) -> f64 {
    (tally.contradiction() + CHANCE) / (tally.agreement() + CHANCE / 10.0)
}

fn doubtful(tally: &Tally) -> bool {
    tally.contradiction() >= DOUBTFUL || tally.agreement() < AGREES_TOO_LITTLE
}

/// Formats the shares of the samples that contradict and that agree.
fn shares(tally: &Tally) -> String {
    format!("{} and {}", percent(tally.contradiction()), percent(tally.agreement()))
}

/// Figures of the next best hypothesis.
fn next_figures(tally: &Tally) -> [(&'static str, f64); 2] {
    [("next_agree", tally.agreement()), ("next_seen_through", tally.contradiction())]
}

struct Comparison<'a> {
    probes: &'a [ProbeSamples],
    pairs: Vec<[usize; 2]>,
    names: Vec<String>,
    projection: Projection,
    monitor: &'a dyn Monitor,
}

/// Compares all probes under the declared kind of depth.
pub fn check(
    probes: &[ProbeSamples],
    kind: DepthKind,
    projection: Projection,
    monitor: &dyn Monitor,
) -> Result<Vec<Finding>> {
    let pairs = pairs_of(probes);
    if pairs.is_empty() {
        let says = if probes.len() < 2 {
            "scale and positions need two probes"
        } else {
            "no two probes have depth in the same frame"
        };
        return Ok(vec![Finding::new("probes", Verdict::CannotTell, says)]);
    }
    let names = probes.iter().map(|view| view.name.clone()).collect();
    Comparison { probes, pairs, names, projection, monitor }.judge(&Hypothesis::declared(kind, probes))
}

/// Returns the ordered pairs of probes with depth in the same frame.
fn pairs_of(probes: &[ProbeSamples]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for a in 0..probes.len() {
        let mut others: Vec<usize> =
            (0..probes.len()).filter(|b| *b != a && probes[*b].frame == probes[a].frame).collect();
        if probes.len() > ALL_PAIRS {
            let distance = |b: &usize| probes[*b].pose.position.distance(probes[a].pose.position);
            others.sort_by(|x, y| distance(x).total_cmp(&distance(y)).then(x.cmp(y)));
            others.truncate(NEIGHBOURS);
        }
        pairs.extend(others.into_iter().flat_map(|b| [[a, b], [b, a]]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

impl Comparison<'_> {
    fn tallies(&self, alternatives: &[Alternative]) -> Result<Vec<Tally>> {
        self.monitor.check()?;
        let of_pairs = |hypothesis| self.pairs.iter().map(|pair| look_up(self.probes, *pair, hypothesis)).sum();
        let tallies = alternatives.par_iter().map(|alternative| of_pairs(&alternative.hypothesis)).collect();
        self.monitor.check()?;
        Ok(tallies)
    }

    /// Returns the sum of the tallies of the selected pairs.
    fn total(&self, own: &[Tally], is_in: impl Fn(&[usize; 2]) -> bool) -> Tally {
        self.pairs.iter().zip(own).filter(|(pair, _)| is_in(pair)).map(|(_, tally)| *tally).sum()
    }

    fn judge(&self, base: &Hypothesis) -> Result<Vec<Finding>> {
        let own: Vec<Tally> = self.pairs.par_iter().map(|pair| look_up(self.probes, *pair, base)).collect();
        let all: Tally = own.iter().copied().sum();
        let figures = [
            ("agree", all.agreement()),
            ("seen_through", all.contradiction()),
            ("samples", all.tested() as f64),
            ("pairs", self.pairs.len() as f64),
        ];
        if all.tested() < MIN_TESTED {
            let says = format!("only {} samples of one probe are visible from another", all.tested());
            return Ok(vec![Finding::new("probes", Verdict::CannotTell, says).with(&figures)]);
        }
        let alone = |probe: usize| {
            let tally = self.total(&own, |pair| pair.contains(&probe));
            tally.tested() >= MIN_TESTED && tally.contradiction() >= DOUBTFUL_PROBE
        };
        if doubtful(&all) || (0..self.probes.len()).any(alone) {
            return self.explain(base, &own, &figures);
        }
        let alternatives = alternatives(base, &self.names, self.projection, Extent::Common);
        let tallies = self.tallies(&alternatives)?;
        let mut findings = Vec::new();
        for subject in [Subject::Kind, Subject::Scale, Subject::Positions, Subject::Orientations] {
            let of = alternatives.iter().zip(&tallies).filter(|(other, _)| other.subject == subject);
            findings.extend(self.confirm(subject, &all, of.collect()));
        }
        if let Some(first) = findings.first_mut() {
            first.figures.extend_from_slice(&figures);
        }
        Ok(findings)
    }

    /// Creates the finding about a subject without contradictions: fine if every alternative fits clearly worse.
    fn confirm(&self, subject: Subject, own: &Tally, others: Vec<(&Alternative, &Tally)>) -> Option<Finding> {
        let (next, tally) = others.into_iter().min_by(|a, b| misfit(a.1).total_cmp(&misfit(b.1)))?;
        let margin = misfit(tally) / misfit(own);
        let (verdict, says) = if margin >= DECISIVE {
            let says = format!(
                "{} of the samples of other probes agree and {} are seen through; with {}: {} and {}",
                percent(own.agreement()),
                percent(own.contradiction()),
                next.words,
                percent(tally.agreement()),
                percent(tally.contradiction()),
            );
            (Verdict::Fine, says)
        } else {
            let says = format!("nothing contradicts the manifest, but {} would fit nearly as well", next.words);
            (Verdict::CannotTell, says)
        };
        Some(Finding::new(name_of(subject), verdict, says).with(&[("margin", margin)]).with(&next_figures(tally)))
    }

    /// Searches for the mistake if probes contradict each other.
    fn explain(&self, base: &Hypothesis, own: &[Tally], figures: &[(&'static str, f64)]) -> Result<Vec<Finding>> {
        let all: Tally = own.iter().copied().sum();
        let what = format!(
            "{} of the samples of one probe are seen through by another and {} agree",
            percent(all.contradiction()),
            percent(all.agreement())
        );
        let (mut hypothesis, mut tally) = (base.clone(), all);
        let mut steps: Vec<(Subject, String)> = Vec::new();
        let odd = self.odd_one_out(own, misfit(&all));
        while steps.len() < MAX_MISTAKES && doubtful(&tally) {
            let alternatives = alternatives(&hypothesis, &self.names, self.projection, Extent::All);
            let tallies = self.tallies(&alternatives)?;
            let best = tallies.iter().map(misfit).fold(f64::INFINITY, f64::min);
            if best * DECISIVE > misfit(&tally) {
                break;
            }
            // One misplaced probe is the better explanation if the others agree better without it than under the best
            // alternative.
            if steps.is_empty() && odd.as_ref().is_some_and(|(_, misfit)| *misfit * AS_GOOD <= best) {
                break;
            }
            let good: Vec<usize> =
                (0..alternatives.len()).filter(|at| misfit(&tallies[*at]) <= best * AS_GOOD).collect();
            let Some(&first) = good.first() else { break };
            // Of equally good scales, report only the most common.
            let most = if alternatives[first].subject == Subject::Scale { 1 } else { 3 };
            let words: Vec<String> = good.iter().take(most).map(|at| alternatives[*at].words.clone()).collect();
            steps.push((alternatives[first].subject, listed(&words, "or")));
            (hypothesis, tally) = (alternatives[first].hypothesis.clone(), tallies[first]);
        }
        let mut figures = figures.to_vec();
        if !steps.is_empty() && all.contradiction() < DOUBTFUL && tally.agreement() < FAIR_SHARE {
            figures.extend(next_figures(&tally));
            let words: Vec<&str> = steps.iter().map(|(_, words)| words.as_str()).collect();
            let words = words.join(" together with ");
            let says = format!("{what}, which is inconclusive; with {words}: {}, hardly more", shares(&tally));
            return Ok(vec![Finding::new("probes", Verdict::CannotTell, says).with(&figures)]);
        }
        if steps.is_empty() {
            let unexplained = "no common mistake explains it";
            let (check, verdict, says) = match odd {
                Some((probe, misfit_without)) => {
                    figures.push(("margin", misfit(&all) / misfit_without));
                    let says = format!(
                        "probe {} contradicts the others, which agree with each other: check its position, orientation \
                         and files",
                        self.names[probe]
                    );
                    ("positions", Verdict::Suspect, says)
                }
                None if all.contradiction() >= 5.0 * DOUBTFUL => {
                    ("probes", Verdict::Suspect, format!("{what}, and {unexplained}"))
                }
                None => ("probes", Verdict::CannotTell, format!("{what}, as in noisy depth, and {unexplained}")),
            };
            return Ok(vec![Finding::new(check, verdict, says).with(&figures)]);
        }
        figures.push(("margin", misfit(&all) / misfit(&tally)));
        figures.extend(next_figures(&tally));
        let findings = steps.iter().enumerate().map(|(at, (subject, words))| {
            let others: Vec<&str> =
                steps.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, step)| step.1.as_str()).collect();
            let also =
                if others.is_empty() { String::new() } else { format!(", together with {}", others.join(" and ")) };
            let says = format!("{what}; with {words}{also}: {}", shares(&tally));
            Finding::new(name_of(*subject), Verdict::Suspect, says).with(&figures)
        });
        Ok(findings.collect())
    }

    /// Returns the probe without which the others agree, and their misfit.
    fn odd_one_out(&self, own: &[Tally], misfit_of_all: f64) -> Option<(usize, f64)> {
        if self.probes.len() < 3 {
            return None;
        }
        let (probe, tally) = (0..self.probes.len())
            .map(|probe| (probe, self.total(own, |pair| !pair.contains(&probe))))
            .min_by(|a, b| misfit(&a.1).total_cmp(&misfit(&b.1)))?;
        let enough = tally.tested() >= MIN_TESTED && !doubtful(&tally) && misfit(&tally) * 2.0 <= misfit_of_all;
        enough.then(|| (probe, misfit(&tally)))
    }
}

fn name_of(subject: Subject) -> &'static str {
    match subject {
        Subject::Kind => KIND,
        Subject::Scale => "depth.scale",
        Subject::Positions => "positions",
        Subject::Orientations => "orientations",
    }
}
