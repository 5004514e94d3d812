//! Inputs of the kernels of the transform codec: random trees of blocks of all sizes and lengths, levels up to the maximum,
//! palettes, cells of many sizes, and moving pictures from the encoder.

use std::sync::Arc;

use crate::harness::Case;
use crate::selftest::cells::CellSample;
use crate::selftest::gathered::Gathered;
use codec::color::quality::{EightBit, Pu21, Quality};
use codec::color::transform::authored::{ANY, PALETTES, USUAL, WHOLE, random_payload};
use codec::color::transform::domain::ChromaSlopes;
use codec::color::transform::encode::{PricedTables, TransformEncoder};
use codec::color::transform::payload::Header;
use codec::color::transform::steps::{OFFSET_SETS, StepIndices};
use codec::color::transform::{Keyed, Tables, TransformChunk};
use codec::color::{CellFormat, HalfKey, SearchSettings, Target};
use codec::entropy::{Counts, TableSet};
use codec::error::Result;
use codec::math::random::Random;
use kernels::layout::{BoxRow, Job, Record, Unit};
use kernels::prepare::{self, Prepared};
use kernels::transform_tables::TransformTables;

/// Returns a random legal payload, which an encoder would not write.
pub fn any_payload<S: Keyed>(size: [usize; 2], frames: u32, tables: &Tables, random: &mut Random) -> Result<Vec<u8>> {
    let taste = random.pick(&[USUAL, ANY, WHOLE, PALETTES]).unwrap_or(USUAL);
    let mut index = || random.pick(&[0, 255, 30, 100, 160]).unwrap_or(0);
    let steps = StepIndices { luma: index(), chroma: index() };
    let slopes = ChromaSlopes { green: random.word() as i8, orange: random.word() as i8 };
    let mask = (1 << S::DOMAIN.key_bits) - 1;
    let colors = (0..random.below(16)).map(|_| [(); 3].map(|()| (random.word() & mask) as i32)).collect();
    let set = random.below(tables.sets().len() as u32) as usize;
    let offset_set = random.below(OFFSET_SETS.len() as u32) as usize;
    let header = Header { set, steps, slopes, offset_set, colors };
    random_payload::<S>(size, frames as usize, &header, tables, (taste, &mut |end| random.below(end)))
}

/// Returns the built-in table sets, and two sets with random frequencies.
pub fn random_tables(random: &mut Random) -> Tables {
    let set = |random: &mut Random| -> TableSet<_> {
        let mut counts = Counts::default();
        counts.by_cluster_mut().as_flattened_mut().fill_with(|| 1 + u64::from(random.below(400)));
        counts.fitted()
    };
    Tables::with_own((0..2).map(|_| set(random)).collect())
}

struct Cell {
    payload: Vec<u8>,
    size: [usize; 2],
    frames: u32,
}

/// Adds units that show frames of a chunk.
fn push<S: Keyed + CellSample>(all: &mut Gathered, tables: &Tables, cell: &Cell, shown: &[u32]) -> Result<()> {
    let Cell { payload, size, frames } = cell;
    let chunk = TransformChunk::parse::<S>(payload, *size, *frames, tables)?;
    let [width, height] = size.map(|side| side as u32);
    let prepared = prepare::of_transform::<S>(&chunk, payload, *frames, tables)?;
    let Prepared { stream, records, boxes, passes, .. } = prepared;
    all.passes = all.passes.max(passes);
    let (bytes, first, first_box) = (4 * all.stream.len() as u32, all.records.len(), all.boxes.len() as u32);
    all.records.extend(records.iter().map(|row| Record { at: row.at + bytes, first: row.first + first_box, ..*row }));
    all.boxes.extend(boxes.iter().map(|row| BoxRow { at: row.at + bytes, ..*row }));
    all.stream.extend(stream);
    let base = TransformTables::new([tables]).first_sets.first().copied().unwrap_or_default();
    for &frame in shown {
        let mut samples = vec![S::default(); 3 * size[0] * size[1]];
        chunk.show(frame as usize, None, &mut samples);
        let unit = all.push_unit(Unit { width, height, base, ..Unit::default() }, S::pack(&samples));
        let record = records.partition_point(|row| row.frame <= frame) - 1;
        let job = Job { unit, record: (first + record) as u32, ..Job::default() };
        all.push_job(job, records[record].work);
        all.pixels += u64::from(width * height);
        all.inputs += 1;
    }
    Ok(())
}

/// Returns random trees: every block size and length, cells smaller than a block and cells of many regions.
fn random_case<S: Keyed + CellSample>(sizes: &[[usize; 2]], lengths: &[u32], random: &mut Random) -> Result<Gathered> {
    let tables = random_tables(random);
    let mut all = Gathered { tables: TransformTables::new([&tables]).words, ..Gathered::default() };
    for (&size, &frames) in sizes.iter().flat_map(|size| lengths.iter().map(move |frames| (size, frames))) {
        let cell = Cell { payload: any_payload::<S>(size, frames, &tables, random)?, size, frames };
        let shown = [0, frames - 1, random.below(frames), random.below(frames)];
        push::<S>(&mut all, &tables, &cell, &shown)?;
    }
    Ok(all)
}

/// Sample types of the self-test, with a quality measure and a conversion from 8-bit levels.
pub trait Coded: Keyed + CellSample {
    type Quality: Quality<Self>;

    fn quality() -> Result<Self::Quality>;

    /// Converts a value of 0 to 255 to a sample.
    fn of_level(level: u8) -> Self;
}

impl Coded for u8 {
    type Quality = EightBit;

    fn quality() -> Result<EightBit> {
        Ok(EightBit)
    }

    fn of_level(level: u8) -> u8 {
        level
    }
}

impl Coded for HalfKey {
    type Quality = Pu21;

    fn quality() -> Result<Pu21> {
        Pu21::new(100.0)
    }

    fn of_level(level: u8) -> HalfKey {
        HalfKey::from_bits(half::f16::from_f32(f32::from(level) / 128.0).to_bits())
    }
}

/// Returns a picture of a disc with soft edges on a gradient with some noise, and flat bars. The disc moves by one pixel per
/// frame.
fn moving_picture<S: Coded>(size: [usize; 2], frame: u32, random: &mut Random) -> Vec<S> {
    let mut samples = Vec::with_capacity(3 * size[0] * size[1]);
    for (y, x) in (0..size[1] as i32).flat_map(|y| (0..size[0] as i32).map(move |x| (y, x))) {
        let (u, v) = (x - 20 - frame as i32, y - 24);
        let disc = (900 - u * u - v * v).clamp(0, 255);
        let bars = if y > 40 && (x / 5 + y / 7) % 2 == 0 { 60 } else { 0 };
        let noise = random.below(3) as i32;
        for channel in [disc, x + y + bars, 200 - disc / 2] {
            samples.push(S::of_level((channel + noise).clamp(0, 255) as u8));
        }
    }
    samples
}

/// Returns cells that the encoder wrote.
fn coded_case<S: Coded>(random: &mut Random) -> Result<Gathered> {
    const SIZE: [usize; 2] = [64, 64];
    const FRAMES: u32 = 24;
    let priced = Arc::new(PricedTables::new(Tables::default()));
    let mut all = Gathered { tables: TransformTables::new([&priced.tables]).words, ..Gathered::default() };
    let search = SearchSettings { target: Target::Psnr(40.0), ..SearchSettings::default() };
    let format = CellFormat::of_samples(SIZE[0], SIZE[1]);
    let mut encoder = TransformEncoder::new(format, search, FRAMES, Arc::clone(&priced));
    let quality = S::quality()?;
    for frame in 0..FRAMES {
        if let Some(chunk) = encoder.push(&moving_picture::<S>(SIZE, frame, random), &quality)? {
            let cell = Cell { payload: chunk.payload, size: SIZE, frames: chunk.frame_count };
            push::<S>(&mut all, &priced.tables, &cell, &(0..FRAMES).collect::<Vec<_>>())?;
        }
    }
    Ok(all)
}

pub(super) fn cases<S: Coded>(seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let small = [[1, 1], [4, 4], [5, 3], [3, 7], [8, 8], [16, 9], [17, 1], [32, 32]];
    let odd = [5, 7, 13, 23, 25, 64, 95, 96];
    let many = [[33, 5], [64, 64], [33, 65], [250, 251]];
    let cases = [
        ("random trees of every length", random_case::<S>(&small, &[1, 2, 3, 4, 6, 8, 12, 16, 24], random)),
        ("random trees of odd lengths", random_case::<S>(&small, &odd, random)),
        ("cells of many regions", random_case::<S>(&many, &[1, 3, 11], random)),
        ("moving pictures", coded_case::<S>(random)),
    ];
    // If a payload fails to parse, the case has no inputs, which the test of `ROWS` detects.
    cases.map(|(label, gathered)| gathered.unwrap_or_default().case(label)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_host_knows_the_pixels_that_change_between_any_two_frames() {
        let random = &mut Random::new(3);
        let tables = random_tables(random);
        for (size, frames) in [([33, 9], 8), ([5, 32], 25), ([64, 64], 6)] {
            let payload = any_payload::<u8>(size, frames, &tables, random).unwrap();
            let chunk = TransformChunk::parse::<u8>(&payload, size, frames, &tables).unwrap();
            let prepared = prepare::of_transform::<u8>(&chunk, &payload, frames, &tables).unwrap();
            let pixels = (size[0] * size[1]) as u64;
            for frame in 0..frames {
                for shown in (0..frames).map(Some).chain([None]) {
                    let changed = chunk.updated_pixels(frame as usize, shown.map(|shown| shown as usize));
                    assert_eq!(prepared.timeline.changed_pixels(frame, shown, pixels), changed, "{frame} {shown:?}");
                }
            }
        }
    }
}
