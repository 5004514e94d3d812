//! Buffers of resident chunks: bytes of chunks, and tables of offsets into them (GDC 5).
//!
//! Chunks are loaded on demand and stay resident. Dropped chunks leave gaps, which are reused; resident chunks never move. If a
//! chunk still does not fit, all chunks are dropped.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

use crate::Gpu;
use codec::error::Result;
use kernels::layout::{BoxRow, Chunk, Record, words_of};
use kernels::prepare::{KernelOf, Prepared, Timeline};

const FIRST_WORDS: usize = 1 << 14;

pub struct Growing {
    pub label: &'static str,
    /// Contains all words after a flush.
    pub buffer: wgpu::Buffer,
    /// End of the allocated words.
    len: usize,
    gaps: Gaps,
    /// Words that are not yet on the device, with the position of the first.
    pending: Vec<(usize, Vec<u32>)>,
    pub bytes_sent: u64,
}

/// Free ranges; adjacent ones are merged.
#[derive(Default)]
struct Gaps {
    /// Length of each range in words, by its start.
    ranges: BTreeMap<usize, usize>,
    /// Total words of all ranges.
    words: usize,
}

impl Gaps {
    /// Returns the start of the smallest gap with at least `words` words, the first one if several are equal.
    fn find(&self, words: usize) -> Option<usize> {
        let large = self.ranges.iter().filter(|(_, gap)| **gap >= words);
        large.min_by_key(|(at, gap)| (**gap, **at)).map(|(at, _)| *at)
    }

    /// Allocates words from the front of the gap that begins at `at`.
    fn take(&mut self, at: usize, words: usize) {
        let left = self.remove(at).saturating_sub(words);
        if left > 0 {
            self.insert(at + words, left);
        }
    }

    fn insert(&mut self, at: usize, words: usize) {
        self.ranges.insert(at, words);
        self.words += words;
    }

    /// Removes the gap that begins at `at`, if any; returns its length in words.
    fn remove(&mut self, at: usize) -> usize {
        let words = self.ranges.remove(&at).unwrap_or(0);
        self.words -= words;
        words
    }

    /// Adds a range and merges it with adjacent gaps; returns the merged gap.
    fn add(&mut self, mut range: Range<usize>) -> Range<usize> {
        let before = self.ranges.range(..range.start).next_back().map(|(at, words)| *at..at + words);
        if let Some(gap) = before.filter(|gap| gap.end == range.start) {
            range.start = gap.start;
            self.remove(gap.start);
        }
        range.end += self.remove(range.end);
        if !range.is_empty() {
            self.insert(range.start, range.len());
        }
        range
    }
}

impl Growing {
    pub fn new(gpu: &Gpu, label: &'static str) -> Result<Growing> {
        let buffer = gpu.buffer(label, FIRST_WORDS, wgpu::BufferUsages::empty())?;
        Ok(Growing { label, buffer, len: 0, gaps: Gaps::default(), pending: Vec::new(), bytes_sent: 0 })
    }

    /// Returns the allocated words, without gaps.
    pub fn taken(&self) -> usize {
        self.len - self.gaps.words
    }

    /// True if `words` words fit into a buffer of at most `most` words.
    fn has_room(&self, words: usize, most: usize) -> bool {
        self.gaps.find(words).is_some() || self.len + words <= most
    }

    /// Allocates words: in the smallest sufficient gap, otherwise at the end.
    fn place(&mut self, words: usize) -> Range<usize> {
        let at = match self.gaps.find(words) {
            Some(at) => {
                self.gaps.take(at, words);
                at
            }
            None => self.len,
        };
        self.len = self.len.max(at + words);
        at..at + words
    }

    fn put(&mut self, at: usize, words: Vec<u32>) {
        match self.pending.last_mut() {
            Some((start, pending)) if *start + pending.len() == at => pending.extend(words),
            _ => self.pending.push((at, words)),
        }
    }

    pub fn push(&mut self, words: Vec<u32>) {
        let at = self.len;
        self.len += words.len();
        self.put(at, words);
    }

    /// Frees words, which must have been flushed.
    fn free(&mut self, range: Range<usize>) {
        let gap = self.gaps.add(range);
        if gap.end == self.len {
            self.gaps.remove(gap.start);
            self.len = gap.start;
        }
    }

    /// Frees all words, including those not flushed.
    pub fn clear(&mut self) {
        self.len = 0;
        self.gaps = Gaps::default();
        self.pending.clear();
    }

    pub fn flush(&mut self, gpu: &Gpu) -> Result<()> {
        let (needed, most) = (self.len, gpu.info.max_binding_bytes as usize / 4);
        if 4 * needed as u64 > self.buffer.size() {
            let words = needed.next_power_of_two().min(most).max(needed);
            let larger = gpu.buffer(self.label, words, wgpu::BufferUsages::empty())?;
            gpu.submit(self.label, |encoder| {
                encoder.copy_buffer_to_buffer(&self.buffer, 0, &larger, 0, self.buffer.size());
            })?;
            self.buffer = larger;
        }
        if !self.pending.is_empty() {
            gpu.guard(self.label, || {
                for (at, words) in &self.pending {
                    gpu.queue.write_buffer(&self.buffer, 4 * *at as u64, bytemuck::cast_slice(words));
                }
            })?;
            self.bytes_sent += self.pending.iter().map(|(_, words)| 4 * words.len() as u64).sum::<u64>();
            self.pending.clear();
        }
        Ok(())
    }
}

pub struct ResidentChunk {
    /// Row in the table of chunks.
    pub row: u32,
    /// Maximum invocations of any of its records.
    pub max_work: u32,
    pub kernel: KernelOf,
    /// See [`Prepared::passes`].
    pub passes: u32,
    pub timeline: Arc<Timeline>,
    /// The last call that needed it.
    last_used: u64,
    /// Its ranges in the tables of bytes, records, boxes and chunks.
    places: [Range<usize>; 4],
}

pub struct Resident {
    /// Bytes of chunks, then the rows of records, boxes and chunks.
    pub tables: [Growing; 4],
    resident: HashMap<u32, ResidentChunk>,
    max_words: usize,
}

impl Resident {
    /// Creates empty tables, whose buffers grow up to `max_words` words.
    pub fn new(gpu: &Gpu, max_words: usize) -> Result<Resident> {
        let table = |label| Growing::new(gpu, label);
        let tables = [table("stream")?, table("records")?, table("boxes")?, table("chunks")?];
        Ok(Resident { tables, resident: HashMap::new(), max_words })
    }

    pub fn chunk(&self, key: u32) -> Option<&ResidentChunk> {
        self.resident.get(&key)
    }

    /// Marks a chunk as needed by a call. Chunks of earlier calls are dropped first.
    pub fn needed(&mut self, key: u32, call: u64) {
        if let Some(chunk) = self.resident.get_mut(&key) {
            chunk.last_used = call;
        }
    }

    /// Returns the words of chunk bytes, without the other tables.
    pub fn stream_words(&self) -> usize {
        self.tables[0].taken()
    }

    pub fn bytes_sent(&self) -> u64 {
        self.tables.iter().map(|table| table.bytes_sent).sum()
    }

    pub fn bytes(&self) -> u64 {
        self.tables.iter().map(|table| table.buffer.size()).sum()
    }

    pub fn has_room(&self, chunk: &Prepared) -> bool {
        self.tables.iter().zip(words_taken(chunk)).all(|(table, words)| table.has_room(words, self.max_words))
    }

    /// Drops chunks that a call does not need, least recently needed first, until at most `words` words of chunks remain. All
    /// chunks must have been flushed.
    pub fn drop_unneeded(&mut self, call: u64, words: usize) {
        let unneeded = self.resident.iter().filter(|(_, chunk)| chunk.last_used != call);
        let mut unneeded: Vec<(u64, u32)> = unneeded.map(|(key, chunk)| (chunk.last_used, *key)).collect();
        unneeded.sort_unstable();
        for (_, key) in unneeded {
            if self.stream_words() <= words {
                break;
            }
            let Some(chunk) = self.resident.remove(&key) else { continue };
            self.tables.iter_mut().zip(chunk.places).for_each(|(table, place)| table.free(place));
        }
    }

    pub fn clear(&mut self) {
        self.tables.iter_mut().for_each(Growing::clear);
        self.resident.clear();
    }

    pub fn place(&mut self, key: u32, chunk: Prepared, call: u64) {
        let words = words_taken(&chunk);
        let places = [0, 1, 2, 3].map(|table| self.tables[table].place(words[table]));
        let [at, first_record, first_box, number] = [(0, 1), (1, Record::WORDS), (2, BoxRow::WORDS), (3, Chunk::WORDS)]
            .map(|(table, row_words): (usize, usize)| (places[table].start / row_words) as u32);
        // Nodes are addressed in words, all other records in bytes.
        let start = if chunk.is_nodes() { at } else { 4 * at };
        let records = chunk.records.iter();
        let records = records.map(|row| Record { at: row.at + start, first: row.first + first_box, ..*row });
        let boxes = chunk.boxes.iter().map(|row| BoxRow { at: row.at + 4 * at, ..*row });
        let [weights_at, weight_count] = chunk.weights;
        let record_count = chunk.records.len() as u32;
        let row = Chunk { first_record, record_count, weights_at: weights_at + 4 * at, weight_count };
        let rows = [words_of(&records.collect::<Vec<_>>()), words_of(&boxes.collect::<Vec<_>>()), words_of(&[row])];
        let max_work = chunk.records.iter().map(|row| row.work).max().unwrap_or(0);
        let mut stream = chunk.stream;
        stream.resize(words[0], 0);
        for ((table, place), words) in self.tables.iter_mut().zip(&places).zip([stream].into_iter().chain(rows)) {
            table.put(place.start, words);
        }
        let (kernel, passes, timeline) = (chunk.kernel, chunk.passes, Arc::new(chunk.timeline));
        let resident = ResidentChunk { row: number, max_work, kernel, passes, timeline, last_used: call, places };
        self.resident.insert(key, resident);
    }

    pub fn flush(&mut self, gpu: &Gpu) -> Result<()> {
        self.tables.iter_mut().try_for_each(|table| table.flush(gpu))
    }
}

/// Returns the words that a chunk occupies in the tables of bytes, records, boxes and chunks.
fn words_taken(chunk: &Prepared) -> [usize; 4] {
    [
        // Frames of nodes start at multiples of 16 bytes.
        chunk.stream.len().next_multiple_of(4),
        chunk.records.len() * Record::WORDS,
        chunk.boxes.len() * BoxRow::WORDS,
        Chunk::WORDS,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_joined_and_the_smallest_that_suffices_is_filled() {
        let mut gaps = Gaps::default();
        assert_eq!(gaps.add(8..12), 8..12);
        assert_eq!(gaps.add(20..30), 20..30);
        assert_eq!((gaps.find(4), gaps.find(5), gaps.find(11)), (Some(8), Some(20), None));
        // Between the two gaps, adjacent to the first.
        assert_eq!(gaps.add(12..14), 8..14);
        assert_eq!(gaps.add(14..20), 8..30);
        assert_eq!((gaps.words, gaps.ranges.len()), (22, 1));
        gaps.take(8, 22);
        assert_eq!((gaps.words, gaps.find(1)), (0, None));
        gaps.add(4..6);
        gaps.add(2..4);
        gaps.take(2, 1);
        assert_eq!((gaps.words, gaps.find(3)), (3, Some(3)));
    }
}
