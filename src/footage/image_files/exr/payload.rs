//! Checks the counters inside compressed chunks against the raw size of the chunk.
//!
//! RLE, ZIP, PXR24 and PIZ state no sizes of their own: the `exr` crate decodes them up to the raw size. DWAA and DWAB state
//! eleven counters, from which the crate computes allocation sizes. Damaged B44 blocks make the crate's sample arithmetic
//! negative.

use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::Compression;

/// Number of 8-byte counters at the start of a DWA chunk.
pub(super) const DWA_COUNTERS: usize = 11;
/// Number of AC coefficients of a block of 8x8 samples.
const AC_OF_BLOCK: u64 = 63;

/// Maximum sizes of the contents of a chunk, which follow from its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    pub raw_bytes: u64,
    columns: usize,
    rows: usize,
    channels: u64,
    /// Number of blocks of 8x8 samples of one channel.
    blocks: u64,
}

impl Room {
    pub fn new(header: &Header, Vec2(columns, rows): Vec2<usize>) -> Room {
        let pixels = (columns as u64).saturating_mul(rows as u64);
        Room {
            raw_bytes: pixels.saturating_mul(header.channels.bytes_per_pixel as u64),
            columns,
            rows,
            channels: header.channels.list.len() as u64,
            blocks: columns.div_ceil(8) as u64 * rows.div_ceil(8) as u64,
        }
    }

    fn all_blocks(&self) -> u64 {
        self.blocks.saturating_mul(self.channels)
    }

    /// Returns the bytes of the block buffers of a DWA chunk: three channels as floats at once, and for all channels the
    /// coefficients, both as inflated and as integers, and the samples.
    pub fn dct_bytes(&self) -> u64 {
        self.blocks.saturating_mul(3 * 64 * 4 + 8).saturating_add(self.all_blocks().saturating_mul(4 * 2 * 64 + 2 * 64))
    }
}

/// Checks a payload; the error continues a sentence about the chunk.
pub fn check(header: &Header, room: &Room, payload: &[u8]) -> Result<(), String> {
    // A chunk that compression would enlarge is stored uncompressed.
    if payload.len() as u64 == room.raw_bytes {
        return Ok(());
    }
    match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => check_dwa(room, payload),
        Compression::B44 | Compression::B44A => check_b44(header, room, payload),
        Compression::Uncompressed => {
            Err(format!("has {} bytes, where its pixels take {} bytes", payload.len(), room.raw_bytes))
        }
        _ => Ok(()),
    }
}

/// Checks the counters of a DWA chunk: sizes of four sections as stored and as inflated, and counts of coefficients.
fn check_dwa(room: &Room, payload: &[u8]) -> Result<(), String> {
    // An empty chunk decodes to zeros.
    if payload.is_empty() {
        return Ok(());
    }
    let (words, _) = payload.as_chunks::<8>();
    let Some(head) = words.first_chunk::<DWA_COUNTERS>() else {
        return Err(format!("has {} bytes, where a DWA chunk begins with 88 bytes of counters", payload.len()));
    };
    let [_, unknown, unknown_stored, ac_stored, dc_stored, rle_stored, rle_tokens, rle, ac, dc, _] =
        head.map(u64::from_le_bytes);
    let (raw, stored) = (room.raw_bytes, payload.len() as u64);
    let limits = [
        ("bytes of unclassified channels", unknown, raw),
        // Unclassified and run-length coded channels are disjoint.
        ("bytes of run-length coded channels", rle, raw.saturating_sub(unknown)),
        // A run takes two bytes and codes at least one byte.
        ("bytes of runs", rle_tokens, rle.saturating_mul(2)),
        ("AC coefficients", ac, room.all_blocks().saturating_mul(AC_OF_BLOCK)),
        ("DC coefficients", dc, room.all_blocks()),
        ("compressed bytes of unclassified channels", unknown_stored, stored),
        ("compressed bytes of AC coefficients", ac_stored, stored),
        ("compressed bytes of DC coefficients", dc_stored, stored),
        ("compressed bytes of runs", rle_stored, stored),
    ];
    match limits.iter().find(|(_, claimed, limit)| claimed > limit) {
        Some((what, claimed, limit)) => {
            Err(format!("claims {claimed} {what}, where {limit} at most fit its {stored} bytes and its pixels"))
        }
        None => Ok(()),
    }
}

/// Checks the blocks of 4x4 halves of a B44 chunk. Each sample is coded as a difference from a neighbour, and in files of every
/// encoder the sum is a 16-bit value. The crate subtracts without an overflow check.
fn check_b44(header: &Header, room: &Room, payload: &[u8]) -> Result<(), String> {
    let short = || format!("has {} bytes, fewer than its blocks take", payload.len());
    let mut rest = payload;
    for channel in &header.channels.list {
        if channel.sample_type != SampleType::F16 {
            let bytes = room.columns.saturating_mul(room.rows).saturating_mul(channel.sample_type.bytes_per_sample());
            rest = rest.get(bytes..).ok_or_else(short)?;
            continue;
        }
        for _ in 0..room.columns.div_ceil(4) * room.rows.div_ceil(4) {
            // A shift of 13 or more marks a block with a single value, in 3 bytes.
            let bytes = if *rest.get(2).ok_or_else(short)? >= 13 << 2 { 3 } else { 14 };
            let (block, behind) = rest.split_at_checked(bytes).ok_or_else(short)?;
            if let Some(block) = block.first_chunk::<14>()
                && steps_below_zero(block)
            {
                return Err("has a block whose samples step below zero".into());
            }
            rest = behind;
        }
    }
    Ok(())
}

/// Returns true if a sample of a 14-byte block is negative. The block has 16 bits of first sample, 6 bits of shift, and 15
/// differences of 6 bits.
fn steps_below_zero(block: &[u8; 14]) -> bool {
    /// Sample that each difference is added to, and the sample it yields: down the first column, then along the rows.
    const FROM: [(usize, usize); 15] = [
        (0, 4),
        (4, 8),
        (8, 12),
        (0, 1),
        (4, 5),
        (8, 9),
        (12, 13),
        (1, 2),
        (5, 6),
        (9, 10),
        (13, 14),
        (2, 3),
        (6, 7),
        (10, 11),
        (14, 15),
    ];
    let bits = block.iter().fold(0u128, |bits, byte| bits << 8 | u128::from(*byte));
    let mut samples = [0i64; 16];
    samples[0] = (bits >> 96) as i64;
    let shift = (bits >> 90) as u32 & 0x3f;
    for (at, (from, to)) in FROM.into_iter().enumerate() {
        let step = (bits >> (84 - 6 * at)) as i64 & 0x3f;
        let value = samples[from] + ((step - 0x20) << shift);
        if value < 0 {
            return true;
        }
        // Values of more than 16 bits are truncated.
        samples[to] = value & 0xffff;
    }
    false
}
