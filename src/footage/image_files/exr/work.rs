//! Counts the steps that the `exr` crate needs to decode a chunk, before the chunk is decoded.
//!
//! The crate searches for a Huffman code of more than 14 bits in a list, entry by entry, and compares the channels of a DWA chunk
//! with each other. Files of real encoders need a few steps per sample; a hostile file may need a hundred thousand.

use std::collections::HashSet;

use exr::meta::header::Header;
use exr::prelude::Compression;

use super::payload::{DWA_COUNTERS, Room};

/// Number of steps that any file is allowed.
const FREE_STEPS: u64 = 1 << 26;
/// Number of additional steps allowed per payload byte.
const STEPS_PER_STORED_BYTE: u64 = 64;
/// Raw pixel bytes per additional step allowed.
const RAW_BYTES_PER_STEP: u64 = 4;
/// Maximum length in bits of codes that a table lookup decodes.
const SHORT_BITS: u32 = 14;
const MAX_BITS: usize = 58;
/// Number of Huffman symbols: all 16-bit values and the run code.
const SYMBOLS: usize = (1 << 16) + 1;
/// Bytes before the code length table of a Huffman code.
const HUFFMAN_HEAD: usize = 20;
/// Maximum length of lists for which decoding is not simulated: it cannot exceed the allowed steps.
const SHORT_LIST: u64 = 64;
/// Bytes of the shortest channel rule of a DWA chunk.
const MIN_RULE_BYTES: u64 = 3;
/// Number of channel rules of chunks that state none (versions 0 and 1).
const OLD_RULES: u64 = 25;

/// Number of steps of the chunks of a file so far, and the limit.
#[derive(Debug, Clone, Default)]
pub struct Work {
    /// Comparisons per rule to classify the channels of each part.
    channels: Vec<u64>,
    steps: u64,
    allowed: u64,
}

impl Work {
    pub fn new(headers: &[Header]) -> Work {
        Work { channels: headers.iter().map(comparisons).collect(), steps: 0, allowed: FREE_STEPS }
    }

    /// Adds a chunk of a part. Fails if the limit is exceeded; the error continues a sentence about the chunk.
    pub fn add(&mut self, part: usize, header: &Header, room: &Room, payload: &[u8]) -> Result<(), String> {
        let measure = STEPS_PER_STORED_BYTE.saturating_mul(payload.len() as u64);
        self.allowed = self.allowed.saturating_add(measure).saturating_add(room.raw_bytes / RAW_BYTES_PER_STEP);
        if payload.len() as u64 == room.raw_bytes {
            return Ok(());
        }
        let steps = match header.compression {
            Compression::PIZ => piz_code(payload).map_or(0, huffman_steps),
            Compression::DWAA(_) | Compression::DWAB(_) => {
                let (rules, code) = dwa_parts(payload);
                let comparisons = self.channels.get(part).map_or(0, |channels| channels.saturating_mul(1 + rules));
                comparisons.saturating_add(code.map_or(0, huffman_steps))
            }
            _ => 0,
        };
        self.steps = self.steps.saturating_add(steps);
        match self.steps > self.allowed {
            true => Err(format!(
                "raises the steps to decode codes and channels to {}, where {} are allowed for the bytes read: save \
                the image with ZIP compression",
                self.steps, self.allowed
            )),
            false => Ok(()),
        }
    }
}

/// Returns the number of comparisons of channels with layer names per rule; 0 unless the part is DWA compressed.
fn comparisons(header: &Header) -> u64 {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return 0;
    }
    let layer = |name: &exr::meta::attribute::Text| {
        let name = name.to_string();
        name.rsplit_once('.').map_or(String::new(), |(layer, _)| layer.to_owned())
    };
    let layers: HashSet<String> = header.channels.list.iter().map(|channel| layer(&channel.name)).collect();
    header.channels.list.len() as u64 * layers.len() as u64
}

/// Returns the Huffman code of a PIZ chunk, which follows the bitmap.
fn piz_code(payload: &[u8]) -> Option<&[u8]> {
    let (bounds, rest) = payload.split_at_checked(4)?;
    let [first, last] = [[bounds[0], bounds[1]], [bounds[2], bounds[3]]].map(u16::from_le_bytes).map(usize::from);
    let bitmap = if first <= last { last - first + 1 } else { 0 };
    rest.get(bitmap + 4..)
}

/// Returns the maximum number of rules of a DWA chunk, and its AC coefficients if they are Huffman coded.
fn dwa_parts(payload: &[u8]) -> (u64, Option<&[u8]>) {
    let (words, _) = payload.as_chunks::<8>();
    let Some(head) = words.first_chunk::<DWA_COUNTERS>() else { return (0, None) };
    let [version, _, unknown_stored, ac_stored, _, _, _, _, count, _, coder] = head.map(u64::from_le_bytes);
    let rest = &payload[8 * DWA_COUNTERS..];
    let rule_bytes = match (version, rest.first_chunk::<2>()) {
        (0 | 1, _) => 0,
        (_, Some(bytes)) => u64::from(u16::from_le_bytes(*bytes)),
        (_, None) => return (0, None),
    };
    let rules = if version < 2 { OLD_RULES } else { rule_bytes / MIN_RULE_BYTES };
    let place = |at: u64| usize::try_from(at).unwrap_or(usize::MAX);
    let start = place(rule_bytes.saturating_add(unknown_stored));
    let code = rest.get(start..start.saturating_add(place(ac_stored)));
    (rules, code.filter(|_| count > 0 && coder == 0))
}

/// Returns an upper bound of the list entries examined while decoding; 0 if the crate rejects the code before decoding.
fn huffman_steps(code: &[u8]) -> u64 {
    Code::read(code).map_or(0, |code| code.steps())
}

/// A canonical Huffman code: longer codes have smaller values.
struct Code<'a> {
    /// Number of codes of each length, and the first code of each length.
    counts: [u64; MAX_BITS + 1],
    first: [u64; MAX_BITS + 1],
    /// Length and value of the run code, which is followed by a count byte.
    run: (usize, u64),
    /// Number of long codes by their first [`SHORT_BITS`] bits.
    lists: Vec<u32>,
    coded: &'a [u8],
}

impl<'a> Code<'a> {
    fn read(bytes: &'a [u8]) -> Option<Code<'a>> {
        let (head, rest) = bytes.split_at_checked(HUFFMAN_HEAD)?;
        let word = |at: usize| head[4 * at..][..4].iter().rev().fold(0, |word, byte| word << 8 | usize::from(*byte));
        let (min, max) = (word(0), word(1));
        if min.max(max) >= SYMBOLS {
            return None;
        }
        let (lengths, coded) = lengths(rest, min, max)?;
        let mut counts = [0u64; MAX_BITS + 1];
        lengths.iter().for_each(|length| counts[usize::from(*length)] += 1);
        let (mut first, mut next) = ([0; MAX_BITS + 1], 0);
        for length in (1..=MAX_BITS).rev() {
            first[length] = next;
            next = (next + counts[length]) >> 1;
        }
        let run_length = usize::from(*lengths.last()?);
        let run = (run_length, (first[run_length] + counts[run_length]).saturating_sub(1));
        let mut lists = vec![0; 1 << SHORT_BITS];
        for length in SHORT_BITS as usize + 1..=MAX_BITS {
            for code in first[length]..first[length] + counts[length] {
                *lists.get_mut((code >> (length - SHORT_BITS as usize)) as usize)? += 1;
            }
        }
        Some(Code { counts, first, run, lists, coded })
    }

    fn steps(&self) -> u64 {
        let longest = u64::from(self.lists.iter().copied().max().unwrap_or(0));
        if longest <= SHORT_LIST {
            return 0;
        }
        // Codes written by encoders are complete, so every bit sequence decodes; incomplete codes are bounded without decoding.
        let covered: u128 = (1..=MAX_BITS).map(|length| u128::from(self.counts[length]) << (MAX_BITS - length)).sum();
        if covered != 1 << MAX_BITS {
            return longest.saturating_mul(self.coded.len() as u64 * 8 / u64::from(SHORT_BITS + 1));
        }
        let mut bits = Bits { bytes: self.coded, held: 0, count: 0 };
        let mut steps = 0u64;
        while let Some(start) = bits.peek(SHORT_BITS as usize) {
            let list = u64::from(self.lists[start as usize]);
            steps = steps.saturating_add(list);
            let lengths = if list > 0 { SHORT_BITS as usize + 1..=MAX_BITS } else { 1..=SHORT_BITS as usize };
            let found = lengths.filter(|length| self.counts[*length] > 0).find_map(|length| {
                let value = bits.peek(length)?;
                (self.first[length]..self.first[length] + self.counts[length])
                    .contains(&value)
                    .then_some((length, value))
            });
            let Some((length, value)) = found else { break };
            bits.count -= length;
            if (length, value) == self.run {
                if bits.peek(8).is_none() {
                    break;
                }
                bits.count -= 8;
            }
        }
        steps
    }
}

/// Returns the code lengths of the symbols `min` to `max`, and the bytes after the table. Runs of zero lengths are packed.
fn lengths(bytes: &[u8], min: usize, max: usize) -> Option<(Vec<u8>, &[u8])> {
    let count = (max + 1).checked_sub(min)?;
    let mut bits = Bits { bytes, held: 0, count: 0 };
    let mut lengths = Vec::with_capacity(count);
    while lengths.len() < count {
        let zeros = match bits.take(6)? {
            63 => bits.take(8)? + 6,
            word @ 59..=62 => word - 57,
            length => {
                lengths.push(length as u8);
                continue;
            }
        };
        lengths.resize(lengths.len() + zeros as usize, 0);
    }
    (lengths.len() == count).then_some((lengths, bits.bytes))
}

/// Bit reader, most significant bit first. It buffers 128 bits, since a code of 58 bits may begin at the last bit of a byte.
struct Bits<'a> {
    bytes: &'a [u8],
    held: u128,
    count: usize,
}

impl Bits<'_> {
    /// Returns the next bits without consuming them.
    fn peek(&mut self, count: usize) -> Option<u64> {
        while self.count < count {
            let (byte, rest) = self.bytes.split_first()?;
            (self.held, self.count, self.bytes) = (self.held << 8 | u128::from(*byte), self.count + 8, rest);
        }
        Some((self.held >> (self.count - count)) as u64 & ((1 << count) - 1))
    }

    fn take(&mut self, count: usize) -> Option<u64> {
        let bits = self.peek(count)?;
        self.count -= count;
        Some(bits)
    }
}
