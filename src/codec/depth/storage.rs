//! Storage form of nodes, without redundant bits (depth.md 9, GDC 4).
//!
//! Input: nodes in the order of the walk. Output: bytes that decode to exactly these nodes. The paper stores a level count, a
//! place of two bytes and two bits of function for each node, and its coefficients in full. Here a walk over the quadtree codes
//! level and place in one to three bits, and low bits of coefficients that are zero are omitted.

use byteorder::{ByteOrder, LittleEndian};

use crate::container::fields::Fields;
use crate::depth::bits::{BitReader, BitWriter};
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, Precision, function_of, integers};
use crate::depth::quantise::BACKGROUND_CODE;
use crate::error::{Error, Result};

pub const SECTION: &str = "depth.md 9";

const HEAD_BIQUADRATIC: u8 = 0;
const HEAD_PLATELET: u8 = 1;
const HEAD_BC4W: u8 = 2;
/// Mask of the field in a raw node's head that contains the number of bits per value.
const RAW_BITS: u8 = 0x1F;
/// Flag in a raw node's head: the largest value represents the background.
const RAW_BACKGROUND: u8 = 0x20;

/// Coverage of a unit by a record's nodes; the first byte of the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Coverage {
    /// The nodes cover the whole unit. The walk has no bits for empty places.
    Complete = 0,
    Partial = 1,
}

fn coverage(grid: Grid, nodes: &[Node]) -> Coverage {
    let covered: u64 = nodes.iter().map(|node| grid.pixels_of(node.place)).sum();
    if covered == grid.pixel_count() { Coverage::Complete } else { Coverage::Partial }
}

pub fn write_record(grid: Grid, nodes: &[Node], out: &mut Vec<u8>) {
    out.push(coverage(grid, nodes) as u8);
    write_nodes(grid, nodes, out);
}

fn write_nodes(grid: Grid, nodes: &[Node], out: &mut Vec<u8>) {
    let mut walk = WalkWriter { grid, coverage: coverage(grid, nodes), left: nodes, bits: BitWriter::default() };
    walk.visit(grid.root());
    out.extend(walk.bits.finish());
    write_functions(nodes, out);
}

pub fn read_nodes(grid: Grid, coverage: Coverage, fields: &mut Fields<'_>) -> Result<Vec<Node>> {
    let mut places = Vec::new();
    let mut bits = BitReader::new(fields);
    read_walk(grid, coverage, grid.root(), &mut bits, &mut places)?;
    bits.finish()?;
    read_functions(&places, fields)
}

struct WalkWriter<'a> {
    grid: Grid,
    coverage: Coverage,
    left: &'a [Node],
    bits: BitWriter,
}

impl WalkWriter<'_> {
    fn visit(&mut self, place: Place) {
        if !self.grid.has(place) {
            return;
        }
        let next = self.left.first().map(|node| node.place).filter(|&next| place.holds(next));
        if self.coverage == Coverage::Partial {
            self.bits.put(u16::from(next.is_some()), 1);
        }
        let Some(next) = next else { return };
        if place.level > 0 {
            self.bits.put(u16::from(next == place), 1);
        }
        if next == place {
            self.left = &self.left[1..];
        } else {
            place.children().into_iter().for_each(|child| self.visit(child));
        }
    }
}

fn read_walk(
    grid: Grid,
    coverage: Coverage,
    place: Place,
    bits: &mut BitReader<'_, '_>,
    out: &mut Vec<Place>,
) -> Result<()> {
    if !grid.has(place) || (coverage == Coverage::Partial && !bits.bit()?) {
        return Ok(());
    }
    if place.level == 0 || bits.bit()? {
        out.push(place);
        return Ok(());
    }
    place.children().into_iter().try_for_each(|child| read_walk(grid, coverage, child, bits, out))
}

/// Returns the bytes of a node's function, without its share of the walk.
pub fn stored_bytes(node: &Node) -> usize {
    let mut sections = Sections::default();
    sections.push(node);
    sections.all().iter().map(|section| section.len()).sum()
}

/// Appends the functions of nodes: heads, numbers, lines, BC4w blocks, raw blocks, each in the order of the nodes.
pub fn write_functions(nodes: &[Node], out: &mut Vec<u8>) {
    let mut sections = Sections::default();
    nodes.iter().for_each(|node| sections.push(node));
    sections.all().iter().for_each(|section| out.extend_from_slice(section));
}

#[derive(Default)]
struct Sections {
    heads: Vec<u8>,
    numbers: Vec<u8>,
    lines: Vec<u8>,
    blocks: Vec<u8>,
    raw: Vec<u8>,
}

impl Sections {
    fn all(&self) -> [&[u8]; 5] {
        [&self.heads, &self.numbers, &self.lines, &self.blocks, &self.raw]
    }

    fn push(&mut self, node: &Node) {
        match node.function() {
            Function::Raw => push_raw(&node.coefficients, &mut self.raw),
            Function::Bc4w => {
                self.heads.push(HEAD_BC4W);
                self.blocks.extend_from_slice(&node.coefficients);
            }
            Function::Biquadratic => {
                let [a0, a1, a2, a3, a4, a5] = integers(&node.coefficients);
                let full = [a5, a0, a1, a2, a3, a4];
                let used = if [a2, a3, a4] != [0; 3] { 6 } else { used_of_plane([a5, a0, a1]) };
                let precision = precision_of(node.place.level, [&full[..3], &[]], &full[3..]);
                self.heads.push(HEAD_BIQUADRATIC | precision.get() << 2 | (used as u8 / 3) << 6);
                push_numbers(&full[..used], precision, node.place.level, &mut self.numbers);
            }
            Function::Platelet => {
                let [a0, a1, a5, b0, b1, b5] = integers(&node.coefficients);
                let sides = [[a5, a0, a1], [b5, b0, b1]];
                let precision = precision_of(node.place.level, [&sides[0], &sides[1]], &[]);
                let used = sides.map(used_of_plane);
                let planes = (u8::from(used[0] == 3)) << 6 | (u8::from(used[1] == 3)) << 7;
                self.heads.push(HEAD_PLATELET | precision.get() << 2 | planes);
                for (side, used) in sides.iter().zip(used) {
                    push_numbers(&side[..used], precision, node.place.level, &mut self.numbers);
                }
                self.lines.extend_from_slice(&node.coefficients[24..28]);
            }
        }
    }
}

fn used_of_plane([_, a0, a1]: [i32; 3]) -> usize {
    if a0 == 0 && a1 == 0 { 1 } else { 3 }
}

/// Returns the coarsest precision that represents all numbers exactly. Planes start with their constant term, then linear ones.
fn precision_of(level: u8, planes: [&[i32]; 2], quadratic: &[i32]) -> Precision {
    let zeros = |numbers: &mut dyn Iterator<Item = &i32>| numbers.map(|n| n.trailing_zeros()).min().unwrap_or(32);
    let constant = zeros(&mut planes.iter().filter_map(|plane| plane.first()));
    let linear = zeros(&mut planes.iter().flat_map(|plane| plane.iter().skip(1)));
    let quadratic = zeros(&mut quadratic.iter());
    let serves = |precision: &Precision| {
        let shifts = precision.shifts(level);
        shifts.constant <= constant && shifts.linear <= linear && shifts.quadratic <= quadratic
    };
    Precision::from_coarsest().find(serves).unwrap_or_default()
}

/// Returns the shift of number `at` of a plane or surface: constant, two linear, three quadratic.
fn shift_of(at: usize, precision: Precision, level: u8) -> u32 {
    let shifts = precision.shifts(level);
    match at {
        0 => shifts.constant,
        1 | 2 => shifts.linear,
        _ => shifts.quadratic,
    }
}

/// Appends numbers: zigzag, then seven bits per byte, the least significant first.
fn push_numbers(numbers: &[i32], precision: Precision, level: u8, out: &mut Vec<u8>) {
    for (at, number) in numbers.iter().enumerate() {
        let value = number >> shift_of(at, precision, level);
        let mut zigzag = (value << 1 ^ value >> 31) as u32;
        while zigzag >= 0x80 {
            out.push(zigzag as u8 | 0x80);
            zigzag >>= 7;
        }
        out.push(zigzag as u8);
    }
}

fn read_number(fields: &mut Fields<'_>, shift: u32) -> Result<i32> {
    let mut zigzag = 0u32;
    for byte_at in 0..5 {
        let byte = fields.u8()?;
        let bits = u32::from(byte & 0x7F);
        if byte_at == 4 && bits > 0xF {
            return Err(fields.error("a coefficient of more than 32 bits"));
        }
        zigzag |= bits << (7 * byte_at);
        if byte & 0x80 == 0 {
            let value = (zigzag >> 1) as i32 ^ -((zigzag & 1) as i32);
            let number = value.wrapping_shl(shift);
            return if number >> shift == value {
                Ok(number)
            } else {
                Err(fields.error(format!("a coefficient of {value} · 2^{shift} does not fit 32 bits")))
            };
        }
    }
    Err(fields.error("a coefficient of more than 5 bytes"))
}

/// Appends a raw node: a head with the bits per value and whether there is background, the smallest surface code, and the
/// differences from it.
fn push_raw(coefficients: &[u8; COEFFICIENT_BYTES], out: &mut Vec<u8>) {
    let mut codes = [0u16; 16];
    LittleEndian::read_u16_into(coefficients, &mut codes);
    let surfaces = || codes.iter().copied().filter(|&code| code != BACKGROUND_CODE);
    let background = surfaces().count() < 16;
    let (Some(least), Some(most)) = (surfaces().min(), surfaces().max()) else {
        out.push(0);
        out.extend_from_slice(&BACKGROUND_CODE.to_le_bytes());
        return;
    };
    // The background is represented by one value more than the surfaces need.
    let values = u32::from(most - least) + u32::from(background);
    let bits = 32 - values.leading_zeros();
    if bits >= 16 {
        out.push(16);
        out.extend_from_slice(coefficients);
        return;
    }
    out.push(bits as u8 | if background { RAW_BACKGROUND } else { 0 });
    out.extend_from_slice(&least.to_le_bytes());
    let stand_in = ((1u32 << bits) - 1) as u16;
    let mut packed = BitWriter::default();
    for code in codes {
        packed.put(if code == BACKGROUND_CODE { stand_in } else { code - least }, bits);
    }
    out.extend(packed.finish());
}

fn read_raw(fields: &mut Fields<'_>) -> Result<[u8; COEFFICIENT_BYTES]> {
    let mut out = [0; COEFFICIENT_BYTES];
    let head = fields.u8()?;
    let (bits, background) = (u32::from(head & RAW_BITS), head & RAW_BACKGROUND != 0);
    if bits > 16 || head & !(RAW_BITS | RAW_BACKGROUND) != 0 || (background && (bits == 0 || bits == 16)) {
        return Err(fields.error(format!("a raw node with head {head:#04x}")));
    }
    if bits == 16 {
        out.copy_from_slice(fields.bytes(COEFFICIENT_BYTES)?);
        return Ok(out);
    }
    let least = fields.u16()?;
    let packed = fields.bytes(2 * bits as usize)?;
    let stand_in = (1u32 << bits) - 1;
    let (mut held, mut held_bits, mut next) = (0u32, 0, packed.iter());
    for bytes in out.as_chunks_mut::<2>().0 {
        while held_bits < bits {
            held |= u32::from(next.next().copied().unwrap_or(0)) << held_bits;
            held_bits += 8;
        }
        let value = held & stand_in;
        held >>= bits;
        held_bits -= bits;
        let code = if background && value == stand_in {
            BACKGROUND_CODE
        } else {
            u16::try_from(u32::from(least) + value).map_err(|_| fields.error("a raw code above 65535"))?
        };
        *bytes = code.to_le_bytes();
    }
    Ok(out)
}

pub fn read_functions(places: &[Place], fields: &mut Fields<'_>) -> Result<Vec<Node>> {
    fields.enter(SECTION);
    let coarse = places.iter().filter(|place| place.level > 0).count();
    let mut heads = fields.bytes(coarse)?.iter();
    let mut nodes = Vec::with_capacity(places.len());
    for &place in places {
        let mut coefficients = [0; COEFFICIENT_BYTES];
        if place.level > 0 {
            read_numbers(place.level, heads.next().copied().unwrap_or(0), &mut coefficients, fields)?;
        }
        nodes.push(Node { place, coefficients });
    }
    // The markers now determine the functions. The remaining parts follow in the order of the sections.
    let lines = nodes.iter_mut().filter(|node| node.function() == Function::Platelet);
    for node in lines {
        let line = fields.bytes(4)?;
        if line == [0xFF; 4] {
            return Err(fields.error("a platelet with an invalid line"));
        }
        node.coefficients[24..28].copy_from_slice(line);
    }
    for node in nodes.iter_mut().filter(|node| node.function() == Function::Bc4w) {
        node.coefficients.copy_from_slice(fields.bytes(COEFFICIENT_BYTES)?);
        if function_of(node.place.level, &node.coefficients) != Function::Bc4w {
            return Err(fields.error("a BC4w block that ends like another function"));
        }
    }
    for node in nodes.iter_mut().filter(|node| node.place.level == 0) {
        node.coefficients = read_raw(fields)?;
    }
    Ok(nodes)
}

/// Reads the numbers and sets the marker of a node with this head. A BC4w block stays zero, which is not a marker.
fn read_numbers(
    level: u8,
    head: u8,
    coefficients: &mut [u8; COEFFICIENT_BYTES],
    fields: &mut Fields<'_>,
) -> Result<()> {
    let illegal = |fields: &Fields<'_>| -> Error { fields.error(format!("a node with head {head:#04x}")) };
    let precision = Precision::new(head >> 2 & 0xF).ok_or_else(|| illegal(fields))?;
    let mut integers = [0; 6];
    match (head & 3, head >> 6) {
        (HEAD_BIQUADRATIC, order @ 0..=2) => {
            let count = [1, 3, 6][usize::from(order)];
            for at in 0..count {
                integers[(at + 5) % 6] = read_number(fields, shift_of(at, precision, level))?;
            }
            coefficients[24..].fill(0xFF);
        }
        (HEAD_PLATELET, planes) => {
            for side in 0..2 {
                let count = if planes >> side & 1 == 1 { 3 } else { 1 };
                for at in 0..count {
                    integers[3 * side + (at + 2) % 3] = read_number(fields, shift_of(at, precision, level))?;
                }
            }
            coefficients[28..].fill(0xFF);
        }
        (HEAD_BC4W, 0) if level == 1 && precision.get() == 0 => {}
        _ => return Err(illegal(fields)),
    }
    LittleEndian::write_i32_into(&integers, &mut coefficients[..24]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::runtime::Runtime;
    use proptest::prelude::*;

    const GRID: Grid = Grid { width: 45, height: 30 };

    fn bytes(integers: [i32; 6], tail: [u8; 8]) -> [u8; 32] {
        let mut out = [0; 32];
        for (bytes, integer) in out.as_chunks_mut::<4>().0.iter_mut().zip(integers) {
            *bytes = integer.to_le_bytes();
        }
        out[24..].copy_from_slice(&tail);
        out
    }

    fn coefficients(level: u8) -> BoxedStrategy<[u8; 32]> {
        let integer = (any::<i32>(), 0..32u32).prop_map(|(value, shift)| (value >> shift) << (shift / 2));
        let integers = proptest::array::uniform6(integer);
        let biquadratic = (integers.clone(), 0..3).prop_map(|(mut integers, order)| {
            integers[[0, 2, 5][order as usize]..5].fill(0);
            bytes(integers, [0xFF; 8])
        });
        let platelet = (integers, any::<[u8; 3]>())
            .prop_map(|(integers, [a, b, c])| bytes(integers, [a, b, c, a & 0x7F, 0xFF, 0xFF, 0xFF, 0xFF]));
        let bc4w = any::<[u8; 32]>().prop_map(|mut bytes| {
            bytes[30] &= 0x7F;
            bytes
        });
        let raw = (any::<[u8; 32]>(), 0..17u32, any::<u16>()).prop_map(|(noise, bits, base)| {
            let mut out = [0; 32];
            for (out, noise) in out.as_chunks_mut::<2>().0.iter_mut().zip(noise.as_chunks::<2>().0) {
                let noise = u16::from_le_bytes(*noise);
                let small = (u32::from(noise) & ((1 << bits) - 1)) as u16;
                *out = if noise % 7 == 0 { u16::MAX } else { base.saturating_add(small) }.to_le_bytes();
            }
            out
        });
        match level {
            0 => raw.boxed(),
            1 => prop_oneof![biquadratic, platelet, bc4w].boxed(),
            _ => prop_oneof![biquadratic, platelet].boxed(),
        }
    }

    /// Returns nodes over random parts of the grid, in the order of the walk.
    fn nodes() -> impl Strategy<Value = Vec<Node>> {
        fn visit(place: Place, choices: &mut impl Iterator<Item = u8>, out: &mut Vec<Place>) {
            if !GRID.has(place) {
                return;
            }
            match choices.next().unwrap_or(0) % 4 {
                0 => {}
                1 => out.push(place),
                _ if place.level == 0 => out.push(place),
                _ => place.children().into_iter().for_each(|child| visit(child, choices, out)),
            }
        }
        proptest::collection::vec(any::<u8>(), 200).prop_flat_map(|choices| {
            let mut places = Vec::new();
            visit(GRID.root(), &mut choices.into_iter().chain(std::iter::repeat(1)), &mut places);
            let node =
                |place: Place| coefficients(place.level).prop_map(move |coefficients| Node { place, coefficients });
            places.into_iter().map(node).collect::<Vec<_>>()
        })
    }

    proptest! {
        #[test]
        fn storage_and_runtime_forms_turn_into_each_other(nodes in nodes()) {
            let mut stored = Vec::new();
            write_nodes(GRID, &nodes, &mut stored);
            let mut fields = Fields::new(&stored, 0, SECTION);
            let back = read_nodes(GRID, coverage(GRID, &nodes), &mut fields).unwrap();
            fields.finish().unwrap();
            prop_assert_eq!(&back, &nodes);
            let mut runtime = Runtime::new(GRID);
            runtime.push(3, &nodes);
            let nodes_of_frame = runtime.nodes(runtime.frames[0]);
            let mut walked: Vec<Node> = nodes_of_frame.map(|(place, &coefficients)| Node { place, coefficients }).collect();
            walked.sort_by_key(|node| node.place.walk_key());
            prop_assert_eq!(&walked, &nodes);
            prop_assert_eq!(runtime.buffer.len() % 16, 0);
            let mut again = Vec::new();
            write_nodes(GRID, &walked, &mut again);
            prop_assert_eq!(again, stored);
        }

        #[test]
        fn damaged_nodes_are_refused_or_lie_in_the_picture(nodes in nodes(), at in any::<usize>(), bit in 0..8) {
            let mut stored = Vec::new();
            write_nodes(GRID, &nodes, &mut stored);
            prop_assume!(!stored.is_empty());
            let at = at % stored.len();
            stored[at] ^= 1u8 << bit;
            for coverage in [Coverage::Complete, Coverage::Partial] {
                if let Ok(nodes) = read_nodes(GRID, coverage, &mut Fields::new(&stored, 0, SECTION)) {
                    prop_assert!(nodes.iter().all(|node| GRID.has(node.place)));
                    let covered: u64 = nodes.iter().map(|node| GRID.pixels_of(node.place)).sum();
                    prop_assert!(covered <= GRID.pixel_count());
                }
            }
        }
    }

    #[test]
    fn zero_bits_are_not_stored() {
        let node = |integers| Node { place: Place { level: 3, x: 0, y: 0 }, coefficients: bytes(integers, [0xFF; 8]) };
        // A constant in steps of 32 codes: head and two bytes.
        assert_eq!(stored_bytes(&node([0, 0, 0, 0, 0, 1000 << 19])), 3);
        assert_eq!(stored_bytes(&node([0, 0, 0, 0, 0, 1 << 30])), 3);
        assert_eq!(stored_bytes(&node([1, 0, 0, 0, 0, 1000 << 19])), 1 + 5 + 1 + 1);
        let raw = |codes: [u16; 16]| {
            let mut coefficients = [0; 32];
            coefficients.as_chunks_mut::<2>().0.iter_mut().zip(codes).for_each(|(b, code)| *b = code.to_le_bytes());
            Node { place: Place { level: 0, x: 0, y: 0 }, coefficients }
        };
        assert_eq!(stored_bytes(&raw([7; 16])), 3);
        assert_eq!(stored_bytes(&raw([u16::MAX; 16])), 3);
        let mut codes = [7; 16];
        codes[3] = 8;
        assert_eq!(stored_bytes(&raw(codes)), 3 + 2);
        codes[4] = u16::MAX;
        assert_eq!(stored_bytes(&raw(codes)), 3 + 4);
        codes[5] = 60_000;
        assert_eq!(stored_bytes(&raw(codes)), 33);
    }
}
