//! Pairs of matching streams and frames of two sides.

use std::collections::HashMap;

use crate::compare::comparison::Missing;
use crate::compare::side::{Side, SideForm, SideStream};
use codec::error::{Error, Result};
use codec::image::{FrameRange, StreamKind};

/// Treatment of streams and frames that only one side has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coverage {
    /// They count as a difference.
    #[default]
    Whole,
    /// They are ignored.
    Common,
}

#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    pub streams: [&'a SideStream; 2],
    /// Frames that both streams have, as numbered on the first side.
    pub frames: FrameRange,
    /// Offset that is added to a frame number of the first side to get that of the second.
    shift: i64,
}

#[derive(Debug)]
pub struct Pairing<'a> {
    pub(super) sides: &'a [Side; 2],
    pub pairs: Vec<Pair<'a>>,
    pub(super) missing: Vec<Missing>,
}

impl<'a> Pairing<'a> {
    /// Matches streams by kind, probe and face. If each side has a single stream of a kind, these match whatever their names.
    pub fn new(sides: &'a [Side; 2], coverage: Coverage) -> Result<Pairing<'a>> {
        let [a, b] = sides;
        let [of_a, of_b] =
            [a, b].map(|side| side.streams.iter().map(|stream| (&stream.id, stream)).collect::<HashMap<_, _>>());
        let mut matches: Vec<[Option<&SideStream>; 2]> =
            a.streams.iter().map(|stream| [Some(stream), of_b.get(&stream.id).copied()]).collect();
        matches.extend(b.streams.iter().filter(|stream| !of_a.contains_key(&stream.id)).map(|b| [None, Some(b)]));
        for kind in StreamKind::ALL {
            let only = |side: &'a Side| {
                let mut of_kind = side.streams.iter().filter(|stream| stream.id.kind == kind);
                of_kind.next().filter(|_| of_kind.next().is_none())
            };
            if let (Some(a), Some(b)) = (only(a), only(b))
                && a.id != b.id
            {
                matches.retain(|streams| streams.iter().flatten().all(|stream| stream.id.kind != kind));
                matches.push([Some(a), Some(b)]);
            }
        }
        let order = |streams: &[Option<&SideStream>; 2]| {
            let first = streams.iter().flatten().next();
            first.map(|stream| (stream.id.kind, stream.probe_order, stream.id.face))
        };
        matches.sort_by_key(order);
        let mut pairing = Pairing { sides, pairs: Vec::new(), missing: Vec::new() };
        for streams in matches {
            pairing.add(streams)?;
        }
        if pairing.pairs.is_empty() {
            return Err(pairing.nothing_in_common());
        }
        if coverage == Coverage::Common {
            pairing.missing.clear();
        }
        Ok(pairing)
    }

    fn add(&mut self, streams: [Option<&'a SideStream>; 2]) -> Result<()> {
        let [Some(a), Some(b)] = streams else {
            for (only_in, stream) in streams.iter().enumerate() {
                let lost = stream.map(|stream| Missing { only_in, id: stream.id.clone(), frames: stream.frames });
                self.missing.extend(lost);
            }
            return Ok(());
        };
        if a.size != b.size {
            let text = |stream: &SideStream| format!("{}x{} pixels", stream.size[0], stream.size[1]);
            return Err(Error::invalid(format!("{}: {} cannot be compared with {}", a.id, text(a), text(b))));
        }
        if a.id.kind == StreamKind::Depth && a.depth_kind != b.depth_kind {
            return Err(Error::Usage(format!(
                "{}: one side holds distances and the other planar depth; set `depth_kind`, and `intrinsics` for a \
                 perspective sequence",
                a.id
            )));
        }
        let single = self.sides.iter().all(|side| side.form == SideForm::Sequence)
            && [a, b].iter().all(|stream| stream.frames.count() == 1);
        let shift = if single { i64::from(b.frames.first) - i64::from(a.frames.first) } else { 0 };
        let common = if single { Some(a.frames) } else { a.frames.intersect(b.frames) };
        for (only_in, stream) in [a, b].into_iter().enumerate() {
            let outside = if single { Vec::new() } else { frames_outside(stream.frames, common) };
            let missing = outside.into_iter().map(|frames| Missing { only_in, id: stream.id.clone(), frames });
            self.missing.extend(missing);
        }
        self.pairs.extend(common.map(|frames| Pair { streams: [a, b], frames, shift }));
        Ok(())
    }

    fn nothing_in_common(&self) -> Error {
        let list = |side: &Side| {
            let names: Vec<_> =
                side.streams.iter().take(3).map(|stream| format!("{} frames {}", stream.id, stream.frames)).collect();
            let more = if side.streams.len() > 3 { ", ..." } else { "" };
            format!("{} has {}{more}", side.path, names.join(", "))
        };
        let [a, b] = self.sides;
        let sequence = self.sides.iter().any(|side| side.form == SideForm::Sequence);
        let hint = if sequence { "; set `probe` and `face` of the sequence" } else { "" };
        Error::Usage(format!("the two have no stream and frame in common: {}; {}{hint}", list(a), list(b)))
    }

    pub fn images(&self) -> u64 {
        self.pairs.iter().map(|pair| pair.frames.count()).sum()
    }
}

fn frames_outside(all: FrameRange, inner: Option<FrameRange>) -> Vec<FrameRange> {
    let Some(inner) = inner else { return vec![all] };
    let before = (all.first < inner.first).then(|| FrameRange { first: all.first, last: inner.first - 1 });
    let after = (inner.last < all.last).then(|| FrameRange { first: inner.last + 1, last: all.last });
    before.into_iter().chain(after).collect()
}

impl Pair<'_> {
    /// Returns true if the pairs share files on either side, which should be read only once.
    pub(super) fn shares_files(&self, next: &Pair<'_>) -> bool {
        self.streams.iter().zip(next.streams).any(|(one, next)| one.shares_files(next))
    }

    pub fn other_frame(&self, frame: u32) -> u32 {
        u32::try_from(i64::from(frame) + self.shift).unwrap_or(frame)
    }
}
