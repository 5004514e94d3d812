//! Noise for procedural textures, from integer hashes: the same on every machine.

/// Returns a fixed number in 0..1 for each cell of the plane.
pub(super) fn cell_noise(column: f64, row: f64) -> f64 {
    // The casts saturate only far outside any scene.
    let mut h = (column as i32 as u32).wrapping_mul(0x9e37_79b1) ^ (row as i32 as u32).wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae3d);
    h ^= h >> 13;
    f64::from(h >> 8) / f64::from(1_u32 << 24)
}

/// Returns value noise in 0..1: [`cell_noise`] at whole coordinates, with continuous slopes between them.
pub(super) fn smooth(x: f64, y: f64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let [u, v] = [x - column, y - row].map(|t| t * t * (3.0 - 2.0 * t));
    let along = |row: f64| {
        let (left, right) = (cell_noise(column, row), cell_noise(column + 1.0, row));
        left + u * (right - left)
    };
    let (low, high) = (along(row), along(row + 1.0));
    low + v * (high - low)
}

/// Returns the sum of three octaves of [`smooth`], in 0..1.
pub(super) fn fractal(x: f64, y: f64) -> f64 {
    (4.0 * smooth(x, y) + 2.0 * smooth(2.0 * x + 19.0, 2.0 * y) + smooth(4.0 * x, 4.0 * y + 43.0)) / 7.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_continuous_and_meets_the_cells() {
        for at in 0..200 {
            let (x, y) = (0.37 * f64::from(at) - 20.0, 0.61 * f64::from(at) - 50.0);
            assert_eq!(smooth(x.floor(), y.floor()), cell_noise(x.floor(), y.floor()));
            for of in [smooth, fractal] {
                assert!((of(x, y) - of(x + 1e-6, y - 1e-6)).abs() < 1e-4);
                assert!((0.0..1.0).contains(&of(x, y)));
            }
        }
    }
}
