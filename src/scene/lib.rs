//! Scenes that can be rendered from any position: analytic shapes, meshes, procedural scenes, ray casting, cube-map capture.
//!
//! Takes a time and a camera position; returns colour and depth planes. Every value follows from the scene's definition, as
//! `lightfold demo` and the codec tests require. Positions and lengths are in metres.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod animated;
pub mod capture;
pub mod footage_plan;
pub mod light;
pub mod material;
pub mod mesh;
pub mod mesh_scene;
pub mod model;
mod noise;
pub mod object;
pub mod placement;
pub mod primitive;
pub mod procedural;
pub mod raycast;
pub mod shading;
mod shadow_cube;
mod shadow_grid;
mod summary;
mod surface;
pub mod trace;

pub use animated::Scene;
#[cfg(test)]
pub(crate) use capture::tests::capture_face;
pub use capture::{CapturePlan, CaptureSummary, MAX_FACE_SIZE, Pass};
pub use footage_plan::FootagePlan;
pub use light::{Cone, Lamp, Light, Sky, Sun, Window};
pub use material::{Material, Segment, Texture};
pub use mesh_scene::{MeshMaterial, Optics, Phong, SceneMesh};
pub use model::{Model, Play};
pub use object::{CastsShadow, Object};
pub use primitive::{Fence, Quad, Shape, Sphere, TurnedBox};
pub use procedural::{DemoKind, DemoScene};
pub use raycast::{FirstHit, HitSurface, LightRays, SceneAtTime};
pub use shading::OPAQUE;
pub use summary::{AnimationSummary, SceneBounds, SceneSummary};
pub use trace::{Hit, trace};

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
