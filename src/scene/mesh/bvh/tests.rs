use std::ops::Range;

use super::*;

const AHEAD: Range<f64> = 0.0..f64::INFINITY;

/// Pseudorandom number generator.
pub(crate) struct Numbers(u64);

impl Numbers {
    pub(crate) fn new(seed: u64) -> Self {
        Numbers(seed)
    }

    /// Returns the next number, in −1..1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

/// Returns all hits, found by testing every triangle, ordered by distance and index.
pub(crate) fn brute_force(triangles: &[[DVec3; 3]], ray: &Ray, range: Range<f64>) -> Vec<TriangleHit> {
    let frame = RayFrame::new(ray);
    let mut hits = Vec::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        if is_in_range(corners)
            && triangle::has_area(corners)
            && let Some((distance, barycentric)) = frame.intersect(corners)
            && distance > range.start
            && distance < range.end
        {
            hits.push(TriangleHit { distance, triangle, barycentric });
        }
    }
    hits.sort_by(|a, b| a.distance.partial_cmp(&b.distance).unwrap().then(a.triangle.cmp(&b.triangle)));
    hits
}

fn build(triangles: &[[DVec3; 3]]) -> Bvh {
    Bvh::new(triangles.iter().copied())
}

/// Checks all, nearest and any hit of a ray against brute force, and returns the number of hits.
#[track_caller]
fn check(bvh: &Bvh, triangles: &[[DVec3; 3]], ray: &Ray, range: Range<f64>) -> usize {
    let expected = brute_force(triangles, ray, range.clone());
    assert_eq!(bvh.all(ray, range.clone()), expected, "{ray:?}");
    assert_eq!(bvh.nearest(ray, range.clone(), |_| true), expected.first().copied(), "{ray:?}");
    assert_eq!(bvh.any(ray, range.clone(), |_| true), !expected.is_empty(), "{ray:?}");
    // The hit on another triangle, if the first one is rejected.
    let first = expected.first().map(|hit| hit.triangle);
    let second = expected.iter().find(|hit| Some(hit.triangle) != first).copied();
    assert_eq!(bvh.nearest(ray, range, |hit| Some(hit.triangle) != first), second, "{ray:?}");
    expected.len()
}

/// Triangles of various sizes anywhere in a cube, some of which share corners.
fn soup(count: usize, seed: u64) -> Vec<[DVec3; 3]> {
    let mut numbers = Numbers::new(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let (middle, size) = (numbers.point(), 10.0_f64.powf(1.5 * numbers.next() - 1.5));
        positions.extend([(); 3].map(|()| middle + size * numbers.point()));
    }
    let third = |i: usize| if i % 5 == 4 { 3 * i - 1 } else { 3 * i + 2 };
    (0..count).map(|i| [3 * i, 3 * i + 1, third(i)].map(|corner| positions[corner])).collect()
}

/// A closed surface around the origin: a sphere whose radius varies, made of subdivided octahedra.
fn pebble(levels: u32) -> Vec<[DVec3; 3]> {
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
    triangles.into_iter().map(|corners| corners.map(|corner| bump(positions[corner as usize]))).collect()
}

fn placed(triangles: Vec<[DVec3; 3]>, scale: f64, shift: DVec3) -> Vec<[DVec3; 3]> {
    triangles.into_iter().map(|corners| corners.map(|corner| scale * corner + shift)).collect()
}

#[test]
fn hits_equal_brute_force_at_any_scale_and_place() {
    for (scale, shift) in
        [(1.0, DVec3::ZERO), (1e-6, DVec3::new(3e-6, 0.0, 1e-6)), (1e6, DVec3::ZERO), (1.0, DVec3::splat(1e6))]
    {
        let triangles = placed(soup(400, 3), scale, shift);
        let bvh = build(&triangles);
        let mut numbers = Numbers::new(8);
        let mut hits = 0;
        for turn in 0..6000 {
            let target = shift + scale * numbers.point();
            let origin = shift + scale * [0.5, 3.0, 1e3, 1e7][turn % 4] * numbers.point();
            let Some(ray) = Ray::new(origin, target - origin) else { continue };
            let length = (target - origin).length();
            let range = [0.0..f64::INFINITY, 0.4 * length..f64::INFINITY, -length..0.5 * length][turn % 3].clone();
            hits += usize::from(check(&bvh, &triangles, &ray, range) > 0);
        }
        assert!(hits > 2000, "{hits}");
    }
}

#[test]
fn all_hits_of_nested_coincident_and_degenerate_triangles() {
    let mut numbers = Numbers::new(11);
    let shells = (0..40).flat_map(|shell| placed(pebble(2), 0.1 + 0.05 * f64::from(shell), DVec3::ZERO));
    let copies = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 300];
    let mut degenerate = soup(200, 5);
    for (turn, [a, b, c]) in degenerate.iter_mut().enumerate() {
        match turn % 6 {
            0 => *b = *a,
            1 => (*b, *c) = (*a, *a),
            2 => *c = 2.0 * *b - *a,
            3 => c.y = f64::NAN,
            4 => c.x = f64::INFINITY,
            _ => {}
        }
    }
    let mixed = [degenerate.clone(), copies.clone(), soup(100, 9)].concat();
    for triangles in [shells.collect(), copies, degenerate, mixed, soup(1, 1), vec![]] {
        let bvh = build(&triangles);
        let mut most = 0;
        for turn in 0..1500 {
            let (origin, target) = (2.0 * numbers.point(), 0.5 * numbers.point());
            let Some(ray) = Ray::new(origin, target - origin) else { continue };
            let range = if turn % 2 == 0 { AHEAD } else { -1.5..1.0 };
            most = most.max(check(&bvh, &triangles, &ray, range));
        }
        assert!(triangles.len() < 300 || most >= 10, "{most}");
    }
    let ray = Ray::new(DVec3::new(0.2, 0.3, 2.0), DVec3::NEG_Z).unwrap();
    let hits = build(&[[DVec3::ZERO, DVec3::X, DVec3::Y]; 5]).all(&ray, AHEAD);
    assert_eq!(hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
}

#[test]
fn distances_equal_brute_force() {
    let mut numbers = Numbers::new(21);
    for (scale, shift) in [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1e6, DVec3::splat(-2e6)), (1.0, DVec3::splat(1e6))]
    {
        let mut collinear = soup(100, 2);
        collinear.iter_mut().for_each(|[a, b, c]| *c = 2.0 * *b - *a);
        let copies = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 50];
        for triangles in [soup(500, 7), pebble(3), [collinear, copies].concat(), vec![[DVec3::ONE; 3]], vec![]] {
            let triangles = placed(triangles, scale, shift);
            let bvh = build(&triangles);
            for turn in 0..1200 {
                let point = shift + scale * [0.3, 1.0, 4.0, 1e4, 1e8][turn % 5] * numbers.point();
                let all = triangles.iter().map(|corners| triangle::distance_squared(*corners, point));
                assert_eq!(bvh.distance_m(point), all.fold(f64::INFINITY, f64::min).sqrt(), "{point} {scale} {shift}");
            }
        }
    }
}

#[test]
fn distances_to_plane_edge_and_corner() {
    let bvh = build(&[[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::NAN; 3]]);
    let at = |x: f64, y: f64, z: f64| bvh.distance_m(DVec3::new(x, y, z));
    assert_eq!([at(0.25, 0.25, -3.0), at(0.5, -2.0, 0.0), at(4.0, 0.0, 4.0)], [3.0, 2.0, 5.0]);
    assert_eq!(build(&[]).distance_m(DVec3::ZERO), f64::INFINITY);
    // The distance to a triangle without area is that to its edges.
    assert_eq!(build(&[[DVec3::ZERO, DVec3::X, DVec3::X]]).distance_m(DVec3::Y), 1.0);
}

#[test]
fn axis_parallel_rays_and_negative_zeros_miss_nothing() {
    let triangles = pebble(4);
    let bvh = build(&triangles);
    let mut numbers = Numbers::new(2);
    for _ in 0..1000 {
        let [x, y] = [0.5 * numbers.next(), 0.5 * numbers.next()];
        for sign in [0.0, -0.0, 1e-320, -1e-50, -1e-9, 1e-8] {
            let ray = Ray::new(DVec3::new(x, y, -4.0), DVec3::new(sign, -sign, 1.0)).unwrap();
            assert!(check(&bvh, &triangles, &ray, AHEAD) > 0);
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
        let triangles = placed(pebble(6), scale, shift);
        let bvh = build(&triangles);
        assert_eq!(triangles.len(), 32_768);
        let mut numbers = Numbers::new(5);
        let mut leaks = 0;
        for turn in 0..rays {
            let [a, b, _] = triangles[turn % triangles.len()];
            let share = match turn % 3 {
                0 => 0.0,
                1 => 0.5,
                _ => 0.5 + 0.5 * numbers.next(),
            };
            let target = a + share * (b - a);
            // From inside, and from outside towards the surface.
            let near = if turn % 2 == 0 { shift } else { 3.0 * target - 2.0 * shift };
            let origin = near + 0.3 * scale * numbers.point();
            let ray = Ray::new(origin, target - origin).unwrap();
            leaks += usize::from(bvh.nearest(&ray, AHEAD, |_| true).is_none());
            leaks += usize::from(!bvh.any(&ray, AHEAD, |_| true));
        }
        assert_eq!(leaks, 0, "{scale} {shift}");
    }
}

#[test]
fn triangles_that_are_not_finite_or_have_no_area_are_missed() {
    let huge = DVec3::X * 1e300;
    let broken = [
        [DVec3::ZERO, DVec3::X, DVec3::NAN],
        [DVec3::ZERO, DVec3::X * f64::INFINITY, DVec3::Y],
        [DVec3::ZERO, DVec3::X, DVec3::X * 2.0],
        [DVec3::X; 3],
        [DVec3::ZERO, huge, DVec3::Y],
    ];
    let ray = Ray::new(DVec3::new(0.2, 0.0, 2.0), DVec3::NEG_Z).unwrap();
    let bvh = build(&broken);
    assert_eq!((bvh.nearest(&ray, AHEAD, |_| true), bvh.bounds), (None, None));
    let bvh = build(&[broken.to_vec(), vec![[DVec3::ZERO, DVec3::X, DVec3::Y]]].concat());
    assert_eq!(bvh.nearest(&ray, AHEAD, |_| true).unwrap().triangle, 5);
    assert_eq!(bvh.bounds, Some(AxisBox { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) }));
}

#[test]
fn from_the_surface_itself_and_from_very_far() {
    let triangles = pebble(3);
    let bvh = build(&triangles);
    let mut numbers = Numbers::new(4);
    for turn in 0..2000 {
        let corners = triangles[turn % triangles.len()];
        let on = (corners[0] + corners[1] + corners[2]) / 3.0;
        let ray = Ray::new(on, numbers.point()).unwrap();
        for from in [0.0, 1e-12, 1e-6, 1e-4, 2e-4] {
            check(&bvh, &triangles, &ray, from..f64::INFINITY);
        }
        let far = Ray::new(on - 1e12 * ray.direction(), ray.direction()).unwrap();
        check(&bvh, &triangles, &far, AHEAD);
        let farthest = Ray::new(DVec3::splat(1e308), -ray.direction()).unwrap();
        assert!(bvh.nearest(&farthest, AHEAD, |_| true).is_none_or(|hit| hit.distance.is_finite()));
    }
}
