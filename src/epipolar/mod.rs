//! Hundreds of views on a line, from few source views (Epipolar: de Quilletes).
//!
//! All cameras look in one direction, and the line that they stand on is parallel to their scanlines. A point of the scene is then on the
//! same scanline of every view, and its column is a linear function of the camera's place: a line in epipolar space.
//!
//! Enters: a scene, or captured images with depth, and the output views. Leaves: their pictures.
//! Scanlines do not depend on each other, and are acquired and interpolated in bands. Stages, each in a file that bears its name:
//!
//! 1. [`views`]: the output views (3.1), with an off-axis window where they converge.
//! 2. [`acquire`]: source views with all surfaces that an output view may see (3.3.1), by [`visibility`] (3.4.1, 3.4.2); [`captured`] reads them
//!    from images.
//! 3. [`lines`]: the pixels of source views as lines in integers, [`coalesce`]d in runs (3.4.3); [`slice`]: their winners in one
//!    scanline of all output views (3.3.2); [`interpolate`]: whole views.
//! 4. [`highlights`]: light that depends on the eye (3.5).
//! 5. [`fill`]: pixels that no line covers.
//!
//! [`backend`]: stages 3 and 4 on the CPU, or elsewhere, and [`drawing`] of triangles for stage 2, whose active pixels are [`compact`].
//! [`erosion`] is a stopping rule of stage 2. [`grid`] makes columns between two
//! rows (7.2). [`layers`] decides between the frames of a sequence how many layers are acquired (3.4.4). [`pipeline`] runs all stages,
//! band by band; [`stages`] are timed; views gather in [`view_store`], and [`memory`] plans what a run takes. [`brute_force`] renders every view, which is the truth.

pub mod acquire;
pub mod backend;
pub mod brute_force;
pub mod captured;
pub mod coalesce;
pub mod compact;
pub mod continuity;
pub mod counters;
pub mod drawing;
pub mod erosion;
pub mod fill;
pub mod grid;
pub mod highlights;
pub mod interpolate;
pub mod layers;
pub mod lines;
pub mod memory;
pub mod pipeline;
pub mod slice;
pub mod source;
pub mod stages;
pub mod view_store;
pub mod views;
pub mod visibility;
