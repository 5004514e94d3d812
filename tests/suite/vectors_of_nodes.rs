//! Frozen containers of [`crate::vectors`] with depth as a quadtree or as plain blocks.

use std::sync::Arc;

use codec::container::{Compression, EncodedChunk, Storage};
use codec::depth::domain::DomainKind;
use codec::depth::mode_decision::Decide;
use codec::depth::node_chunk::NodeChunk;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::nodes::{Function, Node, Place};
use codec::depth::record_table::TableBuilder;
use codec::depth::storage;
use codec::effort::Effort;
use codec::streams::CodecHeader;

use crate::samples::{self, Stream};
use crate::vectors::{one, shape};

fn node_settings(window: u8, epsilon: u16, bound: u16, keyframe_interval: u32) -> NodeSettings {
    NodeSettings { window, epsilon, bound, keyframe_interval, effort: Effort::Fast, ..NodeSettings::default() }
}

/// Returns the coefficients of a function of six numbers, followed by `tail`.
fn numbers(numbers: [i32; 6], tail: [u8; 8]) -> [u8; 32] {
    let bytes = numbers.iter().flat_map(|number| number.to_le_bytes()).chain(tail);
    bytes.collect::<Vec<u8>>().try_into().unwrap()
}

fn hex(text: &str) -> [u8; 32] {
    let byte = |word: &str| u8::from_str_radix(word, 16).unwrap();
    text.split_whitespace().map(byte).collect::<Vec<u8>>().try_into().unwrap()
}

/// Returns a stream of one 45×30 unit and three frames with nodes built by hand: each function in each of its forms.
fn every_function(face: u8, kind: DomainKind) -> Stream {
    let domain = samples::node_domain(kind);
    let value = |value: i32| value << 14;
    let surface = |numbers_of| numbers(numbers_of, [0xff; 8]);
    let platelet = |sides, [x0, y0, x1, y1]: [u8; 4]| numbers(sides, [x0, y0, x1, y1, 255, 255, 255, 255]);
    let raw = |codes: [u16; 16]| codes.map(u16::to_le_bytes).as_flattened().try_into().unwrap();
    let ramp: [u16; 16] = std::array::from_fn(|at| 40_000 + 3 * at as u16);
    let mut holed = ramp;
    holed[5] = u16::MAX;
    let wide: [u16; 16] = std::array::from_fn(|at| at as u16 * 4369);
    let node = |level, x, y, coefficients: [u8; 32]| Node { place: Place { level, x, y }, coefficients };
    let indices = "88 c6 fa ".repeat(8);
    let modes = ["ff 1f 00 04 00 7d 40 f0", "b8 0b 77 1d 00 00 00 00"].map(|tail| hex(&(indices.clone() + tail)));
    let mut nodes = vec![
        node(2, 0, 0, surface([3000, -2000, 70_000, -30_000, 20_001, value(20_000)])),
        node(
            2,
            1,
            0,
            platelet([512 << 6, -(9 << 8), value(30_000), -40_960, 3, value(50_000) + 77], [10, 0, 200, 255]),
        ),
        node(2, 0, 1, platelet([0, 0, value(1234), 90_000, 5000, value(60_000)], [255, 128, 0, 127])),
        node(1, 2, 2, modes[0]),
        node(1, 3, 2, modes[1]),
        node(0, 4, 6, raw(ramp)),
        node(0, 5, 6, raw(holed)),
        node(0, 4, 7, raw(wide)),
        node(0, 5, 7, raw([u16::MAX; 16])),
        node(1, 3, 3, surface([0, 0, 0, 0, 0, domain.background()])),
        node(2, 2, 0, surface([-70_000, 123_456, 0, 0, 0, value(33_000)])),
        // Sums that wrap around, and results beyond both ends of the range.
        node(2, 2, 1, surface([4_194_304, -99_999_999, 134_217_728, -77, i32::MIN, 1 << 30])),
    ];
    nodes.sort_by_key(|node| node.place.walk_key());
    let shape = shape(face, [45, 30], [64, 64], 0, 3);
    let settings = node_settings(1, 0, 0, 64);
    let entry = samples::entry(shape, &samples::nodes_codec(samples::node_header(settings, &domain)));
    let grid = samples::grid(&entry, 0);
    let mut chunk = TableBuilder::default();
    let mut push = |frame, nodes: &[Node]| storage::write_record(grid, nodes, chunk.begin(frame));
    push(0, &nodes);
    let both_constant = [0, 0, value(7), 0, 0, domain.background()];
    push(1, &[node(1, 2, 0, platelet(both_constant, [0, 0, 255, 255])), node(0, 11, 7, raw([5; 16]))]);
    push(2, &[node(4, 0, 0, surface([i32::MAX, i32::MIN, 1, -1, i32::MIN, -1]))]);
    let payload = chunk.finish().unwrap();
    let census = NodeChunk::parse(payload.clone(), grid, 3, domain).unwrap().mode_statistics();
    for function in Function::ALL {
        assert!(census.of(function).nodes > 1, "{function:?}");
    }
    Stream { entry, chunks: vec![(0, EncodedChunk { first_frame: 0, frame_count: 3, payload })] }
}

/// Returns the functions that occur in a quadtree stream.
fn functions_of(stream: &Stream, kind: DomainKind) -> Vec<Function> {
    let mut functions = Vec::new();
    for (unit, chunk) in &stream.chunks {
        let (grid, domain) = (samples::grid(&stream.entry, *unit), samples::node_domain(kind));
        let parsed = NodeChunk::parse(chunk.payload.clone(), grid, chunk.frame_count, domain).unwrap();
        let census = parsed.mode_statistics();
        functions.extend(Function::ALL.into_iter().filter(|&function| census.of(function).nodes > 0));
    }
    functions
}

/// Returns the valid vectors of the quadtree and of plain blocks.
pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let size = [45, 30];
    let scene = samples::scene_codes(size, 9);
    let of = |unit| shape(0, size, unit, 3, 9);
    let mut all = Vec::new();
    all.push(("nodes-lossless-w2", {
        one(samples::nodes(of([64, 64]), DomainKind::Log, &scene, node_settings(2, 0, 0, 5)))
    }));
    all.push(("nodes-w3", {
        let stream = samples::nodes(of([64, 64]), DomainKind::Log, &scene, node_settings(3, 0, 100, 64));
        let functions = functions_of(&stream, DomainKind::Log);
        assert!(Function::ALL.iter().all(|function| functions.contains(function)), "{functions:?}");
        one(stream)
    }));
    all.push(("nodes-odd-units", {
        let settings = NodeSettings { decide: Decide::Size, ..node_settings(2, 9, 100, 4) };
        let stream = |face: u8, size: [u32; 2], unit| {
            samples::nodes(shape(face, size, unit, 0, 7), DomainKind::Log, &samples::scene_codes(size, 7), settings)
        };
        let streams = [
            stream(0, [45, 30], [13, 9]),
            stream(1, [1, 1], [1, 1]),
            stream(2, [3, 5], [4, 4]),
            stream(3, [1, 37], [8, 1024]),
            stream(4, [45, 30], [20, 17]),
        ];
        samples::container(0, samples::probe("odd", 8), &streams, Compression::None)
    }));
    all.push(("nodes-linear", {
        one(samples::nodes(of([32, 24]), DomainKind::Linear, &scene, node_settings(2, 0, 100, 64)))
    }));
    all.push(("nodes-inverse", {
        one(samples::nodes(of([32, 24]), DomainKind::Inverse, &scene, node_settings(2, 3, 100, 64)))
    }));
    all.push(("nodes-every-function", {
        let streams: Vec<_> = (0..).zip(DomainKind::ALL).map(|(face, kind)| every_function(face, kind)).collect();
        samples::container(0, samples::probe("00", 2), &streams, Compression::None)
    }));
    all.push(("nodes-empty-records", {
        // The library's encoder never writes a record without nodes, or a tree walk into empty quadrants.
        let bytes = [&[0, 1, 0, 0x80, 0x80, 10][..], &[1, 0], &[1, 0b01]].concat();
        one(node_stream([8, 8], 4, &node_payload(&[(0, 0), (1, 6), (3, 8)], &bytes)))
    }));
    all.push(("tree", {
        let stream = |face, kind, unit| {
            samples::tree(shape(face, size, unit, 0, 6), kind, &scene[..6], node_settings(1, 0, 100, 4))
        };
        let streams = [stream(0, DomainKind::Log, [64, 64]), stream(1, DomainKind::Inverse, [19, 30])];
        samples::container(0, samples::probe("00", 6), &streams, Compression::None)
    }));
    all.push(("blocks", {
        let streams = [
            samples::blocks(shape(0, size, [32, 32], 5, 5), &scene[..5], 2),
            samples::blocks(shape(1, [1, 9], [8, 8], 5, 5), &samples::scene_codes([1, 9], 5), 64),
        ];
        samples::container(0, samples::probe("00", 10), &streams, Compression::None)
    }));
    all.push(("nodes-lzma2", {
        let streams = [
            samples::nodes(shape(0, size, [64, 64], 0, 9), DomainKind::Log, &scene, node_settings(1, 0, 0, 64)),
            samples::tree(shape(1, size, [64, 64], 0, 9), DomainKind::Linear, &scene, node_settings(1, 0, 50, 64)),
            samples::blocks(shape(2, size, [64, 64], 0, 9), &scene, 64),
        ];
        let bytes = samples::container(0, samples::probe("00", 8), &streams, Compression::Lzma2(9));
        let (index, _) = samples::take_apart(&bytes);
        assert!(index.chunks.iter().all(|chunk| chunk.storage == Storage::Lzma2));
        bytes
    }));
    all
}

/// Returns a payload of records; `table` has the frame of each record and its offset in `records`.
fn node_payload(table: &[(u32, u32)], records: &[u8]) -> Vec<u8> {
    let start = 4 + 8 * table.len() as u32;
    let rows = table.iter().flat_map(|&(frame, at)| [frame, start + at]);
    let mut payload: Vec<u8> = [table.len() as u32].into_iter().chain(rows).flat_map(u32::to_le_bytes).collect();
    payload.extend_from_slice(records);
    payload
}

/// Returns a stream of packed nodes of one unit and one chunk.
fn node_stream(size: [u32; 2], frame_count: u32, payload: &[u8]) -> Stream {
    let header = samples::node_header(node_settings(1, 0, 0, 64), &samples::node_domain(DomainKind::Log));
    stream_of(&samples::nodes_codec(header), size, frame_count, payload)
}

fn stream_of(header: &CodecHeader, size: [u32; 2], frame_count: u32, payload: &[u8]) -> Stream {
    let entry = samples::entry(shape(0, size, size, 0, frame_count), header);
    Stream { entry, chunks: vec![(0, EncodedChunk { first_frame: 0, frame_count, payload: payload.to_vec() })] }
}

/// Returns the invalid vectors of the quadtree and of plain blocks.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let mut all: Vec<(&'static str, Vec<u8>, &'static str)> = Vec::new();
    let record = |side: u32, bytes: &[u8]| one(node_stream([side; 2], 1, &node_payload(&[(0, 0)], bytes)));
    all.push(("nodes-first-record-partial", record(8, &[1, 3, 0, 0]), "record 0 is of kind 1"));
    all.push(("nodes-coverage", record(8, &[2, 1, 0, 0]), "record 0 is of kind 2"));
    all.push(("nodes-walk-spare-bits", record(8, &[0, 3, 0, 0]), "the bits after the last one are not zero"));
    all.push(("nodes-walk-cut", record(8, &[0]), "1 more bytes expected, 0 left"));
    all.push(("nodes-head-function", record(8, &[0, 1, 0x03]), "a node with head 0x03"));
    all.push(("nodes-head-order", record(8, &[0, 1, 0xc0, 0, 0, 0, 0, 0, 0]), "a node with head 0xc0"));
    let block = |head: u8, last: u8| [&[0, 1, head][..], &[0; 28], &[last; 4]].concat();
    all.push(("nodes-head-bc4w-precision", record(8, &block(0x06, 0)), "a node with head 0x06"));
    all.push(("nodes-head-bc4w-bits", record(8, &block(0x42, 0)), "a node with head 0x42"));
    all.push(("nodes-head-bc4w-level", record(16, &block(0x02, 0)), "a node with head 0x02"));
    all.push(("nodes-bc4w-marker", record(8, &block(0x02, 0xff)), "a BC4w block that ends like another function"));
    let number = |head: u8, bytes: &[u8]| record(8, &[&[0, 1, head], bytes].concat());
    let more = "a coefficient of more than 32 bits";
    all.push(("nodes-number-bits", number(0, &[0xff, 0xff, 0xff, 0xff, 0x10]), more));
    all.push((
        "nodes-number-bytes",
        number(0, &[0xff, 0xff, 0xff, 0xff, 0x8f, 0]),
        "a coefficient of more than 5 bytes",
    ));
    all.push(("nodes-number-shifted", number(0x3c, &[0x80, 0x40]), "does not fit 32 bits"));
    all.push(("nodes-number-shifted-just", number(0x3c, &[0x80, 0x20]), "does not fit 32 bits"));
    all.push(("nodes-platelet-line", number(1, &[0, 0, 255, 255, 255, 255]), "a platelet with an invalid line"));
    let raw = |head: u8, rest: &[u8]| record(4, &[&[0, head], rest].concat());
    all.push(("nodes-raw-bits", raw(0x11, &[0; 36]), "a raw node with head 0x11"));
    all.push(("nodes-raw-head", raw(0x40, &[0; 2]), "a raw node with head 0x40"));
    all.push(("nodes-raw-background-alone", raw(0x20, &[0; 2]), "a raw node with head 0x20"));
    all.push(("nodes-raw-background-wide", raw(0x30, &[0; 32]), "a raw node with head 0x30"));
    all.push(("nodes-raw-code", raw(1, &[255, 255, 0, 0x80]), "a raw code above 65535"));
    all.push(("nodes-trailing-byte", record(8, &[0, 1, 0, 0, 0]), "1 bytes after the last field"));
    let gap = node_payload(&[(0, 0), (1, 5)], &[0, 1, 0, 0, 0, 1, 0]);
    all.push(("nodes-record-gap", one(node_stream([8; 2], 2, &gap)), "record 1 was announced at offset 25"));
    let wide = |size| one(node_stream(size, 1, &node_payload(&[(0, 0)], &[0, 1, 0, 0])));
    all.push(("nodes-unit-too-wide", wide([1025, 8]), "tiles of more than 1024 pixels"));
    all.push(("nodes-unit-too-high", wide([8, 1025]), "tiles of more than 1024 pixels"));

    let good = record(8, &[0, 1, 0, 0]);
    let (index, stored) = samples::take_apart(&good);
    let header = |at: usize, bytes: &[u8]| {
        let mut index = index.clone();
        Arc::make_mut(&mut index.streams[0].codec_header)[at..at + bytes.len()].copy_from_slice(bytes);
        samples::assemble(&index, &stored, |_| ())
    };
    all.push(("nodes-header-no-window", header(16, &[0]), "a depth window of 0 frames"));
    all.push(("nodes-header-window", header(16, &[0, 1]), "a depth window of 256 frames"));
    all.push(("nodes-header-interval", header(20, &[0; 4]), "a keyframe interval of 0 frames"));
    all.push(("nodes-header-domain", header(26, &[3]), "domain 3 is unknown"));
    all.push(("nodes-header-log-base", header(28, &[1]), "a Log domain with base 1 and scale 0"));
    all.push(("nodes-header-log-scale", header(32, &[1]), "a Log domain with base 0 and scale 1"));
    all.push(("nodes-header-no-scale", header(26, &[1]), "a Linear domain with base 0 and scale 0"));
    let base = [2, 0, 0, 0, 0, 24, 1, 0, 0, 0];
    all.push(("nodes-header-base", header(26, &base), "a Inverse domain with base 402653184 and scale 1"));

    let tree = |window: u8, bytes: &[u8]| {
        let domain = samples::node_domain(DomainKind::Log);
        let header = samples::tree_codec(samples::node_header(node_settings(window, 0, 0, 64), &domain));
        one(stream_of(&header, [8, 8], 1, &node_payload(&[(0, 0)], bytes)))
    };
    let leaves = |walk: u8, count: usize, rest: &[u8]| [&[walk][..], &[0, 5, 0].repeat(count), rest].concat();
    all.push(("tree-lacks-leaves", tree(1, &leaves(0x1d, 3, &[])), "a chunk's first record must hold all leaves"));
    all.push(("tree-walk-spare-bits", tree(1, &leaves(0x7d, 4, &[])), "the bits after the last one are not zero"));
    all.push(("tree-head", tree(1, &leaves(0x3f, 4, &[3, 0, 0, 0])), "a node with head 0x03"));
    all.push(("tree-no-error", tree(1, &leaves(0x3f, 4, &[0, 0, 0])), "2 more bytes expected, 1 left"));
    all.push(("tree-window", tree(2, &leaves(0x3d, 4, &[])), "a window of 2 frames"));

    let blocks = |payload: &[u8]| one(stream_of(&samples::blocks_codec(), [8, 8], 1, payload));
    all.push(("blocks-shorter", blocks(&[0; 31]), "32 more bytes expected, 31 left"));
    all.push(("blocks-longer", blocks(&[0; 33]), "1 bytes after the last field"));
    all.push(("blocks-marker", blocks(&[0xff; 32]), "a BC4w block that ends like another function"));
    all
}
