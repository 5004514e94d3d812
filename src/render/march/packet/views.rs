//! Occupancy tests of four points at once. They perform the operations of [`ActiveView::occupancy`] and
//! [`crate::march::segments::is_segment_empty`] in the same order, so that results are the same bits.
//!
//! Points of a packet are close to each other and to the points tested before, so they are first projected into the same face as
//! those. If the projected positions confirm this guess, the face is not computed.

use glam::Vec4;

use crate::march::packet::lanes::{ALL, Lanes, Points, either, lanes_of, number_of, to_whole};
use crate::march::segments::{ROUNDING, SURELY_BELOW_ONE};
use crate::march::{ActiveView, ActiveViews, Footprint, MIN_M, ViewPyramids};
use crate::views::{ColorCoding, ColorTexels, FaceTexels, UNKNOWN};
use codec::image::{Face, TexelMap};

/// Maximum side of an image whose face is guessed, in texels: positions in it have an error far below one texel.
const LONGEST_GUESSED: f32 = 65_536.0;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Map {
    size: [f32; 2],
    texels: TexelMap,
}

pub(crate) struct PacketView<'a> {
    /// Columns of the rotation from the world into the view's axes.
    turn: [[Lanes; 3]; 3],
    /// Rows of the rotations from the world into right, down and forward of each cube face.
    turns_of_faces: [[[Lanes; 3]; 3]; 6],
    /// Projection for [`PacketView::guessed`], if all images of a cube have the same one and it covers the face.
    whole_faces: Option<Map>,
    /// [`PacketView::near_m`], but at least [`MIN_M`].
    min_guessed_m: Lanes,
    pub(crate) from_eye: [Lanes; 3],
    reach_m: f32,
    near_m: Lanes,
    near_squared: f32,
    greatest_inverse_depth: f32,
    pub(crate) camera_weight: f32,
    footprint: Footprint,
    pub(crate) has_edges: bool,
    is_view: bool,
    /// True if all texel indices are below 2²³.
    pub(crate) are_small: bool,
    pyramids: &'a ViewPyramids,
    pub(crate) faces: [Option<&'a FaceTexels>; 7],
    /// Inverse depths of each face. There are eight entries, so that any three bits are a valid index.
    pub(crate) depth: [&'a [f32]; 8],
    /// [`DepthPyramid::around`](crate::march::DepthPyramid) of each face, or empty.
    squares: [&'a [f32]; 8],
    pub(crate) width: [u32; 8],
    /// Empty for linear colours.
    pub(crate) codes: [&'a [[u8; 4]]; 8],
    has_alpha: [bool; 8],
    maps: [Map; 7],
    /// Projection of all images, if they have the same one.
    alike: Option<Map>,
}

/// Texels of an image with coded colours.
pub(crate) struct CodedFace<'a> {
    pub(crate) depth: &'a [f32],
    pub(crate) codes: &'a [[u8; 4]],
    pub(crate) has_alpha: bool,
}

/// Face indices, one byte per lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Faces(u32);

impl Faces {
    /// Expands four bits to four bytes, each 0 or 1.
    const SPREAD: [u32; 16] = {
        let mut spread = [0; 16];
        let mut bits = 0;
        while bits < 16 {
            spread[bits] = (bits & 1 | (bits & 2) << 7 | (bits & 4) << 14 | (bits & 8) << 21) as u32;
            bits += 1;
        }
        spread
    };

    const VIEW: Faces = Faces(0x0606_0606);

    /// Returns the faces of a cube from the lanes whose main axis is x, or y, and the lanes where it is negative.
    #[inline(always)]
    fn of_cube(is_x: u32, is_y: u32, negative: u32) -> Faces {
        let spread = |bits: u32| Faces::SPREAD[(bits & ALL) as usize];
        Faces(0x0404_0404 - 4 * spread(is_x) - 2 * spread(is_y) + spread(negative))
    }

    #[inline(always)]
    fn all(face: usize) -> Faces {
        Faces((face as u32 & 7) * 0x0101_0101)
    }

    /// Returns the face of all lanes, if they have the same one.
    #[inline(always)]
    pub(crate) fn only(self) -> Option<usize> {
        (self.0 == (self.0 & 7) * 0x0101_0101).then_some((self.0 & 7) as usize)
    }

    #[inline(always)]
    pub(crate) fn of(self, lane: usize) -> usize {
        (self.0 >> (8 * lane) & 7) as usize
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Places {
    /// Lanes that lie in an image, as bits; the values of other lanes are undefined.
    pub(crate) exist: u32,
    pub(crate) face: Faces,
    plane: [Lanes; 2],
    pub(crate) planar_m: Lanes,
    inverse_depth: Lanes,
    /// Column and row, in texels.
    pub(crate) at: [Lanes; 2],
    /// Width and height of the images, in texels.
    pub(crate) size: [Lanes; 2],
    scale: [Lanes; 2],
}

/// Returns the rows of the rotation from the world into right, down and forward of a cube face, from the columns of the rotation
/// into the view's axes.
fn turn_of_face(turn: [[Lanes; 3]; 3], face: Face) -> [[Lanes; 3]; 3] {
    let [forward, right, down] = face.axes();
    [right, down, forward].map(|axis| {
        // One coordinate of an axis is 1 or −1, the others are 0.
        let at = [axis.x, axis.y, axis.z].iter().position(|&part| part != 0.0).unwrap_or(0);
        let sign = Lanes::splat(axis[at] as f32);
        turn.map(|column| sign * column[at])
    })
}

/// Occupancy of four points in a view, as bits; neither bit is set if the occupancy is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Occupancies {
    pub(crate) empty: u32,
    pub(crate) occupied: u32,
}

impl<'a> PacketView<'a> {
    fn new(active: &'a ActiveView<'a>) -> PacketView<'a> {
        let faces: [Option<&FaceTexels>; 7] = std::array::from_fn(|at| active.view.faces[at].as_ref());
        let map = |face: Option<&FaceTexels>| match face {
            Some(face) => Map { size: face.size.map(|size| size as f32), texels: face.map },
            None => Map { size: [1.0; 2], texels: TexelMap { scale: [0.0; 2], centre: [0.0; 2] } },
        };
        let mut all = faces.iter().flatten().map(|&face| map(Some(face)));
        let of = |at: usize| faces.get(at).copied().flatten();
        let first = all.next();
        let alike = first.filter(|first| all.all(|map| map == *first));
        let turn = active.probe_from_world.to_cols_array_2d().map(|column| column.map(Lanes::splat));
        let is_view = faces[Face::View as usize].is_some();
        let are_small = faces.iter().flatten().all(|face| face.inverse_depth.len() <= 1 << 23);
        let is_whole = |map: Map| {
            map.texels == TexelMap::cube_face(map.size.map(|size| size as u32))
                && map.size.iter().all(|&size| size <= LONGEST_GUESSED)
        };
        PacketView {
            turn,
            turns_of_faces: Face::CUBE.map(|face| turn_of_face(turn, face)),
            whole_faces: alike.filter(|&map| !is_view && are_small && is_whole(map)),
            min_guessed_m: Lanes::splat(active.view.near_m.abs().max(MIN_M)),
            from_eye: active.from_eye.to_array().map(Lanes::splat),
            reach_m: active.from_eye.abs().max_element(),
            near_m: Lanes::splat(active.view.near_m),
            near_squared: active.view.near_m * active.view.near_m,
            greatest_inverse_depth: active.greatest_inverse_depth,
            camera_weight: active.camera_weight,
            footprint: active.footprint,
            has_edges: active.has_edges(),
            are_small,
            is_view,
            pyramids: &active.pyramids,
            faces,
            depth: std::array::from_fn(|at| of(at).map_or(&[][..], |face| &face.inverse_depth)),
            squares: std::array::from_fn(|at| active.pyramids.faces.get(at).map_or(&[][..], |face| &face.around)),
            width: std::array::from_fn(|at| of(at).map_or(1, |face| face.size[0])),
            codes: std::array::from_fn(|at| match of(at).map(|face| &face.color) {
                Some(ColorTexels::Codes(codes)) => &codes[..],
                _ => &[],
            }),
            has_alpha: std::array::from_fn(|at| of(at).is_some_and(|face| face.has_alpha)),
            maps: faces.map(map),
            alike,
        }
    }

    #[inline(always)]
    fn local(&self, points: &Points) -> Points {
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

    /// Projects points into this face of a cube. None unless all of them certainly lie in the face, and none is nearer than the
    /// near distance.
    ///
    /// The axes of a face are those of the view up to signs, which do not affect rounding. If no coordinate in the plane at depth
    /// 1 is above [`SURELY_BELOW_ONE`], the point is in no other face and needs no clamping.
    #[inline(always)]
    fn guessed(&self, points: &Points, face: usize) -> Option<Places> {
        let Map { size, texels: TexelMap { scale, centre } } = self.whole_faces?;
        let x = points.x - self.from_eye[0];
        let y = points.y - self.from_eye[1];
        let z = points.z - self.from_eye[2];
        let [right, down, forward] = self.turns_of_faces.get(face)?;
        let planar_m = x * forward[0] + y * forward[1] + z * forward[2];
        let inverse_depth = planar_m.recip();
        let plane = [
            (x * right[0] + y * right[1] + z * right[2]) * inverse_depth,
            (x * down[0] + y * down[1] + z * down[2]) * inverse_depth,
        ];
        let widest = plane[0].abs().max(plane[1].abs());
        let is_there = widest.cmple(Lanes::splat(SURELY_BELOW_ONE)) & planar_m.cmpge(self.min_guessed_m);
        if is_there.bitmask() != ALL {
            return None;
        }
        let two = |two: [f32; 2]| [Lanes::splat(two[0]), Lanes::splat(two[1])];
        let (size, scale, centre) = (two(size), two(scale), two(centre));
        let at = [plane[0] * scale[0] + centre[0], plane[1] * scale[1] + centre[1]];
        Some(Places { exist: ALL, face: Faces::all(face), plane, planar_m, inverse_depth, at, size, scale })
    }

    /// Projects points; `guess` is the face of earlier points, and is updated.
    #[inline(always)]
    pub(crate) fn places_of(&self, points: &Points, guess: &mut usize) -> Places {
        match self.guessed(points, *guess) {
            Some(places) => places,
            None => self.places_anywhere(points, guess),
        }
    }

    #[inline(never)]
    fn places_anywhere(&self, points: &Points, guess: &mut usize) -> Places {
        let places = self.places(&self.local(points));
        *guess = places.face.only().unwrap_or(*guess);
        places
    }

    #[inline(always)]
    pub(crate) fn test(&self, points: &Points, guess: &mut usize) -> Occupancies {
        let Some(places) = self.guessed(points, *guess) else { return self.test_anywhere(points, guess) };
        let depth = self.depth[*guess & 7];
        let surface = match self.footprint {
            Footprint::Texel => {
                let at = number_of(places.at, places.size[0]);
                let texel = |lane: usize| depth.get(at[lane] as usize).copied().unwrap_or(UNKNOWN);
                Lanes::new(texel(0), texel(1), texel(2), texel(3))
            }
            Footprint::Around => {
                let (around, squares) = (Around::of(&places), self.squares[*guess & 7]);
                if around.are_squares() && squares.len() == depth.len() {
                    let square = |lane: usize| squares.get(around.first[lane] as usize).copied().unwrap_or(UNKNOWN);
                    Lanes::new(square(0), square(1), square(2), square(3))
                } else {
                    greatest_of(&around, |_, texel| depth.get(texel).copied())
                }
            }
        };
        let known = surface.cmpne(Vec4::splat(UNKNOWN)).bitmask();
        let before = surface.cmplt(places.inverse_depth).bitmask();
        Occupancies { empty: known & before, occupied: known & !before }
    }

    #[inline(never)]
    fn test_anywhere(&self, points: &Points, guess: &mut usize) -> Occupancies {
        let local = self.local(points);
        let places = self.places(&local);
        *guess = places.face.only().unwrap_or(*guess);
        self.occupancies(&local, &places)
    }

    #[inline(always)]
    fn places(&self, local: &Points) -> Places {
        if self.is_view { self.places_in_view(local) } else { self.places_in_cube(local) }
    }

    #[inline(always)]
    fn places_in_view(&self, local: &Points) -> Places {
        let face = Faces::VIEW;
        let planar_m = -local.z;
        let inverse_depth = planar_m.recip();
        let plane = [local.x * inverse_depth, -local.y * inverse_depth];
        let [size, scale, centre] = self.mapping(Faces::VIEW);
        let at = [plane[0] * scale[0] + centre[0], plane[1] * scale[1] + centre[1]];
        let mut exist = inverse_depth.cmpgt(Lanes::ZERO) & inverse_depth.cmplt(Lanes::INFINITY);
        for axis in 0..2 {
            exist &= at[axis].cmpge(Lanes::ZERO) & at[axis].cmplt(size[axis]);
        }
        let exist = exist.bitmask();
        Places { exist, face, plane, planar_m, inverse_depth, at, size, scale }
    }

    #[inline(always)]
    fn places_in_cube(&self, local: &Points) -> Places {
        let Points { x, y, z } = *local;
        let (wide, high, deep) = (x.abs(), y.abs(), z.abs());
        let is_x = wide.cmpge(high) & wide.cmpge(deep);
        let is_y = !is_x & high.cmpge(deep);
        let along = either(is_x, x, either(is_y, y, z));
        let planar_m = along.abs();
        let negative = along.cmplt(Lanes::ZERO);
        let sign = either(negative, Lanes::NEG_ONE, Lanes::ONE);
        let inverse_depth = planar_m.recip();
        let plane = [
            either(is_x, -(z * sign), either(is_y, x, x * sign)) * inverse_depth,
            either(is_y, z * sign, -y) * inverse_depth,
        ];
        let face = Faces::of_cube(is_x.bitmask(), is_y.bitmask(), negative.bitmask());
        let [size, scale, centre] = self.mapping(face);
        let at = [plane[0] * scale[0] + centre[0], plane[1] * scale[1] + centre[1]];
        let exist = inverse_depth.cmplt(Lanes::INFINITY).bitmask();
        Places { exist, face, plane, planar_m, inverse_depth, at, size, scale }
    }

    #[inline(always)]
    fn mapping(&self, face: Faces) -> [[Lanes; 2]; 3] {
        if let Some(Map { size, texels: TexelMap { scale, centre } }) = self.alike {
            let splat = |two: [f32; 2]| [Lanes::splat(two[0]), Lanes::splat(two[1])];
            return [splat(size), splat(scale), splat(centre)];
        }
        self.mapping_of_each(face)
    }

    #[cold]
    fn mapping_of_each(&self, face: Faces) -> [[Lanes; 2]; 3] {
        let each = |part: fn(&Map) -> [f32; 2]| {
            [0, 1].map(|axis| Lanes::from_array(std::array::from_fn(|lane| part(&self.maps[face.of(lane)])[axis])))
        };
        [each(|map| map.size), each(|map| map.texels.scale), each(|map| map.texels.centre)]
    }

    /// Returns the maximum inverse depth of each footprint's texels.
    #[inline(always)]
    fn footprint_depth(&self, places: &Places) -> Lanes {
        match self.footprint {
            Footprint::Texel => self.nearest(places),
            Footprint::Around => {
                greatest_of(&Around::of(places), |lane, texel| self.depth[places.face.of(lane)].get(texel).copied())
            }
        }
    }

    #[inline(always)]
    fn nearest(&self, places: &Places) -> Lanes {
        let within = |axis: usize| places.at[axis].max(Lanes::ZERO).min(places.size[axis] - 1.0);
        let (column, row) = (within(0), within(1));
        let at = if self.are_small {
            number_of([column, row], places.size[0]).map(|at| at as usize)
        } else {
            let (column, row) = (to_whole(column), to_whole(row));
            std::array::from_fn(|lane| {
                row[lane] as usize * self.width[places.face.of(lane)] as usize + column[lane] as usize
            })
        };
        let texel = |depth: &[f32], lane: usize| depth.get(at[lane]).copied().unwrap_or(UNKNOWN);
        if let Some(face) = places.face.only() {
            let depth = self.depth[face];
            return Lanes::new(texel(depth, 0), texel(depth, 1), texel(depth, 2), texel(depth, 3));
        }
        let each = |lane| texel(self.depth[places.face.of(lane)], lane);
        Lanes::new(each(0), each(1), each(2), each(3))
    }

    #[inline(always)]
    fn occupancies(&self, local: &Points, places: &Places) -> Occupancies {
        let surface = self.footprint_depth(places);
        let known = surface.cmpne(Vec4::splat(UNKNOWN)).bitmask() & places.exist;
        let before = surface.cmplt(places.inverse_depth).bitmask();
        // The distance of a point is at least its planar depth, so no point is nearer than the near distance.
        if places.planar_m.cmpge(self.near_m).bitmask() == ALL {
            return Occupancies { empty: known & before, occupied: known & !before };
        }
        let square = local.x * local.x + local.y * local.y + local.z * local.z;
        let near = square.cmplt(Vec4::splat(self.near_squared)).bitmask();
        let centre = near & square.cmple(Vec4::splat(f32::MIN_POSITIVE)).bitmask() & !places.exist;
        // Points nearer than the near distance are empty, regardless of the texels, if the face has an image.
        let captured =
            (0..4).filter(|&lane| !self.depth[places.face.of(lane)].is_empty()).fold(0, |all, lane| all | 1 << lane);
        let near = near & places.exist & captured;
        Occupancies { empty: known & before | near | centre, occupied: known & !(near | before) }
    }

    /// Returns the face of all four positions, if they have the same one and its colours are codes.
    #[inline(always)]
    pub(crate) fn face_of_codes(&self, places: &Places) -> Option<CodedFace<'a>> {
        let face = places.face.only().filter(|_| places.exist == ALL && self.are_small)?;
        let (depth, codes, has_alpha) = (self.depth[face], self.codes[face], self.has_alpha[face]);
        (codes.len() == depth.len()).then_some(CodedFace { depth, codes, has_alpha })
    }

    /// Returns the tested lanes whose segments the view proves empty.
    #[inline(always)]
    pub(crate) fn prove(&self, tested: u32, ends: [&Points; 2], guess: usize, reach_m: Lanes) -> u32 {
        let error_m = ROUNDING * (reach_m + self.reach_m) + MIN_M;
        if let Some(first) = self.guessed(ends[0], guess)
            && let Some(last) = self.guessed(ends[1], guess)
        {
            // In a cube, the planar depth is the largest absolute coordinate.
            let farthest_m = first.planar_m.max(last.planar_m) + 2.0 * error_m;
            let whole = self.prove_whole(tested, farthest_m);
            return if whole == tested { whole } else { self.prove_between(tested, whole, [&first, &last], error_m) };
        }
        self.prove_anywhere(tested, ends, error_m)
    }

    #[inline(never)]
    fn prove_anywhere(&self, tested: u32, [a, b]: [&Points; 2], error_m: Lanes) -> u32 {
        let (a, b) = (self.local(a), self.local(b));
        let size = |end: &Points| end.x.abs().max(end.y.abs()).max(end.z.abs());
        let whole = self.prove_whole(tested, size(&a).max(size(&b)) + 2.0 * error_m);
        if whole == tested {
            return whole;
        }
        self.prove_between(tested, whole, [&self.places(&a), &self.places(&b)], error_m)
    }

    /// Returns the tested lanes whose segments are nearer to the view than any surface.
    #[inline(always)]
    fn prove_whole(&self, tested: u32, farthest_m: Lanes) -> u32 {
        tested & (self.greatest_inverse_depth * farthest_m).cmplt(Vec4::splat(SURELY_BELOW_ONE)).bitmask()
    }

    /// Adds to `proved` the lanes whose segments the texels between the ends prove empty.
    #[inline(always)]
    fn prove_between(&self, tested: u32, mut proved: u32, [first, last]: [&Places; 2], error_m: Lanes) -> u32 {
        let nearest_m = first.planar_m.min(last.planar_m);
        let farthest_m = first.planar_m.max(last.planar_m) + 2.0 * error_m;
        let widest = first.plane[0].abs().max(first.plane[1].abs());
        let widest = widest.max(last.plane[0].abs().max(last.plane[1].abs()));
        let slack = (1.0 + widest) * (4.0 * error_m / nearest_m + ROUNDING);
        let mut may = nearest_m.cmpge(4.0 * error_m);
        if !self.is_view {
            may &= (widest + slack).cmple(Lanes::ONE);
        }
        let (mut least, mut most) = ([[0; 4]; 2], [[0; 4]; 2]);
        for axis in 0..2 {
            let (one, two) = (first.at[axis], last.at[axis]);
            let margin = slack * last.scale[axis].abs() + last.size[axis] * ROUNDING;
            let (low, high) = (one.min(two) - margin, one.max(two) + margin);
            if self.is_view {
                may &= low.cmpge(Lanes::ZERO) & high.cmplt(last.size[axis]);
            }
            let (end, reach) = (last.size[axis] - 1.0, self.footprint.reach());
            least[axis] = to_whole((low - reach).max(Lanes::ZERO).min(end));
            most[axis] = to_whole((high + reach).max(Lanes::ZERO).min(end));
        }
        let may = may.bitmask() & tested & !proved;
        let farthest_m = farthest_m.to_array();
        for lane in lanes_of(may) {
            let face = last.face.of(lane);
            let Some(texels) = self.faces[face] else { continue };
            let (from, to) = ([least[0][lane], least[1][lane]], [most[0][lane], most[1][lane]]);
            if first.face.of(lane) == face
                && self.pyramids.faces[face].greatest_between(texels, from, to) * farthest_m[lane] < SURELY_BELOW_ONE
            {
                proved |= 1 << lane;
            }
        }
        proved
    }
}

/// The four texels around each position in an image.
struct Around {
    /// Index of the first texel. `across` and `down` are the offsets to the last column and the last row, or 0 if they are the
    /// same as the first.
    first: [u32; 4],
    across: [u32; 4],
    down: [u32; 4],
}

impl Around {
    #[inline(always)]
    fn of(places: &Places) -> Around {
        let reach = Footprint::Around.reach();
        let end = |axis: usize, by: f32| to_whole((places.at[axis] + by).max(Lanes::ZERO).min(places.size[axis] - 1.0));
        let ([column, row], [last, lowest]) = ([end(0, -reach), end(1, -reach)], [end(0, reach), end(1, reach)]);
        let width = to_whole(places.size[0]);
        Around {
            first: std::array::from_fn(|lane| row[lane].wrapping_mul(width[lane]).wrapping_add(column[lane])),
            across: std::array::from_fn(|lane| last[lane].wrapping_sub(column[lane])),
            down: std::array::from_fn(|lane| lowest[lane].wrapping_sub(row[lane]).wrapping_mul(width[lane])),
        }
    }

    /// True if all four positions have four distinct texels.
    #[inline(always)]
    fn are_squares(&self) -> bool {
        (0..4).fold(true, |all, lane| all & (self.across[lane] == 1) & (self.down[lane] != 0))
    }
}

/// Returns the maximum inverse depth of the texels around each position; [`UNKNOWN`] if any of them is. `texel` returns an
/// inverse depth by lane and texel index.
#[inline(always)]
fn greatest_of(places: &Around, texel: impl Fn(usize, usize) -> Option<f32>) -> Lanes {
    let of = |lane: usize| {
        let (first, across, down) = (places.first[lane], places.across[lane], places.down[lane]);
        let texel = |number: u32| texel(lane, number as usize).unwrap_or(UNKNOWN);
        let above = texel(first).max(texel(first.wrapping_add(across)));
        above.max(texel(first.wrapping_add(down)).max(texel(first.wrapping_add(down).wrapping_add(across))))
    };
    Lanes::new(of(0), of(1), of(2), of(3))
}

pub(crate) struct PacketViews<'a> {
    pub(crate) views: Vec<PacketView<'a>>,
    pub(crate) are_codes: bool,
    pub(crate) has_alpha: bool,
}

impl<'a> PacketViews<'a> {
    pub(crate) fn new(views: &'a ActiveViews<'a>) -> PacketViews<'a> {
        let packet_views: Vec<PacketView<'_>> = views.views.iter().map(PacketView::new).collect();
        PacketViews {
            are_codes: matches!(views.coding, ColorCoding::Codes(_)),
            has_alpha: packet_views.iter().any(|view| view.has_alpha.contains(&true)),
            views: packet_views,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3, Vec3};

    use super::*;
    use crate::march::synthetic::{SyntheticProbe, room};
    use crate::march::tests::field;
    use codec::image::transfer::ToneMap;

    #[test]
    fn guesses_change_no_result() {
        let coding = ColorCoding::Codes(ToneMap::default());
        let turns = [DQuat::IDENTITY, DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7)];
        let mut answered = 0;
        for (turn, size) in turns.into_iter().zip([[16, 16], [9, 24]]) {
            let made = SyntheticProbe { turn, size, ..SyntheticProbe::new(DVec3::new(0.1, -0.2, 0.3), 1) };
            let sight = |direction| room(made.position, direction, DVec3::new(3.0, 1.5, 2.0), 0.0);
            let mut cube = made.cube(coding, &sight);
            cube.faces[3] = None;
            let light_field = field(vec![cube], coding);
            let views = ActiveViews::new(&light_field, &[0], DVec3::ZERO);
            let flat = PacketViews::new(&views);
            let (active, view) = (&views.views[0], &flat.views[0]);
            for at in 0..40_000u32 {
                let part = |prime: u32| ((at * prime) % 2003) as f32 / 1001.5 - 1.0;
                // Points in the view's axes, including points on edges of faces, next to them, and near the centre.
                let mut local = Vec3::new(part(7), part(11), part(13));
                if at.is_multiple_of(8) {
                    local[at as usize / 8 % 3] = local[(at as usize / 8 + 1) % 3] * [1.0, -1.0][at as usize / 24 % 2];
                }
                let local = local * [4.0, 1.0, 0.02][at as usize % 3];
                let beside = |x: f32, y: f32| {
                    let point =
                        local + local.length() * [0.0, 1e-7, 0.01][at as usize / 3 % 3] * Vec3::new(x, y, x * y);
                    (active.probe_from_world.transpose() * point + active.from_eye).to_array()
                };
                let four = [beside(0.0, 0.0), beside(1.0, 0.0), beside(0.0, 1.0), beside(1.0, -1.0)];
                let axis = |axis: usize| Lanes::from_array(four.map(|point| point[axis]));
                let points = Points { x: axis(0), y: axis(1), z: axis(2) };
                let way = view.local(&points);
                let places = view.places(&way);
                for lane in 0..4 {
                    // The scalar projection in single precision must give the same bits.
                    let expected = active.view.project(Vec3::new(way.x[lane], way.y[lane], way.z[lane]));
                    let is_missing = view.faces[places.face.of(lane)].is_none();
                    assert_eq!(places.exist >> lane & 1 == 1 && !is_missing, expected.is_some());
                    if let Some(expected) = expected {
                        assert_eq!(places.face.of(lane), expected.face);
                        assert_eq!(places.at.map(|at| at[lane]), expected.at);
                        assert_eq!(places.inverse_depth[lane], expected.inverse_depth);
                    }
                }
                for mut face in 0..6 {
                    if let Some(guessed) = view.guessed(&points, face) {
                        assert_eq!((guessed.exist, guessed.face), (places.exist, places.face));
                        assert_eq!((guessed.at, guessed.plane), (places.at, places.plane));
                        assert_eq!(guessed.planar_m, places.planar_m);
                        assert_eq!(guessed.inverse_depth, places.inverse_depth);
                        assert!((0..2).all(|axis| guessed.at[axis].cmplt(guessed.size[axis]).bitmask() == ALL));
                        answered += 1;
                    }
                    assert_eq!(view.test(&points, &mut face), view.occupancies(&way, &places));
                }
            }
        }
        assert!(answered > 30_000, "{answered}");
    }
}
