//! Compares `project` of shaders/march/light_field.wgsl with `View::project` and with the image model.

use codec::image::transfer::ToneMap;
use codec::image::{Face, ImageProjection, TexelMap};
use glam::{DMat3, DVec3, Vec3};
use gpu::Gpu;
use gpu::harness::groups;
use kernels::{Binding, BindingKind, Kernel, ShaderFile};
use libtest_mimic::Failed;
use render::views::light_field::{ColorCoding, FaceTexels, View};

const NO_FACE: u32 = u32::MAX;
const POINTS: u32 = 20_000;
/// Maximum error of positions relative to the image's side, and of depths, relative: GPU divisions have errors of up to 2.5 ulp.
const BOUND: f64 = 2e-6;

const ENTRY: &str = "
@group(0) @binding(3) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> places: array<vec4<u32>>;
@compute @workgroup_size(64)
fn project_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x < arrayLength(&points)) {
        let found = project(u32(points[id.x].w), points[id.x].xyz);
        places[id.x] = vec4(found.face, bitcast<vec2<u32>>(found.at), bitcast<u32>(found.inverse_depth));
    }
}
";

const fn binding(name: &'static str, kind: BindingKind) -> Binding {
    Binding { name, kind }
}

/// The entry point does not use the textures of the shader, whose bindings are 4 and 5.
static PROJECT: Kernel = Kernel {
    name: "project-points",
    entry: "project_points",
    files: &[
        ShaderFile { path: "march/layout.wgsl", text: include_str!("../../shaders/march/layout.wgsl") },
        ShaderFile { path: "march/light_field.wgsl", text: include_str!("../../shaders/march/light_field.wgsl") },
        ShaderFile { path: "project_points.wgsl", text: ENTRY },
    ],
    bindings: &[
        binding("scene", BindingKind::ReadOnlyStorage),
        binding("views", BindingKind::ReadOnlyStorage),
        binding("faces", BindingKind::ReadOnlyStorage),
        binding("points", BindingKind::ReadOnlyStorage),
        binding("places", BindingKind::Storage),
    ],
    workgroup: 64,
    reader: None,
};

/// Returns a view with these faces; `intrinsics` are those of a perspective image.
fn view(faces: &[Face], size: [u32; 2], intrinsics: [f64; 4]) -> View {
    let coding = ColorCoding::Codes(ToneMap::default());
    let mut view = View {
        name: "v".into(),
        probe: 0,
        position: DVec3::ZERO,
        probe_from_world: DMat3::IDENTITY,
        near_m: 0.1,
        far_m: 100.0,
        faces: Default::default(),
    };
    for &face in faces {
        view.faces[face as usize] = Some(FaceTexels::unknown(size, TexelMap::of_face(face, size, intrinsics), coding));
    }
    view
}

/// Returns points in all directions, some on edges and corners of the cube.
fn points() -> Vec<Vec3> {
    let point = |at: u32| {
        let part = |prime: u32| ((at * prime) % 2003) as f32 / 1001.5 - 1.0;
        let mut point = Vec3::new(part(7), part(11), part(13));
        if at.is_multiple_of(5) {
            point[at as usize % 3] = point[(at as usize + 1) % 3];
        }
        point * [0.01, 1.0, 37.0][at as usize % 3]
    };
    (1..=POINTS).map(point).filter(|point| *point != Vec3::ZERO).collect()
}

/// Returns the words of views and of their faces, in the layout of `layout.wgsl`.
fn words(views: &[View]) -> [Vec<u32>; 2] {
    let (mut all, mut faces) = (Vec::new(), Vec::new());
    let mut rows = 0;
    for view in views {
        all.extend([0; 16]);
        let mut row = [NO_FACE; 8];
        for (number, texels) in view.faces.iter().enumerate() {
            let Some(texels) = texels else { continue };
            row[number] = rows;
            rows += 1;
            faces.extend([0, 0, 0, 0, texels.size[0], texels.size[1], 0, 0, 0, number as u32]);
            faces.extend(texels.map.scale.iter().chain(&texels.map.centre).map(|value| value.to_bits()));
            // No alpha image.
            faces.extend([0, 0]);
        }
        all.extend(row);
    }
    [all, faces]
}

pub fn agrees_with_the_model(gpu: &Gpu) -> Result<(), Failed> {
    let size = [48, 33];
    let intrinsics = [40.0, 41.0, 55.0, 12.0];
    let views = [
        view(&Face::CUBE, [64, 64], intrinsics),
        view(&Face::CUBE[..4], [33, 33], intrinsics),
        view(&[Face::View], size, intrinsics),
    ];
    let points = points();
    let [view_words, face_words] = words(&views);
    let asked: Vec<(usize, Vec3)> = points.iter().flat_map(|point| [0, 1, 2].map(|view| (view, *point))).collect();
    let point_words: Vec<u32> =
        asked.iter().flat_map(|(view, point)| [point.x, point.y, point.z, *view as f32].map(f32::to_bits)).collect();
    let said = |error: lightfold::Error| error.to_string();
    let pipeline = gpu.pipeline(&PROJECT).map_err(said)?;
    let mut buffers = Vec::new();
    for words in [vec![0; 32], view_words, face_words, point_words.clone(), vec![0; point_words.len()]] {
        let buffer = gpu.buffer("projection", words.len(), wgpu::BufferUsages::empty()).map_err(said)?;
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
        buffers.push(buffer);
    }
    gpu.guard("projection", || {
        let group = gpu.bind(&pipeline, |name| {
            let at = PROJECT.bindings.iter().position(|binding| binding.name == name)?;
            Some(buffers[at].as_entire_binding())
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let [x, y] = groups((asked.len() as u32).div_ceil(PROJECT.workgroup));
        pass.dispatch_workgroups(x, y, 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    })
    .map_err(said)?;
    let found = gpu.read(&buffers[4], 4 * asked.len()).map_err(said)?;
    let face_rows: Vec<(usize, usize)> = views
        .iter()
        .enumerate()
        .flat_map(|(at, view)| (0..7).filter(|face| view.faces[*face].is_some()).map(move |face| (at, face)))
        .collect();
    let (mut compared, mut worst) = (0, 0f64);
    for (&(view, point), found) in asked.iter().zip(found.chunks(4)) {
        let exact = Face::CUBE.into_iter().chain([Face::View]).find_map(|face| {
            let texels = views[view].faces[face as usize].as_ref()?;
            let model = ImageProjection::of_face(face, texels.size, intrinsics);
            Some((face, texels.size, model.project(point.as_dvec3())?))
        });
        let shown = views[view].project(point);
        // Within rounding of the edge of a perspective image, either implementation may treat a point as outside.
        let at_edge = |at: [f64; 2]| {
            (0..2).any(|axis| at[axis].min(f64::from(size[axis]) - at[axis]) < BOUND * f64::from(size[axis]))
        };
        match (found[0], shown, exact) {
            (NO_FACE, None, None) => {}
            (row, Some(shown), Some((face, size, exact))) if row != NO_FACE => {
                let (_, number) = face_rows[row as usize];
                let at = [found[1], found[2]].map(f32::from_bits);
                let mut error = f64::from((f32::from_bits(found[3]) / shown.inverse_depth - 1.0).abs());
                for axis in 0..2 {
                    let side = f64::from(size[axis]);
                    error = error.max(f64::from((at[axis] - shown.at[axis]).abs()) / side);
                    error = error.max((f64::from(at[axis]) - exact[axis]).abs() / side);
                }
                if number != shown.face || number != face as usize || error > BOUND {
                    return Err(format!("{point} in view {view}: face {number}, {at:?}; {shown:?}, {exact:?}").into());
                }
                worst = worst.max(error);
                compared += 1;
            }
            (_, _, Some((Face::View, _, exact))) if at_edge(exact) => {}
            other => return Err(format!("{point} in view {view}: {other:?}").into()),
        }
    }
    println!("{compared} points, largest error {worst:e} on {}", gpu.info.name);
    if compared > POINTS { Ok(()) } else { Err(format!("only {compared} points were compared").into()) }
}
