//! Every output view ray cast at its own eye: the truth, and the baseline of all times.

use super::views::OutputViews;
use crate::error::{Error, Result};
use crate::image::{DepthKind, plane::ColorPlane};
use crate::monitor::Monitor;
use crate::scene::SceneAtTime;
use crate::scene::capture::{Pass, PassSettings, SamplePattern, capture_view};

/// The picture from a place on the line, as `capture` renders it.
pub fn render(
    scene: &SceneAtTime,
    (views, offset_m): (&OutputViews, f64),
    samples: &SamplePattern,
    monitor: &dyn Monitor,
) -> Result<ColorPlane> {
    let settings = PassSettings { passes: &[Pass::Color], samples, depth: DepthKind::Distance, far_m: f64::INFINITY };
    let images = capture_view(scene, &views.viewpoint(offset_m), &settings, monitor)?;
    images.color.ok_or_else(|| Error::invalid("a capture of colour without colour"))
}
