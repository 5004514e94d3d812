//! Which image is which face of a cube, and which way up: what is declared, and what fits best.

use glam::{DMat3, DVec3};

use super::borders::{Edge, SIDES, edges, side_of, side_point};
use crate::image::Face;
use crate::image::cube::{FacePoint, direction_to_face};

/// A cube has six faces.
const FACES: usize = 6;

/// A way to turn and mirror an image: exchange rows and columns or not, then mirror across, then upside down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Turn(u8);

impl Turn {
    /// As it is.
    pub const NONE: Turn = Turn(0);

    /// All eight.
    pub fn all() -> impl Iterator<Item = Turn> {
        (0..8).map(Turn)
    }

    /// The point of the image as it is in the file that is shown at a point of the turned one, both in −1..1.
    pub fn in_file(self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [u, v] = if self.0 & 4 != 0 { [v, u] } else { [u, v] };
        [if self.0 & 1 != 0 { -u } else { u }, if self.0 & 2 != 0 { -v } else { v }]
    }

    /// What has been done to the file's image: as a sentence goes on after "is".
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

    /// The turn that shows in its upper right quarter the point that is given in the file.
    fn that_shows(probe: [f64; 2], file: [f64; 2]) -> Option<Turn> {
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
        Turn::all().find(|turn| near(turn.in_file(probe), file))
    }
}

/// For each face, the file that should be it and how it is to be turned; `None` where there is none.
pub type Arrangement = [Option<(usize, Turn)>; FACES];

/// Every face from its own file, as it is.
pub fn declared(present: [bool; FACES]) -> Arrangement {
    std::array::from_fn(|face| present[face].then_some((face, Turn::NONE)))
}

/// What any two sides of different files differ by.
#[derive(Debug, Clone)]
pub struct CostTable {
    costs: Vec<f64>,
    edges: Vec<Edge>,
}

impl CostTable {
    /// Asks for the cost of (file, side) against (file, side), one of them reversed or not.
    pub fn new(cost: impl Fn((usize, usize), (usize, usize), bool) -> f64) -> CostTable {
        let mut costs = vec![0.0; (FACES * SIDES) * (FACES * SIDES) * 2];
        for a in 0..FACES * SIDES {
            for b in (0..FACES * SIDES).filter(|b| b / SIDES != a / SIDES) {
                for reversed in [false, true] {
                    costs[Self::index(a, b, reversed)] = cost((a / SIDES, a % SIDES), (b / SIDES, b % SIDES), reversed);
                }
            }
        }
        CostTable { costs, edges: edges() }
    }

    fn index(a: usize, b: usize, reversed: bool) -> usize {
        (a * FACES * SIDES + b) * 2 + usize::from(reversed)
    }

    /// Cost of an edge under an arrangement; 0 where one of its faces is not there.
    fn edge(&self, edge: &Edge, arrangement: &Arrangement) -> f64 {
        let place = |(face, side): (usize, usize)| {
            let (file, turn) = arrangement[face]?;
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

    /// Cost of an arrangement.
    pub fn total(&self, arrangement: &Arrangement) -> f64 {
        self.edges.iter().map(|edge| self.edge(edge, arrangement)).sum()
    }

    /// Cost of the edges of one face.
    pub fn of_face(&self, face: usize, arrangement: &Arrangement) -> f64 {
        let own = |edge: &&Edge| edge.a.0 == face || edge.b.0 == face;
        self.edges.iter().filter(own).map(|edge| self.edge(edge, arrangement)).sum()
    }

    /// The arrangement of least cost: files exchanged among the faces that are there, and turned. Of six faces the first
    /// stays where it is, because a cube may be turned and mirrored as a whole without any edge noticing.
    ///
    /// Branch and bound: costs only grow as files are placed.
    pub fn best(&self, present: [bool; FACES]) -> (Arrangement, f64) {
        let start = declared(present);
        let mut best = (start, self.total(&start));
        let mut place = [None; FACES];
        let mut free: Vec<usize> = (0..FACES).filter(|face| present[*face]).collect();
        let positions = free.clone();
        if positions.len() == FACES {
            place[0] = Some((0, Turn::NONE));
            free.remove(0);
            self.descend(&positions[1..], &mut free, &mut place, 0.0, &mut best);
        } else {
            self.descend(&positions, &mut free, &mut place, 0.0, &mut best);
        }
        best
    }

    fn descend(
        &self,
        positions: &[usize],
        free: &mut Vec<usize>,
        place: &mut Arrangement,
        cost: f64,
        best: &mut (Arrangement, f64),
    ) {
        let [face, rest @ ..] = positions else {
            // What rounding alone makes better is not better.
            if cost < best.1 - 1e-6 {
                *best = (*place, cost);
            }
            return;
        };
        for at in 0..free.len() {
            let file = free.remove(at);
            for turn in Turn::all() {
                place[*face] = Some((file, turn));
                let cost = cost + self.of_face(*face, place);
                if cost < best.1 {
                    self.descend(rest, free, place, cost, best);
                }
            }
            place[*face] = None;
            free.insert(at, file);
        }
    }
}

/// The same arrangement of six faces with the whole cube turned and mirrored, in all 48 ways.
pub fn symmetric(arrangement: &Arrangement) -> Vec<Arrangement> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut found = Vec::new();
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0], [2, 0, 1]] {
        for signs in 0..8u8 {
            let column = |at: usize| axes[order[at]] * if signs >> at & 1 == 1 { -1.0 } else { 1.0 };
            found.extend(turned(arrangement, DMat3::from_cols(column(0), column(1), column(2))));
        }
    }
    found
}

fn turned(arrangement: &Arrangement, turn: DMat3) -> Option<Arrangement> {
    let mut placed = [None; FACES];
    for face in Face::CUBE {
        let [forward, right, down] = face.axes();
        // A point without symmetry.
        let probe = [0.6, -0.3];
        let FacePoint { face: other, plane: [u, v] } =
            direction_to_face(turn * (forward + probe[0] * right + probe[1] * down));
        let (file, inner) = arrangement[other as usize]?;
        placed[face as usize] = Some((file, Turn::that_shows(probe, inner.in_file([u, v]))?));
    }
    Some(placed)
}

/// The faces whose file or turn is not what is declared.
pub fn changed(arrangement: &Arrangement) -> Vec<usize> {
    let differs = |face: &usize| arrangement[*face].is_some_and(|place| place != (*face, Turn::NONE));
    (0..FACES).filter(differs).collect()
}

/// Every face from its own file, each turned in the same way.
pub fn all_turned(present: [bool; FACES], turn: Turn) -> Arrangement {
    std::array::from_fn(|face| present[face].then_some((face, turn)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; FACES] = [true; FACES];

    /// Costs 0 where two sides belong together under `truth`, else 1.
    fn table(truth: &Arrangement) -> CostTable {
        let belongs: Vec<_> = edges()
            .iter()
            .map(|edge| {
                let place = |(face, side): (usize, usize)| {
                    let (file, turn) = truth[face].unwrap();
                    let (side, along) = side_of(turn.in_file(side_point(side, 0.5)));
                    ((file, side), along < 0.0)
                };
                let ((a, back_a), (b, back_b)) = (place(edge.a), place(edge.b));
                (a, b, edge.reversed ^ back_a ^ back_b)
            })
            .collect();
        CostTable::new(|a, b, reversed| {
            let fits = belongs.iter().any(|&(x, y, r)| r == reversed && ((x, y) == (a, b) || (x, y) == (b, a)));
            if fits { 0.0 } else { 1.0 }
        })
    }

    #[test]
    fn the_best_arrangement_is_the_true_one_up_to_the_whole_cube() {
        let mut truth = declared(ALL);
        truth[1] = Some((4, Turn(5)));
        truth[4] = Some((1, Turn(2)));
        truth[3] = Some((3, Turn(7)));
        let table = table(&truth);
        assert_eq!(table.total(&truth), 0.0);
        let (best, cost) = table.best(ALL);
        assert_eq!(cost, 0.0);
        let equal = symmetric(&best);
        assert_eq!(equal.len(), 48);
        assert!(equal.contains(&truth));
        assert!(equal.iter().all(|arrangement| table.total(arrangement) == 0.0));
    }

    #[test]
    fn what_is_declared_stays_where_it_fits() {
        let table = table(&declared(ALL));
        assert_eq!(table.best(ALL), (declared(ALL), 0.0));
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
        // What the file shows in its upper right corner must be seen, after a file was turned to the right by 90
        // degrees, where undoing it looks it up: the upper left corner of the truth is the upper right of the file.
        let named = |words: &str| Turn::all().find(|turn| turn.words() == words).unwrap();
        assert_eq!(named("turned by 90 degrees to the right").in_file([-1.0, -1.0]), [1.0, -1.0]);
        assert_eq!(named("turned by 90 degrees to the left").in_file([1.0, -1.0]), [-1.0, -1.0]);
        assert_eq!(named("mirrored left to right").in_file([1.0, 0.5]), [-1.0, 0.5]);
        assert_eq!(named("mirrored across its diagonal").in_file([1.0, 0.5]), [0.5, 1.0]);
    }
}
