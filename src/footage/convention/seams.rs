//! Checks order and orientation of cube faces: neighbouring faces must have the same content along their common edge.
//!
//! Edges distinguish neither planar depth from distance, nor a cube from the same cube rotated or mirrored as a whole.

use super::borders::{Borders, Edge, FaceSide, Mismatch, edges, mismatch};
use super::face_permutation::{self, CostTable, FacePermutation, Fit, PlacedFile, Turn};
use super::finding::{Finding, Verdict, listed, percent};
use codec::image::Face;

pub const DEPTH: Stream = Stream { check: "seams.depth", cap: 0.1 };
pub const COLOR: Stream = Stream { check: "seams.color", cap: 0.7 };
/// Minimum ratio of the cost of the declared permutation to that of a permutation that is preferred to it.
const DECISIVE: f64 = 3.0;
/// Minimum decrease of the mismatch of a preferred permutation, as a share of the samples.
const MIN_GAIN: f64 = 0.1;
/// With fewer samples the check is inconclusive.
const MIN_SAMPLES: u64 = 32;
/// The orientation of a face is certain if every other orientation costs at least this many samples more.
const SURE: f64 = 8.0;
/// Permutations with a cost within this factor of the lowest are equally good.
const AS_GOOD: f64 = 1.2;

/// Borders of the faces of one probe, indexed by face.
pub type CubeBorders = [Option<Borders>; 6];

#[derive(Debug, Clone, Copy)]
pub struct Stream {
    pub check: &'static str,
    /// Values whose ratio is e^`cap` or more have the maximum mismatch.
    pub cap: f64,
}

/// Checks the edges of all probes together, then of each probe separately.
pub fn check(stream: Stream, probes: &[(String, CubeBorders)]) -> Vec<Finding> {
    let present: [bool; 6] = std::array::from_fn(|face| probes.iter().any(|(_, borders)| borders[face].is_some()));
    if present.iter().filter(|present| **present).count() < 2 {
        return vec![Finding::new(stream.check, Verdict::CannotTell, "fewer than two faces are present")];
    }
    let all = judge(stream, probes, present);
    if all.verdict != Verdict::Fine || probes.len() == 1 {
        return vec![all];
    }
    // An error of one of many probes is invisible in the sum.
    let mut findings: Vec<Finding> = probes
        .iter()
        .map(|probe| (probe, judge(stream, std::slice::from_ref(probe), present)))
        .filter(|(_, finding)| finding.verdict == Verdict::Suspect)
        .map(|((name, _), finding)| Finding { says: format!("probe {name}: {}", finding.says), ..finding })
        .collect();
    if findings.is_empty() {
        findings.push(all);
    }
    findings
}

fn judge(stream: Stream, probes: &[(String, CubeBorders)], present: [bool; 6]) -> Finding {
    let pair = |&Edge { a, b, reversed }: &Edge| -> Mismatch {
        let of = |(_, borders): &(String, CubeBorders)| {
            let of = |at: FaceSide| borders[at.face].as_ref()?.sides.get(at.side);
            let (a, b) = (of(a)?, of(b)?);
            Some(mismatch(a, b, reversed, stream.cap))
        };
        probes.iter().filter_map(of).fold(Mismatch::default(), Mismatch::add)
    };
    let table = CostTable::new(|edge| pair(edge).cost);
    let samples: u64 = edges().iter().map(|edge| pair(edge).samples).sum();
    let declared = face_permutation::declared(present);
    let own = table.total(&declared);
    let share = |cost: f64| cost / samples.max(1) as f64;
    let Fit { permutation: best, cost: least } = table.best(present);
    let figures = [
        ("mismatch", share(own)),
        ("best_mismatch", share(least)),
        ("margin", own / least.max(1e-9 + samples as f64 * 1e-3)),
        ("samples", samples as f64),
    ];
    let finding = if samples < MIN_SAMPLES {
        Finding::new(stream.check, Verdict::CannotTell, "hardly any surface reaches an edge of a face")
    } else if own >= DECISIVE * least && share(own - least) >= MIN_GAIN {
        Finding::new(stream.check, Verdict::Suspect, explain(&table, &best, least, present, share(own)))
    } else {
        settle(stream, &table, present, least)
    };
    finding.with(&figures)
}

/// Creates the finding if no permutation fits much better than the declared one.
fn settle(stream: Stream, table: &CostTable, present: [bool; 6], least: f64) -> Finding {
    let declared = face_permutation::declared(present);
    let own = table.total(&declared);
    let sure = |face: &usize| {
        Turn::all().filter(|turn| *turn != Turn::NONE).all(|turn| {
            let mut other = declared;
            other[*face] = Some(PlacedFile { file: *face, turn });
            table.total(&other) - own >= SURE.max(own * 0.05)
        })
    };
    let there: Vec<usize> = (0..6).filter(|face| present[*face]).collect();
    let unsure: Vec<usize> = there.iter().copied().filter(|face| !sure(face)).collect();
    let differ = "faces continue each other as declared";
    let (verdict, says) = if own > AS_GOOD * least + SURE {
        (Verdict::CannotTell, "another order of the faces fits slightly better, which is inconclusive".to_owned())
    } else if unsure.len() == there.len() {
        (Verdict::CannotTell, format!("{differ}, and would in other orientations, too"))
    } else if unsure.is_empty() {
        (Verdict::Fine, format!("{differ}, and in no other orientation"))
    } else {
        let names: Vec<String> = unsure.iter().map(|face| Face::CUBE[*face].name().to_owned()).collect();
        (Verdict::Fine, format!("{differ}; the orientation of {} is unknown", listed(&names, "and")))
    };
    Finding::new(stream.check, verdict, says)
}

/// Describes the simplest permutation that fits as well as the best one.
fn explain(table: &CostTable, best: &FacePermutation, least: f64, present: [bool; 6], mismatch: f64) -> String {
    let as_good = |permutation: &FacePermutation| table.total(permutation) <= least * AS_GOOD + 1e-6;
    let whole = present.iter().all(|present| *present);
    let mut candidates = few_changes(present);
    if whole {
        candidates.extend(face_permutation::symmetric(best));
    }
    candidates.retain(as_good);
    let effort = |candidate: &&FacePermutation| {
        let turned = candidate.iter().flatten().filter(|placed| placed.turn != Turn::NONE).count();
        (face_permutation::changed(candidate).len(), turned)
    };
    let simplest = candidates.iter().min_by_key(effort).unwrap_or(best);
    let mut words = vec![in_words(simplest)];
    let mirrored = Turn::all().skip(1).map(|turn| (turn, face_permutation::all_turned(present, turn)));
    for (turn, all) in mirrored.filter(|(_, all)| as_good(all) && all != simplest) {
        if whole && face_permutation::changed(&all).len() > face_permutation::changed(simplest).len() {
            words.push(format!("every face is {}", turn.words()));
        }
    }
    words.truncate(3);
    let (share, words) = (percent(mismatch), listed(&words, "or"));
    format!("faces do not match along their edges ({share} of the samples differ): {words}")
}

/// Returns the permutations with one file turned, or two files exchanged and turned.
fn few_changes(present: [bool; 6]) -> Vec<FacePermutation> {
    let declared = face_permutation::declared(present);
    let there: Vec<usize> = (0..6).filter(|face| present[*face]).collect();
    let mut found = Vec::new();
    for &face in &there {
        for turn in Turn::all() {
            let mut other = declared;
            other[face] = Some(PlacedFile { file: face, turn });
            found.push(other);
        }
    }
    for (at, &a) in there.iter().enumerate() {
        for &b in &there[at + 1..] {
            for (turn_a, turn_b) in Turn::all().flat_map(|x| Turn::all().map(move |y| (x, y))) {
                let mut other = declared;
                other[a] = Some(PlacedFile { file: b, turn: turn_a });
                other[b] = Some(PlacedFile { file: a, turn: turn_b });
                found.push(other);
            }
        }
    }
    found
}

/// Describes a permutation, such as `px and nx are exchanged and py is turned by 180 degrees`.
fn in_words(permutation: &FacePermutation) -> String {
    let mut words = Vec::new();
    let mut left = face_permutation::changed(permutation);
    while let Some(face) = left.first().copied() {
        left.remove(0);
        let Some(PlacedFile { file, turn }) = permutation[face] else { continue };
        let name = |face: usize| Face::CUBE[face].name();
        if file == face {
            words.push(format!("{} is {}", name(face), turn.words()));
            continue;
        }
        match permutation[file] {
            Some(PlacedFile { file: back, turn: other }) if back == face => {
                left.retain(|other| *other != file);
                let turned = match (turn, other) {
                    (Turn::NONE, Turn::NONE) => String::new(),
                    (x, y) if x == y => format!(", each {}", x.words()),
                    (x, y) => format!(", {} {} and {} {}", name(file), x.words(), name(face), y.words()),
                };
                words.push(format!("{} and {} are exchanged{turned}", name(face), name(file)));
            }
            _ if turn == Turn::NONE => words.push(format!("the file of {} is the face {}", name(file), name(face))),
            _ => words.push(format!("the file of {} is the face {}, {}", name(file), name(face), turn.words())),
        }
    }
    listed(&words, "and")
}
