//! Divides the encode of a source into shards, at segment boundaries of its streams.

use std::ops::Range;

use crate::dataset::SourceGroup;
use crate::encode::plan::Plan;
use codec::error::{Error, Result, counted};
use codec::image::{FrameRange, StreamKind};

/// Granularity and order in which work is divided into shards.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShardBy {
    /// Segments of streams in time; gives the most even shards.
    #[default]
    Segment,
    Probe,
    /// Groups of streams that are read from the same files.
    Stream,
    /// Segments of all streams, sorted by time.
    Time,
}

/// Number of a shard, and the number of shards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1 to `count`.
    pub number: u32,
    pub count: u32,
}

impl Shard {
    /// Returns the range of `total` consecutive items that belongs to this shard. The sizes of shards differ by at most one.
    /// `what` names an item in the error.
    ///
    /// # Errors
    /// [`Error::Usage`] for a number out of range, and if there are more shards than items.
    pub fn range(self, total: u64, what: &str) -> Result<Range<u64>> {
        self.check(total, || format!("there can be at most {}, one for each {what}", counted(total, "shard")))?;
        let end_of = |number: u32| (u128::from(total) * u128::from(number) / u128::from(self.count)) as u64;
        Ok(end_of(self.number - 1)..end_of(self.number))
    }

    /// Fails if the number is out of range, or with `words` if there are more than `most` shards.
    fn check(self, most: u64, words: impl FnOnce() -> String) -> Result<()> {
        let Shard { number, count } = self;
        if !(1..=count).contains(&number) {
            return Err(Error::Usage(format!("`shard` {number}/{count}: a number of 1 to {count} was expected")));
        }
        if u64::from(count) > most {
            return Err(Error::Usage(format!("`shard` {number}/{count}: {}", words())));
        }
        Ok(())
    }
}

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
    /// Returns the chosen groups with their frames.
    ///
    /// # Errors
    /// [`Error::Usage`] for unknown probes, for frames that are not at segment boundaries, and if nothing is chosen.
    pub(super) fn groups(&self, plan: &Plan<'_>) -> Result<Vec<SourceGroup>> {
        let names: Vec<&str> = plan.source.probes().iter().map(|probe| probe.name.as_str()).collect();
        if let Some(unknown) = self.probes.iter().find(|name| !names.contains(&name.as_str())) {
            let names = names.join(", ");
            return Err(Error::Usage(format!("`shard_probe` {unknown}: the probes are {names}")));
        }
        let mut groups = Vec::new();
        for group in plan.groups.iter().map(|planned| planned.group) {
            let name = names[group.probe];
            let of_kind = self.kinds.is_empty() || self.kinds.contains(&group.kind);
            let of_probe = self.probes.is_empty() || self.probes.iter().any(|probe| probe == name);
            if !of_kind || !of_probe {
                continue;
            }
            let asked = self.frames.unwrap_or(group.frames);
            let Some(frames) = asked.intersect(group.frames) else { continue };
            if let Some(words) = not_cut(group.frames, frames, plan.settings.segment_frames(group.kind).max(1)) {
                let kind = group.kind.name();
                return Err(Error::Usage(format!("`shard_frames` {asked}: {kind} of probe {name} {words}")));
            }
            groups.push(SourceGroup { frames, ..group.clone() });
        }
        if groups.is_empty() {
            let message = "no stream has the probes, kinds and frames of this shard: see `shard_probe`, `shard_stream` and \
                           `shard_frames`";
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

/// Consecutive frames of a group.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Index of the group in encoding order.
    pub ordered: usize,
    pub frames: FrameRange,
    pixels: u64,
}

/// Segments that must be in the same shard.
struct Piece {
    segments: Vec<Segment>,
    pixels: u64,
}

/// Returns the groups of a shard with their frames.
///
/// # Errors
/// [`Error::Usage`] for a number out of range, and if the source cannot be cut into so many shards.
pub(super) fn groups_of_shard(plan: &Plan<'_>, shard: Shard, by: ShardBy) -> Result<Vec<SourceGroup>> {
    let pieces = pieces(plan, |kind| plan.settings.segment_frames(kind), by);
    let mut segments: Vec<Segment> =
        of_shard(&pieces, shard)?.iter().flat_map(|piece| &piece.segments).copied().collect();
    segments.sort_by_key(|segment| (segment.ordered, segment.frames.first));
    let mut groups: Vec<(usize, SourceGroup)> = Vec::new();
    for Segment { ordered, frames, .. } in segments {
        match groups.last_mut() {
            Some((at, group)) if *at == ordered && group.frames.last + 1 == frames.first => {
                group.frames.last = frames.last;
            }
            _ => groups.push((ordered, SourceGroup { frames, ..plan.groups[ordered].group.clone() })),
        }
    }
    Ok(groups.into_iter().map(|(_, group)| group).collect())
}

/// Returns the segments of `length` frames of a shard, for work that may have more shards than segments; shards beyond the last
/// segment are empty.
pub(super) fn segments_of_shard(plan: &Plan<'_>, length: u32, Shard { number, count }: Shard) -> Result<Vec<Segment>> {
    let pieces = pieces(plan, |_| length, ShardBy::Segment);
    if count as usize > pieces.len() && (1..=count).contains(&number) {
        return Ok(pieces.get(number as usize - 1).map_or_else(Vec::new, |piece| piece.segments.clone()));
    }
    Ok(of_shard(&pieces, Shard { number, count })?.iter().flat_map(|piece| &piece.segments).copied().collect())
}

/// Returns all segments of `length` frames, grouped into pieces in the order in which they are assigned to shards.
fn pieces(plan: &Plan<'_>, length: impl Fn(StreamKind) -> u32, by: ShardBy) -> Vec<Piece> {
    let mut segments: Vec<Segment> = Vec::new();
    for (ordered, group) in plan.groups.iter().enumerate() {
        let SourceGroup { kind, faces, frames, width, height, .. } = group.group;
        let length = length(*kind).max(1);
        let mut first = frames.first;
        loop {
            let part = FrameRange { first, last: first.saturating_add(length - 1).min(frames.last) };
            let pixels = part.count() * u64::from(*width) * u64::from(*height) * faces.len() as u64;
            segments.push(Segment { ordered, frames: part, pixels });
            if part.last == frames.last {
                break;
            }
            first = part.last + 1;
        }
    }
    if by == ShardBy::Time {
        segments.sort_by_key(|segment| (segment.frames.first, segment.ordered));
    }
    let probe = |segment: &Segment| plan.groups[segment.ordered].group.probe;
    let together = |a: &Segment, b: &Segment| match by {
        ShardBy::Segment | ShardBy::Time => false,
        ShardBy::Stream => a.ordered == b.ordered,
        ShardBy::Probe => probe(a) == probe(b),
    };
    let piece = |segments: &[Segment]| Piece {
        segments: segments.to_vec(),
        pixels: segments.iter().map(|segment| segment.pixels).sum(),
    };
    segments.chunk_by(together).map(piece).collect()
}

/// Returns the pieces of a shard: consecutive, at least one, with as even a share of the pixels as whole pieces allow.
fn of_shard(pieces: &[Piece], shard: Shard) -> Result<&[Piece]> {
    shard.check(pieces.len() as u64, || {
        format!("these streams can be cut into at most {} shards, or into more by another `shard_by`", pieces.len())
    })?;
    let Shard { number, count } = shard;
    let total: u64 = pieces.iter().map(|piece| piece.pixels).sum();
    let (mut start, mut done) = (0, 0);
    for shard in 1..=count {
        let left = (count - shard) as usize;
        let goal = u128::from(total) * u128::from(shard);
        let mut end = start;
        while end < pieces.len() - left && (end == start || u128::from(done) * u128::from(count) < goal) {
            done += pieces[end].pixels;
            end += 1;
        }
        if shard == number {
            return Ok(&pieces[start..end]);
        }
        start = end;
    }
    Ok(&[])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_hold_all_pieces_evenly_and_none_is_empty() {
        let of = |pixels: &[u64]| -> Vec<Piece> {
            pixels.iter().map(|&pixels| Piece { segments: Vec::new(), pixels }).collect()
        };
        let even = [1; 54];
        for (pixels, count) in [(&even[..], 1), (&even, 7), (&even, 54), (&[100, 1, 1, 1], 4), (&[1, 1, 1, 100], 3)] {
            let pieces = of(pixels);
            let lengths: Vec<usize> =
                (1..=count).map(|number| of_shard(&pieces, Shard { number, count }).unwrap().len()).collect();
            assert_eq!(lengths.iter().sum::<usize>(), pieces.len());
            assert!(lengths.iter().all(|&length| length > 0), "{lengths:?}");
            if pixels == even {
                assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1, "{lengths:?}");
            }
        }
        for (number, count) in [(1, 3), (0, 2), (3, 2)] {
            assert!(of_shard(&of(&[1, 1]), Shard { number, count }).is_err());
            assert!(Shard { number, count }.range(2, "picture").is_err());
        }
    }

    #[test]
    fn ranges_follow_each_other_and_are_even() {
        for (total, count) in [(7, 3), (3, 3), (u64::MAX, 5), (1000, 7)] {
            let ranges = (1..=count).map(|number| Shard { number, count }.range(total, "picture").unwrap());
            let mut next = 0;
            for range in ranges {
                assert_eq!(range.start, next);
                assert!((range.end - range.start).abs_diff(total / u64::from(count)) <= 1, "{range:?}");
                next = range.end;
            }
            assert_eq!(next, total);
        }
    }

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
