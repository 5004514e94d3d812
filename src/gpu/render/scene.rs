//! Input of the rendering kernels: camera, settings, views and their images, as the structs of `shaders/march/layout.wgsl`.

use std::mem::offset_of;

use codec::image::Transfer;
use codec::math::{Camera, Window};
use kernels::layout::{Face, Scene, View};
use render::march::{Acceleration, ActiveViews, DepthPyramid, MAX_BOUNCES, Proxies, Refinements, RenderSettings};
use render::rendered_image::{BackgroundFill, HoleFill};
use render::views::{ColorCoding, FaceTexels};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ImageId {
    /// Index of its probe in the container.
    pub probe: usize,
    pub face: usize,
}

/// Position of an image in the texture arrays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Origin {
    /// Column and row of its first texel.
    pub texels: [u32; 2],
    /// Column and row of its pyramid in the pyramid texture.
    pub pyramid: [u32; 2],
    pub layer: u32,
}

/// Substitute for an infinite inverse depth: shaders have no infinity.
pub const NO_BOUND: f32 = 1e30;

/// Marks a face for which a view has no image.
const NO_FACE: u32 = u32::MAX;
/// Number of image slots per view.
const FACES_OF_VIEW: usize = 8;
const CODING_LIGHT: u32 = 0;
const CODING_SRGB: u32 = 1;
const CODING_LINEAR: u32 = 2;
const HOLES_BLANK: u32 = 0;
const HOLES_NEAREST: u32 = 1;
const HOLES_BEHIND: u32 = 2;
const BACKGROUND_OPAQUE: u32 = 0;
const BACKGROUND_TRANSPARENT: u32 = 1;
const REFINE_ANGLES: u32 = 1;
const REFINE_EDGES: u32 = 2;
const REFINE_THIN: u32 = 4;
/// Word of [`Scene`] with the first row of a dispatch.
pub const FIRST_ROW_WORD: usize = offset_of!(Scene, first_row) / 4;
/// Word of [`Scene`] with the number of rows of a dispatch.
pub const ROWS_WORD: usize = offset_of!(Scene, rows) / 4;
pub const GREATEST_WORD: usize = offset_of!(View, greatest_inverse_depth) / 4;

/// Input of a rendering kernel, except textures.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneRows {
    pub scene: Scene,
    /// Active views, then one view per refractive sphere.
    pub views: Vec<View>,
    pub faces: Vec<Face>,
    pub distances_m: Vec<f32>,
}

impl SceneRows {
    /// Creates the input. `pyramid_rows` is [`super::texels::DeviceTexels::pyramid_rows`]; `origin` returns the position of an
    /// image.
    pub fn new(
        views: &ActiveViews<'_>,
        proxies: &Proxies,
        camera: &Camera,
        settings: &RenderSettings,
        pyramid_rows: u32,
        origin: impl Fn(ImageId) -> Origin,
    ) -> SceneRows {
        let proxy_count = proxies.proxies.len() as u32;
        let mut rows = SceneRows {
            scene: Scene { pyramid_rows, proxy_count, ..scene(views, camera, settings) },
            views: Vec::new(),
            faces: Vec::new(),
            distances_m: settings.steps.distances_m.clone(),
        };
        let environments = proxies.proxies.iter().map(|proxy| (proxy.environment_view(), proxy.reach_m));
        for (active, reach_m) in views.views.iter().cloned().map(|view| (view, 0.0)).chain(environments) {
            let mut faces = [NO_FACE; FACES_OF_VIEW];
            for (number, texels) in active.view.faces.iter().enumerate() {
                let Some(texels) = texels else { continue };
                faces[number] = rows.faces.len() as u32;
                // With decoding on the device all levels exist there, and none on the CPU.
                let levels = match texels.is_in_backend() {
                    true => DepthPyramid::sizes(texels.size).len(),
                    false => active.pyramids.faces[number].levels.len(),
                } as u32;
                let id = ImageId { probe: active.view.probe, face: number };
                rows.faces.push(Face { levels, ..face(number, texels, origin(id)) });
            }
            let turn = active.probe_from_world;
            rows.views.push(View {
                from_eye: active.from_eye.to_array(),
                near_m: active.view.near_m,
                turn_x: turn.x_axis.to_array(),
                camera_weight: active.camera_weight,
                turn_y: turn.y_axis.to_array(),
                greatest_inverse_depth: active.greatest_inverse_depth.min(NO_BOUND),
                turn_z: turn.z_axis.to_array(),
                reach_m,
                faces,
            });
        }
        rows
    }
}

fn face(number: usize, texels: &FaceTexels, origin: Origin) -> Face {
    let [column, row] = origin.texels;
    let [pyramid_column, pyramid_row] = origin.pyramid;
    let [width, height] = texels.size;
    Face {
        column,
        row,
        layer: origin.layer,
        has_material: texels.material.is_some().into(),
        width,
        height,
        pyramid_column,
        pyramid_row,
        levels: 0,
        number: number as u32,
        scale: texels.map.scale,
        centre: texels.map.centre,
        has_alpha: texels.has_alpha.into(),
        spare: 0,
    }
}

fn scene(views: &ActiveViews<'_>, camera: &Camera, settings: &RenderSettings) -> Scene {
    let [forward, right, down] = camera.axes();
    let [half_right, half_down] = camera.half();
    let (coding, gain) = match views.coding {
        ColorCoding::Light => (CODING_LIGHT, 1.0),
        ColorCoding::Codes(tone) => {
            let curve = match tone.transfer {
                Transfer::Srgb => CODING_SRGB,
                Transfer::Linear => CODING_LINEAR,
            };
            (curve, (-f64::from(tone.exposure_ev)).exp2() as f32)
        }
    };
    let samples = settings.steps.distances_m.len().next_power_of_two() as u32;
    let [longest_segment, first_segment] = match settings.acceleration {
        Acceleration::None => [1, 1],
        Acceleration::Pyramid => [samples, (samples / 4).max(1)],
    };
    // Shaders have no infinity.
    let [near_m, far_m] = camera.depth_m().map(|metres| (metres as f32).min(f32::MAX));
    let [width, height] = settings.size;
    let Window { u, v } = camera.window();
    let Refinements { angles, edges, thin } = settings.refinements;
    Scene {
        forward: forward.as_vec3().to_array(),
        width,
        right: (right * half_right).as_vec3().to_array(),
        height,
        down: (down * half_down).as_vec3().to_array(),
        samples: settings.samples.max(1),
        view_count: views.views.len() as u32,
        distance_count: settings.steps.distances_m.len() as u32,
        refine: settings.steps.refine(),
        tolerance: settings.tolerance(),
        holes: match settings.holes {
            HoleFill::Blank => HOLES_BLANK,
            HoleFill::Nearest => HOLES_NEAREST,
            HoleFill::Behind => HOLES_BEHIND,
        },
        background: match settings.background {
            BackgroundFill::Opaque => BACKGROUND_OPAQUE,
            BackgroundFill::Transparent => BACKGROUND_TRANSPARENT,
        },
        coding,
        gain,
        max_bounces: settings.max_bounces.min(MAX_BOUNCES),
        longest_segment,
        first_segment,
        near_m,
        far_m,
        log_step: settings.steps.log_step(),
        nearest_view: views.nearest_number().unwrap_or(0) as u32,
        refinements: u32::from(angles) * REFINE_ANGLES
            + u32::from(edges) * REFINE_EDGES
            + u32::from(thin) * REFINE_THIN,
        middle: [u, v].map(|[low, high]| ((low + high) / (high - low)) as f32),
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use wgpu::naga;

    use super::*;
    use crate::render::{COUNTED, COUNTERS, GIVEN_UP, TILE};
    use codec::streams::convert::IOR_RANGE;
    use kernels::{KERNELS, Kernel};
    use render::march::interpolate::{self, DEPTH_EPSILON};
    use render::march::specular::{material, normal, secondary_rays, solid};
    use render::march::{Footprint, active_views, layers, pyramid, ray, samples, segments};
    use render::views::light_field::{BACKGROUND, UNKNOWN};

    fn renders(kernel: &&&Kernel) -> bool {
        kernel.entry == "render"
    }

    /// Constants that both the shaders and the CPU define.
    fn twins() -> Vec<(&'static str, f64)> {
        let numbers = [
            ("VIEW_FACE", codec::image::cube::Face::View as u32),
            ("NO_FACE", NO_FACE),
            ("CODING_LIGHT", CODING_LIGHT),
            ("CODING_SRGB", CODING_SRGB),
            ("CODING_LINEAR", CODING_LINEAR),
            ("HOLES_BLANK", HOLES_BLANK),
            ("HOLES_NEAREST", HOLES_NEAREST),
            ("HOLES_BEHIND", HOLES_BEHIND),
            ("BACKGROUND_OPAQUE", BACKGROUND_OPAQUE),
            ("BACKGROUND_TRANSPARENT", BACKGROUND_TRANSPARENT),
            ("REFINE_ANGLES", REFINE_ANGLES),
            ("REFINE_EDGES", REFINE_EDGES),
            ("REFINE_THIN", REFINE_THIN),
            ("MAX_LAYERS", layers::MAX_LAYERS),
            ("MAX_EXITS", layers::MAX_EXITS),
            ("BACKGROUND", BACKGROUND.to_bits()),
            ("UNKNOWN", UNKNOWN.to_bits()),
            ("TILE", TILE),
            ("COUNTERS", COUNTERS as u32),
            ("MAX_REACH", normal::MAX_REACH as u32),
            ("SETTLE_TIMES", active_views::SETTLE_TIMES),
            ("MAX_INSIDE", solid::MAX_INSIDE as u32),
            ("MAX_BEFORE_STEPS", ray::MAX_BEFORE_STEPS),
        ];
        let floats = [
            ("DEPTH_EPSILON", DEPTH_EPSILON),
            ("HOLE_DIFFERENCE", active_views::HOLE_DIFFERENCE),
            ("ANGLE_EPSILON", interpolate::ANGLE_EPSILON),
            ("CAMERA_EPSILON", active_views::CAMERA_EPSILON),
            ("EDGE_PENALTY", interpolate::EDGE_PENALTY),
            ("BACKGROUND_EDGE_PENALTY", interpolate::BACKGROUND_EDGE_PENALTY),
            ("NEARER", interpolate::NEARER),
            ("DEPTH_CUT", interpolate::DEPTH_CUT),
            ("CUT_WEIGHT", interpolate::CUT_WEIGHT),
            ("GIVEN_UP", GIVEN_UP),
            ("EDGE_CONTRAST", samples::EDGE_CONTRAST),
            ("EDGE_BLACK", samples::EDGE_BLACK),
            ("MIN_LAYER", layers::MIN_LAYER),
            ("AROUND_REACH", Footprint::Around.reach()),
            ("GROWTH", ray::GROWTH),
            ("MIN_POSITIVE", f32::MIN_POSITIVE),
            ("ROUNDING", segments::ROUNDING),
            ("SURELY_BELOW_ONE", segments::SURELY_BELOW_ONE),
            ("MIN_M", pyramid::MIN_M),
            ("MIN_WEIGHT", material::MIN_WEIGHT),
            ("CLEAR", material::CLEAR),
            ("MIN_IOR", IOR_RANGE[0]),
            ("GREATEST_IOR", IOR_RANGE[1]),
            ("SAME_SURFACE", normal::SAME_SURFACE),
            ("FIT", normal::FIT),
            ("SAME_PATCH", normal::SAME_PATCH),
            ("SAME_MATERIAL", normal::SAME_MATERIAL as f32),
            ("FLAT", solid::FLAT),
            ("BEHIND_TEXELS", solid::BEHIND_TEXELS),
            ("MIN_SHARE", secondary_rays::MIN_SHARE),
            ("LIFT_TEXELS", secondary_rays::LIFT_TEXELS),
            ("HIDDEN_TEXELS", secondary_rays::HIDDEN_TEXELS),
            ("RECORDED_SINE", secondary_rays::RECORDED_SINE),
        ];
        let counted = (0..).zip(COUNTED).map(|(at, (name, _))| (name, f64::from(at)));
        let numbers = numbers.into_iter().map(|(name, value)| (name, value.into()));
        numbers.chain(floats.into_iter().map(|(name, value)| (name, value.into()))).chain(counted).collect()
    }

    /// Constants that only shaders define: enum values, sentinels, capacities, and lengths near the limits of floats.
    const OF_SHADERS: [&str; 12] = [
        "ALL_VIEWS",
        "EMPTY",
        "OCCUPIED",
        "NOT_KNOWN",
        "FOUND_NOTHING",
        "FOUND_LIGHT",
        "FOUND_SURFACE",
        "MAX_PENDING",
        "NO_TEXEL",
        "NO_LIMIT_M",
        "MIN_LENGTH",
        "MIN_INVERTIBLE_M",
    ];

    #[test]
    fn constants_are_those_of_the_cpu() {
        let twins: HashMap<&str, f64> = twins().into_iter().collect();
        let mut seen = HashSet::new();
        for kernel in KERNELS.iter().filter(renders) {
            let source = kernel.source();
            let module = naga::front::wgsl::parse_str(&source).unwrap();
            let value = |name: &str| {
                let found = module.constants.iter().find(|(_, found)| found.name.as_deref() == Some(name));
                // naga discards untyped constants when it parses a shader.
                let (_, found) = found.unwrap_or_else(|| panic!("{name} of {} needs a type", kernel.name));
                match module.global_expressions[found.init] {
                    naga::Expression::Literal(naga::Literal::F32(value)) => Some(f64::from(value)),
                    naga::Expression::Literal(naga::Literal::U32(value)) => Some(value.into()),
                    naga::Expression::Literal(naga::Literal::I32(value)) => Some(value.into()),
                    _ => None,
                }
            };
            for line in source.lines().filter_map(|line| line.strip_prefix("const ")) {
                let name = line.split([':', ' ']).next().unwrap();
                let Some(value) = value(name).filter(|_| !OF_SHADERS.contains(&name)) else { continue };
                assert_eq!(twins.get(name), Some(&value), "{name} of {}", kernel.name);
                seen.insert(name.to_owned());
            }
            if let Some(room) = source.contains("MAX_PENDING").then(|| value("MAX_PENDING").unwrap()) {
                assert!(room >= f64::from(1 + 3 * MAX_BOUNCES));
            }
        }
        let missing: Vec<_> = twins.keys().filter(|name| !seen.contains(**name)).collect();
        assert!(missing.is_empty(), "no shader has {missing:?}");
    }
}
