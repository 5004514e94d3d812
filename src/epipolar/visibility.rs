//! Tests of what an output view may see behind a pixel of a source view (Epipolar 3.4.1, 3.4.2).

use super::continuity::Continuity;

/// Distance from a source view to the outermost output views on both sides.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    /// Numbers of columns by which a surface at 1 m moves between the source and the views farthest to its left and to its right.
    pub columns: [f64; 2],
}

/// Returns the distance behind a surface within which no view sees anything past one of its pixels (Epipolar equation 3.1, after
/// Lee et al.); `+inf` if nothing behind it is visible.
///
/// Pixels at the distance of the surface cast an umbra if the eye moves by more than their width. `width` is a tangent: that of
/// two pixels within a surface. From an eye `reach_m` to the side, a point δ behind their centre has moved by reach δ/(d + δ)
/// across them. The paper uses half of the baseline as the reach, which is right for a source in the middle; for a source at an
/// end the reach is the whole baseline. The paper's formula has a pole where the eye moves by exactly the width, and is negative
/// below; in both cases nothing behind the pixels is visible.
pub fn hidden_m(depth_m: f64, width: f64, reach_m: f64) -> f64 {
    let (width_m, baseline_m) = (depth_m * width, 2.0 * reach_m);
    if baseline_m <= width_m { f64::INFINITY } else { depth_m * width_m / (baseline_m - width_m) }
}

/// Returns true for each pixel of a layer that shows the same surface as the next pixel. Inverse distances are as for
/// [`sees_past`].
pub fn joined(inverse: &[Option<f64>], continuity: Continuity) -> Vec<bool> {
    let of = |at: usize| inverse.get(at).copied().flatten();
    let joins = |at: usize| {
        let before = at.checked_sub(1).and_then(of);
        of(at).zip(of(at + 1)).is_some_and(|(a, b)| continuity.joins(before, [a, b], of(at + 2)))
    };
    (0..inverse.len()).map(joins).collect()
}

/// Returns true for each pixel of a layer that an output view may see past. Takes the inverse distances of the pixels (0 for the
/// background, `None` where the layer has no pixel) and the result of [`joined`].
///
/// A view to the right shows the points behind a pixel on a segment from the pixel to the position of a point at infinity. If all
/// pixels of that segment show one surface, everything behind the pixel is hidden. This holds if no edge lies between: the
/// cumulative counts of edges from the left are equal at both ends.
pub fn sees_past(inverse: &[Option<f64>], joined: &[bool], reach: Reach) -> Vec<bool> {
    // Number of edges to the left of each pixel.
    let mut edges = Vec::with_capacity(inverse.len());
    let mut count = 0u32;
    for at in 0..inverse.len() {
        count += u32::from(at > 0 && !joined[at - 1]);
        edges.push(count);
    }
    let is_open = |at: usize, end: i64| usize::try_from(end).ok().and_then(|end| edges.get(end)) != Some(&edges[at]);
    let sees = |at: usize| match inverse[at] {
        None => false,
        Some(inverse) => {
            let [left, right] = reach
                .columns
                .map(|columns| if columns > 0.0 { ((columns * inverse).ceil() as i64).saturating_add(1) } else { 0 });
            is_open(at, (at as i64).saturating_sub(left)) || is_open(at, (at as i64).saturating_add(right))
        }
    };
    (0..inverse.len()).map(sees).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_close_behind_is_hidden() {
        // Pixels of 1 cm at 2 m, and half a metre to each side: similar triangles of 1 m and 2 cm.
        assert!((hidden_m(2.0, 0.01, 0.5) - 2.0 * 0.02 / 0.98).abs() < 1e-12);
        for reach_m in [0.01, 0.005, 0.0] {
            assert_eq!(hidden_m(2.0, 0.01, reach_m), f64::INFINITY, "{reach_m}");
        }
        let above = 0.01f64.next_up();
        assert!(hidden_m(2.0, 0.01, above) > 1e13);
    }

    #[test]
    fn one_surface_hides_everything_and_edges_show_what_is_behind() {
        let continuity = Continuity::new(100.0);
        let wall = vec![Some(0.5); 40];
        let sees = |layer: &[Option<f64>], columns| sees_past(layer, &joined(layer, continuity), Reach { columns });
        // Anything may come into view near the borders of the image.
        let past = sees(&wall, [10.0, 0.0]);
        assert!(past[..6].iter().all(|sees| *sees) && !past[6..].iter().any(|sees| *sees), "{past:?}");
        assert!(!sees(&wall, [0.0; 2]).contains(&true));
        let mut step = wall.clone();
        step[20..].fill(Some(0.25));
        let past = sees(&step, [0.0, 10.0]);
        let behind: Vec<usize> = (0..30).filter(|&at| past[at]).collect();
        // Pixels whose segment to infinity, 5 columns of the near wall and one for rounding, crosses the edge.
        assert_eq!(behind, [14, 15, 16, 17, 18, 19]);
        // A surface so near that a pixel moves by more columns than an integer holds.
        assert!(sees(&[Some(1e300), Some(1e300)], [10.0; 2]).iter().all(|sees| *sees));
        // A gap in the layer is an edge.
        let mut gap = wall;
        gap[20] = None;
        assert!(!sees(&gap, [0.0, 10.0])[20] && sees(&gap, [0.0, 10.0])[19]);
    }
}
