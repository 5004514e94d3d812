//! Decodes streams of one family on a graphics device: all their tiles and cells together.
//!
//! Input: units, each with a frame. The device keeps the chunks ([`crate::resident`]), the pictures, and the frame that
//! each picture shows; a call sends only the list of units. A planning kernel finds the next record of each unit and sums up
//! the work. The decoding kernel is dispatched indirectly with the planned size; its invocations find their part of the work by
//! bisection. Units more than a window behind the requested frame take several rounds.
//!
//! Based on: GDC 5, algorithm 2.

mod read;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use crate::Gpu;
use crate::device::Pipeline;
use crate::family::{Family, PixelWords};
use crate::resident::{Growing, Resident, ResidentChunk};
use codec::color::cells::MISSING_NEXT_KEYFRAME;
use codec::color::transform::blocks::REGION;
use codec::container::ChunkEntry;
use codec::decode::{AllUnits, DecodeCost, Decoder, StreamInfo, UnitFilter};
use codec::depth::record_table;
use codec::error::{Error, Result};
use codec::monitor::{Monitor, Silent};
use codec::ordered::try_map_ordered;
use kernels::Kernel;
use kernels::layout::{Dispatch, Item, Job, LIST_HEAD_WORDS, NONE, SCRATCH_WORDS, State, Unit, list_of, words_of};
use kernels::prepare::{self, KernelOf, Prepared, Timeline};
use kernels::transform_tables::TransformTables;

/// Maximum number of units whose chunks are fetched and checked together.
const FETCH_TOGETHER: usize = 32;
/// Maximum payload bytes that are fetched together; a single larger payload is fetched alone.
const FETCH_BYTES: u64 = 64 << 20;
/// Maximum rounds of a unit. Only a frame far behind its keyframe in a stream with a narrow window takes many rounds. Each
/// round is two dispatches, so without this limit a file of a few bytes could cause hours of them.
const MAX_ROUNDS: u32 = 1 << 14;
const ROUNDS_TOGETHER: u32 = 64;
/// Maximum invocations of a dispatch: kernels number them in 32 bits. Nodes that extend beyond narrow tiles can need more
/// invocations than there are pixels.
const MAX_WORK: u64 = 1 << 31;
/// Maximum bytes of the scratch memory between a kernel and its reader; a unit that needs more gets more.
const MAX_SCRATCH_BYTES: u64 = 128 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitFrame {
    /// Index of its stream in [`GpuDecoder::streams`].
    pub stream: usize,
    pub unit: u32,
    /// Frame number in the source.
    pub frame: u32,
}

/// Content of a unit's picture, as tracked by the host.
#[derive(Debug, Clone)]
struct Shown {
    key: u32,
    frame: u32,
    /// Timeline of the chunk; kept even if the chunk was dropped from the device.
    timeline: Arc<Timeline>,
}

pub struct GpuDecoder<'a> {
    gpu: &'a Gpu,
    decoder: &'a Decoder,
    pub streams: Vec<&'a StreamInfo>,
    family: Family,
    first_units: Vec<usize>,
    units: Vec<Unit>,
    shown: Vec<Option<Shown>>,
    resident: Resident,
    calls: u64,
    max_work: u64,
    /// Maximum words of chunks that are kept between calls; bounds device memory during long playback.
    pub kept_words: usize,
    /// Pixels that the last call wrote, by unit.
    written: Vec<u64>,
    buffers: Buffers,
    /// Cost so far; device time is only included where the host waited for the device.
    pub cost: DecodeCost,
    /// Sum of the pixels of the requested units of all calls.
    pub wanted_pixels: u64,
    monitor: &'a dyn Monitor,
}

struct Buffers {
    units: wgpu::Buffer,
    states: wgpu::Buffer,
    pictures: wgpu::Buffer,
    log2_table: wgpu::Buffer,
    /// Tables of the transform codec.
    tables: wgpu::Buffer,
    dispatch: wgpu::Buffer,
    items: Growing,
    jobs: wgpu::Buffer,
    /// Scratch memory between a kernel and its reader, shared by all decoders of a device.
    scratch: wgpu::Buffer,
}

/// Units whose chunks are resident, to be decoded together.
#[derive(Default)]
struct Batch {
    codec: List,
    /// Units in keyframe chunks, for codecs that have both chunk types.
    keyframes: List,
}

/// Units decoded by one kernel.
#[derive(Default)]
struct List {
    items: Vec<Item>,
    rounds: u32,
    /// Passes of the kernel's reader.
    passes: u32,
    /// Upper bound of the invocations of a dispatch.
    work: u64,
}

impl Batch {
    fn of(&mut self, kernel: KernelOf) -> &mut List {
        match kernel {
            KernelOf::Codec => &mut self.codec,
            KernelOf::Keyframes => &mut self.keyframes,
        }
    }
}

/// Returns the size in words of a stream's pictures, with rows of 8-bit colour padded to a multiple of `row_words` words.
pub fn picture_words(stream: &StreamInfo, row_words: u32) -> u64 {
    let (entry, family) = (&stream.entry, Family::of(&stream.header));
    let stride = |width: u32| u64::from(stride_of(family, width, row_words));
    let unit = entry.unit_width.min(entry.width).max(1);
    // All units of a column have the same width, and their heights add up to the image height.
    (u64::from(entry.width / unit) * stride(unit) + stride(entry.width % unit)) * u64::from(entry.height)
}

/// Returns the size in words of the largest buffer of a decoder for these streams of one family, without the chunk buffers.
pub fn buffer_words(streams: &[&StreamInfo], row_words: u32) -> u64 {
    let pictures: u64 = streams.iter().map(|stream| picture_words(stream, row_words)).sum();
    let units: u64 = streams.iter().map(|stream| u64::from(stream.entry.unit_count())).sum();
    let lists = [(0, Unit::WORDS), (0, State::WORDS), (LIST_HEAD_WORDS, Item::WORDS), (LIST_HEAD_WORDS, Job::WORDS)];
    let tables = TransformTables::of(streams).words.len() as u64;
    let largest = pictures.max(tables).max(scratch_words(streams));
    lists.into_iter().map(|(head, words)| head as u64 + units * words as u64).fold(largest, u64::max)
}

/// Returns the scratch words that the largest unit needs; 0 if the kernel has no reader.
fn scratch_words(streams: &[&StreamInfo]) -> u64 {
    let regions = |stream: &&StreamInfo| {
        let entry = &stream.entry;
        let sides = [entry.unit_width.min(entry.width), entry.unit_height.min(entry.height)];
        let [columns, rows] = sides.map(|side| u64::from(side.div_ceil(REGION as u32)));
        if Family::of(&stream.header).kernel.reader.is_some() { columns * rows } else { 0 }
    };
    streams.iter().map(regions).max().unwrap_or(0) * u64::from(SCRATCH_WORDS)
}

/// Returns the row stride of a picture in words. Only rows of 8-bit colour are copied into textures and need padding.
fn stride_of(family: Family, width: u32, row_words: u32) -> u32 {
    let is_padded = family.is_color && family.words == PixelWords::Bytes;
    family.stride(width).next_multiple_of(if is_padded { row_words.max(1) } else { 1 })
}

impl<'a> GpuDecoder<'a> {
    /// Creates a decoder for one or more streams of one family.
    pub fn new(gpu: &'a Gpu, decoder: &'a Decoder, streams: &[&'a StreamInfo]) -> Result<GpuDecoder<'a>> {
        Self::with_rows(gpu, decoder, streams, 1)
    }

    /// As [`GpuDecoder::new`], with rows of 8-bit colour padded to a multiple of `row_words` words, as copies into textures
    /// require.
    pub fn with_rows(
        gpu: &'a Gpu,
        decoder: &'a Decoder,
        streams: &[&'a StreamInfo],
        row_words: u32,
    ) -> Result<GpuDecoder<'a>> {
        let mut families = streams.iter().map(|stream| Family::of(&stream.header));
        let Some(family) = families.next().filter(|family| families.all(|other| other == *family)) else {
            return Err(Error::Usage("streams of different families cannot be decoded together".into()));
        };
        let total: u64 = streams.iter().map(|stream| picture_words(stream, row_words)).sum();
        // If the buffer is too large, its error states both the needed and the allowed size.
        let picture_words = usize::try_from(total).unwrap_or(usize::MAX / 8);
        let none = wgpu::BufferUsages::empty();
        let pictures = gpu.buffer("pictures", picture_words, none)?;
        let tables = TransformTables::of(streams);
        let (mut units, mut first_units, mut at) = (Vec::new(), Vec::new(), 0);
        for (number, stream) in streams.iter().enumerate() {
            let first_set = tables.first_sets.get(number);
            first_units.push(units.len());
            for number in 0..stream.entry.unit_count() {
                let [_, _, width, height] = stream.entry.unit_rect(number);
                let stride = stride_of(family, width, row_words);
                let unit = family.unit(&stream.header, [width, height], at);
                units.push(Unit { stride, base: first_set.copied().unwrap_or(unit.base), ..unit });
                at += stride * height;
            }
        }
        let buffers = Buffers {
            units: gpu.filled("units", &words_of(&units))?,
            states: gpu.buffer("states", units.len() * State::WORDS, none)?,
            pictures,
            log2_table: gpu.filled("log2_table", &codec::depth::domain::LOG2_TABLE)?,
            tables: gpu.filled("tables", &tables.words)?,
            dispatch: gpu.buffer("dispatch", Dispatch::WORDS, wgpu::BufferUsages::INDIRECT)?,
            items: Growing::new(gpu, "items")?,
            jobs: gpu.buffer("jobs", 4, none)?,
            scratch: gpu.scratch(scratch_words(streams) as usize)?,
        };
        for kernel in [Some(family.plan()), family.kernel.reader, Some(family.kernel)].into_iter().flatten() {
            gpu.pipeline(kernel)?;
        }
        Ok(GpuDecoder {
            gpu,
            decoder,
            streams: streams.to_vec(),
            family,
            first_units,
            shown: vec![None; units.len()],
            written: vec![0; units.len()],
            units,
            resident: Resident::new(gpu, gpu.info.max_binding_bytes as usize / 4)?,
            calls: 0,
            max_work: MAX_WORK,
            kept_words: usize::MAX,
            buffers,
            cost: DecodeCost::default(),
            wanted_pixels: 0,
            monitor: &Silent,
        })
    }

    /// Sets a monitor. A stop request makes a call fail with [`Error::Interrupted`].
    #[must_use]
    pub fn watched_by(self, monitor: &'a dyn Monitor) -> Self {
        GpuDecoder { monitor, ..self }
    }

    /// Limits the words of chunks in a buffer. For tests.
    pub fn limit_resident(&mut self, words: usize) -> Result<()> {
        self.resident = Resident::new(self.gpu, words.min(self.gpu.info.max_binding_bytes as usize / 4))?;
        Ok(())
    }

    /// Limits the invocations of a list. For tests.
    pub fn limit_work(&mut self, invocations: u64) {
        self.max_work = invocations.min(MAX_WORK);
    }

    /// Returns the maximum invocations of a list of units for a kernel.
    fn max_work(&self, kernel: &Kernel) -> u64 {
        let scratch_bytes = MAX_SCRATCH_BYTES.min(self.gpu.info.max_binding_bytes);
        let by_scratch = kernel.reader.map_or(MAX_WORK, |_| scratch_bytes / (4 * u64::from(SCRATCH_WORDS)));
        self.max_work.min(by_scratch)
    }

    /// Returns the family's kernel for a chunk type.
    fn kernel(&self, of: KernelOf) -> &'static Kernel {
        self.family.keyframes.filter(|_| of == KernelOf::Keyframes).unwrap_or(self.family.kernel)
    }

    pub fn decode(&mut self, frame: u32) -> Result<()> {
        let has_it = |at: &usize| self.streams[*at].frames.contains(frame);
        let units = (0..self.streams.len()).filter(has_it).flat_map(|at| self.wanted(at, frame, &AllUnits));
        let units: Vec<UnitFrame> = units.collect();
        self.decode_units(&units)
    }

    pub fn wanted(&self, stream: usize, frame: u32, filter: &dyn UnitFilter) -> Vec<UnitFrame> {
        let info = self.streams[stream];
        let units = (0..info.entry.unit_count()).filter(|&unit| filter.wants(info, unit, frame));
        units.map(|unit| UnitFrame { stream, unit, frame }).collect()
    }

    /// Decodes units. A unit may be listed only once.
    pub fn decode_units(&mut self, wanted: &[UnitFrame]) -> Result<()> {
        self.calls += 1;
        if self.resident.stream_words() > self.kept_words {
            self.drop_chunks(wanted)?;
        }
        for one in wanted {
            let unit = self.number(*one);
            self.written[unit] = 0;
        }
        let shapes = wanted.iter().map(|one| &self.units[self.number(*one)]);
        self.wanted_pixels += shapes.map(|unit| u64::from(unit.width) * u64::from(unit.height)).sum::<u64>();
        let mut batch = Batch::default();
        let listed = self.list(wanted, &mut batch);
        // Submit even after an error: the device must decode every unit that `shown` lists as decoded.
        let submitted = self.submit(&mut batch);
        let decoded = listed.and(submitted);
        if decoded.is_err() {
            // The next call lists all units again; the device has its own record of what each picture shows.
            self.shown.fill(None);
        }
        decoded
    }

    /// Drops chunks that these units do not need until at most `kept_words` remain.
    fn drop_chunks(&mut self, wanted: &[UnitFrame]) -> Result<()> {
        for &one in wanted {
            let (key, entry) = self.chunk(one)?;
            self.resident.needed(key, self.calls);
            let frame = one.frame - entry.key.first_frame;
            if self.resident.chunk(key).is_some_and(|chunk| chunk.timeline.blend(frame).1) {
                self.resident.needed(key + 1, self.calls);
            }
        }
        self.resident.flush(self.gpu)?;
        self.resident.drop_unneeded(self.calls, self.kept_words);
        Ok(())
    }

    /// Lists units, making their chunks resident; submits the list when no further chunk fits.
    fn list(&mut self, mut wanted: &[UnitFrame], batch: &mut Batch) -> Result<()> {
        while !wanted.is_empty() {
            self.monitor.check()?;
            let start = Instant::now();
            let (count, mut fetched) = self.fetch_missing(wanted)?;
            self.cost.fetching += start.elapsed();
            let (part, rest) = wanted.split_at(count);
            wanted = rest;
            for &one in part {
                if self.add(one, &mut fetched, batch)? {
                    continue;
                }
                self.submit(batch)?;
                self.resident.flush(self.gpu)?;
                self.resident.drop_unneeded(self.calls, 0);
                if self.add(one, &mut fetched, batch)? {
                    continue;
                }
                self.resident.clear();
                if !self.add(one, &mut fetched, batch)? {
                    let why = format!("it takes more than the {} bytes of a buffer", self.gpu.info.max_binding_bytes);
                    return Err(self.gpu.failed("a chunk", &why));
                }
            }
        }
        Ok(())
    }

    /// Returns the index of a unit among those of all streams.
    fn number(&self, one: UnitFrame) -> usize {
        self.first_units[one.stream] + one.unit as usize
    }

    /// Returns the number of a unit's pixels that the last call wrote.
    pub fn written(&self, one: UnitFrame) -> u64 {
        self.written[self.number(one)]
    }

    /// True if a unit's picture is known to show a frame.
    pub fn shows(&self, one: UnitFrame) -> bool {
        let Some(shown) = &self.shown[self.number(one)] else { return false };
        let Ok((key, entry)) = self.chunk(one) else { return false };
        let frame = one.frame - entry.key.first_frame;
        let alike = || self.family.is_color && shown.timeline.changed_pixels(frame, Some(shown.frame), 1) == 0;
        shown.key == key && (shown.frame == frame || alike())
    }

    /// Returns the frame that a unit's picture shows, if it belongs to this chunk.
    fn frame_of(&self, unit: usize, key: u32) -> Option<u32> {
        self.shown[unit].as_ref().filter(|shown| shown.key == key).map(|shown| shown.frame)
    }

    /// Returns a unit, with the position of its picture in [`GpuDecoder::pictures`].
    pub fn unit(&self, stream: usize, unit: u32) -> &Unit {
        &self.units[self.first_units[stream] + unit as usize]
    }

    pub fn pictures(&self) -> &wgpu::Buffer {
        &self.buffers.pictures
    }

    pub fn bytes_sent(&self) -> u64 {
        self.resident.bytes_sent() + self.buffers.items.bytes_sent
    }

    pub fn bytes(&self) -> u64 {
        let Buffers { units, states, pictures, log2_table, tables, dispatch, items, jobs, scratch: _ } = &self.buffers;
        let buffers = [units, states, pictures, log2_table, tables, dispatch, &items.buffer, jobs];
        self.resident.bytes() + buffers.into_iter().map(wgpu::Buffer::size).sum::<u64>()
    }

    /// Returns the chunk that holds a frame of a unit, and its key: its position in the index plus 1.
    fn chunk(&self, one: UnitFrame) -> Result<(u32, ChunkEntry)> {
        let (reader, stream) = (self.decoder.reader(), self.streams[one.stream]);
        if !stream.frames.contains(one.frame) {
            let frames = stream.frames;
            return Err(Error::Usage(format!("frame {} is not one of the stream's frames {frames}", one.frame)));
        }
        let chunks = &reader.index().chunks;
        let key = |chunk: &ChunkEntry| (chunk.key.stream, chunk.key.unit, chunk.key.first_frame);
        let after = chunks.partition_point(|chunk| key(chunk) <= (stream.index, one.unit, one.frame));
        let found = after.checked_sub(1).map(|at| chunks[at]).filter(|chunk| {
            (chunk.key.stream, chunk.key.unit) == (stream.index, one.unit)
                && one.frame - chunk.key.first_frame < chunk.key.frame_count
        });
        let entry = found
            .ok_or_else(|| Error::invalid(format!("no chunk holds frame {}", one.frame)).in_file(reader.path()))?;
        Ok((after as u32, entry))
    }

    fn chunk_after(&self, key: u32, entry: &ChunkEntry) -> Result<ChunkEntry> {
        let reader = self.decoder.reader();
        let next = reader.index().chunks.get(key as usize);
        let next = next.filter(|next| (next.key.stream, next.key.unit) == (entry.key.stream, entry.key.unit));
        next.copied().ok_or_else(|| Error::invalid(MISSING_NEXT_KEYFRAME).in_file(reader.path()))
    }

    fn fetch(&self, entry: &ChunkEntry) -> Result<Prepared> {
        let (reader, stream) = (self.decoder.reader(), &self.decoder.streams()[entry.key.stream as usize]);
        let payload = reader.fetch(entry)?;
        let place = reader.index().place(entry);
        prepare::prepare(&stream.header, payload, stream.unit_area(entry.key.unit), entry.key.frame_count, place)
            .map_err(|error| reader.blame(entry, error))
    }

    /// Fetches, in parallel, the missing chunks of the first units. Returns the number of these units, at least one, and the
    /// chunks.
    fn fetch_missing(&mut self, wanted: &[UnitFrame]) -> Result<(usize, HashMap<u32, Prepared>)> {
        let (mut missing, mut bytes, mut count) = (Vec::new(), 0, 0);
        for &one in wanted.iter().take(FETCH_TOGETHER) {
            let (key, entry) = self.chunk(one)?;
            let is_shown = self.frame_of(self.number(one), key) == Some(one.frame - entry.key.first_frame);
            if !is_shown && self.resident.chunk(key).is_none() {
                bytes += prepare::prepared_bytes(self.streams[one.stream], &entry);
                if bytes > FETCH_BYTES && !missing.is_empty() {
                    break;
                }
                missing.push((key, entry));
            }
            count += 1;
        }
        self.cost.bytes_read += missing.iter().map(|(_, entry)| u64::from(entry.stored_bytes)).sum::<u64>();
        let this = &*self;
        let fetched = try_map_ordered(missing, |(key, entry)| Ok((key, this.fetch(&entry)?)))?;
        Ok((count, fetched.into_iter().collect()))
    }

    /// Makes a chunk resident; returns `false` if there is no room for it.
    fn make_resident(&mut self, key: u32, entry: &ChunkEntry, fetched: &mut HashMap<u32, Prepared>) -> Result<bool> {
        if self.resident.chunk(key).is_some() {
            self.resident.needed(key, self.calls);
            return Ok(true);
        }
        let chunk = match fetched.remove(&key) {
            Some(chunk) => chunk,
            None => {
                self.cost.bytes_read += u64::from(entry.stored_bytes);
                self.fetch(entry)?
            }
        };
        let room = self.resident.has_room(&chunk);
        if room {
            self.resident.place(key, chunk, self.calls);
        } else {
            fetched.insert(key, chunk);
        }
        Ok(room)
    }

    /// Adds a unit to the list; returns `false` if its chunks do not fit beside the chunks of the listed units.
    fn add(&mut self, one: UnitFrame, fetched: &mut HashMap<u32, Prepared>, batch: &mut Batch) -> Result<bool> {
        let (key, entry) = self.chunk(one)?;
        let frame = one.frame - entry.key.first_frame;
        let unit = self.number(one);
        if self.frame_of(unit, key) == Some(frame) {
            return Ok(true);
        }
        if !self.make_resident(key, &entry, fetched)? {
            return Ok(false);
        }
        let mut next = NONE;
        if self.resident.chunk(key).is_some_and(|chunk| chunk.timeline.blend(frame).1) {
            let after = self.chunk_after(key, &entry)?;
            if !self.make_resident(key + 1, &after, fetched)? {
                return Ok(false);
            }
            next = self.resident.chunk(key + 1).map_or(NONE, |next| next.row);
        }
        let (rounds, pixels) = self.work(unit, key, frame);
        if rounds > MAX_ROUNDS {
            let why = format!("frame {} is {rounds} steps behind, at most {MAX_ROUNDS} are taken", one.frame);
            return Err(self.gpu.failed("a tile", &why));
        }
        let Some(resident) = self.resident.chunk(key) else { return Ok(false) };
        let ResidentChunk { row: chunk, max_work, kernel, passes, .. } = *resident;
        let timeline = Arc::clone(&resident.timeline);
        if batch.of(kernel).work + u64::from(max_work) > self.max_work(self.kernel(kernel)) {
            self.submit(batch)?;
        }
        let list = batch.of(kernel);
        list.items.push(Item { unit: unit as u32, chunk, next, frame, key });
        list.work += u64::from(max_work);
        list.rounds = list.rounds.max(rounds);
        list.passes = list.passes.max(passes);
        self.shown[unit] = Some(Shown { key, frame, timeline });
        self.written[unit] = pixels;
        self.cost.updated_pixels += pixels;
        Ok(true)
    }

    /// Returns the rounds that a unit needs to reach a frame of a resident chunk, at least one, and the pixels that they write.
    fn work(&self, unit: usize, key: u32, frame: u32) -> (u32, u64) {
        let Some(ResidentChunk { timeline, .. }) = self.resident.chunk(key) else { return (1, 0) };
        let at = self.frame_of(unit, key);
        let pixels = u64::from(self.units[unit].width) * u64::from(self.units[unit].height);
        if self.family.is_color {
            return (1, timeline.changed_pixels(frame, at, pixels));
        }
        let Ok(window @ 1..) = u8::try_from(self.units[unit].window) else { return (1, pixels) };
        let records = &timeline.records;
        let steps = record_table::steps(records, |record| record.0, at, frame, window);
        let (rounds, pixels) = steps.fold((0, 0), |(rounds, sum), step| (rounds + 1, sum + records[step].1));
        (rounds.max(1), pixels)
    }

    fn submit(&mut self, batch: &mut Batch) -> Result<()> {
        let Batch { codec, keyframes } = std::mem::take(batch);
        self.submit_list(&codec, self.kernel(KernelOf::Codec))?;
        self.submit_list(&keyframes, self.kernel(KernelOf::Keyframes))
    }

    fn submit_list(&mut self, list: &List, kernel: &'static Kernel) -> Result<()> {
        if list.items.is_empty() {
            return Ok(());
        }
        let gpu = self.gpu;
        let start = Instant::now();
        self.resident.flush(gpu)?;
        self.cost.fetching += start.elapsed();
        let start = Instant::now();
        self.buffers.list(gpu, &list.items)?;
        if kernel.reader.is_some() {
            self.buffers.scratch = gpu.scratch(list.work as usize * SCRATCH_WORDS as usize)?;
        }
        // Byte offsets in `Dispatch`: its size with one invocation per part of the work, and with one workgroup per part.
        let (invocations, workgroups) = (0, std::mem::offset_of!(Dispatch, part_x) as u64);
        let of_kernel = if kernel.reader.is_some() { workgroups } else { invocations };
        let steps = [(kernel.reader, list.passes, invocations), (Some(kernel), 1, of_kernel)];
        let mut decoding = Vec::new();
        for (kernel, times, size) in steps {
            let Some(kernel) = kernel else { continue };
            let pipeline = gpu.pipeline(kernel)?;
            decoding.push((self.bind(&pipeline), pipeline, times, size));
        }
        let plan = gpu.pipeline(self.family.plan())?;
        let plan_group = self.bind(&plan);
        let mut left = list.rounds;
        while left > 0 {
            let now = left.min(ROUNDS_TOGETHER);
            gpu.submit(self.family.kernel.name, |encoder| {
                for _ in 0..now {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                    pass.set_pipeline(&plan.pipeline);
                    pass.set_bind_group(0, &plan_group, &[]);
                    pass.dispatch_workgroups(1, 1, 1);
                    for (group, pipeline, times, size) in &decoding {
                        pass.set_pipeline(&pipeline.pipeline);
                        pass.set_bind_group(0, group, &[]);
                        (0..*times).for_each(|_| pass.dispatch_workgroups_indirect(&self.buffers.dispatch, *size));
                    }
                }
            })?;
            left -= now;
            // Wait between groups of rounds, so that a long chunk does not queue all its rounds at once.
            if left > 0 {
                gpu.wait()?;
                self.monitor.check()?;
            }
        }
        self.cost.applying += start.elapsed();
        Ok(())
    }

    fn bind(&self, pipeline: &Pipeline) -> wgpu::BindGroup {
        let buffer_of = |name: &str| match name {
            "units" => &self.buffers.units,
            "items" => &self.buffers.items.buffer,
            "states" => &self.buffers.states,
            "jobs" => &self.buffers.jobs,
            "dispatch" => &self.buffers.dispatch,
            "log2_table" => &self.buffers.log2_table,
            "tables" => &self.buffers.tables,
            "scratch" => &self.buffers.scratch,
            name => {
                let table = self.resident.tables.iter().find(|table| table.label == name);
                table.map_or(&self.buffers.pictures, |table| &table.buffer)
            }
        };
        self.gpu.bind(pipeline, |name| Some(buffer_of(name).as_entire_binding()))
    }

    pub fn wait(&mut self) -> Result<()> {
        let start = Instant::now();
        self.gpu.wait()?;
        self.cost.applying += start.elapsed();
        Ok(())
    }
}

impl Buffers {
    fn list(&mut self, gpu: &Gpu, items: &[Item]) -> Result<()> {
        self.items.clear();
        self.items.push(list_of([items.len() as u32, 0], items));
        self.items.flush(gpu)?;
        let job_words = LIST_HEAD_WORDS + items.len() * Job::WORDS;
        if 4 * job_words as u64 > self.jobs.size() {
            self.jobs = gpu.buffer("jobs", job_words, wgpu::BufferUsages::empty())?;
        }
        Ok(())
    }
}
