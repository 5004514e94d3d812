//! Active pixels of a layer of a source view: those that show a surface (Epipolar 3.3.2).
//!
//! Behind the first layer most pixels show nothing. Compacted, the others follow each other without gaps, so that a device that draws
//! layers gives those back alone.

/// A pixel's number, row by row, and what it shows.
pub type ActivePixel = [u32; 2];

/// Active pixels of each row; 0 shows nothing.
pub fn counts(shown: &[u32], width: usize) -> Vec<u32> {
    shown.chunks(width.max(1)).map(|row| row.iter().filter(|shown| **shown != 0).count() as u32).collect()
}

/// The active pixels in their order.
pub fn compact(shown: &[u32]) -> Vec<ActivePixel> {
    (0..).zip(shown).filter(|(_, shown)| **shown != 0).map(|(pixel, shown)| [pixel, *shown]).collect()
}

/// Puts active pixels back into a picture in which nothing is shown. Pixels beyond its end are left out.
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
