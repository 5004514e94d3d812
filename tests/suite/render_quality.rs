//! Regression test of rendered pictures against tests/baselines/render.csv, one row for each dataset and method.
//!
//! A probe of each dataset is excluded and rendered from the others.
//! `cargo test --test suite render_quality::write_baselines -- --ignored` rewrites the file after an intended change.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use codec::color::SearchSettings;
use codec::container::Reader;
use codec::decode::Decoder;
use codec::image::plane::DepthPlane;
use codec::image::{Face, FrameRange};
use codec::math::{Camera, Lens};
use codec::metrics::psnr::SquaredError;
use codec::metrics::pu21::DEFAULT_WHITE_CD_M2;
use codec::monitor::Silent;
use codec::streams::ColorFormat;
use evaluate::reference::{Reference, ReferenceImage};
use evaluate::similarity::Similarity;
use footage::dataset::cameras::{CameraSet, PlacedCamera};
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::{ColorCodec, DepthCodec, DepthSettings, EncodeSettings, TileSize, encode};
use glam::DVec3;
use render::frame_requests::FrameRequest;
use render::march::baseline::reproject::ReprojectRenderer;
use render::march::baseline::splat::SplatRenderer;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions, Renderer};
use render::march::render::Rendered;
use render::march::settings::{Refinements, SpecularMode};
use render::rendered_image::HoleFill;
use render::views::catalogue::ProbeChoice;
use render::views::light_field::{ColorCoding, ColorTexels};
use scene::{DemoKind, DemoScene, FootagePlan, Pass, Scene};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/baselines/render.csv");
const HEAD: &str = "set,probe,method,psnr_db,ssim,hole_percent";
/// Tolerance in dB, and in percentage points of holes: logarithms of other processors may change a few rays.
const SLACK: f64 = 0.02;

/// Rendering methods under test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Method {
    March,
    Calf,
    Splat,
    Reproject,
}

const METHODS: [(&str, Method); 4] =
    [("march", Method::March), ("calf", Method::Calf), ("splat", Method::Splat), ("reproject", Method::Reproject)];

/// Returns the renderer of a method; reprojection uses a true distance for each pixel.
fn renderer(method: Method, size: [u32; 2], distance_m: Option<DepthPlane>) -> Box<dyn Renderer> {
    let options = PictureOptions { size, ..PictureOptions::default() };
    let options = match method {
        Method::March => options,
        Method::Calf => PictureOptions { refinements: Refinements::NONE, ..options },
        // Pixels that these methods do not cover count as black.
        Method::Splat | Method::Reproject => PictureOptions { holes: HoleFill::Blank, ..options },
    };
    match method {
        Method::March | Method::Calf => Box::new(CpuRenderer::new(options)),
        Method::Splat => Box::new(SplatRenderer { options }),
        Method::Reproject => Box::new(ReprojectRenderer { options, distances_m: distance_m.into_iter().collect() }),
    }
}

/// Similarity between the pictures of a method and the images of one probe in frame 0, over all pixels.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    set: String,
    probe: String,
    method: &'static str,
    psnr_db: f64,
    ssim: f64,
    hole_percent: f64,
}

impl Row {
    fn line(&self) -> String {
        let Row { set, probe, method, psnr_db, ssim, hole_percent } = self;
        format!("{set},{probe},{method},{psnr_db:.3},{ssim:.4},{hole_percent:.3}")
    }
}

/// Encodes frame 0 with default settings and returns its decoder.
fn encoded(folder: &Path) -> Decoder {
    encoded_with(folder, &EncodeSettings::default())
}

/// Returns settings with colour close to the source and the depth codec of the baselines, so that rows measure reconstruction
/// only.
fn of_baselines() -> EncodeSettings {
    EncodeSettings {
        color_codec: ColorCodec::Cells,
        search: SearchSettings::default(),
        depth: DepthSettings { codec: DepthCodec::Quadtree, ..DepthSettings::default() },
        ..EncodeSettings::default()
    }
}

fn encoded_with(folder: &Path, settings: &EncodeSettings) -> Decoder {
    let options = SourceOptions { frames: Some(FrameRange { first: 0, last: 0 }), ..SourceOptions::default() };
    let source = Source::open(folder, &options).unwrap();
    let (bytes, _) = encode(&source, settings, Vec::new(), &Silent).unwrap();
    Decoder::new(Reader::from_memory(bytes).unwrap()).unwrap()
}

fn picture(playback: &mut Playback<'_>, camera: Camera, renderer: &mut dyn Renderer) -> Rendered {
    let request = FrameRequest { frame: 0, cameras: vec![camera] };
    playback.show(&request, renderer, &Silent).unwrap().pictures.remove(0)
}

fn measure(set: &str, folder: &Path, probe: &str) -> Vec<Row> {
    let decoder = encoded_with(folder, &of_baselines());
    let mut reference = Reference::open(folder).unwrap();
    let images = reference.images.to_vec();
    let mut rows = Vec::new();
    for (name, method) in METHODS {
        let probes = ProbeChoice { without: vec![probe.into()], ..ProbeChoice::default() };
        let mut playback = Playback::new(&decoder, PlaybackOptions { probes, ..PlaybackOptions::default() }).unwrap();
        let tone = playback.player.field.coding.tone();
        let mut sum = Similarity::empty();
        for (at, image) in images.iter().enumerate().filter(|(_, image)| image.probe == probe) {
            let truth = reference.truth(at, 0).unwrap();
            let distance_m = reference.distance_m(at, 0).unwrap();
            let mut by = renderer(method, image.size, distance_m);
            let rendered = picture(&mut playback, image.camera(0), by.as_mut());
            sum.merge(&Similarity::of(&rendered.image, &truth, tone).unwrap()).unwrap();
        }
        assert_eq!(sum.images, 6);
        rows.push(Row {
            set: set.into(),
            probe: probe.into(),
            method: name,
            psnr_db: sum.all.psnr_db(),
            ssim: sum.ssim().unwrap(),
            hole_percent: sum.hole_percent(),
        });
    }
    rows
}

/// Captures one frame of a scene from nine probes: one in the middle of the scene's probe region, and eight at its corners.
fn capture(kind: DemoKind, face_size: u32, folder: &Path) {
    let mut plan = FootagePlan { kind, frames: 1, face_size, probes: 1 }.capture().unwrap();
    let (middle, reach) = DemoScene::new(kind).probe_region();
    let offsets = (0..8u32).map(|corner| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 }));
    let at = |offset: [f64; 3]| PlacedCamera::at((middle + DVec3::from_array(offset) * reach).to_array());
    plan.cameras = CameraSet::new(std::iter::once([0.0; 3]).chain(offsets).map(at).collect());
    if kind == DemoKind::Mirrors {
        plan.passes.push(Pass::Material);
    }
    plan.write(&Scene::Procedural(DemoScene::new(kind)), folder, &Silent).unwrap();
}

fn of_scene(kind: DemoKind) -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    capture(kind, 64, folder.path());
    measure(kind.name(), folder.path(), "00")
}

const SCENES: [DemoKind; 4] = [DemoKind::Courtyard, DemoKind::Interior, DemoKind::Mirrors, DemoKind::Fence];

fn scenes() -> Vec<Row> {
    SCENES.into_iter().flat_map(of_scene).collect()
}

/// Returns the folder of a dataset of the footage.
fn footage(set: &str) -> PathBuf {
    Path::new(option_env!("LIGHTFOLD_DATA").unwrap_or("no data")).join(set)
}

fn shared() -> Vec<Row> {
    let measured = |(set, probe)| measure(set, &footage(set), probe);
    [("sponza9", "00"), ("glass", "00")].into_iter().flat_map(measured).collect()
}

fn check(rows: &[Row]) {
    let text = std::fs::read_to_string(FILE).unwrap();
    assert_eq!(text.lines().next(), Some(HEAD));
    for row in rows {
        println!("{}", row.line());
        let key = format!("{},{},{},", row.set, row.probe, row.method);
        let line = text.lines().find(|line| line.starts_with(&key)).unwrap_or_else(|| panic!("{key} has no baseline"));
        let numbers: Vec<f64> = line[key.len()..].split(',').map(|number| number.parse().unwrap()).collect();
        assert!(row.psnr_db >= numbers[0] - SLACK, "{key} {} dB are less than {}", row.psnr_db, numbers[0]);
        assert!(row.ssim >= numbers[1] - 0.001, "{key} an SSIM of {} is less than {}", row.ssim, numbers[1]);
        assert!(
            row.hole_percent <= numbers[2] + SLACK,
            "{key} {}% holes are more than {}",
            row.hole_percent,
            numbers[2]
        );
    }
}

/// Returns the PSNR in dB of a method for a dataset.
fn psnr(rows: &[Row], set: &str, method: &str) -> f64 {
    rows.iter().find(|row| row.set == set && row.method == method).unwrap().psnr_db
}

#[test]
fn pictures_of_scenes_are_no_worse_and_better_than_points_and_true_distances() {
    let rows = scenes();
    check(&rows);
    for kind in SCENES {
        let [march, splat, best] = ["march", "splat", "reproject"].map(|method| psnr(&rows, kind.name(), method));
        assert!(march >= splat + 2.5, "{}: {march} dB by marching, {splat} dB by points", kind.name());
        // Reprojection has the true distance of one point per pixel and no layers behind it.
        assert!(march >= best, "{}: {march} dB by marching, {best} dB by true distances", kind.name());
    }
}

/// Renders the six faces of probe 00 of `mirrors` with all probes, from an eye `right_m` metres along +X of the probe.
fn beside_a_probe(decoder: &Decoder, reference: &Reference, specular: SpecularMode, right_m: f64) -> Vec<Rendered> {
    let mut playback = Playback::new(decoder, PlaybackOptions::default()).unwrap();
    let images = reference.images.iter().filter(|image| image.probe == "00");
    let of_image = |image: &ReferenceImage| {
        let camera = image.camera(0).moved(DVec3::X * right_m);
        let options = PictureOptions { size: image.size, specular, ..PictureOptions::default() };
        picture(&mut playback, camera, &mut CpuRenderer::new(options))
    };
    images.map(of_image).collect()
}

#[test]
fn pictures_become_what_a_probe_recorded_as_the_eye_comes_to_it() {
    let folder = tempfile::tempdir().unwrap();
    capture(DemoKind::Mirrors, 64, folder.path());
    let decoder = encoded_with(folder.path(), &of_baselines());
    let mut reference = Reference::open(folder.path()).unwrap();
    let probe: Vec<usize> = (0..reference.images.len()).filter(|&at| reference.images[at].probe == "00").collect();
    let tone = Playback::new(&decoder, PlaybackOptions::default()).unwrap().player.field.coding.tone();
    let mut psnr_of = |specular: SpecularMode| {
        let mut sum = Similarity::empty();
        for (rendered, &at) in beside_a_probe(&decoder, &reference, specular, 0.0).iter().zip(&probe) {
            let truth = reference.truth(at, 0).unwrap();
            sum.merge(&Similarity::of(&rendered.image, &truth, tone).unwrap()).unwrap();
        }
        sum.all.psnr_db()
    };
    let [with, without] = [SpecularMode::Auto, SpecularMode::None].map(&mut psnr_of);
    println!("{with} dB with effects, {without} dB without");
    // At silhouettes the nearest texel may belong to another surface.
    assert!(with >= 45.0 && with >= without - 3.0, "{with} dB with effects, {without} dB without");
    // As the eye moves to the probe and past it, consecutive pictures differ by at most twice the median difference.
    let at = |step: i32| beside_a_probe(&decoder, &reference, SpecularMode::Auto, 0.01 * f64::from(step));
    let pictures: Vec<Vec<Rendered>> = (-6..=6).map(at).collect();
    let difference = |pair: &[Vec<Rendered>]| -> f64 {
        let faces = pair[0].iter().zip(&pair[1]);
        let squares =
            faces.flat_map(|(a, b)| a.image.color.data().iter().flatten().zip(b.image.color.data().iter().flatten()));
        squares.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    };
    let mut differences: Vec<f64> = pictures.windows(2).map(difference).collect();
    println!("{differences:?}");
    differences.sort_by(f64::total_cmp);
    let [median, largest] = [differences[differences.len() / 2], differences[differences.len() - 1]];
    assert!(largest <= 2.0 * median, "{differences:?}");
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn pictures_of_real_footage_are_no_worse_and_good_enough() {
    let rows = shared();
    assert_eq!(rows.len(), 2 * METHODS.len());
    check(&rows);
    let [march, splat] = ["march", "splat"].map(|method| psnr(&rows, "sponza9", method));
    assert!(march >= 31.5 && march >= splat + 4.0, "{march} dB by marching, {splat} dB by points");
}

/// Renders a probe of the set `glass` from the others. Returns the gain in dB from effects in mirrors and in glass.
fn gains_of_effects(decoder: &Decoder, probe: &str) -> [f64; 2] {
    let mut reference = Reference::open(&footage("glass")).unwrap();
    let images = reference.images.to_vec();
    let [with, without] = [SpecularMode::Auto, SpecularMode::None].map(|specular| {
        let probes = ProbeChoice { without: vec![probe.into()], ..ProbeChoice::default() };
        let mut playback = Playback::new(decoder, PlaybackOptions { probes, ..PlaybackOptions::default() }).unwrap();
        let tone = playback.player.field.coding.tone();
        let mut sum = Similarity::empty();
        for (at, image) in images.iter().enumerate().filter(|(_, image)| image.probe == probe) {
            let options = PictureOptions { size: image.size, specular, ..PictureOptions::default() };
            let rendered = picture(&mut playback, image.camera(0), &mut CpuRenderer::new(options));
            sum.merge(&Similarity::of(&rendered.image, &reference.truth(at, 0).unwrap(), tone).unwrap()).unwrap();
        }
        sum
    });
    let gain = |of: fn(&Similarity) -> &SquaredError| of(&with).psnr_db() - of(&without).psnr_db();
    let [mirrors, glass] = [gain(|sum| &sum.mirrors), gain(|sum| &sum.glass)];
    println!("probe {probe}: {mirrors} dB in mirrors, {glass} dB in glass");
    [mirrors, glass]
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn effects_gain_3_db_in_mirrors_and_in_glass_of_half_floats() {
    let color = ColorFormat::Half { white_cd_m2: DEFAULT_WHITE_CD_M2 };
    let decoder = encoded_with(&footage("glass"), &EncodeSettings { color, ..EncodeSettings::default() });
    for probe in ["00", "01"] {
        let gains = gains_of_effects(&decoder, probe);
        assert!(gains.iter().all(|gain| *gain >= 3.0), "{probe}: {gains:?} dB");
    }
}

/// Glass reflects too little, because 8 bits clip lamps. Depth is coded in quadtrees, which preserve surface normals better: with
/// predictive depth, whose errors are larger within the same bound, mirrors gain 2.8 dB.
#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
#[cfg_attr(all(footage_at_hand, not(all_tests)), ignore = "long: scripts/test all runs it")]
fn effects_gain_3_db_in_mirrors_and_1_in_glass_of_8_bits() {
    let depth = DepthSettings { codec: DepthCodec::Quadtree, ..DepthSettings::default() };
    let settings = EncodeSettings { depth, ..EncodeSettings::default() };
    let [mirrors, glass] = gains_of_effects(&encoded_with(&footage("glass"), &settings), "00");
    assert!(mirrors >= 3.0 && glass >= 1.0, "{mirrors} dB in mirrors, {glass} dB in glass");
}

/// Faces of 128 pixels have four cells and one tile of the default size, so views along an axis read more than half of the bytes.
/// With cells and tiles as small relative to a face as in larger datasets, no view does.
#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
#[cfg_attr(all(footage_at_hand, not(all_tests)), ignore = "long: scripts/test all runs it")]
fn a_view_of_90_degrees_of_real_footage_reads_at_most_half_of_the_bytes() {
    let usual = encoded(&footage("sponza9"));
    let tiles = TileSize::PerSide(4);
    let small = encoded_with(&footage("sponza9"), &EncodeSettings { cell: 16, tiles, ..EncodeSettings::default() });
    let read = |decoder: &Decoder, way: DVec3| {
        let mut playback = Playback::new(decoder, PlaybackOptions::default()).unwrap();
        let eye = DVec3::new(-0.5, 1.75, -0.35);
        let camera = Camera::look_at(eye, eye + way, DVec3::Y, Lens::new(90.0)).unwrap();
        let options = PictureOptions { size: [4, 4], steps: 8, ..PictureOptions::default() };
        playback
            .show(&FrameRequest { frame: 0, cameras: vec![camera] }, &mut CpuRenderer::new(options), &Silent)
            .unwrap();
        let counts = playback.summary().counts;
        println!("{} of {} bytes towards {way}", counts.bytes_read, counts.bytes_all);
        counts.bytes_read as f64 / counts.bytes_all as f64
    };
    let slanting = DVec3::new(2.5, -0.25, 0.35);
    assert!(read(&usual, slanting) <= 0.5);
    for way in [slanting, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 0.2, 1.0)] {
        assert!(read(&small, way) <= 0.5, "{way}");
    }
}

#[test]
fn a_probe_that_takes_part_comes_back_code_by_code() {
    let folder = tempfile::tempdir().unwrap();
    capture(DemoKind::Courtyard, 24, folder.path());
    let decoder = encoded(folder.path());
    let mut reference = Reference::open(folder.path()).unwrap();
    let images = reference.images.to_vec();
    let probes = ProbeChoice { only: vec!["03".into()], ..ProbeChoice::default() };
    let mut playback = Playback::new(&decoder, PlaybackOptions { probes, ..PlaybackOptions::default() }).unwrap();
    for (at, image) in images.iter().enumerate().filter(|(_, image)| image.probe == "03") {
        for (name, method) in METHODS {
            let distance_m = reference.distance_m(at, 0).unwrap();
            let rendered = picture(&mut playback, image.camera(0), renderer(method, image.size, distance_m).as_mut());
            let field = &playback.player.field;
            let ColorCoding::Codes(tone) = field.coding else { panic!("8-bit colour was asked for") };
            let Some(ColorTexels::Codes(texels)) = field.views[0].faces[image.face as usize].as_ref().map(|f| &f.color)
            else {
                panic!("8-bit colour was asked for")
            };
            let codes: Vec<[u8; 4]> = rendered
                .image
                .color
                .data()
                .iter()
                .map(|light| {
                    let [r, g, b] = light.map(|light| tone.code(light));
                    [r, g, b, 0]
                })
                .collect();
            assert!(rendered.image.alpha.data().iter().all(|alpha| *alpha == 1.0), "{name} {}", image.face.name());
            let wrong = codes.iter().zip(texels).filter(|(a, b)| a != b).count();
            assert_eq!(wrong, 0, "{name} {}", image.face.name());
            assert!(image.face != Face::View);
        }
    }
}

#[test]
#[ignore = "writes tests/baselines"]
fn write_baselines() {
    let mut text = format!("{HEAD}\n");
    let of_footage = if cfg!(footage_at_hand) { shared() } else { Vec::new() };
    for row in scenes().iter().chain(&of_footage) {
        writeln!(text, "{}", row.line()).unwrap();
    }
    std::fs::write(FILE, text).unwrap();
}
