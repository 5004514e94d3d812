//! The frame that views show: decodes what is wanted of it into the texels of a light field (CALF 6.2).
//!
//! Enters: an open container, the number of a frame, views, a filter of units. Leaves: the light field in that frame, and which
//! rectangles of it changed. Views keep what they decoded from frame to frame, so that only what differs is done.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::dataset::stream::{DepthKind, StreamKind};
use crate::decode::{AllUnits, Decoder, StreamInfo, UnitFilter};
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::image::FrameRange;
use crate::image::TexelMap;
use crate::memory::{Budget, Need};
use crate::ordered::try_map_ordered;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, DepthHeader};
use crate::views::face_cache::{FaceStreams, ShownFace, ShownUnit};
use crate::views::light_field::{ColorCoding, FaceTexels, InverseDepth, LightField, UNKNOWN, View};
use crate::views::rects::Rect;
use crate::views::units_on_device::{FaceParts, NewFace, UnitId, UnitsOnDevice};

/// Bytes of views that no longer take part, which are kept in case they come back, where there is no budget.
const KEPT_BYTES: u64 = 2 << 30;

/// Which probes of a container are shown. Nothing chosen: all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ProbeChoice {
    /// Names of those that are shown; empty: all.
    pub only: Vec<String>,
    /// Names of those that are not.
    pub without: Vec<String>,
}

impl ProbeChoice {
    /// Whether a probe is shown.
    pub fn takes(&self, name: &str) -> bool {
        let named = |names: &[String]| names.iter().any(|other| other == name);
        !named(&self.without) && (self.only.is_empty() || named(&self.only))
    }

    fn check(&self, decoder: &Decoder) -> Result<()> {
        let probes = &decoder.reader().index().probes;
        match self.only.iter().chain(&self.without).find(|name| probes.iter().all(|probe| probe.name != **name)) {
            None => Ok(()),
            Some(name) => {
                let names: Vec<&str> = probes.iter().take(20).map(|probe| probe.name.as_str()).collect();
                let more = if probes.len() > names.len() { ", ..." } else { "" };
                Err(Error::Usage(format!(
                    "{}: there is no probe '{name}'; its probes are {}{more}",
                    decoder.reader().path().display(),
                    names.join(", ")
                )))
            }
        }
    }
}

/// A rectangle of a face whose texels changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Index of the view in the light field.
    pub view: usize,
    /// Number of the face.
    pub face: usize,
    /// Which of its texels.
    pub kind: StreamKind,
    /// Left, top, width and height in texels.
    pub rect: Rect,
}

/// A view that has a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Its number in the light field.
    pub view: usize,
    /// Where it stands, in metres.
    pub position: DVec3,
}

/// What it took to show a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShowCounts {
    /// Tiles and cells whose pixels were written.
    pub cells_decoded: u64,
    /// Tiles and cells that are wanted and showed the frame already.
    pub cells_unchanged: u64,
    /// Tiles and cells of the views that take part which are not wanted.
    pub cells_unseen: u64,
    /// Texels that changed, of each kind, or lie between those that did.
    pub texels_updated: u64,
    /// Stored bytes that were read.
    pub bytes_read: u64,
    /// Stored bytes of the chunks that hold the frame for these views and did not hold the frame before: what decoding all of
    /// it reads, but for the chunk after it, into which colours between two keyframes sometimes lead.
    pub bytes_all: u64,
}

impl ShowCounts {
    /// Tiles and cells that were not decoded.
    pub fn cells_skipped(&self) -> u64 {
        self.cells_unchanged + self.cells_unseen
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: ShowCounts) -> ShowCounts {
        ShowCounts {
            cells_decoded: self.cells_decoded + other.cells_decoded,
            cells_unchanged: self.cells_unchanged + other.cells_unchanged,
            cells_unseen: self.cells_unseen + other.cells_unseen,
            texels_updated: self.texels_updated + other.texels_updated,
            bytes_read: self.bytes_read + other.bytes_read,
            bytes_all: self.bytes_all + other.bytes_all,
        }
    }
}

/// Shows frames of a container.
#[derive(Debug)]
pub struct Player<'a> {
    decoder: &'a Decoder,
    /// What is known of each view without decoding anything, by its index in the light field.
    sources: Vec<ViewSource<'a>>,
    /// What is decoded of each view.
    shown: Vec<Option<ShownView<'a>>>,
    field: LightField,
    changes: Vec<Change>,
    budget: Budget,
    /// Bytes of the budget that others take.
    beside_bytes: u64,
    tables: Vec<((DepthRange, DepthKind), Arc<InverseDepth>)>,
    /// Frames that were shown so far.
    clock: u64,
    /// Bytes that views had read which were given up since.
    bytes_given_up: u64,
    /// Whether what is shown was decoded on a device.
    on_device: bool,
}

/// What is to be shown.
#[derive(Clone, Copy)]
pub struct Wanted<'f> {
    /// The units.
    pub filter: &'f dyn UnitFilter,
    /// Whether materials may call for everything.
    pub effects: bool,
}

/// What decodes depth and colour, where the player does not.
type Device<'d> = Option<&'d mut dyn UnitsOnDevice>;

/// The streams of a view.
#[derive(Debug)]
struct ViewSource<'a> {
    faces: Vec<FaceStreams<'a>>,
    /// Bytes that it takes when it is shown.
    bytes: u64,
}

/// A view that is shown.
#[derive(Debug)]
struct ShownView<'a> {
    /// In the order of [`ViewSource::faces`].
    faces: Vec<ShownFace<'a>>,
    last_used: u64,
}

impl<'a> Player<'a> {
    /// A player of all chosen probes that have a face with both colour and depth. Nothing is decoded until a frame is shown.
    ///
    /// # Errors
    /// When a name is not one of a probe, there is no such probe, images of a face differ in size, or colours are coded in
    /// more than one way.
    pub fn new(decoder: &'a Decoder, probes: &ProbeChoice) -> Result<Player<'a>> {
        probes.check(decoder)?;
        let all = decoder.streams();
        let of = |like: &StreamInfo, kind| {
            all.iter().find(|other| other.probe == like.probe && other.face == like.face && other.kind == kind)
        };
        let (mut views, mut sources, mut coding) = (Vec::<View>::new(), Vec::<ViewSource<'_>>::new(), None);
        for depth in all.iter().filter(|stream| stream.kind == StreamKind::Depth) {
            let entry = decoder.probe(depth);
            let Some(color) = of(depth, StreamKind::Color).filter(|_| probes.takes(&entry.name)) else { continue };
            let material = of(depth, StreamKind::Material);
            let CodecHeader::Depth(header) = depth.header else { continue };
            let coded = coding_of(color);
            if *coding.get_or_insert(coded) != coded {
                return Err(Error::unsupported(
                    "colours of one light field are coded in more than one way: encode them alike",
                ));
            }
            let streams = FaceStreams { depth, header, color, material };
            check_sizes(&entry.name, &streams)?;
            let at = match views.iter().position(|view| view.probe == depth.probe) {
                Some(at) => at,
                None => {
                    let Some(range) = range_of(all, depth.probe) else { continue };
                    views.push(View::new(depth.probe, entry, range)?);
                    sources.push(ViewSource { faces: Vec::new(), bytes: 0 });
                    views.len() - 1
                }
            };
            sources[at].bytes += bytes_of(decoder, &streams, coded);
            sources[at].faces.push(streams);
        }
        let coding = coding.ok_or_else(|| {
            Error::Usage("no probe of this container has both colour and depth, which rendering takes".into())
        })?;
        Ok(Player {
            decoder,
            shown: sources.iter().map(|_| None).collect(),
            sources,
            field: LightField { views, coding },
            changes: Vec::new(),
            budget: Budget::UNLIMITED,
            beside_bytes: 0,
            tables: Vec::new(),
            clock: 0,
            bytes_given_up: 0,
            on_device: false,
        })
    }

    /// The same, with at most so much memory for what is decoded and `beside_bytes` that others take.
    #[must_use]
    pub fn with_memory(self, budget: Budget, beside_bytes: u64) -> Player<'a> {
        Player { budget, beside_bytes, ..self }
    }

    /// The light field as it was shown last. Views that did not take part lately have no faces.
    pub fn field(&self) -> &LightField {
        &self.field
    }

    /// Whether probes have a stream of materials.
    pub fn has_material(&self) -> bool {
        self.sources.iter().flat_map(|view| &view.faces).any(|face| face.material.is_some())
    }

    /// All frames that a view has, from the first to the last.
    pub fn frames(&self) -> FrameRange {
        let frames = || self.sources.iter().flat_map(|view| &view.faces).flat_map(FaceStreams::all).map(|s| s.frames);
        let first = frames().map(|frames| frames.first).min().unwrap_or_default();
        FrameRange { first, last: frames().map(|frames| frames.last).max().unwrap_or(first) }
    }

    /// The views that have a frame, as candidates for a selection.
    pub fn candidates(&self, frame: u32) -> Vec<Candidate> {
        let has = |view: usize| self.sources[view].faces.iter().any(|face| face.have(frame));
        let views = self.field.views.iter().enumerate().filter(|(view, _)| has(*view));
        views.map(|(view, known)| Candidate { view, position: known.position }).collect()
    }

    /// The streams of views (indices into [`LightField::views`]) that have a frame.
    pub fn streams_of(&self, frame: u32, views: &[usize]) -> Vec<&'a StreamInfo> {
        let sources = views.iter().filter_map(|&view| self.sources.get(view));
        let faces = sources.flat_map(|source| &source.faces).filter(|face| face.have(frame));
        faces.flat_map(FaceStreams::all).collect()
    }

    /// What changed since this was asked last, at first everything that is shown. Rectangles of one kind do not overlap
    /// within a frame. A view that was given up and comes back begins with all of its texels.
    pub fn take_changes(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.changes)
    }

    /// Bytes that the views which are kept take at most: texels, decoded units, and chunks.
    pub fn bytes(&self) -> u64 {
        let kept = self.sources.iter().zip(&self.shown).filter(|(_, shown)| shown.is_some());
        kept.map(|(source, _)| source.bytes).sum()
    }

    /// The same as [`Player::show`], with all materials of the views; where a weight of them is above 0, with everything,
    /// as mirrors and glass send rays anywhere.
    ///
    /// # Errors
    /// Those of [`Player::show`].
    pub fn show_with_effects(&mut self, frame: u32, views: &[usize], filter: &dyn UnitFilter) -> Result<ShowCounts> {
        self.show_on(frame, views, Wanted { filter, effects: true }, None)
    }

    /// Shows a frame of some views (indices into [`LightField::views`]), as far as the filter wants it. What is not shown
    /// becomes [`UNKNOWN`], unless it is known to be right for the frame all the same; so do views that do not have the frame.
    ///
    /// # Errors
    /// When no view has the frame, it cannot be decoded, or the views do not fit into memory. Then nothing is known of any
    /// view until the next frame is shown.
    pub fn show(&mut self, frame: u32, views: &[usize], filter: &dyn UnitFilter) -> Result<ShowCounts> {
        self.show_on(frame, views, Wanted { filter, effects: false }, None)
    }

    /// The same, where a device decodes depth and colour and keeps their texels; the light field has none of them then. What was
    /// shown without one is given up, and what was shown on one, where there is none now. It is to be the same from frame to
    /// frame: another has begun none of the views, and refuses; after such an error all views begin anew.
    ///
    /// # Errors
    /// Those of [`Player::show`], and what the device refuses.
    pub fn show_on(
        &mut self,
        frame: u32,
        views: &[usize],
        wanted: Wanted<'_>,
        mut device: Device<'_>,
    ) -> Result<ShowCounts> {
        if self.candidates(frame).is_empty() {
            let name = self.decoder.reader().path().display();
            return Err(Error::Usage(format!(
                "{name}: no probe has colour and depth of frame {frame}; there are frames {}",
                self.frames()
            )));
        }
        self.clock += 1;
        if std::mem::replace(&mut self.on_device, device.is_some()) != device.is_some() {
            (0..self.shown.len()).for_each(|at| self.give_up(at, &mut device));
        }
        self.make_room(views, &mut device)?;
        let read = |player: &Self, device: &Device<'_>| {
            player.bytes_read() + device.as_ref().map_or(0, |device| device.bytes_read())
        };
        let before = read(self, &device);
        let shown = self.begin(views, &mut device).and_then(|()| {
            self.decode(frame, views, wanted, &mut device)?;
            let (counts, parts) = self.update(views);
            device.as_mut().map_or(Ok(()), |device| device.write_depths(&parts))?;
            Ok(counts)
        });
        let mut counts = match shown {
            Ok(counts) => counts,
            Err(error) => {
                self.forget(&mut device);
                return Err(error);
            }
        };
        counts.bytes_read = read(self, &device) - before;
        for (_, view) in self.shown.iter_mut().enumerate().filter(|(at, _)| views.contains(at)) {
            let faces = view.iter_mut().flat_map(|view| &mut view.faces);
            counts.bytes_all += faces.map(|face| face.count_bytes(frame)).sum::<u64>();
        }
        Ok(counts)
    }

    /// Decodes what is wanted, materials first: they may call for everything.
    fn decode(&mut self, frame: u32, views: &[usize], wanted: Wanted<'_>, device: &mut Device<'_>) -> Result<()> {
        let Wanted { filter, effects } = wanted;
        let materials: &dyn UnitFilter = if effects { &AllUnits } else { filter };
        let faces = self.faces_of(frame, views, materials);
        let jobs = faces.flat_map(|(face, filter)| face.want_material(frame, filter)).collect();
        try_map_ordered(jobs, |unit: &mut ShownUnit<'_>| unit.decode(frame))?;
        let calls = effects
            && self.faces_of(frame, views, filter).any(|(face, wanted)| wanted.is_some() && face.calls_for_effects());
        let others: &dyn UnitFilter = if calls { &AllUnits } else { filter };
        let knows = device.as_deref();
        let faces = self.faces_of(frame, views, others);
        let mut jobs: Vec<_> = faces.flat_map(|(face, filter)| face.want(frame, filter, knows)).collect();
        match device {
            None => {
                try_map_ordered(jobs, |unit: &mut ShownUnit<'_>| unit.decode(frame))?;
            }
            Some(device) => {
                let units: Vec<UnitId> = jobs.iter().map(|unit| unit.id()).collect();
                let written = device.decode(frame, &units)?;
                jobs.iter_mut().zip(written).for_each(|(unit, written)| unit.was_decoded(written));
            }
        }
        Ok(())
    }

    /// All faces that are shown, each with the filter if it takes part and has the frame.
    fn faces_of<'s>(
        &'s mut self,
        frame: u32,
        views: &'s [usize],
        filter: &'s dyn UnitFilter,
    ) -> impl Iterator<Item = (&'s mut ShownFace<'a>, Option<&'s dyn UnitFilter>)> {
        let views_shown = self.sources.iter().zip(&mut self.shown).enumerate();
        views_shown.filter_map(|(at, (source, view))| Some((at, source, view.as_mut()?))).flat_map(
            move |(at, source, view)| {
                let takes_part = views.contains(&at);
                source
                    .faces
                    .iter()
                    .zip(&mut view.faces)
                    .map(move |(streams, face)| (face, Some(filter).filter(|_| takes_part && streams.have(frame))))
            },
        )
    }

    /// Gives up views that do not take part, those first that were used least lately, until the others fit.
    fn make_room(&mut self, views: &[usize], device: &mut Device<'_>) -> Result<()> {
        let mut taken: Vec<usize> = views.to_vec();
        taken.sort_unstable();
        taken.dedup();
        let active: u64 = taken.iter().filter_map(|&view| self.sources.get(view)).map(|source| source.bytes).sum();
        let taken_bytes = active.saturating_add(self.beside_bytes);
        let need = Need { what: "showing the views", fixed: taken_bytes, each: 0, instead: "fewer `views`" };
        self.budget.at_once(&need, 1)?;
        let kept_bytes = self.budget.less(taken_bytes).at_most(KEPT_BYTES);
        let mut idle = self.idle(&taken);
        idle.sort_by_key(|&at| self.shown[at].as_ref().map(|view| std::cmp::Reverse(view.last_used)));
        let mut bytes = 0u64;
        for at in idle {
            let probe = self.field.views[at].probe;
            let on_device = device.as_ref().map_or(0, |device| device.bytes(probe));
            bytes = bytes.saturating_add(on_device.max(self.sources[at].bytes));
            if bytes > kept_bytes {
                self.give_up(at, device);
            }
        }
        Ok(())
    }

    /// The views that are kept beside those that take part.
    fn idle(&self, taking_part: &[usize]) -> Vec<usize> {
        (0..self.shown.len()).filter(|at| self.shown[*at].is_some() && !taking_part.contains(at)).collect()
    }

    /// Forgets a view.
    fn give_up(&mut self, at: usize, device: &mut Device<'_>) {
        self.bytes_given_up += self.shown[at].take().map_or(0, |view| view.bytes_read());
        let view = &mut self.field.views[at];
        view.faces = Default::default();
        if let Some(device) = device {
            device.give_up(view.probe);
        }
        self.changes.retain(|change| change.view != at);
    }

    /// Makes room for what is decoded of views that were not shown before.
    fn begin(&mut self, views: &[usize], device: &mut Device<'_>) -> Result<()> {
        let known = self.sources.len();
        for at in views.iter().copied().filter(|at| *at < known) {
            if self.shown[at].is_none() {
                let faces: Vec<_> = (0..self.sources[at].faces.len()).map(|face| self.begin_face(at, face)).collect();
                if let Err(error) = self.begin_on(device, at, &faces) {
                    // What is only kept must not be why another is not shown.
                    let idle = self.idle(views);
                    if idle.is_empty() {
                        return Err(error);
                    }
                    idle.into_iter().for_each(|at| self.give_up(at, device));
                    self.begin_on(device, at, &faces)?;
                }
                self.shown[at] = Some(ShownView { faces, last_used: 0 });
            }
            if let Some(view) = &mut self.shown[at] {
                view.last_used = self.clock;
            }
        }
        Ok(())
    }

    /// Has a device take in a view, where there is one.
    fn begin_on(&self, device: &mut Device<'_>, at: usize, faces: &[ShownFace<'_>]) -> Result<()> {
        let Some(device) = device else { return Ok(()) };
        let view = &self.field.views[at];
        let new = self.sources[at].faces.iter().zip(faces).filter_map(|(streams, shown)| {
            let face = streams.depth.face as usize;
            let (texels, inverse) = (view.faces[face].as_ref()?, shown.inverse());
            Some(NewFace { face, depth: streams.depth.index, color: streams.color.index, texels, inverse })
        });
        device.begin(view.probe, &new.collect::<Vec<_>>())
    }

    fn begin_face(&mut self, at: usize, face: usize) -> ShownFace<'a> {
        let streams = self.sources[at].faces[face].clone();
        let depth = streams.depth;
        let number = depth.face as usize;
        let size = [depth.entry.width, depth.entry.height];
        let map = TexelMap::of_face(depth.face, size, self.decoder.probe(depth).intrinsics);
        let texels = match self.on_device {
            true => FaceTexels::on_device(size, map, self.field.coding),
            false => FaceTexels::unknown(size, map, self.field.coding),
        };
        let texels = if streams.material.is_some() { texels.with_material() } else { texels };
        self.field.views[at].faces[number] = Some(texels);
        for kind in streams.all().map(|stream| stream.kind) {
            self.changes.push(Change { view: at, face: number, kind, rect: [0, 0, size[0], size[1]] });
        }
        let inverse = self.inverse_of(&streams.header);
        ShownFace::new(self.decoder, &streams, inverse)
    }

    /// The table of a range of depths, shared by all that have the same.
    fn inverse_of(&mut self, header: &DepthHeader) -> Arc<InverseDepth> {
        let of = (header.range, header.kind);
        if let Some((_, table)) = self.tables.iter().find(|(other, _)| *other == of) {
            return Arc::clone(table);
        }
        self.tables.retain(|(_, table)| Arc::strong_count(table) > 1);
        let table = Arc::new(InverseDepth::new(header.range, header.kind));
        self.tables.push((of, Arc::clone(&table)));
        table
    }

    /// Brings texels to what was decoded, faces in parallel, and counts what became of the units of these views; answers also
    /// what a device is to write.
    fn update(&mut self, views: &[usize]) -> (ShowCounts, Vec<FaceParts>) {
        let mut faces = Vec::new();
        for (at, (view, shown)) in self.field.views.iter_mut().zip(&mut self.shown).enumerate() {
            let Some(shown) = shown else { continue };
            let mut texels = view.faces.each_mut().map(Option::as_mut);
            for (streams, face) in self.sources[at].faces.iter().zip(&mut shown.faces) {
                let number = streams.depth.face as usize;
                faces.extend(texels[number].take().map(|texels| (at, number, face, texels)));
            }
        }
        let changes: Vec<_> =
            faces.into_par_iter().map(|(view, number, face, texels)| (view, number, face.update(texels))).collect();
        let (mut counts, mut on_device) = (ShowCounts::default(), Vec::new());
        for (view, face, changes) in changes {
            if views.contains(&view) {
                counts.cells_decoded += changes.decoded;
                counts.cells_unchanged += changes.unchanged;
                counts.cells_unseen += changes.unseen;
            }
            for (kind, rect) in changes.rects {
                counts.texels_updated += u64::from(rect[2]) * u64::from(rect[3]);
                self.changes.push(Change { view, face, kind, rect });
            }
            if !changes.depth_parts.is_empty() {
                let probe = self.field.views[view].probe;
                on_device.push(FaceParts { probe, face, parts: changes.depth_parts });
            }
        }
        (counts, on_device)
    }

    /// Nothing is known of any view any more.
    fn forget(&mut self, device: &mut Device<'_>) {
        if device.is_some() {
            return (0..self.shown.len()).for_each(|at| self.give_up(at, device));
        }
        for (at, view) in self.shown.iter_mut().enumerate() {
            view.iter_mut().flat_map(|view| &mut view.faces).for_each(ShownFace::forget);
            for (face, texels) in self.field.views[at].faces.iter_mut().enumerate() {
                let Some(texels) = texels else { continue };
                texels.inverse_depth.fill(UNKNOWN);
                let rect = [0, 0, texels.size[0], texels.size[1]];
                self.changes.push(Change { view: at, face, kind: StreamKind::Depth, rect });
            }
        }
    }

    fn bytes_read(&self) -> u64 {
        self.bytes_given_up + self.shown.iter().flatten().map(ShownView::bytes_read).sum::<u64>()
    }
}

impl ShownView<'_> {
    fn bytes_read(&self) -> u64 {
        self.faces.iter().map(ShownFace::bytes_read).sum()
    }
}

/// Near and far over all faces of a probe.
fn range_of(streams: &[StreamInfo], probe: usize) -> Option<DepthRange> {
    let ranges = streams.iter().filter(|stream| stream.probe == probe).filter_map(|stream| match stream.header {
        CodecHeader::Depth(header) => Some([header.range.near_m(), header.range.far_m()]),
        _ => None,
    });
    let [near, far] = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    DepthRange::new(near, far).ok()
}

fn coding_of(color: &StreamInfo) -> ColorCoding {
    match color.header {
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }) => ColorCoding::Codes(tone),
        _ => ColorCoding::Light,
    }
}

fn check_sizes(probe: &str, streams: &FaceStreams<'_>) -> Result<()> {
    let size = |stream: &StreamInfo| [stream.entry.width, stream.entry.height];
    let depth = size(streams.depth);
    match streams.all().find(|stream| size(stream) != depth) {
        None => Ok(()),
        Some(other) => Err(Error::unsupported(format!(
            "probe {probe}, face {}: {} has {}x{} pixels and depth {}x{}: rendering takes images of one size",
            other.face.name(),
            other.kind.name(),
            other.entry.width,
            other.entry.height,
            depth[0],
            depth[1]
        ))),
    }
}

/// The most bytes that a face takes: its texels, and what its decoders hold.
fn bytes_of(decoder: &Decoder, streams: &FaceStreams<'_>, coding: ColorCoding) -> u64 {
    let pixels = u64::from(streams.depth.entry.width) * u64::from(streams.depth.entry.height);
    let color = match coding {
        ColorCoding::Codes(_) => 4,
        ColorCoding::Light => 8,
    };
    // The smaller levels of a pyramid have a third of its pixels, and a little more where sides are odd.
    let pyramid = 2;
    let texel = 4 + pyramid + color + if streams.material.is_some() { 4 } else { 0 };
    let index = decoder.reader().index();
    streams.all().map(|stream| stream.memory_bytes(index)).fold(pixels * texel, u64::saturating_add)
}
