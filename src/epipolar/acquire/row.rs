//! The layers of one scanline of a source view.

use std::ops::Range;

use glam::DVec3;
use half::f16;

use super::{AcquireSettings, Culling, TILE};
use crate::epipolar::continuity::Continuity;
use crate::epipolar::counters::Counters;
use crate::epipolar::source::{Light, SourcePixel, SourceRow};
use crate::epipolar::visibility::{Reach, hidden_m, sees_past};
use crate::mesh::Ray;
use crate::scene::FirstHit;
use crate::scene::capture::{PixelTracer, halves};
use crate::scene::shading::Radiance;
use crate::scene::trace::EyeLight;

pub(super) struct RowAcquisition<'a> {
    pub pixels: PixelTracer<'a>,
    pub settings: &'a AcquireSettings,
    pub layers: usize,
    pub focal_pixels: f64,
    pub baseline_m: f64,
    pub continuity: Continuity,
    pub reach: Reach,
}

/// A pixel's ray, and all that it hits.
struct Column {
    ray: Ray,
    /// Planar distance over distance.
    planar: f64,
    hits: Vec<FirstHit>,
    /// Index of the hit of the current layer; as many as there are hits is the background, and none is nothing.
    current: Option<usize>,
}

impl Column {
    fn depth_m(&self, hit: usize) -> f64 {
        self.hits.get(hit).map_or(f64::INFINITY, |hit| hit.distance * self.planar)
    }
}

impl RowAcquisition<'_> {
    /// Some scanlines, which share lists of objects in view.
    pub fn band(&self, rows: Range<u32>, columns: Range<i32>) -> (Vec<SourceRow>, Counters) {
        let tiles: Vec<(Range<i32>, Vec<usize>)> = columns
            .clone()
            .step_by(TILE as usize)
            .map(|left| {
                let right = (left + TILE as i32).min(columns.end);
                let corner = |column: i32, row: u32| [f64::from(column), f64::from(row)];
                (left..right, self.pixels.in_view(corner(left, rows.start), corner(right, rows.end)))
            })
            .collect();
        let mut counters = Counters::default();
        let rows = rows.map(|row| self.row(row, &tiles, &mut counters)).collect();
        (rows, counters)
    }

    fn row(&self, row: u32, tiles: &[(Range<i32>, Vec<usize>)], counters: &mut Counters) -> SourceRow {
        let first = tiles.first().map_or(0, |tile| tile.0.start);
        let mut columns: Vec<Column> = Vec::new();
        for (range, candidates) in tiles {
            columns.extend(range.clone().map(|column| self.column(column, row, candidates)));
        }
        let candidates = |at: usize| &tiles[at / TILE as usize].1[..];
        let mut out = SourceRow::default();
        for layer in 0..self.layers {
            for (at, column) in columns.iter().enumerate() {
                if column.current.is_some() {
                    let place = [first + at as i32, row as i32];
                    self.shade(column, (place, layer), candidates(at), &mut out);
                }
            }
            if layer + 1 == self.layers || !self.peel(&mut columns, counters) {
                break;
            }
        }
        out
    }

    fn column(&self, column: i32, row: u32, candidates: &[usize]) -> Column {
        let at = [f64::from(column) + 0.5, f64::from(row) + 0.5];
        let ray = self.pixels.ray(at);
        let planar = self.pixels.from.projection.unproject(at).length().recip();
        let hits = match self.layers {
            1 => self.pixels.scene.first_hit(&ray, candidates.iter().copied()).into_iter().collect(),
            _ => self.pixels.scene.all_hits(&ray, candidates.iter().copied()),
        };
        Column { ray, planar, hits, current: Some(0) }
    }

    /// Goes on to the next layer; whether it has any pixel.
    fn peel(&self, columns: &mut [Column], counters: &mut Counters) -> bool {
        let masks = (self.settings.culling == Culling::Full).then(|| {
            let inverse = |column: &Column| column.current.map(|hit| column.depth_m(hit).recip());
            sees_past(&columns.iter().map(inverse).collect::<Vec<_>>(), self.continuity, self.reach)
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
                _ => hidden_m(depth_m, self.focal_pixels, self.baseline_m),
            };
            let visible_m = depth_m + hidden_m;
            let next = (hit + 1..column.hits.len()).find(|&next| column.depth_m(next) > visible_m);
            counters.offset_skipped += next.unwrap_or(column.hits.len()) as u64 - hit as u64 - 1;
            // Behind the last surface is the background.
            column.current = next.or((visible_m < f64::INFINITY).then_some(column.hits.len()));
            is_any |= column.current.is_some();
        }
        is_any
    }

    /// Adds the pixel of the current layer.
    fn shade(&self, column: &Column, (place, layer): ([i32; 2], usize), candidates: &[usize], out: &mut SourceRow) {
        let Some(hit) = column.current else { return };
        let (scene, hit_surface) = (self.pixels.scene, column.hits.get(hit));
        let [mut steady, own] = match layer {
            0 => self.mean(place, candidates),
            _ => sums(&scene.shade(&column.ray, hit_surface)).map(halves),
        };
        let light = match hit_surface.map(|hit| scene.eye_light(&column.ray, hit)) {
            Some(EyeLight::Traced) => Light::Traced,
            Some(EyeLight::Gloss(gloss)) => {
                out.gloss.push(gloss);
                Light::Gloss(out.gloss.len() as u32 - 1)
            }
            Some(EyeLight::None) | None => {
                steady = own;
                Light::Steady
            }
        };
        let depth_m = (column.depth_m(hit) as f32).max(f32::MIN_POSITIVE);
        out.pixels.push(SourcePixel { column: place[0], depth_m, layer: layer as u8, light, steady, own });
    }

    /// Means over a pixel: of the light without highlights, and of all light, the same bits as those of a captured image.
    fn mean(&self, [column, row]: [i32; 2], candidates: &[usize]) -> [[f16; 3]; 2] {
        let points = &self.settings.samples.points;
        let mut total = [DVec3::ZERO; 2];
        for [x, y] in points {
            let ray = self.pixels.ray([f64::from(column) + x, f64::from(row) + y]);
            let hit = self.pixels.scene.first_hit(&ray, candidates.iter().copied());
            let of_ray = sums(&self.pixels.scene.shade(&ray, hit.as_ref()));
            (total[0], total[1]) = (total[0] + of_ray[0], total[1] + of_ray[1]);
        }
        total.map(|sum| halves(sum / points.len() as f64))
    }
}

/// Light without highlights, and all light.
fn sums(radiance: &Radiance) -> [DVec3; 2] {
    [radiance.steady, radiance.total()]
}
