use super::*;
use crate::mesh::AxisBox;
use crate::{Light, Material, Object, Shape, Sphere, Texture};
use codec::monitor::Silent;

fn scene(shapes: &[Shape]) -> SceneAtTime {
    let paint = Material::diffuse(Texture::Solid(DVec3::ONE));
    SceneAtTime::new(shapes.iter().map(|shape| Object::new(*shape, paint)).collect(), Light::default())
}

fn ball(center: DVec3, radius: f64) -> Shape {
    Shape::Sphere(Sphere { center, radius })
}

fn solid(min: DVec3, max: DVec3) -> Shape {
    Shape::AxisBox(AxisBox { min, max })
}

fn settings(effort: Effort) -> Settings {
    Settings {
        rate_per_m: None,
        min_distance_m: None,
        effort,
        kind: CandidateKind::Refined,
        candidates: Some(200),
        surface_samples: Some(1000),
    }
}

fn around(half: f64) -> Region {
    Region::parse(&[format!("{0},{0},{0},{half},{half},{half}", -half)]).unwrap()
}

const CONVERGED: Stop = Stop { cameras: None, until: DEFAULT_UNTIL };
const SPECULAR: Lighting = Lighting::Specular { theta_deg: 50.0 };

/// Three boxes and a ball that hide parts of each other.
fn group(scale: f64) -> SceneAtTime {
    let at = |x: f64, y: f64, z: f64| scale * DVec3::new(x, y, z);
    scene(&[
        solid(at(-1.0, 0.0, -1.0), at(-0.4, 1.2, -0.3)),
        solid(at(0.2, 0.0, -0.8), at(1.0, 0.7, -0.1)),
        solid(at(-0.6, 0.0, 0.3), at(0.1, 0.5, 1.0)),
        ball(at(0.6, 0.4, 0.6), 0.35 * scale),
    ])
}

#[test]
fn a_convex_object_in_the_open_is_covered_by_few_cameras() {
    let region = around(3.0);
    for shape in [ball(DVec3::ZERO, 1.0), solid(DVec3::NEG_ONE, DVec3::ONE)] {
        let search = Search::new(vec![scene(&[shape])], &region, &settings(Effort::Normal), &Silent).unwrap();
        let found = search.place(Lighting::Diffuse, &[], CONVERGED, &Silent).unwrap();
        let enough = found.cameras.iter().position(|camera| camera.figures.coverage >= 0.99).unwrap() + 1;
        assert!(enough <= 8, "{enough} cameras for {shape:?}");
        assert!(found.cameras.windows(2).all(|pair| pair[1].figures.coverage >= pair[0].figures.coverage));
        assert!(found.cameras.windows(2).all(|pair| pair[1].figures.within >= pair[0].figures.within));
        assert!(found.reachable.coverage > 0.999);
        let sum: f64 = found.cameras.iter().map(|camera| camera.gain).sum();
        assert!((sum - found.cameras.last().unwrap().figures.weighted).abs() < 1e-9);
    }
}

#[test]
fn plain_and_lazy_place_the_same_and_lazy_asks_a_tenth() {
    let region = around(2.0);
    for lighting in [Lighting::Diffuse, SPECULAR] {
        let mut search = Search::new(vec![group(1.0)], &region, &settings(Effort::Normal), &Silent).unwrap();
        let lazy = search.place(lighting, &[], CONVERGED, &Silent).unwrap();
        search.effort = Effort::Exhaustive;
        let plain = search.place(lighting, &[], CONVERGED, &Silent).unwrap();
        assert_eq!(lazy.cameras, plain.cameras);
        assert_eq!(lazy.refinement_calls, plain.refinement_calls);
        assert_eq!(plain.objective_calls, plain.plain_objective_calls);
        assert_eq!(lazy.plain_objective_calls, plain.objective_calls);
        assert!(lazy.bound_calls >= search.visible_sets.len() as u64 && plain.bound_calls == 0);
        assert!(lazy.cameras.len() >= 15, "{}", lazy.cameras.len());
        let calls = [lazy.objective_calls, plain.objective_calls];
        assert!(10 * calls[0] <= calls[1], "{lighting:?}: {calls:?} for {} cameras", lazy.cameras.len());
    }
}

#[test]
fn diffuse_converges_before_specular() {
    let (region, scene) = (around(2.0), vec![group(1.0)]);
    let search = Search::new(scene, &region, &settings(Effort::Normal), &Silent).unwrap();
    let share = |lighting: Lighting, cameras: usize| {
        let stop = Stop { cameras: Some(cameras), until: 0.0 };
        let found = search.place(lighting, &[], stop, &Silent).unwrap();
        found.cameras.last().unwrap().figures.coverage
    };
    for cameras in [2, 5, 10] {
        assert!(share(Lighting::Diffuse, cameras) > share(SPECULAR, cameras) + 0.05);
    }
    // The bottom faces of the boxes are visible in this scene; between the boxes little is hidden.
    assert!(share(Lighting::Diffuse, 10) > 0.9);
}

#[test]
fn going_on_places_what_one_search_places() {
    let region = around(2.0);
    let search = Search::new(vec![group(1.0)], &region, &settings(Effort::Fast), &Silent).unwrap();
    for lighting in [Lighting::Diffuse, SPECULAR, Lighting::Specular { theta_deg: 0.0 }] {
        let place = |start: &[DVec3], cameras: usize| {
            search.place(lighting, start, Stop { cameras: Some(cameras), until: 0.0 }, &Silent).unwrap()
        };
        let whole = place(&[], 9);
        let start: Vec<DVec3> = whole.cameras[..4].iter().map(|camera| camera.position).collect();
        let rest = place(&start, 5);
        assert_eq!(rest.started, 4);
        assert_eq!(rest.cameras, whole.cameras);
        // Without new cameras, the given ones are only measured.
        assert_eq!(place(&start, 0).cameras, whole.cameras[..4]);
    }
}

#[test]
fn theta_of_180_places_as_for_diffuse_surfaces() {
    let region = around(2.0);
    let search = Search::new(vec![group(1.0)], &region, &settings(Effort::Fast), &Silent).unwrap();
    let place = |lighting| search.place(lighting, &[], CONVERGED, &Silent).unwrap().cameras;
    assert_eq!(place(Lighting::Diffuse), place(Lighting::Specular { theta_deg: 180.0 }));
}

#[test]
fn scale_does_not_matter() {
    let place = |scale: f64| {
        let region = around(2.0 * scale);
        let search = Search::new(vec![group(scale)], &region, &settings(Effort::Fast), &Silent).unwrap();
        search.place(Lighting::Diffuse, &[], Stop { cameras: Some(6), until: 0.0 }, &Silent).unwrap().cameras
    };
    let usual = place(1.0);
    for scale in [1e-6, 1e6] {
        let other = place(scale);
        assert_eq!((usual.len(), other.len()), (6, 6));
        for (a, b) in usual.iter().zip(other) {
            assert!((a.position - b.position / scale).length() < 1e-6, "{a:?} {b:?}");
            assert!((a.gain - b.gain).abs() < 1e-6 && (a.figures.coverage - b.figures.coverage).abs() < 1e-2);
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let place = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let region = around(2.0);
            let search = Search::new(vec![group(1.0)], &region, &settings(Effort::Fast), &Silent).unwrap();
            search.place(SPECULAR, &[], CONVERGED, &Silent).unwrap()
        })
    };
    let one = place(1);
    assert_eq!(one, place(2));
    assert_eq!(one, place(5));
}

#[test]
fn what_moves_is_seen_in_all_its_places() {
    // The wall hides the ball, half of the time each, from cameras on either side.
    let at = |x: f64| scene(&[ball(DVec3::X * x, 0.4), solid(DVec3::new(-0.1, -2.0, -2.0), DVec3::new(0.1, 2.0, 2.0))]);
    let region = Region::parse(&["-3,-1,-1,3,1,1"]).unwrap();
    let place = |times: Vec<SceneAtTime>| {
        let search = Search::new(times, &region, &settings(Effort::Fast), &Silent).unwrap();
        search.place(Lighting::Diffuse, &[], CONVERGED, &Silent).unwrap()
    };
    let moving = place(vec![at(-1.5), at(1.5)]);
    let near = |found: &Placement, x: f64| {
        found.cameras.iter().filter(|camera| camera.position.distance(DVec3::X * x) < 1.2).count()
    };
    assert!(near(&moving, -1.5) >= 2 && near(&moving, 1.5) >= 2, "{:?}", moving.cameras);
    // A still scene gives the same result with one or two time samples, except for the surface points.
    let (once, twice) = (place(vec![at(1.5)]), place(vec![at(1.5), at(1.5)]));
    let last = |found: &Placement| found.cameras.last().unwrap().figures;
    assert!((last(&once).coverage - last(&twice).coverage).abs() < 0.03);
    assert!(once.cameras.len().abs_diff(twice.cameras.len()) <= once.cameras.len() / 3);
}

#[test]
fn exhaustive_and_grid_searches_end() {
    let region = around(2.0);
    for (effort, kind) in [(Effort::Exhaustive, CandidateKind::Refined), (Effort::Normal, CandidateKind::Grid)] {
        let settings = Settings { kind, candidates: Some(60), ..settings(effort) };
        let search = Search::new(vec![group(1.0)], &region, &settings, &Silent).unwrap();
        let found = search.place(Lighting::Diffuse, &[], CONVERGED, &Silent).unwrap();
        assert!(found.cameras.last().unwrap().figures.coverage > 0.8);
        assert_eq!(found.refinement_calls == 0, kind == CandidateKind::Grid);
    }
}

#[test]
fn too_much_is_refused_and_an_interruption_heeded() {
    struct Stopped;
    impl Monitor for Stopped {
        fn advance(&self, _steps: u64) {}
        fn interrupted(&self) -> bool {
            true
        }
    }
    let region = around(2.0);
    let large = Settings { candidates: Some(1 << 20), surface_samples: Some(1 << 20), ..settings(Effort::Fast) };
    let said = Search::new(vec![group(1.0)], &region, &large, &Silent).unwrap_err().to_string();
    assert!(said.contains("reduce either"), "{said}");
    let stopped = Search::new(vec![group(1.0)], &region, &settings(Effort::Fast), &Stopped);
    assert!(matches!(stopped, Err(Error::Interrupted)));
}

#[test]
fn frames_are_spread_over_the_range() {
    assert_eq!(sample_frames([0, 95], 4), [12, 36, 60, 84]);
    assert_eq!(sample_frames([7, 9], 16), [7, 8, 9]);
    assert_eq!(sample_frames([5, 5], 16), [5]);
    assert_eq!(sample_frames([0, u32::MAX], 2).len(), 2);
}

/// Equation 7 as `objective` reads it: the integral of equation 4 over time, computed independently from its definition.
#[test]
fn each_time_sample_counts_by_its_time_and_nothing_twice() {
    let at = |x: f64| scene(&[ball(DVec3::X * x, 0.5)]);
    let region = Region::parse(&["-4,-4,2,4,4,4"]).unwrap();
    let settings = Settings { rate_per_m: Some(0.7), min_distance_m: Some(0.5), ..settings(Effort::Fast) };
    let search = Search::new(vec![at(-2.0), at(2.0)], &region, &settings, &Silent).unwrap();
    let surfels = &search.problem.surfels;
    let time = |is_meant: fn(&super::super::objective::Surfel) -> bool| -> f64 {
        surfels.iter().filter(|surfel| is_meant(surfel)).map(|surfel| surfel.weight).sum()
    };
    // The ball has the same size at both times, and each time counts half.
    assert!((time(|surfel| surfel.point.x < 0.0) - 0.5).abs() < 1e-12);
    assert!((time(|surfel| surfel.point.x > 0.0) - 0.5).abs() < 1e-12);
    let cameras = [DVec3::new(-3.0, 0.3, 3.5), DVec3::new(1.0, -0.4, 2.2)];
    let stop = Stop { cameras: Some(0), until: 0.0 };
    let found = search.place(Lighting::Diffuse, &cameras, stop, &Silent).unwrap();
    let suited = |camera: DVec3, at: usize| {
        let surfel = &surfels[at];
        let way = camera - surfel.point;
        // A ball hides the points that face away from the camera; there is no other object.
        let is_seen = way.dot(surfel.normal) > 0.0;
        // Z: distance straight up to the region, at least half a metre.
        let viewer_m = (2.0 - surfel.point.z).max(0.5);
        if is_seen { (-0.7 * (way.length() - viewer_m).max(0.0)).exp() } else { 0.0 }
    };
    let mut best = vec![0.0; surfels.len()];
    for (camera, placed) in cameras.iter().zip(&found.cameras) {
        let mut once = 0.0;
        let mut twice = 0.0;
        for (at, best) in best.iter_mut().enumerate() {
            let suitability = suited(*camera, at);
            let left = (suitability - *best).max(0.0);
            once += surfels[at].weight * left;
            twice += surfels[at].weight * suitability * left;
            *best = best.max(suitability);
        }
        assert!((placed.gain - once).abs() < 1e-9, "{} {once}", placed.gain);
        assert!(twice < 0.8 * once);
    }
}

#[test]
fn spread_cameras_need_no_search_and_are_measured() {
    let region = around(2.0);
    let search = Search::new(vec![group(1.0)], &region, &settings(Effort::Fast), &Silent).unwrap();
    let cameras = search.free_space().hammersley(12).unwrap();
    assert!(cameras.len() == 12 && cameras.iter().all(|camera| search.free_space().admits(*camera)));
    let stop = Stop { cameras: Some(0), until: 0.0 };
    let found = search.place(Lighting::Diffuse, &cameras, stop, &Silent).unwrap();
    let best = search.place(Lighting::Diffuse, &[], Stop { cameras: Some(12), until: 0.0 }, &Silent).unwrap();
    let weighted = |found: &Placement| found.cameras.last().unwrap().figures.weighted;
    // The search must give a better result than spread cameras.
    assert!(weighted(&found) > 0.3 && weighted(&found) < weighted(&best), "{} {}", weighted(&found), weighted(&best));
}
