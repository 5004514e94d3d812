//! Assignments of images to the faces of a cube, with a turn of each image: the declared one, and the one whose edges fit best.

use glam::{DMat3, DVec3};

use super::borders::{Edge, FaceSide, SIDES, edges, side_of, side_point};
use codec::image::Face;
use codec::image::cube::{FacePoint, direction_to_face};

const FACES: usize = 6;

/// One of the 8 symmetries of a square image: optional exchange of rows and columns, then horizontal, then vertical mirroring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Turn(u8);

impl Turn {
    pub const NONE: Turn = Turn(0);

    pub fn all() -> impl Iterator<Item = Turn> {
        (0..8).map(Turn)
    }

    /// Maps a point of the turned image to the point of the file's image, both in −1..1.
    pub fn in_file(self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [u, v] = if self.0 & 4 != 0 { [v, u] } else { [u, v] };
        [if self.0 & 1 != 0 { -u } else { u }, if self.0 & 2 != 0 { -v } else { v }]
    }

    /// Phrase that follows "is" in a sentence.
    pub fn words(self) -> &'static str {
        match self.0 {
            0 => "as it should be",
            1 => "mirrored left to right",
            2 => "mirrored top to bottom",
            3 => "turned by 180 degrees",
            4 => "mirrored across its diagonal",
            5 => "turned by 90 degrees to the right",
            6 => "turned by 90 degrees to the left",
            _ => "mirrored across its other diagonal",
        }
    }

    /// Returns the turn that maps point `probe` of the turned image to point `file` of the file's image.
    fn that_shows(probe: [f64; 2], file: [f64; 2]) -> Option<Turn> {
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
        Turn::all().find(|turn| near(turn.in_file(probe), file))
    }
}

/// The file and turn of each face; `None` for a missing face.
pub type FacePermutation = [Option<PlacedFile>; FACES];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlacedFile {
    /// Index of the face that the file is declared to be.
    pub file: usize,
    pub turn: Turn,
}

/// Returns the declared permutation: each face from its own file, not turned.
pub fn declared(present: [bool; FACES]) -> FacePermutation {
    all_turned(present, Turn::NONE)
}

/// Mismatch of every two sides of different files.
#[derive(Debug, Clone)]
pub struct CostTable {
    costs: Vec<f64>,
    edges: Vec<Edge>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    pub permutation: FacePermutation,
    pub cost: f64,
}

impl CostTable {
    /// Creates a table; `cost` compares two sides of different files.
    pub fn new(cost: impl Fn(&Edge) -> f64) -> CostTable {
        let mut costs = vec![0.0; (FACES * SIDES) * (FACES * SIDES) * 2];
        for a in 0..FACES * SIDES {
            for b in (0..FACES * SIDES).filter(|b| b / SIDES != a / SIDES) {
                for reversed in [false, true] {
                    let [side_a, side_b] = [a, b].map(|at| FaceSide { face: at / SIDES, side: at % SIDES });
                    costs[Self::index(a, b, reversed)] = cost(&Edge { a: side_a, b: side_b, reversed });
                }
            }
        }
        CostTable { costs, edges: edges() }
    }

    fn index(a: usize, b: usize, reversed: bool) -> usize {
        (a * FACES * SIDES + b) * 2 + usize::from(reversed)
    }

    /// Returns the cost of an edge; 0 if one of its faces is missing.
    fn edge(&self, edge: &Edge, permutation: &FacePermutation) -> f64 {
        let place = |FaceSide { face, side }| {
            let PlacedFile { file, turn } = permutation[face]?;
            let (side, along) = side_of(turn.in_file(side_point(side, 0.5)));
            Some((file * SIDES + side, along < 0.0))
        };
        match (place(edge.a), place(edge.b)) {
            (Some((a, backwards_a)), Some((b, backwards_b))) => {
                self.costs[Self::index(a, b, edge.reversed ^ backwards_a ^ backwards_b)]
            }
            _ => 0.0,
        }
    }

    pub fn total(&self, permutation: &FacePermutation) -> f64 {
        self.edges.iter().map(|edge| self.edge(edge, permutation)).sum()
    }

    pub fn of_face(&self, face: usize, permutation: &FacePermutation) -> f64 {
        let own = |edge: &&Edge| edge.a.face == face || edge.b.face == face;
        self.edges.iter().filter(own).map(|edge| self.edge(edge, permutation)).sum()
    }

    /// Returns the permutation with the lowest cost, by branch and bound: costs never decrease as files are placed. With six
    /// faces the first one is fixed, because rotating or mirroring the whole cube does not change edges.
    pub fn best(&self, present: [bool; FACES]) -> Fit {
        let start = declared(present);
        let mut best = Fit { permutation: start, cost: self.total(&start) };
        let mut place = [None; FACES];
        let mut free: Vec<usize> = (0..FACES).filter(|face| present[*face]).collect();
        let positions = free.clone();
        let fixed = usize::from(positions.len() == FACES);
        if fixed == 1 {
            place[0] = Some(PlacedFile { file: 0, turn: Turn::NONE });
            free.remove(0);
        }
        self.descend(&positions[fixed..], &mut free, &mut place, 0.0, &mut best);
        best
    }

    fn descend(
        &self,
        positions: &[usize],
        free: &mut Vec<usize>,
        place: &mut FacePermutation,
        cost: f64,
        best: &mut Fit,
    ) {
        let [face, rest @ ..] = positions else {
            // Require more than a rounding difference.
            if cost < best.cost - 1e-6 {
                *best = Fit { permutation: *place, cost };
            }
            return;
        };
        for at in 0..free.len() {
            let file = free.remove(at);
            for turn in Turn::all() {
                place[*face] = Some(PlacedFile { file, turn });
                let cost = cost + self.of_face(*face, place);
                if cost < best.cost {
                    self.descend(rest, free, place, cost, best);
                }
            }
            place[*face] = None;
            free.insert(at, file);
        }
    }
}

/// Returns the equivalents of a permutation of six faces under the 48 symmetries of the cube.
pub fn symmetric(permutation: &FacePermutation) -> Vec<FacePermutation> {
    let columns = signed_axes().map(|axes| axes.map(|(axis, sign)| DVec3::AXES[axis] * sign));
    columns.filter_map(|[x, y, z]| turned(permutation, DMat3::from_cols(x, y, z))).collect()
}

/// Signed permutations of the three axes: for each axis, the index of the axis that replaces it and its sign.
pub fn signed_axes() -> impl Iterator<Item = [(usize, f64); 3]> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0], [2, 0, 1]];
    let signed =
        |order: [usize; 3], signs: u8| [0, 1, 2].map(|at| (order[at], if signs >> at & 1 == 1 { -1.0 } else { 1.0 }));
    orders.into_iter().flat_map(move |order| (0..8).map(move |signs| signed(order, signs)))
}

fn turned(permutation: &FacePermutation, turn: DMat3) -> Option<FacePermutation> {
    let mut placed = [None; FACES];
    for face in Face::CUBE {
        let [forward, right, down] = face.axes();
        // A point that no symmetry of the square maps to itself.
        let probe = [0.6, -0.3];
        let FacePoint { face: other, plane: [u, v] } =
            direction_to_face(turn * (forward + probe[0] * right + probe[1] * down));
        let PlacedFile { file, turn: inner } = permutation[other as usize]?;
        let turn = Turn::that_shows(probe, inner.in_file([u, v]))?;
        placed[face as usize] = Some(PlacedFile { file, turn });
    }
    Some(placed)
}

/// Returns the faces whose file or turn differs from the declared one.
pub fn changed(permutation: &FacePermutation) -> Vec<usize> {
    let differs =
        |face: &usize| permutation[*face].is_some_and(|place| place != PlacedFile { file: *face, turn: Turn::NONE });
    (0..FACES).filter(differs).collect()
}

/// Returns the permutation with each face from its own file, all with the same turn.
pub fn all_turned(present: [bool; FACES], turn: Turn) -> FacePermutation {
    std::array::from_fn(|face| present[face].then_some(PlacedFile { file: face, turn }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; FACES] = [true; FACES];

    /// Returns a table with cost 0 for two sides that are adjacent under `truth`, else 1.
    fn table(truth: &FacePermutation) -> CostTable {
        let belongs: Vec<_> = edges()
            .iter()
            .map(|edge| {
                let place = |FaceSide { face, side }| {
                    let PlacedFile { file, turn } = truth[face].unwrap();
                    let (side, along) = side_of(turn.in_file(side_point(side, 0.5)));
                    (FaceSide { face: file, side }, along < 0.0)
                };
                let ((a, back_a), (b, back_b)) = (place(edge.a), place(edge.b));
                (a, b, edge.reversed ^ back_a ^ back_b)
            })
            .collect();
        CostTable::new(|&Edge { a, b, reversed }| {
            let fits = belongs.iter().any(|&(x, y, r)| r == reversed && ((x, y) == (a, b) || (x, y) == (b, a)));
            if fits { 0.0 } else { 1.0 }
        })
    }

    #[test]
    fn the_best_permutation_is_the_true_one_up_to_the_whole_cube() {
        let mut truth = declared(ALL);
        truth[1] = Some(PlacedFile { file: 4, turn: Turn(5) });
        truth[4] = Some(PlacedFile { file: 1, turn: Turn(2) });
        truth[3] = Some(PlacedFile { file: 3, turn: Turn(7) });
        let table = table(&truth);
        assert_eq!(table.total(&truth), 0.0);
        let Fit { permutation: best, cost } = table.best(ALL);
        assert_eq!(cost, 0.0);
        let equal = symmetric(&best);
        assert_eq!(equal.len(), 48);
        assert!(equal.contains(&truth));
        assert!(equal.iter().all(|permutation| table.total(permutation) == 0.0));
    }

    #[test]
    fn what_is_declared_stays_where_it_fits() {
        let table = table(&declared(ALL));
        assert_eq!(table.best(ALL), Fit { permutation: declared(ALL), cost: 0.0 });
        let least = symmetric(&declared(ALL)).iter().map(|equal| changed(equal).len()).min();
        assert_eq!(least, Some(0));
    }

    #[test]
    fn mirroring_all_faces_is_exchanging_two_opposite_ones() {
        let mirrored = table(&all_turned(ALL, Turn(1)));
        let mut exchanged = declared(ALL);
        (exchanged[0], exchanged[1]) = (exchanged[1], exchanged[0]);
        assert_eq!(mirrored.total(&exchanged), 0.0);
    }

    #[test]
    fn turns_are_named_as_they_are() {
        // A file that was turned right by 90 degrees shows the true upper left corner in its upper right corner, so `in_file`
        // maps the former to the latter.
        let named = |words: &str| Turn::all().find(|turn| turn.words() == words).unwrap();
        assert_eq!(named("turned by 90 degrees to the right").in_file([-1.0, -1.0]), [1.0, -1.0]);
        assert_eq!(named("turned by 90 degrees to the left").in_file([1.0, -1.0]), [-1.0, -1.0]);
        assert_eq!(named("mirrored left to right").in_file([1.0, 0.5]), [-1.0, 0.5]);
        assert_eq!(named("mirrored across its diagonal").in_file([1.0, 0.5]), [0.5, 1.0]);
    }
}
