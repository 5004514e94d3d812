//! Captures that are hard to simplify: budgets that must hold, pictures without cracks, invalid input.
//!
//! Every capture is a set of rays in memory. The tested properties follow from the definitions: budgets are strict, a
//! pixel of the capture that shows a surface has at least half of its alpha, and a scene of a single colour has that
//! colour wherever it is opaque.

use glam::DVec3;

use crate::case::{Family, Group, HardCase, Measured};
use codec::effort::Effort;
use codec::error::Result;
use codec::image::Face;
use codec::math::random::Random;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use footage::dataset::seurat::CaptureRay;
use scene::mesh::Ray;
use scene::placement::Region;
use simplify::budgets::{Budgets, SelectedTiling};
use simplify::candidates::{CandidateLevel, Extent, Tiling};
use simplify::capture::{Capture, CaptureImage};
use simplify::constraints::ConstraintKind;
use simplify::cost::{CostModel, TextureCoordinates};
use simplify::fidelity::Evaluation;
use simplify::pipeline::{Simplified, simplify};
use simplify::samples::{Background, Sample};
use simplify::settings::Settings;
use simplify::shading::{LightBuffer, ShortCuts};
use simplify::silhouettes::ConstraintBitmap;
use simplify::texture_filter::TextureFilter;
use simplify::textures::{TextureBuilder, TileTextures};
use simplify::tile_plane::TilePlane;
use simplify::tiles::TileSet;
use simplify::tree::TreeCell;

/// Pixels per side of a face.
const SIDE: u32 = 16;
/// Linear RGB of surfaces of a single colour. 8-bit codes represent it to half a code.
const COLOR: [f32; 3] = [0.5, 0.25, 0.75];
/// PSNR of pictures that are off by one code of 255 everywhere: 20 log10 255. The texture rounds radiance to a code,
/// and the picture rounds it to the same code, or to an adjacent one if the bilinear weights do not sum to exactly 1.
const ONE_CODE_DB: f64 = 48.130_803_608_679_1;

/// Distance in metres to the surface along a ray, from the eye's position and the direction; `+inf` without a surface.
type Surface = fn(DVec3, DVec3) -> f64;

/// A capture: positions of the eyes, the surface, and the settings of simplification.
#[derive(Clone)]
struct Case {
    eyes: Vec<DVec3>,
    faces: Vec<Face>,
    side: u32,
    surface: Surface,
    /// Viewing volumes, separated by semicolons. By default the box around the eyes.
    region: Option<String>,
    budgets: Budgets,
    atlas: u32,
    background: Background,
    pixels_per_degree: Option<f64>,
    /// True if no surface hides another.
    is_convex: bool,
    /// True if crack pixels are allowed: an off-centre eye may look past all tiles at a surface that no other eye sees,
    /// with nothing behind it.
    may_crack: bool,
}

/// Returns the corners of a box with half sides of `half_m` metres.
fn corners(half_m: f64) -> Vec<DVec3> {
    let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    (0..8u32).map(|at| half_m * DVec3::new(sign(at & 1), sign(at & 2), sign(at & 4))).collect()
}

impl Case {
    fn new(surface: Surface) -> Case {
        Case {
            eyes: corners(0.5).into_iter().step_by(3).collect(),
            faces: Face::CUBE.to_vec(),
            side: SIDE,
            surface,
            region: Some("-0.5,-0.5,-0.5,0.5,0.5,0.5".to_owned()),
            budgets: Budgets { triangles: 4000.0, area: 3.0, peak_overdraw: 5.0 },
            atlas: 1024,
            background: Background::Sky,
            pixels_per_degree: None,
            is_convex: false,
            may_crack: false,
        }
    }

    fn convex(surface: Surface) -> Case {
        Case { is_convex: true, ..Case::new(surface) }
    }

    fn capture(&self) -> Result<Capture> {
        let mut images = Vec::new();
        for (at, &eye) in self.eyes.iter().enumerate() {
            for face in &self.faces {
                let camera = Camera::with_axes(eye, face.axes(), Lens::new(90.0))?;
                let side = self.side;
                let ray = |pixel: u32| {
                    let [column, row] = [pixel % side, pixel / side];
                    let place = [column, row].map(|at| (f64::from(at) + 0.5) / f64::from(side));
                    let direction = camera.direction(place);
                    let distance_m = (self.surface)(eye, direction);
                    CaptureRay { pixel: [column, row], origin: eye, direction, distance_m, light: COLOR, alpha: 1.0 }
                };
                // A distance of 0 means no sample.
                let rays = (0..side * side).map(ray).filter(|ray| ray.distance_m > 0.0).collect();
                let name = format!("eye {at}, {}", face.name());
                images.push((CaptureImage { name, eye, size: [side; 2], camera: Some(camera) }, rays));
            }
        }
        Ok(Capture::of_rays(images))
    }

    fn settings(&self) -> Result<Settings> {
        let volumes = |text: &String| Region::parse(&text.split(';').collect::<Vec<_>>());
        let region = self.region.as_ref().map(volumes).transpose()?;
        Ok(Settings {
            budgets: self.budgets,
            atlas: self.atlas,
            pixels_per_degree: self.pixels_per_degree,
            region,
            background: self.background,
            effort: Effort::Fast,
            ..Settings::default()
        })
    }

    fn run(&self) -> Result<Simplified> {
        simplify(&mut self.capture()?, &self.settings()?, &Silent)
    }

    /// Counts violated properties of a result.
    fn broken(&self) -> Result<Measured> {
        let found = self.run()?;
        let Evaluation { fidelity, .. } = found.evaluate(&mut self.capture()?, &self.settings()?, &Silent)?;
        let mut wrong = Measured::count(0);
        let Budgets { triangles, area, peak_overdraw } = self.budgets;
        let mesh = &found.scene.mesh;
        let [used, used_area, used_peak] = found.used;
        // Sums of the model have the rounding errors of their terms.
        let within = |used: f64, limit: f64| used <= limit * (1.0 + 1e-12);
        wrong.count_if(mesh.triangles.len() as f64 > triangles, || format!("{} triangles", mesh.triangles.len()));
        wrong.count_if(used != mesh.triangles.len() as f64, || format!("{used} triangles in the model"));
        wrong.count_if(!within(used_area, area), || format!("area {used_area}"));
        wrong.count_if(!within(used_peak, peak_overdraw), || format!("peak overdraw {used_peak}"));
        wrong.count_if(found.atlas.iter().any(|side| *side > self.atlas), || format!("atlas {:?}", found.atlas));
        let finite = mesh.positions.iter().all(|position| position.is_finite());
        wrong.count_if(!finite, || "a corner is not finite".to_owned());
        let inside = mesh.uvs.iter().all(|uv| uv.cmpge(glam::Vec2::ZERO).all() && uv.cmple(glam::Vec2::ONE).all());
        wrong.count_if(!inside, || "texture coordinates beyond the texture".to_owned());
        let cracks = fidelity.crack_pixels;
        wrong.count_if(cracks > 0 && !self.may_crack, || format!("{cracks} crack pixels"));
        let psnr_db = fidelity.similarity.all.psnr_db();
        wrong.count_if(self.is_closed() && psnr_db < ONE_CODE_DB, || format!("{psnr_db:.2} dB"));
        let slivers = self.slivers(&found);
        let note = format!(
            "{} tiles, {slivers} triangles whose plane passes within r_min, {cracks} crack pixels",
            found.tiles
        );
        Ok(wrong.with_note(note))
    }

    /// True if every ray hits a surface that is never occluded or missing: all pixels then have its colour.
    fn is_closed(&self) -> bool {
        self.is_convex && self.background == Background::Sky
    }

    /// Counts triangles whose plane passes within r_min, 1% of the region's radius, of the region's centre.
    fn slivers(&self, found: &Simplified) -> usize {
        let min_m = 0.01 * found.region.radius();
        let middle = found.region.middle;
        let mesh = &found.scene.mesh;
        let passes_near = |&triangle: &usize| {
            let [a, b, c] = mesh.corners(triangle).map(|corner| corner - middle);
            (b - a).cross(c - a).try_normalize().is_some_and(|normal| normal.dot(a).abs() < min_m)
        };
        (0..mesh.triangles.len()).filter(passes_near).count()
    }

    /// Counts faults of the refusal of a capture or a budget: no error, or an error message that lacks one of `words`
    /// or has several lines.
    fn refused(&self, words: &[&str]) -> Measured {
        let mut wrong = Measured::count(0);
        match self.run() {
            Ok(_) => wrong.count_if(true, || "it was accepted".to_owned()),
            Err(error) => {
                let said = error.to_string();
                for word in words {
                    wrong.count_if(!said.contains(word), || format!("'{said}' without '{word}'"));
                }
                wrong.count_if(said.contains('\n'), || "a message of two lines".to_owned());
            }
        }
        wrong
    }
}

/// Distance to a box around the origin with half sides `half`.
fn room(half: DVec3, eye: DVec3, direction: DVec3) -> f64 {
    let along = |axis: usize| (half[axis].copysign(direction[axis]) - eye[axis]) / direction[axis];
    along(0).min(along(1)).min(along(2))
}

/// Distance to the plane y = `height_m`; `+inf` if the ray misses it.
fn floor(height_m: f64, eye: DVec3, direction: DVec3) -> f64 {
    let metres = (height_m - eye.y) / direction.y;
    if metres > 0.0 { metres } else { f64::INFINITY }
}

/// Distance to a vertical wire 2 m away, with a diameter of a tenth of a pixel at that distance.
fn wire(eye: DVec3, direction: DVec3) -> f64 {
    const RADIUS_M: f64 = 0.5 * 2.0 * (2.0 / SIDE as f64) / 10.0;
    let (beside, ahead) = (DVec3::new(-0.03, 0.0, -2.0) - eye, direction);
    // In the plane perpendicular to the wire.
    let (cross, dot) = (ahead.x * beside.z - ahead.z * beside.x, ahead.x * beside.x + ahead.z * beside.z);
    let flat = ahead.x.hypot(ahead.z);
    if flat > 0.0 && dot > 0.0 && (cross / flat).abs() <= RADIUS_M { dot / (flat * flat) } else { f64::INFINITY }
}

/// Distance to leaves at random distances of 2 m to 10 m, outside a region of 1 m. A third of the rays miss them.
fn foliage(eye: DVec3, direction: DVec3) -> f64 {
    let bits = (eye + 16.0 * direction).to_array().map(f64::to_bits);
    let mut random = Random::new(bits[0] ^ bits[1].rotate_left(21) ^ bits[2].rotate_left(42));
    if random.below(3) == 0 { f64::INFINITY } else { 2.0 + f64::from(random.below(8000)) * 1e-3 }
}

/// A table whose edge hides most of a hall: every other ray beside the edge is far longer than its neighbour.
fn edges(eye: DVec3, direction: DVec3) -> f64 {
    let metres = floor(-0.7, eye, direction);
    let at = eye + metres * direction;
    let is_table = metres.is_finite() && (at.x.abs() < 2.0 && at.z.abs() < 2.0) && (4.0 * at.x).rem_euclid(2.0) < 1.0;
    if is_table { metres } else { room(DVec3::new(60.0, 40.0, 60.0), eye, direction) }
}

fn cube(eye: DVec3, direction: DVec3) -> f64 {
    room(DVec3::new(2.0, 1.5, 3.0), eye, direction)
}

fn sky(_: DVec3, _: DVec3) -> f64 {
    f64::INFINITY
}

fn nothing(_: DVec3, _: DVec3) -> f64 {
    0.0
}

pub(super) fn cases() -> Vec<HardCase> {
    let mut cases = of_captures();
    cases.extend(of_budgets());
    cases.extend(refusals());
    cases.extend(of_textures());
    cases
}

fn group(pipeline: &str, unit: &'static str) -> Group {
    Group::new(Family::Simplification, pipeline, unit)
}

fn of_captures() -> Vec<HardCase> {
    let with = |surface: Surface, change: fn(&mut Case)| {
        let mut case = Case::new(surface);
        change(&mut case);
        case
    };
    let in_room = |change: fn(&mut Case)| {
        let mut case = Case::convex(cube);
        change(&mut case);
        case
    };
    let on_a_ray = |case: &mut Case| {
        (case.side, case.faces) = (1, vec![Face::Px]);
        case.eyes = (0..5).map(|step| DVec3::new(0.1 * f64::from(step) - 0.2, 0.0, 0.0)).collect();
    };
    let captures = [
        ("a room", in_room(|_| {})),
        ("one view only", in_room(|case| (case.eyes, case.faces) = (vec![DVec3::ZERO], vec![Face::Nz]))),
        ("a region without extent", in_room(|case| (case.eyes, case.region) = (vec![DVec3::ZERO], None))),
        (
            "cameras in a plane",
            in_room(|case| {
                case.eyes.iter_mut().for_each(|eye| eye.y = 0.0);
                case.region = None;
            }),
        ),
        (
            "a region of two boxes that are small for their distance",
            in_room(|case| {
                case.eyes = vec![DVec3::new(-1.5, 0.0, 0.0), DVec3::new(1.5, 0.0, 0.0)];
                case.region = Some("-1.5001,0,0,-1.5,0.0001,0.0001;1.5,0,0,1.5001,0.0001,0.0001".to_owned());
            }),
        ),
        ("samples twice", in_room(|case| case.eyes = [case.eyes.clone(), case.eyes.clone()].concat())),
        ("textures of the least size", in_room(|case| case.pixels_per_degree = Some(1e-3))),
        ("sky only", Case::convex(sky)),
        ("a plane through the horizon", Case::convex(|eye, direction| floor(-0.6, eye, direction))),
        (
            "all samples in one plane",
            with(
                |eye, direction| floor(-1.0, eye, direction),
                |case| (case.faces, case.background) = (vec![Face::Ny], Background::Transparent),
            ),
        ),
        ("all samples in one place, on one ray", with(|eye, _| 3.0 - eye.x, on_a_ray)),
        ("all samples on one ray", with(|eye, _| 51.0 + 100.0 * eye.x, on_a_ray)),
        (
            "all samples equal",
            with(|_, _| 2.0, |case| (case.side, case.faces, case.eyes) = (1, vec![Face::Nz], vec![DVec3::ZERO; 6])),
        ),
        ("slivers towards the viewer at depth edges", Case::new(edges)),
        ("a wire of a tenth of a pixel", with(wire, |case| case.background = Background::Transparent)),
        ("foliage", with(foliage, |case| (case.background, case.eyes) = (Background::Transparent, vec![DVec3::ZERO]))),
        (
            "foliage, seen from beside",
            with(foliage, |case| (case.background, case.may_crack) = (Background::Transparent, true)),
        ),
        ("foliage before the sky", Case::new(foliage)),
        (
            "a region of 1e-6 m",
            with(
                |eye, direction| 1e-6 * cube(1e6 * eye, direction),
                |case| (case.eyes, case.region, case.is_convex) = (corners(0.5e-6), None, true),
            ),
        ),
        (
            "a region of 1e6 m",
            with(
                |eye, direction| 1e6 * cube(1e-6 * eye, direction),
                |case| (case.eyes, case.region, case.is_convex) = (corners(0.5e6), None, true),
            ),
        ),
    ];
    let promises = group("capture to quads, all samples of one colour", "promises broken");
    captures.into_iter().map(|(name, case)| promises.none(name, move || case.broken())).collect()
}

fn of_budgets() -> Vec<HardCase> {
    let promises = group("budgets at their ends", "promises broken");
    let refused = group("budgets that cannot be kept", "wrong answers");
    let with = |triangles: f64, atlas: u32| {
        let budgets = Budgets { triangles, area: 4.0, peak_overdraw: 20.0 };
        // From off-centre eyes one sees between the edges of so few tiles.
        Case { budgets, atlas, eyes: vec![DVec3::ZERO], ..Case::convex(cube) }
    };
    let small = |area: f64, peak_overdraw: f64| {
        let budgets = Budgets { triangles: 4000.0, area, peak_overdraw };
        Case { budgets, ..Case::new(cube) }
    };
    vec![
        promises.none("12 triangles", move || with(12.0, 1024).broken()),
        promises.none("10^7 triangles", move || with(1e7, 4096).broken()),
        promises.none("an atlas of 12 texels for 6 tiles", move || with(12.0, 12).broken()),
        refused.none("11 triangles", move || Ok(with(11.0, 1024).refused(&["triangles", "12"]))),
        refused.none("an area of 1e-9", move || Ok(small(1e-9, 5.0).refused(&["area", "minimum"]))),
        refused.none("a peak overdraw of 1e-9", move || Ok(small(3.0, 1e-9).refused(&["peak overdraw", "minimum"]))),
        refused.none("an atlas of 4 texels", move || Ok(with(12.0, 4).refused(&["6 tiles", "4 texels", "12"]))),
    ]
}

fn of_textures() -> Vec<HardCase> {
    let textures = group("textures of tiles", "wrong texels");
    let hits = group("rays through tiles at one distance", "wrong hits");
    vec![
        textures.none("no solid texel", || Ok(without_solid())),
        hits.none("two tiles in one plane", || Ok(coincident())),
    ]
}

/// Counts texels that are not black and transparent, for a tile with only free-space constraints or with none.
fn without_solid() -> Measured {
    const TEXELS: usize = 8;
    let mut wrong = Measured::count(0);
    let mut bitmap = ConstraintBitmap::new(TEXELS);
    wrong.count_if(bitmap.is_opaque(), || "opaque without a constraint".to_owned());
    bitmap.add([3.0, 4.0], ConstraintKind::FreeSpace);
    let covered = bitmap.coverage().iter().filter(|alpha| **alpha != 0.0).count();
    wrong.count_if(covered > 0, || format!("{covered} texels are covered"));
    let (light, filled) = LightBuffer::new(TEXELS, TextureFilter::default()).resolve(ShortCuts::Taken);
    wrong.count_if(filled != TEXELS * TEXELS, || format!("{filled} texels were filled"));
    let lit = light.iter().filter(|light| light[..3] != [0.0; 3]).count();
    wrong.count_if(lit > 0, || format!("{lit} texels have light"));
    wrong
}

/// Counts rays that do not hit both of two equal tiles, and samples that are not solid on both.
fn coincident() -> Measured {
    const TEXELS: usize = 16;
    let cell = TreeCell::ROOTS[0];
    let [forward, right, down] = cell.face.axes();
    let plane = TilePlane::fronto_parallel(2.0 * forward);
    let mut tilings = vec![Vec::new(); TreeCell::count(0)];
    tilings[cell.index()] = vec![Tiling { planes: vec![plane; 2], energy: 0.0 }];
    let model = CostModel {
        extent: Extent { min_m: 0.01, max_m: 4.0, margin: 0.0, sway_px_m: 1.0 },
        eyes: vec![DVec3::ZERO],
        texture_coordinates: TextureCoordinates::Affine,
    };
    let tiles = TileSet::new(&[SelectedTiling { cell, tiling: 0 }], &[CandidateLevel { level: 0, tilings }], &model);
    let mut builder = TextureBuilder::new(&tiles, &[TEXELS; 2], 0.01, TextureFilter::default());
    let mut wrong = Measured::count(0);
    let mut samples = Vec::new();
    for at in 0..256u32 {
        let place = [at % 16, at / 16].map(|at| (f64::from(at) + 0.5) / 8.0 - 1.0);
        let end = 2.0 * (forward + place[0] * right + place[1] * down);
        let crossed = Ray::new(DVec3::ZERO, end).map_or(0, |ray| tiles.crossed(&ray).len());
        // A ray through the diagonal of a quad hits both of its triangles; only one counts.
        wrong.count_if(crossed != 2, || format!("ray {at} meets {crossed} tiles"));
        samples.push(Sample { pixel: at, origin: DVec3::ZERO, end, color: COLOR, is_surface: true, weight: 1.0 });
    }
    builder.add(&samples);
    let (solid, free) = (builder.solid, builder.free);
    wrong.count_if((solid, free) != (512, 0), || format!("{solid} solid constraints and {free} of free space"));
    let TileTextures { textures, .. } = builder.finish(ShortCuts::Taken);
    wrong.count_if(textures[0] != textures[1], || "two textures".to_owned());
    wrong
}

fn refusals() -> Vec<HardCase> {
    let refused = group("captures that cannot be simplified", "wrong answers");
    let promises = group("surfaces beside the region", "promises broken");
    // One pixel that looks along x at a surface 2 m away, and a region that ends in front of the surface or behind it.
    let ending_at = |half_m: f64| Case {
        eyes: vec![DVec3::ZERO],
        faces: vec![Face::Px],
        side: 1,
        region: Some(format!("{0:?},{0:?},{0:?},{1:?},{1:?},{1:?}", -half_m, half_m)),
        budgets: Budgets { triangles: 4000.0, area: 3.0, peak_overdraw: 10.0 },
        ..Case::new(|_, _| 2.0)
    };
    let named = ["eye 0, px", "pixel (0, 0)", "viewing region"];
    vec![
        refused.none("a surface a metre inside of the region", move || Ok(ending_at(3.0).refused(&named))),
        refused.none("a surface an ulp inside of the region", move || Ok(ending_at(2f64.next_up()).refused(&named))),
        refused.none("a surface in the side of the region", move || Ok(ending_at(2.0).refused(&named))),
        promises.none("a surface an ulp outside of the region", move || ending_at(2f64.next_down()).broken()),
        refused.none("nothing at all", || Ok(Case::new(nothing).refused(&["no sample"]))),
        refused.none("sky only, and the background transparent", || {
            let case = Case { background: Background::Transparent, ..Case::new(sky) };
            Ok(case.refused(&["no sample"]))
        }),
    ]
}
