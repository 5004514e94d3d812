//! Inputs of the kernel of nodes: all functions on all levels, in units of odd sizes, in all domains.

use crate::depth::domain::{Domain, DomainKind, LOG2_TABLE};
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of};
use crate::depth::runtime::{LEVELS, Runtime};
use crate::gpu::harness::Case;
use crate::gpu::layout::{Job, Record, Unit, words_of};
use crate::gpu::pictures::{code_stride, pack_codes};
use crate::math::random::Random;

/// Units of one dispatch, gathered.
#[derive(Default)]
struct Gathered {
    units: Vec<Unit>,
    records: Vec<Record>,
    jobs: Vec<Job>,
    stream: Vec<u32>,
    expected: Vec<u32>,
    nodes: u64,
    pixels: u64,
}

impl Gathered {
    /// Adds a unit that shows these nodes.
    fn push(&mut self, grid: Grid, domain: &Domain, nodes: &[Node]) {
        let mut runtime = Runtime::new(grid);
        runtime.push(0, nodes);
        let mut picture = vec![0u16; grid.pixel_count() as usize];
        for &frame in runtime.frames() {
            self.pixels += runtime.apply(&mut picture, frame, domain);
        }
        let work: u32 = nodes.iter().map(|node| 1u32 << (2 * node.place.level)).sum();
        let (unit, record) = (self.units.len() as u32, self.records.len() as u32);
        self.units.push(Unit {
            picture: self.expected.len() as u32,
            width: grid.width,
            height: grid.height,
            stride: code_stride(grid.width),
            window: 1,
            domain: domain.kind() as u32,
            base: domain.base(),
            scale: domain.scale(),
        });
        self.records.push(Record { at: self.stream.len() as u32, work, ..Record::default() });
        let end = self.jobs.last().map_or(0, |job| job.end) + work;
        self.jobs.push(Job { unit, end, record, ..Job::default() });
        self.stream.extend(runtime.buffer().as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)));
        self.expected.extend(pack_codes(&picture, grid.width as usize));
        self.nodes += nodes.len() as u64;
    }

    fn case(self, label: &str) -> Case {
        let invocations = self.jobs.last().map_or(0, |job| job.end);
        let mut jobs = vec![invocations, self.jobs.len() as u32];
        jobs.extend(words_of(&self.jobs));
        let pictures = vec![0; self.expected.len()];
        Case {
            label: label.to_owned(),
            buffers: vec![
                words_of(&self.units),
                words_of(&self.records),
                jobs,
                self.stream,
                LOG2_TABLE.to_vec(),
                pictures,
            ],
            invocations,
            expected: vec![(5, self.expected)],
            inputs: self.nodes,
            pixels: self.pixels,
        }
    }
}

/// Numbers at which sums wrap, signs change and codes are clamped.
const EDGES: [i32; 14] =
    [0, 1, -1, 31, 32, -32, 128, -129, i32::MAX, i32::MIN, i32::MAX - 8191, 1 << 30, (1 << 30) - 8193, 1_073_725_440];
/// Lines: of equal points, along the edges, diagonal, and as steep as they can be.
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
/// Sides of units: less than a leaf, odd, just over a level, and as large as they may be.
const SIZES: [[u32; 2]; 10] =
    [[1, 1], [3, 2], [4, 4], [5, 3], [7, 9], [8, 8], [17, 33], [50, 18], [129, 64], [255, 257]];

/// All domains, with ordinary numbers and with the most extreme that are legal.
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
    parts.iter().filter_map(|&(kind, base, scale)| Domain::from_parts(kind, base, scale).ok()).collect()
}

fn words_into(words: &[i32; 6], tail: [[u8; 4]; 2]) -> [u8; COEFFICIENT_BYTES] {
    let mut out = [0; COEFFICIENT_BYTES];
    let bytes = words.iter().map(|word| word.to_le_bytes()).chain(tail);
    out.as_chunks_mut::<4>().0.iter_mut().zip(bytes).for_each(|(out, bytes)| *out = bytes);
    out
}

/// Six numbers: edges, small slopes around a value, or anything.
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
            // A block's line must not be a marker.
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

/// A node at a place, of a random function that its level may have.
pub(super) fn random_node(place: Place, random: &mut Random) -> Node {
    let function = random.pick(functions_of(place.level)).unwrap_or(Function::Raw);
    let coefficients = coefficients(function, random);
    debug_assert_eq!(function_of(place.level, &coefficients), function);
    Node { place, coefficients }
}

/// Random nodes that do not overlap, in the order of the walk; some places may stay empty.
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
            sizes.push(grid, domain, &random_nodes(grid, holes, random));
        }
    }
    cases.push(sizes.case("odd sizes"));
    let mut many = Gathered::default();
    let domains = domains();
    for at in 0..48 {
        let grid = Grid { width: 1 + random.below(200), height: 1 + random.below(200) };
        let nodes = random_nodes(grid, at % 3 == 0, random);
        many.push(grid, &domains[at % domains.len()], &nodes);
    }
    cases.push(many.case("random units"));
    let mut large = Gathered::default();
    let grid = Grid { width: 1024, height: 1024 };
    (0..4).for_each(|_| large.push(grid, &Domain::log(), &random_nodes(grid, false, random)));
    cases.push(large.case("units of 1024x1024"));
    cases
}

/// One node of each level and function that covers its unit, in each domain.
fn roots(random: &mut Random) -> Case {
    let mut gathered = Gathered::default();
    for domain in &domains() {
        for level in 0..LEVELS as u8 {
            let side = 4u32 << level;
            for &function in functions_of(level) {
                let place = Place { level, x: 0, y: 0 };
                let node = Node { place, coefficients: coefficients(function, random) };
                gathered.push(Grid { width: side - u32::from(level) % 2, height: side }, domain, &[node]);
            }
        }
    }
    gathered.case("roots of all levels")
}

/// Constants at the edges of all domains, and lines of platelets on all levels.
fn lines() -> Case {
    let mut gathered = Gathered::default();
    for domain in &domains() {
        for edge in EDGES {
            let place = Place { level: 1, x: 0, y: 0 };
            let coefficients = words_into(&[0, 0, 0, 0, 0, edge], [[0xff; 4]; 2]);
            gathered.push(Grid { width: 8, height: 8 }, domain, &[Node { place, coefficients }]);
        }
    }
    for level in 1..LEVELS as u8 {
        for line in LINES {
            let place = Place { level, x: 0, y: 0 };
            let coefficients = words_into(&[0, 0, 1 << 20, 0, 0, 2 << 20], [line, [0xff; 4]]);
            let side = 4 << level;
            gathered.push(Grid { width: side, height: side }, &Domain::log(), &[Node { place, coefficients }]);
        }
    }
    gathered.case("edges and lines")
}
