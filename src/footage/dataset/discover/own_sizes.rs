//! Finds probes whose images have another size than those of the first one, and the same aspect.

use std::collections::{BTreeMap, BTreeSet};

use super::names::Named;
use super::sequences::Found;
use codec::image::StreamKind;

/// Returns the sizes of probes whose images have another size than the first image, by name. Empty if other images differ in size,
/// too: those of one probe, or of another aspect. Without depth, images of another size are previews.
pub fn of_probes(kinds: &BTreeMap<StreamKind, (Vec<&Found>, Named)>) -> BTreeMap<String, (u32, u32)> {
    let Some((files, first)) = kinds.values().next().filter(|_| kinds.contains_key(&StreamKind::Depth)) else {
        return BTreeMap::new();
    };
    let (width, height) = files[0].size;
    let is_whole = |named: &Named| named.left_out.is_empty() && named.members.keys().eq(first.members.keys());
    let mut sizes: BTreeMap<&str, BTreeSet<(u32, u32)>> = BTreeMap::new();
    for (files, named) in kinds.values() {
        for ((probe, _), at) in &named.members {
            sizes.entry(probe).or_default().insert(files[*at].size);
        }
    }
    let has_aspect =
        |(wide, high): &(u32, u32)| u64::from(*wide) * u64::from(height) == u64::from(width) * u64::from(*high);
    let is_one = |sizes: &BTreeSet<(u32, u32)>| sizes.len() == 1 && sizes.iter().all(has_aspect);
    if !kinds.values().all(|(_, named)| is_whole(named)) || !sizes.values().all(is_one) {
        return BTreeMap::new();
    }
    let all = sizes.into_iter().filter_map(|(probe, sizes)| Some((probe.to_owned(), *sizes.first()?)));
    all.filter(|(_, size)| *size != (width, height)).collect()
}
