//! What a picture is rendered of, as words for `shaders/march/layout.wgsl`: camera, settings, views and their images.

use glam::Vec3;

use crate::evaluate::rendered_image::HoleFill;
use crate::image::transfer::Transfer;
use crate::march::active_views::ActiveViews;
use crate::march::interpolate::camera_weights;
use crate::march::pyramid::DepthPyramid;
use crate::march::settings::{Acceleration, RenderSettings};
use crate::march::shading::HOLE_DIFFERENCE;
use crate::march::specular::secondary_rays::MAX_BOUNCES;
use crate::march::specular::sphere_fit::GlassBalls;
use crate::math::Camera;
use crate::views::light_field::ColorCoding;

/// Where an image lies on the device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Origin {
    /// Column and row of its first texel.
    pub texels: [u32; 2],
    /// Column and row at which its pyramid begins, in textures of their own.
    pub pyramid: [u32; 2],
    /// The layer of both.
    pub layer: u32,
}

/// What stands for the inverse of no distance at all: shaders have no infinity.
pub const NO_BOUND: f32 = 1e30;

/// The word of a view that has no image of a face.
const NO_FACE: u32 = u32::MAX;
/// Words of a view for the numbers of its images.
const FACE_WORDS: usize = 8;
/// Colours are linear light.
const CODING_LIGHT: u32 = 0;
/// Colours are codes of sRGB.
const CODING_SRGB: u32 = 1;
/// Colours are codes of light.
const CODING_LINEAR: u32 = 2;
/// Word of a scene that says the first row of a dispatch.
pub const FIRST_ROW_WORD: usize = 11;
/// Word of a scene that says how many rows a dispatch has.
pub const ROWS_WORD: usize = 21;

/// Structs of the shader, and of each member its name and the words from it to the next.
pub const STRUCTS: [(&str, &[(&str, usize)]); 3] = [
    (
        "Scene",
        &[
            ("forward", 3),
            ("width", 1),
            ("right", 3),
            ("height", 1),
            ("down", 3),
            ("first_row", 1),
            ("samples", 1),
            ("view_count", 1),
            ("distance_count", 1),
            ("refine", 1),
            ("hole_difference", 1),
            ("fill_holes", 1),
            ("coding", 1),
            ("gain", 1),
            ("max_bounces", 1),
            ("rows", 1),
            ("pyramid_rows", 1),
            ("longest_segment", 1),
            ("first_segment", 1),
            ("ball_count", 1),
            ("near_m", 1),
            ("far_m", 1),
        ],
    ),
    (
        "View",
        &[
            ("from_eye", 3),
            ("near_m", 1),
            ("turn_x", 3),
            ("camera_weight", 1),
            ("turn_y", 3),
            ("greatest_inverse_depth", 1),
            ("turn_z", 3),
            ("spare", 1),
            ("faces", FACE_WORDS),
        ],
    ),
    (
        "Face",
        &[
            ("column", 1),
            ("row", 1),
            ("layer", 1),
            ("has_material", 1),
            ("width", 1),
            ("height", 1),
            ("pyramid_column", 1),
            ("pyramid_row", 1),
            ("levels", 1),
            ("number", 1),
            ("scale", 2),
            ("centre", 2),
        ],
    ),
];

/// Words of a view from one to the next.
pub const VIEW_WORDS: usize = 24;
/// Word of a view that says its greatest inverse depth.
pub const GREATEST_WORD: usize = 11;

/// Words of all that a kernel is told beside texels.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneWords {
    /// One `Scene`.
    pub scene: Vec<u32>,
    /// A `View` for each active view.
    pub views: Vec<u32>,
    /// A `Face` for each image of an active view.
    pub faces: Vec<u32>,
    /// The distances at which rays are looked at, in metres.
    pub distances_m: Vec<u32>,
}

/// The words of a picture; `place` says where the image of a probe's face lies, and `pyramid_rows` is
/// [`super::texels::DeviceTexels::pyramid_rows`].
pub fn words(
    (views, glass): (&ActiveViews<'_>, &GlassBalls),
    camera: &Camera,
    settings: &RenderSettings,
    pyramid_rows: u32,
    place: impl Fn(usize, usize) -> Origin,
) -> SceneWords {
    let mut scene = scene(views, camera, settings);
    let points = settings.steps.distances_m.len().next_power_of_two() as u32;
    let [longest, first] = match settings.acceleration {
        Acceleration::None => [1, 1],
        Acceleration::Pyramid => [points, (points / 4).max(1)],
    };
    // Shaders have no infinity.
    let [near_m, far_m] = camera.depth_m().map(|metres| (metres as f32).min(f32::MAX).to_bits());
    scene.extend([pyramid_rows, longest, first, glass.balls.len() as u32, near_m, far_m]);
    let mut words = SceneWords { scene, views: Vec::new(), faces: Vec::new(), distances_m: Vec::new() };
    put(&mut words.distances_m, &settings.steps.distances_m);
    let mut count = 0;
    let from_balls = glass.balls.iter().map(|ball| (ball.around(), 1.0));
    for (active, camera_weight) in views.views.iter().cloned().zip(camera_weights(views)).chain(from_balls) {
        let turn = active.probe_from_world;
        for (axis, last) in [
            (active.from_eye, active.view.near_m),
            (turn.x_axis, camera_weight),
            (turn.y_axis, active.greatest_inverse_depth.min(NO_BOUND)),
            (turn.z_axis, 0.0),
        ] {
            put_axis(&mut words.views, axis, last.to_bits());
        }
        let mut numbers = [NO_FACE; FACE_WORDS];
        for (face, texels) in active.view.faces.iter().enumerate() {
            let Some(texels) = texels else { continue };
            numbers[face] = count;
            count += 1;
            let origin = place(active.view.probe, face);
            words.faces.extend(origin.texels);
            words.faces.extend([origin.layer, texels.material.is_some().into()]);
            words.faces.extend(texels.size);
            words.faces.extend(origin.pyramid);
            // A device that decodes has all levels, and the CPU none.
            let levels = match texels.is_on_device() {
                true => DepthPyramid::sizes(texels.size).len(),
                false => active.pyramids.face(face).levels(),
            };
            words.faces.extend([levels as u32, face as u32]);
            put(&mut words.faces, texels.scale.as_slice());
            put(&mut words.faces, texels.centre.as_slice());
        }
        words.views.extend(numbers);
    }
    words
}

fn scene(views: &ActiveViews<'_>, camera: &Camera, settings: &RenderSettings) -> Vec<u32> {
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
    let [width, height] = settings.size;
    let mut out = Vec::new();
    put_axis(&mut out, forward.as_vec3(), width);
    put_axis(&mut out, (right * half_right).as_vec3(), height);
    put_axis(&mut out, (down * half_down).as_vec3(), 0);
    let count = |length: usize| length as u32;
    out.extend([settings.samples.max(1), count(views.views.len()), count(settings.steps.distances_m.len())]);
    out.extend([settings.steps.refine, (HOLE_DIFFERENCE + settings.steps.unsure()).to_bits()]);
    out.extend([
        u32::from(settings.holes == HoleFill::Nearest),
        coding,
        gain.to_bits(),
        settings.max_bounces.min(MAX_BOUNCES),
        0,
    ]);
    out
}

fn put(out: &mut Vec<u32>, values: &[f32]) {
    out.extend(values.iter().map(|value| value.to_bits()));
}

fn put_axis(out: &mut Vec<u32>, axis: Vec3, last: u32) {
    put(out, &axis.to_array());
    out.push(last);
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use wgpu::naga;

    use super::*;
    use crate::gpu::kernels::{KERNELS, Kernel};
    use crate::gpu::render::{COUNTED, COUNTERS, TILE};
    use crate::image::cube::Face;
    use crate::march::interpolate::DEPTH_EPSILON;
    use crate::march::pyramid;
    use crate::march::ray;
    use crate::march::segments;
    use crate::march::specular::material;
    use crate::march::specular::normal;
    use crate::march::specular::secondary_rays;
    use crate::march::specular::solid;
    use crate::march::specular::sphere_fit;
    use crate::streams::convert::IOR_RANGE;
    use crate::views::light_field::{BACKGROUND, UNKNOWN};

    fn renders(kernel: &&&Kernel) -> bool {
        kernel.entry == "render"
    }

    #[test]
    fn structs_are_those_of_wgsl() {
        for kernel in KERNELS.iter().filter(renders) {
            let module = naga::front::wgsl::parse_str(&kernel.source()).unwrap();
            for (name, fields) in STRUCTS {
                let found = module.types.iter().find(|(_, found)| found.name.as_deref() == Some(name)).unwrap().1;
                let naga::TypeInner::Struct { members, span } = &found.inner else { panic!("{name}") };
                let wgsl: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
                let mut offset = 0;
                let place = |(field, words): &(&'static str, usize)| {
                    offset += 4 * words;
                    (*field, offset - 4 * words)
                };
                let rust: Vec<_> = fields.iter().map(place).collect();
                assert_eq!(wgsl, rust, "{name} of {}", kernel.name);
                assert_eq!(*span as usize, offset, "{name}");
            }
            let view = STRUCTS[1].1;
            let at = view.iter().position(|(field, _)| *field == "greatest_inverse_depth").unwrap();
            assert_eq!(view[..at].iter().map(|field| field.1).sum::<usize>(), GREATEST_WORD);
            assert_eq!(view.iter().map(|field| field.1).sum::<usize>(), VIEW_WORDS);
            let scene = STRUCTS[0].1;
            for (word, name) in [(FIRST_ROW_WORD, "first_row"), (ROWS_WORD, "rows")] {
                let at = scene.iter().position(|(field, _)| *field == name).unwrap();
                assert_eq!(scene[..at].iter().map(|field| field.1).sum::<usize>(), word);
            }
        }
    }

    /// Constants of shaders that the CPU has too.
    fn twins() -> Vec<(&'static str, f64)> {
        let numbers = [
            ("VIEW_FACE", Face::View as u32),
            ("NO_FACE", NO_FACE),
            ("CODING_LIGHT", CODING_LIGHT),
            ("CODING_SRGB", CODING_SRGB),
            ("CODING_LINEAR", CODING_LINEAR),
            ("BACKGROUND", BACKGROUND.to_bits()),
            ("UNKNOWN", UNKNOWN.to_bits()),
            ("TILE", TILE),
            ("COUNTERS", COUNTERS as u32),
            ("MAX_INSIDE", solid::MAX_INSIDE as u32),
            ("MOST_BEFORE_STEPS", ray::MOST_BEFORE_STEPS),
        ];
        let floats = [
            ("DEPTH_EPSILON", DEPTH_EPSILON),
            ("GROWTH", ray::GROWTH),
            ("MIN_POSITIVE", f32::MIN_POSITIVE),
            ("ROUNDING", segments::ROUNDING),
            ("SURELY_BELOW_ONE", segments::SURELY_BELOW_ONE),
            ("LEAST_M", pyramid::LEAST_M),
            ("LEAST_WEIGHT", material::LEAST_WEIGHT),
            ("CLEAR", material::CLEAR),
            ("LEAST_IOR", IOR_RANGE[0]),
            ("GREATEST_IOR", IOR_RANGE[1]),
            ("SAME_SURFACE", normal::SAME_SURFACE),
            ("FIT_NEAR", normal::FIT[0]),
            ("FIT_FAR", normal::FIT[1]),
            ("SAME_PATCH", normal::SAME_PATCH),
            ("SAME_MATERIAL", normal::SAME_MATERIAL as f32),
            ("FLAT", solid::FLAT),
            ("BEHIND_TEXELS", solid::BEHIND_TEXELS),
            ("NEAR_BALL", sphere_fit::NEAR_BALL),
            ("LEAST_SHARE", secondary_rays::LEAST_SHARE),
            ("LIFT_TEXELS", secondary_rays::LIFT_TEXELS),
            ("HIDDEN_TEXELS", secondary_rays::HIDDEN_TEXELS),
        ];
        let counted = (0..).zip(COUNTED).map(|(at, (name, _))| (name, f64::from(at)));
        let numbers = numbers.into_iter().map(|(name, value)| (name, value.into()));
        numbers.chain(floats.into_iter().map(|(name, value)| (name, value.into()))).chain(counted).collect()
    }

    /// Constants that shaders have for themselves: what stands for an enum or for nothing, and lengths that floats set.
    const OF_SHADERS: [&str; 12] = [
        "ALL_VIEWS",
        "OPEN",
        "BEHIND",
        "NOT_KNOWN",
        "FOUND_NOTHING",
        "FOUND_LIGHT",
        "FOUND_SURFACE",
        "MOST_PENDING",
        "NO_TEXEL",
        "NO_LIMIT_M",
        "LEAST_LENGTH",
        "LEAST_INVERTIBLE_M",
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
                // Those without a type are gone when the text is read.
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
            if let Some(room) = source.contains("MOST_PENDING").then(|| value("MOST_PENDING").unwrap()) {
                assert!(room >= f64::from(1 + 3 * MAX_BOUNCES));
            }
        }
        let missing: Vec<_> = twins.keys().filter(|name| !seen.contains(**name)).collect();
        assert!(missing.is_empty(), "no shader has {missing:?}");
    }
}
