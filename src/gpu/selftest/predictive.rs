//! Random streams of predictive depth, with arbitrary codes or with levels. An encoder writes their chunks, because a random
//! payload almost never ends together with its last frame.

use crate::selftest::boxes::random_picture;
use codec::container::EncodedChunk;
use codec::depth::BACKGROUND_CODE;
use codec::depth::mode_decision::Decide;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::levels::MAX_LEVELS;
use codec::depth::predictive::projection::{Projection, Shape};
use codec::depth::predictive::{Levels, PredictiveHeader, Tables, UnitArea};
use codec::effort::Effort;
use codec::error::Result;
use codec::math::random::Random;

/// Returns a random header for pixels of any projection except a square cube face.
pub fn random_header(random: &mut Random) -> Result<PredictiveHeader> {
    let levels = if random.one_in(2) { random_levels(random)? } else { Levels::default() };
    let (bound, projection) = match (levels.is_empty(), random.one_in(2)) {
        (false, _) => (0, Projection::default()),
        (true, true) => (random.below(300) as u16, Projection::default()),
        (true, false) => {
            (random.below(300) as u16, Projection { shape: Shape::Planar, octave: 512 + random.below(9000) })
        }
    };
    Ok(PredictiveHeader { bound, epsilon: 0, keyframe_interval: 64, projection, tables: Tables::default(), levels })
}

/// Returns random levels: one, a few or the maximum number, anywhere among surface codes.
fn random_levels(random: &mut Random) -> Result<Levels> {
    let count = match random.below(4) {
        0 => 1,
        1 => MAX_LEVELS,
        _ => 2 + random.below(90) as usize,
    };
    let mut codes: Vec<u16> = (0..count).map(|_| random.below(BACKGROUND_CODE.into()) as u16).collect();
    codes.sort_unstable();
    codes.dedup();
    Levels::new(codes)
}

/// Returns a chunk of at most `frames` frames; each changes a rectangle of the previous one.
pub fn random_chunk(
    header: &PredictiveHeader,
    [width, height]: [u32; 2],
    frames: u32,
    random: &mut Random,
) -> Result<Option<EncodedChunk>> {
    let area = UnitArea::whole([width, height]);
    let mut encoder = PredictiveEncoder::new(header, area, Decide::Size, Effort::Fast)?;
    let mut picture: Vec<u16> = random_picture(width as usize * height as usize, random);
    picture.iter_mut().for_each(|value| *value = number_of(header, *value));
    for _ in 0..frames {
        if let Some(closed) = encoder.push(&picture) {
            return Ok(Some(closed));
        }
        let (left, top) = (random.below(width), random.below(height));
        let (columns, rows) = (1 + random.below(width - left), 1 + random.below(height - top));
        let (value, is_flat) = (random.word() as u16, random.one_in(2));
        for row in picture.chunks_exact_mut(width as usize).skip(top as usize).take(rows as usize) {
            for pixel in &mut row[left as usize..][..columns as usize] {
                *pixel = number_of(header, if is_flat { value } else { random.word() as u16 });
            }
        }
    }
    Ok(encoder.finish())
}

/// Maps a value to a code or the index of a level; one of 16 becomes background.
fn number_of(header: &PredictiveHeader, value: u16) -> u16 {
    match header.levels.codes().len() {
        _ if value.is_multiple_of(16) => BACKGROUND_CODE,
        0 => value,
        count => value % count as u16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::depth::predictive::PredictiveChunk;

    #[test]
    fn headers_have_levels_or_none_and_their_chunks_decode() {
        let mut random = Random::new(4);
        let mut with_levels = 0;
        for _ in 0..40 {
            let header = random_header(&mut random).unwrap();
            let size = [1 + random.below(30), 1 + random.below(30)];
            let chunk = random_chunk(&header, size, 6, &mut random).unwrap().unwrap();
            let levels = header.levels.clone();
            with_levels += usize::from(!levels.is_empty());
            let decoder =
                PredictiveChunk::parse(chunk.payload, header, UnitArea::whole(size), chunk.frame_count).unwrap();
            decoder
                .for_each_frame(|frame| {
                    assert!(levels.numbers(frame.picture).is_ok(), "a code that is no level");
                    Ok(())
                })
                .unwrap();
        }
        assert!((8..=32).contains(&with_levels), "{with_levels} of 40");
    }
}
