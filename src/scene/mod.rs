//! Scenes that can be seen from anywhere: analytic shapes, meshes, procedural scenes, ray casting, cube-map capture.
//!
//! Enters: a time and a camera position. Leaves: colour and depth planes whose every value has a known reason, which
//! is what `lightfold demo` and the tests of a codec need.

pub mod animated;
pub mod bvh;
pub mod capture;
pub mod footage;
pub mod light;
pub mod material;
pub mod mesh;
pub mod model;
#[cfg(test)]
mod numbers;
pub mod primitive;
pub mod procedural;
pub mod raycast;
pub mod shading;
mod shadow_grid;
mod surface;
pub mod texture;
mod triangle;

pub use animated::Scene;
pub use bvh::{MeshBvh, MeshHit};
pub use capture::{CapturePlan, CaptureSummary, Kept, MAX_FACE_SIZE, Pass, capture_face};
pub use footage::FootagePlan;
pub use light::{Cone, Lamp, Light, Sky, Sun, Window};
pub use material::{Material, Texture};
pub use mesh::{Mesh, MeshMaterial, Optics, Phong};
pub use model::{Model, Play};
pub use primitive::{AxisBox, Fence, Intersection, Quad, Ray, Shape, Sphere, TurnedBox};
pub use procedural::{DemoKind, DemoScene};
pub use raycast::{CastsShadow, FirstHit, Hit, OPAQUE, Object, SceneAtTime, Thing, trace};
pub use texture::{ImageTexture, Wrap};
pub(crate) use triangle::RayFrame;
