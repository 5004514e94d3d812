//! Joins the shards of one encode to the container that the encode would have written (container.md 6.4).

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Write;

use crate::pack::join::{Copier, PackSettings, PackSummary, Repack, batch_length, limits, merge_attributes};
use codec::container::{ChunkEntry, ChunkKey, PackedChunk, Reader, StreamEntry, Writer};
use codec::error::{Error, Result, counted};
use codec::image::{Face, StreamKind};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams;
use codec::streams::shard::{FootageDigests, SHARD, SHARD_FOOTAGE, ShardEntry, WholeStream};

/// Maximum bytes of adjacent chunks that are read with one system call, to reduce the cost of calls.
const RUN_BYTES: u64 = 512 << 10;

/// Streams of the joined container, and the inputs that hold their chunks.
pub(super) struct Joined<'a> {
    inputs: &'a [Reader],
    whole: Vec<WholeStream>,
    /// Stream entries of the joined container.
    pub streams: Vec<StreamEntry>,
    /// Pieces by group and first frame; a group is that of [`WholeStream`].
    pieces: BTreeMap<(u32, u32), Piece>,
}

struct Piece {
    input: usize,
    /// Stream of the joined container by stream of the input.
    streams: HashMap<u32, u32>,
}

/// Returns the shard attribute of each input; `None` if no input is a shard.
///
/// # Errors
/// [`Error::Invalid`] if some inputs are not shards, or are shards of other encodes.
pub(super) fn shard_entries(inputs: &[Reader]) -> Result<Option<Vec<ShardEntry>>> {
    let value = |reader: &Reader| {
        let value = reader.index().attributes.get(SHARD)?;
        Some(ShardEntry::read(value).map_err(|error| error.in_file(reader.path())))
    };
    let entries: Vec<Option<ShardEntry>> =
        inputs.iter().map(|reader| value(reader).transpose()).collect::<Result<_>>()?;
    if entries.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut shards = Vec::new();
    for (reader, entry) in inputs.iter().zip(entries) {
        let Some(entry) = entry else {
            let message = "this is a complete container among shards: pack the shards separately first";
            return Err(Error::invalid(message).in_file(reader.path()));
        };
        shards.push(entry);
    }
    for (reader, shard) in inputs.iter().zip(&shards) {
        if (shard.job, &shard.streams) != (shards[0].job, &shards[0].streams) {
            let message = not_of_one_encode(&inputs[0], reader, &shards[0]);
            return Err(Error::invalid(message).in_file(reader.path()));
        }
        if reader.index().probes != inputs[0].index().probes {
            let message = format!("its probes are not those of {}", inputs[0].path().display());
            return Err(Error::invalid(message).in_file(reader.path()));
        }
    }
    Ok(Some(shards))
}

/// Describes how a shard differs from the first one, as far as their attributes state it.
fn not_of_one_encode(first: &Reader, other: &Reader, shard: &ShardEntry) -> String {
    let digests = |reader: &Reader| {
        FootageDigests::read(reader.index().attributes.get(SHARD_FOOTAGE)?, shard.streams.len()).map(|found| found.0)
    };
    let than = first.path().display();
    let (footage, others) =
        ("other footage", "other settings, another version of lightfold or another kind of processor");
    let (Some(of_first), Some(of_other)) = (digests(first), digests(other)) else {
        return format!("a shard of another encode than {than}: {footage}, {others}");
    };
    let mut differing = shard.streams.iter().zip(of_first.iter().zip(&of_other)).filter(|(_, (a, b))| a != b);
    let Some((stream, _)) = differing.next() else {
        return format!("a shard of another encode than {than}: {others}");
    };
    let more = match differing.count() {
        0 => String::new(),
        more => format!(" and {}", counted(more as u64, "further stream")),
    };
    format!(
        "a shard of another encode than {than}: {footage}, whose {}{more} {} different content: encode all shards \
        from the same footage",
        name_of(first, stream),
        if more.is_empty() { "has" } else { "have" }
    )
}

/// Writes the joined container to `out`.
pub(super) fn join<W: Write + Send>(
    joined: &Joined<'_>,
    settings: &PackSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, PackSummary)> {
    if settings.flatten.is_some() {
        return Err(Error::Usage("`max_error` packs whole containers: pack the shards first, without it".into()));
    }
    let head = joined.inputs[0].index();
    let mut writer = Writer::new(out, &head.name, head.fps, head.projection)?;
    for probe in &head.probes {
        writer.add_probe(probe.clone())?;
    }
    let mut summary = PackSummary::default();
    for stream in &joined.streams {
        writer.add_stream(stream.clone());
        summary.count(stream);
    }
    let (chunks_at_once, batch_bytes) = limits(joined.inputs, settings)?;
    let chunks = joined.chunks()?;
    let mut left = chunks.as_slice();
    let pack = |run: &[Source]| {
        monitor.check()?;
        let copier = Copier { reader: &joined.inputs[run[0].input], repack: settings.repack, monitor };
        copier.copy_run(&run.iter().map(|source| (source.chunk, source.stream)).collect::<Vec<_>>())
    };
    let mut packed: Vec<Vec<PackedChunk>> = Vec::new();
    // A batch is written while the next one is read.
    loop {
        let (batch, rest) = left.split_at(batch_length(left, batch_bytes / 2, |source| &source.chunk));
        left = rest;
        let write = || {
            packed.iter().flatten().try_for_each(|chunk| {
                monitor.advance(1);
                writer.push(chunk)
            })
        };
        let runs = runs(batch, if settings.repack == Repack::Keep { RUN_BYTES } else { 0 });
        let (written, next) = rayon::join(write, || try_map_at_once(runs, chunks_at_once, pack));
        written?;
        summary.chunks += packed.iter().map(|run| run.len() as u64).sum::<u64>();
        packed = next?;
        if packed.is_empty() {
            break;
        }
    }
    for (name, value) in merge_attributes(joined.used_inputs())?.iter() {
        writer.set_attribute(name, value.to_vec());
    }
    let (out, bytes) = writer.finish_checked(streams::check_written)?;
    Ok((out, PackSummary { bytes, ..summary }))
}

impl Joined<'_> {
    /// Finds the pieces of all streams of the joined container.
    ///
    /// # Errors
    /// [`Error::Invalid`] if shards are missing, or if two shards hold different data for the same frames.
    pub fn new<'a>(inputs: &'a [Reader], shards: &[ShardEntry]) -> Result<Joined<'a>> {
        let whole = shards[0].streams.clone();
        let numbers: HashMap<_, _> = (0..).zip(&whole).map(|(at, stream): (u32, _)| (key_of(stream), at)).collect();
        let mut joined = Joined { inputs, whole, streams: Vec::new(), pieces: BTreeMap::new() };
        let mut parts: BTreeMap<(u32, u32), (usize, u32)> = BTreeMap::new();
        for (input, reader) in inputs.iter().enumerate() {
            // Earlier inputs that hold a stream of this input, one entry per such stream.
            let mut repeats: Vec<usize> = Vec::new();
            for (at, stream) in (0..).zip(&reader.index().streams) {
                let strange = || Error::invalid(format!("stream {at} is not of its encode")).in_file(reader.path());
                let number = *numbers.get(&(stream.kind, stream.probe, stream.face)).ok_or_else(strange)?;
                match parts.get(&(number, stream.first_frame)) {
                    None => {
                        parts.insert((number, stream.first_frame), (input, at));
                        let group = joined.whole[number as usize].group;
                        let piece = joined.pieces.entry((group, stream.first_frame));
                        let piece = piece.or_insert_with(|| Piece { input, streams: HashMap::new() });
                        if piece.input != input {
                            return Err(strange());
                        }
                        piece.streams.insert(at, number);
                    }
                    Some(&(earlier, of_earlier)) => {
                        repeats.push(earlier);
                        let earlier = &inputs[earlier];
                        if earlier.index().streams[of_earlier as usize].frame_count != stream.frame_count {
                            return Err(joined.overlap(reader, stream, number));
                        }
                        if chunks_of(earlier, of_earlier) != chunks_of(reader, at) {
                            let message = format!(
                                "its {} differs from that of {}: encode this shard again",
                                name_of(reader, &joined.whole[number as usize]),
                                earlier.path().display()
                            );
                            return Err(Error::invalid(message).in_file(reader.path()));
                        }
                    }
                }
            }
            joined.check_repeats(input, &repeats)?;
        }
        joined.join_streams(&parts, shards)?;
        Ok(joined)
    }

    /// Rejects an input that shares some streams with an earlier input, unless both have exactly the same streams. Attributes
    /// that cover all streams of an input, such as clipped pixels, would be counted twice.
    fn check_repeats(&self, input: usize, repeats: &[usize]) -> Result<()> {
        let Some(&first) = repeats.first() else { return Ok(()) };
        let streams = |input: usize| self.inputs[input].index().streams.len();
        if repeats.iter().all(|&earlier| earlier == first) && [input, first].map(streams) == [repeats.len(); 2] {
            return Ok(());
        }
        let message = format!(
            "it has some streams of {} and others: shards must not overlap, but for the same shard twice",
            self.inputs[first].path().display()
        );
        Err(Error::invalid(message).in_file(self.inputs[input].path()))
    }

    /// Concatenates the pieces of each stream.
    fn join_streams(&mut self, parts: &BTreeMap<(u32, u32), (usize, u32)>, shards: &[ShardEntry]) -> Result<()> {
        for (number, stream) in (0..).zip(&self.whole) {
            let mut next = stream.first_frame;
            let mut entry: Option<StreamEntry> = None;
            for (_, &(input, at)) in parts.range((number, 0)..=(number, u32::MAX)) {
                let reader = &self.inputs[input];
                let part = &reader.index().streams[at as usize];
                let like = |first: &StreamEntry| {
                    *first
                        == StreamEntry {
                            first_frame: first.first_frame,
                            frame_count: first.frame_count,
                            ..part.clone()
                        }
                };
                if part.first_frame < next {
                    return Err(self.overlap(reader, part, number));
                }
                if !entry.as_ref().is_none_or(like) {
                    let message = format!("its {} does not continue that of the other shards", name_of(reader, stream));
                    return Err(Error::invalid(message).in_file(reader.path()));
                }
                if part.first_frame > next {
                    break;
                }
                entry.get_or_insert_with(|| part.clone());
                next = part.end_frame();
            }
            let end = stream.first_frame + stream.frame_count;
            let Some(entry) = entry.filter(|_| next == end) else {
                let name = name_of(&self.inputs[0], stream);
                return Err(Error::invalid(format!("{}: no shard has frame {next} of {name}", missing(shards))));
            };
            self.streams.push(StreamEntry {
                first_frame: stream.first_frame,
                frame_count: stream.frame_count,
                ..entry
            });
        }
        Ok(())
    }

    /// Returns the error for two shards with the same frames.
    fn overlap(&self, reader: &Reader, part: &StreamEntry, number: u32) -> Error {
        let name = name_of(reader, &self.whole[number as usize]);
        let (first, last) = (part.first_frame, part.end_frame() - 1);
        let message =
            format!("another shard has some of the frames {first}-{last} of its {name}: shards must not overlap");
        Error::invalid(message).in_file(reader.path())
    }

    /// Returns the inputs whose chunks are used; a repeated shard is not.
    fn used_inputs(&self) -> impl Iterator<Item = &Reader> {
        let used: BTreeSet<usize> = self.pieces.values().map(|piece| piece.input).collect();
        used.into_iter().map(|input| &self.inputs[input])
    }

    /// Returns the chunks of all inputs in the order of the joined container, each with its input and its stream in that
    /// container.
    pub fn chunks(&self) -> Result<Vec<Source>> {
        let mut written: HashMap<usize, Vec<ChunkEntry>> = HashMap::new();
        let mut chunks = Vec::new();
        for piece in self.pieces.values() {
            if let std::collections::hash_map::Entry::Vacant(entry) = written.entry(piece.input) {
                let reader = &self.inputs[piece.input];
                entry.insert(reader.chunks_as_written().map_err(|error| error.in_file(reader.path()))?);
            }
            chunks.extend(written[&piece.input].iter().filter_map(|chunk| {
                let stream = *piece.streams.get(&chunk.key.stream)?;
                Some(Source { input: piece.input, chunk: *chunk, stream })
            }));
        }
        Ok(chunks)
    }
}

/// A chunk of an input, and its stream in the joined container.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    pub input: usize,
    pub chunk: ChunkEntry,
    pub stream: u32,
}

/// Divides chunks into runs that are adjacent in their file and have at most `max_bytes` bytes in total, or a single chunk.
fn runs(mut chunks: &[Source], max_bytes: u64) -> Vec<&[Source]> {
    let mut runs = Vec::new();
    while let Some(first) = chunks.first() {
        let mut bytes = u64::from(first.chunk.stored_bytes);
        let continues = |pair: &&[Source]| {
            bytes += u64::from(pair[1].chunk.stored_bytes);
            pair[0].is_before(&pair[1]) && bytes <= max_bytes
        };
        let (run, rest) = chunks.split_at(1 + chunks.windows(2).take_while(continues).count());
        runs.push(run);
        chunks = rest;
    }
    runs
}

impl Source {
    /// Returns true if `other` directly follows this chunk in the file.
    fn is_before(&self, other: &Source) -> bool {
        self.input == other.input && self.chunk.offset + u64::from(self.chunk.stored_bytes) == other.chunk.offset
    }
}

fn key_of(stream: &WholeStream) -> (u8, u16, u8) {
    (stream.kind, stream.probe, stream.face)
}

/// Returns the values that are equal if two shards hold the same bytes of a stream.
fn chunks_of(reader: &Reader, stream: u32) -> (StreamEntry, Vec<(ChunkKey, u32, u32, u32)>) {
    let chunks = reader.index().stream_chunks(stream).iter().map(|chunk| {
        let ChunkEntry { key, stored_bytes, raw_bytes, crc32, .. } = *chunk;
        (ChunkKey { stream: 0, ..key }, stored_bytes, raw_bytes, crc32)
    });
    (reader.index().streams[stream as usize].clone(), chunks.collect())
}

fn name_of(reader: &Reader, stream: &WholeStream) -> String {
    let probe = reader.index().probes.get(usize::from(stream.probe)).map_or("?", |probe| probe.name.as_str());
    let kind = StreamKind::ALL.into_iter().find(|&kind| kind as u8 == stream.kind).map_or("stream", StreamKind::name);
    let face = Face::from_index(stream.face).map_or("?", Face::name);
    format!("{kind} of probe {probe}, face {face}")
}

/// Returns a message that names the missing shards.
fn missing(shards: &[ShardEntry]) -> String {
    let count = shards[0].count;
    if shards.iter().any(|shard| shard.count != count) {
        return "shards are missing, and the existing ones have different divisions".to_owned();
    }
    let there: BTreeSet<u32> = shards.iter().map(|shard| shard.number).collect();
    let missing: Vec<u32> = (1..=count).filter(|number| !there.contains(number)).collect();
    let words: Vec<String> = missing.iter().take(12).map(u32::to_string).collect();
    let more = if missing.len() > words.len() { ", …" } else { "" };
    match missing.len() {
        0 => format!(
            "the {count} shards have different divisions: use the same `shard_by` for all, or encode the missing \
            content in one of them"
        ),
        1 => format!("shard {} of {count} is missing", words[0]),
        _ => format!("shards {}{more} of {count} are missing", words.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::container::Storage;

    #[test]
    fn runs_are_neighbours_of_one_file_up_to_a_limit() {
        let source = |(input, offset)| {
            let key = ChunkKey { stream: 0, unit: 0, first_frame: 0, frame_count: 1 };
            let (storage, stored_bytes, raw_bytes, crc32) = (Storage::Raw, 10, 10, 0);
            Source { input, chunk: ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage }, stream: 0 }
        };
        // A gap, a repeated chunk, another file.
        let chunks = [(0, 16), (0, 26), (0, 36), (0, 50), (0, 50), (1, 60), (1, 70)].map(source);
        let lengths = |most| runs(&chunks, most).iter().map(|run| run.len()).collect::<Vec<_>>();
        assert_eq!(lengths(100), [3, 1, 1, 2]);
        assert_eq!(lengths(20), [2, 1, 1, 1, 2]);
        assert_eq!(lengths(0), [1; 7]);
        assert!(runs(&[], 20).is_empty());
    }
}
