//! Finds duplicate and blank images.
//!
//! Depth images may be equal without being duplicates: in front of the middle of similar walls, or anywhere above a floor. Equal
//! depth is therefore a duplicate only if colour is equal too, or if the surfaces of one image contradict those of the other.

use std::collections::BTreeMap;

use super::finding::{Finding, Verdict};
use super::hypotheses::Hypothesis;
use super::probe_samples::ProbeSamples;
use super::read::{Footage, HashedImage, Shows};
use super::reproject::{Tally, look_up};
use crate::dataset::{DepthKind, StreamKind};

/// With fewer samples of one face visible from the other, the comparison is inconclusive.
const MIN_TESTED: u64 = 50;
/// Minimum share of samples that agree between two probes that see the same surface.
const IS_ONE_SURFACE: f64 = 0.5;

/// Finds duplicate and blank images. `kind` is the declared kind of depth.
pub fn check(footage: &Footage, kind: DepthKind) -> Vec<Finding> {
    let groups = equal_images(footage, Shows::Surfaces);
    let (alike, duplicates): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| are_alike(footage, group, kind));
    let mut findings = vec![match duplicates.first() {
        Some(group) => {
            let says = format!("{} have the same pixels", names(group));
            let figures = [("copies", duplicates.len() as f64), ("alike", alike.len() as f64)];
            Finding::new("images", Verdict::Suspect, says).with(&figures)
        }
        None => no_duplicates(footage, &alike),
    }];
    if let Some(name) = footage.blank.first() {
        // A wall or a dome may also have a uniform colour.
        let says = format!("{name} has one colour, but its depth varies: was it rendered?");
        findings.push(Finding::new("images", Verdict::CannotTell, says).with(&[("blank", footage.blank.len() as f64)]));
    }
    findings
}

/// Returns groups of images with equal pixels, among those with content `shows`.
fn equal_images(footage: &Footage, shows: Shows) -> Vec<Vec<&HashedImage>> {
    let mut by_hash: BTreeMap<u64, Vec<&HashedImage>> = BTreeMap::new();
    for image in footage.hashes.iter().filter(|image| image.shows == shows) {
        by_hash.entry(image.hash).or_default().push(image);
    }
    let mut groups: Vec<Vec<&HashedImage>> = by_hash.into_values().filter(|group| group.len() > 1).collect();
    groups.sort_unstable_by(|a, b| a[0].name.cmp(&b[0].name));
    groups
}

fn names(group: &[&HashedImage]) -> String {
    let two: Vec<&str> = group.iter().take(2).map(|image| image.name.as_str()).collect();
    two.join(" and ")
}

/// Returns true if all images of a group may show different but similar surfaces.
fn are_alike(footage: &Footage, group: &[&HashedImage], kind: DepthKind) -> bool {
    group.iter().enumerate().all(|(at, a)| group[at + 1..].iter().all(|b| may_be_alike(footage, a, b, kind)))
}

fn may_be_alike(footage: &Footage, a: &HashedImage, b: &HashedImage, kind: DepthKind) -> bool {
    if a.kind != StreamKind::Depth || b.kind != StreamKind::Depth {
        return false;
    }
    let color = |of: &HashedImage| {
        let is_it =
            |image: &&HashedImage| image.kind == StreamKind::Color && image.probe == of.probe && image.face == of.face;
        footage.hashes.iter().find(is_it).map(|image| image.hash)
    };
    if color(a).is_some_and(|hash| color(b) == Some(hash)) {
        return false;
    }
    // Faces of one probe share no surface point; `seams` checks them.
    if a.probe == b.probe {
        return true;
    }
    let (Some(from), Some(to)) = (alone(footage, a), alone(footage, b)) else { return false };
    let views = [from, to];
    let hypothesis = Hypothesis::declared(kind, &views);
    let tally: Tally = [[0, 1], [1, 0]].into_iter().map(|pair| look_up(&views, pair, &hypothesis)).sum();
    tally.tested() < MIN_TESTED || tally.agreement() >= IS_ONE_SURFACE
}

/// Returns the samples of an image's probe, restricted to the image's face.
fn alone(footage: &Footage, image: &HashedImage) -> Option<ProbeSamples> {
    let view = footage.views.iter().find(|view| view.name == image.probe)?;
    let face = view.faces.iter().find(|samples| samples.face == image.face)?;
    Some(ProbeSamples { faces: vec![face.clone()], name: view.name.clone(), ..*view })
}

/// Creates the finding if no image of surfaces is duplicated. Equal images of the sky are valid, because it looks the same from
/// every position.
fn no_duplicates(footage: &Footage, alike: &[Vec<&HashedImage>]) -> Finding {
    let skies = equal_images(footage, Shows::Background);
    let unknown = equal_images(footage, Shows::Unknown);
    let figures = [
        ("copies", 0.0),
        ("alike", alike.len() as f64),
        ("equal_backgrounds", skies.len() as f64),
        ("equal_unknown", unknown.len() as f64),
    ];
    let (verdict, says) = if let Some(group) = alike.first().map(|group| names(group)) {
        let says = format!("{group} have the same pixels, as similar walls may where colour differs");
        (Verdict::CannotTell, says)
    } else if let Some(group) = unknown.first().map(|group| names(group)) {
        (Verdict::CannotTell, format!("{group} have the same pixels, as images of the sky alone may"))
    } else if let Some(group) = skies.first().map(|group| names(group)) {
        let have = "no two images of surfaces have the same pixels";
        (Verdict::Fine, format!("{have}; {group} have, without varying depth, as a sky"))
    } else {
        (Verdict::Fine, "no two images have the same pixels".to_owned())
    };
    Finding::new("images", verdict, says).with(&figures)
}
