//! What colours four points have: [`super::interpolate::surface_color`] of each, but for what rounding makes of logarithms
//! and of the order of sums: less than a hundredth of a code of 8 bits.

use glam::Vec3;

use crate::image::transfer::ToneMap;
use crate::reconstruct::interpolate::{DEPTH_EPSILON, Seen};
use crate::reconstruct::lanes::{Lanes, Points, either, lanes_of, ln, to_whole};
use crate::reconstruct::light_field::{BACKGROUND, ColorTexels, UNKNOWN};
use crate::reconstruct::packet::{PacketView, PacketViews, Places};

/// What views saw, summed up.
#[derive(Debug)]
struct Sums {
    /// Red, green and blue, in codes up to 255 or light.
    color: [Lanes; 3],
    weight: Lanes,
    difference: Lanes,
}

/// What the views saw of surfaces in the points of these lanes. None where none of them saw any surface in its direction.
pub(crate) fn surface_colors(
    views: &PacketViews<'_>,
    camera_weights: &[f32],
    asked: u32,
    points: &Points,
) -> [Option<Seen>; 4] {
    let mut sums = Sums { color: [Lanes::ZERO; 3], weight: Lanes::ZERO, difference: Lanes::INFINITY };
    for (view, &camera_weight) in views.views.iter().zip(camera_weights) {
        let places = view.places(&view.local(points));
        if asked & places.exist != 0 {
            add(&mut sums, view, &places, asked & places.exist, camera_weight);
        }
    }
    let unit = if views.are_codes { 255.0 } else { 1.0 };
    let [red, green, blue] = sums.color.map(|color| (color / (unit * sums.weight)).to_array());
    let (weight, difference) = (sums.weight.to_array(), sums.difference.to_array());
    std::array::from_fn(|lane| {
        let color = Vec3::new(red[lane], green[lane], blue[lane]);
        (asked >> lane & 1 != 0 && weight[lane] > 0.0).then_some(Seen { color, difference: difference[lane] })
    })
}

fn add(sums: &mut Sums, view: &PacketView<'_>, places: &Places, lanes: u32, camera_weight: f32) {
    let (mut columns, mut rows, mut parts) = ([[0; 4]; 2], [[0; 4]; 2], [Lanes::ZERO; 2]);
    for (axis, ends) in [&mut columns, &mut rows].into_iter().enumerate() {
        let at = places.at[axis] - 0.5;
        let low = at.floor();
        parts[axis] = at - low;
        let within = |at: Lanes| to_whole(at.max(Lanes::ZERO).min(places.size[axis] - 1.0));
        *ends = [within(low), within(low + 1.0)];
    }
    let mut taps = [[0; 4]; 4];
    let mut depths = [[UNKNOWN; 4]; 4];
    for lane in lanes_of(lanes) {
        let face = places.face.of(lane);
        let (depth, width) = (view.depth[face], view.width[face] as usize);
        for tap in 0..4 {
            let texel = rows[tap / 2][lane] as usize * width + columns[tap % 2][lane] as usize;
            (taps[tap][lane], depths[tap][lane]) = (texel, depth.get(texel).copied().unwrap_or(UNKNOWN));
        }
    }
    let [across, down] = parts;
    let above = 1.0 - down;
    let bilinear = [(1.0 - across) * above, across * above, (1.0 - across) * down, across * down];
    for tap in 0..4 {
        let depth = Lanes::from_array(depths[tap]);
        let is_surface = depth.cmpgt(Lanes::splat(BACKGROUND)) & depth.cmplt(Lanes::splat(UNKNOWN));
        let ratio = either(is_surface, depth * places.planar_m, Lanes::ONE);
        let difference = ln(ratio).abs();
        let weight = bilinear[tap] * camera_weight / (difference + DEPTH_EPSILON);
        let weight = either(is_surface, weight, Lanes::ZERO);
        sums.weight += weight;
        sums.difference = sums.difference.min(either(is_surface, difference, Lanes::INFINITY));
        let counted = is_surface.bitmask();
        let colors = colors(view, places, counted, &taps[tap]);
        for (sum, color) in sums.color.iter_mut().zip(colors) {
            *sum += weight * color;
        }
    }
}

/// Red, green and blue of texels: codes up to 255, or light; 0 in lanes that do not count.
fn colors(view: &PacketView<'_>, places: &Places, lanes: u32, texels: &[usize; 4]) -> [Lanes; 3] {
    let mut codes = [0u32; 4];
    let mut light = [[0.0; 4]; 3];
    let mut are_codes = true;
    for lane in lanes_of(lanes) {
        let Some(face) = view.faces[places.face.of(lane)] else { continue };
        if let ColorTexels::Codes(of_face) = &face.color {
            codes[lane] = u32::from_le_bytes(of_face[texels[lane]]);
        } else {
            are_codes = false;
            let color = face.color.get(texels[lane]).to_array();
            (0..3).for_each(|channel| light[channel][lane] = color[channel]);
        }
    }
    if are_codes {
        let channel = |shift: u32| Lanes::from_array(codes.map(|code| (code >> shift & 0xff) as i32 as f32));
        [channel(0), channel(8), channel(16)]
    } else {
        light.map(Lanes::from_array)
    }
}

/// Linear light of codes between those of 8 bits, from a table.
#[derive(Debug)]
pub(crate) struct LightCurve {
    values: Vec<f32>,
}

impl LightCurve {
    /// Entries of the table; between them it is straight, which is off by less than 2e-7 of the brightest light.
    const PARTS: usize = 4096;

    pub(crate) fn new(tone: ToneMap) -> LightCurve {
        let gain = (-f64::from(tone.exposure_ev)).exp2();
        let value = |at: usize| (tone.transfer.decode(at as f64 / Self::PARTS as f64) * gain) as f32;
        LightCurve { values: (0..=Self::PARTS + 1).map(value).collect() }
    }

    /// Light of a code over 255.
    pub(crate) fn light(&self, code: f32) -> f32 {
        let at = code.clamp(0.0, 1.0) * Self::PARTS as f32;
        let entry = at as usize;
        let [low, high] = [self.values[entry], self.values[entry + 1]];
        low + (high - low) * (at - entry as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::transfer::Transfer;

    #[test]
    fn light_is_that_of_the_curve() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            let curve = LightCurve::new(ToneMap { transfer, exposure_ev: 0.0 });
            for at in 0..=100_000 {
                let code = at as f32 / 100_000.0;
                let exact = transfer.decode(f64::from(code));
                assert!((f64::from(curve.light(code)) - exact).abs() < 2e-7, "{code}");
            }
        }
    }
}
