//! Decodes only the tiles that a moving camera sees, frame by frame: `cargo run --example camera_path`.
//!
//! The container is created in memory and has one probe with a cube map of depth. The camera is at the probe and turns around the
//! vertical axis. A tile is treated as visible if the direction of any of its corners or of its centre is in the field of view.

use lightfold::{Decoder, Encoder, Face, PixelsMut, ProbePose, Result};

const SIDE: u32 = 64;
const FRAMES: u32 = 12;
/// Cosine of half the field of view.
const COS_HALF_FOV: f64 = 0.8;

fn main() -> Result<()> {
    let container = Decoder::from_memory(sample()?)?;
    for frame in 0..FRAMES {
        let angle = std::f64::consts::TAU * f64::from(frame) / f64::from(FRAMES);
        let forward = [angle.sin(), 0.0, -angle.cos()];
        let (mut visible, mut all, mut nearest) = (0, 0, f32::INFINITY);
        for stream in container.streams() {
            for unit in 0..stream.unit_count() {
                let mut tile = container.unit(stream, unit);
                let [left, top, width, height] = tile.rect();
                all += 1;
                let [x, y, right, bottom] = [left, top, left + width, top + height].map(f64::from);
                let points =
                    [[x, y], [right, y], [x, bottom], [right, bottom], [(x + right) / 2.0, (y + bottom) / 2.0]];
                if points.iter().any(|point| cosine(stream.face, *point, forward) > COS_HALF_FOV) {
                    let mut metres = vec![0.0; width as usize * height as usize];
                    tile.decode_into(frame, PixelsMut::DepthMetres(&mut metres))?;
                    nearest = metres.iter().fold(nearest, |nearest, &z| nearest.min(z));
                    visible += 1;
                }
            }
        }
        println!("frame {frame}: {visible} of {all} tiles are visible, nearest surface {nearest:.2} m");
    }
    Ok(())
}

/// Returns the cosine of the angle between `forward` and the direction of a point of a face, given in pixels.
fn cosine(face: Face, [x, y]: [f64; 2], forward: [f64; 3]) -> f64 {
    let [ahead, right, down] = face.axes();
    let on_plane = |pixels: f64| 2.0 * pixels / f64::from(SIDE) - 1.0;
    let direction = (ahead + right * on_plane(x) + down * on_plane(y)).normalize();
    direction.to_array().iter().zip(forward).map(|(a, b)| a * b).sum()
}

/// Returns a container with a cube map of depth in which each face has a different distance.
fn sample() -> Result<Vec<u8>> {
    let mut encoder = Encoder::new("sample", 24.0);
    let probe = encoder.add_probe("00", ProbePose::default())?;
    for (face, metres) in Face::CUBE.into_iter().zip(2u8..) {
        let depth = encoder.add_depth(probe, face, [SIDE, SIDE])?;
        for frame in 0..FRAMES {
            encoder.push_depth(depth, &[f32::from(metres) + frame as f32 / 100.0; (SIDE * SIDE) as usize])?;
        }
    }
    Ok(encoder.finish(Vec::new())?.0)
}
