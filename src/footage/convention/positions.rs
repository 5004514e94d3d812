//! Detects probes with equal positions, as in a manifest without stated positions.

use std::collections::HashMap;

use super::finding::{Finding, Verdict};
use crate::dataset::ProbeInfo;

/// Returns a suspicion if two probes have the same first frame, position and orientation. Views from one position in several
/// directions are valid.
pub(super) fn check(probes: &[ProbeInfo]) -> Option<Finding> {
    let mut earlier: HashMap<_, &ProbeInfo> = HashMap::new();
    let mut pairs = probes.iter().filter_map(|probe| {
        let pose = probe.pose(probe.frames.first);
        let place = (pose.position.map(f64::to_bits), pose.orientation.map(f64::to_bits), probe.frames.first);
        Some((earlier.insert(place, probe)?, probe))
    });
    let (one, other) = pairs.next()?;
    let says = format!(
        "probes {} and {} stand at one place and have one orientation: state where each stands",
        one.name, other.name
    );
    Some(Finding::new("positions", Verdict::Suspect, says))
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::FrameRange;

    #[test]
    fn probes_at_one_place_are_suspect_unless_they_look_elsewhere() {
        let probe = |name: &str, x: f64, orientation| ProbeInfo {
            name: name.into(),
            position: [x, 0.0, 0.0],
            orientation,
            poses: Vec::new(),
            frames: FrameRange { first: 0, last: 3 },
            intrinsics: None,
        };
        let (ahead, behind) = ([0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]);
        assert!(check(&[probe("a", 0.0, ahead), probe("b", 1.0, ahead), probe("c", 0.0, behind)]).is_none());
        let found = check(&[probe("a", 0.0, ahead), probe("b", 1.0, ahead), probe("c", 0.0, ahead)]).unwrap();
        assert!(found.says.starts_with("probes a and c stand at one place"), "{}", found.says);
    }
}
