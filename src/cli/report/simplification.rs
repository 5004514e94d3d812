//! Charts and pictures of a simplified scene: convergence of the tile selection, durations of the stages, and overdraw (Seurat
//! figures 9 to 11 and 13, table 2).

use std::path::{Path, PathBuf};

use super::picture::raster::{self, HALF_SIDE, Scale};
use super::picture::sheet::{Bar, Panel, Sheet, error_picture};
use super::plot::axis::Axis;
use super::plot::chart::{Chart, Kind, Mark, Series};
use super::plot::marker::Look;
use super::plot::palette::{Rgb, heat};
use super::plot::{Drawing, save};
use codec::error::Result;
use codec::image::plane::Plane;
use evaluate::similarity::difference;
use footage::files::OutputFolder;
use footage::image_files::png;
use simplify::capture::{Capture, CaptureImage};
use simplify::fidelity::Compared;
use simplify::pipeline::{Simplified, Stages};
use simplify::quad_mesh::QuadMesh;
use simplify::raster::overdraw;
use simplify::samples::Background;
use simplify::selection::Bounds;

const SIZE: [u32; 2] = [860, 420];
/// Number of triangles over a pixel at which the colour scale ends.
const MAX_LAYERS: u32 = 16;
/// Number of images for which an error map is drawn.
const ERROR_MAPS: usize = 4;

/// Writes all charts and pictures into a folder, and returns their paths.
pub fn write(
    folder: &Path,
    simplified: &Simplified,
    capture: &mut Capture,
    background: Background,
) -> Result<Vec<PathBuf>> {
    let Simplified { scene, selection, stages, .. } = simplified;
    let out = OutputFolder::create(folder)?;
    let mut files = Vec::new();
    for (name, drawing) in charts(&selection.convergence, stages) {
        files.extend(save(&drawing, out.work_path(), name).map_err(|error| out.present(error))?);
    }
    for (name, picture) in pictures(scene, capture, background)? {
        let path = out.work_path().join(format!("{name}.png"));
        png::write_color8(&path, &picture).map_err(|error| out.present(error))?;
        files.push(path);
    }
    out.commit()?;
    Ok(files.iter().filter_map(|path| Some(folder.join(path.file_name()?))).collect())
}

/// Returns the charts of a run with their names.
fn charts(convergence: &[Bounds], stages: &Stages) -> [(&'static str, Drawing); 2] {
    [("convergence", converging(convergence)), ("stages", durations(stages))]
}

/// Seurat figure 13, right: dual bound by iteration, and energy of the best feasible selection.
fn converging(convergence: &[Bounds]) -> Drawing {
    let series = |number: usize, name: &str, value: fn(&Bounds) -> f64| {
        let mark = |(at, bounds): (usize, &Bounds)| Mark { x: at as f64, y: value(bounds), ..Mark::default() };
        let is_drawn = |mark: &Mark| mark.y.is_finite() && mark.y > 0.0;
        let marks = convergence.iter().enumerate().map(mark).filter(is_drawn).collect();
        let kind = if convergence.len() > 1 { Kind::Curve } else { Kind::Points };
        Series { name: name.to_owned(), kind, look: Look::of(number), marks }
    };
    let series = vec![
        series(0, "best selection (primal)", |bounds| bounds.primal),
        series(1, "bound (dual)", |bounds| bounds.dual),
    ];
    let x = Axis::linear("iterations", [0.0, convergence.len().saturating_sub(1).max(1) as f64]);
    let values: Vec<f64> = series.iter().flat_map(|series| &series.marks).map(|mark| mark.y).collect();
    let chart = Chart::new("Convergence of the selection of tiles", x, Axis::logarithmic("energy", values));
    Chart { series, legend: "Energy".to_owned(), ..chart }.draw(SIZE[0], SIZE[1])
}

/// Seurat table 2. Writing the output files is not included: it happens later.
fn durations(stages: &Stages) -> Drawing {
    let Stages { merge, candidates, selection, silhouettes, shading, atlas, gaps, export: _, evaluate } = *stages;
    let all = [
        ("merge", merge),
        ("candidates", candidates),
        ("selection", selection),
        ("silhouettes", silhouettes),
        ("shading", shading),
        ("atlas", atlas),
        ("gaps", gaps),
        ("evaluate", evaluate),
    ];
    let mark = |(at, (_, duration)): (usize, &(&str, std::time::Duration))| Mark {
        x: (at + 1) as f64,
        y: duration.as_secs_f64(),
        ..Mark::default()
    };
    let marks: Vec<Mark> = all.iter().enumerate().map(mark).collect();
    let total: f64 = marks.iter().map(|mark| mark.y).sum();
    // The axis has an empty tick label at each end, because a bar is as wide as the distance between two tick labels.
    let names = all.iter().map(|(name, _)| *name);
    let words: Vec<String> = std::iter::once("").chain(names).chain([""]).map(str::to_owned).collect();
    let y = Axis::linear("seconds", marks.iter().map(|mark| mark.y));
    let chart = Chart::new(format!("Stages of {total:.1} s"), Axis::of_words("stage", &words), y);
    let series = vec![Series { name: String::new(), kind: Kind::Bars, look: Look::of(0), marks }];
    Chart { series, ..chart }.draw(SIZE[0], SIZE[1])
}

/// Result of comparing one image of a capture with the simplified scene.
struct ImageScore {
    image: usize,
    psnr_db: f64,
    overdraw: f64,
}

/// Returns error maps of the captured images with the lowest PSNR, and the overdraw picture of the view with the
/// highest overdraw, with their names.
fn pictures(scene: &QuadMesh, capture: &mut Capture, background: Background) -> Result<Vec<(String, Plane<Rgb>)>> {
    let compared = |capture: &mut Capture, image: usize| {
        let rays = capture.rays(image)?;
        Compared::new(scene, &capture.images[image], &rays, background)
    };
    let mut judged = Vec::new();
    for image in 0..capture.images.len() {
        let Some(Compared { similarity, overdraw, .. }) = compared(capture, image)? else { continue };
        judged.push(ImageScore { image, psnr_db: similarity.all.psnr_db(), overdraw });
    }
    let most = judged.iter().max_by(|a, b| a.overdraw.total_cmp(&b.overdraw)).map(|judged| judged.image);
    judged.sort_by(|a, b| a.psnr_db.total_cmp(&b.psnr_db));
    let mut pictures = Vec::new();
    for (rank, &ImageScore { image, psnr_db, .. }) in judged.iter().take(ERROR_MAPS).enumerate() {
        let Some(Compared { shown, wanted, .. }) = compared(capture, image)? else { continue };
        let title = format!("{}: {psnr_db:.2} dB", capture.images[image].name);
        let picture = error_picture(&title, [&shown, &wanted], &difference(&shown, &wanted)?)?;
        pictures.push((format!("error-{}", rank + 1), picture));
    }
    if let Some(CaptureImage { name, camera: Some(camera), size, .. }) = most.map(|image| &capture.images[image]) {
        let picture = overdraw_picture(name, &overdraw(scene, camera, *size)?)?;
        pictures.push(("overdraw".to_owned(), picture));
    }
    Ok(pictures)
}

/// Draws the number of triangles over each pixel.
fn overdraw_picture(title: &str, layers: &Plane<u32>) -> Result<Plane<Rgb>> {
    let size = [layers.width(), layers.height()];
    let share = |count: u32| f64::from(count.min(MAX_LAYERS)) / f64::from(MAX_LAYERS);
    let ticks = [0, 4, 8, 12, MAX_LAYERS]
        .map(|count| (share(count), if count == MAX_LAYERS { format!("{count} or more") } else { count.to_string() }));
    let sum: u64 = layers.data().iter().map(|&count| u64::from(count)).sum();
    let sheet = Sheet {
        title: title.to_owned(),
        facts: vec![format!(
            "{:.2} triangles over a pixel in the mean, {} at most.",
            sum as f64 / layers.data().len().max(1) as f64,
            layers.data().iter().max().copied().unwrap_or(0)
        )],
        panels: vec![Panel {
            caption: "overdraw".to_owned(),
            image: raster::render(size, Scale::of(size, HALF_SIDE), |x, y| heat(share(layers.get(x, y)))),
            key: Vec::new(),
            bar: Some(Bar { color: heat, ticks: ticks.to_vec(), label: "triangles over a pixel".into(), mark: None }),
        }],
    };
    sheet.draw()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use codec::math::{Camera, Lens};
    use scene::mesh::{Bvh, ImageTexture, Mesh, Ray, Wrap};
    use simplify::raster::draw;

    /// Counts the triangles that the ray of each pixel hits.
    fn rays(scene: &QuadMesh, camera: &Camera, [width, height]: [u32; 2]) -> Plane<u32> {
        let bvh = Bvh::new((0..scene.mesh.triangles.len()).map(|triangle| scene.mesh.corners(triangle)));
        Plane::from_fn(width, height, |column, row| {
            let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
            let direction = camera.direction([centre[0] / f64::from(width), centre[1] / f64::from(height)]);
            let ray = Ray::new(camera.eye(), direction).unwrap();
            bvh.all(&ray, 0.0..f64::INFINITY).len() as u32
        })
    }

    #[test]
    fn layers_of_rays_are_the_fragments_of_the_rasteriser() {
        // Slanted triangles at pseudo-random positions; one is behind the eye.
        let mut mesh = Mesh::default();
        for at in 0..9u32 {
            let far = if at == 8 { 1.0 } else { -1.0 - 0.3 * f64::from(at) };
            let x = 0.371 * f64::from(at % 4) - 0.6;
            let corners = [[x - 0.7, -0.53, far], [x + 0.81, -0.4, far - 0.2], [x + 0.1, 0.77, far + 0.1]];
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners.map(DVec3::from_array));
            mesh.uvs.extend([glam::Vec2::ZERO; 3]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        let texture = ImageTexture { width: 1, height: 1, pixels: vec![[9, 9, 9, 255]], wrap: [Wrap::Clamp; 2] };
        let scene = QuadMesh { mesh, texture: Arc::new(texture), stq: Vec::new(), light: None, runs: Vec::new() };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
        let layers = rays(&scene, &camera, [48, 40]);
        assert_eq!(layers, overdraw(&scene, &camera, [48, 40]).unwrap());
        let sum: u64 = layers.data().iter().map(|&count| u64::from(count)).sum();
        let drawn = draw(&scene, &camera, [48, 40]);
        assert!(sum > 1000 && sum == drawn.fragments, "{sum} {}", drawn.fragments);
        assert_eq!(layers.data().iter().max(), Some(&drawn.max_fragments));
    }

    #[test]
    fn a_search_of_one_step_has_a_chart() {
        let bounds = [Bounds { dual: 1.0, primal: f64::INFINITY }, Bounds { dual: 2.0, primal: 3.0 }];
        for convergence in [&bounds[..1], &bounds[..], &[]] {
            let drawn = charts(convergence, &Stages::default());
            assert_eq!(drawn.map(|(name, _)| name), ["convergence", "stages"]);
        }
    }
}
