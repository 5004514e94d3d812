//! Lights of a glTF file (KHR_lights_punctual).
//!
//! A white matte surface reflects 1/π of its illuminance: E lux give a radiance of E/π, and I candela a radiance of I/π at 1 m,
//! in lm/(sr·m²).

use std::f64::consts::PI;

use glam::{DMat4, DVec3};
use gltf::khr_lights_punctual::Kind;

use crate::light::{Cone, Lamp, Light, Sun, Window};
use codec::error::{Error, Result};

/// Maximum number of lights of a scene: each surface point traces a shadow ray to each light.
const MAX_SUNS: usize = 64;
const MAX_LAMPS: usize = 4096;

/// A light on a node, directed along the node's −Z.
#[derive(Debug, Clone, Copy)]
pub struct NodeLight {
    pub node: usize,
    color: DVec3,
    reach: f64,
    kind: LightKind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum LightKind {
    Sun,
    Lamp,
    Spot { cos_inner: f64, cos_outer: f64 },
}

impl NodeLight {
    fn lamp(&self, position: DVec3, cone: Option<Cone>) -> Lamp {
        Lamp { position, radiance: self.color, reach: self.reach, window: Window::Punctual, cone }
    }
}

pub fn read(document: &gltf::Document, shown: &[bool]) -> Result<Vec<NodeLight>> {
    let mut all = Vec::new();
    let mut counts = [0; 2];
    for node in document.nodes().filter(|node| shown[node.index()]) {
        let Some(light) = node.light() else { continue };
        let kind = match light.kind() {
            Kind::Directional => LightKind::Sun,
            Kind::Point => LightKind::Lamp,
            Kind::Spot { inner_cone_angle, outer_cone_angle } => spot(inner_cone_angle, outer_cone_angle),
        };
        let intensity = f64::from(light.intensity());
        let color = DVec3::from_array(light.color().map(f64::from)) * intensity / PI;
        let reach = light.range().map_or(f64::INFINITY, f64::from);
        if !color.is_finite() || color.min_element() < 0.0 || reach.is_nan() || reach <= 0.0 {
            return Err(Error::invalid(format!("light {} has a color, intensity or range below 0", light.index())));
        }
        counts[usize::from(kind != LightKind::Sun)] += 1;
        if counts[0] > MAX_SUNS || counts[1] > MAX_LAMPS {
            let message = format!("more than {MAX_SUNS} directional lights or {MAX_LAMPS} others in a scene");
            return Err(Error::unsupported(message));
        }
        all.push(NodeLight { node: node.index(), color, reach, kind });
    }
    Ok(all)
}

fn spot(inner: f32, outer: f32) -> LightKind {
    let angle = |value: f32| if value.is_finite() { f64::from(value).clamp(0.0, PI) } else { 0.0 };
    let cos_outer = angle(outer).cos();
    // The cosines differ by at least 1e-9, because their difference is a divisor.
    LightKind::Spot { cos_inner: angle(inner).cos().max(cos_outer + 1e-9), cos_outer }
}

/// Returns all lights at one time; the default daylight if there are none. glTF has no sky, so the sky is always the default.
pub fn place(lights: &[NodeLight], to_world: &[DMat4]) -> Light {
    let mut light = Light::default();
    if !lights.is_empty() {
        light.suns.clear();
    }
    for one in lights {
        let matrix = &to_world[one.node];
        let axis = (-matrix.z_axis.truncate()).try_normalize();
        let position = matrix.w_axis.truncate();
        match (one.kind, axis) {
            (LightKind::Sun, Some(axis)) => light.suns.push(Sun { direction: -axis, radiance: one.color }),
            (LightKind::Lamp, _) if position.is_finite() => light.lamps.push(one.lamp(position, None)),
            (LightKind::Spot { cos_inner, cos_outer }, Some(axis)) if position.is_finite() => {
                light.lamps.push(one.lamp(position, Some(Cone { axis, cos_inner, cos_outer })));
            }
            // Lights of nodes scaled to 0 have no axis.
            _ => {}
        }
    }
    light
}
