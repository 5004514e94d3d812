//! Decodes frames of a container into the texels of a light field (CALF 6.2).
//!
//! Takes an open container, a frame, views, and a filter of units. Returns the light field in that frame, and the rectangles of
//! it that changed. Decoded units are kept from frame to frame, so that only differences are decoded and written.

use std::sync::Arc;

use glam::DVec3;

use crate::views::catalogue::{Catalogue, ViewStreams};
use crate::views::{
    CachedUnit, ColorCoding, CpuBackend, FaceCache, FaceStreams, FaceTexels, FaceUpdate, InverseDepth, LightField,
    NewFace, ProbeChoice, Rect, StraightCodes, TexelBackend, decode_on_cpu,
};
use codec::decode::{AllUnits, Decoder, StreamInfo, UnitFilter};
use codec::error::{Error, Result};
use codec::image::{FrameRange, StreamKind, TexelMap};
use codec::math::add_members;
use codec::memory::{Budget, Need};
use codec::streams::DepthHeader;

/// Bytes of idle views that are kept if there is no memory budget.
const KEPT_BYTES: u64 = 2 << 30;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Index of the view in the light field.
    pub view: usize,
    pub face: usize,
    pub kind: StreamKind,
    /// Left, top, width and height in texels.
    pub rect: Rect,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index in the light field.
    pub view: usize,
    pub position: DVec3,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct ShowCounts {
    /// Tiles and cells whose pixels were written.
    pub cells_decoded: u64,
    /// Tiles and cells of the visible set that already showed the frame.
    pub cells_unchanged: u64,
    /// Tiles and cells of active views outside the visible set.
    pub cells_unseen: u64,
    /// Texels in changed rectangles, of all kinds.
    pub texels_updated: u64,
    /// Stored bytes that were read.
    pub bytes_read: u64,
    /// Stored bytes of the chunks that hold the frame for these views and did not hold the previous frame. Decoding everything
    /// reads these chunks, and sometimes the next chunk, if colour is blended with its first keyframe.
    pub bytes_all: u64,
}

impl ShowCounts {
    /// Number of tiles and cells that were not decoded.
    pub fn cells_skipped(&self) -> u64 {
        self.cells_unchanged + self.cells_unseen
    }
}

add_members!(ShowCounts: cells_decoded, cells_unchanged, cells_unseen, texels_updated, bytes_read, bytes_all);

/// Units of a frame that are needed.
#[derive(Clone, Copy)]
pub struct UnitRequest<'f> {
    pub visible: &'f dyn UnitFilter,
    /// True with secondary rays: all units are needed if a material of a visible unit is specular.
    pub secondary_rays: bool,
}

#[derive(Debug)]
pub struct Player<'a> {
    decoder: &'a Decoder,
    /// By the index of the view in the light field.
    streams: Vec<ViewStreams<'a>>,
    loaded: Vec<Option<LoadedView<'a>>>,
    /// Texels of the last frame. Views that are not loaded have no faces.
    pub field: LightField,
    changes: Vec<Change>,
    budget: Budget,
    /// Bytes of the budget that are used by others.
    reserved_bytes: u64,
    /// True if decoders keep only pixels from frame to frame, because their full state would exceed the budget.
    forgets: bool,
    tables: Vec<Arc<InverseDepth>>,
    /// Present if colours are codes and a face has alpha.
    straight: Option<Arc<StraightCodes>>,
    /// Number of frames so far.
    clock: u64,
    /// Bytes read by views that were unloaded.
    bytes_unloaded: u64,
    /// True if the last backend stores texels itself.
    in_backend: bool,
}

#[derive(Debug)]
struct LoadedView<'a> {
    /// In the order of [`ViewStreams::faces`].
    faces: Vec<FaceCache<'a>>,
    last_used: u64,
}

impl<'a> Player<'a> {
    /// Creates a player of all chosen probes that have a face with both colour and depth. Nothing is decoded yet.
    pub fn new(decoder: &'a Decoder, probes: &ProbeChoice) -> Result<Player<'a>> {
        let Catalogue { field, streams } = Catalogue::new(decoder, probes)?;
        let has_alpha = streams.iter().flat_map(|view| &view.faces).any(|face| face.alpha.is_some());
        let straight = match field.coding {
            ColorCoding::Codes(tone) if has_alpha => Some(Arc::new(StraightCodes::new(tone.transfer))),
            _ => None,
        };
        Ok(Player {
            decoder,
            loaded: streams.iter().map(|_| None).collect(),
            streams,
            field,
            changes: Vec::new(),
            budget: Budget::UNLIMITED,
            reserved_bytes: 0,
            forgets: false,
            tables: Vec::new(),
            straight,
            clock: 0,
            bytes_unloaded: 0,
            in_backend: false,
        })
    }

    /// Sets a memory budget, of which `reserved_bytes` are used by others.
    pub fn limit_memory(&mut self, budget: Budget, reserved_bytes: u64) {
        (self.budget, self.reserved_bytes) = (budget, reserved_bytes);
    }

    pub fn has_material(&self) -> bool {
        self.streams.iter().flat_map(|view| &view.faces).any(|face| face.material.is_some())
    }

    /// Returns the range of frames of all views, from the first to the last.
    pub fn frames(&self) -> FrameRange {
        let frames = || self.streams.iter().flat_map(|view| &view.faces).flat_map(FaceStreams::all).map(|s| s.frames);
        let first = frames().map(|frames| frames.first).min().unwrap_or_default();
        FrameRange { first, last: frames().map(|frames| frames.last).max().unwrap_or(first) }
    }

    pub fn candidates(&self, frame: u32) -> Vec<Candidate> {
        let has_it = |view: usize| self.streams[view].faces.iter().any(|face| face.have(frame));
        let views = self.field.views.iter().enumerate().filter(|(view, _)| has_it(*view));
        views
            .map(|(view, known)| {
                let probe = self.decoder.probe_at(known.probe, frame);
                Candidate { view, position: DVec3::from_array(probe.position) }
            })
            .collect()
    }

    /// Returns the streams of views (indices into [`LightField::views`]) that have a frame.
    pub fn streams_of(&self, frame: u32, views: &[usize]) -> Vec<&'a StreamInfo> {
        let streams = views.iter().filter_map(|&view| self.streams.get(view));
        let faces = streams.flat_map(|view| &view.faces).filter(|face| face.have(frame));
        faces.flat_map(FaceStreams::all).collect()
    }

    /// Returns the changes since the last call; rectangles of one kind do not overlap. A newly loaded view reports all its texels
    /// as changed.
    pub fn take_changes(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.changes)
    }

    /// Returns the maximum bytes of the loaded views: texels, decoded units, and chunks.
    pub fn bytes(&self) -> u64 {
        let loaded = self.streams.iter().zip(&self.loaded).filter(|(_, loaded)| loaded.is_some());
        loaded.map(|(streams, _)| streams.bytes).sum()
    }

    /// Shows a frame of some views on the CPU, without secondary rays; see [`Player::show_on`].
    pub fn show(&mut self, frame: u32, views: &[usize], visible: &dyn UnitFilter) -> Result<ShowCounts> {
        self.show_on(frame, views, UnitRequest { visible, secondary_rays: false }, &mut CpuBackend)
    }

    /// Shows a frame of some views (indices into [`LightField::views`]). Texels of other units and views become
    /// [`UNKNOWN`](crate::views::light_field::UNKNOWN), unless they are known to be valid for the frame.
    ///
    /// A change between the CPU and a device unloads all views. The device must stay the same from frame to frame: another device
    /// has not loaded the views, and fails.
    pub fn show_on(
        &mut self,
        frame: u32,
        views: &[usize],
        request: UnitRequest<'_>,
        backend: &mut dyn TexelBackend,
    ) -> Result<ShowCounts> {
        if self.candidates(frame).is_empty() {
            let name = self.decoder.reader().path().display();
            return Err(Error::Usage(format!(
                "{name}: no probe has colour and depth of frame {frame}; there are frames {}",
                self.frames()
            )));
        }
        self.clock += 1;
        for view in &mut self.field.views {
            view.place(&self.decoder.probe_at(view.probe, frame))?;
        }
        if std::mem::replace(&mut self.in_backend, backend.keeps_texels()) != backend.keeps_texels() {
            self.unload_all(backend);
        }
        self.make_room(views, backend)?;
        let before = self.bytes_read(backend);
        let shown = self.load(views, backend).and_then(|()| {
            self.decode(frame, views, request, backend)?;
            self.update(views, backend)
        });
        let mut counts = match shown {
            Ok(counts) => counts,
            Err(error) => {
                self.unload_all(backend);
                return Err(error);
            }
        };
        counts.bytes_read = self.bytes_read(backend) - before;
        for (_, view) in self.loaded.iter_mut().enumerate().filter(|(at, _)| views.contains(at)) {
            let faces = view.iter_mut().flat_map(|view| &mut view.faces);
            counts.bytes_all += faces.map(|face| face.count_bytes(frame)).sum::<u64>();
        }
        Ok(counts)
    }

    /// Decodes the needed units, materials first, because they may require all units.
    fn decode(
        &mut self,
        frame: u32,
        views: &[usize],
        request: UnitRequest<'_>,
        backend: &mut dyn TexelBackend,
    ) -> Result<()> {
        let UnitRequest { visible, secondary_rays } = request;
        let faces = self.faces_of(frame, views, visible);
        decode_on_cpu(frame, faces.flat_map(|(face, filter)| face.begin_material(frame, filter)).collect())?;
        let is_specular = secondary_rays
            && self
                .faces_of(frame, views, visible)
                .any(|(face, filter)| filter.is_some_and(|filter| face.is_specular(frame, filter)));
        if is_specular {
            let faces = self.faces_of(frame, views, visible);
            let active = faces.filter_map(|(face, filter)| Some((face, filter?)));
            let others = active.flat_map(|(face, filter)| face.begin_other_material(frame, filter));
            decode_on_cpu(frame, others.collect())?;
        }
        let others: &dyn UnitFilter = if is_specular { &AllUnits } else { visible };
        let knows = &*backend;
        let shows = |unit: &CachedUnit<'_>| knows.shows(unit, frame);
        let faces = self.faces_of(frame, views, others);
        let units: Vec<_> = faces.flat_map(|(face, filter)| face.begin_frame(frame, filter, &shows)).collect();
        backend.decode(frame, units)
    }

    /// Returns all loaded faces, with the filter for faces of active views that have the frame.
    fn faces_of<'s>(
        &'s mut self,
        frame: u32,
        views: &'s [usize],
        filter: &'s dyn UnitFilter,
    ) -> impl Iterator<Item = (&'s mut FaceCache<'a>, Option<&'s dyn UnitFilter>)> {
        let loaded = self.streams.iter().zip(&mut self.loaded).enumerate();
        loaded.filter_map(|(at, (streams, view))| Some((at, streams, view.as_mut()?))).flat_map(
            move |(at, streams, view)| {
                let is_active = views.contains(&at);
                let faces = streams.faces.iter().zip(&mut view.faces);
                faces.map(move |(streams, face)| (face, Some(filter).filter(|_| is_active && streams.have(frame))))
            },
        )
    }

    /// Returns the minimum bytes that suffice to show some views (indices into [`LightField::views`], each once).
    pub fn min_bytes(&self, views: &[usize]) -> u64 {
        self.bytes_of(views).into_iter().min().unwrap_or(0)
    }

    /// Returns the bytes of loaded views: with the full state of decoders, and if decoders keep only pixels from frame to frame.
    fn bytes_of(&self, views: &[usize]) -> [u64; 2] {
        let streams = || views.iter().filter_map(|&view| self.streams.get(view));
        let pixels: u64 = streams().map(|view| view.pixel_bytes).sum();
        let unit = streams().map(|view| view.unit_bytes).max().unwrap_or(0);
        let at_work = unit.saturating_mul(rayon::current_num_threads() as u64);
        [streams().map(|view| view.bytes).sum(), pixels.saturating_add(at_work)]
    }

    /// Unloads idle views, least recently used first, until the active ones fit. Fails if the active views exceed the budget.
    fn make_room(&mut self, views: &[usize], backend: &mut dyn TexelBackend) -> Result<()> {
        let mut active: Vec<usize> = views.to_vec();
        active.sort_unstable();
        active.dedup();
        let [whole, forgetting] = self.bytes_of(&active).map(|bytes| bytes.saturating_add(self.reserved_bytes));
        // The units that are being decoded may take more than the state of all decoders: then dropping that state does not help.
        self.forgets = forgetting < whole && self.budget.bytes.is_some_and(|bytes| whole > bytes);
        let fixed = if self.forgets { forgetting } else { whole };
        let need = Need { what: "showing the views", fixed, each: 0, instead: "fewer `views`" };
        self.budget.at_once(&need, 1)?;
        let kept_bytes = self.budget.less(fixed).at_most(KEPT_BYTES);
        let mut idle = self.idle(&active);
        idle.sort_by_key(|&at| self.loaded[at].as_ref().map(|view| std::cmp::Reverse(view.last_used)));
        let mut bytes = 0u64;
        for at in idle {
            let in_backend = backend.bytes(self.field.views[at].probe);
            bytes = bytes.saturating_add(in_backend.max(self.streams[at].bytes));
            if bytes > kept_bytes {
                self.unload(at, backend);
            }
        }
        Ok(())
    }

    fn idle(&self, active: &[usize]) -> Vec<usize> {
        (0..self.loaded.len()).filter(|at| self.loaded[*at].is_some() && !active.contains(at)).collect()
    }

    fn unload(&mut self, at: usize, backend: &mut dyn TexelBackend) {
        self.bytes_unloaded += self.loaded[at].take().map_or(0, |view| view.bytes_read());
        let view = &mut self.field.views[at];
        view.faces = Default::default();
        backend.unload(view.probe);
        self.changes.retain(|change| change.view != at);
    }

    fn unload_all(&mut self, backend: &mut dyn TexelBackend) {
        (0..self.loaded.len()).for_each(|at| self.unload(at, backend));
    }

    fn load(&mut self, views: &[usize], backend: &mut dyn TexelBackend) -> Result<()> {
        let count = self.streams.len();
        for at in views.iter().copied().filter(|at| *at < count) {
            if self.loaded[at].is_none() {
                let faces: Vec<_> = (0..self.streams[at].faces.len()).map(|face| self.load_face(at, face)).collect();
                if let Err(error) = self.load_into(backend, at, &faces) {
                    // Idle views must not prevent the loading of an active one.
                    let idle = self.idle(views);
                    if idle.is_empty() {
                        return Err(error);
                    }
                    idle.into_iter().for_each(|at| self.unload(at, backend));
                    self.load_into(backend, at, &faces)?;
                }
                self.loaded[at] = Some(LoadedView { faces, last_used: 0 });
            }
            if let Some(view) = &mut self.loaded[at] {
                view.last_used = self.clock;
                view.faces.iter_mut().for_each(|face| face.set_forgetting(self.forgets));
            }
        }
        Ok(())
    }

    fn load_into(&self, backend: &mut dyn TexelBackend, at: usize, faces: &[FaceCache<'_>]) -> Result<()> {
        let view = &self.field.views[at];
        let new = self.streams[at].faces.iter().zip(faces).filter_map(|(streams, cache)| {
            let face = streams.depth.face as usize;
            let (texels, inverse) = (view.faces[face].as_ref()?, &cache.inverse);
            Some(NewFace { face, depth: streams.depth.index, color: streams.color.index, texels, inverse })
        });
        backend.load(view.probe, &new.collect::<Vec<_>>())
    }

    fn load_face(&mut self, at: usize, face: usize) -> FaceCache<'a> {
        let streams = self.streams[at].faces[face].clone();
        let depth = streams.depth;
        let number = depth.face as usize;
        let size = [depth.entry.width, depth.entry.height];
        let map = TexelMap::of_face(depth.face, size, self.decoder.probe(depth).intrinsics);
        let texels = match self.in_backend {
            true => FaceTexels::in_backend(size, map, self.field.coding),
            false => FaceTexels::unknown(size, map, self.field.coding),
        };
        let texels = if streams.material.is_some() { texels.with_material() } else { texels };
        let texels = FaceTexels { has_alpha: streams.alpha.is_some(), ..texels };
        self.field.views[at].faces[number] = Some(texels);
        // Alpha is a part of the colour texels.
        for kind in streams.all().map(|stream| stream.kind).filter(|&kind| kind != StreamKind::Alpha) {
            self.changes.push(Change { view: at, face: number, kind, rect: [0, 0, size[0], size[1]] });
        }
        let inverse = self.inverse_of(&streams.header);
        FaceCache::new(self.decoder, &streams, inverse, self.straight.clone())
    }

    /// Returns the table of a stream, shared by streams of the same range and kind.
    fn inverse_of(&mut self, header: &DepthHeader) -> Arc<InverseDepth> {
        let (range, kind) = (header.range, header.kind);
        if let Some(table) = self.tables.iter().find(|table| (table.range, table.kind) == (range, kind)) {
            return Arc::clone(table);
        }
        self.tables.retain(|table| Arc::strong_count(table) > 1);
        let table = Arc::new(InverseDepth::new(range, kind));
        self.tables.push(Arc::clone(&table));
        table
    }

    /// Updates the texels from the decoded units, and counts the units of the active views.
    fn update(&mut self, views: &[usize], backend: &mut dyn TexelBackend) -> Result<ShowCounts> {
        let mut faces = Vec::new();
        for (at, (view, loaded)) in self.field.views.iter_mut().zip(&self.loaded).enumerate() {
            let Some(loaded) = loaded else { continue };
            let mut texels = view.faces.each_mut().map(Option::as_mut);
            for (streams, cache) in self.streams[at].faces.iter().zip(&loaded.faces) {
                let face = streams.depth.face as usize;
                let probe = view.probe;
                faces.extend(texels[face].take().map(|texels| FaceUpdate { view: at, probe, face, cache, texels }));
            }
        }
        let places: Vec<_> = faces.iter().map(|face| (face.view, face.face)).collect();
        let mut counts = ShowCounts::default();
        for ((view, face), changes) in places.into_iter().zip(backend.update(faces)?) {
            if views.contains(&view) {
                counts.cells_decoded += changes.decoded;
                counts.cells_unchanged += changes.unchanged;
                counts.cells_unseen += changes.unseen;
            }
            for (kind, rect) in changes.rects {
                counts.texels_updated += u64::from(rect[2]) * u64::from(rect[3]);
                self.changes.push(Change { view, face, kind, rect });
            }
        }
        Ok(counts)
    }

    fn bytes_read(&self, backend: &dyn TexelBackend) -> u64 {
        let loaded = self.loaded.iter().flatten().map(LoadedView::bytes_read).sum::<u64>();
        self.bytes_unloaded + loaded + backend.bytes_read()
    }
}

impl LoadedView<'_> {
    fn bytes_read(&self) -> u64 {
        self.faces.iter().map(FaceCache::bytes_read).sum()
    }
}
