//! Simplification of a still scene to textured quads under hard budgets (Seurat): a capture from inside a viewing region becomes
//! a mesh that a phone can draw.
//!
//! Each stage is in a file of its own:
//!
//! 1. [`capture`]: images as rays; [`samples`] of these, with [`image_measures`]; [`region`]: where the eye may be.
//! 2. [`points`]: merges samples into a point cloud (4.1).
//! 3. [`candidates`]: tilings of the cells of six quadtrees ([`tree`]), whose planes minimise an [`energy`], by [`fit_displacement`]
//!    or, as in the paper, by [`fit`] (4.2).
//! 4. [`cost`], [`budgets`], [`selection`], [`fill`]: the tilings that keep the budgets (4.3), of which [`overdraw`] is measured by [`budgeted`];
//!    [`selected`] runs all stages up to this one. [`tiles`]:
//!    the selected quads in drawing order; [`gaps`] and [`extended`] extend them over gaps.
//! 5. [`constraints`], [`silhouettes`], [`shading`]: coverage and colour of the tiles' [`textures`] (5.1, 5.2), filtered by a
//!    [`texture_filter`]; [`texturing`] makes a mesh from them, and [`cracks`] closes its cracks.
//! 6. [`texture_sizes`]: one atlas of bounded size (5.3); [`quad_mesh`]: the mesh; [`gbuffer`]: atlases of normals and material;
//!    [`export`]: files; [`geometry_bytes`]: size of the compressed mesh.
//! 7. [`raster`]: draws the mesh (6); [`read_glb`] reads it from its file.
//!
//! [`pipeline`] runs all stages with [`settings`]; [`fidelity`] compares the result with the capture (7); [`memory`] computes the
//! memory need; [`shading::ShortCuts`] controls the work that is skipped.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod budgeted;
pub mod budgets;
pub mod candidates;
pub mod capture;
pub mod constraints;
pub mod cost;
pub mod cracks;
pub mod energy;
pub mod export;
pub mod extended;
pub mod fidelity;
pub mod fill;
pub mod fit;
pub mod fit_displacement;
pub mod gaps;
pub mod gbuffer;
pub mod geometry_bytes;
pub mod image_measures;
pub mod memory;
pub mod overdraw;
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
pub mod silhouettes;
pub mod texture_filter;
pub mod texture_sizes;
pub mod textures;
pub mod texturing;
pub mod tile_plane;
pub mod tiles;
pub mod tree;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
