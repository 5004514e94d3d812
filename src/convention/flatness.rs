//! Planar depth or distance, from one probe alone: what is straight in the world.
//!
//! Along a row or a column of an image, 1/Z of a plane is linear, where Z is planar depth. Where distance is taken for Z, or
//! Z for distance, it is not. So among three samples in a row, many are in line under the true reading and few under
//! the other. A dome around the probe and a wall at right angles to the view cannot be told apart; values that do not
//! change are passed over.

use rayon::prelude::*;

use super::between_probes::DECISIVE;
use super::finding::{Finding, Verdict, percent};
use super::views::{Samples, View};
use crate::dataset::DepthKind;

/// Distances between the samples of a triple, on the plane at distance 1: short ones for what is small, long ones for
/// what is noisy.
const SPANS: [f64; 2] = [0.125, 0.25];
/// A triple is in line where 1/Z in its middle is that close to the mean of both ends, times the square of the span. Between
/// the two readings lie up to 0.5.
const STRAIGHT: f64 = 0.05;
/// Values that differ by no more than this share do not change.
const CONSTANT: f64 = 1e-4;
/// Fewer triples that are in line under one reading only say nothing.
const MIN_TRIPLES: u64 = 400;
/// The same as a share of all triples.
const MIN_SHARE: f64 = 0.02;

/// Triples of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Triples {
    /// All whose three samples show a surface and differ.
    pub all: u64,
    /// In line as distance only.
    pub distance: u64,
    /// In line as planar depth only.
    pub planar: u64,
}

impl Triples {
    fn add(self, other: Triples) -> Triples {
        Triples {
            all: self.all + other.all,
            distance: self.distance + other.distance,
            planar: self.planar + other.planar,
        }
    }
}

/// Counts the triples of a face, along rows and columns.
pub fn count(samples: &Samples) -> Triples {
    let (width, height) = (samples.stored.width(), samples.stored.height());
    // Stored depth, and 1/Z if it is a distance and if it is planar.
    let values = |x: u32, y: u32| -> Option<[f64; 3]> {
        let stored = f64::from(samples.stored.get(x, y));
        let factor = samples.to_distance(DepthKind::Planar, x, y);
        stored.is_finite().then(|| [stored, factor / stored, 1.0 / stored])
    };
    let mut found = Triples::default();
    for span in SPANS {
        let [step_x, step_y] = samples.spacing().map(|spacing| ((span / spacing).round() as u32).max(1));
        for (dx, dy) in [(step_x, 0), (0, step_y)] {
            let span = f64::from(dx) * samples.spacing()[0] + f64::from(dy) * samples.spacing()[1];
            for y in dy..height.saturating_sub(dy) {
                for x in dx..width.saturating_sub(dx) {
                    let ends = values(x - dx, y - dy).zip(values(x + dx, y + dy));
                    let Some((middle, (before, after))) = values(x, y).zip(ends) else { continue };
                    let change = (before[0] - middle[0]).abs().max((after[0] - middle[0]).abs());
                    if change <= CONSTANT * middle[0] {
                        continue;
                    }
                    let straight = |reading: usize| {
                        let bend = (before[reading] + after[reading]) / 2.0 - middle[reading];
                        bend.abs() <= STRAIGHT * span * span * middle[reading]
                    };
                    found.all += 1;
                    match (straight(1), straight(2)) {
                        (true, false) => found.distance += 1,
                        (false, true) => found.planar += 1,
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

/// Compares what is flat under both readings, over all views.
pub fn check(views: &[View], kind: DepthKind) -> Finding {
    let faces: Vec<&Samples> = views.iter().flat_map(|view| &view.faces).collect();
    let counts: Vec<Triples> = faces.into_par_iter().map(count).collect();
    let found = counts.into_iter().fold(Triples::default(), Triples::add);
    let (declared, other) = match kind {
        DepthKind::Distance => (found.distance, found.planar),
        DepthKind::Planar => (found.planar, found.distance),
    };
    let share = |count: u64| count as f64 / found.all.max(1) as f64;
    let margin = declared.max(other) as f64 / declared.min(other).max(1) as f64;
    let enough = |count: u64| count >= MIN_TRIPLES && share(count) >= MIN_SHARE;
    let (name, other_name) = match kind {
        DepthKind::Distance => ("distance", "planar depth"),
        DepthKind::Planar => ("planar depth", "distance"),
    };
    let shares = format!(
        "{} of the surfaces are straight as {name} only and {} as {other_name} only",
        percent(share(declared)),
        percent(share(other))
    );
    let (verdict, says) = if enough(declared) && declared > other && margin >= DECISIVE {
        (Verdict::Fine, shares)
    } else if enough(other) && other > declared && margin >= DECISIVE {
        (Verdict::Suspect, format!("{shares}: depth looks like {other_name}"))
    } else {
        (Verdict::CannotTell, format!("{shares}, which does not decide"))
    };
    Finding::new("depth.kind.flatness", verdict, says).with(&[
        ("straight_as_declared", share(declared)),
        ("straight_as_the_other", share(other)),
        ("margin", margin),
        ("samples", found.all as f64),
    ])
}
