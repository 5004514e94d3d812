//! Light fields and cameras for testing the rendering kernels: built-in scenes and difficult sets of views.

use std::time::Instant;

use glam::{DQuat, DVec3};

use crate::Gpu;
use crate::harness::KernelReport;
use crate::render::GpuRenderer;
use crate::render::agreement::Agreement;
use codec::container::ProbeEntry;
use codec::error::{Error, Result};
use codec::image::{DepthKind, Face, ImageProjection, ToneMap, Transfer};
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use kernels::Kernel;
use render::march::render::render;
use render::march::synthetic::set_alpha_of_blocks;
use render::march::{Acceleration, ActiveViews, PictureOptions, Refinements, RenderSettings, Rendered, SpecularMode};
use render::rendered_image::{BackgroundFill, HoleFill};
use render::views::from_images::{FaceImages, from_images};
use render::views::{ColorCoding, LightField, UNKNOWN, View};
use scene::capture::{PassSettings, SamplePattern, Viewpoint, capture_view};
use scene::{DemoKind, DemoScene, Pass, SceneAtTime};

/// Width and height of a captured image in pixels.
const FACE: u32 = 48;
/// Width of a picture in pixels.
const SIZE: u32 = 96;

#[derive(Debug, Clone)]
pub struct PictureCase {
    pub label: &'static str,
    pub field: LightField,
    pub views: Vec<usize>,
    pub camera: Camera,
    pub settings: RenderSettings,
}

impl PictureCase {
    pub fn active(&self) -> ActiveViews<'_> {
        ActiveViews::new(&self.field, &self.views, self.camera.eye())
    }
}

/// Returns all cases; the last one is timed.
pub fn cases() -> Result<Vec<PictureCase>> {
    let codes = ColorCoding::Codes(ToneMap::default());
    let dark = ColorCoding::Codes(ToneMap { transfer: Transfer::Linear, exposure_ev: -1.5 });
    let [courtyard, interior, cornell, object] =
        [DemoKind::Courtyard, DemoKind::Interior, DemoKind::Cornell, DemoKind::Object].map(Captured::of);
    let mirrors = Captured { has_material: true, ..Captured::of(DemoKind::Mirrors) };
    let dull = Captured { has_material: true, ..Captured::of(DemoKind::Courtyard) };
    let (eye, reach) = (courtyard.middle + courtyard.reach * DVec3::new(0.3, -0.2, 0.4), courtyard.reach);
    let around = |at: DVec3| corners(at, reach * 0.7);
    let mut cases = vec![
        courtyard.case("courtyard", &around(courtyard.middle), codes, eye)?,
        interior.case("light, four rays a pixel", &corners(interior.middle, interior.reach), ColorCoding::Light, {
            interior.middle + interior.reach * 0.2
        })?,
        cornell.case("exposure and no curve", &corners(cornell.middle, cornell.reach), dark, cornell.middle)?,
        object.case("background", &corners(object.middle, object.reach), codes, object.middle)?,
        courtyard.case("eye at a probe, which is there twice", &[eye, eye, courtyard.middle], codes, eye)?,
        courtyard.case("far from the origin", &around(courtyard.middle), codes, eye)?,
        courtyard.case("images missing, texels not known", &around(courtyard.middle), codes, eye)?,
        courtyard.case("no views", &[], codes, eye)?,
        interior.case("inside a surface", &corners(interior.middle, interior.reach * 0.5), codes, {
            interior.middle + 3.0 * interior.reach
        })?,
        interior.pictures("turned perspective images", codes)?,
        courtyard.case("more images than layers", &crowd(courtyard.middle, reach), codes, eye)?,
        dull.case("materials that send nothing on", &around(courtyard.middle), codes, eye)?,
        mirrors.case("mirrors and glass", &corners(mirrors.middle, mirrors.reach * 0.4), codes, mirrors.middle)?,
        courtyard.case("near and far planes", &around(courtyard.middle), codes, eye)?,
        courtyard.case("alpha", &around(courtyard.middle), codes, eye)?,
        object.case(
            "alpha, and a transparent background",
            &corners(object.middle, object.reach),
            ColorCoding::Light,
            object.middle,
        )?,
        courtyard.case("courtyard, twice as wide", &around(courtyard.middle), codes, eye)?,
    ];
    cases[1].settings.samples = 2;
    cases[2].settings.samples = 4;
    let away = DVec3::new(1e6, -2e5, 3e6);
    cases[5].field.views.iter_mut().for_each(|view| view.position += away);
    cases[5].camera = looking(eye + away)?;
    for (case, specular) in [(11, SpecularMode::Force), (12, SpecularMode::Auto)] {
        cases[case].settings.specular = specular;
    }
    let lens = Lens { near_m: 2.0, far_m: 6.0, ..Lens::new(80.0) };
    cases[13].camera = Camera::look_at(eye, eye + DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, lens)?;
    // Look towards both spheres.
    let eye = cases[12].camera.eye();
    cases[12].camera = Camera::look_at(eye, eye + DVec3::new(0.0, -0.8, -1.6), DVec3::Y, Lens::new(85.0))?;
    // The paper's algorithm, without refinements.
    for case in [0, 8, 13] {
        cases[case].settings.refinements = Refinements::NONE;
    }
    for case in [14, 15] {
        cases[case].field.views.iter_mut().for_each(|view| set_alpha_of_blocks(view, [8, 5]));
    }
    cases[15].settings.background = BackgroundFill::Transparent;
    hide(&mut cases[6].field);
    cases[6].settings.holes = HoleFill::Nearest;
    let steps = &mut cases[6].settings.steps;
    *steps = steps.with_refine(0);
    if let Some(last) = cases.last_mut() {
        last.settings.size = [2 * SIZE, 2 * SIZE];
    }
    Ok(cases)
}

#[derive(Debug, Clone)]
pub struct PictureResult {
    pub agreement: Agreement,
    pub on_device: Rendered,
    pub on_cpu: Rendered,
}

pub fn run(gpu: &Gpu, case: &PictureCase) -> Result<PictureResult> {
    let views = case.active();
    let mut renderer = GpuRenderer::new(gpu, case.field.coding);
    let on_device = renderer.render(&views, &case.camera, &case.settings, &Silent)?;
    let on_cpu = render(&views, &case.camera, &case.settings, &Silent)?;
    Ok(PictureResult { agreement: Agreement::of(&on_device, &on_cpu)?, on_device, on_cpu })
}

pub(super) fn test(gpu: &Gpu, kernel: &'static Kernel) -> Result<KernelReport> {
    let mut report = KernelReport::new(kernel.name);
    let mut cases = cases()?;
    if kernel.name == kernels::RENDER_EFFECTS.name {
        cases.retain(|case| case.settings.specular != SpecularMode::None);
    } else {
        cases.iter_mut().for_each(|case| case.settings.specular = SpecularMode::None);
    }
    if kernel.name == kernels::RENDER.name {
        cases.iter_mut().for_each(|case| case.settings.acceleration = Acceleration::None);
    }
    for case in &cases {
        let agreement = run(gpu, case)?.agreement;
        report.inputs += 1;
        report.mismatches += agreement.mismatches();
        if agreement.mismatches() > 0 && report.first.is_none() {
            report.first = Some(format!("{}: {agreement:?}", case.label));
        }
    }
    if let Some(case) = cases.last() {
        let (views, mut renderer) = (case.active(), GpuRenderer::new(gpu, case.field.coding));
        renderer.upload(&views)?;
        let start = Instant::now();
        renderer.render(&views, &case.camera, &case.settings, &Silent)?;
        let pixels = f64::from(case.settings.size[0]) * f64::from(case.settings.size[1]);
        report.megapixels_per_second = pixels / 1e6 / start.elapsed().as_secs_f64().max(1e-9);
    }
    Ok(report)
}

struct Captured {
    scene: SceneAtTime,
    middle: DVec3,
    reach: DVec3,
    has_material: bool,
}

impl Captured {
    fn of(kind: DemoKind) -> Captured {
        let scene = DemoScene::new(kind);
        let (middle, reach) = scene.probe_region();
        Captured { scene: scene.at(0.4), middle, reach, has_material: false }
    }

    /// Returns a case with cube maps captured at these positions.
    fn case(&self, label: &'static str, places: &[DVec3], coding: ColorCoding, eye: DVec3) -> Result<PictureCase> {
        let side = if places.len() > 12 { 8 } else { FACE };
        let windows = Face::CUBE.map(|face| (face, ImageProjection::cube_face(face, side)));
        let views = places.iter().enumerate().map(|(at, &place)| self.view((at, place, None), &windows, coding));
        self.seen_by(label, LightField { views: views.collect::<Result<_>>()?, coding }, eye)
    }

    /// Returns a case with rotated perspective images of different sizes.
    fn pictures(&self, label: &'static str, coding: ColorCoding) -> Result<PictureCase> {
        let places = corners(self.middle, self.reach * 0.3);
        let views = places.iter().enumerate().map(|(at, &place)| {
            let turn = DQuat::from_rotation_y(0.1 * at as f64 - 0.35) * DQuat::from_rotation_z(0.05 * at as f64);
            let size = [FACE + 3 * at as u32, FACE - at as u32];
            let intrinsics = [20.0, 21.0, f64::from(size[0]) * 0.45, f64::from(size[1]) * 0.55];
            let window = ImageProjection::Pinhole { size, intrinsics };
            self.view((at, place, Some(turn)), &[(Face::View, window)], coding)
        });
        self.seen_by(label, LightField { views: views.collect::<Result<_>>()?, coding }, self.middle)
    }

    fn seen_by(&self, label: &'static str, field: LightField, eye: DVec3) -> Result<PictureCase> {
        let views: Vec<usize> = (0..field.views.len()).collect();
        let active = ActiveViews::new(&field, &views, eye);
        let options = PictureOptions {
            size: [SIZE, SIZE - 11],
            steps: 96,
            far_m: Some(active.far_m().max(1.0)),
            specular: SpecularMode::None,
            ..PictureOptions::default()
        };
        let settings = options.settings(&active);
        Ok(PictureCase { label, views, camera: looking(eye)?, settings, field })
    }

    fn view(
        &self,
        (at, position, turn): (usize, DVec3, Option<DQuat>),
        windows: &[(Face, ImageProjection)],
        coding: ColorCoding,
    ) -> Result<View> {
        let samples = SamplePattern::new(1)?;
        let passes = [Pass::Color, Pass::Depth, Pass::Material];
        let settings =
            PassSettings { passes: &passes, samples: &samples, depth: DepthKind::Planar, far_m: f64::INFINITY };
        let mut entry = ProbeEntry {
            name: format!("{at}"),
            position: position.to_array(),
            orientation: turn.unwrap_or(DQuat::IDENTITY).to_array(),
            frames: [0, 0],
            intrinsics: [0.0; 4],
        };
        let mut images = Vec::new();
        for &(face, projection) in windows {
            let from = Viewpoint { position, orientation: turn, projection };
            let image = capture_view(&self.scene, &from, &settings, &Silent)?;
            let (Some(color), Some(depth)) = (image.color, image.depth) else {
                return Err(Error::invalid("a capture without colour and depth"));
            };
            if let ImageProjection::Pinhole { intrinsics, .. } = projection {
                entry.intrinsics = intrinsics;
            }
            let material = image.material.filter(|_| self.has_material);
            images.push(FaceImages { face, color, alpha: None, depth, kind: DepthKind::Planar, material });
        }
        from_images(at, &entry, &images, coding)
    }
}

/// Returns the corners of a box, and a point near its centre.
fn corners(middle: DVec3, half: DVec3) -> Vec<DVec3> {
    let sign = |at: u32, bit: u32| if at >> bit & 1 == 0 { -1.0 } else { 1.0 };
    let mut places: Vec<DVec3> =
        (0..8).map(|at| middle + half * DVec3::new(sign(at, 0), sign(at, 1), sign(at, 2))).collect();
    places.push(middle + half * 0.05);
    places
}

/// Returns more positions than a device has texture layers for cube maps.
fn crowd(middle: DVec3, half: DVec3) -> Vec<DVec3> {
    let part = |at: usize, prime: usize| (at * prime % 47) as f64 / 23.0 - 1.0;
    (0..44).map(|at| middle + half * DVec3::new(part(at, 5), part(at, 11), part(at, 17))).collect()
}

/// Returns a camera that looks along a diagonal, so that no ray is parallel to a cube face.
fn looking(eye: DVec3) -> Result<Camera> {
    Camera::look_at(eye, eye + DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, Lens { aspect: 1.13, ..Lens::new(80.0) })
}

/// Removes some images, and marks texels of the others as unknown.
fn hide(field: &mut LightField) {
    for (at, view) in field.views.iter_mut().enumerate() {
        view.faces[at % 6] = None;
        for (face, texels) in view.faces.iter_mut().enumerate() {
            let Some(texels) = texels else { continue };
            let width = texels.size[0] as usize;
            for (texel, depth) in texels.inverse_depth.iter_mut().enumerate() {
                if (texel % width / 16 + texel / width / 16 + at + face).is_multiple_of(3) {
                    *depth = UNKNOWN;
                }
            }
        }
    }
}
