//! An analytic shape with its material.

use glam::{DQuat, DVec3};

use super::{Material, Optics, Shape};
use crate::mesh::AxisBox;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    pub shape: Shape,
    /// A box that contains the shape.
    pub bounds: AxisBox,
    pub material: Material,
    /// Origin of the texture's coordinates in the world, metres.
    pub anchor: DVec3,
    /// Rotation from world axes to the axes of the texture.
    pub texture_from_world: DQuat,
    pub casts_shadow: CastsShadow,
}

/// Selects whether shadow rays are tested against an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CastsShadow {
    Yes,
    No,
}

impl Object {
    /// Creates an object that casts shadows and is textured in world coordinates.
    pub fn new(shape: Shape, material: Material) -> Self {
        Object {
            shape,
            bounds: shape.bounding_box(),
            material,
            anchor: DVec3::ZERO,
            texture_from_world: DQuat::IDENTITY,
            casts_shadow: CastsShadow::Yes,
        }
    }

    /// True if it casts shadows; glass never does.
    pub(super) fn is_occluder(&self) -> bool {
        self.casts_shadow == CastsShadow::Yes && !matches!(self.material.optics, Optics::Glass { .. })
    }
}
