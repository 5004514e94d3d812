//! Layers of a primary ray: successive surfaces, each with its share of the ray, and the background.
//!
//! Takes active views, a ray, and the first hits of the ray. Returns layers whose shares, together with that of a transparent
//! background, sum to 1.
//!
//! Algorithm 4 of CALF ends a ray at the first surface that it meets, and treats a surface that no view saw as a hole.
//! `Refinements` extend this:
//!
//! - Near an edge, some texels have the surface, and others have what is behind it. Coverage is interpolated between them like
//!   colour, and the ray continues with the rest of its share. Edges are as soft as texels are, and objects thinner than a texel
//!   do not vanish.
//! - A thin surface that the nearest view saw may lie between two texels of other views, which then seem to see past it. Such a
//!   surface also has coverage, by the weights of the views that have it. The image converges to what a probe recorded as the eye
//!   approaches the probe.
//! - A surface that no view saw hides nothing that is known: with [`HoleFill::Behind`] the ray continues to the surfaces that
//!   views saw behind it.
//!
//! A surface with alpha takes that fraction of its coverage, and the ray continues behind it with the rest. Its texels do not
//! record what is behind it, so the next surface is the one that the ray meets after it has left the first, where another view
//! sees past it. If the rest of the share then reaches nothing known, it is transparent if the background is.

use glam::Vec3;

use crate::march::active_views::NEGLIGIBLE_WEIGHT;
use crate::march::{
    ActiveViews, ClipPlanes, Counters, Footprint, HOLE_DIFFERENCE, Interpolated, LightCurve, Ray, RenderSettings,
    background_color, light_of,
};
use crate::rendered_image::{BackgroundFill, HoleFill};
use crate::views::ColorCoding;

/// Minimum share of a layer that is shown, and of a remainder that is traced further.
pub const MIN_LAYER: f32 = NEGLIGIBLE_WEIGHT;
/// Maximum number of layers of a ray; the last one takes all of the remaining share.
pub const MAX_LAYERS: u32 = 8;
/// Maximum number of times that a ray leaves a surface and marches on.
pub const MAX_EXITS: u32 = 64;
/// Surfaces whose log distances differ by less than this count as one surface.
const SAME_SURFACE: f32 = HOLE_DIFFERENCE;

/// One layer of a primary ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layer {
    /// Metres to the surface; none for background.
    pub(crate) distance_m: Option<f32>,
    /// Linear RGB, without secondary rays.
    pub(crate) light: Vec3,
    pub(crate) share: f32,
}

/// Distances at which a ray first meets surfaces, in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct FirstHits {
    /// First surface of the nearest view; only with [`Refinements::thin`](crate::march::Refinements).
    pub(crate) nearest_m: Option<f32>,
    /// First surface of all views.
    pub(crate) all_m: Option<f32>,
}

impl FirstHits {
    /// Returns the surface of the nearest view if it lies in front of that of all views.
    pub(crate) fn thin_m(&self) -> Option<f32> {
        self.nearest_m.filter(|&nearest_m| self.all_m.is_none_or(|all_m| nearest_m < all_m * libm::expf(-SAME_SURFACE)))
    }
}

/// Result of a primary ray.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PrimaryHit {
    /// First layer.
    pub(crate) first: Option<Layer>,
    /// Layers behind the first, in order of distance.
    pub(crate) behind: Vec<Layer>,
    /// Share of a background that is not shown, or that is itself transparent.
    pub(crate) transparent: f32,
    /// True if the ray first meets a surface that no view saw, or ends without a known colour.
    pub(crate) is_hole: bool,
}

impl PrimaryHit {
    /// Returns the metres to the layer with the largest share; none for background.
    pub(crate) fn distance_m(&self) -> Option<f32> {
        self.layers().max_by(|a, b| a.share.total_cmp(&b.share)).and_then(|layer| layer.distance_m)
    }

    pub(crate) fn layers(&self) -> impl Iterator<Item = &Layer> {
        self.first.iter().chain(&self.behind)
    }

    fn push(&mut self, layer: Layer) {
        match self.first {
            None => self.first = Some(layer),
            Some(_) => self.behind.push(layer),
        }
    }
}

/// Shared state of the primary rays of an image.
pub(crate) struct Primary<'a> {
    /// All active views, with the footprint of primary rays.
    pub(crate) views: ActiveViews<'a>,
    /// The nearest view alone; only with [`Refinements::thin`](crate::march::Refinements).
    pub(crate) nearest: Option<ActiveViews<'a>>,
    clip: Option<ClipPlanes>,
    curve: Option<LightCurve>,
    pub(crate) settings: &'a RenderSettings,
}

/// Input that a [`LayerWalk`] requests from its caller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Query {
    /// Interpolated colour of the point at this distance in metres.
    Color(f32),
    /// True if the point at this step is on or behind a surface.
    Occupancy(usize),
    /// Distance at which the ray meets a surface, searched from this step on.
    Hit(usize),
    /// No further input: the walk has ended.
    Done,
}

/// Walk of a ray through its layers. The caller supplies the result of each query until the query is [`Query::Done`].
pub(crate) struct LayerWalk<'p, 'a> {
    primary: &'p Primary<'a>,
    pub(crate) query: Query,
    shown: PrimaryHit,
    place: Place,
    /// Share of the ray that has no layer yet.
    left: f32,
    /// Minimum distance of a surface that is shown, in metres.
    min_m: f32,
    /// Linear RGB of the last texels whose depths did not match.
    unseen: Option<Vec3>,
    /// Range of distances in metres in which surfaces are visible.
    range_m: [f32; 2],
    /// True if the current surface begins in front of the near plane; it is cut away with its inside.
    is_cut: bool,
    /// True if the ray is inside a surface with alpha whose share is already counted.
    is_within: bool,
    /// True if the ray has passed through a surface with alpha.
    lets_through: bool,
    ends_in_hole: bool,
    exits: u32,
}

/// Position of a ray in its walk.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    /// At the thin surface of the nearest view. The first surface of all views, `all_m` in metres, is next.
    Thin { all_m: Option<f32> },
    /// At a hit on a surface of all views.
    Hit,
    /// At a step inside that surface.
    Inside,
}

impl<'a> Primary<'a> {
    pub(crate) fn new(views: &ActiveViews<'a>, clip: Option<ClipPlanes>, settings: &'a RenderSettings) -> Primary<'a> {
        let footprint = if settings.refinements.edges { Footprint::Around } else { Footprint::Texel };
        let views = views.with_footprint(footprint);
        let nearest = if settings.refinements.thin { views.nearest() } else { None };
        let curve = match views.coding {
            ColorCoding::Codes(tone) => Some(LightCurve::new(tone)),
            ColorCoding::Light => None,
        };
        Primary { views, nearest, clip, curve, settings }
    }

    /// Converts an interpolated colour to linear RGB.
    pub(crate) fn light(&self, color: Vec3) -> Vec3 {
        match &self.curve {
            Some(curve) => color.to_array().map(|code| curve.light(code)).into(),
            None => color,
        }
    }

    fn coverage(&self, seen: &Interpolated) -> f32 {
        if self.settings.refinements.edges { seen.coverage } else { 1.0 }
    }

    /// Returns the range of distances in metres in which the surfaces of a ray are visible.
    fn range_m(&self, ray: &Ray) -> [f32; 2] {
        self.clip.map_or([0.0, f32::INFINITY], |clip| clip.distances_m(ray))
    }

    /// Returns the hit of a ray whose first surface takes all of it: a shortcut for a [`LayerWalk`] that would end there.
    pub(crate) fn whole(&self, ray: &Ray, hits: &FirstHits, seen: &Interpolated) -> Option<PrimaryHit> {
        let is_shown = |hit_m: f32| {
            let [near_m, far_m] = self.range_m(ray);
            (near_m..=far_m).contains(&hit_m)
        };
        let is_whole = self.coverage(seen) * seen.alpha > 1.0 - MIN_LAYER
            && seen.difference <= self.settings.tolerance()
            && hits.thin_m().is_none()
            && hits.all_m.is_some_and(is_shown);
        let layer = || Layer { distance_m: hits.all_m, light: self.light(seen.color), share: 1.0 };
        is_whole.then(|| PrimaryHit { first: Some(layer()), ..PrimaryHit::default() })
    }
}

impl<'p, 'a> LayerWalk<'p, 'a> {
    pub(crate) fn new(primary: &'p Primary<'a>, ray: &Ray, hits: &FirstHits) -> LayerWalk<'p, 'a> {
        let range_m = primary.range_m(ray);
        let mut walk = LayerWalk {
            primary,
            query: Query::Done,
            shown: PrimaryHit::default(),
            place: Place::Thin { all_m: hits.all_m },
            left: 1.0,
            min_m: range_m[0],
            unseen: None,
            range_m,
            is_cut: false,
            is_within: false,
            lets_through: false,
            ends_in_hole: false,
            exits: 0,
        };
        match hits.thin_m().filter(|thin_m| (range_m[0]..=range_m[1]).contains(thin_m)) {
            Some(thin_m) => walk.query = Query::Color(thin_m),
            None => walk.answer_hit(hits.all_m),
        }
        walk
    }

    /// Processes the result of a [`Query::Hit`].
    pub(crate) fn answer_hit(&mut self, hit_m: Option<f32>) {
        self.exits += 1;
        self.query = match hit_m.filter(|&hit_m| hit_m <= self.range_m[1] && self.exits <= MAX_EXITS) {
            Some(hit_m) => {
                (self.place, self.is_cut) = (Place::Hit, hit_m < self.range_m[0]);
                self.is_within &= hit_m < self.min_m;
                self.at(hit_m)
            }
            None => Query::Done,
        };
    }

    /// Processes the result of a [`Query::Occupancy`].
    pub(crate) fn answer_occupancy(&mut self, step: usize, is_surface: bool) {
        self.query = match is_surface {
            true => {
                self.place = Place::Inside;
                self.at(self.primary.settings.steps.distances_m[step])
            }
            false => Query::Hit(step),
        };
    }

    /// Processes the result of a [`Query::Color`].
    pub(crate) fn answer_color(&mut self, at_m: f32, seen: Option<Interpolated>) {
        let settings = self.primary.settings;
        // Points inside a surface lie on steps and are not refined.
        let within = if self.place == Place::Inside {
            HOLE_DIFFERENCE + settings.steps.log_step()
        } else {
            settings.tolerance()
        };
        match (seen, self.place) {
            (Some(seen), _) if seen.difference <= within => self.show(at_m, &seen),
            (_, Place::Thin { .. }) => {}
            (seen, place) => {
                self.unseen = seen.map(|seen| self.primary.light(seen.color)).or(self.unseen);
                if self.shown.first.is_none() && place == Place::Hit {
                    self.shown.is_hole = true;
                    self.ends_in_hole = settings.holes != HoleFill::Behind;
                }
            }
        }
        match self.place {
            _ if self.left == 0.0 || self.ends_in_hole => self.query = Query::Done,
            Place::Thin { all_m } => self.answer_hit(all_m),
            Place::Hit | Place::Inside => self.query = self.after(at_m),
        }
    }

    /// Returns the query for a point on a surface.
    fn at(&self, at_m: f32) -> Query {
        let is_asked = at_m >= self.min_m && !self.is_cut && !self.is_within;
        if is_asked { Query::Color(at_m) } else { self.after(at_m) }
    }

    /// Returns the query for the next step behind that point.
    fn after(&self, at_m: f32) -> Query {
        let distances_m = &self.primary.settings.steps.distances_m;
        let next = distances_m.partition_point(|&distance_m| distance_m <= at_m);
        let is_in_range = distances_m.get(next).is_some_and(|&next_m| next_m <= self.range_m[1]);
        if is_in_range { Query::Occupancy(next) } else { Query::Done }
    }

    /// Adds a layer for a surface, by its coverage and alpha.
    fn show(&mut self, distance_m: f32, seen: &Interpolated) {
        let coverage = self.primary.coverage(seen);
        let opacity = coverage * seen.alpha;
        self.lets_through |= seen.alpha <= 1.0 - MIN_LAYER;
        self.is_within |= coverage > 1.0 - MIN_LAYER && seen.alpha <= 1.0 - MIN_LAYER;
        if opacity < MIN_LAYER {
            return;
        }
        let is_last = self.shown.layers().count() + 1 == MAX_LAYERS as usize;
        let left = if is_last || opacity > 1.0 - MIN_LAYER { 0.0 } else { self.left * (1.0 - opacity) };
        let left = if left < MIN_LAYER { 0.0 } else { left };
        let light = self.primary.light(seen.color);
        self.shown.push(Layer { distance_m: Some(distance_m), light, share: self.left - left });
        self.left = left;
        self.min_m = distance_m * libm::expf(SAME_SURFACE);
    }

    /// Returns all layers of the ray, after the last query.
    pub(crate) fn end(mut self, ray: &Ray, counters: &mut Counters) -> PrimaryHit {
        if self.left == 0.0 {
            return self.shown;
        }
        if self.ends_in_hole {
            return self.end_in_hole();
        }
        counters.background_rays += u64::from(self.shown.first.is_none());
        let views = &self.primary.views;
        match (background_color(views, ray.direction), self.primary.settings.background) {
            (None, BackgroundFill::Transparent) if self.lets_through => self.shown.transparent = self.left,
            (None, _) => return self.end_in_hole(),
            (Some(_), BackgroundFill::Transparent) => self.shown.transparent = self.left,
            (Some(seen), BackgroundFill::Opaque) => {
                let (light, share) = (light_of(views.coding, seen.color), self.left * seen.alpha);
                self.shown.push(Layer { distance_m: None, light, share });
                self.shown.transparent = self.left - share;
            }
        }
        self.shown
    }

    /// Ends a ray whose remaining share reaches nothing known. The layers in front are scaled to take all of the ray; without
    /// layers, the colour of the last texels whose depths did not match is used.
    fn end_in_hole(self) -> PrimaryHit {
        let mut shown = self.shown;
        if shown.first.is_none() {
            shown.is_hole = true;
            shown.first = self.unseen.map(|light| Layer { distance_m: None, light, share: 1.0 });
            return shown;
        }
        let whole = (1.0 - self.left).recip();
        shown.first.iter_mut().chain(&mut shown.behind).for_each(|layer| layer.share *= whole);
        shown
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::march::synthetic::{SyntheticProbe, room, set_alpha};
    use crate::march::{Acceleration, Refinements, SpecularMode, Steps};
    use crate::views::light_field::{ColorCoding, LightField};
    use codec::image::transfer::{ToneMap, Transfer};

    const CODES: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });
    const SIDE: u32 = 32;
    /// Width in metres of a texel at a distance of 1 m.
    const TEXEL_M: f64 = 2.0 / SIDE as f64;
    const WALL_M: f64 = 4.0;

    /// A red plate 1 m in front of a probe, from `left` to `right` in texels right of the middle, in a dark room.
    fn plate([left, right]: [f64; 2]) -> LightField {
        let view = SyntheticProbe::new(DVec3::ZERO, SIDE).cube(CODES, &|direction| {
            let at = direction / -direction.z / TEXEL_M;
            match direction.z < 0.0 && (left..right).contains(&at.x) && at.y.abs() < 8.0 {
                true => Some((direction.length() / -direction.z, [255, 0, 0])),
                false => room(DVec3::ZERO, direction, DVec3::splat(WALL_M), 0.0).map(|(metres, _)| (metres, [0; 3])),
            }
        });
        LightField { views: vec![view], coding: CODES }
    }

    fn settings(holes: HoleFill, background: BackgroundFill, refinements: Refinements) -> RenderSettings {
        RenderSettings {
            size: [1; 2],
            steps: Steps::new(256, 0.01, 16.0, 16),
            samples: 1,
            holes,
            background,
            specular: SpecularMode::None,
            max_bounces: 0,
            acceleration: Acceleration::Pyramid,
            refinements,
        }
    }

    /// Returns the layers of a ray from an eye to a point of the plate's plane, `column` texels right of the middle.
    fn shown(field: &LightField, (eye, column): (DVec3, f64), settings: &RenderSettings) -> PrimaryHit {
        let all: Vec<usize> = (0..field.views.len()).collect();
        let views = ActiveViews::new(field, &all, eye);
        let primary = Primary::new(&views, None, settings);
        let target = DVec3::new(column * TEXEL_M, TEXEL_M / 2.0, -1.0);
        let ray = Ray { origin: Vec3::ZERO, direction: (target - eye).normalize().as_vec3() };
        let mut counters = Counters::default();
        let found = primary.hit(&ray, &mut counters);
        let shares = found.layers().map(|layer| layer.share).sum::<f32>() + found.transparent;
        assert!((shares - 1.0).abs() < 1e-6 || found.first.is_none());
        found
    }

    #[test]
    fn edges_show_both_surfaces_by_their_coverage() {
        // The plate begins with texel 0, whose middle is at 0.5.
        let field = plate([0.0, 4.0]);
        let shares = |column: f64, refinements| {
            let settings = settings(HoleFill::Behind, BackgroundFill::Opaque, refinements);
            let found = shown(&field, (DVec3::ZERO, column), &settings);
            found.layers().map(|layer| (layer.distance_m.unwrap().round() as u32, layer.share)).collect::<Vec<_>>()
        };
        for (column, red) in [(-0.25, 0.25), (0.0, 0.5), (0.25, 0.75)] {
            let found = shares(column, Refinements::ALL);
            let [(near, share), (far, _)] = found[..] else { panic!("{column}: {found:?}") };
            assert!((near, far) == (1, 4) && (share - red).abs() < 1e-3, "{column}: {found:?}");
        }
        assert_eq!(shares(0.5, Refinements::ALL), [(1, 1.0)]);
        assert_eq!(shares(-0.5, Refinements::ALL), [(4, 1.0)]);
        // Without refinements an edge is a hard step.
        assert_eq!(shares(-0.25, Refinements::NONE), [(4, 1.0)]);
        assert_eq!(shares(0.25, Refinements::NONE), [(1, 1.0)]);
    }

    #[test]
    fn rays_go_on_behind_what_no_view_saw() {
        let field = plate([-4.0, 4.0]);
        // From the right, between the plate and the wall behind it.
        let place = (DVec3::new(1.0, 0.0, -1.5), -40.0);
        let ray = |holes| shown(&field, place, &settings(holes, BackgroundFill::Opaque, Refinements::ALL));
        let behind = ray(HoleFill::Behind);
        let wall_m = behind.first.and_then(|layer| layer.distance_m);
        assert!(behind.is_hole && wall_m.is_some_and(|wall_m| wall_m > 5.0), "{behind:?}");
        let blank = ray(HoleFill::Blank);
        assert!(blank.is_hole && blank.layers().all(|layer| layer.distance_m.is_none()), "{blank:?}");
    }

    /// A red pane 1 m in front of the first probe, with an alpha in 255ths, in a green room; a second probe sees past it.
    fn pane(alpha: u8) -> LightField {
        let view = |position: DVec3| {
            let mut view = SyntheticProbe::new(position, SIDE).cube(CODES, &|direction| {
                let distance_m = (-1.0 - position.z) / direction.z;
                let at = position + distance_m * direction;
                match distance_m > 0.0 && at.x.abs() < 0.5 && at.y.abs() < 0.5 {
                    true => Some((distance_m, [255, 0, 0])),
                    false => room(position, direction, DVec3::splat(WALL_M), 0.0).map(|(m, _)| (m, [0, 255, 0])),
                }
            });
            set_alpha(&mut view, |texels, at| if texels.color.get(at).x > 0.5 { alpha } else { 255 });
            view
        };
        LightField { views: [DVec3::ZERO, DVec3::new(3.0, 0.0, 1.5)].map(view).to_vec(), coding: CODES }
    }

    #[test]
    fn surfaces_with_alpha_show_what_is_behind_them() {
        let all = |background| settings(HoleFill::Behind, background, Refinements::ALL);
        let opaque = all(BackgroundFill::Opaque);
        let place = (DVec3::ZERO, 0.5);
        let shares = |found: &PrimaryHit| -> Vec<(Option<u32>, f32)> {
            found.layers().map(|layer| (layer.distance_m.map(|metres| metres.round() as u32), layer.share)).collect()
        };
        for (alpha, refinements) in
            [(64, Refinements::ALL), (128, Refinements::ALL), (128, Refinements::NONE), (250, Refinements::NONE)]
        {
            let found = shown(&pane(alpha), place, &RenderSettings { refinements, ..opaque.clone() });
            let [(near, share), (far, rest)] = shares(&found)[..] else { panic!("{alpha}: {found:?}") };
            assert_eq!((near, far, found.is_hole), (Some(1), Some(4), false));
            assert!((share - f32::from(alpha) / 255.0).abs() < 1e-5 && (share + rest - 1.0).abs() < 1e-6, "{found:?}");
            assert!(found.first.unwrap().light.distance(Vec3::X) < 0.01, "{found:?}");
        }
        let found = shown(&pane(128), place, &opaque);
        // A small part of the pane's colour is interpolated into that of the surface behind it.
        assert!(found.behind[0].light.distance(Vec3::Y) < 0.05, "{found:?}");
        // An alpha within [`MIN_LAYER`] of 1 or 0 counts as 1 or 0.
        assert_eq!(shares(&shown(&pane(252), place, &opaque)), [(Some(1), 1.0)]);
        let found = shown(&pane(3), place, &opaque);
        assert!(shares(&found) == [(Some(4), 1.0)] && !found.is_hole, "{found:?}");
    }

    #[test]
    fn what_goes_through_and_ends_in_nothing_is_transparent_as_backgrounds_are() {
        let place = (DVec3::ZERO, 0.5);
        let found = |alpha, background| {
            let mut field = pane(alpha);
            field.views.truncate(1);
            let found = shown(&field, place, &settings(HoleFill::Behind, background, Refinements::ALL));
            // Shares in thousandths.
            let [shown, transparent] = [found.layers().map(|layer| layer.share).sum(), found.transparent]
                .map(|share: f32| (1000.0 * share).round() as u32);
            (shown, transparent, found.is_hole)
        };
        assert_eq!(found(51, BackgroundFill::Transparent), (200, 800, false));
        assert_eq!(found(0, BackgroundFill::Transparent), (0, 1000, false));
        assert_eq!(found(51, BackgroundFill::Opaque), (1000, 0, false));
        // The ray has no layer and no known background.
        assert_eq!(found(0, BackgroundFill::Opaque), (0, 0, true));
    }
}
