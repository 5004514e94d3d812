//! Checks kind and scale of depth, positions and orientations by reprojection between probes.
//!
//! A surface of one probe may be hidden from another, but not seen through. Under a true hypothesis hardly any sample
//! contradicts; under a false one many do, or hardly any agrees because all are hidden.

use rayon::prelude::*;

use super::finding::{Finding, Verdict, listed, percent};
use super::hypotheses::{Alternative, Extent, Hypothesis, Pose, Subject, alternatives};
use super::probe_samples::ProbeSamples;
use super::reproject::{Tally, look_up, look_up_all};
use crate::dataset::{DepthKind, Projection};
use crate::error::Result;
use crate::monitor::Monitor;

/// Finding about planar depth or distance.
pub const KIND: &str = "depth.kind";
/// Fewer compared samples are inconclusive.
const MIN_TESTED: u64 = 200;
/// A hypothesis with this share of contradictions is doubtful: ten times that of true ones on rendered datasets.
const DOUBTFUL: f64 = 0.02;
/// The same for the pairs of a single probe.
const DOUBTFUL_PROBE: f64 = 0.04;
/// So is one with less agreement: everything hides everything.
const AGREES_TOO_LITTLE: f64 = 0.02;
/// Where nothing contradicts but little agrees, as between probes around an object, another hypothesis must reach this
/// agreement to be preferred: any that brings surfaces together makes some agree by chance.
const FAIR_SHARE: f64 = 0.2;
/// Ratio of misfits from which a hypothesis is preferred.
pub const DECISIVE: f64 = 3.0;
/// Hypotheses within this ratio of the least misfit are equally good.
const AS_GOOD: f64 = 1.3;
/// Share attributed to chance.
const CHANCE: f64 = 0.005;
/// Limit of simultaneous mistakes.
const MAX_MISTAKES: usize = 3;
/// Up to this many probes, all pairs are compared.
const ALL_PAIRS: usize = 6;
/// Beyond, each probe with this many nearest ones.
const NEIGHBOURS: usize = 4;

/// Ratio of contradiction to agreement: about 0.01 for a true hypothesis.
pub fn misfit(tally: &Tally) -> f64 {
    (tally.contradiction() + CHANCE) / (tally.agreement() + CHANCE / 10.0)
}

fn doubtful(tally: &Tally) -> bool {
    tally.contradiction() >= DOUBTFUL || tally.agreement() < AGREES_TOO_LITTLE
}

/// Probes and the pairs to compare.
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
    let poses = probes.iter().map(|view| Pose { position: view.position, turn: view.turn }).collect();
    let base = Hypothesis { kind, scale: 1.0, poses };
    let names = probes.iter().map(|view| view.name.clone()).collect();
    Comparison { probes, pairs, names, projection, monitor }.judge(&base)
}

/// Ordered pairs of probes of one frame.
fn pairs_of(probes: &[ProbeSamples]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for a in 0..probes.len() {
        let mut others: Vec<usize> =
            (0..probes.len()).filter(|b| *b != a && probes[*b].frame == probes[a].frame).collect();
        if probes.len() > ALL_PAIRS {
            let distance = |b: &usize| probes[*b].position.distance(probes[a].position);
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
    fn tally(&self, hypothesis: &Hypothesis) -> Tally {
        self.pairs.iter().map(|pair| look_up(self.probes, *pair, hypothesis)).sum()
    }

    /// The tally of each alternative.
    fn tallies(&self, alternatives: &[Alternative]) -> Result<Vec<Tally>> {
        self.monitor.check()?;
        let tallies = alternatives.par_iter().map(|alternative| self.tally(&alternative.hypothesis)).collect();
        self.monitor.check()?;
        Ok(tallies)
    }

    fn judge(&self, base: &Hypothesis) -> Result<Vec<Finding>> {
        let own = look_up_all(self.probes, &self.pairs, base);
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
        let of_probe = |probe: usize| -> Tally {
            self.pairs.iter().zip(&own).filter(|(pair, _)| pair.contains(&probe)).map(|(_, tally)| *tally).sum()
        };
        let alone = |tally: &Tally| tally.tested() >= MIN_TESTED && tally.contradiction() >= DOUBTFUL_PROBE;
        if doubtful(&all) || (0..self.probes.len()).any(|probe| alone(&of_probe(probe))) {
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

    /// The finding about a subject that nothing contradicts: fine where all alternatives would be contradicted.
    fn confirm(&self, subject: Subject, own: &Tally, others: Vec<(&Alternative, &Tally)>) -> Option<Finding> {
        let (next, tally) = others.into_iter().min_by(|a, b| misfit(a.1).total_cmp(&misfit(b.1)))?;
        let margin = misfit(tally) / misfit(own);
        let figures =
            [("margin", margin), ("next_agree", tally.agreement()), ("next_seen_through", tally.contradiction())];
        let check = name_of(subject);
        let finding = if margin >= DECISIVE {
            let says = format!(
                "{} of the samples of other probes agree and {} are seen through; with {}: {} and {}",
                percent(own.agreement()),
                percent(own.contradiction()),
                next.words,
                percent(tally.agreement()),
                percent(tally.contradiction()),
            );
            Finding::new(check, Verdict::Fine, says)
        } else {
            let says = format!("nothing contradicts the manifest, but {} would fit nearly as well", next.words);
            Finding::new(check, Verdict::CannotTell, says)
        };
        Some(finding.with(&figures))
    }

    /// Searches for the mistake where probes contradict each other.
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
            // A single misplaced probe explains it better where all others agree better than under the best alternative.
            if steps.is_empty() && odd.as_ref().is_some_and(|(_, misfit)| *misfit * AS_GOOD <= best) {
                break;
            }
            let good: Vec<usize> =
                (0..alternatives.len()).filter(|at| misfit(&tallies[*at]) <= best * AS_GOOD).collect();
            let Some(&first) = good.first() else { break };
            // Of equally good scales, the most common.
            let most = if alternatives[first].subject == Subject::Scale { 1 } else { 3 };
            let words: Vec<String> = good.iter().take(most).map(|at| alternatives[*at].words.clone()).collect();
            steps.push((alternatives[first].subject, listed(&words, "or")));
            (hypothesis, tally) = (alternatives[first].hypothesis.clone(), tallies[first]);
        }
        let mut figures = figures.to_vec();
        if !steps.is_empty() && all.contradiction() < DOUBTFUL && tally.agreement() < FAIR_SHARE {
            figures.extend([("next_agree", tally.agreement()), ("next_seen_through", tally.contradiction())]);
            let words: Vec<&str> = steps.iter().map(|(_, words)| words.as_str()).collect();
            let says = format!(
                "{what}, which is inconclusive; with {}: {} and {}, hardly more",
                words.join(" together with "),
                percent(tally.contradiction()),
                percent(tally.agreement())
            );
            return Ok(vec![Finding::new("probes", Verdict::CannotTell, says).with(&figures)]);
        }
        if steps.is_empty() {
            let finding = match odd {
                Some((probe, misfit_without)) => {
                    figures.push(("margin", misfit(&all) / misfit_without));
                    let says = format!(
                        "probe {} contradicts the others, which agree with each other: check its position, orientation \
                         and files",
                        self.names[probe]
                    );
                    Finding::new("positions", Verdict::Suspect, says)
                }
                None if all.contradiction() >= 5.0 * DOUBTFUL => {
                    let says = format!("{what}, and no common mistake explains it");
                    Finding::new("probes", Verdict::Suspect, says)
                }
                None => {
                    let says = format!("{what}, as in noisy depth, and no common mistake explains it");
                    Finding::new("probes", Verdict::CannotTell, says)
                }
            };
            return Ok(vec![finding.with(&figures)]);
        }
        figures.extend([
            ("margin", misfit(&all) / misfit(&tally)),
            ("next_agree", tally.agreement()),
            ("next_seen_through", tally.contradiction()),
        ]);
        let findings = steps.iter().enumerate().map(|(at, (subject, words))| {
            let others: Vec<&str> =
                steps.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, step)| step.1.as_str()).collect();
            let also =
                if others.is_empty() { String::new() } else { format!(", together with {}", others.join(" and ")) };
            let says = format!(
                "{what}; with {words}{also}: {} and {}",
                percent(tally.contradiction()),
                percent(tally.agreement())
            );
            Finding::new(name_of(*subject), Verdict::Suspect, says).with(&figures)
        });
        Ok(findings.collect())
    }

    /// The probe without which the others agree, and their misfit.
    fn odd_one_out(&self, own: &[Tally], misfit_of_all: f64) -> Option<(usize, f64)> {
        if self.probes.len() < 3 {
            return None;
        }
        let without = |probe: usize| -> Tally {
            self.pairs.iter().zip(own).filter(|(pair, _)| !pair.contains(&probe)).map(|(_, tally)| *tally).sum()
        };
        let (probe, tally) = (0..self.probes.len())
            .map(|probe| (probe, without(probe)))
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
