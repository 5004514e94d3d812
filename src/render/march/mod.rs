//! Renders a light field from any eye by ray marching (CALF 6, algorithm 4).

pub mod active_views;
pub mod aov;
pub mod baseline;
pub mod clip;
mod columns;
pub mod counters;
pub mod interpolate;
pub mod intersect;
pub mod layers;
pub mod memory;
mod packet;
pub mod playback;
mod primary_rays;
pub mod pyramid;
pub mod ray;
pub mod render;
pub mod samples;
pub mod segments;
pub mod settings;
pub mod shading;
pub mod silhouettes;
pub mod specular;
pub mod synthetic;

pub use active_views::{ActiveView, ActiveViews, Footprint, HOLE_DIFFERENCE, Occupancy};
pub use clip::ClipPlanes;
pub use counters::Counters;
pub use interpolate::{
    DEPTH_EPSILON, Interpolated, Taps, background_color, seen_from_eye, surface_color, surface_color_of,
};
pub use intersect::intersect_from;
pub(crate) use layers::{FirstHits, Layer, Primary, PrimaryHit};
pub use playback::frames::{PictureOptions, Renderer, Stage};
pub use pyramid::{DepthPyramid, Level, MIN_M, Pyramids, ViewPyramids};
pub use ray::{Ray, Steps, StepsFrom, Until};
pub use render::{Rendered, distances_m};
pub use settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
pub(crate) use shading::LightCurve;
pub use shading::{RayResult, background, light_of, surface};
pub use specular::material::{fresnel, surface_material};
pub use specular::normal::{Patch, patch};
pub use specular::proxy::{Proxies, Proxy, SpecularImage, proxies_in_sight};
pub use specular::secondary_rays::MAX_BOUNCES;
pub use specular::sphere::Sphere;
pub use specular::sphere_fit::SphereFit;

#[cfg(test)]
mod tests;
