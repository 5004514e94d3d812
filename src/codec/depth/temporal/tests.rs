use super::*;
use crate::depth::block_tiles::Layout;
use crate::depth::records::TemporalChunk;

/// Checks for the tests of the encoder with both layouts of pixels.
pub mod paths {
    use super::*;

    pub fn encode<T: Texel>(mut encoder: TemporalEncoder<T>, frames: &[Vec<T>]) -> Vec<EncodedChunk> {
        let mut chunks = Vec::new();
        for frame in frames {
            chunks.extend(encoder.push(frame).unwrap());
        }
        chunks.extend(encoder.finish().unwrap());
        assert_eq!(chunks.iter().map(|chunk| chunk.frame_count as usize).sum::<usize>(), frames.len());
        chunks
    }

    /// Decodes along random legal paths and the two canonical ones; all must show the same pictures, within the bound.
    pub fn check_all<T: Texel>(
        frames: &[Vec<T>],
        (size, layout): ([u32; 2], Layout),
        chunks: Vec<EncodedChunk>,
        settings: TemporalSettings,
    ) {
        let mut seed = 7u32;
        for chunk in chunks {
            let parsed = TemporalChunk::<T>::parse(layout, chunk.payload, size, chunk.frame_count).unwrap();
            parsed.check_window(settings.window, chunk.frame_count).unwrap();
            let body = |frame| parsed.records.iter().find(|record| record.frame == frame).map(|record| record.body);
            let mut canonical = vec![vec![T::default(); frames[0].len()]];
            parsed.apply(&mut canonical[0], body(0).unwrap());
            for frame in 1..chunk.frame_count {
                let mut picture = canonical[frame as usize - 1].clone();
                if let Some(body) = body(frame) {
                    parsed.apply(&mut picture, body);
                }
                canonical.push(picture);
            }
            for (at, picture) in canonical.iter().enumerate() {
                let source = &frames[chunk.first_frame as usize + at];
                let ok = picture.iter().zip(source).all(|(&held, &source)| T::within(held, source, settings.epsilon));
                assert!(ok, "frame {at} leaves the bound");
            }
            for _ in 0..50 {
                let (mut picture, mut frame) = (canonical[0].clone(), 0);
                while frame + 1 < chunk.frame_count {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    frame += 1 + (seed >> 16) % u32::from(settings.window);
                    frame = frame.min(chunk.frame_count - 1);
                    if let Some(body) = body(frame) {
                        parsed.apply(&mut picture, body);
                    }
                    assert_eq!(picture, canonical[frame as usize], "frame {frame}");
                }
            }
            for frame in 0..chunk.frame_count {
                let mut picture = vec![T::default(); frames[0].len()];
                parsed.advance(&mut picture, None, frame, settings.window);
                assert_eq!(picture, canonical[frame as usize]);
            }
        }
    }
}

const SIZE: [u32; 2] = [12, 9];

fn encode(frames: &[Vec<u16>], settings: TemporalSettings) -> Vec<EncodedChunk> {
    paths::encode(TemporalEncoder::new(SIZE[0], settings), frames)
}

fn check_all_paths(frames: &[Vec<u16>], settings: TemporalSettings) {
    paths::check_all::<u16>(frames, (SIZE, Layout::Values), encode(frames, settings), settings);
}

#[test]
fn every_legal_path_shows_the_same_frames_within_epsilon() {
    let mut seed = 3u32;
    let mut next = |n: u32| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 12) % n
    };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut frames = vec![vec![30_000u16; pixels]];
    for _ in 1..60 {
        let mut frame = frames[frames.len() - 1].clone();
        for _ in 0..next(6) {
            let at = next(pixels as u32) as usize;
            frame[at] = match next(4) {
                0 => u16::MAX,
                1 => frame[at].wrapping_add(1),
                2 => 30_000,
                _ => next(65_536) as u16,
            };
        }
        frames.push(frame);
    }
    for window in [1, 2, 3, 16, 100] {
        for epsilon in [0, 1, 40] {
            for (max_aabbs, keyframe_interval) in [(1, 1000), (8, 20), (256, 7), (3, 1)] {
                check_all_paths(&frames, TemporalSettings { window, epsilon, max_aabbs, keyframe_interval });
            }
        }
    }
}

#[test]
fn a_pixel_that_creeps_below_epsilon_for_600_frames_stays_within_it() {
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let frames: Vec<Vec<u16>> =
        (0..600u16).map(|n| (0..pixels).map(|at| if at == 50 { 1000 + n } else { 7 }).collect()).collect();
    let settings = TemporalSettings { epsilon: 10, keyframe_interval: 1000, ..TemporalSettings::default() };
    check_all_paths(&frames, settings);
    let chunk = &encode(&frames, settings)[0];
    let parsed = TemporalChunk::<u16>::parse(Layout::Values, chunk.payload.clone(), SIZE, 600).unwrap();
    // The pixel is sent every 11 frames, in both frames of the window.
    assert_eq!(parsed.records.len(), 1 + 599 / 11 * 2);
}

#[test]
fn a_static_unit_has_one_record_and_a_constant_one_no_pixels() {
    let flat = encode(&vec![vec![9; 108]; 30], TemporalSettings::default());
    assert_eq!(flat.len(), 1);
    assert_eq!(flat[0].payload.len(), 4 + 8 + 4 + 2);
    let ramp: Vec<u16> = (0..108).collect();
    let chunks = encode(&vec![ramp; 30], TemporalSettings { keyframe_interval: 10, ..Default::default() });
    assert_eq!(chunks.len(), 3);
    assert!(chunks.iter().all(|chunk| chunk.payload == chunks[0].payload));
}
