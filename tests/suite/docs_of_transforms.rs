//! Sections 6 to 8 of formats/color.md against the library.

use codec::color::transform::authored::{Author, Question, contexts_of};
use codec::color::transform::basis::{COSINES, LENGTHS};
use codec::color::transform::blocks::{Block, MAX_FRAMES};
use codec::color::transform::contexts::{BUILT_IN, CLUSTERS, CONTEXTS, FAMILIES};
use codec::color::transform::domain::{ChromaSlopes, Domain};
use codec::color::transform::palette::CACHED;
use codec::color::transform::payload::Header;
use codec::color::transform::region::{Region, Setting};
use codec::color::transform::steps::{OFFSET_SETS, StepIndices, Steps};
use codec::color::transform::{Tables, TransformChunk};
use codec::entropy::tables::MAX_OWN;
use codec::entropy::{Encoder, Family};

use crate::docs::{hex_bytes, read, table};

const NAMES: [&str; 13] = [
    "NODE",
    "PLANES",
    "CODED",
    "LAST",
    "LAST_BITS",
    "LEVELS",
    "PALETTE_SIZE",
    "PALETTE_COLOR",
    "ROW",
    "PIXEL",
    "LATER_FRAME",
    "LATER_ROW",
    "LATER_PIXEL",
];

fn numbers(row: &[String]) -> Vec<usize> {
    row.iter().filter_map(|cell| cell.parse().ok()).collect()
}

#[test]
fn families_and_limits_are_those_of_the_code() {
    let document = read("formats/color.md");
    let rows = table(&document, "| family | contexts | first |");
    assert_eq!(rows.iter().map(|row| row[0].as_str()).collect::<Vec<_>>(), NAMES);
    for (row, family) in rows.iter().zip(FAMILIES) {
        let Family { first_context, contexts, alphabet, first_cluster, clusters } = family;
        assert_eq!(numbers(&row[1..6]), [contexts, first_context, alphabet, clusters, first_cluster], "{}", row[0]);
    }
    let says = |sentence: String| assert!(document.contains(&sentence), "color.md does not say: {sentence}");
    says(format!("of {CLUSTERS} distributions"));
    let entropy = read("formats/entropy.md");
    let says_of_sets = |row: String| assert!(entropy.contains(&row), "entropy.md does not say: {row}");
    says_of_sets(format!("| contexts | {},{:03} |", CONTEXTS / 1000, CONTEXTS % 1000));
    says_of_sets(format!("| distributions of a table set | {CLUSTERS} |"));
    says_of_sets(format!("| built-in sets | {BUILT_IN}, numbers 0 to {} |", BUILT_IN - 1));
    says_of_sets(format!("| own sets of a stream, in its codec header | 0 to {MAX_OWN}:"));
    says(format!("| 28 | 1 | u8 | own_set_count | 0 to {MAX_OWN} |"));
    says(format!("F must be at most {MAX_FRAMES}"));
    assert_eq!(CACHED, 15, "four bits of a payload's header");
    says(format!("bits 4 to 6: offset_set, 0 or {} (section 6.3)", OFFSET_SETS.len() - 1));
}

#[test]
fn bases_and_steps_are_those_of_the_code() {
    let document = read("formats/color.md");
    let cosines: Vec<usize> = table(&document, "| j | +0 |").iter().flat_map(|row| numbers(&row[1..])).collect();
    assert_eq!(cosines, COSINES.map(|cosine| cosine as usize));
    let octave = numbers(&table(&document, "| i | 0 | 1 | 2 |")[0]);
    let lengths = table(&document, "| length index | 0 |");
    assert_eq!(numbers(&lengths[0]), LENGTHS);
    let roots = numbers(&lengths[1]);
    let base_offset = |channel: &str| {
        let cell = &table(&document, "| channel | base |").into_iter().find(|row| row[0] == channel).unwrap()[1];
        cell.split(' ').nth(2).map_or(0, |offset| offset.parse::<i32>().unwrap())
    };
    let rows = table(&document, "| table | d | +0 |");
    let offsets = |name: &str| -> Vec<usize> {
        rows.iter().filter(|row| row[0].split(", ").any(|of| of == name)).flat_map(|row| numbers(&row[2..])).collect()
    };
    let indices = (0..=255).step_by(5).flat_map(|index| [0, 1].map(|set| (index, set, (index % 16) as i8 - 8)));
    for (domain, (index, set, delta)) in
        [Domain::BYTES, Domain::HALVES].iter().flat_map(|d| indices.clone().map(move |i| (d, i)))
    {
        let steps = Steps::new(StepIndices { luma: index, chroma: index }, set, delta, domain.steps);
        for (channel, name) in ["Y", "G", "O"].into_iter().enumerate() {
            let offsets = offsets(name);
            assert_eq!(offsets.len(), 64);
            for (z, x_y) in (0..4).flat_map(|z| (0..(8 << z) - 1).map(move |x_y| (z, x_y))) {
                let offset = if set == 0 { 0 } else { offsets[((2 * x_y + 1) << (3 - z)) >> 1] };
                let i = (i32::from(index) + base_offset(name) + 4 * i32::from(delta) + offset as i32).clamp(0, 255)
                    as usize;
                for (at, root) in roots.iter().enumerate() {
                    let (mantissa, shift) = ((octave[i % 16] * root + 2048) >> 12, 11 - domain.fraction_bits);
                    let said = ((mantissa << (i / 16)) + (1 << (shift - 1))) >> shift;
                    assert_eq!(steps.of(channel, z, at).at(x_y) as usize, said.max(1), "{name} {i} {at}");
                }
            }
        }
    }
}

/// Returns the header of the example in color.md 8.
fn header_of_example() -> Header {
    Header {
        set: 0,
        steps: StepIndices { luma: 96, chroma: 90 },
        slopes: ChromaSlopes { green: 4, orange: -8 },
        offset_set: 0,
        colors: vec![[16, 32, 48]],
    }
}

/// Encodes the payload of color.md 8 from its table of symbols.
fn example(document: &str) -> Vec<u8> {
    let mut rows = table(document, "| what | value | meaning |").into_iter();
    let mut value_of = |what: String| {
        let row = rows.next().unwrap_or_else(|| panic!("{what} is not in the table"));
        assert_eq!(row[0], what);
        row[1].parse().unwrap()
    };
    let pick = |question: Question<'_>| match question {
        Question::Symbol(context, _) => {
            let at = FAMILIES.iter().position(|family| contexts_of(*family).contains(&context)).unwrap();
            value_of(format!("{}({})", NAMES[at], context - FAMILIES[at].first_context))
        }
        Question::Bits(1) => 0,
        Question::Bits(2) => value_of("1 raw bit".into()),
        Question::Bits(below) | Question::Length(below) => value_of(format!("{} raw bits", below.ilog2())),
    };
    let (header, tables) = (header_of_example(), Tables::default());
    let mut stream = Encoder::default();
    let author = Author::new(&mut stream, &tables.sets()[header.set], pick);
    let setting = Setting { header: &header, delta: 0, domain: &Domain::BYTES };
    Region::read_by(author, u64::MAX, Block::root([5, 6], 2), setting).unwrap();
    assert!(rows.next().is_none(), "the table has rows too many");
    header.write::<u8>(&[0], &[stream.finish()])
}

/// Decodes both frames of the example.
fn pictures(payload: &[u8]) -> Vec<Vec<u8>> {
    let chunk = TransformChunk::parse::<u8>(payload, [5, 6], 2, &Tables::default()).unwrap();
    let mut shown = vec![0; 5 * 6 * 3];
    let picture = |frame: usize| {
        chunk.show(frame, frame.checked_sub(1), &mut shown);
        shown.clone()
    };
    (0..2).map(picture).collect()
}

#[test]
fn the_example_is_what_its_table_of_symbols_says() {
    let document = read("formats/color.md");
    let written = example(&document);
    assert_eq!(hex_bytes(&document, 0), written, "the library writes {}", hex(&written));
    let pictures = pictures(&written);
    let rows = table(&document, "| frame | x | y | red |");
    assert!(rows.len() >= 6);
    for row in rows {
        let [frame, x, y, rgb @ ..] = &numbers(&row)[..] else { panic!("{row:?}") };
        let shown = &pictures[*frame][3 * (y * 5 + x)..][..3];
        assert_eq!(shown.iter().map(|&key| usize::from(key)).collect::<Vec<_>>(), rgb, "{row:?}");
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}

/// Prints the payload and the pixels of color.md 8: `cargo test --test suite print_transform_example -- --ignored --nocapture`.
#[test]
#[ignore = "prints the example of color.md 8"]
fn print_transform_example() {
    let written = example(&read("formats/color.md"));
    println!("{}", hex(&written));
    for (frame, picture) in pictures(&written).iter().enumerate() {
        for (at, pixel) in picture.as_chunks::<3>().0.iter().enumerate() {
            println!("| {frame} | {} | {} | {} | {} | {} |", at % 5, at / 5, pixel[0], pixel[1], pixel[2]);
        }
    }
}
