//! Encodes frames generated in memory, of a ball that moves in front of a wall, as a cube map of depth and colour: `cargo run
//! --example encode_from_memory [OUT.lfold]`.

#![allow(clippy::disallowed_methods)]

use std::fs::File;
use std::io::{BufWriter, Write};

use lightfold::{Encoder, Error, Face, ProbePose, Result, f16};

const SIDE: u32 = 64;
const FRAMES: u32 = 8;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1);
    let io = |error| Error::io(path.clone().unwrap_or_default(), error);
    let out: Box<dyn Write> = match &path {
        Some(path) => Box::new(BufWriter::new(File::create(path).map_err(io)?)),
        None => Box::new(std::io::sink()),
    };
    let mut encoder = Encoder::new("ball", 24.0);
    let probe = encoder.add_probe("00", ProbePose { position: [0.0, 1.5, 0.0], ..ProbePose::default() })?;
    let mut streams = Vec::new();
    for face in Face::CUBE {
        let size = [SIDE, SIDE];
        streams.push((encoder.add_depth(probe, face, size)?, encoder.add_color(probe, face, size)?));
    }
    for frame in 0..FRAMES {
        for &(depth, color) in &streams {
            let (metres, light) = image(frame);
            encoder.push_depth(depth, &metres)?;
            encoder.push_color(color, &light)?;
        }
    }
    let (mut out, summary) = encoder.finish(out)?;
    out.flush().map_err(io)?;
    println!(
        "{} images of {} streams: {} bytes, {:.1}% of {}",
        summary.frames,
        summary.streams,
        summary.bytes,
        100.0 * summary.bytes as f64 / summary.raw_bytes as f64,
        summary.raw_bytes
    );
    Ok(())
}

/// Returns distances in metres and linear RGB of a frame; all faces have the same image.
fn image(frame: u32) -> (Vec<f32>, Vec<[f16; 3]>) {
    let center = [16.0 + 4.0 * frame as f32, 32.0];
    let pixels = (0..SIDE * SIDE).map(|at| [(at % SIDE) as f32, (at / SIDE) as f32]);
    let on_ball = |[x, y]: [f32; 2]| (x - center[0]).hypot(y - center[1]) < 12.0;
    pixels
        .map(|pixel| if on_ball(pixel) { (2.0, [f16::from_f32(0.8); 3]) } else { (5.0, [f16::from_f32(0.2); 3]) })
        .unzip()
}
