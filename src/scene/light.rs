//! What shines: suns, lamps and the sky. Plain data; [`super::shading`] says what surfaces make of it.

use glam::DVec3;

/// A light at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Direction towards it, length 1.
    pub direction: DVec3,
    /// Radiance of a white surface that faces it.
    pub radiance: DVec3,
}

/// A light at a point whose reach ends: beyond it, nothing changes when it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Where, metres.
    pub position: DVec3,
    /// Radiance of a white surface that faces it at 1 m, before the fall-off to the reach.
    pub radiance: DVec3,
    /// Distance in metres from which on it lights nothing; may be `+inf`.
    pub reach: f64,
    /// How its light comes to an end there.
    pub window: Window,
    /// Where it shines to, `None` for all around.
    pub cone: Option<Cone>,
}

/// What the inverse square of the distance is multiplied with, so that light ends at the reach of its lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
    /// (1 − (d/r)²)², which ends with slope 0: the lamps of the procedural scenes.
    #[default]
    Smooth,
    /// 1 − (d/r)⁴, as glTF's `KHR_lights_punctual` recommends: nearly the inverse square up to half the reach.
    Punctual,
}

impl Window {
    /// Two factors whose product is the window, for the squares of the distance and of the reach: 1 without an end.
    pub(super) fn factors(self, squared: f64, reach_squared: f64) -> [f64; 2] {
        let share = squared / reach_squared;
        match self {
            Window::Smooth => [1.0 - share; 2],
            Window::Punctual => [(1.0 - share * share).max(0.0), 1.0],
        }
    }
}

/// The light of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Its middle, length 1.
    pub axis: DVec3,
    /// Cosine of the angle from the axis within which it has its full strength.
    pub cos_inner: f64,
    /// Cosine of the angle from which on it lights nothing, below `cos_inner`.
    pub cos_outer: f64,
}

impl Cone {
    /// Share of the lamp's light that goes in a direction of length 1: 1 inside, 0 outside, and between the two cosines
    /// the square of a straight line in the cosine, as glTF's `KHR_lights_punctual` recommends.
    pub fn strength(&self, direction: DVec3) -> f64 {
        let width = (self.cos_inner - self.cos_outer).max(1e-9);
        let inside = ((direction.dot(self.axis) - self.cos_outer) / width).clamp(0.0, 1.0);
        inside * inside
    }
}

/// What is seen where there is nothing, and the light that comes from there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Radiance up to the elevation whose sine is [`Sky::GRADIENT_START`]: one constant.
    pub horizon: DVec3,
    /// Radiance straight up.
    pub zenith: DVec3,
    /// Radiance of a white surface that faces up, without sun.
    pub ambient: DVec3,
}

impl Sky {
    /// Sine of the elevation where the sky starts to change: just above 45°, so that the four horizontal faces of a
    /// cube map see one constant.
    pub const GRADIENT_START: f64 = 0.71;

    /// Black, and no light from anywhere.
    pub const NONE: Sky = Sky { horizon: DVec3::ZERO, zenith: DVec3::ZERO, ambient: DVec3::ZERO };

    /// Radiance in a direction of length 1.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let rise = (direction.y - Sky::GRADIENT_START) / (1.0 - Sky::GRADIENT_START);
        if rise <= 0.0 { self.horizon } else { self.horizon.lerp(self.zenith, rise.min(1.0)) }
    }
}

/// All that shines in a scene, but for surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Lights at infinity.
    pub suns: Vec<Sun>,
    /// Lights at points.
    pub lamps: Vec<Lamp>,
    /// The background.
    pub sky: Sky,
}

impl Default for Light {
    /// A bright day, for scenes that bring no light.
    fn default() -> Self {
        let sun = Sun { direction: DVec3::new(0.5, 0.78, 0.38).normalize(), radiance: DVec3::new(1.75, 1.6, 1.35) };
        let sky = Sky {
            horizon: DVec3::new(0.5, 0.66, 0.86),
            zenith: DVec3::new(0.16, 0.32, 0.68),
            ambient: DVec3::new(0.3, 0.36, 0.46),
        };
        Light { suns: vec![sun], lamps: Vec::new(), sky }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_is_full_inside_and_nothing_outside() {
        let cone = Cone { axis: DVec3::NEG_Y, cos_inner: 0.9, cos_outer: 0.7 };
        let at = |cos: f64| cone.strength(DVec3::new((1.0 - cos * cos).sqrt(), -cos, 0.0));
        assert_eq!((at(1.0), at(0.95), at(0.65), at(-1.0)), (1.0, 1.0, 0.0, 0.0));
        assert!((at(0.8) - 0.25).abs() < 1e-12);
        let sharp = Cone { cos_outer: 0.9, ..cone };
        assert_eq!((sharp.strength(DVec3::NEG_Y), sharp.strength(DVec3::X)), (1.0, 0.0));
    }

    #[test]
    fn windows_end_at_the_reach_and_not_before() {
        let window = |window: Window, d: f64, r: f64| window.factors(d * d, r * r).iter().product::<f64>();
        for kind in [Window::Smooth, Window::Punctual] {
            assert_eq!(
                (window(kind, 0.0, 8.0), window(kind, 8.0, 8.0), window(kind, 5.0, f64::INFINITY)),
                (1.0, 0.0, 1.0)
            );
        }
        assert_eq!((window(Window::Smooth, 1.0, 2.0), window(Window::Punctual, 1.0, 2.0)), (0.5625, 0.9375));
    }
}
