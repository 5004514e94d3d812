//! Frozen containers of [`crate::vectors`] with colour in the transform codec (formats/color.md 6).

use codec::color::cells::builder::CellBuilder;
use codec::color::transform::authored::{
    ANY, Author, PALETTES, Question, Taste, USUAL, WHOLE, contexts_of, random_payload,
};
use codec::color::transform::basis::LENGTHS;
use codec::color::transform::blocks::Block;
use codec::color::transform::contexts::{BUILT_IN, NODE, PALETTE_SIZE, PIXEL};
use codec::color::transform::domain::{ChromaSlopes, Domain};
use codec::color::transform::payload::{CELLS, Header, holds_cells};
use codec::color::transform::region::{Content, PALETTE, QUARTERS, Region, Setting};
use codec::color::transform::steps::StepIndices;
use codec::color::transform::{Keyed, Tables, TransformChunk};
use codec::color::{HalfKey, SearchSettings, Target};
use codec::container::{Compression, EncodedChunk, Reader, StreamEntry};
use codec::entropy::Encoder;
use codec::image::transfer::ToneMap;
use codec::streams::{CodecHeader, ColorCoding, ColorFormat, ColorHeader};
use half::f16;

use crate::samples::{self, Random, Shape, Stream};
use crate::transform_payloads::{Coverage, own_set, own_sets, usual_header};
use crate::vectors::shape;

/// Returns the row of a stream with these tables and samples of `bytes` bytes.
fn entry(shape: Shape, bytes: usize, tables: &Tables) -> StreamEntry {
    let format = match bytes {
        1 => ColorFormat::EightBit(ToneMap::default()),
        _ => ColorFormat::Half { white_cd_m2: 100.0 },
    };
    let header =
        ColorHeader { format, coding: ColorCoding::Transform(tables.clone()), min_psnr_db: 40.0, min_quality: 0.0 };
    samples::entry(shape, &CodecHeader::Color(header))
}

/// Returns a stream with chunks of `chunk_frames` frames, used cyclically. `payload` makes the payload for a cell size and a
/// frame count.
fn stream<S: Keyed>(
    shape: Shape,
    chunk_frames: &[usize],
    tables: &Tables,
    mut payload: impl FnMut([usize; 2], usize) -> Vec<u8>,
) -> Stream {
    let entry = entry(shape, S::BYTES, tables);
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let [_, _, width, height] = entry.unit_rect(unit);
        let (mut first_frame, mut chunk_frames) = (0, chunk_frames.iter().cycle());
        while let Some(&frames) = chunk_frames.next().filter(|_| first_frame < shape.frame_count) {
            let frame_count = (frames as u32).min(shape.frame_count - first_frame);
            let payload = payload([width as usize, height as usize], frame_count as usize);
            chunks.push((unit, EncodedChunk { first_frame, frame_count, payload }));
            first_frame += frame_count;
        }
    }
    Stream { entry, chunks }
}

fn payload_of_taste<S: Keyed>(
    size: [usize; 2],
    frames: usize,
    header: &Header,
    tables: &Tables,
    (taste, random): (Taste, &mut Random),
) -> Vec<u8> {
    random_payload::<S>(size, frames, header, tables, (taste, &mut |end| random.below(end))).unwrap()
}

/// Returns a stream of one chunk with random symbols, whose probabilities `taste` gives.
fn random<S: Keyed>(face: u8, size: [u32; 2], frames: u32, header: &Header, (taste, seed): (Taste, u64)) -> Stream {
    let tables = Tables::default();
    let mut random = Random(seed);
    stream::<S>(shape(face, size, size, 0, frames), &[frames as usize], &tables, |size, frames| {
        payload_of_taste::<S>(size, frames, header, &tables, (taste, &mut random))
    })
}

/// Returns a stream with one block per cell, of every length.
fn whole<S: Keyed>(face: u8, size: [u32; 2], seed: u64) -> Stream {
    let (tables, mut random) = (Tables::default(), Random(seed));
    let frames = LENGTHS.iter().sum::<usize>() as u32;
    stream::<S>(shape(face, size, size, 0, frames), &LENGTHS, &tables, |size, frames| {
        let header = Header { set: usize::from(face), ..usual_header(S::BYTES) };
        payload_of_taste::<S>(size, frames, &header, &tables, (WHOLE, &mut random))
    })
}

fn container(streams: &[Stream]) -> Vec<u8> {
    samples::container(0, samples::probe("00", 100), streams, Compression::None)
}

/// Returns a container with transforms of every size and length.
fn sizes_and_lengths<S: Keyed>(seed: u64) -> Vec<u8> {
    let sized = (0..).zip([[4, 4], [5, 3], [9, 2], [17, 2]]);
    container(&sized.map(|(face, size)| whole::<S>(face, size, seed + u64::from(face))).collect::<Vec<_>>())
}

/// Returns a container with block trees in cells of several regions, and in cells smaller than a region.
fn trees<S: Keyed>(seed: u64) -> Vec<u8> {
    let header = usual_header(S::BYTES);
    let sized = [([32, 32], 12), ([33, 5], 16), ([8, 7], 13), ([1, 1], 96), ([4, 65], 3), ([16, 9], 1), ([20, 30], 2)];
    let streams = (0..).zip(sized).map(|(face, (size, frames))| {
        let header = Header { set: usize::from(face) % 4, ..header.clone() };
        random::<S>(face, size, frames, &header, (USUAL, seed + u64::from(face)))
    });
    container(&streams.collect::<Vec<_>>())
}

/// Returns a container with steps, slopes and levels of all magnitudes, with sums that wrap around.
fn sums_that_wrap<S: Keyed>(seed: u64) -> Vec<u8> {
    let headers = [(0, 0, 0, 0), (255, 255, 127, -128), (31, 240, -128, 127), (200, 247, 24, -24), (16, 100, 1, -1)];
    let streams = (0..).zip(headers).map(|(face, (luma, chroma, green, orange))| {
        let (steps, slopes) = (StepIndices { luma, chroma }, ChromaSlopes { green, orange });
        let header = Header { set: 1, steps, slopes, offset_set: usize::from(face) % 2, colors: Vec::new() };
        random::<S>(face, [12, 9], 7, &header, (ANY, seed + u64::from(face)))
    });
    container(&streams.collect::<Vec<_>>())
}

/// Returns a container with palettes of all sizes, with and without colours of the payload, next to transforms.
fn palettes<S: Keyed>(seed: u64) -> Vec<u8> {
    let most = (1u32 << S::DOMAIN.key_bits) - 1;
    let mut colors = Random(seed);
    let streams = (0..).zip([0, 1, 14, 15]).map(|(face, count): (u8, usize)| {
        let colors = (0..count).map(|_| std::array::from_fn(|_| colors.below(most + 1) as i32)).collect();
        let header = Header { colors, ..usual_header(S::BYTES) };
        random::<S>(face, [72, 33], [5, 1, 2, 9][usize::from(face)], &header, (PALETTES, seed + u64::from(face)))
    });
    container(&streams.collect::<Vec<_>>())
}

/// Returns a container of streams with one, two and eight own table sets.
fn own_tables<S: Keyed>(seed: u64) -> Vec<u8> {
    let streams = (0..).zip([1, 2, 8]).map(|(face, count)| {
        let mut random = Random(seed + u64::from(face));
        let tables = own_sets(count, &mut random);
        stream::<S>(shape(face, [24, 8], [8, 8], 4, 10), &[4, 2], &tables, |size, frames| {
            let set = random.below(tables.sets().len() as u32) as usize;
            let header = Header { set, ..usual_header(S::BYTES) };
            payload_of_taste::<S>(size, frames, &header, &tables, (USUAL, &mut random))
        })
    });
    container(&streams.collect::<Vec<_>>())
}

/// Returns a container with half floats as keyframes and weights: payloads with first byte 255, of one frame and of the maximum
/// number of frames.
fn halves_in_chunks_of_cells() -> Vec<u8> {
    let tables = Tables::default();
    let mut random = Random(37);
    let mut payload = |size: [usize; 2], frames: usize| {
        let mut cell = CellBuilder::default();
        let mut samples =
            || (0..3 * size[0] * size[1]).map(|_| HalfKey::from_bits(random.below(0x7c00) as u16)).collect();
        let first: Vec<HalfKey> = samples();
        cell.push_keyframe(&first);
        if frames > 1 {
            cell.push_weight(51, frames as u32 - 2);
            let last: Vec<HalfKey> = samples();
            cell.push_keyframe(&last);
        }
        [vec![CELLS], cell.finish().unwrap()].concat()
    };
    container(&[stream::<HalfKey>(shape(4, [7, 5], [4, 5], 1, 99), &[1, 96, 2], &tables, &mut payload)])
}

/// Returns a container in which every third chunk has keyframes and weights instead of transforms.
fn chunks_of_cells() -> Vec<u8> {
    let tables = Tables::default();
    let mut random = Random(31);
    let mut number = 0;
    let mut payload = |size: [usize; 2], frames: usize| {
        number += 1;
        if number % 3 != 0 {
            let header = usual_header(1);
            return payload_of_taste::<u8>(size, frames, &header, &tables, (USUAL, &mut random));
        }
        let mut cell = CellBuilder::default();
        let mut samples = || (0..3 * size[0] * size[1]).map(|_| random.below(256) as u8).collect::<Vec<u8>>();
        cell.push_keyframe(&samples());
        cell.push_weight(85, 1);
        cell.push_keyframe(&samples());
        cell.push_weight(0, frames as u32 - 3);
        [vec![CELLS], cell.finish().unwrap()].concat()
    };
    let stream = stream::<u8>(shape(5, [11, 6], [6, 6], 2, 24), &[5, 4, 6], &tables, &mut payload);
    assert!(stream.chunks.iter().any(|(_, chunk)| holds_cells(&chunk.payload)));
    container(&[stream])
}

fn search() -> SearchSettings {
    SearchSettings { target: Target::Psnr(40.0), ..SearchSettings::default() }
}

/// Returns a container with encoded 8-bit colour with chunk lengths that cover all splits into halves and thirds.
fn encoded_bytes() -> Vec<u8> {
    let size = [13, 10];
    let streams = (0..).zip([1, 2, 3, 5, 7, 24, 25]).map(|(face, chunk_frames)| {
        let images = samples::drifting_bytes(size, 25);
        // Every second stream has a constant step, with offsets by frequency.
        let search = if face % 2 == 1 { SearchSettings { target: Target::Step(80), ..search() } } else { search() };
        samples::color8_transform(shape(face, size, [8, 8], 3, 25), &images, search, chunk_frames)
    });
    container(&streams.collect::<Vec<_>>())
}

/// Returns a container with half floats at both ends of their range, negative values, infinities and NaN, which are coded as
/// cells; and with colour that is coded by the transform alone.
fn encoded_halves() -> Vec<u8> {
    let special = [65504.0, 6e-8, -65504.0, -6e-8, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 0.0, 1.0, 99.9];
    let any = |x: u32, y: u32, t: u32, channel: usize| match (x + y + t / 4) % 3 {
        0 => special[(x + 2 * y + t / 6) as usize % special.len()],
        _ => x as f32 * 0.1 - 2.0 + y as f32 * 0.3 + channel as f32,
    };
    let smooth = |x: u32, y: u32, t: u32, channel: usize| match (x < 8, y < 4) {
        (true, true) => 65504.0,
        (true, false) => 6e-8 * (1 + channel) as f32,
        (false, _) => ((x as f32 + t as f32 * 0.3) * 0.2 - y as f32 * 0.1 + channel as f32 * 0.5).exp2(),
    };
    type Light<'a> = &'a dyn Fn(u32, u32, u32, usize) -> f32;
    let images = |[width, height]: [u32; 2], of: Light<'_>| -> Vec<Vec<[f16; 3]>> {
        let pixel = |at: u32, t| std::array::from_fn(|channel| f16::from_f32(of(at % width, at / width, t, channel)));
        (0..13).map(|t| (0..width * height).map(|at| pixel(at, t)).collect()).collect()
    };
    let stream = |face, size, of: Light<'_>| {
        samples::color_half_transform(shape(face, size, [40, 40], 0, 13), &images(size, of), search(), 13)
    };
    let streams =
        [stream(0, [9, 7], &any), stream(1, [1, 1], &any), stream(2, [33, 5], &smooth), stream(3, [20, 12], &smooth)];
    let is_cells = |stream: &Stream| holds_cells(&stream.chunks[0].1.payload);
    assert!(streams.iter().any(is_cells) && !streams.iter().all(is_cells));
    container(&streams)
}

/// Returns a region of palettes with the maximum number of leaves and colours for its bytes, plus `more`.
fn max_items(more: usize) -> Vec<u8> {
    // A node takes two bits and a palette size four; all other symbols take none.
    let tables = own_set(|family| match family.alphabet {
        4 if family.first_context == NODE.first_context => vec![1024; 4],
        16 if family.first_context == PALETTE_SIZE.first_context => vec![256; 16],
        alphabet => [vec![4096], vec![0; alphabet - 1]].concat(),
    });
    let size = [32, 32];
    let header = Header { set: BUILT_IN, colors: vec![[9, 80, 200]], ..usual_header(1) };
    for colors in 1..=256 {
        let (mut stream, mut palettes) = (Encoder::default(), 0..);
        let pick = |question: Question<'_>| match question {
            Question::Symbol(context, _) if contexts_of(NODE).contains(&context) => {
                if context / 10 > 1 {
                    QUARTERS as u32
                } else {
                    PALETTE as u32
                }
            }
            // `colors` colours in total, distributed over sixteen palettes.
            Question::Symbol(context, _) if contexts_of(PALETTE_SIZE).contains(&context) => {
                let at = palettes.next().unwrap_or(0);
                (colors * (at + 1) / 16 - colors * at / 16).max(1) - 1
            }
            Question::Symbol(..) | Question::Bits(_) | Question::Length(_) => 0,
        };
        let author = Author::new(&mut stream, &tables.sets()[header.set], pick);
        let region = Region::read_by(author, u64::MAX, Block::root(size, 1), still(&header)).unwrap();
        let items = region.leaves().map(|leaf| match &leaf.content {
            Content::Palette(palette) => 1 + palette.colors.len(),
            Content::Transform { .. } => 1,
        });
        let items = items.sum::<usize>();
        let bytes = stream.finish();
        if items == 64 + 8 * bytes.len() + more {
            let payload = header.write::<u8>(&[0], &[bytes]);
            return container(&[stream_of_one::<u8>(size.map(|side| side as u32), 1, &tables, payload)]);
        }
    }
    panic!("no region has so many leaves and colours");
}

/// Returns name and bytes of every valid vector.
pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("transform8-sizes-and-lengths", sizes_and_lengths::<u8>(100)),
        ("transform8-trees", trees::<u8>(110)),
        ("transform8-sums-that-wrap", sums_that_wrap::<u8>(200)),
        ("transform8-palettes", palettes::<u8>(300)),
        ("transform8-own-tables", own_tables::<u8>(400)),
        ("transform8-chunks-of-cells", chunks_of_cells()),
        ("transform8-most-items", max_items(0)),
        ("transform8-encoded", encoded_bytes()),
        ("transform-half-sizes-and-lengths", sizes_and_lengths::<HalfKey>(500)),
        ("transform-half-trees", trees::<HalfKey>(510)),
        ("transform-half-sums-that-wrap", sums_that_wrap::<HalfKey>(600)),
        ("transform-half-palettes", palettes::<HalfKey>(700)),
        ("transform-half-own-tables", own_tables::<HalfKey>(800)),
        ("transform-half-encoded", encoded_halves()),
        ("transform-half-chunks-of-cells", halves_in_chunks_of_cells()),
    ]
}

/// Returns a stream of one cell with a payload built by hand.
fn stream_of_one<S: Keyed>(size: [u32; 2], frames: u32, tables: &Tables, payload: Vec<u8>) -> Stream {
    let mut payload = Some(payload);
    stream::<S>(shape(0, size, size, 0, frames), &[frames as usize], tables, |_, _| payload.take().unwrap_or_default())
}

fn by_hand(size: [u32; 2], frames: u32, payload: Vec<u8>) -> Vec<u8> {
    container(&[stream_of_one::<u8>(size, frames, &Tables::default(), payload)])
}

/// Returns the parameters for reading a region of 8-bit colour with delta 0.
fn still(header: &Header) -> Setting<'_> {
    Setting { header, delta: 0, domain: &Domain::BYTES }
}

/// Returns a payload: a header without colours, for one or two regions with delta 0, followed by `rest`.
fn headed(rest: &[u8]) -> Vec<u8> {
    [&[0, 84, 89, 3, 0xf9, 0x80, 0x88], rest].concat()
}

/// Returns a payload of one region with these symbols, each with its context, and raw bits.
fn symbols(symbols: &[(usize, usize)], bits: &[(u32, u32)]) -> Vec<u8> {
    let tables = Tables::default();
    let mut stream = Encoder::default();
    for &(context, symbol) in symbols {
        stream.symbol(tables.sets()[0].distribution(context), symbol);
    }
    bits.iter().for_each(|&(value, count)| stream.bits(value, count));
    headed(&stream.finish())
}

/// Returns a payload with a palette of three colours and a pixel that refers to a fourth.
fn beyond_its_palette() -> Vec<u8> {
    let (header, tables) = (usual_header(1), Tables::default());
    let mut stream = Encoder::default();
    let pick = |question: Question<'_>| match question {
        Question::Symbol(0, _) => 3,
        Question::Symbol(context, _) if contexts_of(PALETTE_SIZE).contains(&context) => 2,
        Question::Symbol(context, _) if contexts_of(PIXEL).contains(&context) => 2,
        Question::Symbol(..) => 0,
        Question::Bits(3) => 3,
        Question::Bits(_) | Question::Length(_) => 0,
    };
    let author = Author::new(&mut stream, &tables.sets()[0], pick);
    assert!(Region::read_by(author, u64::MAX, Block::root([4, 4], 1), still(&header)).is_err());
    headed(&stream.finish())
}

/// Returns name, bytes and a part of the message of every invalid vector.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let mut all = Vec::new();
    let mut random = Random(900);
    let tables = own_sets(2, &mut random);
    let payload = |size, frames| {
        let taste = (USUAL, &mut Random(901));
        payload_of_taste::<u8>(size, frames, &usual_header(1), &Tables::default(), taste)
    };
    let with_header = |change: &dyn Fn(&mut Vec<u8>)| {
        let shape = shape(0, [6, 5], [6, 5], 0, 2);
        let mut stream = stream::<u8>(shape, &[2], &tables, payload);
        let mut header = stream.entry.codec_header.to_vec();
        change(&mut header);
        stream.entry.codec_header = header.into();
        container(&[stream])
    };
    let quality = |header: &mut Vec<u8>| header[16..24].copy_from_slice(&100.5f64.to_le_bytes());
    all.push(("transform-header-quality", with_header(&|header| quality(header)), "a quality of 100.5"));
    all.push(("transform-header-planes", with_header(&|header| header[24] = 4), "4 planes of colour"));
    all.push(("transform-header-reserved", with_header(&|header| header[26] = 1), "a reserved byte is not zero"));
    all.push(("transform-header-sets", with_header(&|header| header[28] = 9), "9 table sets"));
    let beyond = |header: &mut Vec<u8>| drop(header.splice(29.., [0x80, 0x20, 1]));
    all.push(("transform-header-frequencies", with_header(&beyond), "sum to more than 4096"));
    let long = |header: &mut Vec<u8>| drop(header.splice(29..30, [0x80, 0]));
    all.push(("transform-header-varint", with_header(&long), "not in its shortest form"));
    all.push(("transform-header-shorter", with_header(&|header| header.truncate(1000)), "more bytes expected"));
    all.push(("transform-header-longer", with_header(&|header| header.push(0)), "1 bytes after the last field"));

    let (small, wide) = (|payload| by_hand([6, 5], 2, payload), |payload| by_hand([40, 5], 2, payload));
    all.push(("transform-no-bytes", small(vec![]), "1 more bytes expected"));
    all.push((
        "transform-table-set",
        small([vec![BUILT_IN as u8], headed(&[])[1..].to_vec()].concat()),
        "table set 10",
    ));
    all.push(("transform-header-cut", small(headed(&[])[..5].to_vec()), "1 more bytes expected"));
    all.push(("transform-offset-set", small(vec![0, 84, 89, 3, 0, 0x20, 0x88]), "set 2 of frequency offsets"));
    all.push(("transform-deltas-cut", small(headed(&[])[..6].to_vec()), "1 more bytes expected"));
    all.push(("transform-colors-cut", small(vec![0, 84, 89, 3, 0, 2, 1, 2, 3, 4, 5]), "1 more bytes expected"));
    all.push(("transform-size-beyond", wide(headed(&[9, 1, 2])), "9 more bytes expected"));
    all.push(("transform-size-cut", wide(headed(&[])), "1 more bytes expected"));
    all.push(("transform-size-varint", wide(headed(&[0x81, 0, 7, 7])), "not in its shortest form"));
    let frames = |count| by_hand([1, 1], count, symbols(&[], &[]));
    all.push(("transform-too-many-frames", frames(97), "97 frames"));

    let size = "as its size does not allow";
    let node = |size: usize, length: usize, kind| [(10 * size + length, kind)];
    all.push(("transform-quarters-of-least", by_hand([4, 4], 1, symbols(&node(0, 0, 1), &[])), size));
    all.push(("transform-parts-of-one-frame", by_hand([4, 4], 1, symbols(&node(0, 0, 2), &[])), size));
    all.push(("transform-of-five-frames", by_hand([4, 4], 5, symbols(&node(0, 9, 0), &[])), size));
    all.push(("transform-too-many-items", max_items(1), "more blocks and colours than its substream justifies"));
    all.push(("transform-palette-index", by_hand([4, 4], 1, beyond_its_palette()), "that its palette does not have"));

    let end = "does not end where its symbols do";
    let good = payload([6, 5], 2);
    assert!(good.len() > 20);
    all.push(("transform-word-missing", small(good[..good.len() - 2].to_vec()), end));
    all.push(("transform-word-left", small([&good[..], &[0, 0]].concat()), end));
    all.push(("transform-byte-left", small([&good[..], &[0]].concat()), end));
    all.push(("transform-low-state", small(headed(&[0xff, 0xff, 0, 0])), end));
    all.push(("transform-raw-bit-left", small(symbols(&[(11, 0), (43, 0), (55, 0), (67, 0)], &[(1, 1)])), end));
    let cell = |flags: u8, frames: u32| {
        let mut cell = CellBuilder::default();
        cell.push_keyframe::<u8>(&[7; 3]);
        cell.push_weight(0, frames - 1);
        let mut payload = [vec![CELLS], cell.finish().unwrap()].concat();
        payload[3] = flags;
        by_hand([1, 1], frames, payload)
    };
    all.push(("transform-cells-closed", cell(1, 2), "are closed by the next chunk"));
    all.push(("transform-cells-flags", cell(2, 2), "flags 2"));
    all.push(("transform-cells-too-many-frames", cell(0, 97), "97 frames"));
    all.push(("transform-cells-cut", by_hand([1, 1], 1, vec![CELLS, 1, 0]), "expected"));
    all
}

fn note(file: &[u8], coverage: &mut Coverage) {
    let reader = Reader::from_memory(file.to_vec()).unwrap();
    for (at, stream) in (0..).zip(&reader.index().streams) {
        let CodecHeader::Color(ColorHeader { coding: ColorCoding::Transform(tables), .. }) =
            CodecHeader::read(stream).unwrap()
        else {
            panic!("a stream of another codec");
        };
        for chunk in reader.index().stream_chunks(at) {
            let payload = reader.fetch(chunk).unwrap();
            let [_, _, width, height] = stream.unit_rect(chunk.key.unit).map(|side| side as usize);
            let (size, frames) = ([width, height], chunk.key.frame_count);
            if !holds_cells(&payload) {
                let parse = if stream.codec == *b"CTR8" {
                    TransformChunk::parse::<u8>
                } else {
                    TransformChunk::parse::<HalfKey>
                };
                coverage.note(parse(&payload, size, frames, &tables).unwrap().regions());
            }
        }
    }
}

#[test]
fn every_size_length_and_palette_occurs_in_the_vectors() {
    for kind in ["transform8", "transform-half"] {
        let mut coverage = Coverage::default();
        valid().iter().filter(|(name, _)| name.starts_with(kind)).for_each(|(_, file)| note(file, &mut coverage));
        for (level, length) in (0..4).flat_map(|level| LENGTHS.map(|length| (level, length))) {
            assert!(coverage.transforms.contains(&(level, length)), "{kind}: no transform of {level}, {length}");
        }
        for colors in [1, 2, 3, 15, 16] {
            assert!(coverage.palettes.iter().any(|palette| palette.1 == colors), "{kind}: no palette of {colors}");
        }
        assert!(coverage.regions > 40);
    }
}
