//! Damaged chunks as reports list them.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::video::damage::DamagedChunk;
use crate::video::decode::Decoder;

/// One object for each chunk.
pub fn json(decoder: &Decoder, damaged: &[DamagedChunk]) -> Vec<Value> {
    let object = |damaged: &DamagedChunk| {
        let key = damaged.chunk.key;
        let stream = &decoder.streams()[key.stream as usize];
        let frames = damaged.frames();
        json!({
            "stream": key.stream,
            "kind": stream.kind.name(),
            "probe": decoder.probe(stream).name,
            "face": stream.face.name(),
            "unit": key.unit,
            "frames": [frames.first, frames.last],
            "offset": damaged.chunk.offset,
            "reason": damaged.reason,
        })
    };
    damaged.iter().map(object).collect()
}

/// One line for each chunk.
pub fn lines(decoder: &Decoder, damaged: &[DamagedChunk]) -> String {
    let mut out = String::new();
    for damaged in damaged {
        let key = damaged.chunk.key;
        let stream = &decoder.streams()[key.stream as usize];
        let _ = writeln!(
            out,
            "  stream {} ({} of probe {} face {}), unit {}, frames {}, at byte {}: {}",
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
