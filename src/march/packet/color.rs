//! Colours of four points at once: [`crate::march::interpolate::seen_from_eye`] up to rounding of logarithms and of the order
//! of sums, less than a hundredth of an 8-bit code.

use glam::Vec3;

use crate::march::interpolate::{ANGLE_EPSILON, CUT_WEIGHT, DEPTH_CUT};
use crate::march::packet::lanes::{Lanes, Points, bytes, either, floor, lanes_of, ln, number_of, to_whole};
use crate::march::packet::views::{PacketView, PacketViews, Places};
use crate::march::{DEPTH_EPSILON, Interpolated, Refinements, RenderSettings};
use crate::views::{BACKGROUND, ColorTexels, UNKNOWN};

struct Sums {
    /// Red, green and blue, in codes up to 255 or light.
    color: [Lanes; 3],
    weight: Lanes,
    difference: Lanes,
    /// Weights of texels that have the surface, and of those that have no nearer one.
    covered: Lanes,
    all: Lanes,
    refinements: Refinements,
    tolerance: Lanes,
}

/// Colours of the surface points in the `asked` lanes. None where no view has a surface in its direction.
pub(crate) fn seen_from_eye(
    views: &PacketViews<'_>,
    guesses: &mut [usize],
    (asked, points): (u32, &Points),
    settings: &RenderSettings,
) -> [Option<Interpolated>; 4] {
    let zero = Lanes::ZERO;
    let difference = Lanes::INFINITY;
    let (refinements, tolerance) = (settings.refinements, Lanes::splat(settings.tolerance()));
    let mut sums =
        Sums { color: [zero; 3], weight: zero, difference, covered: zero, all: zero, refinements, tolerance };
    let from_eye_m = length(points);
    for (view, guess) in views.views.iter().zip(guesses) {
        let places = view.places_of(points, guess);
        if asked & places.exist != 0 {
            let weight = match refinements.angles {
                true => angle_weight(view, points, from_eye_m),
                false => Lanes::splat(view.camera_weight),
            };
            add(&mut sums, view, &places, (asked & places.exist, weight));
        }
    }
    let unit = if views.are_codes { 255.0 } else { 1.0 };
    let [red, green, blue] = sums.color.map(|color| (color / (unit * sums.weight)).to_array());
    let coverage = either(sums.all.cmpgt(zero), sums.covered / sums.all, Lanes::ONE).to_array();
    let (weight, difference) = (sums.weight.to_array(), sums.difference.to_array());
    std::array::from_fn(|lane| {
        let color = Vec3::new(red[lane], green[lane], blue[lane]);
        let seen = Interpolated { color, difference: difference[lane], coverage: coverage[lane] };
        (asked >> lane & 1 != 0 && weight[lane] > 0.0).then_some(seen)
    })
}

fn length(points: &Points) -> Lanes {
    let square = points.x * points.x + points.y * points.y + points.z * points.z;
    Lanes::from_array(square.to_array().map(f32::sqrt))
}

/// [`crate::march::interpolate::angle_weight`].
#[inline(always)]
fn angle_weight(view: &PacketView<'_>, points: &Points, from_eye_m: Lanes) -> Lanes {
    let [x, y, z] = view.from_eye;
    let from_view = Points { x: points.x - x, y: points.y - y, z: points.z - z };
    let from_view_m = length(&from_view);
    let cross = Points {
        x: points.y * from_view.z - points.z * from_view.y,
        y: points.z * from_view.x - points.x * from_view.z,
        z: points.x * from_view.y - points.y * from_view.x,
    };
    let dot = points.x * from_view.x + points.y * from_view.y + points.z * from_view.z;
    let least = Lanes::splat(f32::MIN_POSITIVE);
    let sine = length(&cross) / (from_eye_m * from_view_m).max(least);
    let angle = either(dot.cmpgt(Lanes::ZERO), sine, Lanes::ONE);
    let blur = (from_view_m / from_eye_m.max(least) - 1.0).max(Lanes::ZERO);
    (angle + blur + ANGLE_EPSILON).recip()
}

struct Texels {
    depth: Lanes,
    color: [Lanes; 3],
}

#[inline(always)]
fn add(sums: &mut Sums, view: &PacketView<'_>, places: &Places, (lanes, of_view): (u32, Lanes)) {
    let (mut columns, mut rows, mut parts) = ([Lanes::ZERO; 2], [Lanes::ZERO; 2], [Lanes::ZERO; 2]);
    for (axis, ends) in [&mut columns, &mut rows].into_iter().enumerate() {
        let at = places.at[axis] - 0.5;
        let low = floor(at);
        parts[axis] = at - low;
        let last = places.size[axis] - 1.0;
        *ends = [low.max(Lanes::ZERO).min(last), (low + 1.0).max(Lanes::ZERO).min(last)];
    }
    let [across, down] = parts;
    let above = 1.0 - down;
    let bilinear = [(1.0 - across) * above, across * above, (1.0 - across) * down, across * down];
    let weights = bilinear.map(|weight| weight * of_view);
    let at = |tap: usize| [columns[tap % 2], rows[tap / 2]];
    match view.face_of_codes(places) {
        Some((depth, codes)) => {
            for (tap, weight) in weights.into_iter().enumerate() {
                sums.add(weight, places.planar_m, texels_of_face(depth, codes, number_of(at(tap), places.size[0])));
            }
        }
        None => {
            for (tap, weight) in weights.into_iter().enumerate() {
                sums.add(weight, places.planar_m, texels_anywhere(view, places, lanes, at(tap)));
            }
        }
    }
}

impl Sums {
    /// Adds texels; `weight` lacks the factor of depth.
    #[inline(always)]
    fn add(&mut self, weight: Lanes, planar_m: Lanes, texels: Texels) {
        let is_known = texels.depth.cmplt(Lanes::splat(UNKNOWN));
        let is_surface = texels.depth.cmpgt(Lanes::splat(BACKGROUND)) & is_known;
        let ratio = either(is_surface, texels.depth * planar_m, Lanes::ONE);
        let nearer = ln(ratio);
        let difference = nearer.abs();
        let tolerance = self.tolerance;
        let sees = is_known & (!is_surface | nearer.cmple(tolerance));
        self.all += either(sees, weight, Lanes::ZERO);
        self.covered += either(is_surface & difference.cmple(tolerance), weight, Lanes::ZERO);
        let fit = (difference + DEPTH_EPSILON).recip();
        let fit = match self.refinements.angles {
            true => (fit - 1.0 / (DEPTH_CUT + DEPTH_EPSILON)).max(CUT_WEIGHT * fit),
            false => fit,
        };
        let weight = either(is_surface, weight * fit, Lanes::ZERO);
        self.weight += weight;
        self.difference = self.difference.min(either(is_surface, difference, Lanes::INFINITY));
        for (sum, color) in self.color.iter_mut().zip(texels.color) {
            *sum += weight * color;
        }
    }
}

/// Texels of one face with coded colours.
#[inline(always)]
fn texels_of_face(depth: &[f32], codes: &[[u8; 4]], at: [u32; 4]) -> Texels {
    let depth_of = |lane: usize| depth.get(at[lane] as usize).copied().unwrap_or(UNKNOWN);
    let code_of = |lane: usize| codes.get(at[lane] as usize).map_or(0, |&code| u32::from_le_bytes(code));
    Texels {
        depth: Lanes::new(depth_of(0), depth_of(1), depth_of(2), depth_of(3)),
        color: bytes([code_of(0), code_of(1), code_of(2), code_of(3)]),
    }
}

/// Texels of these lanes, each in its own face; colours of other lanes and of no surface are 0.
#[inline(never)]
fn texels_anywhere(view: &PacketView<'_>, places: &Places, lanes: u32, [column, row]: [Lanes; 2]) -> Texels {
    let (column, row) = (to_whole(column), to_whole(row));
    let (mut texels, mut depths, mut counted) = ([0; 4], [UNKNOWN; 4], 0);
    for lane in lanes_of(lanes) {
        let face = places.face.of(lane);
        let texel = row[lane] as usize * view.width[face] as usize + column[lane] as usize;
        let depth = view.depth[face].get(texel).copied().unwrap_or(UNKNOWN);
        (texels[lane], depths[lane]) = (texel, depth);
        counted |= u32::from(depth > BACKGROUND && depth < UNKNOWN) << lane;
    }
    Texels { depth: Lanes::from_array(depths), color: colors(view, places, counted, &texels) }
}

/// Red, green and blue: codes up to 255, or light; 0 in other lanes.
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
    if are_codes { bytes(codes) } else { light.map(Lanes::from_array) }
}
