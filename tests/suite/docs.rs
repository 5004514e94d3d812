//! The documents under formats/ against the library: examples, tables, constants, citations and links.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use codec::color::{HalfKey, Sample};
use codec::container::{Compression, Fields, Reader};
use codec::depth::domain::Domain;
use codec::depth::mode_decision::Decide;
use codec::depth::node_chunk::NodeChunk;
use codec::depth::node_encoder::{NodeEncoder, NodeSettings};
use codec::depth::nodes::Grid;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::projection::Projection;
use codec::depth::predictive::{self, Levels, PredictiveChunk, PredictiveHeader, Tables, UnitArea};
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::depth::{DepthRange, TemporalSettings};
use codec::effort::Effort;
use codec::entropy::{self, Distribution};
use half::f16;

use crate::samples::{self, Shape};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Returns the example file of container.md 8.
fn example() -> Vec<u8> {
    let settings = TemporalSettings { window: 1, epsilon: 0, max_aabbs: 8, keyframe_interval: 64 };
    let shape = Shape { face: 0, size: [2, 1], unit: [8, 8], first_frame: 0, frame_count: 2 };
    let stream = samples::depth(shape, [1.0, 2.0], &[vec![0, 65_535], vec![0, 32_767]], settings);
    let mut probe = samples::probe("p", 1);
    probe.position = [0.0, 1.5, 0.0];
    samples::container(0, probe, &[stream], Compression::None)
}

/// Returns the payload of depth.md 9: 12x8 codes, a plane on the left and raw leaves on the right; the second frame changes one
/// of the leaves.
fn example_of_nodes() -> Vec<u8> {
    let first: Vec<u16> = (0..96).map(|at| (at % 12, at / 12)).map(|(x, y)| code_of_example(x, y)).collect();
    let mut second = first.clone();
    second[3 * 12 + 11] = 5008;
    let settings = NodeSettings { window: 1, bound: 0, effort: Effort::Fast, ..NodeSettings::default() };
    let mut encoder = NodeEncoder::new(Grid { width: 12, height: 8 }, Domain::log(), settings);
    for frame in [first, second] {
        assert!(encoder.push(&frame, None).unwrap().is_none());
    }
    encoder.finish().unwrap().unwrap().payload
}

fn code_of_example(x: u16, y: u16) -> u16 {
    match (x, y) {
        (0..8, _) => 20_000 + 32 * x + 64 * y,
        (_, 0) => u16::MAX,
        _ => 5000 + (x * y) % 7,
    }
}

/// Returns the payload of depth.md 11: 8x4 codes of a plane.
fn example_of_tree() -> Vec<u8> {
    let codes: Vec<u16> = (0..32).map(|at| code_of_example(at % 8, at / 8)).collect();
    let settings = NodeSettings { window: 1, bound: 100, effort: Effort::Fast, ..NodeSettings::default() };
    let mut encoder = TreeEncoder::new(Grid { width: 8, height: 4 }, Domain::log(), settings);
    assert!(encoder.push(&codes).unwrap().is_none());
    encoder.finish().unwrap().unwrap().payload
}

fn predictive_header() -> PredictiveHeader {
    let projection = Projection { shape: predictive::projection::Shape::None, octave: 0 };
    PredictiveHeader {
        bound: 2,
        epsilon: 0,
        keyframe_interval: 64,
        projection,
        tables: Tables::default(),
        levels: Levels::default(),
    }
}

/// Returns the payload of depth.md 15.10: the codes of depth.md 9 in the predictive codec.
fn example_of_prediction() -> Vec<u8> {
    let first: Vec<u16> = (0..96).map(|at| code_of_example(at % 12, at / 12)).collect();
    let mut second = first.clone();
    second[3 * 12 + 11] = 5008;
    let area = UnitArea::whole([12, 8]);
    let mut encoder = PredictiveEncoder::new(&predictive_header(), area, Decide::Mse, Effort::Normal).unwrap();
    assert!([first, second].iter().all(|frame| encoder.push(frame).is_none()));
    encoder.finish().unwrap().payload
}

/// Returns the bytes of hex block `number` of a document. Fails if the offset of a line is wrong.
pub fn hex_bytes(document: &str, number: usize) -> Vec<u8> {
    let mut bytes: Vec<u8> = Vec::new();
    for (offset, line) in hex_lines(document, number) {
        assert_eq!(offset, bytes.len(), "the offset of a line of the example is wrong");
        bytes.extend(line);
    }
    bytes
}

/// Returns `(offset, bytes)` of every line of hex block `number`, counted from 0.
fn hex_lines(document: &str, number: usize) -> Vec<(usize, Vec<u8>)> {
    let block = document.split("```hex\n").nth(1 + number).expect("a block tagged hex");
    let block = block.split("```").next().unwrap();
    let hex = |text: &str| usize::from_str_radix(text, 16).unwrap_or_else(|_| panic!("{text:?} is not hexadecimal"));
    let line = |line: &str| {
        let (offset, rest) = line.split_once(':').expect("an offset");
        let bytes = rest.split('|').next().unwrap();
        (hex(offset.trim()), bytes.split_whitespace().map(|byte| hex(byte) as u8).collect())
    };
    block.lines().map(line).collect()
}

#[test]
fn the_substream_of_entropy_md_holds_what_it_says() {
    let document = read("formats/entropy.md");
    let (own, substream) = (hex_bytes(&document, 0), hex_bytes(&document, 1));
    let distribution = Distribution::read(&mut Fields::new(&own, 0, ""), 3).unwrap();
    assert_eq!([0, 1, 2].map(|symbol| distribution.frequency(symbol)), [2048, 1024, 1024]);
    let mut decoder = entropy::Decoder::new(&substream);
    let mut symbols = |count: usize| (0..count).map(|_| decoder.symbol(&distribution)).collect::<Vec<_>>();
    assert_eq!(symbols(2), [0, 2]);
    assert_eq!(decoder.bits(5), 19);
    assert_eq!(decoder.symbol(&distribution), 1);
    assert_eq!(decoder.bits(13), 5000);
    let rest: Vec<_> = (0..3).map(|_| decoder.symbol(&distribution)).collect();
    assert_eq!((rest, decoder.finished()), (vec![0, 2, 2], true));
}

#[test]
fn the_example_of_container_md_is_what_the_library_writes() {
    let bytes = hex_bytes(&read("formats/container.md"), 0);
    let written = example();
    let at = bytes.iter().zip(&written).position(|(a, b)| a != b);
    assert_eq!((at, bytes.len()), (None, written.len()), "the library writes {written:02x?}");
    let codes = samples::decode_all(bytes).unwrap();
    assert_eq!(codes, [[vec![0, 0, 0xff, 0xff], vec![0, 0, 0xff, 0x7f]]]);
}

#[test]
fn the_examples_of_depth_md_are_what_the_encoders_write() {
    let document = read("formats/depth.md");
    let examples = [example_of_nodes(), example_of_tree(), example_of_prediction()];
    for (number, written) in examples.into_iter().enumerate() {
        assert_eq!(hex_bytes(&document, number), written, "the library writes {written:02x?}");
    }
    let (grid, mut picture) = (Grid { width: 12, height: 8 }, vec![0; 96]);
    let nodes = NodeChunk::parse(hex_bytes(&document, 0), grid, 2, Domain::log()).unwrap();
    assert_eq!(nodes.advance(&mut picture, None, 1, 1), 96 + 16);
    assert_eq!([picture[0], picture[8], picture[3 * 12 + 10], picture[3 * 12 + 11]], [20_000, u16::MAX, 5002, 5008]);
    let chunk = PredictiveChunk::parse(hex_bytes(&document, 2), predictive_header(), UnitArea::whole([12, 8]), 2);
    assert_eq!(chunk.unwrap().advance(&mut picture, None, 1).unwrap(), 96 + 32);
    assert_eq!([picture[0], picture[1], picture[8], picture[3 * 12 + 11]], [19_998, 20_033, u16::MAX, 5010]);
}

#[test]
fn the_smallest_file_is_as_small_as_container_md_says() {
    let writer = codec::container::Writer::new(Vec::new(), "", 1.0, 0).unwrap();
    let (file, _) = writer.finish().unwrap();
    assert_eq!(file.len(), 16 + 18 + 40);
    assert!(Reader::from_memory(file).unwrap().index().streams.is_empty());
}

/// Returns the cells of each row of the table whose header begins with `heading`.
pub fn table(document: &str, heading: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| -> Vec<String> { line.split('|').map(|cell| cell.trim().to_owned()).collect() };
    let mut rows = document.lines().skip_while(|line| !line.starts_with(heading));
    assert!(rows.next().is_some() && rows.next().is_some(), "no table headed {heading}");
    rows.take_while(|line| line.starts_with('|')).map(|line| cells(line.trim_matches('|'))).collect()
}

#[test]
fn the_tables_of_arithmetic_md_hold() {
    let document = read("formats/arithmetic.md");
    let lerps = table(&document, "| a | b | w | lerp |");
    assert!(lerps.len() >= 7);
    for row in lerps {
        let numbers: Vec<u16> = row.iter().map(|cell| cell.parse().unwrap()).collect();
        let [a, b, weight, result] = numbers[..] else { panic!("{row:?}") };
        assert_eq!(HalfKey::lerp(HalfKey(a), HalfKey(b), weight as u8), HalfKey(result), "{row:?}");
        if a.max(b) <= 255 {
            assert_eq!(u16::from(u8::lerp(a as u8, b as u8, weight as u8)), result, "{row:?}");
        }
    }
    let keys = table(&document, "| bits | key | value |");
    assert!(keys.len() >= 11);
    for row in keys {
        let hex = |cell: &str| u16::from_str_radix(cell.trim_start_matches("0x"), 16).unwrap();
        let (bits, key) = (hex(&row[0]), hex(&row[1]));
        assert_eq!((HalfKey::from_bits(bits).0, HalfKey(key).to_bits()), (key, bits), "{row:?}");
        let value = f16::from_bits(bits).to_f64();
        match row[2].replace('−', "-").parse::<f64>() {
            Ok(said) => assert!(said.is_nan() == value.is_nan() && (said.is_nan() || said == value), "{row:?}"),
            Err(_) => assert_eq!(row[2], "least below zero"),
        }
    }
}

#[test]
fn functions_and_logarithms_of_arithmetic_md_hold() {
    use codec::depth::biquadratic::Biquadratic;
    use codec::depth::domain::{DomainKind, LOG2_TABLE, integer_log2};
    use codec::depth::platelet::{Plane, Platelet};
    let document = read("formats/arithmetic.md");
    let numbers = |row: &[String]| row.iter().map(|cell| cell.parse().unwrap()).collect::<Vec<i64>>();
    for row in table(&document, "| a0 | a1 | a2 |").iter() {
        let [a0, a1, a2, a3, a4, a5, x, y, r, code] = numbers(row)[..] else { panic!("{row:?}") };
        let function = Biquadratic { coefficients: [a0, a1, a2, a3, a4, a5].map(|a| a as i32) };
        assert_eq!(i64::from(function.value(x as i32, y as i32)), r, "{row:?}");
        assert_eq!(i64::from(Domain::log().code_of(r as i32)), code, "{row:?}");
    }
    for row in table(&document, "| x0 | y0 | x1 |").iter() {
        let [x0, y0, x1, y1, side, x, y] = numbers(&row[..7])[..] else { panic!("{row:?}") };
        let sides = [Plane::constant(0), Plane::constant(1)];
        let platelet = Platelet { sides, line: [x0, y0, x1, y1].map(|at| at as u8) };
        let level = (side / 4).ilog2() as u8;
        assert_eq!(["A", "B"][platelet.value(level, x as i32, y as i32) as usize], row[7], "{row:?}");
    }
    for row in table(&document, "| V | log |").iter() {
        let [value, log] = numbers(row)[..] else { panic!("{row:?}") };
        assert_eq!(i64::from(integer_log2(value as u32)), log);
    }
    for row in table(&document, "| domain | base | scale |").iter() {
        let kind = if row[0] == "linear" { DomainKind::Linear } else { DomainKind::Inverse };
        let [base, scale, r, code] = numbers(&row[1..])[..] else { panic!("{row:?}") };
        let domain = Domain::new(kind, DepthRange::new(0.5, 8.0).unwrap()).unwrap();
        assert_eq!((i64::from(domain.parts.base), i64::from(domain.parts.scale)), (base, scale));
        assert_eq!(i64::from(domain.code_of(r as i32)), code, "{row:?}");
    }
    let entries: Vec<u32> = table(&document, "| i | +0 | +1 |")
        .iter()
        .flat_map(|row| {
            row[1..].iter().filter(|cell| !cell.is_empty()).map(|cell| cell.parse().unwrap()).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(entries, LOG2_TABLE);
}

#[test]
fn the_constants_of_the_documents_are_those_of_the_code() {
    use codec::container::{chunk, index};
    let limits = table(&read("formats/container.md"), "| name | value | applies to |");
    let value = |name: &str| {
        let row = limits.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name} is not in the table"));
        row[1].split(' ').next().unwrap().replace(',', "").parse::<u64>().unwrap()
    };
    assert_eq!(value("MAX_SIZE"), u64::from(index::MAX_SIZE));
    assert_eq!(value("MAX_FRAME"), u64::from(index::MAX_FRAME));
    assert_eq!(value("MAX_CHUNK_BYTES"), u64::from(chunk::MAX_CHUNK_BYTES));
    assert_eq!(value("MAX_EXPANSION"), chunk::MAX_EXPANSION);
    assert_eq!(value("MAX_ZSTD_EXPANSION"), chunk::MAX_ZSTD_EXPANSION);
    let document = read("formats/color.md");
    let p = |name: &str| {
        let row = document.lines().find_map(|line| line.strip_prefix(&format!("| {name} | "))).unwrap();
        row.trim_end_matches(" |").parse::<f64>().unwrap()
    };
    let [p1, p2, p3, p4, p5, p6, p7] = ["p1", "p2", "p3", "p4", "p5", "p6", "p7"].map(p);
    for y in [0.005f64, 0.1, 1.0, 80.0, 100.0, 10_000.0] {
        let power = y.powf(p4);
        let said = p7 * (((p1 + p2 * power) / (1.0 + p3 * power)).powf(p5) - p6);
        assert!((said - codec::metrics::pu21_encode(y)).abs() < 1e-9);
    }
}

fn files_below(folder: PathBuf, extension: &str, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
}

/// Returns the section of every citation of `document` in a text, such as `6.1` for `container.md 6.1`.
fn citations(text: &str, document: &str) -> Vec<String> {
    let number = |rest: &str| {
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        rest[..end].trim_end_matches('.').to_owned()
    };
    let (plain, link) = (format!("{document} "), format!("({document}) "));
    let plain = text.match_indices(&plain).map(|(at, found)| number(&text[at + found.len()..]));
    let linked = text.match_indices(&link).map(|(at, found)| number(&text[at + found.len()..]));
    plain.chain(linked).filter(|section| !section.is_empty()).collect()
}

#[test]
fn every_section_that_is_cited_exists() {
    let documents = ["container.md", "depth.md", "color.md", "blocks.md", "arithmetic.md", "entropy.md", "errata.md"];
    let mut files = Vec::new();
    files_below(root().join("src"), "rs", &mut files);
    files.extend(documents.map(|document| root().join("formats").join(document)));
    let mut seen = 0;
    for document in documents {
        let text = read(Path::new("formats").join(document));
        let headings: HashSet<_> = text
            .lines()
            .filter(|line| line.starts_with('#'))
            .map(|line| line.trim_start_matches(['#', ' ']).split(' ').next().unwrap().trim_end_matches('.').to_owned())
            .collect();
        for file in &files {
            for section in citations(&fs::read_to_string(file).unwrap(), document) {
                assert!(headings.contains(&section), "{}: {document} has no section {section}", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 40, "only {seen} citations were found");
}

#[test]
fn links_between_documents_lead_somewhere() {
    let mut files = Vec::new();
    files_below(root().join("formats"), "md", &mut files);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split([')', '#']).next().unwrap()) {
            assert!(file.with_file_name(link).exists(), "{}: {link}", file.display());
        }
    }
}

/// Prints the examples, whose fields are then named by hand: `cargo test --test suite print_example -- --ignored --nocapture`.
#[test]
#[ignore = "prints"]
fn print_example() {
    for example in [example(), example_of_nodes(), example_of_tree()] {
        for (line, bytes) in example.chunks(16).enumerate() {
            println!("{:04x}: {}", line * 16, bytes.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" "));
        }
    }
}
