//! Allocation of rectangles in the layers of a texture array.
//!
//! Shelf packing: a layer is cut into shelves from top to bottom, and a shelf is filled from left to right. A rectangle is
//! placed on the shelf that wastes the least height, or on a new shelf if that waste is more than a quarter of the
//! rectangle's height. Rectangles of one size leave no gaps; for several sizes, allocate the highest first.

/// A rectangle starts a new shelf if an existing one would waste more than 1 / `WASTE_DIVISOR` of the rectangle's height.
const WASTE_DIVISOR: u32 = 4;

/// Maximum size of a device's texture arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureLimits {
    /// Maximum width and height in texels.
    pub side: u32,
    pub layers: u32,
}

/// Grid of tiles of one size in the layers of a texture array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileGrid {
    pub columns: u32,
    pub rows: u32,
    pub layers: u32,
}

impl TileGrid {
    /// Returns a grid for `count` tiles with as few tiles per layer as the limits allow; `None` if there are too many tiles.
    pub fn new(tile: [u32; 2], count: u32, limits: TextureLimits) -> Option<TileGrid> {
        let [max_columns, max_rows] = tile.map(|side| limits.side / side.max(1));
        let per_layer = count.max(1).div_ceil(limits.layers.max(1));
        let columns = per_layer.min(max_columns).max(1);
        let rows = per_layer.div_ceil(columns);
        let fits = max_columns > 0 && rows <= max_rows;
        fits.then(|| TileGrid { columns, rows, layers: count.max(1).div_ceil(columns * rows) })
    }

    /// Maximum number of tiles in one texture array.
    pub fn most(tile: [u32; 2], limits: TextureLimits) -> u64 {
        tile.map(|side| u64::from(limits.side / side.max(1))).iter().product::<u64>() * u64::from(limits.layers)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allocation {
    pub layer: u32,
    /// Left column and top row.
    pub corner: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

#[derive(Debug, Clone)]
struct Shelf {
    layer: u32,
    top: u32,
    height: u32,
    used_columns: u32,
}

/// Allocator of rectangles in the layers of a texture array.
#[derive(Debug, Clone)]
pub struct Atlas {
    size: [u32; 2],
    /// Number of rows of each layer that shelves occupy.
    used_rows: Vec<u32>,
    shelves: Vec<Shelf>,
}

impl Atlas {
    /// Creates an empty atlas whose layers have `size` (width, height) texels.
    pub fn new(size: [u32; 2], layers: u32) -> Atlas {
        Atlas { size, used_rows: vec![0; layers as usize], shelves: Vec::new() }
    }

    /// Allocates a rectangle of `size` (width, height); `None` if there is no space.
    pub fn allocate(&mut self, size: [u32; 2]) -> Option<Allocation> {
        let [width, height] = size;
        let fits = |shelf: &Shelf| shelf.height >= height && self.size[0] - shelf.used_columns >= width;
        let fitting = self.shelves.iter().enumerate().filter(|(_, shelf)| fits(shelf));
        let best = fitting.map(|(at, shelf)| (shelf.height - height, at)).min();
        let fits = |used: &u32| width <= self.size[0] && used.saturating_add(height) <= self.size[1];
        let at = match (best, self.used_rows.iter().position(fits)) {
            (Some((waste, at)), layer) if waste <= height / WASTE_DIVISOR || layer.is_none() => at,
            (_, Some(layer)) => {
                self.shelves.push(Shelf { layer: layer as u32, top: self.used_rows[layer], height, used_columns: 0 });
                self.used_rows[layer] += height;
                self.shelves.len() - 1
            }
            _ => return None,
        };
        let shelf = &mut self.shelves[at];
        let corner = [shelf.used_columns, shelf.top];
        shelf.used_columns += width;
        Some(Allocation { layer: shelf.layer, corner, size })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TextureLimits = TextureLimits { side: 100, layers: 4 };

    fn overlap(a: &Allocation, b: &Allocation) -> bool {
        let meets = |axis: usize| {
            a.corner[axis] < b.corner[axis] + b.size[axis] && b.corner[axis] < a.corner[axis] + a.size[axis]
        };
        a.layer == b.layer && meets(0) && meets(1)
    }

    #[test]
    fn grids_take_layers_first() {
        let grid = |columns, rows, layers| Some(TileGrid { columns, rows, layers });
        assert_eq!(TileGrid::new([30, 20], 0, LIMITS), grid(1, 1, 1));
        assert_eq!(TileGrid::new([30, 20], 4, LIMITS), grid(1, 1, 4));
        assert_eq!(TileGrid::new([30, 20], 5, LIMITS), grid(2, 1, 3));
        assert_eq!(TileGrid::new([30, 20], 60, LIMITS), grid(3, 5, 4));
        assert_eq!(TileGrid::new([30, 20], 61, LIMITS), None);
        assert_eq!(TileGrid::new([101, 20], 1, LIMITS), None);
        assert_eq!(TileGrid::most([30, 20], LIMITS), 60);
    }

    #[test]
    fn tiles_fill_a_grid() {
        let tile = [30, 20];
        let mut atlas = Atlas::new([90, 100], 2);
        let tiles: Vec<_> = std::iter::from_fn(|| atlas.allocate(tile)).collect();
        assert_eq!(tiles.len(), 30);
        for (at, a) in tiles.iter().enumerate() {
            assert!(a.corner[0].is_multiple_of(30) && a.corner[1].is_multiple_of(20));
            assert!(tiles[..at].iter().all(|b| !overlap(a, b)));
        }
    }

    #[test]
    fn rectangles_of_any_size_never_overlap() {
        let mut atlas = Atlas::new([64, 64], 2);
        let mut held: Vec<Allocation> = Vec::new();
        let mut number = 1u32;
        let mut below = |end: u32| {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (number >> 8) % end
        };
        let mut refused = 0;
        for _ in 0..300 {
            match atlas.allocate([1 + below(24), 1 + below(24)]) {
                None => refused += 1,
                Some(new) => {
                    assert!((0..2).all(|axis| new.corner[axis] + new.size[axis] <= 64), "{new:?}");
                    assert!(held.iter().all(|other| !overlap(&new, other)), "{new:?}");
                    held.push(new);
                }
            }
        }
        assert!(refused > 0 && held.len() > 20, "{refused} {}", held.len());
    }
}
