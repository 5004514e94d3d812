//! What lies on the device: bytes of chunks, and the tables that lead into them (GDC 5).
//!
//! Chunks come as they are needed and stay. Where a buffer is full, all are dropped at once: the units that are being
//! decoded soon have theirs again, and nothing has to be searched for room.

use std::collections::HashMap;

use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::layout::{BoxRow, Chunk, Record, Words, words_of};
use crate::gpu::prepare::{Prepared, Timeline};

/// Words that a buffer starts with.
const FIRST_WORDS: usize = 1 << 14;

/// A buffer that words are appended to.
#[derive(Debug)]
pub struct Growing {
    label: &'static str,
    buffer: wgpu::Buffer,
    words: usize,
    used: usize,
    /// Words that follow, not yet on the device.
    pending: Vec<u32>,
    /// Bytes that went to the device so far.
    sent: u64,
}

impl Growing {
    /// An empty one.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn new(gpu: &Gpu, label: &'static str) -> Result<Growing> {
        let buffer = gpu.buffer(label, FIRST_WORDS, wgpu::BufferUsages::empty())?;
        Ok(Growing { label, buffer, words: FIRST_WORDS, used: 0, pending: Vec::new(), sent: 0 })
    }

    /// Words in it.
    pub fn len(&self) -> usize {
        self.used + self.pending.len()
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes that went to the device so far.
    pub fn bytes_sent(&self) -> u64 {
        self.sent
    }

    /// The buffer, with all words once they were flushed.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Appends words.
    pub fn push(&mut self, words: &[u32]) {
        self.pending.extend_from_slice(words);
    }

    /// Forgets all words; those not yet on the device must not be needed any more.
    pub fn clear(&mut self) {
        self.used = 0;
        self.pending.clear();
    }

    /// Brings what was appended onto the device.
    ///
    /// # Errors
    /// The device has no memory, or allows no buffer of this size.
    pub fn flush(&mut self, gpu: &Gpu) -> Result<()> {
        let (needed, most) = (self.len(), gpu.info.max_binding_bytes as usize / 4);
        if needed > self.words {
            let words = needed.next_power_of_two().min(most).max(needed);
            let larger = gpu.buffer(self.label, words, wgpu::BufferUsages::empty())?;
            gpu.guard(self.label, || {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encoder.copy_buffer_to_buffer(&self.buffer, 0, &larger, 0, 4 * self.used as u64);
                gpu.queue.submit([encoder.finish()]);
            })?;
            (self.buffer, self.words) = (larger, words);
        }
        if !self.pending.is_empty() {
            gpu.guard(self.label, || {
                gpu.queue.write_buffer(&self.buffer, 4 * self.used as u64, bytemuck::cast_slice(&self.pending));
            })?;
            self.used = needed;
            self.sent += 4 * self.pending.len() as u64;
            self.pending.clear();
        }
        Ok(())
    }
}

/// A chunk on the device.
#[derive(Debug)]
pub struct Slot {
    /// Its row of the table of chunks.
    pub chunk: u32,
    /// Invocations that the largest of its records takes.
    pub most_work: u32,
    /// What the host knows of it.
    pub timeline: Timeline,
}

/// All chunks of some streams that are on the device.
#[derive(Debug)]
pub struct Resident {
    /// Bytes of chunks.
    pub stream: Growing,
    /// Table of records.
    pub records: Growing,
    /// Table of boxes.
    pub boxes: Growing,
    /// Table of chunks.
    pub chunks: Growing,
    slots: HashMap<u32, Slot>,
    most_words: usize,
}

impl Resident {
    /// Nothing yet; buffers grow up to `most_words` words.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn new(gpu: &Gpu, most_words: usize) -> Result<Resident> {
        Ok(Resident {
            stream: Growing::new(gpu, "stream")?,
            records: Growing::new(gpu, "records")?,
            boxes: Growing::new(gpu, "boxes")?,
            chunks: Growing::new(gpu, "chunks")?,
            slots: HashMap::new(),
            most_words,
        })
    }

    /// The chunk of a key, where it is there.
    pub fn slot(&self, key: u32) -> Option<&Slot> {
        self.slots.get(&key)
    }

    /// Whether there are no chunks.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Words of the chunks, tables apart.
    pub fn stream_words(&self) -> usize {
        self.stream.len()
    }

    /// Bytes that went to the device so far.
    pub fn bytes_sent(&self) -> u64 {
        [&self.stream, &self.records, &self.boxes, &self.chunks].into_iter().map(Growing::bytes_sent).sum()
    }

    /// Whether a chunk would find room.
    pub fn has_room(&self, chunk: &Prepared) -> bool {
        let room = |growing: &Growing, words: usize| growing.len() + words <= self.most_words;
        room(&self.stream, chunk.stream.len() + 4)
            && room(&self.records, chunk.records.len() * Record::WORDS)
            && room(&self.boxes, chunk.boxes.len() * BoxRow::WORDS)
            && room(&self.chunks, Chunk::WORDS)
    }

    /// Drops all chunks.
    pub fn clear(&mut self) {
        [&mut self.stream, &mut self.records, &mut self.boxes, &mut self.chunks].into_iter().for_each(Growing::clear);
        self.slots.clear();
    }

    /// Puts a chunk behind the others.
    pub fn place(&mut self, key: u32, chunk: Prepared) {
        // Frames of nodes start on multiples of 16 bytes.
        let padding = self.stream.len().next_multiple_of(4) - self.stream.len();
        self.stream.pending.extend(std::iter::repeat_n(0, padding));
        let word = self.stream.len() as u32;
        let first_box = (self.boxes.len() / BoxRow::WORDS) as u32;
        let first_record = (self.records.len() / Record::WORDS) as u32;
        // Nodes are found by words, all else by bytes.
        let start = if chunk.is_nodes() { word } else { 4 * word };
        let records = chunk.records.iter();
        let records = records.map(|row| Record { at: row.at + start, first: row.first + first_box, ..*row });
        let boxes = chunk.boxes.iter().map(|row| BoxRow { at: row.at + 4 * word, ..*row });
        let [weights_at, weight_count] = chunk.weights;
        let record_count = chunk.records.len() as u32;
        let most_work = chunk.records.iter().map(|row| row.work).max().unwrap_or(0);
        let row = Chunk { first_record, record_count, weights_at: weights_at + 4 * word, weight_count };
        let slot = (self.chunks.len() / Chunk::WORDS) as u32;
        self.records.pending.extend(words_of(&records.collect::<Vec<_>>()));
        self.boxes.pending.extend(words_of(&boxes.collect::<Vec<_>>()));
        self.chunks.pending.extend(words_of(&[row]));
        self.stream.pending.extend(chunk.stream);
        self.slots.insert(key, Slot { chunk: slot, most_work, timeline: chunk.timeline });
    }

    /// Brings what was placed onto the device.
    ///
    /// # Errors
    /// The device has no memory, or allows no buffer of this size.
    pub fn flush(&mut self, gpu: &Gpu) -> Result<()> {
        [&mut self.stream, &mut self.records, &mut self.boxes, &mut self.chunks]
            .into_iter()
            .try_for_each(|growing| growing.flush(gpu))
    }
}
