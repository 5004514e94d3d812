//! Trains entropy tables of the transform codec (color.md 6.7) on the colour of containers.
//!
//! Chunks that share their place in a file count once, as they are stored once.

#![doc(hidden)]

use std::collections::HashSet;

use serde::Serialize;

use crate::color::HalfKey;
use crate::color::transform::Tables;
use crate::color::transform::encode::{PayloadCounts, PricedTables, Trainer, table_text};
use crate::container::ChunkEntry;
use crate::decode::{Decoder, memory};
use crate::error::{Error, Result};
use crate::memory::{Budget, Need};
use crate::monitor::Monitor;
use crate::ordered::try_map_at_once;
use crate::streams::{CodecHeader, StreamInfo};

#[derive(Debug, Clone, Copy)]
pub struct TrainSettings {
    /// Number of table sets, 1 to [`crate::color::transform::tables::MOST_OWN`].
    pub sets: usize,
    pub memory: Budget,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TrainSummary {
    /// Payloads of transform blocks and palettes.
    pub payloads: u64,
    pub symbols: u64,
    pub sets: usize,
    pub payload_bytes: u64,
    /// Bytes of the same symbols where each payload has the cheapest set, trained or built in.
    pub trained_payload_bytes: u64,
    /// Bytes of the sets in a codec header.
    pub table_bytes: u64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The sets in the form of formats/color-tables.txt.
    pub text: String,
    pub summary: TrainSummary,
}

/// A chunk to count.
#[derive(Debug, Clone, Copy)]
pub struct TrainingChunk<'a> {
    input: usize,
    stream: &'a StreamInfo,
    chunk: &'a ChunkEntry,
}

/// Colour chunks of the transform codec.
///
/// # Errors
/// [`Error::Invalid`] names an input that has none.
pub fn find_chunks(inputs: &[Decoder]) -> Result<Vec<TrainingChunk<'_>>> {
    let mut found = Vec::new();
    for (input, decoder) in inputs.iter().enumerate() {
        let (before, mut places) = (found.len(), HashSet::new());
        for stream in decoder.streams().iter().filter(|stream| tables_of(stream).is_some()) {
            let chunks = decoder.reader().index().stream_chunks(stream.index).iter();
            let chunks = chunks.filter(|chunk| places.insert((chunk.offset, chunk.stored_bytes)));
            found.extend(chunks.map(|chunk| TrainingChunk { input, stream, chunk }));
        }
        if found.len() == before {
            return Err(nothing_to_count(decoder));
        }
    }
    Ok(found)
}

fn tables_of(stream: &StreamInfo) -> Option<&Tables> {
    if let CodecHeader::Color(header) = &stream.header { header.tables() } else { None }
}

fn nothing_to_count(decoder: &Decoder) -> Error {
    Error::invalid("no colour in transform blocks: encode it with `color_codec` transform")
        .in_file(decoder.reader().path())
}

/// Trains on chunks that [`find_chunks`] found in `inputs`; the monitor advances by one for each.
pub fn train(
    inputs: &[Decoder],
    chunks: Vec<TrainingChunk<'_>>,
    settings: TrainSettings,
    monitor: &dyn Monitor,
) -> Result<Trained> {
    let TrainSettings { sets, memory } = settings;
    let each = chunks.iter().map(|at| memory::chunk_bytes(&at.stream.header, &at.stream.entry, at.chunk)).max();
    let containers: u64 = inputs.iter().map(|decoder| memory::container_bytes(decoder.reader())).sum();
    let fixed = containers + chunks.len() as u64 * PayloadCounts::BYTES;
    let need = Need { what: "training", fixed, each: each.unwrap_or(0), instead: "fewer inputs" };
    let at_once = memory.at_once(&need, rayon::current_num_threads())?;
    let counted = try_map_at_once(chunks, at_once, |at| {
        monitor.check()?;
        let counts = count(&inputs[at.input], at)?;
        monitor.advance(1);
        Ok((at.input, counts))
    })?;
    for (at, decoder) in inputs.iter().enumerate() {
        if !counted.iter().any(|(input, counts)| *input == at && counts.is_some()) {
            return Err(nothing_to_count(decoder));
        }
    }
    let trainer = Trainer::new(counted.into_iter().filter_map(|(_, counts)| counts).collect());
    let payloads = trainer.payloads().len();
    if payloads < sets {
        return Err(Error::Usage(format!("`sets` {sets}: more than the inputs have payloads, {payloads}")));
    }
    let own = trainer.train(sets);
    let text = table_text::write(&own);
    let tables = Tables::with_own(own);
    let mut header = Vec::new();
    tables.write(&mut header);
    let summary = TrainSummary {
        payloads: payloads as u64,
        symbols: trainer.payloads().iter().map(PayloadCounts::symbols).sum(),
        sets,
        payload_bytes: trainer.bytes(),
        trained_payload_bytes: trainer.bytes_with(&PricedTables::new(tables)),
        // Less the number of sets, which every header has.
        table_bytes: header.len() as u64 - 1,
    };
    Ok(Trained { text, summary })
}

fn count(decoder: &Decoder, at: TrainingChunk<'_>) -> Result<Option<PayloadCounts>> {
    let TrainingChunk { stream, chunk, .. } = at;
    let Some(tables) = tables_of(stream) else { return Ok(None) };
    let tables = PricedTables::new(tables.clone());
    let payload = decoder.reader().fetch(chunk)?;
    let [_, _, width, height] = stream.entry.unit_rect(chunk.key.unit);
    let (size, frames) = ([width as usize, height as usize], chunk.key.frame_count);
    let counts = match stream.is_half_float() {
        Some(true) => PayloadCounts::of::<HalfKey>(&payload, size, frames, &tables),
        _ => PayloadCounts::of::<u8>(&payload, size, frames, &tables),
    };
    counts.map_err(|error| decoder.reader().blame(chunk, error))
}
