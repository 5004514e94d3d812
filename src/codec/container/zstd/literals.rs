//! Literals of a block (RFC 8878, 3.1.1.3.1).

use super::bits::damaged;
use super::huffman::Table;
use crate::error::Result;

/// Minimum number of literals in four streams.
const MIN_OF_FOUR_STREAMS: usize = 6;
/// Bytes of the jump table: the sizes of the first three of four streams.
const JUMP_TABLE_BYTES: usize = 6;

/// Reads a block's literals, at most `max` bytes, into `out`. Returns the number of bytes read. `table` is the Huffman table
/// of earlier blocks.
pub fn read(block: &[u8], table: &mut Option<Table>, out: &mut Vec<u8>, max: usize) -> Result<usize> {
    let early = || damaged("literals end early");
    let first = *block.first().ok_or_else(early)?;
    let (kind, form) = (first & 3, usize::from(first >> 2 & 3));
    // Bytes of the header, position of the sizes in it in bits, and bits of each size.
    let (head, shift, width) = match kind {
        0 | 1 => [(1, 3, 5), (2, 4, 12), (1, 3, 5), (3, 4, 20)][form],
        _ => [(3, 4, 10), (3, 4, 10), (4, 4, 14), (5, 4, 18)][form],
    };
    let header = block.get(..head).ok_or_else(early)?;
    let sizes = header.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte)) >> shift;
    let mask = (1u64 << width) - 1;
    let count = (sizes & mask) as usize;
    if count > max {
        return Err(damaged(format_args!("a block of {count} literals, {max} bytes at most")));
    }
    let size = match kind {
        0 => count,
        1 => 1,
        _ => (sizes >> width) as usize,
    };
    let body = block.get(head..head + size).ok_or_else(early)?;
    out.clear();
    match kind {
        0 => out.extend_from_slice(body),
        1 => out.resize(count, body[0]),
        _ => {
            let mut used = 0;
            if kind == 2 {
                let (read, bytes) = Table::read(body)?;
                (*table, used) = (Some(read), bytes);
            }
            let table = table.as_ref().ok_or_else(|| damaged("a Huffman table is missing"))?;
            out.resize(count, 0);
            if form > 0 {
                four_streams(table, &body[used..], out)?;
            } else if count > 0 {
                table.decode(&body[used..], out)?;
            } else {
                return Err(damaged("a Huffman stream of no literals"));
            }
        }
    }
    Ok(head + size)
}

fn four_streams(table: &Table, body: &[u8], out: &mut [u8]) -> Result<()> {
    let early = || damaged("literals end early");
    if out.len() < MIN_OF_FOUR_STREAMS {
        return Err(damaged(format_args!("four streams of {} literals", out.len())));
    }
    let (jumps, mut rest) = body.split_first_chunk::<JUMP_TABLE_BYTES>().ok_or_else(early)?;
    let mut parts = out.chunks_mut(out.len().div_ceil(4));
    for jump in jumps.chunks_exact(2) {
        let size = usize::from(u16::from_le_bytes([jump[0], jump[1]]));
        let (stream, others) = rest.split_at_checked(size).ok_or_else(early)?;
        table.decode(stream, parts.next().unwrap_or_default())?;
        rest = others;
    }
    // With six or nine literals, the last stream has none.
    table.decode(rest, parts.next().unwrap_or_default())
}
