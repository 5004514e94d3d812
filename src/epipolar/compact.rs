//! Active pixels of a layer of a source view: the pixels that show a surface (Epipolar 3.3.2).
//!
//! Behind the first layer most pixels are empty. A compacted list stores only the others, so that a device that draws layers
//! transfers only these.

/// A pixel's index in row-major order, and its value.
pub type ActivePixel = [u32; 2];

/// Returns the number of active pixels in each row; a value of 0 is an empty pixel.
pub fn counts(shown: &[u32], width: usize) -> Vec<u32> {
    shown.chunks(width.max(1)).map(|row| row.iter().filter(|shown| **shown != 0).count() as u32).collect()
}

/// Returns the active pixels in order.
pub fn compact(shown: &[u32]) -> Vec<ActivePixel> {
    (0..).zip(shown).filter(|(_, shown)| **shown != 0).map(|(pixel, shown)| [pixel, *shown]).collect()
}

/// Writes active pixels into an empty picture. Pixels beyond its end are ignored.
pub fn spread(active: &[ActivePixel], picture: &mut [u32]) {
    for &[pixel, shown] in active {
        if let Some(at) = picture.get_mut(pixel as usize) {
            *at = shown;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compacted_comes_back() {
        let shown = [0, 7, 0, 0, 0, 0, 3, 4, 0];
        assert_eq!(counts(&shown, 3), [1, 0, 2]);
        let active = compact(&shown);
        assert_eq!(active, [[1, 7], [6, 3], [7, 4]]);
        let mut again = [0; 9];
        spread(&active, &mut again);
        assert_eq!(again, shown);
        assert!(compact(&[]).is_empty() && counts(&[], 0).is_empty());
        spread(&[[9, 1]], &mut again);
        assert_eq!(again, shown);
    }
}
