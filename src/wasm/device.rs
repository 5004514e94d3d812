//! Chunks and tables for graphics devices, as words: `Prepared` of viewer/src/decoder/types.ts.

use codec::color::transform::Tables;
use codec::container::Payload;
use codec::error::Result;
use codec::streams::CodecHeader;

use crate::stream::{ChunkArea, Stream};
use kernels::layout::words_of;
use kernels::prepare::{self, KernelOf, Prepared, Timeline};
use kernels::transform_tables::TransformTables;

/// Checks a payload and returns it for the device: five numbers, the lengths in words of nine arrays, and the arrays.
pub fn prepared(stream: &Stream, payload: Payload, area: ChunkArea) -> Result<Vec<u32>> {
    let unit = stream.unit_area(area.unit);
    let prepared = prepare::prepare(&stream.header, payload, unit, area.frames, area.place)?;
    let is_nodes = prepared.is_nodes();
    let Prepared { kernel, stream, records, boxes, weights: [weights_at, weight_count], passes, timeline } = prepared;
    let Timeline { records: of_frames, keyframes, weights, pixels_of_frames } = timeline;
    let sets = pixels_of_frames.iter().flat_map(|(set, _)| [0, 32, 64, 96].map(|shift| (set >> shift) as u32));
    let arrays = [
        stream,
        words_of(&records),
        words_of(&boxes),
        of_frames.iter().map(|&(frame, _)| frame).collect(),
        of_frames.iter().map(|&(_, pixels)| pixels as u32).collect(),
        keyframes,
        weights.into_iter().map(u32::from).collect(),
        sets.collect(),
        pixels_of_frames.iter().map(|&(_, pixels)| pixels as u32).collect(),
    ];
    let is_keyframes = kernel == KernelOf::Keyframes;
    let mut words = vec![is_keyframes.into(), is_nodes.into(), weights_at, weight_count, passes];
    words.extend(arrays.iter().map(|array| array.len() as u32));
    arrays.iter().for_each(|array| words.extend_from_slice(array));
    Ok(words)
}

/// Returns the tables of streams of the transform codec: for each stream the first word of its table sets, then the words.
pub fn transform_tables(streams: &[&Stream]) -> Vec<u32> {
    let tables: Vec<&Tables> = streams
        .iter()
        .filter_map(|stream| match &stream.header {
            CodecHeader::Color(header) => header.tables(),
            _ => None,
        })
        .collect();
    let TransformTables { words, mut first_sets } = TransformTables::new(tables);
    first_sets.extend(words);
    first_sets
}
