//! Counts the symbols of payloads, to train table sets.

use crate::color::transform::blocks::{Block, regions};
use crate::color::transform::coder::{Coder, Reader, SourceCoder};
use crate::color::transform::contexts::{Tables, Transform};
use crate::color::transform::domain::Keyed;
use crate::color::transform::encode::rate::Counts;
use crate::color::transform::payload::{Layout, check_frames, holds_cells};
use crate::color::transform::region::{Region, Setting, max_items};
use crate::entropy::{Decoder, PayloadCounts, Prices};
use crate::error::{Error, Result};

/// Counts the symbols of a payload that was encoded with `tables`; `None` if it has keyframes and weights.
pub fn count_payload<S: Keyed>(
    payload: &[u8],
    size: [usize; 2],
    frames: u32,
    tables: &Tables,
) -> Result<Option<PayloadCounts<Transform>>> {
    if holds_cells(payload) {
        return Ok(None);
    }
    check_frames(frames)?;
    let Layout { header, deltas, substreams } = Layout::parse::<S>(payload, size, tables)?;
    let set = &tables.sets()[header.set];
    let mut counts = Counts::default();
    for (([_, _, width, height], substream), delta) in regions(size).zip(substreams).zip(deltas) {
        let bytes = &payload[substream];
        let reader = Reader { stream: Decoder::new(bytes), tables: set };
        let root = Block::root([width, height], frames as usize);
        let counting = CountingReader { reader, counts: &mut counts };
        let setting = Setting { header: &header, delta, domain: &S::DOMAIN };
        Region::read_by(counting, max_items(bytes), root, setting).map_err(Error::invalid)?;
    }
    let bits = Prices::new(set).total(&counts);
    Ok(Some(PayloadCounts { counts, bytes: payload.len() as u64, bits }))
}

/// Coder that counts the symbols that it reads.
struct CountingReader<'a> {
    reader: Reader<'a>,
    counts: &'a mut Counts,
}

impl Coder for CountingReader<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        let symbol = self.reader.symbol(context, value);
        self.counts.count(context, symbol);
        symbol
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        self.reader.bits(value, count)
    }
}

impl SourceCoder for CountingReader<'_> {
    fn is_short(&self) -> bool {
        self.reader.is_short()
    }

    fn is_finished(&self) -> bool {
        self.reader.is_finished()
    }
}
