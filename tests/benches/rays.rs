//! Ray casting speed on one thread: camera rays, shadow rays towards the sun, random rays, visibility between two points, and
//! shaded camera rays.
//!
//! `cargo bench --bench rays` builds the bounding volume hierarchies of a generated landscape of a quarter of a million triangles
//! and, if `LIGHTFOLD_DATA` (or `../shared/data`) contains it, of `meshes/sponza.glb`. Camera rays are those of a cube map at the
//! centre of the scene, face by face, at three sizes; rays per second should not depend on the size. Shadow rays start at the
//! hits of the camera rays. Speeds are medians over `TURNS` runs, in millions of rays per second.

mod clock;

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use clock::Clock;
use glam::{DVec3, Vec3};
use scene::mesh::{Mesh, Ray};
use scene::{Light, MeshMaterial, Play, Scene, SceneAtTime, SceneMesh};

/// Face widths in pixels.
const SIZES: [u32; 3] = [256, 512, 1024];
/// Number of runs of each measurement.
const TURNS: usize = 5;
/// Number of random rays, and of visibility queries between two points.
const RANDOM: usize = 200_000;
/// Number of squares along each side of the landscape; each has two triangles.
const SQUARES: u32 = 354;

fn main() {
    println!(
        "{:<10} {:>9} {:>7}   camera {:>5} {:>6} {:>6}   {:>6} {:>6} {:>6} {:>6}",
        "scene", "triangles", "build s", "256", "512", "1024", "shadow", "random", "sees", "shaded"
    );
    let start = Instant::now();
    let tree = SceneMesh::new(landscape(), [MeshMaterial::default()].into());
    let seconds = start.elapsed().as_secs_f64();
    let scene = SceneAtTime::with_meshes(vec![], vec![tree.into()], Light::default());
    measure("landscape", &scene, seconds);
    let folder = std::env::var_os("LIGHTFOLD_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    match Scene::open(&folder.join("meshes/sponza.glb").to_string_lossy(), Play::All) {
        Ok((scene, _)) => {
            let moment = scene.at(0.0);
            let start = Instant::now();
            for mesh in &moment.meshes {
                black_box(SceneMesh::new(mesh.mesh.clone(), mesh.materials.clone()));
            }
            measure("sponza.glb", &moment, start.elapsed().as_secs_f64());
        }
        Err(error) => println!("sponza.glb is not measured: {error}"),
    }
}

fn measure(name: &str, scene: &SceneAtTime, build_seconds: f64) {
    let Some(bounds) = scene.bounds else { return println!("{name} is empty") };
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.mesh.triangles.len()).sum();
    let eye = 0.5 * (bounds.min + bounds.max);
    print!("{name:<10} {triangles:>9} {build_seconds:>7.2}          ");
    let speed = |count: usize, seconds: f64| count as f64 / seconds / 1e6;
    for size in SIZES {
        let rays = camera(eye, size);
        let seconds = median(|| rays.iter().filter(|ray| scene.first_hit(ray, []).is_some()).count());
        print!("{:>6.2} ", speed(rays.len(), seconds));
    }
    let rays = camera(eye, SIZES[0]);
    let hits: Vec<DVec3> =
        rays.iter().filter_map(|ray| scene.first_hit(ray, []).map(|hit| ray.at(hit.distance))).collect();
    let sun = Light::default().suns[0].direction;
    let to_sun: Vec<Ray> = hits.iter().filter_map(|&at| Ray::new(at, sun)).collect();
    let seconds = median(|| {
        let dark = |ray: &&Ray| scene.meshes.iter().any(|mesh| mesh.occluded(ray, 1e-4..f64::INFINITY));
        to_sun.iter().filter(dark).count()
    });
    print!("  {:>6.2} ", speed(to_sun.len(), seconds));
    let mut random = random();
    let mut anywhere = || bounds.min + (bounds.max - bounds.min) * DVec3::from_array([(); 3].map(|()| random()));
    let ends: Vec<[DVec3; 2]> = (0..RANDOM).map(|_| [anywhere(), anywhere()]).collect();
    let rays_anywhere: Vec<Ray> = ends.iter().filter_map(|[from, to]| Ray::new(*from, *to - *from)).collect();
    let seconds = median(|| rays_anywhere.iter().filter(|ray| scene.first_hit(ray, []).is_some()).count());
    print!("{:>6.2} ", speed(rays_anywhere.len(), seconds));
    let seconds = median(|| hits.iter().zip(&ends).filter(|(hit, ends)| scene.sees(ends[0], **hit)).count());
    print!("{:>6.2} ", speed(hits.len().min(RANDOM), seconds));
    let seconds = median(|| rays.iter().map(|ray| scene.trace(ray, []).color).sum::<DVec3>().x as usize);
    println!("{:>6.2}", speed(rays.len(), seconds));
}

/// Returns the rays of a cube map, face by face and row by row.
fn camera(eye: DVec3, size: u32) -> Vec<Ray> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut rays = Vec::new();
    for face in 0..6 {
        let forward = if face % 2 == 0 { axes[face / 2] } else { -axes[face / 2] };
        let (right, down) = (axes[(face / 2 + 1) % 3], axes[(face / 2 + 2) % 3]);
        let at = |pixel: u32| 2.0 * (f64::from(pixel) + 0.5) / f64::from(size) - 1.0;
        for row in 0..size {
            rays.extend((0..size).filter_map(|col| Ray::new(eye, forward + at(col) * right + at(row) * down)));
        }
    }
    rays
}

/// Returns hills in a bowl, ten metres wide.
fn landscape() -> Mesh {
    let mut mesh = Mesh::default();
    let side = SQUARES + 1;
    for row in 0..side {
        for col in 0..side {
            let [x, z] = [col, row].map(|at| 10.0 * f64::from(at) / f64::from(SQUARES) - 5.0);
            let y = 0.4 * (3.0 * x).sin() * (2.0 * z).cos() + 0.1 * (11.0 * x + 7.0 * z).sin() + 0.15 * (x * x + z * z);
            mesh.positions.push(DVec3::new(x, y, z));
            mesh.normals.push(Vec3::Y);
        }
    }
    for row in 0..SQUARES {
        for col in 0..SQUARES {
            let a = row * side + col;
            mesh.triangles.extend([[a, a + side, a + 1], [a + 1, a + side, a + side + 1]]);
        }
    }
    mesh.material_of = vec![0; mesh.triangles.len()];
    mesh
}

/// Returns a generator of pseudo-random numbers in 0..1 with a fixed seed.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn median<T>(mut turn: impl FnMut() -> T) -> f64 {
    let mut seconds: Vec<f64> = (0..TURNS)
        .map(|_| {
            let start = Clock::start();
            black_box(turn());
            start.seconds()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[TURNS / 2]
}
