use std::sync::Arc;

use glam::Vec2;

use super::super::mesh::MeshMaterial;
use super::super::numbers::Numbers;
use super::super::texture::{ImageTexture, Wrap};
use super::*;

/// The same answers by trying all triangles.
fn plainly(bvh: &MeshBvh, ray: &Ray, min_distance: f64) -> Option<MeshHit> {
    let frame = RayFrame::new(ray);
    let mut best: Option<MeshHit> = None;
    for leaf in &bvh.leaves {
        let Some((distance, barycentric)) = frame.meet(&leaf.corners) else { continue };
        let triangle = leaf.triangle as usize;
        let first = best.is_none_or(|best| (distance, triangle) < (best.distance, best.triangle));
        if first && distance > min_distance && !bvh.hole(leaf, barycentric) {
            best = Some(MeshHit { distance, triangle, barycentric });
        }
    }
    best
}

fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let material_of = vec![0; triangles.len()];
    Mesh { positions, triangles, material_of, materials: [MeshMaterial::default()].into(), ..Mesh::default() }
}

/// Triangles of all sizes anywhere in a cube, and some that share corners.
fn soup(count: u32, seed: u64) -> Mesh {
    let mut numbers = Numbers::new(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let (middle, size) = (numbers.point(), 10.0_f64.powf(1.5 * numbers.next() - 1.5));
        positions.extend([(); 3].map(|()| middle + size * numbers.point()));
    }
    mesh(positions, (0..count).map(|i| [3 * i, 3 * i + 1, if i % 5 == 4 { 3 * i - 1 } else { 3 * i + 2 }]).collect())
}

/// A closed surface around the origin: a ball whose radius varies, by subdivided octahedra.
fn pebble(levels: u32) -> Mesh {
    let mut positions = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let bump = |p: DVec3| p * (1.0 + 0.2 * (5.0 * p.x).sin() * (4.0 * p.y + p.z).cos());
    mesh(positions.into_iter().map(bump).collect(), triangles)
}

#[test]
fn tree_and_plain_search_agree_to_the_bit() {
    for (scale, shift) in
        [(1.0, DVec3::ZERO), (1e-6, DVec3::new(3e-6, 0.0, 1e-6)), (1e6, DVec3::ZERO), (1.0, DVec3::splat(1e6))]
    {
        let mut triangles = soup(400, 3);
        for position in &mut triangles.positions {
            *position = scale * *position + shift;
        }
        let bvh = MeshBvh::new(triangles);
        let mut numbers = Numbers::new(8);
        let mut hits = 0;
        for turn in 0..6000 {
            let target = shift + scale * numbers.point();
            let reach = [0.5, 3.0, 1e3, 1e7][turn % 4];
            let origin = shift + scale * reach * numbers.point();
            let Some(ray) = Ray::new(origin, target - origin) else { continue };
            let from = if turn % 3 == 0 { 0.4 * (target - origin).length() } else { 0.0 };
            let expected = plainly(&bvh, &ray, from);
            assert_eq!(bvh.nearest(&ray, from), expected, "{scale} {shift} {turn}");
            hits += usize::from(expected.is_some());
            let [below, above] = expected.map_or([1.0, 1.0], |hit| [hit.distance * 0.999, hit.distance * 1.001]);
            assert_eq!(bvh.occluded(&ray, from, f64::INFINITY), expected.is_some());
            assert!(!bvh.occluded(&ray, from, below) || from > below);
            assert_eq!(bvh.occluded(&ray, from, above), expected.is_some_and(|hit| hit.distance < above));
        }
        assert!(hits > 3000, "{hits}");
    }
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn tree_and_plain_search_agree_on_files() {
    let meshes = std::path::Path::new(option_env!("LIGHTFOLD_DATA").unwrap_or("no data")).join("meshes");
    for file in ["sponza.glb", "dragon.glb", "bunny.obj"] {
        let (model, _) = super::super::Model::open(&meshes.join(file)).unwrap();
        let moment = model.at(0.0);
        let bounds = moment.bounds().unwrap();
        let mut numbers = Numbers::new(7);
        let mut anywhere = || 0.5 * (bounds.min + bounds.max) + 0.5 * (bounds.max - bounds.min) * numbers.point();
        let mut hits = 0;
        for bvh in moment.meshes() {
            for _ in 0..60 {
                let (from, to) = (anywhere(), anywhere());
                let ray = Ray::new(from, to - from).unwrap();
                let expected = plainly(bvh, &ray, 0.0);
                assert_eq!(bvh.nearest(&ray, 0.0), expected, "{file} {from} {to}");
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits > 10, "{file}: {hits}");
    }
}

#[test]
fn axis_parallel_rays_and_negative_zeros_miss_nothing() {
    let bvh = MeshBvh::new(pebble(4));
    let mut numbers = Numbers::new(2);
    for _ in 0..1000 {
        let [x, y] = [0.5 * numbers.next(), 0.5 * numbers.next()];
        for sign in [0.0, -0.0, 1e-320, -1e-50, -1e-9, 1e-8] {
            let ray = Ray::new(DVec3::new(x, y, -4.0), DVec3::new(sign, -sign, 1.0)).unwrap();
            assert_eq!(bvh.nearest(&ray, 0.0), plainly(&bvh, &ray, 0.0));
            assert!(bvh.nearest(&ray, 0.0).is_some());
        }
    }
}

#[test]
fn a_million_rays_at_edges_and_corners_leave_no_gap() {
    for (scale, shift, rays) in [
        (1.0, DVec3::ZERO, 700_000),
        (1e-6, DVec3::ZERO, 100_000),
        (1e6, DVec3::ZERO, 100_000),
        (1.0, DVec3::splat(1e6), 100_000),
    ] {
        let mut closed = pebble(6);
        for position in &mut closed.positions {
            *position = scale * *position + shift;
        }
        let bvh = MeshBvh::new(closed);
        let triangles = bvh.mesh().triangles.len();
        assert_eq!(triangles, 32_768);
        let mut numbers = Numbers::new(5);
        let mut leaks = 0;
        for turn in 0..rays {
            let [a, b, _] = bvh.mesh().corners(turn % triangles);
            let share = match turn % 3 {
                0 => 0.0,
                1 => 0.5,
                _ => 0.5 + 0.5 * numbers.next(),
            };
            let target = a + share * (b - a);
            // From inside, and from outside towards it.
            let near = if turn % 2 == 0 { shift } else { 3.0 * target - 2.0 * shift };
            let origin = near + 0.3 * scale * numbers.point();
            let ray = Ray::new(origin, target - origin).unwrap();
            leaks += usize::from(bvh.nearest(&ray, 0.0).is_none());
            leaks += usize::from(!bvh.occluded(&ray, 0.0, f64::INFINITY));
        }
        assert_eq!(leaks, 0, "{scale} {shift}");
    }
}

#[test]
fn equal_distances_go_to_the_lowest_index() {
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let bvh = MeshBvh::new(mesh(corners, vec![[0, 1, 2]; 5000]));
    let ray = Ray::new(DVec3::new(0.2, 0.3, 2.0), DVec3::NEG_Z).unwrap();
    assert_eq!(bvh.nearest(&ray, 0.0).unwrap().triangle, 0);
}

#[test]
fn what_is_not_finite_or_has_no_area_is_never_met() {
    let positions = vec![
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        DVec3::NAN,
        DVec3::new(f64::INFINITY, 0.0, 0.0),
        DVec3::X * 2.0,
        DVec3::X * 1e300,
    ];
    let broken = vec![[0, 1, 3], [0, 4, 2], [0, 1, 5], [1, 1, 1], [0, 6, 2]];
    let ray = Ray::new(DVec3::new(0.2, 0.0, 2.0), DVec3::NEG_Z).unwrap();
    let bvh = MeshBvh::new(mesh(positions.clone(), broken.clone()));
    assert_eq!((bvh.nearest(&ray, 0.0), bvh.bounds()), (None, None));
    let bvh = MeshBvh::new(mesh(positions, [broken, vec![[0, 1, 2]]].concat()));
    assert_eq!(bvh.nearest(&ray, 0.0).unwrap().triangle, 5);
    assert_eq!(bvh.bounds(), Some(AxisBox { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) }));
    let empty = MeshBvh::new(Mesh::default());
    assert_eq!(empty.nearest(&ray, 0.0), None);
    assert!(!empty.occluded(&ray, 0.0, f64::INFINITY));
}

#[test]
fn from_the_surface_itself_and_from_very_far() {
    let bvh = MeshBvh::new(pebble(3));
    let mut numbers = Numbers::new(4);
    for turn in 0..2000 {
        let corners = bvh.mesh().corners(turn % bvh.mesh().triangles.len());
        let on = (corners[0] + corners[1] + corners[2]) / 3.0;
        let ray = Ray::new(on, numbers.point()).unwrap();
        for from in [0.0, 1e-12, 1e-6, 1e-4, 2e-4] {
            assert_eq!(bvh.nearest(&ray, from), plainly(&bvh, &ray, from), "{turn} {from}");
        }
        let far = Ray::new(on - 1e12 * ray.direction(), ray.direction()).unwrap();
        assert_eq!(bvh.nearest(&far, 0.0), plainly(&bvh, &far, 0.0));
        let farthest = Ray::new(DVec3::splat(1e308), -ray.direction()).unwrap();
        assert!(bvh.nearest(&farthest, 0.0).is_none_or(|hit| hit.distance.is_finite()));
    }
}

#[test]
fn glass_stops_rays_but_not_light_and_holes_stop_neither() {
    let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let behind: Vec<DVec3> = square.iter().map(|corner| corner - DVec3::Z).collect();
    let with = |material: MeshMaterial| {
        let mut mesh =
            mesh([square.clone(), behind.clone()].concat(), vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
        mesh.uvs = vec![Vec2::ZERO; 8];
        mesh.material_of = vec![0, 0, 1, 1];
        mesh.materials = [material, MeshMaterial::default()].into();
        MeshBvh::new(mesh)
    };
    let ray = Ray::new(DVec3::new(0.7, 0.2, 1.0), DVec3::NEG_Z).unwrap();
    let sees = |bvh: &MeshBvh| bvh.nearest(&ray, 0.0).unwrap().triangle;
    let holes = |alpha| MeshMaterial { alpha, alpha_cutoff: Some(0.5), ..MeshMaterial::default() };
    assert_eq!(sees(&with(holes(0.6))), 0);
    assert_eq!(sees(&with(holes(0.4))), 2);
    assert!(!with(holes(0.4)).occluded(&ray, 0.0, 1.5));
    assert!(with(holes(0.4)).occluded(&ray, 0.0, 2.5));
    let texture = Arc::new(ImageTexture { width: 1, height: 1, pixels: vec![[255; 4]], wrap: [Wrap::Repeat; 2] });
    assert_eq!(sees(&with(MeshMaterial { base_texture: Some(texture), ..holes(0.6) })), 0);
    let glass = with(MeshMaterial { optics: Optics::Glass { ior: 1.5, tint: DVec3::ONE }, ..MeshMaterial::default() });
    assert_eq!(sees(&glass), 0);
    assert!(glass.occluded(&ray, 0.0, 1.5));
    assert!(!glass.stopped(&ray, [0.0, 1.5], Stops::Opaque));
    assert!(glass.stopped(&ray, [0.0, 2.5], Stops::Opaque));
}
