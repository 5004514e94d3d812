//! Triangle meshes: geometry, materials, textures, bounding volume hierarchy, glTF input and output.

pub mod assembly;
pub mod budget;
pub mod bvh;
pub mod folder;
pub mod gltf;
mod ktx2;
pub mod material;
pub mod polygon;
pub mod ray;
pub mod texture;
mod triangle;
pub mod triangles;

pub use bvh::{Bvh, TriangleHit};
pub use material::Material;
pub use ray::{AxisBox, Intersection, Ray};
pub use texture::{ImageTexture, Wrap};
pub use triangles::Mesh;
