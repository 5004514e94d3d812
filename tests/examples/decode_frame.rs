//! Decodes one frame of every stream of a container and prints a statistic of it: `cargo run --example decode_frame FILE.lfold`.
//! Without a file, it creates a small container in memory.

use lightfold::{Decoder, Encoder, Face, PixelsMut, ProbePose, Result, StreamKind, f16};

fn main() -> Result<()> {
    let container = match std::env::args_os().nth(1) {
        Some(path) => Decoder::open(path)?,
        None => Decoder::from_memory(sample()?)?,
    };
    for stream in container.streams() {
        let ([width, height], probe) = (stream.size(), &container.probe(stream).name);
        let (frame, pixels) = (stream.frames.first, width as usize * height as usize);
        let mut images = container.face(stream);
        let found = match stream.kind {
            StreamKind::Depth => {
                let mut metres = vec![0.0; pixels];
                images.decode_into(frame, PixelsMut::DepthMetres(&mut metres))?;
                let surfaces = metres.iter().filter(|z| z.is_finite());
                format!("nearest surface {} m", surfaces.fold(f32::INFINITY, |nearest, &z| nearest.min(z)))
            }
            StreamKind::Color => {
                let mut light = vec![[f16::ZERO; 3]; pixels];
                images.decode_into(frame, PixelsMut::ColorHalf(&mut light))?;
                let sum: f32 = light.as_flattened().iter().map(|value| value.to_f32()).sum();
                format!("mean of all samples {:.3}", sum / (3 * pixels) as f32)
            }
            StreamKind::Material => {
                let mut material = vec![[0.0; 3]; pixels];
                images.decode_into(frame, PixelsMut::Material(&mut material))?;
                format!("largest reflection weight {}", material.iter().fold(0.0f32, |most, m| most.max(m[0])))
            }
            StreamKind::Alpha => {
                let mut alpha = vec![0.0f32; pixels];
                images.decode_into(frame, PixelsMut::Alpha(&mut alpha))?;
                format!("mean alpha {:.3}", alpha.iter().sum::<f32>() / pixels as f32)
            }
        };
        let (kind, face, codec) = (stream.kind.name(), stream.face.name(), stream.codec());
        println!("{kind} of probe {probe}, face {face}, {width}x{height}, {codec}, frame {frame}: {found}");
    }
    Ok(())
}

/// Returns a container with two frames of a probe with a single view.
fn sample() -> Result<Vec<u8>> {
    let size = [32, 16];
    let mut encoder = Encoder::new("sample", 24.0);
    let probe = encoder.add_probe("00", ProbePose::default())?;
    let depth = encoder.add_depth(probe, Face::View, size)?;
    let color = encoder.add_color(probe, Face::View, size)?;
    for frame in 0..2 {
        let metres: Vec<f32> = (0..512).map(|at| 1.0 + (at % 32) as f32 * 0.25 + frame as f32).collect();
        let light: Vec<[f16; 3]> = (0..512).map(|at| [f16::from_f32(at as f32 / 512.0); 3]).collect();
        encoder.push_depth(depth, &metres)?;
        encoder.push_color(color, &light)?;
    }
    Ok(encoder.finish(Vec::new())?.0)
}
