//! Kind and scale of depth, positions and orientations, from what probes see of each other's surfaces.
//!
//! A surface of one probe may be hidden from another, but the other cannot see through it. Under a true reading hardly any
//! sample contradicts; under a false one many do, or hardly any agrees because all is hidden.

use rayon::prelude::*;

use super::finding::{Finding, Verdict, listed, percent};
use super::readings::{Change, Extent, Subject, changes};
use super::reproject::{Pose, Reading, Tally, look_up, look_up_all};
use super::views::View;
use crate::dataset::{DepthKind, Projection};
use crate::error::Result;
use crate::monitor::Monitor;

/// Name of the finding about planar depth or distance.
pub const KIND: &str = "depth.kind";
/// Fewer samples that can be compared say nothing.
const MIN_TESTED: u64 = 200;
/// A reading under which so large a share is seen through is doubtful: ten times what true readings of renderings show.
const DOUBTFUL: f64 = 0.02;
/// The same for the pairs of a single probe.
const DOUBTFUL_PROBE: f64 = 0.04;
/// A reading under which no larger share agrees is doubtful, too: everything hides everything.
const AGREES_TOO_LITTLE: f64 = 0.02;
/// Where nothing is seen through but little agrees, as between probes around an object, which see different sides of it,
/// another reading must make so much agree to be preferred: any that brings surfaces together makes some agree by chance.
const FAIR_SHARE: f64 = 0.2;
/// By so much a reading must be better than another to be preferred.
pub const DECISIVE: f64 = 3.0;
/// Readings that are no worse than this fit as well as the best one.
const AS_GOOD: f64 = 1.3;
/// Share that is taken for chance.
const CHANCE: f64 = 0.005;
/// More mistakes at once are not looked for.
const MAX_CHANGES: usize = 3;
/// With at most so many probes, each is compared with each.
const ALL_PAIRS: usize = 6;
/// Else, each with so many near ones.
const NEIGHBOURS: usize = 4;

/// How badly a reading fits: seen through against agreeing. Around 0.01 where it is true.
pub fn misfit(tally: &Tally) -> f64 {
    (tally.contradiction() + CHANCE) / (tally.agreement() + CHANCE / 10.0)
}

fn doubtful(tally: &Tally) -> bool {
    tally.contradiction() >= DOUBTFUL || tally.agreement() < AGREES_TOO_LITTLE
}

/// The work of comparing probes.
struct Comparison<'a> {
    views: &'a [View],
    pairs: Vec<[usize; 2]>,
    names: Vec<String>,
    projection: Projection,
    monitor: &'a dyn Monitor,
}

/// Compares all views under the stated kind of depth.
///
/// # Errors
/// When the monitor is interrupted.
pub fn check(views: &[View], kind: DepthKind, projection: Projection, monitor: &dyn Monitor) -> Result<Vec<Finding>> {
    let pairs = pairs_of(views);
    if pairs.is_empty() {
        let says = if views.len() < 2 {
            "one probe alone shows nothing of scale and positions"
        } else {
            "no two probes have depth in the same frame"
        };
        return Ok(vec![Finding::new("probes", Verdict::CannotTell, says)]);
    }
    let poses = views.iter().map(|view| Pose { position: view.position, turn: view.turn }).collect();
    let base = Reading { kind, scale: 1.0, poses };
    let names = views.iter().map(|view| view.name.clone()).collect();
    Comparison { views, pairs, names, projection, monitor }.judge(&base)
}

/// Which probe is looked up in which: all in all where there are few, else in those that stand nearest.
fn pairs_of(views: &[View]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for a in 0..views.len() {
        let mut others: Vec<usize> =
            (0..views.len()).filter(|b| *b != a && views[*b].frame == views[a].frame).collect();
        if views.len() > ALL_PAIRS {
            let distance = |b: &usize| views[*b].position.distance(views[a].position);
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
    fn tally(&self, reading: &Reading) -> Tally {
        self.pairs.iter().map(|pair| look_up(self.views, *pair, reading)).sum()
    }

    /// A tally of each reading.
    fn tallies(&self, changes: &[Change]) -> Result<Vec<Tally>> {
        self.monitor.check()?;
        let tallies = changes.par_iter().map(|change| self.tally(&change.reading)).collect();
        self.monitor.check()?;
        Ok(tallies)
    }

    fn judge(&self, base: &Reading) -> Result<Vec<Finding>> {
        let own = look_up_all(self.views, &self.pairs, base);
        let all: Tally = own.iter().copied().sum();
        let figures = [
            ("agree", all.agreement()),
            ("seen_through", all.contradiction()),
            ("samples", all.tested() as f64),
            ("pairs", self.pairs.len() as f64),
        ];
        if all.tested() < MIN_TESTED {
            let says = format!("only {} points of one probe lie in sight of another", all.tested());
            return Ok(vec![Finding::new("probes", Verdict::CannotTell, says).with(&figures)]);
        }
        let of_probe = |probe: usize| -> Tally {
            self.pairs.iter().zip(&own).filter(|(pair, _)| pair.contains(&probe)).map(|(_, tally)| *tally).sum()
        };
        let alone = |tally: &Tally| tally.tested() >= MIN_TESTED && tally.contradiction() >= DOUBTFUL_PROBE;
        if doubtful(&all) || (0..self.views.len()).any(|probe| alone(&of_probe(probe))) {
            return self.explain(base, &own, &figures);
        }
        let changes = changes(base, &self.names, self.projection, Extent::Usual);
        let tallies = self.tallies(&changes)?;
        let mut findings = Vec::new();
        for subject in [Subject::Kind, Subject::Scale, Subject::Positions, Subject::Orientations] {
            let of = changes.iter().zip(&tallies).filter(|(change, _)| change.subject == subject);
            findings.extend(self.confirm(subject, &all, of.collect()));
        }
        if let Some(first) = findings.first_mut() {
            first.figures.extend_from_slice(&figures);
        }
        Ok(findings)
    }

    /// What is to be said of a reading that nothing contradicts: whether others would be contradicted.
    fn confirm(&self, subject: Subject, own: &Tally, others: Vec<(&Change, &Tally)>) -> Option<Finding> {
        let (next, tally) = others.into_iter().min_by(|a, b| misfit(a.1).total_cmp(&misfit(b.1)))?;
        let margin = misfit(tally) / misfit(own);
        let figures =
            [("margin", margin), ("next_agree", tally.agreement()), ("next_seen_through", tally.contradiction())];
        let check = name_of(subject);
        let finding = if margin >= DECISIVE {
            let says = format!(
                "{} of what probes could see of each other agrees and {} is seen through; {} it would be {} and {}",
                percent(own.agreement()),
                percent(own.contradiction()),
                next.words,
                percent(tally.agreement()),
                percent(tally.contradiction()),
            );
            Finding::new(check, Verdict::Fine, says.replace("; ", "; reading "))
        } else {
            let says =
                format!("nothing contradicts what is declared, but reading {} would fit nearly as well", next.words);
            Finding::new(check, Verdict::CannotTell, says)
        };
        Some(finding.with(&figures))
    }

    /// Looks for what is wrong where probes contradict each other.
    fn explain(&self, base: &Reading, own: &[Tally], figures: &[(&'static str, f64)]) -> Result<Vec<Finding>> {
        let all: Tally = own.iter().copied().sum();
        let what = format!(
            "{} of what one probe shows is seen through by another and {} agrees",
            percent(all.contradiction()),
            percent(all.agreement())
        );
        let (mut reading, mut tally) = (base.clone(), all);
        let mut steps: Vec<(Subject, String)> = Vec::new();
        let odd = self.odd_one_out(own, misfit(&all));
        while steps.len() < MAX_CHANGES && doubtful(&tally) {
            let changes = changes(&reading, &self.names, self.projection, Extent::All);
            let tallies = self.tallies(&changes)?;
            let best = tallies.iter().map(misfit).fold(f64::INFINITY, f64::min);
            if best * DECISIVE > misfit(&tally) {
                break;
            }
            // A single probe that stands wrong is the better explanation where all others agree better than with that.
            if steps.is_empty() && odd.as_ref().is_some_and(|(_, misfit)| *misfit * AS_GOOD <= best) {
                break;
            }
            let good: Vec<usize> = (0..changes.len()).filter(|at| misfit(&tallies[*at]) <= best * AS_GOOD).collect();
            let Some(&first) = good.first() else { break };
            // Of scales that fit as well, the usual one.
            let most = if changes[first].subject == Subject::Scale { 1 } else { 3 };
            let words: Vec<String> = good.iter().take(most).map(|at| changes[*at].words.clone()).collect();
            steps.push((changes[first].subject, listed(&words, "or")));
            (reading, tally) = (changes[first].reading.clone(), tallies[first]);
        }
        let mut figures = figures.to_vec();
        if !steps.is_empty() && all.contradiction() < DOUBTFUL && tally.agreement() < FAIR_SHARE {
            figures.extend([("next_agree", tally.agreement()), ("next_seen_through", tally.contradiction())]);
            let words: Vec<&str> = steps.iter().map(|(_, words)| words.as_str()).collect();
            let says = format!(
                "{what}, too little to tell; reading {} it would be {} and {}, hardly more",
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
                        "probe {} contradicts the others, which agree with each other: look at its position, orientation \
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
                "{what}; reading {words}{also} it would be {} and {}",
                percent(tally.contradiction()),
                percent(tally.agreement())
            );
            Finding::new(name_of(*subject), Verdict::Suspect, says).with(&figures)
        });
        Ok(findings.collect())
    }

    /// The probe without which all others agree, and how badly those fit.
    fn odd_one_out(&self, own: &[Tally], misfit_of_all: f64) -> Option<(usize, f64)> {
        if self.views.len() < 3 {
            return None;
        }
        let without = |probe: usize| -> Tally {
            self.pairs.iter().zip(own).filter(|(pair, _)| !pair.contains(&probe)).map(|(_, tally)| *tally).sum()
        };
        let (probe, tally) = (0..self.views.len())
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
