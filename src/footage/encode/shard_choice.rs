//! Shards whose content the caller specifies: probes, kinds of streams, and frames.

use crate::dataset::SourceGroup;
use crate::encode::order::Order;
use crate::encode::source::FrameSource;
use codec::error::{Error, Result};
use codec::image::{FrameRange, StreamKind};

/// Content of a shard. Empty lists and `None` mean all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ShardChoice {
    /// Names of probes.
    pub probes: Vec<String>,
    /// Kinds of streams.
    pub kinds: Vec<StreamKind>,
    /// Frames. They must start and end at segment boundaries of the streams.
    pub frames: Option<FrameRange>,
}

impl ShardChoice {
    /// Returns the chosen groups with their frames, if streams of a kind can be cut every `length` frames.
    ///
    /// # Errors
    /// [`Error::Usage`] for unknown probes, for frames that are not at segment boundaries, and if nothing is chosen.
    pub(super) fn groups(
        &self,
        source: &dyn FrameSource,
        order: &Order<'_>,
        length: impl Fn(StreamKind) -> u32,
    ) -> Result<Vec<SourceGroup>> {
        let names: Vec<&str> = source.probes().iter().map(|probe| probe.name.as_str()).collect();
        if let Some(unknown) = self.probes.iter().find(|name| !names.contains(&name.as_str())) {
            let names = names.join(", ");
            return Err(Error::Usage(format!("`shard_probe` {unknown}: the probes are {names}")));
        }
        let mut groups = Vec::new();
        for group in order.0.iter().map(|ordered| ordered.group.group) {
            let name = names[group.probe];
            let of_kind = self.kinds.is_empty() || self.kinds.contains(&group.kind);
            let of_probe = self.probes.is_empty() || self.probes.iter().any(|probe| probe == name);
            if !of_kind || !of_probe {
                continue;
            }
            let asked = self.frames.unwrap_or(group.frames);
            let Some(frames) = asked.intersect(group.frames) else { continue };
            if let Some(words) = not_cut(group.frames, frames, length(group.kind).max(1)) {
                let kind = group.kind.name();
                return Err(Error::Usage(format!("`shard_frames` {asked}: {kind} of probe {name} {words}")));
            }
            groups.push(SourceGroup { frames, ..group.clone() });
        }
        if groups.is_empty() {
            let message = "no stream has the probes, kinds and frames of this shard: check `shard_probe`, \
                `shard_stream` and `shard_frames`";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(groups)
    }
}

/// Returns the nearest valid boundary, as words of an error, if `part` does not consist of whole segments of `length` frames.
fn not_cut(all: FrameRange, part: FrameRange, length: u32) -> Option<String> {
    // Offset of a frame from the start of its segment.
    let behind = |frame: u32| (frame - all.first) % length;
    let or = |words: Vec<u32>| words.iter().map(u32::to_string).collect::<Vec<_>>().join(" or ");
    if behind(part.first) != 0 {
        let before = part.first - behind(part.first);
        let after = before.checked_add(length).filter(|&after| after <= all.last);
        let nearest = or(std::iter::once(before).chain(after).collect());
        return Some(format!("can begin at frame {nearest}, not at {}", part.first));
    }
    if part.last != all.last && behind(part.last + 1) != 0 {
        let before = (part.last - behind(part.last)).checked_sub(1).filter(|&before| before >= part.first);
        let after = (part.last - behind(part.last)).saturating_add(length - 1).min(all.last);
        let nearest = or(before.into_iter().chain([after]).collect());
        return Some(format!("can end at frame {nearest}, not at {}", part.last));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_are_no_whole_segments_name_the_nearest_that_are() {
        let all = FrameRange { first: 3, last: 20 };
        let words = |first, last| not_cut(all, FrameRange { first, last }, 8);
        for (first, last) in [(3, 10), (3, 18), (11, 20), (19, 20), (3, 20)] {
            assert_eq!(words(first, last), None, "{first}-{last}");
        }
        for (first, last, expected) in [
            (5, 10, "can begin at frame 3 or 11, not at 5"),
            (20, 20, "can begin at frame 19, not at 20"),
            (3, 9, "can end at frame 10, not at 9"),
            (3, 12, "can end at frame 10 or 18, not at 12"),
            (11, 12, "can end at frame 18, not at 12"),
            (11, 19, "can end at frame 18 or 20, not at 19"),
        ] {
            assert_eq!(words(first, last).as_deref(), Some(expected));
        }
    }
}
