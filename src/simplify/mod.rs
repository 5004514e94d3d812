//! Simplifies a still scene to textured quads under hard budgets (Seurat): what is captured inside a viewing region becomes a mesh
//! that a phone draws.
//!
//! Stages, each in a file that bears its name:
//!
//! 1. [`capture`]: images as rays; [`samples`] of them; [`region`]: where the eye may be.
//! 2. [`points`]: samples merged into a point cloud (4.1).
//! 3. [`candidates`]: tilings of the cells of six quadtrees ([`tree`]), planes by [`fit`] (4.2).
//! 4. [`cost`], [`selection`]: the tilings that keep the budgets (4.3); [`selected`] runs all up to here. [`tiles`]: their quads in
//!    drawing order; [`gaps`] between them.
//! 5. [`constraints`], [`silhouettes`], [`shading`]: coverage and light of the tiles' [`textures`] (5.1, 5.2), by a [`texture_filter`];
//!    [`texturing`] makes a mesh of them, [`cracks`] closes what is left open.
//! 6. [`texture_sizes`]: one atlas of bounded size (5.3); [`quad_mesh`]: the mesh; [`gbuffer`]: atlases of normals and
//!    material; [`export`]: files; [`geometry_bytes`]: what compressing the mesh would save.
//! 7. [`raster`]: draws the mesh (6); [`read_glb`] reads it from its file.
//!
//! [`pipeline`] runs them all by [`settings`]; [`fidelity`] compares the result with the capture (7); [`memory`] says what
//! it takes; [`short_cuts`]: work that is left out.

pub mod candidates;
pub mod capture;
pub mod constraints;
pub mod cost;
pub mod cracks;
pub mod export;
pub mod fidelity;
pub mod fit;
pub mod gaps;
pub mod gbuffer;
pub mod geometry_bytes;
pub mod memory;
pub mod pipeline;
pub mod points;
pub mod quad_mesh;
pub mod raster;
pub mod read_glb;
pub mod region;
pub mod samples;
pub mod selected;
pub mod selection;
pub mod settings;
pub mod shading;
pub mod short_cuts;
pub mod silhouettes;
pub mod texture_filter;
pub mod texture_sizes;
pub mod textures;
pub mod texturing;
pub mod tiles;
pub mod tree;
