//! Sizes that charts, heat maps and legends share.

/// Ems of titles, of axes' names and of ticks, in pixels.
pub const TITLE_EM: f64 = 14.0;
pub const NAME_EM: f64 = 12.0;
pub const TICK_EM: f64 = 11.0;
/// Radius of markers in pixels.
pub const MARKER: f64 = 4.0;
/// Between the picture's border and what is in it, in pixels.
pub const MARGIN: f64 = 12.0;
