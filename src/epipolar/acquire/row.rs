//! Acquisition of the layers of one scanline of a source view.

use std::ops::Range;

use glam::DVec3;
use half::f16;

use super::settings::{AcquireSettings, Culling, TILE};
use crate::continuity::Continuity;
use crate::counters::Counters;
use crate::drawing::PixelHits;
use crate::lines::STEEPEST;
use crate::source::{Light, SourcePixel, SourceRow};
use crate::stages::Lap;
use crate::views::OutputViews;
use crate::visibility::{Reach, hidden_m, joined, sees_past};
use scene::FirstHit;
use scene::capture::{PixelTracer, halves};
use scene::mesh::Ray;
use scene::trace::EyeLight;

pub(super) struct RowAcquisition<'a> {
    pub pixels: PixelTracer<'a>,
    pub views: &'a OutputViews,
    pub settings: &'a AcquireSettings,
    pub layers: usize,
    pub focal_pixels: f64,
    /// Distance from the source to the farthest output view, in metres.
    pub reach_m: f64,
    pub continuity: Continuity,
    pub reach: Reach,
}

/// A pixel's ray and all of its hits.
struct Column {
    ray: Ray,
    /// Planar distance divided by distance along the ray.
    planar: f64,
    hits: Vec<FirstHit>,
    /// Index of the hit of the current layer. `hits.len()` is the background; `None` is no pixel in this layer.
    current: Option<usize>,
}

impl Column {
    fn depth_m(&self, hit: usize) -> f64 {
        self.hits.get(hit).map_or(f64::INFINITY, |hit| hit.distance * self.planar)
    }
}

impl RowAcquisition<'_> {
    /// Acquires the given scanlines, which share lists of objects in view.
    pub fn band(&self, hits: &PixelHits<'_>, rows: Range<u32>, columns: Range<i32>) -> (Vec<SourceRow>, Counters) {
        let tiles = self.tiles(&rows, columns);
        let mut counters = Counters::default();
        let rows = rows.map(|row| self.row((row, hits), &tiles, &mut counters)).collect();
        (rows, counters)
    }

    /// Divides the columns into tiles, each with the objects in view.
    fn tiles(&self, rows: &Range<u32>, columns: Range<i32>) -> Vec<(Range<i32>, Vec<usize>)> {
        let tile = |left: i32| {
            let right = (left + TILE as i32).min(columns.end);
            let corner = |column: i32, row: u32| [f64::from(column), f64::from(row)];
            (left..right, self.pixels.in_view(corner(left, rows.start), corner(right, rows.end)))
        };
        columns.clone().step_by(TILE as usize).map(tile).collect()
    }

    /// Returns the maximum number of columns by which a pixel of the given scanlines moves per metre of eye movement.
    pub fn farthest_columns(&self, rows: Range<u32>, columns: Range<i32>) -> f64 {
        let tiles = self.tiles(&rows, columns);
        let pixels = rows.flat_map(|row| {
            tiles
                .iter()
                .flat_map(move |(columns, candidates)| columns.clone().map(move |column| (column, row, candidates)))
        });
        let moved = pixels.map(|(column, row, candidates)| {
            let (ray, planar) = self.ray([column, row as i32]);
            let hit = self.pixels.scene.first_hit(&ray, candidates.iter().copied());
            let depth_m = hit.map_or(f64::INFINITY, |hit| hit.distance * planar);
            self.views.columns_per_metre(f64::from(nonzero(depth_m))).abs()
        });
        moved.fold(0.0, f64::max)
    }

    fn row(
        &self,
        (row, hits): (u32, &PixelHits<'_>),
        tiles: &[(Range<i32>, Vec<usize>)],
        counters: &mut Counters,
    ) -> SourceRow {
        let mut lap = Lap::begin();
        let first = tiles.first().map_or(0, |tile| tile.0.start);
        let mut columns: Vec<Column> = Vec::new();
        for (range, candidates) in tiles {
            columns.extend(range.clone().map(|column| self.column(hits, [column, row as i32], candidates)));
        }
        let candidates = |at: usize| &tiles[at / TILE as usize].1[..];
        let mut out = SourceRow::default();
        for layer in 0..self.layers {
            for (at, column) in columns.iter().enumerate() {
                if column.current.is_some() {
                    let place = [first + at as i32, row as i32];
                    self.shade(column, (place, layer), (hits, candidates(at)), &mut out);
                }
            }
            counters.threads.acquire += lap.time();
            if layer + 1 == self.layers {
                break;
            }
            let is_any = self.peel(&mut columns, counters);
            counters.threads.mask += lap.time();
            if !is_any {
                break;
            }
        }
        out.fitted()
    }

    fn column(&self, hits: &PixelHits<'_>, pixel: [i32; 2], candidates: &[usize]) -> Column {
        let (ray, planar) = self.ray(pixel);
        let hits = match self.layers {
            1 => hits.nearest(pixel, &ray, candidates).into_iter().collect(),
            _ => hits.all(pixel, &ray, candidates),
        };
        Column { ray, planar, hits, current: Some(0) }
    }

    /// Returns the ray through the centre of a pixel, and planar distance divided by distance along the ray.
    fn ray(&self, pixel: [i32; 2]) -> (Ray, f64) {
        let at = pixel.map(|at| f64::from(at) + 0.5);
        (self.pixels.ray(at), self.pixels.from.projection.unproject(at).length().recip())
    }

    /// Advances all columns to the next layer. Returns true if that layer has any pixel.
    fn peel(&self, columns: &mut [Column], counters: &mut Counters) -> bool {
        let inverse = |column: &Column| column.current.map(|hit| column.depth_m(hit).recip());
        let joined = joined(&columns.iter().map(inverse).collect::<Vec<_>>(), self.continuity);
        let masks = (self.settings.culling == Culling::Full).then(|| {
            let inverse: Vec<_> = columns.iter().map(inverse).collect();
            sees_past(&inverse, &joined, self.reach)
        });
        let mut is_any = false;
        for (at, column) in columns.iter_mut().enumerate() {
            let Some(hit) = column.current.filter(|hit| *hit < column.hits.len()) else {
                column.current = None;
                continue;
            };
            if masks.as_ref().is_some_and(|sees| !sees[at]) {
                counters.masked_pixels += 1;
                column.current = None;
                continue;
            }
            let depth_m = column.depth_m(hit);
            let hidden_m = match self.settings.culling {
                Culling::Off => 0.0,
                // If both neighbours show the same surface, the hidden width is two pixels, otherwise one.
                _ => {
                    let is_inside = at > 0 && joined[at - 1] && joined[at];
                    hidden_m(depth_m, if is_inside { 2.0 } else { 1.0 } / self.focal_pixels, self.reach_m)
                }
            };
            let visible_m = depth_m + hidden_m;
            let next = (hit + 1..column.hits.len()).find(|&next| column.depth_m(next) > visible_m);
            counters.offset_skipped += next.unwrap_or(column.hits.len()) as u64 - hit as u64 - 1;
            // The background is behind the last surface.
            column.current = next.or((visible_m < f64::INFINITY).then_some(column.hits.len()));
            is_any |= column.current.is_some();
        }
        is_any
    }

    /// Shades the pixel of the current layer and appends it to `out`.
    fn shade(
        &self,
        column: &Column,
        (place, layer): ([i32; 2], usize),
        (hits, candidates): (&PixelHits<'_>, &[usize]),
        out: &mut SourceRow,
    ) {
        let Some(hit) = column.current else { return };
        let (scene, hit_surface) = (self.pixels.scene, column.hits.get(hit));
        let depth_m = column.depth_m(hit);
        let PixelLight { steady, total, own } = match layer {
            0 => self.mean(place, depth_m, (hits, candidates)),
            _ => {
                let radiance = scene.shade(&column.ray, hit_surface);
                let [steady, total] = [radiance.steady, radiance.total()].map(halves);
                PixelLight { steady, total, own: total }
            }
        };
        let (light, steady) = match hit_surface.map(|hit| scene.eye_light(&column.ray, hit)) {
            Some(EyeLight::Traced) => (Light::Traced, total),
            Some(EyeLight::Gloss(gloss)) => {
                out.gloss.push(gloss);
                (Light::Gloss(out.gloss.len() as u32 - 1), steady)
            }
            Some(EyeLight::None) | None => (Light::Steady, total),
        };
        out.pixels.push(SourcePixel {
            column: place[0],
            depth_m: nonzero(depth_m),
            layer: layer as u8,
            light,
            steady,
            own,
        });
    }

    /// Averages the samples of a pixel of the first layer.
    ///
    /// Other views show the mean of the samples that are not in front of the surface at the pixel's centre. A near surface then
    /// keeps its soft edge, and a far surface does not carry the radiance of a nearer one into other views, where it would remain
    /// as a ghost. The source's own view shows the mean of all samples. (At the fence of the built-in courtyard this gives 22.9
    /// dB and an SSIM of 0.948; all samples give 22.6 dB and 0.931, only those on the surface at the centre 21.0 dB and 0.932.)
    fn mean(&self, pixel: [i32; 2], depth_m: f64, (hits, candidates): (&PixelHits<'_>, &[usize])) -> PixelLight {
        let points = &self.settings.samples.points;
        let mut sums = [DVec3::ZERO; 3];
        let mut agreeing = 0;
        for (sample, [x, y]) in points.iter().enumerate() {
            let at = [f64::from(pixel[0]) + x, f64::from(pixel[1]) + y];
            let ray = self.pixels.ray(at);
            let hit = hits.first(pixel, sample, &ray, candidates);
            let radiance = self.pixels.scene.shade(&ray, hit.as_ref());
            sums[2] += radiance.total();
            let planar = self.pixels.from.projection.unproject(at).length().recip();
            let sample_m = hit.map_or(f64::INFINITY, |hit| hit.distance * planar);
            // Samples that are not in front of the surface at the centre. The equality covers two infinite depths.
            if sample_m == depth_m || sample_m / depth_m - 1.0 >= -STEEPEST / self.focal_pixels {
                sums[0] += radiance.steady;
                sums[1] += radiance.total();
                agreeing += 1;
            }
        }
        let own = halves(sums[2] / points.len() as f64);
        let [steady, total] = match agreeing {
            0 => [own; 2],
            count => [sums[0], sums[1]].map(|sum| halves(sum / f64::from(count))),
        };
        PixelLight { steady, total, own }
    }
}

/// Converts a planar distance to the range of [`SourcePixel::depth_m`], which is above 0.
fn nonzero(depth_m: f64) -> f32 {
    (depth_m as f32).max(f32::MIN_POSITIVE)
}

/// Radiance of a pixel.
struct PixelLight {
    /// Radiance of the pixel's surface, without highlights.
    steady: [f16; 3],
    /// Radiance of the pixel's surface, with highlights.
    total: [f16; 3],
    /// Radiance of everything that the pixel shows.
    own: [f16; 3],
}
