//! Interpolation of hundreds of views on a line from few source views (Epipolar: de Quilletes).
//!
//! All cameras look in one direction, and their line is parallel to their scanlines. A point of the scene is therefore on the
//! same scanline of every view, and its column is a linear function of the camera's position: a line in epipolar space.
//!
//! Takes a scene, or captured images with depth, and the output views; returns the pictures of these views. Scanlines are
//! independent of each other, and are acquired and interpolated in bands. Each stage is in a file of its own:
//!
//! 1. [`views`]: the output views (3.1), with off-axis windows if they converge.
//! 2. [`acquire`]: source views with all surfaces that an output view may see (3.3.1), as determined by [`visibility`] (3.4.1,
//!    3.4.2); [`captured`] reads source views from images,
//!    [`light_field`] renders them from a container.
//! 3. [`lines`]: the pixels of source views as lines in integers, [`coalesce`]d into runs (3.4.3); [`slice`](mod@slice): the winning lines
//!    of one scanline of all output views (3.3.2); [`interpolate`]: whole views.
//! 4. [`highlights`]: radiance that depends on the eye (3.5).
//! 5. [`fill`]: pixels that no line covers.
//!
//! [`backend`] runs stages 3 and 4 on the CPU or on a device. [`drawing`] finds surfaces for stage 2 by rasterising triangles.
//! [`erosion`] is a stopping rule of stage 2. [`grid`] interpolates columns between two rows (7.2). [`acquire::LayerReduction`]
//! sets the number of layers for the next frame of a sequence (3.4.4). [`pipeline`] runs all stages, band by band; [`stages`]
//! measures their durations; [`view_store`] collects views; [`memory`] plans the memory of a run. [`brute_force`] renders every
//! view as ground truth.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod acquire;
pub mod backend;
pub mod brute_force;
pub mod captured;
pub mod coalesce;
pub mod continuity;
pub mod counters;
pub mod drawing;
pub mod erosion;
pub mod fill;
pub mod grid;
pub mod highlights;
pub mod interpolate;
pub mod light_field;
pub mod lines;
pub mod memory;
pub mod pipeline;
pub mod slice;
pub mod source;
pub mod stages;
pub mod view_store;
pub mod views;
pub mod visibility;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
