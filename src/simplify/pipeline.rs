//! Runs all stages, from a capture to a textured mesh and its statistics.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::capture::Capture;
use super::cracks::{OPAQUE_ALPHA, PlacedTiles, eye_side};
use super::extended::Surroundings;
use super::fidelity::{self, Evaluation};
use super::gaps::SeenDirections;
use super::gbuffer::{SurfaceAtlas, TexturedTiles};
use super::geometry_bytes::GeometryBytes;
use super::memory::check_textures;
use super::quad_mesh::{AtlasLight, QuadMesh};
use super::region::ViewingRegion;
use super::selected::{Counts, SelectedTiles, select};
use super::selection::Selection;
use super::settings::{Settings, SurfaceAtlases};
use super::shading::ShortCuts;
use super::texturing::{Textured, Texturing, depth_note};
use super::tiles::{TileForm, TileSet};
use codec::error::Result;
use codec::monitor::Monitor;
use footage::json;

/// Fraction of rays without support above which a note says so.
const MAX_UNSUPPORTED: f64 = 0.002;

/// Durations of the stages.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Stages {
    #[serde(serialize_with = "json::seconds")]
    pub merge: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub candidates: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub selection: Duration,
    /// Constraints, with the colour that is found in the same pass over all samples.
    #[serde(serialize_with = "json::seconds")]
    pub silhouettes: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub shading: Duration,
    #[serde(serialize_with = "json::seconds")]
    pub atlas: Duration,
    /// Extension of tiles over gaps, and closing of cracks.
    #[serde(serialize_with = "json::seconds")]
    pub gaps: Duration,
    /// Writing of files, done by the caller.
    #[serde(serialize_with = "json::seconds")]
    pub export: Duration,
    /// Duration of [`Simplified::evaluate`].
    #[serde(serialize_with = "json::seconds")]
    pub evaluate: Duration,
}

/// Counts of the work that the stages did.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Counters {
    pub solid_constraints: u64,
    pub free_space_constraints: u64,
    /// Number of samples along which there is no tile.
    pub samples_without_tile: u64,
    /// Number of tiles that were extended over gaps.
    pub extended_tiles: u64,
    /// Number of opaque tiles, which have no silhouette.
    pub opaque_tiles: u64,
    /// Number of samples in the viewing region that were left out.
    pub dropped_samples: u64,
    /// Number of tiles with a silhouette.
    pub silhouettes: u64,
    /// Number of texels without a sample, whose colour was filled in, and number of tiles with such texels.
    pub filled_texels: u64,
    pub filled_tiles: u64,
    /// Number of tiles with a smaller texture than requested, so that the atlas fits.
    pub reduced_tiles: u64,
    pub closed_cracks: u64,
    /// Number of closed pixels that were translucent in front of the sky, which covers everything.
    pub closed_translucent: u64,
    /// Number of texels that are also stored as half floats.
    pub float_texels: u64,
    /// Number of tree cells with samples. Other cells have no tiling.
    pub fitted_cells: u64,
    /// Number of blended triangles. Those of opaque tiles are not blended.
    pub blended_triangles: u64,
    /// Bytes of the mesh in binary glTF, plain and with EXT_meshopt_compression.
    pub geometry_bytes: u64,
    pub geometry_bytes_meshopt: u64,
}

impl Stages {
    fn add(&mut self, textured: &Textured) {
        let [constraints, textures, atlas] = textured.durations;
        self.silhouettes += constraints;
        self.shading += textures;
        self.atlas += atlas;
    }
}

impl Counters {
    fn add(&mut self, textured: &Textured) {
        self.solid_constraints += textured.solid_constraints;
        self.free_space_constraints += textured.free_space_constraints;
        self.samples_without_tile += textured.uncovered_samples;
        self.opaque_tiles += textured.opaque_tiles;
        self.silhouettes += textured.layout.places.len() as u64 - textured.opaque_tiles;
        self.filled_texels += textured.filled_texels;
        self.filled_tiles += textured.filled_tiles;
        self.reduced_tiles += textured.layout.reduced as u64;
    }
}

/// The simplified scene, and its statistics.
#[derive(Debug)]
pub struct Simplified {
    pub scene: QuadMesh,
    pub surfaces: Option<SurfaceAtlas>,
    pub region: ViewingRegion,
    pub selection: Selection,
    /// Triangles, area in spheres, and the measured overdraw of the view with the most.
    pub used: [f64; 3],
    /// Fraction of the rays from eyes in the region that meet no surface that a camera has seen; `None` without a sky.
    pub unsupported: Option<f64>,
    pub counts: Counts,
    pub tiles: u64,
    pub atlas: [u32; 2],
    /// Number of texels that belong to tiles.
    pub used_texels: u64,
    pub stages: Stages,
    pub counters: Counters,
    pub seen: SeenDirections,
    pub notes: Vec<String>,
}

impl Simplified {
    /// Compares pictures of the scene with the capture that it was made from, and counts cracks from random poses.
    pub fn evaluate(&self, capture: &mut Capture, settings: &Settings, monitor: &dyn Monitor) -> Result<Evaluation> {
        let begun = Instant::now();
        let fidelity = fidelity::compare(&self.scene, capture, settings, monitor)?;
        let poses = fidelity::random_poses(&self.scene, &self.region, &self.seen)?;
        Ok(Evaluation { fidelity, poses, duration: begun.elapsed() })
    }
}

/// Returns the number of steps that a run reports to its monitor.
pub fn steps(images: usize) -> u64 {
    // Merging, texturing twice, and closing cracks.
    4 * images as u64
}

/// Simplifies a capture.
pub fn simplify(capture: &mut Capture, settings: &Settings, monitor: &dyn Monitor) -> Result<Simplified> {
    let selected = select(capture, settings, monitor)?;
    texture(selected, capture, settings, monitor)
}

/// Makes a textured mesh from tiles that were selected for a capture with the same settings.
pub fn texture(
    selected: SelectedTiles,
    capture: &mut Capture,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Simplified> {
    let SelectedTiles {
        region,
        surface_m,
        seen,
        tiles,
        selection,
        used,
        unsupported,
        counts,
        durations,
        mut notes,
        ..
    } = selected;
    let [merge, candidates, of_selection, gaps] = durations;
    let mut stages = Stages { merge, candidates, selection: of_selection, gaps, ..Stages::default() };
    let mut counters = Counters {
        dropped_samples: counts.dropped_samples,
        fitted_cells: counts.fitted_cells,
        extended_tiles: counts.extended_tiles,
        ..Counters::default()
    };
    let eye_m = capture.images.iter().map(|image| (image.eye - region.middle).abs().max_element()).fold(0.0, f64::max);
    let farthest_m = if surface_m > 0.0 { surface_m.max(eye_m) } else { 0.0 };
    let sky_m = region.scene_sky_m(farthest_m);
    let tiles = TileSet::in_order(tiles, TileForm { coordinates: settings.texture_coordinates, sky_m });
    let texturing = Texturing::new(capture, settings, &region);
    notes.extend(depth_note(capture));
    if let Some(share) = unsupported.filter(|share| *share > MAX_UNSUPPORTED) {
        notes.push(format!(
            "{:.1}% of the rays from the viewing region meet no surface that a camera has seen, and show what is behind or \
            beside it: capture from more places (the paper from 32 to 64: `uniform` of place makes them), or set a smaller `region`",
            100.0 * share
        ));
    }
    let Texturing { rules, solid_threshold, .. } = texturing;
    check_textures(capture, &texturing.sides(&tiles), settings)?;
    let textured = texturing.run(&tiles, capture, monitor)?;
    stages.add(&textured);
    counters.add(&textured);
    let begun = Instant::now();
    let Textured { mut scene, layout, .. } = textured;
    scene.pull_in(region.middle, sky_m);
    counters.blended_triangles = scene.runs.iter().step_by(2).map(|&count| u64::from(count)).sum();
    counters.float_texels = scene.light.as_ref().map_or(0, Vec::len) as u64;
    // Without runs, all triangles are blended.
    let runs = scene.runs.clone();
    if settings.short_cuts == ShortCuts::Off {
        scene.runs.clear();
    }
    let drawn = tiles.as_drawn();
    let placed = PlacedTiles { tiles: &drawn, layout: &layout };
    let seams =
        Surroundings { region: &region, seen: &seen, background: settings.background, eye_side: eye_side(capture) };
    let pictures = seams.pictures(&scene, OPAQUE_ALPHA, monitor)?;
    counters.closed_cracks += placed.close_in_pictures(&pictures, &mut scene);
    drop(pictures);
    for image in 0..capture.images.len() {
        monitor.check()?;
        let closed = placed.close_in_image(capture, image, &rules, &mut scene)?;
        counters.closed_cracks += closed.cracks;
        counters.closed_translucent += closed.translucent;
        monitor.advance(1);
    }
    scene.runs = runs;
    let geometry = GeometryBytes::of(&scene)?;
    (counters.geometry_bytes, counters.geometry_bytes_meshopt) = (geometry.plain, geometry.meshopt);
    scene.light = scene.light.filter(|_| settings.light == AtlasLight::HalfFloats);
    stages.gaps += begun.elapsed();
    let begun = Instant::now();
    let tiles_in_atlas =
        TexturedTiles { tiles: &tiles, layout: &layout, solid_threshold, filter: settings.texture_filter };
    let surfaces = match settings.surfaces {
        SurfaceAtlases::None => None,
        SurfaceAtlases::GBuffer => Some(tiles_in_atlas.surfaces(capture, &rules, monitor)?),
    };
    stages.atlas += begun.elapsed();
    Ok(Simplified {
        scene,
        surfaces,
        region,
        counts,
        tiles: tiles.tiles.len() as u64,
        atlas: layout.size,
        used_texels: layout.places.iter().map(|place| u64::from(place.side).pow(2)).sum(),
        used,
        unsupported,
        selection,
        stages,
        counters,
        seen,
        notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::effort::Effort;

    use crate::budgets::{Budgets, CONSTRAINTS};
    use crate::cost::TextureCoordinates;
    use crate::export::{self, Outputs, Scene};
    use crate::settings::TilingKind;
    use crate::tree::{MAX_LEVEL, TreeCell};
    use codec::monitor::Silent;
    use scene::placement::Region;
    use scene::{DemoKind, FootagePlan};

    const BUDGETS: Budgets = Budgets { triangles: 3000.0, area: 2.0, peak_overdraw: 4.0 };

    fn settings() -> Settings {
        Settings { budgets: BUDGETS, atlas: 512, effort: Effort::Fast, ..Settings::default() }
    }

    fn captured<T>(work: impl FnOnce(&mut Capture) -> T) -> T {
        captured_at(32, work)
    }

    fn captured_at<T>(face_size: u32, work: impl FnOnce(&mut Capture) -> T) -> T {
        let folder = tempfile::tempdir().unwrap();
        let plan = FootagePlan { kind: DemoKind::Interior, frames: 1, face_size, probes: 3 };
        plan.write(folder.path(), &Silent).unwrap();
        work(&mut Capture::open(folder.path(), None).unwrap())
    }

    fn run(change: impl Fn(&mut Settings)) -> Result<Simplified> {
        let mut settings = settings();
        change(&mut settings);
        captured(|capture| simplify(capture, &settings, &Silent))
    }

    fn evaluated(found: &Simplified) -> Evaluation {
        captured(|capture| found.evaluate(capture, &settings(), &Silent)).unwrap()
    }

    fn psnr_db_of(found: &Simplified) -> f64 {
        evaluated(found).fidelity.similarity.all.psnr_db()
    }

    #[test]
    fn budgets_are_kept_and_the_picture_is_close_to_the_capture() {
        let found = run(|_| {}).unwrap();
        assert!(found.scene.mesh.triangles.len() as f64 <= BUDGETS.triangles);
        assert!(found.used[1] <= BUDGETS.area && found.used[2] <= BUDGETS.peak_overdraw + 1e-9);
        let Evaluation { fidelity, poses, .. } = evaluated(&found);
        assert!(fidelity.peak_overdraw <= 1.15 * BUDGETS.peak_overdraw, "{}", fidelity.peak_overdraw);
        assert!(found.atlas.iter().all(|side| *side <= 512));
        assert_eq!((fidelity.crack_pixels, fidelity.translucent_pixels, poses.poses), (0, 0, 64));
        let psnr_db = fidelity.similarity.all.psnr_db();
        assert!(psnr_db > 25.0, "{psnr_db}");
        // Little more than one tile for each face of the cube gives a worse result.
        let cube = run(|settings| settings.budgets.triangles = 40.0).unwrap();
        let cube_db = psnr_db_of(&cube);
        assert!(cube_db < psnr_db - 2.0, "{cube_db} {psnr_db}");
        // The released evaluator adds a constant.
        assert!(fidelity.released_psnr_db() > psnr_db + 20.0);
    }

    #[test]
    fn the_mesh_does_not_depend_on_the_number_of_threads() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| run(|_| {})).unwrap();
            (found.scene.mesh, found.scene.texture.pixels.clone())
        };
        let one = on(1);
        assert!(one == on(3));
    }

    #[test]
    fn homogeneous_texture_coordinates_divide_no_tile() {
        // Enough triangles and texels, so that both have the same tiles.
        let of = |texture_coordinates| {
            let budgets = Budgets { triangles: 1e6, ..BUDGETS };
            let pixels_per_degree = Some(1.2);
            let settings = Settings { texture_coordinates, budgets, atlas: 2048, pixels_per_degree, ..settings() };
            captured_at(64, |capture| {
                let found = simplify(capture, &settings, &Silent).unwrap();
                let psnr_db = found.evaluate(capture, &settings, &Silent).unwrap().fidelity.similarity.all.psnr_db();
                (found, psnr_db)
            })
        };
        let (found, psnr_db) = of(TextureCoordinates::Projective);
        assert_eq!(found.scene.mesh.triangles.len() as u64, 2 * found.tiles);
        assert_eq!(found.scene.stq.len(), found.scene.mesh.positions.len());
        // The coordinates of each corner are equal to the affine ones.
        for (stq, uv) in found.scene.stq.iter().zip(&found.scene.mesh.uvs) {
            assert!(stq.z > 0.0 && stq.z <= 1.0 && (stq.truncate() / stq.z - uv).length() < 1e-6, "{stq} {uv}");
        }
        let (_, affine_db) = of(TextureCoordinates::Affine);
        assert!(psnr_db > affine_db - 0.1, "{psnr_db} {affine_db}");
    }

    #[test]
    fn tiles_that_were_kept_as_words_give_the_same_scene() {
        captured(|capture| {
            let settings = settings();
            let words = select(capture, &settings, &Silent).unwrap().to_words();
            let again = SelectedTiles::of_words(&words, capture, &settings).unwrap().unwrap();
            assert_eq!(again.to_words(), words);
            let found = texture(again, capture, &settings, &Silent).unwrap();
            let whole = simplify(capture, &settings, &Silent).unwrap();
            assert!(found.scene.mesh == whole.scene.mesh && found.scene.texture.pixels == whole.scene.texture.pixels);
            assert_eq!((found.counts, found.used), (whole.counts, whole.used));
            let mut is_read = |words: &[u64]| SelectedTiles::of_words(words, capture, &settings).unwrap().is_some();
            for count in [0, 7, words.len() / 2, words.len() - 1] {
                assert!(!is_read(&words[..count]), "{count}");
            }
            // Replaces the length of a list.
            let mut wrong = words;
            wrong[18 + 3 * CONSTRAINTS] = u64::MAX;
            assert!(!is_read(&wrong));
        });
    }

    fn glb_of(found: &Simplified) -> Vec<u8> {
        let scene = Scene {
            quads: &found.scene,
            region: &found.region,
            budgets: &BUDGETS,
            frame: 0,
            atlas: 512,
            coordinates: TextureCoordinates::Affine,
            surfaces: None,
        };
        export::files(&scene, &Outputs { scene: "a.glb".into(), ktx2: None }).unwrap().remove(0).bytes
    }

    #[test]
    fn short_cuts_change_nothing_and_are_counted() {
        let [taken, off] = [ShortCuts::Taken, ShortCuts::Off]
            .map(|short_cuts| run(|settings| settings.short_cuts = short_cuts).unwrap());
        let Counters { opaque_tiles, silhouettes, filled_tiles, fitted_cells, blended_triangles, .. } = taken.counters;
        assert!(opaque_tiles > 0 && silhouettes > 0 && opaque_tiles + silhouettes == taken.tiles);
        assert!(filled_tiles > 0 && filled_tiles < taken.tiles);
        assert!(blended_triangles > 0 && blended_triangles < taken.scene.mesh.triangles.len() as u64);
        assert!(fitted_cells > 0 && fitted_cells < TreeCell::count(MAX_LEVEL) as u64, "{fitted_cells}");
        assert!(taken.scene.mesh == off.scene.mesh && glb_of(&taken) == glb_of(&off));
        assert_eq!(taken.counters.filled_texels, off.counters.filled_texels);
        // Without a range above 1 there is no float atlas; a forced one is removed from the result.
        assert_eq!((taken.counters.float_texels, taken.scene.light.is_none()), (0, true));
        assert!(off.counters.float_texels > 0 && off.scene.light.is_none());
        // Drawing blends fewer triangles, and finds the same cracks.
        assert_eq!(taken.counters.closed_cracks, off.counters.closed_cracks);
        assert_eq!(taken.counters.closed_translucent, off.counters.closed_translucent);
    }

    #[test]
    fn light_of_hdr_is_kept_above_white() {
        let codes = run(|_| {}).unwrap();
        assert!(codes.scene.light.is_none() && codes.counters.float_texels == 0);
        let floats = run(|settings| settings.light = AtlasLight::HalfFloats).unwrap();
        let light = floats.scene.light.as_ref().unwrap();
        assert_eq!(floats.counters.float_texels, light.len() as u64);
        assert!(floats.scene.texture.pixels == codes.scene.texture.pixels && floats.scene.mesh == codes.scene.mesh);
        let tone = codec::image::ToneMap::default();
        for (light, pixel) in light.iter().zip(&floats.scene.texture.pixels) {
            for (light, code) in light.iter().zip(pixel) {
                assert!(tone.code(light.to_f32()).abs_diff(*code) <= 1, "{light:?} {pixel:?}");
            }
        }
        assert!(light.as_flattened().iter().any(|light| light.to_f32() > 1.0));
    }

    #[test]
    fn quadtrees_do_better_than_a_grid_of_one_level() {
        let wide = Budgets { triangles: 1e6, area: 1.6, peak_overdraw: 5.0 };
        let of = |tiling| {
            run(|settings| {
                (settings.tiling, settings.budgets, settings.atlas) = (tiling, wide, 2048);
            })
            .unwrap()
            .selection
            .primal
        };
        assert!(of(TilingKind::Quadtree) < of(TilingKind::Uniform));
    }

    #[test]
    fn regions_with_surfaces_in_them_and_missing_frames_are_refused() {
        let said =
            run(|settings| settings.region = Some(Region::parse(&["-50,-50,-50,50,50,50"]).unwrap())).unwrap_err();
        assert!(said.to_string().contains("probe 00") && said.to_string().contains("pixel ("), "{said}");
        let said = run(|settings| settings.budgets.triangles = 4.0).unwrap_err().to_string();
        assert!(said.contains("triangles"), "{said}");
    }
}
