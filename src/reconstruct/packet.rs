//! Views as four rays ask them at once: the same questions as [`ActiveView::evidence`] and
//! [`super::pyramid::is_segment_open`], with the same operations in the same order, so that the answers are the same bits.

use glam::Vec4;

use crate::image::cube::Face;
use crate::reconstruct::active_views::{ActiveView, ActiveViews};
use crate::reconstruct::lanes::{ALL, Lanes, Points, cut, either, lanes_of, to_whole};
use crate::reconstruct::light_field::{FaceTexels, UNKNOWN};
use crate::reconstruct::pyramid::{LEAST_M, ROUNDING, SURELY_BELOW_ONE};

/// The numbers that map a plane at depth 1 to an image.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Map {
    size: [f32; 2],
    scale: [f32; 2],
    centre: [f32; 2],
}

/// An active view, laid out flat.
#[derive(Debug)]
pub(crate) struct PacketView<'a> {
    /// Columns of the turn into its axes.
    turn: [[f32; 3]; 3],
    from_eye: [f32; 3],
    reach_m: f32,
    near_squared: f32,
    greatest_inverse_depth: f32,
    is_view: bool,
    pub(crate) faces: [Option<&'a FaceTexels>; 7],
    depth: [&'a [f32]; 7],
    width: [u32; 7],
    maps: [Map; 7],
    /// Where all its images are mapped alike.
    alike: Option<Map>,
}

/// Where four points lie in the images of a view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places {
    /// Lanes that lie in an image, as bits. Of others, nothing else is known.
    pub(crate) exist: u32,
    pub(crate) face: [usize; 4],
    plane: [Lanes; 2],
    planar_m: Lanes,
    pub(crate) inverse_depth: Lanes,
    /// Column and row, in texels.
    pub(crate) at: [Lanes; 2],
    /// Columns and rows of the images.
    pub(crate) size: [Lanes; 2],
    scale: [Lanes; 2],
}

/// What a view says of four points, as bits; neither where it knows nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answers {
    pub(crate) open: u32,
    pub(crate) behind: u32,
}

impl<'a> PacketView<'a> {
    fn new(active: &ActiveView<'a>) -> PacketView<'a> {
        let faces: [Option<&FaceTexels>; 7] = std::array::from_fn(|at| active.view.faces[at].as_ref());
        let map = |face: Option<&FaceTexels>| match face {
            Some(face) => Map { size: face.size.map(|size| size as f32), scale: face.scale, centre: face.centre },
            None => Map { size: [1.0; 2], scale: [0.0; 2], centre: [0.0; 2] },
        };
        let mut all = faces.iter().flatten().map(|&face| map(Some(face)));
        let first = all.next();
        let alike = first.filter(|first| all.all(|map| map == *first));
        PacketView {
            turn: active.probe_from_world.to_cols_array_2d(),
            from_eye: active.from_eye.to_array(),
            reach_m: active.from_eye.abs().max_element(),
            near_squared: active.view.near_m * active.view.near_m,
            greatest_inverse_depth: active.greatest_inverse_depth,
            is_view: faces[Face::View as usize].is_some(),
            faces,
            depth: faces.map(|face| face.map_or(&[][..], |face| &face.inverse_depth)),
            width: faces.map(|face| face.map_or(1, |face| face.size[0])),
            maps: faces.map(map),
            alike,
        }
    }

    /// The ways from the viewpoint to points.
    pub(crate) fn local(&self, points: &Points) -> Points {
        let x = points.x - self.from_eye[0];
        let y = points.y - self.from_eye[1];
        let z = points.z - self.from_eye[2];
        let [a, b, c] = self.turn;
        Points {
            x: x * a[0] + y * b[0] + z * c[0],
            y: x * a[1] + y * b[1] + z * c[1],
            z: x * a[2] + y * b[2] + z * c[2],
        }
    }

    /// Where ways from the viewpoint lead to.
    pub(crate) fn places(&self, local: &Points) -> Places {
        if self.is_view { self.places_in_view(local) } else { self.places_in_cube(local) }
    }

    fn places_in_view(&self, local: &Points) -> Places {
        let face = Face::View as usize;
        let planar_m = -local.z;
        let inverse_depth = planar_m.recip();
        let plane = [local.x * inverse_depth, -local.y * inverse_depth];
        let [size, scale, centre] = self.mapping(&[face; 4]);
        let at = [plane[0] * scale[0] + centre[0], plane[1] * scale[1] + centre[1]];
        let mut exist = inverse_depth.cmpgt(Lanes::ZERO) & inverse_depth.cmplt(Lanes::INFINITY);
        for axis in 0..2 {
            exist &= at[axis].cmpge(Lanes::ZERO) & at[axis].cmplt(size[axis]);
        }
        let exist = exist.bitmask();
        Places { exist, face: [face; 4], plane, planar_m, inverse_depth, at, size, scale }
    }

    fn places_in_cube(&self, local: &Points) -> Places {
        let Points { x, y, z } = *local;
        let (wide, high, deep) = (x.abs(), y.abs(), z.abs());
        let is_x = wide.cmpge(high) & wide.cmpge(deep);
        let is_y = !is_x & high.cmpge(deep);
        let along = either(is_x, x, either(is_y, y, z));
        let planar_m = along.abs();
        let behind = along.cmplt(Lanes::ZERO);
        let sign = either(behind, Lanes::NEG_ONE, Lanes::ONE);
        let inverse_depth = planar_m.recip();
        let plane = [
            either(is_x, -(z * sign), either(is_y, x, x * sign)) * inverse_depth,
            either(is_y, z * sign, -y) * inverse_depth,
        ];
        let (x_bits, y_bits, behind_bits) = (is_x.bitmask(), is_y.bitmask(), behind.bitmask());
        let face = [0, 1, 2, 3].map(|lane| {
            let bit = |bits: u32| (bits >> lane & 1) as usize;
            4 - 4 * bit(x_bits) - 2 * bit(y_bits) + bit(behind_bits)
        });
        let [size, scale, centre] = self.mapping(&face);
        let at = [plane[0] * scale[0] + centre[0], plane[1] * scale[1] + centre[1]];
        let exist = inverse_depth.cmplt(Lanes::INFINITY).bitmask();
        Places { exist, face, plane, planar_m, inverse_depth, at, size, scale }
    }

    fn mapping(&self, face: &[usize; 4]) -> [[Lanes; 2]; 3] {
        if let Some(map) = self.alike {
            return [map.size, map.scale, map.centre].map(|two| two.map(Lanes::splat));
        }
        let each = |part: fn(&Map) -> [f32; 2]| {
            [0, 1].map(|axis| Lanes::from_array(face.map(|face| part(&self.maps[face])[axis])))
        };
        [each(|map| map.size), each(|map| map.scale), each(|map| map.centre)]
    }

    /// Inverse depths of the texels that points fall into.
    fn nearest(&self, places: &Places) -> Lanes {
        let [column, row] = [0, 1].map(|axis| {
            let within = places.at[axis].max(Lanes::ZERO).min(places.size[axis] - 1.0);
            to_whole(cut(within))
        });
        Lanes::from_array(std::array::from_fn(|lane| {
            let face = places.face[lane];
            let at = row[lane] as usize * self.width[face] as usize + column[lane] as usize;
            self.depth[face].get(at).copied().unwrap_or(UNKNOWN)
        }))
    }

    /// What it says of points, of which it has the ways to them and their places.
    pub(crate) fn answers(&self, local: &Points, places: &Places) -> Answers {
        let surface = self.nearest(places);
        let square = local.x * local.x + local.y * local.y + local.z * local.z;
        let near = square.cmplt(Vec4::splat(self.near_squared));
        let known = surface.cmpne(Vec4::splat(UNKNOWN)).bitmask() & places.exist;
        let before = (near | surface.cmplt(places.inverse_depth)).bitmask();
        let mut open = known & before;
        if places.exist != ALL {
            let centre = (near & square.cmple(Vec4::splat(f32::MIN_POSITIVE))).bitmask();
            open |= centre & !places.exist;
        }
        Answers { open, behind: known & !before }
    }

    /// Lanes, of those asked, of which it proves that all points from one end to the other are open.
    pub(crate) fn prove(&self, asked: u32, ends: [&Points; 2], last: &Places, reach_m: Lanes) -> u32 {
        let error_m = ROUNDING * (reach_m + self.reach_m) + LEAST_M;
        let [a, b] = ends.map(|end| self.local(end));
        let size = |end: &Points| end.x.abs().max(end.y.abs()).max(end.z.abs());
        let farthest_m = size(&a).max(size(&b)) + 2.0 * error_m;
        let below_one = Vec4::splat(SURELY_BELOW_ONE);
        let whole = asked & (self.greatest_inverse_depth * farthest_m).cmplt(below_one).bitmask();
        if whole == asked {
            return whole;
        }
        let first = self.places(&a);
        let nearest_m = first.planar_m.min(last.planar_m);
        let farthest_m = first.planar_m.max(last.planar_m) + 2.0 * error_m;
        let widest = first.plane[0].abs().max(first.plane[1].abs());
        let widest = widest.max(last.plane[0].abs().max(last.plane[1].abs()));
        let slack = (1.0 + widest) * (4.0 * error_m / nearest_m + ROUNDING);
        let mut may = nearest_m.cmpge(4.0 * error_m);
        if !self.is_view {
            may &= (widest + slack).cmple(Lanes::ONE);
        }
        let mut boxes = [[[0; 4]; 2]; 2];
        for axis in 0..2 {
            let (one, two) = (first.at[axis], last.at[axis]);
            let margin = slack * last.scale[axis].abs() + last.size[axis] * ROUNDING;
            let (low, high) = (one.min(two) - margin, one.max(two) + margin);
            if self.is_view {
                may &= low.cmpge(Lanes::ZERO) & high.cmplt(last.size[axis]);
            }
            let within = |at: Lanes| to_whole(cut(at.max(Lanes::ZERO).min(last.size[axis] - 1.0)));
            boxes[0][axis] = within(low);
            boxes[1][axis] = within(high);
        }
        let may = may.bitmask() & asked & !whole;
        let farthest_m = farthest_m.to_array();
        let mut proved = whole;
        for lane in lanes_of(may) {
            let Some(texels) = self.faces[last.face[lane]] else { continue };
            let [from, to] = boxes.map(|corner| corner.map(|lanes| lanes[lane]));
            if first.face[lane] == last.face[lane]
                && texels.greatest_between(from, to) * farthest_m[lane] < SURELY_BELOW_ONE
            {
                proved |= 1 << lane;
            }
        }
        proved
    }
}

/// Active views, laid out flat, in the order in which they are asked, which changes no answer.
#[derive(Debug)]
pub(crate) struct PacketViews<'a> {
    pub(crate) views: Vec<PacketView<'a>>,
}

impl<'a> PacketViews<'a> {
    pub(crate) fn new(views: &ActiveViews<'a>) -> PacketViews<'a> {
        PacketViews { views: views.views.iter().map(PacketView::new).collect() }
    }
}
