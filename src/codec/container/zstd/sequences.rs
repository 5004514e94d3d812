//! Sequences of a block (RFC 8878, 3.1.1.3.2): literals and matches, and their three FSE codes.

use std::sync::LazyLock;

use super::bits::{BackwardBits, damaged};
use super::fse::{Limits, Table};
use crate::error::Result;

/// Maximum offset code; offsets of larger codes exceed every window.
const MAX_OFFSET_CODE: u8 = 24;

/// Limits of the codes of literal lengths, offsets and match lengths, in this order.
const LIMITS: [Limits; 3] =
    [Limits { accuracy: 9, symbols: 36 }, Limits { accuracy: 8, symbols: 32 }, Limits { accuracy: 9, symbols: 53 }];

/// Default distributions (RFC 8878, 3.1.1.3.2.2).
static DEFAULTS: LazyLock<[Table; 3]> = LazyLock::new(|| {
    [
        Table::new(
            6,
            &[
                4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3, 2, 1, 1, 1, 1, 1, -1, -1,
                -1, -1,
            ],
        ),
        Table::new(5, &[1, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1]),
        Table::new(
            6,
            &[
                1, 4, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
                1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1,
            ],
        ),
    ]
});

/// Smallest value and number of extra bits of each code.
type LengthCodes<const N: usize> = [(u32, u8); N];

/// Codes of literal lengths (RFC 8878, 3.1.1.3.2.1.1).
const LITERAL_LENGTHS: LengthCodes<36> =
    length_codes(0, 16, [1, 1, 1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]);
const MATCH_LENGTHS: LengthCodes<53> =
    length_codes(3, 32, [1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]);

/// Builds `plain` codes without extra bits, followed by codes with extra bits.
const fn length_codes<const N: usize, const M: usize>(first: u32, plain: usize, extra: [u8; M]) -> LengthCodes<N> {
    let mut codes = [(0, 0); N];
    let (mut value, mut code) = (first, 0);
    while code < N {
        let bits = if code < plain { 0 } else { extra[code - plain] };
        codes[code] = (value, bits);
        value += 1 << bits;
        code += 1;
    }
    codes
}

/// State that is kept between the blocks of a frame: tables and repeated offsets.
pub struct State {
    tables: [Option<Table>; 3],
    repeats: [usize; 3],
}

/// Limits of the output of a block.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// Maximum distance of a match.
    pub window: usize,
    /// Maximum output bytes of all blocks up to this one.
    pub end: usize,
}

impl State {
    pub fn new() -> Self {
        State { tables: [None, None, None], repeats: [1, 4, 8] }
    }

    /// Executes the sequences in `bytes` and appends their literals and matches to `out`.
    pub fn write(&mut self, bytes: &[u8], literals: &[u8], out: &mut Vec<u8>, bounds: Bounds) -> Result<()> {
        let early = || damaged("sequences end early");
        let byte = |at: usize| bytes.get(at).copied().map(usize::from).ok_or_else(early);
        let (count, head) = match byte(0)? {
            first @ ..128 => (first, 1),
            first @ ..255 => (((first - 128) << 8) + byte(1)?, 2),
            _ => (byte(1)? + (byte(2)? << 8) + 0x7f00, 3),
        };
        let mut literals = literals;
        if count > 0 {
            let used = self.read_tables(bytes, head)?;
            self.execute(&bytes[used..], count, &mut literals, out, bounds)?;
        } else if head != bytes.len() {
            return Err(damaged("bytes follow the sequences"));
        }
        if literals.len() > bounds.end - out.len() {
            return Err(too_long());
        }
        out.extend_from_slice(literals);
        Ok(())
    }

    /// Reads the tables, from the byte of their modes on. Returns the offset of their end.
    fn read_tables(&mut self, bytes: &[u8], head: usize) -> Result<usize> {
        let illegal = || damaged("the modes of sequences are illegal");
        let modes = bytes.get(head).copied().filter(|modes| modes & 3 == 0).ok_or_else(illegal)?;
        let mut used = head + 1;
        for (which, (table, limits)) in self.tables.iter_mut().zip(LIMITS).enumerate() {
            match modes >> (6 - 2 * which) & 3 {
                0 => *table = Some(DEFAULTS[which].clone()),
                1 => {
                    let symbol = bytes.get(used).copied().filter(|symbol| usize::from(*symbol) < limits.symbols);
                    *table = Some(Table::of_one(symbol.ok_or_else(|| damaged("the code of a table is illegal"))?));
                    used += 1;
                }
                2 => {
                    let (read, size) = Table::read(&bytes[used..], limits)?;
                    (*table, used) = (Some(read), used + size);
                }
                _ => {}
            }
        }
        Ok(used)
    }

    /// Executes `count` sequences. `literals` is left with those after the last sequence.
    fn execute(
        &mut self,
        bytes: &[u8],
        count: usize,
        literals: &mut &[u8],
        out: &mut Vec<u8>,
        bounds: Bounds,
    ) -> Result<()> {
        let State { tables, repeats } = self;
        let [Some(lengths), Some(offsets), Some(matches)] = tables else {
            return Err(damaged("a table of sequences is missing"));
        };
        let mut bits = BackwardBits::new(bytes)?;
        let (mut length, mut offset, mut matched) =
            (lengths.start(&mut bits), offsets.start(&mut bits), matches.start(&mut bits));
        for left in (0..count).rev() {
            let rows = [lengths.row(length), offsets.row(offset), matches.row(matched)];
            let code = rows[1].symbol;
            if code > MAX_OFFSET_CODE {
                return Err(too_far());
            }
            let value = (1 << code) + bits.take(code.into()) as usize;
            let (base, extra) = MATCH_LENGTHS[usize::from(rows[2].symbol)];
            let match_length = (base + bits.take(extra.into())) as usize;
            let (base, extra) = LITERAL_LENGTHS[usize::from(rows[0].symbol)];
            let literal_length = (base + bits.take(extra.into())) as usize;
            if left > 0 {
                length = rows[0].next(&mut bits);
                matched = rows[2].next(&mut bits);
                offset = rows[1].next(&mut bits);
            }
            let Some((copied, rest)) = literals.split_at_checked(literal_length).filter(|_| bits.left() >= 0) else {
                return Err(damaged("sequences end early"));
            };
            if literal_length + match_length > bounds.end - out.len() {
                return Err(too_long());
            }
            *literals = rest;
            out.extend_from_slice(copied);
            copy(out, distance(repeats, value, literal_length)?, match_length, bounds.window)?;
        }
        if bits.left() != 0 {
            return Err(damaged("sequences have a wrong length"));
        }
        Ok(())
    }
}

fn too_long() -> crate::error::Error {
    damaged("a block exceeds its maximum size")
}

fn too_far() -> crate::error::Error {
    damaged("a match reaches farther back than the window")
}

/// Returns the distance of a match, which may be one of the last three distances (RFC 8878, 3.1.1.5).
fn distance(repeats: &mut [usize; 3], value: usize, literal_length: usize) -> Result<usize> {
    let [first, second, third] = *repeats;
    let which = if value > 3 { 3 } else { value - 1 + usize::from(literal_length == 0) };
    let chosen = match which {
        0 => first,
        1 => second,
        2 => third,
        _ if value > 3 => value - 3,
        _ => first - 1,
    };
    if chosen == 0 {
        return Err(damaged("a match has a distance of 0"));
    }
    match which {
        0 => {}
        1 => *repeats = [chosen, first, third],
        _ => *repeats = [chosen, first, second],
    }
    Ok(chosen)
}

/// Appends a match, which may overlap its own output.
fn copy(out: &mut Vec<u8>, distance: usize, count: usize, window: usize) -> Result<()> {
    if distance > window.min(out.len()) {
        return Err(too_far());
    }
    let start = out.len() - distance;
    let mut left = count;
    while left > 0 {
        // The copied part repeats with the same period.
        let part = left.min(out.len() - start);
        out.extend_from_within(start..start + part);
        left -= part;
    }
    Ok(())
}
