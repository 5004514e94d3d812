//! Hard cases of view interpolation: planes at all depths, sources in bad places, scenes of all sizes, mirrors.

use std::ops::Range;

use glam::DVec3;
use half::f16;

use crate::case::{Bound, Family, Group, HardCase, Measured};
use codec::error::Result;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, Culling, acquire};
use epipolar::backend::Cpu;
use epipolar::brute_force;
use epipolar::fill::{HoleFilling, Truth};
use epipolar::highlights::{EyeLine, Highlight};
use epipolar::interpolate::{Coverage, InterpolateSettings, InterpolatedView, Interpolator};
use epipolar::lines::{LineSpace, moved};
use epipolar::pipeline::{Request, RowsAtOnce, Settings, between};
use epipolar::source::{Light, MAX_LAYERS, SourcePixel, SourceRow, SourceView, in_order};
use epipolar::view_store::Storage;
use epipolar::views::{MAX_VIEWS, OutputViews, Spread};
use epipolar::visibility::hidden_m;
use gpu::selftest::highlights;
use gpu::selftest::slices::InterpolationCase;
use scene::capture::SamplePattern;
use scene::{Light as SceneLight, Material, Object, Optics, Phong, Quad, SceneAtTime, Shape, Sphere, Texture};

/// Sizes of scenes in metres.
const SIZES: [f64; 3] = [1.0, 1e-6, 1e6];
/// Size of most views in pixels.
const SIZE: [u32; 2] = [48, 3];

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Interpolation, pipeline, unit);
    let mut cases = Vec::new();
    let columns = group("columns of lines", "pixels from exact ones");
    // Disparity is rounded to 1/8192, position to 2^-25, and their product to 1/512.
    cases.push(columns.case("4096 views", Bound::AtMost(1.0 / 256.0), || columns_of_views(MAX_VIEWS, 1.5)));
    cases.push(
        columns.case("a disparity of a thousand images", Bound::AtMost(1.0 / 256.0), || columns_of_views(9, 400.0)),
    );
    let covered = group("planes at all depths", "pixels not covered once");
    for (name, count, baseline_m, focus_m) in [
        ("parallel views", 9, 0.5, f64::INFINITY),
        ("focus at a plane", 9, 0.5, 2.0),
        ("focus nearer than all", 9, 0.5, 1e-3),
        ("one view", 1, 0.0, 2.0),
        ("two views", 2, 0.5, 2.0),
        ("no baseline", 5, 0.0, 2.0),
    ] {
        cases.push(covered.none(name, move || planes(count, baseline_m, focus_m)));
    }
    let sources = group("sources", "other pixels");
    cases.push(sources.none("in another order, and doubled", orders));
    cases.push(sources.none("layers of one depth", coplanar));
    cases.push(sources.none("a layer of holes before a wall", || before_a_wall(|column| column.rem_euclid(6) < 3)));
    cases.push(sources.none("edges at the borders of the image", || {
        before_a_wall(|column| column < 1 || column >= SIZE[0] as i32 - 1)
    }));
    cases.push(sources.none("two sources of planes one ulp apart", one_ulp_apart));
    cases.push(sources.none("no source at all", nothing));
    let offset = group("what lies close behind", "wrong distances");
    cases.push(offset.none("a baseline of two pixels, and one ulp about it", pole));
    let highlights = group("best place of a highlight", "of the cosine");
    // A search in steps of 1/1000 is no better than the closed form, up to rounding.
    cases.push(highlights.case("lights on, along, before and behind the line", Bound::AtMost(1e-9), best_places));
    let lights = group("highlights", "other radiance at splits");
    cases.push(
        lights.none("lamps at the ends of the line, on it and beyond, few splits and many", highlights_at_splits),
    );
    let scenes = group("scene to views", "other pixels than by ray casting");
    for size_m in SIZES {
        cases.push(scenes.none(format!("views of sources, scene of {size_m:e} m"), move || own_views(size_m)));
    }
    cases.push(scenes.none("a mirror that fills the image", || same_as_cast(&mirror(), 5, SIZE)));
    cases.push(
        scenes.none("no surface", || same_as_cast(&SceneAtTime::new(Vec::new(), SceneLight::default()), 5, SIZE)),
    );
    cases.push(scenes.none("eleven surfaces behind each other", too_many_layers));
    cases.push(scenes.none("surfaces along the view direction", || same_as_cast(&edge_on(), 1, SIZE)));
    for size in [[1, 1], [1, 7], [7, 1]] {
        cases.push(scenes.none(format!("{}x{} pixels", size[0], size[1]), move || same_as_cast(&ball(1.0), 1, size)));
    }
    cases
}

fn views(count: u32, baseline_m: f64, focus_m: f64, size: [u32; 2]) -> Result<OutputViews> {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(10.0))?;
    let camera = camera.with_aspect(f64::from(size[0]) / f64::from(size[1]));
    OutputViews::new(camera, size, count, Spread::Baseline(baseline_m), focus_m)
}

/// Returns a source view whose scanlines are all equal.
fn source(offset_m: f64, columns: Range<i32>, layers: &[&dyn Fn(i32) -> Option<f32>]) -> SourceView {
    let pixel = |(layer, depth): (usize, &&dyn Fn(i32) -> Option<f32>)| {
        columns
            .clone()
            .filter_map(|column| {
                let light = [f16::from_f32(column as f32); 3];
                let depth_m = depth(column)?;
                Some(SourcePixel {
                    column,
                    depth_m,
                    layer: layer as u8,
                    light: Light::Steady,
                    steady: light,
                    own: light,
                })
            })
            .collect::<Vec<_>>()
    };
    let pixels: Vec<SourcePixel> = layers.iter().enumerate().flat_map(pixel).collect();
    let row = SourceRow { pixels, gloss: Vec::new() };
    SourceView { offset_m, rows: vec![row; SIZE[1] as usize], layers: layers.len() as u32 }
}

fn interpolated(views: &OutputViews, sources: &[SourceView]) -> Result<Vec<InterpolatedView>> {
    let interpolator = Interpolator::new(views, sources, InterpolateSettings::default());
    Ok(interpolator.views(0..views.count() as usize, &Silent)?.0)
}

/// Returns the input for interpolation on devices.
fn on_devices(label: impl Into<String>, views: &OutputViews, sources: &[SourceView]) -> InterpolationCase {
    InterpolationCase {
        label: label.into(),
        views: views.clone(),
        sources: sources.to_vec(),
        settings: InterpolateSettings::default(),
    }
}

fn columns_of_views(count: u32, baseline_m: f64) -> Result<Measured> {
    let views = views(count, baseline_m, f64::INFINITY, SIZE)?;
    let (mut worst, mut cases) = (Measured::nothing(), Vec::new());
    let space = LineSpace::new(&views, &[views.offsets_m[0]]);
    for depth_m in [0.9f32, 3.3, 171.0, 1e9, f32::INFINITY] {
        let sources = [source(views.offsets_m[0], 20..21, &[&|_| Some(depth_m)])];
        let lines = space.lines(&sources, 0);
        cases.push(on_devices(format!("{depth_m} m"), &views, &sources));
        for (view, offset_m) in views.offsets_m.iter().enumerate() {
            let found = f64::from(lines[0].column + moved(lines[0].disparity, space.place(0, view))) / 256.0;
            let exact = 20.5 + (offset_m - views.offsets_m[0]) * views.columns_per_metre(f64::from(depth_m));
            worst.greatest((found - exact).abs(), || format!("{depth_m} m, view {view}"));
        }
    }
    Ok(worst.with_interpolations(cases))
}

fn planes(count: u32, baseline_m: f64, focus_m: f64) -> Result<Measured> {
    let views = views(count, baseline_m, focus_m, SIZE)?;
    let (mut wrong, mut cases) = (Measured::count(0), Vec::new());
    for depth_m in [1e-3f32, 0.7, 2.0, 2.000_000_2, 1e9, f32::INFINITY] {
        let disparity = views.columns_per_metre(f64::from(depth_m)).abs() * baseline_m;
        let reach = (disparity.min(1e6) as i32) + SIZE[0] as i32;
        let plane = source(0.0, -reach..reach + SIZE[0] as i32, &[&|_| Some(depth_m)]);
        let interpolator = Interpolator::new(&views, std::slice::from_ref(&plane), InterpolateSettings::default());
        let (found, counters) = interpolator.views(0..count as usize, &Silent)?;
        let pixels = u64::from(count * SIZE[0] * SIZE[1]);
        let open = found.iter().flat_map(|view| view.coverage.data()).any(|of| *of != Coverage::Covered);
        wrong.count_if(open || counters.fragments != pixels, || {
            format!("{depth_m} m: {} of {pixels} covered, {} open", counters.fragments, counters.hole_pixels)
        });
        cases.push(on_devices(format!("{depth_m} m"), &views, &[plane]));
    }
    Ok(wrong.with_interpolations(cases))
}

fn orders() -> Result<Measured> {
    let views = views(7, 0.3, 2.0, SIZE)?;
    let post = |column: i32| Some(if column.rem_euclid(9) < 2 { 0.8f32 } else { 3.0 });
    let all: Vec<SourceView> = [-0.15, 0.0, 0.11].map(|offset_m| source(offset_m, -40..90, &[&post])).into();
    let plain = interpolated(&views, &in_order(all.clone()))?;
    let (mut wrong, mut cases) = (Measured::count(0), Vec::new());
    for other in [all.iter().rev().cloned().collect(), [all.clone(), all].concat()] {
        cases.push(on_devices("as they come", &views, &other));
        let found = interpolated(&views, &in_order(other))?;
        let differs = plain.iter().zip(&found).position(|(a, b)| a.color != b.color || a.coverage != b.coverage);
        wrong.count_if(differs.is_some(), || format!("view {differs:?}"));
    }
    Ok(wrong.with_interpolations(cases))
}

/// Coplanar layers: the first of two at equal depth is visible.
fn coplanar() -> Result<Measured> {
    let views = views(5, 0.3, f64::INFINITY, SIZE)?;
    let mut doubled = source(0.0, -60..110, &[&|_| Some(2.0), &|_| Some(2.0)]);
    for row in &mut doubled.rows {
        for pixel in row.pixels.iter_mut().filter(|pixel| pixel.layer == 1) {
            pixel.steady = [f16::INFINITY; 3];
        }
    }
    let case = on_devices("doubled", &views, std::slice::from_ref(&doubled));
    let shown = interpolated(&views, &[doubled])?;
    let alone = interpolated(&views, &[source(0.0, -60..110, &[&|_| Some(2.0)])])?;
    let mut wrong = Measured::count(0);
    for (view, (a, b)) in shown.iter().zip(&alone).enumerate() {
        wrong.count_if(a.color != b.color, || format!("view {view}"));
    }
    Ok(wrong.with_interpolations([case]))
}

/// Each view shows only one of two planes: the nearer one, except in the view of the other plane's source.
fn one_ulp_apart() -> Result<Measured> {
    let views = views(5, 0.3, f64::INFINITY, SIZE)?;
    let mut sources = [(-0.15, 2.0f32), (0.15, 2.0f32.next_up())]
        .map(|(at_m, depth_m)| source(at_m, -60..110, &[&|_| Some(depth_m)]));
    // The second source has negative radiance.
    for pixel in sources[1].rows.iter_mut().flat_map(|row| &mut row.pixels) {
        let light = [f16::from_f32(-1000.0); 3];
        (pixel.steady, pixel.own) = (light, light);
    }
    for pixel in sources[0].rows.iter_mut().flat_map(|row| &mut row.pixels) {
        let light = [f16::from_f32(1000.0); 3];
        (pixel.steady, pixel.own) = (light, light);
    }
    let shown = interpolated(&views, &sources)?;
    let mut wrong = Measured::count(0);
    for (view, found) in shown.iter().enumerate() {
        let first = found.color.get(0, 0)[0].to_f32();
        let is_whole = found.color.data().iter().all(|light| light[0].to_f32() == first);
        let is_own = (view != 0 || first == 1000.0) && (view != 4 || first == -1000.0);
        let is_covered = found.coverage.data().iter().all(|of| *of == Coverage::Covered);
        wrong.count_if(!(is_whole && is_own && is_covered), || format!("view {view}: {first}"));
    }
    Ok(wrong.with_interpolations([on_devices("planes one ulp apart", &views, &sources)]))
}

/// A source with more surfaces behind each other than it has layers: the nearest are kept, and the views of sources
/// equal ray casting.
fn too_many_layers() -> Result<Measured> {
    let sheet = |at: usize| {
        let corner = DVec3::new(-0.2, -9.0, -1.0 - 0.4 * at as f64);
        let shape = Shape::Quad(Quad { corner, u: DVec3::X * 0.4, v: DVec3::Y * 18.0 });
        Object::new(shape, Material::diffuse(Texture::Solid(DVec3::splat(0.1 + 0.05 * at as f64))))
    };
    let scene = SceneAtTime::new((0..=MAX_LAYERS).map(sheet).collect(), SceneLight::default());
    let views = views(5, 0.1, f64::INFINITY, SIZE)?;
    let settings = AcquireSettings { culling: Culling::Off, ..AcquireSettings::new(SamplePattern::new(4)?) };
    let (sources, _) = acquire(&scene, &views, &settings, (&Cpu, &Silent))?;
    let mut wrong = different(&scene, &views, &[0, 4])?;
    for source in &sources {
        wrong.count_if(source.layers as usize != MAX_LAYERS, || format!("{} layers", source.layers));
    }
    Ok(wrong)
}

/// A surface before a wall hides the wall at its own columns and nowhere else.
fn before_a_wall(is_leaf: fn(i32) -> bool) -> Result<Measured> {
    let views = views(9, 0.02, f64::INFINITY, SIZE)?;
    let leaves = |column: i32| Some(if is_leaf(column) { 1.0f32 } else { 4.0 });
    let wall = |column: i32| is_leaf(column).then_some(4.0f32);
    let sources = [source(0.0, -60..110, &[&leaves, &wall])];
    let shown = interpolated(&views, &sources)?;
    let mut wrong = Measured::count(0);
    for (view, found) in shown.iter().enumerate() {
        let moved = views.offsets_m[view] * views.columns_per_metre(1.0);
        for column in 0..SIZE[0] {
            let at = (f64::from(column) + 0.5 - moved).floor() as i32;
            let is_open = found.coverage.get(column, 0) != Coverage::Covered;
            // The pixel shows that of its source leaf, or lies between two pixels of the same leaf.
            let shows_leaf = (found.color.get(column, 0)[0].to_f32() - at as f32).abs() <= 1.0;
            wrong.count_if(is_open || is_leaf(at) && !shows_leaf, || format!("view {view}, column {column}"));
        }
    }
    Ok(wrong.with_interpolations([on_devices("leaves", &views, &sources)]))
}

fn nothing() -> Result<Measured> {
    let views = views(3, 0.3, 2.0, SIZE)?;
    let (mut wrong, mut cases) = (Measured::count(0), Vec::new());
    for sources in [Vec::new(), vec![source(0.0, 0..0, &[])]] {
        let shown = interpolated(&views, &sources)?;
        let open = shown.iter().flat_map(|view| view.coverage.data()).all(|of| *of == Coverage::Hole);
        wrong.count_if(!open, || format!("{} sources", sources.len()));
        cases.push(on_devices(format!("{} sources", sources.len()), &views, &sources));
    }
    Ok(wrong.with_interpolations(cases))
}

fn pole() -> Result<Measured> {
    let mut wrong = Measured::count(0);
    for depth_m in [1e-6f64, 0.3, 2.0, 1e6] {
        // Twice the reach equals the width.
        let at = 0.5 * depth_m * 0.01;
        for reach_m in [0.0, at.next_down(), at] {
            wrong.count_if(hidden_m(depth_m, 0.01, reach_m) != f64::INFINITY, || format!("{depth_m} m, {reach_m} m"));
        }
        for reach_m in [at.next_up(), 1.001 * at, 1e3 * at] {
            let hidden = hidden_m(depth_m, 0.01, reach_m);
            wrong.count_if(hidden.is_nan() || hidden <= 0.0, || format!("{depth_m} m, {reach_m} m: {hidden}"));
        }
    }
    Ok(wrong)
}

fn best_places() -> Result<Measured> {
    let views = views(9, 2.0, f64::INFINITY, SIZE)?;
    let eyes = EyeLine::new(&views);
    let mut worst = Measured::nothing();
    let directions =
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.2, 1.0], [0.0, 0.0, -1.0]];
    for point in [[0.1, -0.2, -2.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.4, 1e-9, 0.0]] {
        for direction in directions {
            let (point, direction) = (DVec3::from_array(point), DVec3::from_array(direction).normalize());
            let eye = |place: f64| DVec3::X * (2.0 * place - 1.0);
            let cosine = |place: f64| (eye(place) - point).normalize_or_zero().dot(direction);
            let best = eyes.best_place(point, direction);
            let searched = (0..=1000).map(|at| cosine(f64::from(at) / 1000.0)).fold(f64::NEG_INFINITY, f64::max);
            let short = if (0.0..=1.0).contains(&best) { searched - cosine(best) } else { f64::NAN };
            worst.greatest(short, || format!("{direction} at {point}"));
        }
    }
    Ok(worst)
}

/// Highlights have their exact radiance at both ends, at the best place of a lamp, and at all splits, whose number is
/// limited.
fn highlights_at_splits() -> Result<Measured> {
    let (mut wrong, cases) = (Measured::count(0), highlights::cases()?);
    for case in &cases {
        let (eyes, limit) = (EyeLine::new(&case.views), case.settings.splits);
        let [first_m, last_m] = case.views.ends_m();
        let eye = |place: f64| case.views.eye(first_m).lerp(case.views.eye(last_m), place);
        let rows = case.sources.iter().flat_map(|source| &source.rows);
        for (at, gloss) in rows.flat_map(|row| &row.gloss).enumerate() {
            let highlight = Highlight::new(gloss, &eyes, limit);
            let places = highlight.places();
            let is_ordered = places.windows(2).all(|pair| pair[0].0 < pair[1].0);
            let is_exact = places.iter().all(|&(place, light)| {
                let exact = gloss.towards(eye(place));
                // This eye position is computed by a different sum, hence the tolerance.
                highlight.at(place) == light && (light - exact).abs().max_element() <= 1e-6 * exact.max_element()
            });
            let has_ends = places[0].0 == 0.0 && (first_m == last_m || places[places.len() - 1].0 == 1.0);
            let is_few = (1..=limit + 2).contains(&places.len());
            wrong.count_if(!(is_ordered && is_exact && has_ends && is_few), || format!("{}: {at}", case.label));
        }
    }
    Ok(wrong.with_interpolations(cases))
}

fn ball(size_m: f64) -> SceneAtTime {
    let matt = |red: f64| Material::diffuse(Texture::Solid(DVec3::new(red, 0.5, 0.5)));
    let center = DVec3::new(0.0, 0.0, -4.0) * size_m;
    let shape = Shape::Sphere(Sphere { center, radius: 0.3 * size_m });
    let corner = DVec3::new(-20.0, -20.0, -9.0) * size_m;
    let wall = Quad { corner, u: DVec3::X * 40.0 * size_m, v: DVec3::Y * 40.0 * size_m };
    let objects = vec![Object::new(shape, matt(0.9)), Object::new(Shape::Quad(wall), matt(0.1))];
    SceneAtTime::new(objects, SceneLight::default())
}

fn mirror() -> SceneAtTime {
    let optics = Optics::Mirror { tint: DVec3::splat(0.9) };
    let material = Material { optics, phong: Phong::default(), ..Material::diffuse(Texture::Solid(DVec3::ZERO)) };
    let quad = Quad { corner: DVec3::new(-9.0, -9.0, -3.0), u: DVec3::X * 18.0, v: DVec3::Y * 18.0 };
    SceneAtTime::new(vec![Object::new(Shape::Quad(quad), material)], SceneLight::default())
}

/// A quad that the middle view sees edge-on.
fn edge_on() -> SceneAtTime {
    let quad = Quad { corner: DVec3::new(0.0, -1.0, -2.0), u: DVec3::NEG_Z, v: DVec3::Y * 2.0 };
    let material = Material::diffuse(Texture::Solid(DVec3::ONE));
    SceneAtTime::new(vec![Object::new(Shape::Quad(quad), material)], SceneLight::default())
}

fn settings() -> Result<Settings> {
    Ok(Settings {
        acquire: AcquireSettings::new(SamplePattern::new(4)?),
        interpolate: InterpolateSettings::default(),
        holes: HoleFilling::Trace,
        at_once: RowsAtOnce { acquired: 4, interpolated: 3 },
        storage: Storage::Memory,
        keeps_unfilled: true,
    })
}

/// Counts pixels of the given views that differ from ray casting.
fn different(scene: &SceneAtTime, views: &OutputViews, compared: &[usize]) -> Result<Measured> {
    let (mut wrong, settings) = (Measured::count(0), settings()?);
    let (sources, _) = acquire(scene, views, &settings.acquire, (&Cpu, &Silent))?;
    let truth = Truth { scene, samples: &settings.acquire.samples };
    between((&sources, Some(truth)), &Request::all(views, &settings), &Silent, |view, picture| {
        if !compared.contains(&view) {
            return Ok(());
        }
        let cast = brute_force::render(scene, (views, views.offsets_m[view]), &settings.acquire.samples, &Silent)?;
        for (at, (shown, cast)) in picture.filled.color.data().iter().zip(cast.data()).enumerate() {
            wrong.count_if(*shown != cast.map(f16::to_f32), || format!("view {view}, pixel {at}"));
        }
        Ok(())
    })?;
    Ok(wrong.with_interpolations([on_devices("sources of the scene", views, &sources)]))
}

fn same_as_cast(scene: &SceneAtTime, count: u32, size: [u32; 2]) -> Result<Measured> {
    let views = views(count, 0.3, 2.5, size)?;
    different(scene, &views, &(0..count as usize).collect::<Vec<_>>())
}

/// Compares the views at the ends, which are source views.
fn own_views(size_m: f64) -> Result<Measured> {
    let views = views(5, 0.3 * size_m, 2.5 * size_m, SIZE)?;
    different(&ball(size_m), &views, &[0, 4])
}
