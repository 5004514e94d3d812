//! Interpolation of the colours of four points at once. Equals [`crate::march::interpolate::seen_from_eye`] up to the rounding of
//! logarithms and the order of sums: less than a hundredth of an 8-bit code.

use glam::Vec3;

use crate::march::active_views::CAMERA_EPSILON;
use crate::march::interpolate::{ANGLE_EPSILON, CUT_WEIGHT, DEPTH_CUT, EDGE_PENALTY, NEARER};
use crate::march::packet::lanes::{
    Lanes, Points, bytes, either, floor, fourth_bytes, lanes_of, ln, number_of, to_whole,
};
use crate::march::packet::views::{CodedFace, PacketView, PacketViews, Places};
use crate::march::{DEPTH_EPSILON, Interpolated, Refinements, RenderSettings};
use crate::views::{BACKGROUND, ColorTexels, UNKNOWN};

struct Sums {
    /// Red, green and blue, in codes up to 255 or linear RGB.
    color: [Lanes; 3],
    weight: Lanes,
    /// Sum of the weights times alpha, or of the plain weights if no view has alpha.
    shown: Lanes,
    has_alpha: bool,
    difference: Lanes,
    /// Sums of the weights of texels that have the surface, and of texels that have no nearer one.
    covered: Lanes,
    all: Lanes,
    /// `covered` with weights times alpha, if a view has alpha.
    opaque: Lanes,
    refinements: Refinements,
    tolerance: Lanes,
}

/// Interpolates the colours of the surface points in the `asked` lanes. None if no view has a surface in the direction of a
/// point.
pub(crate) fn seen_from_eye(
    views: &PacketViews<'_>,
    guesses: &mut [usize],
    (asked, points): (u32, &Points),
    settings: &RenderSettings,
) -> [Option<Interpolated>; 4] {
    let zero = Lanes::ZERO;
    let difference = Lanes::INFINITY;
    let (refinements, tolerance) = (settings.refinements, Lanes::splat(settings.tolerance()));
    let mut sums = Sums {
        color: [zero; 3],
        weight: zero,
        shown: zero,
        has_alpha: views.has_alpha,
        difference,
        covered: zero,
        all: zero,
        opaque: zero,
        refinements,
        tolerance,
    };
    let from_eye_m = length(points);
    for (view, guess) in views.views.iter().zip(guesses) {
        let places = view.places_of(points, guess);
        if asked & places.exist != 0 {
            let (weight, epsilon) = match refinements.angles {
                true => (angle_weight(view, points, from_eye_m), ANGLE_EPSILON),
                false => (Lanes::splat(view.camera_weight), CAMERA_EPSILON),
            };
            let edge_part = view.has_edges.then(|| (1.0 + EDGE_PENALTY - EDGE_PENALTY * epsilon * weight).recip());
            add(&mut sums, view, &places, (asked & places.exist, weight, edge_part));
        }
    }
    let unit = if views.are_codes { 255.0 } else { 1.0 };
    let shown = if sums.has_alpha { sums.shown } else { sums.weight };
    let is_shown = shown.cmpgt(zero);
    let [red, green, blue] = sums.color.map(|color| either(is_shown, color / (unit * shown), zero).to_array());
    let alpha = match sums.has_alpha {
        true => either(sums.covered.cmpgt(zero), sums.opaque / sums.covered, shown / sums.weight),
        false => Lanes::ONE,
    };
    let alpha = alpha.to_array();
    let coverage = either(sums.all.cmpgt(zero), sums.covered / sums.all, Lanes::ONE).to_array();
    let (weight, difference) = (sums.weight.to_array(), sums.difference.to_array());
    std::array::from_fn(|lane| {
        let color = Vec3::new(red[lane], green[lane], blue[lane]);
        let (coverage, alpha) = (coverage[lane], alpha[lane]);
        let seen = Interpolated { color, difference: difference[lane], coverage, alpha };
        (asked >> lane & 1 != 0 && weight[lane] > 0.0).then_some(seen)
    })
}

fn length(points: &Points) -> Lanes {
    let square = points.x * points.x + points.y * points.y + points.z * points.z;
    Lanes::from_array(square.to_array().map(f32::sqrt))
}

/// Packet form of [`crate::march::interpolate::angle_weight`].
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
    alpha: Lanes,
}

#[inline(always)]
fn add(
    sums: &mut Sums,
    view: &PacketView<'_>,
    places: &Places,
    (lanes, of_view, edge_part): (u32, Lanes, Option<Lanes>),
) {
    // Columns and rows of the four texels around each position, and of the texels before and after them.
    let (mut columns, mut rows, mut parts) = ([Lanes::ZERO; 4], [Lanes::ZERO; 4], [Lanes::ZERO; 2]);
    for (axis, along) in [&mut columns, &mut rows].into_iter().enumerate() {
        let at = places.at[axis] - 0.5;
        let low = floor(at);
        parts[axis] = at - low;
        let last = places.size[axis] - 1.0;
        *along = [low - 1.0, low, low + 1.0, low + 2.0].map(|at| at.max(Lanes::ZERO).min(last));
    }
    let [across, down] = parts;
    let above = 1.0 - down;
    let bilinear = [(1.0 - across) * above, across * above, (1.0 - across) * down, across * down];
    let weights = bilinear.map(|weight| weight * of_view);
    let at = |tap: usize| [columns[1 + tap % 2], rows[1 + tap / 2]];
    let texels: [Texels; 4] = match view.face_of_codes(places) {
        Some(face) => std::array::from_fn(|tap| texels_of_face(&face, number_of(at(tap), places.size[0]))),
        None => std::array::from_fn(|tap| texels_anywhere(view, places, lanes, at(tap))),
    };
    let edges = edge_part.map(|edge_part| {
        let depth = |row: usize, column: usize| match (row, column) {
            (1 | 2, 1 | 2) => surface_of(texels[column - 1 + 2 * (row - 1)].depth),
            (1 | 2, _) | (_, 1 | 2) => surface_of(depth_of(view, places, lanes, [columns[column], rows[row]])),
            _ => Lanes::ZERO,
        };
        let depth: [[Lanes; 4]; 4] = std::array::from_fn(|row| std::array::from_fn(|column| depth(row, column)));
        // At the border of an image two of the four texels are the same.
        let [is_column, is_row] = [columns[1].cmpeq(columns[2]), rows[1].cmpeq(rows[2])];
        std::array::from_fn(|tap| {
            let (row, column) = (1 + tap / 2, 1 + tap % 2);
            let [left, right] = [
                either(is_column, depth[row][0], depth[row][column - 1]),
                either(is_column, depth[row][3], depth[row][column + 1]),
            ];
            let [above, below] = [
                either(is_row, depth[0][column], depth[row - 1][column]),
                either(is_row, depth[3][column], depth[row + 1][column]),
            ];
            let nearest = left.max(right).max(above.max(below));
            either(nearest.cmpgt(texels[tap].depth * NEARER), edge_part, Lanes::ONE)
        })
    });
    for (tap, weight) in weights.into_iter().enumerate() {
        let edge_part = edges.map_or(Lanes::ONE, |edges: [Lanes; 4]| edges[tap]);
        sums.add((weight, edge_part), places.planar_m, &texels[tap]);
    }
}

/// Returns the inverse depths of known texels, and 0 for unknown ones.
#[inline(always)]
fn surface_of(depth: Lanes) -> Lanes {
    either(depth.cmplt(Lanes::splat(UNKNOWN)), depth, Lanes::ZERO)
}

impl Sums {
    /// Adds texels. `weight` lacks the depth factor and, for the colour, the edge factor.
    #[inline(always)]
    fn add(&mut self, (weight, edge_part): (Lanes, Lanes), planar_m: Lanes, texels: &Texels) {
        let is_known = texels.depth.cmplt(Lanes::splat(UNKNOWN));
        let is_surface = texels.depth.cmpgt(Lanes::splat(BACKGROUND)) & is_known;
        let ratio = either(is_surface, texels.depth * planar_m, Lanes::ONE);
        let nearer = ln(ratio);
        let difference = nearer.abs();
        let tolerance = self.tolerance;
        let sees = is_known & (!is_surface | nearer.cmple(tolerance));
        self.all += either(sees, weight, Lanes::ZERO);
        let covered = either(is_surface & difference.cmple(tolerance), weight, Lanes::ZERO);
        self.covered += covered;
        if self.has_alpha {
            self.opaque += covered * texels.alpha;
        }
        let fit = (difference + DEPTH_EPSILON).recip();
        let fit = match self.refinements.angles {
            true => (fit - 1.0 / (DEPTH_CUT + DEPTH_EPSILON)).max(CUT_WEIGHT * fit),
            false => fit,
        };
        let weight = either(is_surface, weight * fit * edge_part, Lanes::ZERO);
        self.weight += weight;
        self.difference = self.difference.min(either(is_surface, difference, Lanes::INFINITY));
        let shown = if self.has_alpha { weight * texels.alpha } else { weight };
        self.shown += shown;
        for (sum, color) in self.color.iter_mut().zip(texels.color) {
            *sum += shown * color;
        }
    }
}

/// Returns the inverse depths of the texels at these columns and rows.
#[inline(always)]
fn depth_of(view: &PacketView<'_>, places: &Places, lanes: u32, [column, row]: [Lanes; 2]) -> Lanes {
    let texel = |face: usize, at: usize| view.depth[face].get(at).copied().unwrap_or(UNKNOWN);
    if let Some(face) = places.face.only().filter(|_| view.are_small) {
        let at = number_of([column, row], places.size[0]);
        return Lanes::from_array(at.map(|at| texel(face, at as usize)));
    }
    let (column, row, mut depths) = (to_whole(column), to_whole(row), [UNKNOWN; 4]);
    for lane in lanes_of(lanes) {
        let face = places.face.of(lane);
        depths[lane] = texel(face, row[lane] as usize * view.width[face] as usize + column[lane] as usize);
    }
    Lanes::from_array(depths)
}

/// Returns texels of one face with coded colours.
#[inline(always)]
fn texels_of_face(face: &CodedFace<'_>, at: [u32; 4]) -> Texels {
    let depth_of = |lane: usize| face.depth.get(at[lane] as usize).copied().unwrap_or(UNKNOWN);
    let code_of = |lane: usize| face.codes.get(at[lane] as usize).map_or(0, |&code| u32::from_le_bytes(code));
    let codes = [code_of(0), code_of(1), code_of(2), code_of(3)];
    Texels {
        depth: Lanes::new(depth_of(0), depth_of(1), depth_of(2), depth_of(3)),
        color: bytes(codes),
        alpha: if face.has_alpha { fourth_bytes(codes) / 255.0 } else { Lanes::ONE },
    }
}

/// Returns the texels of these lanes, each in its own face. Colours of other lanes and of texels without a surface are 0.
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
    let (color, alpha) = colors(view, places, counted, &texels);
    Texels { depth: Lanes::from_array(depths), color, alpha }
}

/// Returns red, green and blue, as codes up to 255 or linear RGB, and alpha. Colours of other lanes are 0.
fn colors(view: &PacketView<'_>, places: &Places, lanes: u32, texels: &[usize; 4]) -> ([Lanes; 3], Lanes) {
    let mut codes = [0u32; 4];
    let mut alpha = [1.0; 4];
    let mut light = [[0.0; 4]; 3];
    let mut are_codes = true;
    for lane in lanes_of(lanes) {
        let Some(face) = view.faces[places.face.of(lane)] else { continue };
        alpha[lane] = face.alpha(texels[lane]);
        if let ColorTexels::Codes(of_face) = &face.color {
            codes[lane] = u32::from_le_bytes(of_face[texels[lane]]);
        } else {
            are_codes = false;
            let color = face.color.get(texels[lane]).to_array();
            (0..3).for_each(|channel| light[channel][lane] = color[channel]);
        }
    }
    (if are_codes { bytes(codes) } else { light.map(Lanes::from_array) }, Lanes::from_array(alpha))
}
