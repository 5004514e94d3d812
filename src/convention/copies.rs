//! Images that are the same although they should not be, and images of nothing.
//!
//! Walls that are alike have the same depth from their middle, and a floor has it all along. So depth that is the same twice is
//! a copy only where colour is the same, too, or where what the two show does not lie where both would have it.

use std::collections::BTreeMap;

use super::finding::{Finding, Verdict};
use super::read::{Footage, Marked, Shows};
use super::reproject::{Pose, Reading, Tally, look_up};
use super::views::View;
use crate::dataset::{DepthKind, StreamKind};

/// Fewer samples of one face in sight of another say nothing of both.
const MIN_TESTED: u64 = 50;
/// Of surfaces that look the same to two probes, at least so much is seen by both in one place.
const IS_ONE_SURFACE: f64 = 0.5;

/// Looks for images that were copied or never made; `kind` is what depth is said to be.
pub fn check(footage: &Footage, kind: DepthKind) -> Vec<Finding> {
    let groups = equal_images(footage, Shows::Surfaces);
    let (alike, copied): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| are_alike(footage, group, kind));
    let mut findings = vec![match copied.first() {
        Some(group) => {
            let says = format!("{} are the same picture, pixel by pixel", names(group));
            let figures = [("copies", copied.len() as f64), ("alike", alike.len() as f64)];
            Finding::new("images", Verdict::Suspect, says).with(&figures)
        }
        None => no_copies(footage, &alike),
    }];
    if let Some(name) = footage.blank.first() {
        // A wall or a dome may be of one colour, too.
        let says = format!("{name} is of one colour, but its depth is not of one value: an image that was never made?");
        findings.push(Finding::new("images", Verdict::CannotTell, says).with(&[("blank", footage.blank.len() as f64)]));
    }
    findings
}

/// Images that are pixel by pixel the same, among those that show what is asked for.
fn equal_images(footage: &Footage, shows: Shows) -> Vec<Vec<&Marked>> {
    let mut by_mark: BTreeMap<u64, Vec<&Marked>> = BTreeMap::new();
    for image in footage.marked.iter().filter(|image| image.shows == shows) {
        by_mark.entry(image.mark).or_default().push(image);
    }
    let mut groups: Vec<Vec<&Marked>> = by_mark.into_values().filter(|group| group.len() > 1).collect();
    groups.sort_unstable_by(|a, b| a[0].name.cmp(&b[0].name));
    groups
}

fn names(group: &[&Marked]) -> String {
    let two: Vec<&str> = group.iter().take(2).map(|image| image.name.as_str()).collect();
    two.join(" and ")
}

/// Whether all images of a group may be of surfaces that are alike, and none a copy.
fn are_alike(footage: &Footage, group: &[&Marked], kind: DepthKind) -> bool {
    group.iter().enumerate().all(|(at, a)| group[at + 1..].iter().all(|b| may_be_alike(footage, a, b, kind)))
}

fn may_be_alike(footage: &Footage, a: &Marked, b: &Marked, kind: DepthKind) -> bool {
    if a.kind != StreamKind::Depth || b.kind != StreamKind::Depth {
        return false;
    }
    let color = |of: &Marked| {
        let is_it =
            |image: &&Marked| image.kind == StreamKind::Color && image.probe == of.probe && image.face == of.face;
        footage.marked.iter().find(is_it).map(|image| image.mark)
    };
    if color(a).is_some_and(|mark| color(b) == Some(mark)) {
        return false;
    }
    // Two faces of one probe show no point twice: whether depth is where it belongs is for the seams to say.
    if a.probe == b.probe {
        return true;
    }
    let (Some(from), Some(to)) = (alone(footage, a), alone(footage, b)) else { return false };
    let views = [from, to];
    let poses = views.iter().map(|view| Pose { position: view.position, turn: view.turn }).collect();
    let reading = Reading { kind, scale: 1.0, poses };
    let tally: Tally = [[0, 1], [1, 0]].into_iter().map(|pair| look_up(&views, pair, &reading)).sum();
    tally.tested() < MIN_TESTED || tally.agreement() >= IS_ONE_SURFACE
}

/// The view of an image's probe with its face alone.
fn alone(footage: &Footage, image: &Marked) -> Option<View> {
    let view = footage.views.iter().find(|view| view.name == image.probe)?;
    let face = view.faces.iter().find(|samples| samples.face == image.face)?;
    Some(View { faces: vec![face.clone()], name: view.name.clone(), ..*view })
}

/// What is to be said where no surface is shown twice: the same sky is seen from everywhere.
fn no_copies(footage: &Footage, alike: &[Vec<&Marked>]) -> Finding {
    let skies = equal_images(footage, Shows::Background);
    let unknown = equal_images(footage, Shows::Unknown);
    let figures = [
        ("copies", 0.0),
        ("alike", alike.len() as f64),
        ("equal_backgrounds", skies.len() as f64),
        ("equal_unknown", unknown.len() as f64),
    ];
    let finding = if let Some(group) = alike.first() {
        let says = format!(
            "{} are the same picture, as walls that are alike may be where colour is not the same, too",
            names(group)
        );
        Finding::new("images", Verdict::CannotTell, says)
    } else if let Some(group) = unknown.first() {
        let says = format!("{} are the same picture, as they may be where they show the sky alone", names(group));
        Finding::new("images", Verdict::CannotTell, says)
    } else if let Some(group) = skies.first() {
        let says = format!(
            "no two images of surfaces are the same; {} are, but have no depth that varies, as a sky",
            names(group)
        );
        Finding::new("images", Verdict::Fine, says)
    } else {
        Finding::new("images", Verdict::Fine, "no two images are the same")
    };
    finding.with(&figures)
}
