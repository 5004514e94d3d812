//! Light sources: suns, lamps and the sky.

use glam::DVec3;

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards the light.
    pub direction: DVec3,
    /// Radiance of a white surface that faces the light.
    pub radiance: DVec3,
}

/// A point light of limited range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    pub position: DVec3,
    /// Radiance of a white surface that faces the lamp at 1 m, before the window is applied.
    pub radiance: DVec3,
    /// Range in metres; may be `+inf`.
    pub reach: f64,
    pub window: Window,
    /// `None` if the lamp emits in all directions.
    pub cone: Option<Cone>,
}

/// Factor on the inverse square law that fades the light to 0 at its range r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
    /// (1 − (d/r)²)², with slope 0 at the range; used by built-in scenes.
    #[default]
    Smooth,
    /// 1 − (d/r)⁴, as `KHR_lights_punctual` recommends.
    Punctual,
}

impl Window {
    /// Returns two factors whose product is the window, given squared distances.
    pub(super) fn factors(self, squared: f64, reach_squared: f64) -> [f64; 2] {
        let share = squared / reach_squared;
        match self {
            Window::Smooth => [1.0 - share; 2],
            Window::Punctual => [(1.0 - share * share).max(0.0), 1.0],
        }
    }
}

/// The cone of a spot light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit vector.
    pub axis: DVec3,
    /// Cosine of the angle from the axis up to which the intensity is full.
    pub cos_inner: f64,
    /// Cosine of the angle from the axis at which the intensity reaches 0; below `cos_inner`.
    pub cos_outer: f64,
}

impl Cone {
    /// Returns the fraction of the intensity in a unit direction: the square of a linear ramp between the two cosines, as
    /// `KHR_lights_punctual` recommends.
    pub fn strength(&self, direction: DVec3) -> f64 {
        let width = (self.cos_inner - self.cos_outer).max(1e-9);
        let inside = ((direction.dot(self.axis) - self.cos_outer) / width).clamp(0.0, 1.0);
        inside * inside
    }
}

/// Background and ambient light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Radiance up to the start of the gradient.
    pub horizon: DVec3,
    /// Radiance at the zenith.
    pub zenith: DVec3,
    /// Radiance of a white surface that faces up, from ambient light alone.
    pub ambient: DVec3,
    /// Sine of the elevation at which the gradient from the horizon to the zenith starts, less than 1.
    pub gradient_start: f64,
}

impl Sky {
    /// Just above sin 45°: the four horizontal faces of a cube map see a constant.
    pub const GRADIENT_START: f64 = 0.71;

    pub const NONE: Sky =
        Sky { horizon: DVec3::ZERO, zenith: DVec3::ZERO, ambient: DVec3::ZERO, gradient_start: Sky::GRADIENT_START };

    /// Returns the radiance in a unit direction.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let rise = (direction.y - self.gradient_start) / (1.0 - self.gradient_start);
        if rise <= 0.0 { self.horizon } else { self.horizon.lerp(self.zenith, rise.min(1.0)) }
    }
}

/// All light sources except emissive surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    pub suns: Vec<Sun>,
    pub lamps: Vec<Lamp>,
    pub sky: Sky,
}

impl Default for Light {
    /// A bright day, for scenes without lights.
    fn default() -> Self {
        let sun = Sun { direction: DVec3::new(0.5, 0.78, 0.38).normalize(), radiance: DVec3::new(1.75, 1.6, 1.35) };
        let sky = Sky {
            horizon: DVec3::new(0.5, 0.66, 0.86),
            zenith: DVec3::new(0.16, 0.32, 0.68),
            ambient: DVec3::new(0.3, 0.36, 0.46),
            ..Sky::NONE
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
