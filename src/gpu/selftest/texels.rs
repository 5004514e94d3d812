//! Inputs of the kernels that write texels: tiles of all sizes and positions, both kinds of depth, images of one texel and of
//! odd sizes.

use crate::harness::Case;
use codec::depth::DepthRange;
use codec::image::{DepthKind, TexelMap, ToneMap};
use codec::math::random::Random;
use kernels::layout::{DepthJob, NONE, PyramidJob, list_of};
use kernels::pictures::{code_stride, pack_codes};
use render::march::{DepthPyramid, Level};
use render::views::{BACKGROUND, ColorCoding, FaceTexels, InverseDepth, UNKNOWN};

/// Returns a random code; one of three is near, far or background, or adjacent to them.
fn code(random: &mut Random) -> u16 {
    let hard = [0, 1, u16::MAX - 2, u16::MAX - 1, u16::MAX];
    if random.one_in(3) { random.pick(&hard).unwrap_or_default() } else { random.word() as u16 }
}

pub(super) fn depths(seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let codes = ColorCoding::Codes(ToneMap::default());
    let mut cases = Vec::new();
    for (label, kind, size) in [
        ("one texel", DepthKind::Planar, [1, 1]),
        ("planar", DepthKind::Planar, [37, 23]),
        ("distance", DepthKind::Distance, [33, 61]),
        ("distance, a thousand texels wide", DepthKind::Distance, [1021, 9]),
        ("planar, many tiles", DepthKind::Planar, [512, 300]),
    ] {
        let Ok(range) = DepthRange::new(0.25, 900.0) else { continue };
        let inverse = InverseDepth::new(range, kind);
        let mut face = FaceTexels::unknown(size, TexelMap::cube_face(size), codes);
        let mut tables: Vec<u32> = inverse.of_code.iter().map(|inverse| inverse.to_bits()).collect();
        let stretch = tables.len() as u32;
        for row in 0..size[1] {
            tables.extend((0..size[0]).map(|column| face.map.ray_length_factor(column, row).to_bits()));
        }
        let (mut pictures, mut jobs, mut total) = (vec![0; 3], Vec::<DepthJob>::new(), 0);
        let pitch = size[0].next_multiple_of(64);
        // Texels without a job, and the padding between rows, must not change.
        let mut planes = vec![0xdead_beef; (pitch * size[1]) as usize];
        let before = planes.clone();
        let (columns, rows) = (1 + size[0] / 40, 1 + size[1] / 50);
        let unit = [size[0].div_ceil(columns), size[1].div_ceil(rows)];
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let [left, top] = [column * unit[0], row * unit[1]];
            if left >= size[0] || top >= size[1] {
                continue;
            }
            let [width, height] = [unit[0].min(size[0] - left), unit[1].min(size[1] - top)];
            let tile: Vec<u16> = (0..width * height).map(|_| code(random)).collect();
            let picture = pictures.len() as u32;
            pictures.extend(pack_codes(&tile, width as usize));
            if random.one_in(6) {
                continue;
            }
            let [x, y] = [random.below(width), random.below(height)];
            let [wide, high] = [1 + random.below(width - x), 1 + random.below(height - y)];
            let known = !random.one_in(5);
            for line in y..y + high {
                let from = (line * width + x) as usize;
                let place = ((top + line) * pitch + left + x) as usize;
                let codes = &tile[from..from + wide as usize];
                if known {
                    inverse.write_row(codes, &mut face, [left + x, top + line]);
                    let start = ((top + line) * size[0] + left + x) as usize;
                    let texels = &face.inverse_depth[start..start + wide as usize];
                    planes[place..place + wide as usize].iter_mut().zip(texels).for_each(|(a, b)| *a = b.to_bits());
                } else {
                    planes[place..place + wide as usize].fill(UNKNOWN.to_bits());
                }
            }
            total += wide * high;
            let place = (top + y) * pitch + left + x;
            let plain = DepthJob { width: wide, output: place, pitch, end: total, ..DepthJob::default() };
            let is_stretched = kind == DepthKind::Distance;
            jobs.push(DepthJob {
                picture: if known { picture } else { NONE },
                stride: code_stride(width),
                left: x,
                top: y,
                table: if known { 0 } else { UNKNOWN.to_bits() },
                ray_length: if is_stretched { stretch + (top + y) * size[0] + left + x } else { NONE },
                ray_length_pitch: size[0],
                ..plain
            });
        }
        if jobs.is_empty() {
            continue;
        }
        cases.push(Case {
            label: label.to_owned(),
            inputs: jobs.len() as u64,
            buffers: [
                ("pictures", pictures),
                ("tables", tables),
                ("jobs", list_of([total, jobs.len() as u32], &jobs)),
                ("planes", before),
            ]
            .into(),
            invocations: total,
            passes: 0,
            expected: vec![("planes", planes)],
            pixels: u64::from(total),
        });
    }
    cases
}

pub(super) fn squares(seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let mut cases = Vec::new();
    for size in [[1, 1], [2, 1], [1, 5], [7, 7], [64, 64], [129, 66], [300, 200]] {
        let texels: Vec<f32> = (0..size[0] * size[1])
            .map(|_| match random.below(9) {
                0 => UNKNOWN,
                1 => BACKGROUND,
                _ => random.word() as f32 / 1e9,
            })
            .collect();
        let mut pyramid = DepthPyramid::default();
        pyramid.update(size, &texels, 0..size[0], 0..size[1]);
        let mut below: ([u32; 2], Vec<f32>) = (size, texels);
        for (level, Level { size: above, greatest: values }) in pyramid.levels.into_iter().enumerate() {
            let (below_pitch, pitch) = (below.0[0].next_multiple_of(64), above[0] + 3);
            let mut planes = vec![0; (below_pitch * below.0[1]) as usize];
            for (row, texels) in below.1.chunks(below.0[0] as usize).enumerate() {
                let from = row * below_pitch as usize;
                planes[from..from + texels.len()].iter_mut().zip(texels).for_each(|(a, b)| *a = b.to_bits());
            }
            let place = planes.len() as u32;
            planes.resize(planes.len() + (pitch * above[1]) as usize, 77);
            let mut after = planes.clone();
            let [left, top] = above.map(|side| random.below(side));
            let (width, height) = (above[0] - left, above[1] - top);
            let most = if random.one_in(4) { 2f32.to_bits() } else { u32::MAX };
            for (row, column) in (top..above[1]).flat_map(|row| (left..above[0]).map(move |column| (row, column))) {
                let value = values[(row * above[0] + column) as usize].to_bits().min(most);
                after[(place + row * pitch + column) as usize] = value;
            }
            let job = PyramidJob {
                below: 0,
                below_pitch,
                below_width: below.0[0],
                below_height: below.0[1],
                left,
                top,
                width,
                output: place,
                pitch,
                limit: most,
                end: width * height,
            };
            cases.push(Case {
                label: format!("level {level} of {} x {} texels", size[0], size[1]),
                buffers: [("jobs", list_of([job.end, 1], &[job])), ("planes", planes)].into(),
                invocations: job.end,
                passes: 0,
                expected: vec![("planes", after)],
                inputs: 1,
                pixels: u64::from(job.end),
            });
            below = (above, values);
        }
    }
    // The largest case is timed.
    cases.sort_by_key(|case| case.pixels);
    cases
}
