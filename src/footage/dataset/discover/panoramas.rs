//! Detects panoramas with two eyes in one image, from the shape of the image and the similarity of its halves.

use codec::image::{Plane, StereoLayout};

/// Minimum concordance (Lin 1989) of the pictures of two eyes, 1 for equal pictures. The halves of other images show sky and
/// ground, or different walls.
const ALIKE: f64 = 0.8;

/// Returns the stereo layout that an image of this size could have, each eye with a panorama twice as wide as high, and a
/// description.
pub fn stereo((width, height): (u32, u32)) -> Option<(StereoLayout, &'static str)> {
    if width == height && width % 2 == 0 {
        let words = "square images with similar halves were assumed to be stereo panoramas, left eye above right";
        Some((StereoLayout::OverUnder, words))
    } else if u64::from(width) == 4 * u64::from(height) {
        let words = "images four times as wide as high were assumed to be stereo panoramas, left eye beside right";
        Some((StereoLayout::SideBySide, words))
    } else {
        None
    }
}

/// Returns true if both halves of an image show about the same. False for constant halves, which prove nothing.
pub fn are_alike(shades: &Plane<f32>, layout: StereoLayout) -> bool {
    let (width, height) = (shades.width(), shades.height());
    let [[columns, rows], [right, down]] = match layout {
        StereoLayout::OverUnder => [[width, height / 2], [0, height / 2]],
        StereoLayout::SideBySide => [[width / 2, height], [width / 2, 0]],
    };
    let pairs = || {
        let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        places.map(|(x, y)| [shades.get(x, y), shades.get(x + right, y + down)].map(f64::from))
    };
    let count = f64::from(columns) * f64::from(rows);
    let mean = pairs().fold([0.0; 2], |sum, pair| [0, 1].map(|eye| sum[eye] + pair[eye] / count));
    let [mut together, mut left, mut right] = [0.0; 3];
    for pair in pairs() {
        let [a, b] = [0, 1].map(|eye| pair[eye] - mean[eye]);
        (together, left, right) = (together + a * b, left + a * a, right + b * b);
    }
    let apart = count * (mean[0] - mean[1]).powi(2);
    2.0 * together >= ALIKE * (left + right + apart) && together > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_that_show_the_same_are_eyes() {
        let scene = |x: f32, y: f32| (x * 0.3).sin() + (y * 0.13).cos();
        let over = |shift: f32| {
            Plane::from_fn(64, 64, |x, y| scene(x as f32 + if y < 32 { 0.0 } else { shift }, (y % 32) as f32))
        };
        let (layout, _) = stereo((64, 64)).unwrap();
        assert!(are_alike(&over(1.0), layout), "a small parallax");
        assert!(!are_alike(&Plane::from_fn(64, 64, |x, y| scene(x as f32, y as f32)), layout));
        assert!(!are_alike(&Plane::filled(64, 64, 1.0), layout), "nothing is seen");
        let (layout, _) = stereo((64, 16)).unwrap();
        assert!(are_alike(&Plane::from_fn(64, 16, |x, y| scene((x % 32) as f32, y as f32)), layout));
        assert!(!are_alike(&Plane::from_fn(64, 16, |x, y| scene(x as f32, y as f32) + x as f32), layout));
        assert_eq!((stereo((64, 32)), stereo((0, 16))), (None, None));
    }
}
