//! Inputs of the node kernel: all functions on all levels, in units of odd sizes, in all domains.

use crate::harness::Case;
use crate::selftest::gathered::Gathered;
use codec::depth::DomainParts;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of};
use codec::depth::runtime::{LEVELS, Runtime};
use codec::math::random::Random;
use kernels::layout::{Record, Unit};
use kernels::pictures::pack_codes;
use kernels::prepare::words_from;

fn push(all: &mut Gathered, grid: Grid, domain: &Domain, nodes: &[Node]) {
    let mut runtime = Runtime::new(grid);
    runtime.push(0, nodes);
    let mut picture = vec![0u16; grid.pixel_count() as usize];
    for &frame in &runtime.frames {
        all.pixels += runtime.apply(&mut picture, frame, domain);
    }
    let work: u32 = nodes.iter().map(|node| 1u32 << (2 * node.place.level)).sum();
    let unit = Unit {
        width: grid.width,
        height: grid.height,
        window: 1,
        domain: domain.kind() as u32,
        base: domain.parts.base,
        scale: domain.parts.scale,
        ..Unit::default()
    };
    let record = Record { at: all.stream.len() as u32, work, ..Record::default() };
    all.push(unit, record, pack_codes(&picture, grid.width as usize));
    all.stream.extend(words_from(&runtime.buffer));
    all.inputs += nodes.len() as u64;
}

/// Values at which sums wrap, signs change and codes are clamped.
const EDGES: [i32; 14] =
    [0, 1, -1, 31, 32, -32, 128, -129, i32::MAX, i32::MIN, i32::MAX - 8191, 1 << 30, (1 << 30) - 8193, 1_073_725_440];
/// Lines with equal endpoints, along the edges, diagonal, and of extreme slopes.
const LINES: [[u8; 4]; 10] = [
    [0, 0, 0, 0],
    [9, 9, 9, 9],
    [0, 0, 255, 255],
    [255, 255, 0, 0],
    [0, 128, 255, 128],
    [0, 128, 255, 127],
    [128, 0, 128, 255],
    [255, 0, 0, 255],
    [0, 255, 1, 0],
    [255, 254, 0, 255],
];
/// Sizes of units: smaller than a leaf, odd, and just over a power of two.
const SIZES: [[u32; 2]; 10] =
    [[1, 1], [3, 2], [4, 4], [5, 3], [7, 9], [8, 8], [17, 33], [50, 18], [129, 64], [255, 257]];

/// Returns all domains, with ordinary parameters and with the most extreme legal ones.
fn domains() -> Vec<Domain> {
    let parts = [
        (DomainKind::Log, 0, 0),
        (DomainKind::Linear, 335_543_950, 4_194_176),
        (DomainKind::Inverse, 402_652_814, 4_194_176),
        (DomainKind::Linear, 0, u32::MAX),
        (DomainKind::Inverse, (24 << 24) - 1, u32::MAX),
        (DomainKind::Linear, (24 << 24) - 1, 1),
        (DomainKind::Inverse, 0, 1),
        (DomainKind::Linear, 1, 699_050),
        (DomainKind::Inverse, 402_653_183, 698_998),
    ];
    parts.iter().filter_map(|&(kind, base, scale)| DomainParts { kind, base, scale }.domain().ok()).collect()
}

fn words_into(words: &[i32; 6], tail: [[u8; 4]; 2]) -> [u8; COEFFICIENT_BYTES] {
    let mut out = [0; COEFFICIENT_BYTES];
    let bytes = words.iter().map(|word| word.to_le_bytes()).chain(tail);
    out.as_chunks_mut::<4>().0.iter_mut().zip(bytes).for_each(|(out, bytes)| *out = bytes);
    out
}

/// Returns six coefficients: edge values, random bits, or small slopes around a value.
fn numbers(random: &mut Random) -> [i32; 6] {
    match random.below(4) {
        0 => std::array::from_fn(|_| random.pick(&EDGES).unwrap_or_default()),
        1 => std::array::from_fn(|_| random.word() as i32),
        _ => {
            let shift = 4 + random.below(20);
            let mut small = || random.word() as i32 >> shift;
            let slopes = [small(), small(), small() >> 2, small() >> 2, small() >> 2];
            let start = random.below(1 << 30) as i32;
            [slopes[0], slopes[1], slopes[2], slopes[3], slopes[4], start]
        }
    }
}

fn coefficients(function: Function, random: &mut Random) -> [u8; COEFFICIENT_BYTES] {
    const MARKER: [u8; 4] = [0xff; 4];
    match function {
        Function::Biquadratic => words_into(&numbers(random), [MARKER; 2]),
        Function::Platelet => {
            let line = match random.pick(&LINES) {
                Some(line) if random.one_in(2) => line,
                _ => random.below(u32::MAX).to_le_bytes(),
            };
            words_into(&numbers(random), [line, MARKER])
        }
        Function::Raw | Function::Bc4w => {
            let mut bytes = [0; COEFFICIENT_BYTES];
            random.fill(&mut bytes);
            // The last word of a BC4w block must not equal the marker.
            bytes[31] &= if function == Function::Bc4w { 0x7f } else { 0xff };
            bytes
        }
    }
}

fn functions_of(level: u8) -> &'static [Function] {
    match level {
        0 => &[Function::Raw],
        1 => &[Function::Biquadratic, Function::Platelet, Function::Bc4w],
        _ => &[Function::Biquadratic, Function::Platelet],
    }
}

/// Returns a node with a random function that is legal for its level.
pub(super) fn random_node(place: Place, random: &mut Random) -> Node {
    let function = random.pick(functions_of(place.level)).unwrap_or(Function::Raw);
    let coefficients = coefficients(function, random);
    debug_assert_eq!(function_of(place.level, &coefficients), function);
    Node { place, coefficients }
}

/// Returns random nodes that do not overlap, in depth-first order; with `holes` some places remain empty.
pub fn random_nodes(grid: Grid, holes: bool, random: &mut Random) -> Vec<Node> {
    fn walk(grid: Grid, place: Place, holes: bool, random: &mut Random, out: &mut Vec<Node>) {
        if !grid.has(place) || (holes && random.one_in(5)) {
            return;
        }
        if place.level > 0 && !random.one_in(4) {
            place.children().into_iter().for_each(|child| walk(grid, child, holes, random, out));
        } else {
            out.push(random_node(place, random));
        }
    }
    let mut out = Vec::new();
    walk(grid, grid.root(), holes, random, &mut out);
    out
}

pub(super) fn cases(seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let mut cases = vec![roots(random), lines()];
    let mut sizes = Gathered::default();
    for size in SIZES {
        for domain in &domains() {
            let grid = Grid { width: size[0], height: size[1] };
            let holes = random.one_in(2);
            push(&mut sizes, grid, domain, &random_nodes(grid, holes, random));
        }
    }
    cases.push(sizes.case("odd sizes"));
    let mut many = Gathered::default();
    let domains = domains();
    for at in 0..48 {
        let grid = Grid { width: 1 + random.below(200), height: 1 + random.below(200) };
        let nodes = random_nodes(grid, at % 3 == 0, random);
        push(&mut many, grid, &domains[at % domains.len()], &nodes);
    }
    cases.push(many.case("random units"));
    let mut large = Gathered::default();
    let grid = Grid { width: 1024, height: 1024 };
    (0..4).for_each(|_| push(&mut large, grid, &Domain::log(), &random_nodes(grid, false, random)));
    cases.push(large.case("units of 1024x1024"));
    cases
}

fn roots(random: &mut Random) -> Case {
    let mut gathered = Gathered::default();
    for domain in &domains() {
        for level in 0..LEVELS as u8 {
            let side = 4u32 << level;
            for &function in functions_of(level) {
                let place = Place { level, x: 0, y: 0 };
                let node = Node { place, coefficients: coefficients(function, random) };
                push(&mut gathered, Grid { width: side - u32::from(level) % 2, height: side }, domain, &[node]);
            }
        }
    }
    gathered.case("roots of all levels")
}

fn lines() -> Case {
    let mut gathered = Gathered::default();
    for domain in &domains() {
        for edge in EDGES {
            let place = Place { level: 1, x: 0, y: 0 };
            let coefficients = words_into(&[0, 0, 0, 0, 0, edge], [[0xff; 4]; 2]);
            push(&mut gathered, Grid { width: 8, height: 8 }, domain, &[Node { place, coefficients }]);
        }
    }
    for level in 1..LEVELS as u8 {
        for line in LINES {
            let place = Place { level, x: 0, y: 0 };
            let coefficients = words_into(&[0, 0, 1 << 20, 0, 0, 2 << 20], [line, [0xff; 4]]);
            let side = 4 << level;
            push(&mut gathered, Grid { width: side, height: side }, &Domain::log(), &[Node { place, coefficients }]);
        }
    }
    gathered.case("edges and lines")
}
