//! Coverage of tiles from their constraints (Seurat 5.1).
//!
//! Takes solid and free-space constraints by tile, and returns alpha by texel.

use super::constraints::ConstraintKind;

/// Number of places along a texel's side, to which constraints are quantised and at which coverage is sampled.
pub const SUPERSAMPLING: usize = 4;
/// Distance in places by which solid constraints reach farther than free-space constraints: under a bilinear filter the border of an
/// opaque part shows what lies behind it, which is often a tile without colour there. A place with a free-space constraint stays
/// empty.
const DILATION: f32 = 1.5;
const PLACES: usize = SUPERSAMPLING * SUPERSAMPLING;

/// The two bitmaps of a tile: for each texel a bit per place with a solid constraint, and above them those with free-space constraints.
#[derive(Debug, Clone)]
pub struct ConstraintBitmap {
    /// Number of places along a side.
    side: usize,
    bits: Vec<u32>,
    has_solid: bool,
    has_free: bool,
}

impl ConstraintBitmap {
    /// Creates the bitmaps of a square texture with `texels` texels a side.
    pub fn new(texels: usize) -> ConstraintBitmap {
        let side = texels * SUPERSAMPLING;
        ConstraintBitmap { side, bits: vec![0; texels * texels], has_solid: false, has_free: false }
    }

    /// Adds a constraint at a position in texels; 0 is the centre of the first texel.
    pub fn add(&mut self, at: [f32; 2], kind: ConstraintKind) {
        let place = |at: f32| (((at + 0.5) * SUPERSAMPLING as f32) as usize).min(self.side - 1);
        let (texel, bit) = self.bit([place(at[0]), place(at[1])], kind);
        self.bits[texel] |= bit;
        match kind {
            ConstraintKind::Solid => self.has_solid = true,
            ConstraintKind::FreeSpace => self.has_free = true,
        }
    }

    /// Returns the texel of a place, and the bit of a constraint there.
    fn bit(&self, [x, y]: [usize; 2], kind: ConstraintKind) -> (usize, u32) {
        let texel = y / SUPERSAMPLING * (self.side / SUPERSAMPLING) + x / SUPERSAMPLING;
        let first = if kind == ConstraintKind::Solid { 0 } else { PLACES };
        (texel, 1 << (first + y % SUPERSAMPLING * SUPERSAMPLING + x % SUPERSAMPLING))
    }

    /// Returns for each place, in row-major order, whether only constraints of one kind lie there.
    fn has_only(&self, kind: ConstraintKind) -> impl Fn(usize) -> bool {
        let other = if kind == ConstraintKind::Solid { ConstraintKind::FreeSpace } else { ConstraintKind::Solid };
        move |at| {
            let place = [at % self.side, at / self.side];
            let ((texel, bit), (_, no)) = (self.bit(place, kind), self.bit(place, other));
            self.bits[texel] & (bit | no) == bit
        }
    }

    /// Returns true if a surface lies on the tile and no ray shows any part of it to be empty.
    pub fn is_opaque(&self) -> bool {
        self.has_solid && !self.has_free
    }

    /// Returns for each texel the fraction of its places that lie nearer to a solid constraint than to a free-space constraint, where the
    /// distance to the former may be 1.5 places longer. Places with a free-space constraint are not covered, and those with both kinds
    /// count as neither.
    pub fn coverage(&self) -> Vec<f32> {
        let texels = self.side / SUPERSAMPLING;
        let to = |kind: ConstraintKind| squared_distances(self.side, self.has_only(kind));
        let (solid, free) = (to(ConstraintKind::Solid), to(ConstraintKind::FreeSpace));
        let mut alpha = vec![0.0; texels * texels];
        for (at, (solid, free)) in solid.iter().zip(&free).enumerate() {
            if *free > 0.0 && solid.sqrt() < free.sqrt() + DILATION {
                let (x, y) = (at % self.side / SUPERSAMPLING, at / self.side / SUPERSAMPLING);
                alpha[y * texels + x] += 1.0 / PLACES as f32;
            }
        }
        alpha
    }
}

/// Returns the squared distance of each place to the nearest marked one; `+inf` if none is marked.
///
/// Based on: Felzenszwalb and Huttenlocher, *Distance transforms of sampled functions*, 2012.
fn squared_distances(side: usize, is_marked: impl Fn(usize) -> bool) -> Vec<f32> {
    let mut map: Vec<f32> = (0..side * side).map(|at| if is_marked(at) { 0.0 } else { f32::INFINITY }).collect();
    let mut line = vec![0.0; side];
    let (mut parabolas, mut borders) = (vec![0usize; side], vec![0.0f32; side + 1]);
    for column in 0..side {
        for (row, value) in line.iter_mut().enumerate() {
            *value = map[row * side + column];
        }
        lower_envelope(&line, &mut parabolas, &mut borders, |row, value| map[row * side + column] = value);
    }
    for row in map.chunks_exact_mut(side) {
        line.copy_from_slice(row);
        lower_envelope(&line, &mut parabolas, &mut borders, |column, value| row[column] = value);
    }
    map
}

/// Writes min over q of (p − q)² + values[q] for each p.
fn lower_envelope(values: &[f32], parabolas: &mut [usize], borders: &mut [f32], mut write: impl FnMut(usize, f32)) {
    let mut count: usize = 0;
    for (at, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let start = loop {
            let Some(last) = count.checked_sub(1) else { break f32::NEG_INFINITY };
            let q = parabolas[last];
            let (x, y) = (at as f32, q as f32);
            // Not computed as a difference of squares, which would be rounded on long lines.
            let border = (value - values[q]) / (2.0 * (x - y)) + 0.5 * (x + y);
            if border > borders[last] {
                break border;
            }
            count -= 1;
        };
        (parabolas[count], borders[count]) = (at, start);
        count += 1;
    }
    let mut of = 0;
    for at in 0..values.len() {
        while of + 1 < count && borders[of + 1] < at as f32 {
            of += 1;
        }
        let value = match count {
            0 => f32::INFINITY,
            _ => (at as f32 - parabolas[of] as f32).powi(2) + values[parabolas[of]],
        };
        write(at, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_equal_those_of_all_pairs() {
        let side = 13;
        let marked = |at: usize| at % 29 == 5 || at == 77;
        let found = squared_distances(side, marked);
        for (at, &found) in found.iter().enumerate() {
            let nearest = (0..side * side).filter(|&other| marked(other)).map(|other| {
                let (dx, dy) = ((at % side).abs_diff(other % side), (at / side).abs_diff(other / side));
                (dx * dx + dy * dy) as f32
            });
            assert_eq!(found, nearest.fold(f32::INFINITY, f32::min));
        }
        // Squares of positions at the end of a long line have more bits than a float.
        let long = 1 << 15;
        let values: Vec<f32> =
            (0..long).map(|at| if at % 3 == 0 && at + 100 > long { 0.0 } else { f32::INFINITY }).collect();
        let mut found = vec![0.0; long];
        let (mut parabolas, mut borders) = (vec![0; long], vec![0.0; long + 1]);
        lower_envelope(&values, &mut parabolas, &mut borders, |at, value| found[at] = value);
        for (at, found) in found.iter().enumerate().skip(long - 90).take(88) {
            assert_eq!(*found, [0.0, 1.0, 1.0][at % 3], "{at}");
        }
        assert!(squared_distances(4, |_| false).iter().all(|distance| distance.is_infinite()));
    }

    #[test]
    fn a_wire_thinner_than_a_texel_keeps_its_coverage() {
        // A vertical wire a quarter of a texel wide, and free space on both sides, with 8x8 samples per texel.
        let mut bitmap = ConstraintBitmap::new(8);
        for step in 0..64 * 64 {
            let at = [step % 64, step / 64].map(|at| (at as f32 + 0.5) / 8.0 - 0.5);
            let is_wire = (4.0..4.25).contains(&at[0]);
            bitmap.add(at, if is_wire { ConstraintKind::Solid } else { ConstraintKind::FreeSpace });
        }
        let alpha = bitmap.coverage();
        for row in alpha.chunks_exact(8) {
            assert_eq!(row, [0.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0]);
        }
        assert!(!bitmap.is_opaque());
    }

    #[test]
    fn the_border_lies_behind_halfway_and_places_with_both_kinds_count_for_neither() {
        let mut bitmap = ConstraintBitmap::new(4);
        bitmap.add([0.0, 1.0], ConstraintKind::Solid);
        bitmap.add([3.0, 1.0], ConstraintKind::FreeSpace);
        // A place with both kinds counts as unknown.
        bitmap.add([2.0, 1.0], ConstraintKind::Solid);
        bitmap.add([2.0, 1.0], ConstraintKind::FreeSpace);
        let alpha = bitmap.coverage();
        assert_eq!(alpha[..4].iter().map(|alpha| (alpha * 16.0).round()).collect::<Vec<_>>(), [16.0, 16.0, 5.0, 0.0]);
    }
}
