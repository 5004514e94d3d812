//! The box around the probes, in which an eye finds surfaces that some probe saw.

use glam::DVec3;

/// Axis-aligned box around the probes, in metres, with the margin of the player.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadBox {
    min: DVec3,
    max: DVec3,
}

impl HeadBox {
    /// Returns the box around some points; `None` without points.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Option<HeadBox> {
        let boxes = points.into_iter().map(|point| HeadBox { min: point, max: point });
        boxes.reduce(|one, other| HeadBox { min: one.min.min(other.min), max: one.max.max(other.max) })
    }

    /// Returns the margin in metres around the box: a tenth of its longest side, at least 0.1.
    pub fn margin_m(&self) -> f64 {
        (0.1 * (self.max - self.min).max_element()).max(0.1)
    }

    /// Returns the distance in metres of a point from the box; 0 within its margin.
    pub fn outside_m(&self, point: DVec3) -> f64 {
        let distance = (self.min - point).max(point - self.max).max(DVec3::ZERO).length();
        if distance > self.margin_m() { distance } else { 0.0 }
    }

    /// Returns a sentence about the eyes that lie outside, farthest first; `None` if there are none.
    pub fn warning(&self, eyes: impl IntoIterator<Item = DVec3>) -> Option<String> {
        let outside: Vec<f64> = eyes.into_iter().map(|eye| self.outside_m(eye)).filter(|far| *far > 0.0).collect();
        let farthest = outside.iter().copied().reduce(f64::max)?;
        let count = outside.len();
        let views =
            if count == 1 { "the eye of 1 view is".to_owned() } else { format!("the eyes of {count} views are") };
        Some(format!(
            "{views} outside the box around the probes, by up to {farthest:.2} m: what no probe saw there is filled from its \
             surroundings"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_beyond_the_margin_are_outside() {
        let field = HeadBox::of([DVec3::ZERO, DVec3::new(4.0, 1.0, 0.0)]).unwrap();
        assert_eq!(field.margin_m(), 0.4);
        assert_eq!(field.outside_m(DVec3::new(2.0, 0.5, 0.39)), 0.0);
        assert!((field.outside_m(DVec3::new(-3.0, 5.0, 0.0)) - 5.0).abs() < 1e-12);
        assert_eq!(field.warning([DVec3::ZERO]), None);
        let said = field.warning([DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, DVec3::new(9.0, 0.0, 0.0)]).unwrap();
        assert!(said.contains("2 views are") && said.contains("5.00 m"), "{said}");
        let one = HeadBox::of([DVec3::ONE]).unwrap();
        assert!(one.outside_m(DVec3::new(1.0, 1.0, 1.05)) == 0.0 && one.outside_m(DVec3::new(1.0, 1.0, 1.2)) > 0.19);
        assert_eq!(HeadBox::of([]), None);
    }
}
