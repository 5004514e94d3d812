//! Lists damaged chunks.

use std::collections::HashMap;
use std::fmt::Write;

use codec::decode::{DamagedChunk, Decoder};
use codec::error::counted;

/// Returns one line for each damaged place in the file. Chunks with the same bytes share a line.
pub fn lines(decoder: &Decoder, damaged: &[DamagedChunk]) -> String {
    let place = |damaged: &DamagedChunk| (damaged.chunk.offset, damaged.reason.clone());
    let mut rows_at: HashMap<_, u64> = HashMap::new();
    damaged.iter().for_each(|damaged| *rows_at.entry(place(damaged)).or_default() += 1);
    let mut out = String::new();
    for damaged in damaged {
        let Some(rows) = rows_at.remove(&place(damaged)) else { continue };
        let key = damaged.chunk.key;
        let stream = &decoder.streams()[key.stream as usize];
        let also =
            if rows > 1 { format!(" and {} of the same bytes", counted(rows - 1, "chunk")) } else { String::new() };
        let _ = writeln!(
            out,
            "  stream {} ({} of probe {} face {}), unit {}, frames {}{also}, at byte {}: {}",
            key.stream,
            stream.kind.name(),
            decoder.probe(stream).name,
            stream.face.name(),
            key.unit,
            damaged.frames(),
            damaged.chunk.offset,
            damaged.reason
        );
    }
    out
}
