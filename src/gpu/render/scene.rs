//! What a picture is rendered of, as words for `shaders/reconstruct/layout.wgsl`: camera, settings, views and their images.

use glam::Vec3;

use crate::image::transfer::Transfer;
use crate::math::Camera;
use crate::reconstruct::active_views::ActiveViews;
use crate::reconstruct::effects::MAX_BOUNCES;
use crate::reconstruct::interpolate::camera_weights;
use crate::reconstruct::light_field::ColorCoding;
use crate::reconstruct::render::{Acceleration, HOLE_DIFFERENCE, HoleFill, RenderSettings};

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
const NO_BOUND: f32 = 1e30;

/// The word of a view that has no image of a face.
const NO_FACE: u32 = u32::MAX;
/// Words of a view for the numbers of its images.
const FACE_WORDS: usize = 8;
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
            ("spare", 3),
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

/// The words of a picture; `place` says where the image of a face of an active view lies, and `pyramid_rows` is
/// [`super::texels::DeviceTexels::pyramid_rows`].
pub fn words(
    views: &ActiveViews<'_>,
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
    scene.extend([pyramid_rows, longest, first, 0, 0, 0]);
    let mut words = SceneWords { scene, views: Vec::new(), faces: Vec::new(), distances_m: Vec::new() };
    put(&mut words.distances_m, &settings.steps.distances_m);
    let mut count = 0;
    for (at, (active, camera_weight)) in views.views.iter().zip(camera_weights(views)).enumerate() {
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
            let origin = place(at, face);
            words.faces.extend(origin.texels);
            words.faces.extend([origin.layer, texels.material.is_some().into()]);
            words.faces.extend(texels.size);
            words.faces.extend(origin.pyramid);
            words.faces.extend([texels.pyramid.levels() as u32, face as u32]);
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
        ColorCoding::Light => (0, 1.0),
        ColorCoding::Codes(tone) => {
            let curve = match tone.transfer {
                Transfer::Srgb => 1,
                Transfer::Linear => 2,
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
    use wgpu::naga;

    use super::*;
    use crate::gpu::kernels::{KERNELS, Kernel};
    use crate::reconstruct::interpolate::DEPTH_EPSILON;

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
            let scene = STRUCTS[0].1;
            for (word, name) in [(FIRST_ROW_WORD, "first_row"), (ROWS_WORD, "rows")] {
                let at = scene.iter().position(|(field, _)| *field == name).unwrap();
                assert_eq!(scene[..at].iter().map(|field| field.1).sum::<usize>(), word);
            }
        }
    }

    #[test]
    fn constants_are_those_of_the_cpu() {
        let mut seen = 0;
        for kernel in KERNELS.iter().filter(renders) {
            let module = naga::front::wgsl::parse_str(&kernel.source()).unwrap();
            let value = |name: &str| {
                let found = module.constants.iter().find(|(_, found)| found.name.as_deref() == Some(name)).unwrap().1;
                match module.global_expressions[found.init] {
                    naga::Expression::Literal(naga::Literal::F32(value)) => f64::from(value),
                    naga::Expression::Literal(naga::Literal::AbstractFloat(value)) => value,
                    naga::Expression::Literal(naga::Literal::U32(value)) => value.into(),
                    ref other => panic!("{name}: {other:?}"),
                }
            };
            assert_eq!(value("DEPTH_EPSILON") as f32, DEPTH_EPSILON);
            assert_eq!(value("NO_FACE"), f64::from(NO_FACE));
            assert_eq!(value("UNKNOWN"), f64::from(f32::INFINITY.to_bits()));
            assert_eq!(value("MIN_POSITIVE") as f32, f32::MIN_POSITIVE);
            seen += 1;
        }
        assert!(seen > 0);
    }
}
