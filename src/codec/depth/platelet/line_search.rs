//! Searches the line of a platelet: by image moments of its sides, or as a separator of two sets of pixels.
//!
//! Based on: GDC 3.2, after Morvan et al. 2006. Moments of a side are computed from prefix sums along rows, so the time per line
//! is proportional to the number of rows, not of pixels.

use crate::depth::block::{Block, side_of};
use crate::depth::domain::{Domain, DomainKind};
use crate::depth::platelet::SideTest;

const END: i32 = 255;
const AROUND: i32 = 4 * END;
/// Number of points around the square between which lines are tried first.
const POINTS: i32 = 32;
/// Maximum number of moves of a line's ends at each step size of the refinement.
const TRIES: usize = 4;
/// Number of points close to a separating line, in each half of it, of which all pairs are tried.
const CLOSE_POINTS: usize = 12;

/// Returns the point at a distance along the square, clockwise from the top left.
fn point_at(way: i32) -> [u8; 2] {
    let way = way.rem_euclid(AROUND);
    let along = way % END;
    let [x, y] = match way / END {
        0 => [along, 0],
        1 => [END, along],
        2 => [END - along, END],
        _ => [0, END - along],
    };
    [x as u8, y as u8]
}

fn line_between(ways: [i32; 2]) -> [u8; 4] {
    let ([x0, y0], [x1, y1]) = (point_at(ways[0]), point_at(ways[1]));
    [x0, y0, x1, y1]
}

#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    value: f64,
    value_x: f64,
    value_y: f64,
}

impl Moments {
    /// Returns the part of the sum of squared values that a plane explains.
    #[inline]
    fn explained(&self) -> f64 {
        if self.count < 0.5 {
            return 0.0;
        }
        let inverse = 1.0 / self.count;
        let (x, y, value) = (self.x * inverse, self.y * inverse, self.value * inverse);
        let (xx, xy, yy) = (self.xx - self.x * x, self.xy - self.x * y, self.yy - self.y * y);
        let (vx, vy) = (self.value_x - self.value * x, self.value_y - self.value * y);
        let determinant = xx * yy - xy * xy;
        let constant = self.value * value;
        // Collinear pixels do not determine the slope in one direction.
        if determinant > 1e-6 * (xx * yy) && determinant > 1e-9 {
            constant + (vx * vx * yy - 2.0 * vx * vy * xy + vy * vy * xx) / determinant
        } else if xx >= yy && xx > 1e-9 {
            constant + vx * vx / xx
        } else if yy > 1e-9 {
            constant + vy * vy / yy
        } else {
            constant
        }
    }

    fn without(&self, other: &Moments) -> Moments {
        Moments {
            count: self.count - other.count,
            x: self.x - other.x,
            y: self.y - other.y,
            xx: self.xx - other.xx,
            xy: self.xy - other.xy,
            yy: self.yy - other.yy,
            value: self.value - other.value,
            value_x: self.value_x - other.value_x,
            value_y: self.value_y - other.value_y,
        }
    }

    #[inline]
    fn add_row(&mut self, y: f64, [count, x, xx]: [f64; 3], [value, value_x]: [f64; 2]) {
        self.count += count;
        self.x += x;
        self.xx += xx;
        self.y += y * count;
        self.xy += y * x;
        self.yy += y * y * count;
        self.value += value;
        self.value_x += value_x;
        self.value_y += y * value;
    }
}

pub struct LineSearch {
    level: u8,
    width: usize,
    height: usize,
    /// Prefix sums of value and x · value along each row, `width + 1` per row.
    values: Vec<[f64; 2]>,
    /// Prefix sums of 1, x and x² along a row, the same for all rows.
    columns: Vec<[f64; 3]>,
    all: Moments,
    energy: f64,
}

impl LineSearch {
    /// Computes the moments of a block: of codes, or of the values of other domains, scaled to about the range of codes.
    pub fn new(block: &Block, domain: &Domain) -> LineSearch {
        let (width, height) = (block.width, block.height);
        let mean = block.rows().flatten().map(|&code| u64::from(code)).sum::<u64>() / block.pixel_count() as u64;
        let middle = domain.value_of(mean as u16);
        let slope = domain.slope_at(middle).abs();
        let centre = [(width - 1) as f64 / 2.0, (height - 1) as f64 / 2.0];
        let mut columns = vec![[0.0; 3]];
        for x in 0..width {
            let ([count, sum, square], x) = (columns[x], x as f64 - centre[0]);
            columns.push([count + 1.0, sum + x, square + x * x]);
        }
        let (mut values, mut all, mut energy) = (Vec::with_capacity((width + 1) * height), Moments::default(), 0.0);
        let log = domain.kind() == DomainKind::Log;
        for (y, row) in block.rows().enumerate() {
            let (mut sum, mut across) = (0.0, 0.0);
            values.push([0.0; 2]);
            let mut x = -centre[0];
            for &code in row {
                let value = if log { f64::from(code) - middle } else { (domain.value_of(code) - middle) * slope };
                sum += value;
                across += value * x;
                energy += value * value;
                values.push([sum, across]);
                x += 1.0;
            }
            all.add_row(y as f64 - centre[1], columns[width], [sum, across]);
        }
        LineSearch { level: block.level, width, height, values, columns, all, energy }
    }

    fn squared_error(&self, line: [u8; 4]) -> f64 {
        let test = SideTest::new(line, self.level);
        let mut part = Moments::default();
        let mut y = -((self.height - 1) as f64) / 2.0;
        // Column where the test changes its sign in a row, and the change of this column per row. Pixels on the line count as
        // side A; the tolerance is smaller than the distance of any other pixel.
        let (mut cross, step) = match test.across {
            0 => (0.0, 0.0),
            across => {
                let inverse = -1.0 / f64::from(across);
                let tie = if across < 0 { -1e-6 } else { 1e-6 };
                (f64::from(test.start) * inverse + 1.0 + tie, f64::from(test.down) * inverse)
            }
        };
        for (row, value) in self.values.chunks_exact(self.width + 1).enumerate() {
            let end = match test.across {
                0 if test.at(0, row as i32) > 0 => self.width,
                0 => 0,
                _ => (cross.max(0.0) as usize).min(self.width),
            };
            part.add_row(y, self.columns[end], value[end]);
            cross += step;
            y += 1.0;
        }
        self.energy - part.explained() - self.all.without(&part).explained()
    }

    /// Returns lines of low squared error, best first: lines between points around the block are tried, and the best of them
    /// refined.
    pub fn best<const COUNT: usize>(&self) -> Vec<(f64, [u8; 4])> {
        let mut found: Vec<(f64, [i32; 2])> = Vec::with_capacity(COUNT + 1);
        let per_side = POINTS / 4;
        for first in 0..POINTS {
            for second in first + 1..POINTS {
                if first / per_side == second / per_side {
                    continue;
                }
                let ways = [first, second].map(|point| point * AROUND / POINTS);
                let squared_error = self.squared_error(line_between(ways));
                if found.len() < COUNT || squared_error < found[found.len() - 1].0 {
                    let place = found.partition_point(|&(other, _)| other <= squared_error);
                    found.insert(place, (squared_error, ways));
                    found.truncate(COUNT);
                }
            }
        }
        let mut refined: Vec<(f64, [u8; 4])> = found
            .into_iter()
            .map(|start| self.refine(start))
            .map(|(squared_error, ways)| (squared_error, line_between(ways)))
            .collect();
        refined.sort_by(|a, b| a.0.total_cmp(&b.0));
        refined.dedup_by(|a, b| a.1 == b.1 || a.0 == b.0);
        refined
    }

    /// Moves the ends of a line by decreasing steps as long as the squared error decreases.
    fn refine(&self, (mut least, mut ways): (f64, [i32; 2])) -> (f64, [i32; 2]) {
        const MOVES: [[i32; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]];
        let mut step = AROUND / POINTS / 2;
        while step > 0 {
            for _ in 0..TRIES {
                let from = ways;
                for [a, b] in MOVES {
                    let moved = [from[0] + a * step, from[1] + b * step];
                    // Equal ends do not define a line, and at the last corner they would be read as a marker.
                    if point_at(moved[0]) == point_at(moved[1]) {
                        continue;
                    }
                    let squared_error = self.squared_error(line_between(moved));
                    if squared_error < least {
                        (least, ways) = (squared_error, moved);
                    }
                }
                if ways == from {
                    break;
                }
            }
            step /= 2;
        }
        (least, ways)
    }
}

/// Returns a line with all `chosen` pixels on side B and the others on side A; `None` if no line with representable points was
/// found that separates them.
pub fn separating_line(block: &Block, chosen: impl Fn(u16) -> bool) -> Option<[u8; 4]> {
    // The first and the last pixel of a set in each row are sufficient: the others lie between them.
    let mut sets: [Vec<[i32; 2]>; 2] = [Vec::new(), Vec::new()];
    for (y, row) in block.rows().enumerate() {
        for (set, wanted) in sets.iter_mut().zip([false, true]) {
            let ends = [
                row.iter().position(|&code| chosen(code) == wanted),
                row.iter().rposition(|&code| chosen(code) == wanted),
            ];
            set.extend(ends.into_iter().flatten().map(|x| [x as i32, y as i32]));
        }
    }
    let [others, chosen] = &sets;
    let difference = nearest(chosen, others)?;
    let dot = |[x, y]: [i32; 2]| f64::from(x) * difference[0] + f64::from(y) * difference[1];
    let low = chosen.iter().map(|&point| dot(point)).fold(f64::INFINITY, f64::min);
    let high = others.iter().map(|&point| dot(point)).fold(f64::NEG_INFINITY, f64::max);
    // Half way between the sets, in units of the line's points.
    let unit = 256.0 / side_of(block.level) as f64;
    let offset = ((low + high) / 2.0 + (difference[0] + difference[1]) / 2.0) * unit;
    // Points with integer coordinates close to the line, in two halves: a line through a point of each half is almost the same.
    let [nx, ny] = difference;
    let steep = nx.abs() > ny.abs();
    let (along, over) = if steep { (ny, nx) } else { (nx, ny) };
    let mut points: Vec<(f64, [u8; 2])> = Vec::with_capacity(END as usize + 1);
    for at in 0..=END as u8 {
        let exact = (offset - along * f64::from(at)) / over;
        if (-0.5..=f64::from(END) + 0.5).contains(&exact) {
            let near = exact.round().clamp(0.0, f64::from(END));
            points.push(((exact - near).abs(), if steep { [near as u8, at] } else { [at, near as u8] }));
        }
    }
    let parts = |line: [u8; 4]| {
        let test = SideTest::new(line, block.level);
        others.iter().all(|&[x, y]| test.at(x, y) <= 0) && chosen.iter().all(|&[x, y]| test.at(x, y) > 0)
    };
    let middle = points.len() / 2;
    let (first, second) = points.split_at_mut(middle);
    first.sort_by(|a, b| a.0.total_cmp(&b.0));
    second.sort_by(|a, b| a.0.total_cmp(&b.0));
    for &(_, [x0, y0]) in first.iter().take(CLOSE_POINTS) {
        for &(_, [x1, y1]) in second.iter().take(CLOSE_POINTS) {
            let line = [[x0, y0, x1, y1], [x1, y1, x0, y0]].into_iter().find(|&line| parts(line));
            if line.is_some() {
                return line;
            }
        }
    }
    None
}

/// Returns the shortest vector from the convex hull of `others` to that of `chosen`; `None` if they intersect (Gilbert, Johnson
/// and Keerthi, in two dimensions).
fn nearest(chosen: &[[i32; 2]], others: &[[i32; 2]]) -> Option<[f64; 2]> {
    type Vector = [f64; 2];
    let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1];
    let vector = |[x, y]: [i32; 2]| [f64::from(x), f64::from(y)];
    let farthest = |points: &[[i32; 2]], along: Vector| {
        points.iter().map(|&point| vector(point)).max_by(|&a, &b| dot(a, along).total_cmp(&dot(b, along)))
    };
    let support = |along: Vector| {
        let (a, b) = (farthest(chosen, along)?, farthest(others, [-along[0], -along[1]])?);
        Some([a[0] - b[0], a[1] - b[1]])
    };
    // The point of a segment that is nearest to the origin.
    let closest = |a: Vector, b: Vector| {
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = dot(d, d);
        let t = if length > 0.0 { -dot(a, d) / length } else { 0.0 };
        if t <= 0.0 {
            return a;
        }
        if t >= 1.0 {
            return b;
        }
        // Computed along the normal: the ends are integers, so there is no cancellation however close the origin is.
        let normal = [-d[1], d[0]];
        let distance = dot(normal, a) / length;
        [normal[0] * distance, normal[1] * distance]
    };
    let mut segment = [support([1.0, 0.0])?; 2];
    let mut found = segment[0];
    // Differences are integers, so the distance between hulls that do not intersect is well above the tolerance.
    for _ in 0..1000 {
        if dot(found, found) < 1e-9 {
            return None;
        }
        let next = support([-found[0], -found[1]])?;
        if dot(found, found) - dot(found, next) <= 1e-9 * dot(found, found) {
            return Some(found);
        }
        let options = segment.map(|end| (closest(end, next), end));
        let nearer = usize::from(dot(options[1].0, options[1].0) < dot(options[0].0, options[0].0));
        let (point, end) = options[nearer];
        if dot(point, point) >= dot(found, found) * (1.0 - 1e-12) {
            // No side of the triangle is nearer to the origin than its base, so the origin lies inside.
            return None;
        }
        (segment, found) = ([end, next], point);
    }
    None
}
