//! Trains entropy tables of the transform codec (color.md 6.7) and of predictive depth (depth.md 15.8) on containers.
//!
//! A chunk that several entries of an index share is stored once, and counted once.

use std::collections::HashSet;
use std::io::Read;
use std::path::Path;

use serde::Serialize;

use codec::color::HalfKey;
use codec::color::transform::Transform;
use codec::color::transform::encode::count_payload;
use codec::container::ChunkEntry;
use codec::decode::{Decoder, memory};
use codec::depth::predictive::{Predictive, PredictiveChunk};
use codec::entropy::{Counts, Model, PayloadCounts, PricedTables, TableSet, Tables, Trainer, table_text};
use codec::error::{Error, Result};
use codec::memory::{Budget, Need};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams::{CodecHeader, DepthCoding, StreamInfo};

use crate::files::open_regular;

/// Largest file of tables; a set takes some 5 kB.
const MAX_BYTES: u64 = 1 << 20;

/// Reads the table sets of a text file, at least one.
pub fn read_tables<M: Model>(path: &Path) -> Result<Vec<TableSet<M>>> {
    let mut text = Vec::new();
    open_regular(path)?.take(MAX_BYTES + 1).read_to_end(&mut text).map_err(|error| Error::io(path, error))?;
    if text.len() as u64 > MAX_BYTES {
        return Err(Error::invalid(format!("a file of entropy tables has at most {MAX_BYTES} bytes")).in_file(path));
    }
    table_text::read(&text).map_err(|error| error.in_file(path))
}

/// A codec with trained tables.
pub trait TrainedCodec: Model {
    /// Error for a container without a payload to count.
    const NOTHING_TO_COUNT: &'static str;

    /// Returns the tables of a stream; `None` if it has another codec.
    fn tables_of(stream: &StreamInfo) -> Option<&Tables<Self>>;

    /// Counts the symbols of a chunk's payload; `None` if it has no symbols of the model.
    fn count(stream: &StreamInfo, chunk: &ChunkEntry, payload: &[u8]) -> Result<Option<PayloadCounts<Self>>>;
}

impl TrainedCodec for Transform {
    const NOTHING_TO_COUNT: &'static str = "no colour of the transform codec: encode it with `color_codec` transform";

    fn tables_of(stream: &StreamInfo) -> Option<&Tables<Transform>> {
        if let CodecHeader::Color(header) = &stream.header { header.tables() } else { None }
    }

    fn count(stream: &StreamInfo, chunk: &ChunkEntry, payload: &[u8]) -> Result<Option<PayloadCounts<Transform>>> {
        let Some(tables) = Transform::tables_of(stream) else { return Ok(None) };
        let [_, _, width, height] = stream.entry.unit_rect(chunk.key.unit);
        let (size, frames) = ([width as usize, height as usize], chunk.key.frame_count);
        match stream.is_half_float() {
            Some(true) => count_payload::<HalfKey>(payload, size, frames, tables),
            _ => count_payload::<u8>(payload, size, frames, tables),
        }
    }
}

impl TrainedCodec for Predictive {
    const NOTHING_TO_COUNT: &'static str = "no predictive depth: encode it with `depth_codec` predictive";

    fn tables_of(stream: &StreamInfo) -> Option<&Tables<Predictive>> {
        let CodecHeader::Depth(header) = &stream.header else { return None };
        if let DepthCoding::Predictive(header) = &header.coding { Some(&header.tables) } else { None }
    }

    fn count(stream: &StreamInfo, chunk: &ChunkEntry, payload: &[u8]) -> Result<Option<PayloadCounts<Predictive>>> {
        let CodecHeader::Depth(header) = &stream.header else { return Ok(None) };
        let DepthCoding::Predictive(header) = &header.coding else { return Ok(None) };
        let (area, frames) = (stream.unit_area(chunk.key.unit), chunk.key.frame_count);
        PredictiveChunk::parse(payload.to_vec(), header.clone(), area, frames)?.count().map(Some)
    }
}

#[derive(Debug, Clone, Copy)]
pub struct TrainSettings {
    /// Number of table sets, 1 to [`codec::entropy::tables::MAX_OWN`].
    pub sets: usize,
    pub memory: Budget,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TrainSummary {
    /// Number of payloads of the codec.
    pub payloads: u64,
    pub symbols: u64,
    pub sets: usize,
    pub payload_bytes: u64,
    /// Bytes of the same symbols if each payload uses its cheapest set, trained or built in.
    pub trained_payload_bytes: u64,
    /// Bytes of the trained sets in a codec header.
    pub table_bytes: u64,
    /// Result on containers that were not trained on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// Size of containers that were not trained on, with their own sets and with the trained sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct HeldOut {
    pub payloads: u64,
    pub payload_bytes: u64,
    /// Bytes of the same symbols if each payload uses its cheapest trained set; no built-in set is used.
    pub trained_payload_bytes: u64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The trained sets, in the text form of the table files in `formats/`.
    pub text: String,
    pub summary: TrainSummary,
}

/// Containers and their chunks of one codec.
#[derive(Debug)]
pub struct Footage<'a> {
    inputs: &'a [Decoder],
    chunks: Vec<TrainingChunk<'a>>,
}

#[derive(Debug, Clone, Copy)]
struct TrainingChunk<'a> {
    input: usize,
    stream: &'a StreamInfo,
    chunk: &'a ChunkEntry,
}

impl<'a> Footage<'a> {
    /// Collects the chunks of codec `C` in all inputs.
    ///
    /// # Errors
    /// [`Error::Invalid`] names an input without a chunk of the codec.
    pub fn find<C: TrainedCodec>(inputs: &'a [Decoder]) -> Result<Footage<'a>> {
        let mut found = Vec::new();
        for (input, decoder) in inputs.iter().enumerate() {
            let (before, mut places) = (found.len(), HashSet::new());
            for stream in decoder.streams().iter().filter(|stream| C::tables_of(stream).is_some()) {
                let chunks = decoder.reader().index().stream_chunks(stream.index).iter();
                let chunks = chunks.filter(|chunk| places.insert((chunk.offset, chunk.stored_bytes)));
                found.extend(chunks.map(|chunk| TrainingChunk { input, stream, chunk }));
            }
            if found.len() == before {
                return Err(nothing_to_count::<C>(decoder));
            }
        }
        Ok(Footage { inputs, chunks: found })
    }

    pub fn chunk_count(&self) -> u64 {
        self.chunks.len() as u64
    }

    /// Bytes of the containers with the counts of all chunks, and maximum bytes to count one chunk.
    fn bytes<C: TrainedCodec>(&self) -> [u64; 2] {
        let chunk_bytes = |at: &TrainingChunk<'_>| memory::chunk_bytes(&at.stream.header, &at.stream.entry, at.chunk);
        let containers: u64 = self.inputs.iter().map(|decoder| memory::container_bytes(decoder.reader())).sum();
        let counts = self.chunk_count() * (Counts::<C>::BYTES + size_of::<PayloadCounts<C>>() as u64);
        [containers + counts, self.chunks.iter().map(chunk_bytes).max().unwrap_or(0)]
    }

    /// Counts the symbols of all chunks. The monitor advances by one per chunk.
    fn count<C: TrainedCodec>(self, at_once: usize, monitor: &dyn Monitor) -> Result<Trainer<C>> {
        let Footage { inputs, chunks } = self;
        let counted = try_map_at_once(chunks, at_once, |at| {
            monitor.check()?;
            let counts = count::<C>(&inputs[at.input], at)?;
            monitor.advance(1);
            Ok((at.input, counts))
        })?;
        for (at, decoder) in inputs.iter().enumerate() {
            if !counted.iter().any(|(input, counts)| *input == at && counts.is_some()) {
                return Err(nothing_to_count::<C>(decoder));
            }
        }
        Ok(Trainer::new(counted.into_iter().filter_map(|(_, counts)| counts).collect()))
    }
}

fn nothing_to_count<C: TrainedCodec>(decoder: &Decoder) -> Error {
    Error::invalid(C::NOTHING_TO_COUNT).in_file(decoder.reader().path())
}

/// Trains sets on `footage` and measures them on `held_out`. The monitor advances by one per chunk.
pub fn train<C: TrainedCodec>(
    footage: Footage<'_>,
    held_out: Option<Footage<'_>>,
    settings: TrainSettings,
    monitor: &dyn Monitor,
) -> Result<Trained> {
    let TrainSettings { sets, memory } = settings;
    let all = [Some(&footage), held_out.as_ref()].into_iter().flatten().map(Footage::bytes::<C>);
    let [fixed, each] = all.fold([0, 0], |[fixed, each], [held, chunk]| [fixed + held, each.max(chunk)]);
    let need = Need { what: "training", fixed, each, instead: "fewer containers" };
    let at_once = memory.at_once(&need, rayon::current_num_threads())?;
    let trainer = footage.count::<C>(at_once, monitor)?;
    let payloads = trainer.payloads().len();
    if payloads < sets {
        return Err(Error::Usage(format!("`sets` {sets}: the inputs have only {payloads} payloads")));
    }
    let own = trainer.train(sets);
    let measure = |footage: Footage<'_>| {
        let held_out = footage.count::<C>(at_once, monitor)?;
        Ok::<_, Error>(HeldOut {
            payloads: held_out.payloads().len() as u64,
            payload_bytes: held_out.bytes(),
            trained_payload_bytes: held_out.bytes_with(&PricedTables::new(Tables::of_sets(own.clone()))),
        })
    };
    let held_out = held_out.map(measure).transpose()?;
    let text = table_text::write(&own);
    let tables = Tables::with_own(own);
    let mut header = Vec::new();
    tables.write(&mut header);
    let summary = TrainSummary {
        payloads: payloads as u64,
        symbols: trainer.symbols(),
        sets,
        payload_bytes: trainer.bytes(),
        trained_payload_bytes: trainer.bytes_with(&PricedTables::new(tables)),
        table_bytes: header.len() as u64,
        held_out,
    };
    Ok(Trained { text, summary })
}

fn count<C: TrainedCodec>(decoder: &Decoder, at: TrainingChunk<'_>) -> Result<Option<PayloadCounts<C>>> {
    let TrainingChunk { stream, chunk, .. } = at;
    let payload = decoder.reader().fetch(chunk)?;
    C::count(stream, chunk, &payload).map_err(|error| decoder.reader().blame(chunk, error))
}
