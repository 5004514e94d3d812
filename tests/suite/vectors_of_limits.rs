//! Vectors of files that are refused before an image is decoded: files that only exceed a limit, and files that break a rule that
//! is checked whichever image is requested.

use std::path::Path;

use codec::color::SearchSettings;
use codec::color::cells::MISSING_NEXT_KEYFRAME;
use codec::color::cells::builder::CellBuilder;
use codec::decode::Decoder;
use codec::depth::predictive::UnitArea;
use codec::monitor::Silent;
use footage::inspect::{self, InspectSettings, coding_map, survey};
use kernels::prepare;

use crate::samples;
use crate::vectors::{one, shape};

/// Vectors that break no rule of the format, but would take more resources than their size justifies (container.md 2).
pub const ONLY_TOO_LARGE: [&str; 4] = [
    "chunk-shared-by-many-units",
    "chunk-shared-by-some-units",
    "stream-frames-for-hours",
    "stream-larger-than-justified",
];

/// Returns a cell whose first two frames show its only keyframe, and whose third refers to a chunk that does not exist.
fn leads_nowhere_late() -> Vec<u8> {
    let mut cell = CellBuilder::default();
    cell.push_keyframe::<u8>(&[1, 2, 3]);
    cell.push_weight(0, 1);
    cell.push_weight(7, 1);
    let header = samples::color8_header(&SearchSettings::default());
    one(samples::cells_by_hand(shape(0, [1, 1], [1, 1], 0, 3), &header, vec![cell]))
}

/// Returns name, bytes and a part of the message of every invalid vector.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    vec![
        ("color-last-leads-nowhere-late", leads_nowhere_late(), MISSING_NEXT_KEYFRAME),
        ("stream-frames-for-hours", samples::static_for(1 << 31), "claim 2147483648 units and 8589934592 pixels"),
        ("chunk-shared-by-some-units", samples::shared_chunk(7), "of 7x2 pixels would take"),
        ("chunk-shared-by-many-units", samples::shared_chunk(256), "payloads of 4294967296 bytes"),
    ]
}

#[test]
fn a_last_chunk_that_leads_nowhere_is_refused_whatever_is_asked_for() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/invalid/color-last-leads-nowhere-late.lfold");
    let decoder = Decoder::open(path).unwrap();
    let (stream, reader) = (&decoder.streams()[0], decoder.reader());
    let chunk = reader.index().chunks[0];
    let place = reader.index().place(&chunk);
    // Frame 0 alone needs no other chunk.
    let said = [
        decoder.unit(stream, 0).decode(0).err(),
        decoder.face(stream).decode(0).err(),
        coding_map(&decoder, stream, 0).err(),
        survey(&decoder, stream, &Silent).err(),
        inspect::inspect(&decoder, &[stream], InspectSettings::default(), &Silent).err(),
        prepare::prepare(&stream.header, reader.fetch(&chunk).unwrap(), UnitArea::whole([1, 1]), 3, place).err(),
    ];
    for (way, error) in said.into_iter().enumerate() {
        let error = error.map_or_else(|| "it is taken".to_owned(), |error| error.to_string());
        assert!(error.contains(MISSING_NEXT_KEYFRAME), "way {way}: {error}");
    }
}
