//! Rays from the eye: their first hits and their layers, for one ray or for several at once.

use crate::march::intersect::first_step;
use crate::march::layers::{LayerWalk, Query};
use crate::march::{
    ActiveViews, Counters, FirstHits, Interpolated, Primary, PrimaryHit, Ray, RenderSettings, StepsFrom, Until,
    seen_from_eye,
};

/// March of `N` rays from the eye through views. Of each ray it takes a step, by its index, or a distance in metres; a ray with
/// none of them is left out.
pub(crate) trait March<const N: usize>: Sized {
    /// Returns the first steps, from these on, at which marching ends.
    fn first_steps(&mut self, until: Until, from: [Option<usize>; N], counters: &mut Counters) -> [Option<usize>; N];

    /// Returns those of the steps whose points are on or behind a surface.
    fn on_surface(&mut self, steps: [Option<usize>; N]) -> [Option<usize>; N];

    /// Bisects the intervals before these steps; see [`ActiveViews::refine`].
    fn refine(&mut self, hits: [Option<usize>; N], counters: &mut Counters) -> [Option<f32>; N];

    /// Interpolates the colours of the points at these distances.
    fn seen(&mut self, at_m: [Option<f32>; N]) -> [Option<Interpolated>; N];

    /// Returns the distances at which the rays meet a surface, from these steps on.
    fn hits(&mut self, from: [Option<usize>; N], counters: &mut Counters) -> [Option<f32>; N] {
        let steps = self.first_steps(Until::Surface, from, counters);
        self.refine(steps, counters)
    }

    /// Returns the first hits of the rays that have a step in `from`. `nearest` marches them through the nearest view alone.
    fn first_hits(
        &mut self,
        nearest: Option<&mut Self>,
        mut from: [Option<usize>; N],
        counters: &mut Counters,
    ) -> [FirstHits; N] {
        let mut nearest_m = [None; N];
        if let Some(nearest) = nearest {
            // The nearest view sees past all points before these steps.
            from = nearest.first_steps(Until::Unknown, from, counters);
            let known = nearest.on_surface(from);
            nearest_m = nearest.refine(known, counters);
        }
        let all_m = self.hits(from, counters);
        std::array::from_fn(|lane| FirstHits { nearest_m: nearest_m[lane], all_m: all_m[lane] })
    }

    /// Walks through layers, each until it is done, by answering its queries.
    fn follow(&mut self, walks: &mut [Option<LayerWalk<'_, '_>>; N], counters: &mut Counters) {
        while walks.iter().flatten().any(|walk| walk.query != Query::Done) {
            let queries = walks.each_ref().map(|walk| walk.as_ref().map_or(Query::Done, |walk| walk.query));
            let seen_m = queries.map(|query| if let Query::Color(at_m) = query { Some(at_m) } else { None });
            let tested = queries.map(|query| if let Query::Occupancy(step) = query { Some(step) } else { None });
            let marched = queries.map(|query| if let Query::Hit(first) = query { Some(first) } else { None });
            counters.march_steps += tested.iter().flatten().count() as u64;
            let (seen, surfaces) = (self.seen(seen_m), self.on_surface(tested));
            let hits = self.hits(marched, counters);
            for (lane, walk) in walks.iter_mut().enumerate() {
                let Some(walk) = walk else { continue };
                match walk.query {
                    Query::Color(at_m) => walk.answer_color(at_m, seen[lane]),
                    Query::Occupancy(step) => walk.answer_occupancy(step, surfaces[lane].is_some()),
                    Query::Hit(_) => walk.answer_hit(hits[lane]),
                    Query::Done => {}
                }
            }
        }
    }
}

/// March of a single ray: the scalar reference implementation.
struct RayMarch<'a> {
    views: &'a ActiveViews<'a>,
    ray: &'a Ray,
    settings: &'a RenderSettings,
}

impl March<1> for RayMarch<'_> {
    fn first_steps(&mut self, until: Until, [from]: [Option<usize>; 1], counters: &mut Counters) -> [Option<usize>; 1] {
        let from = from.map(|first| StepsFrom { steps: &self.settings.steps, first });
        [from.and_then(|from| first_step(self.settings.acceleration, self.views, (self.ray, from), until, counters))]
    }

    fn on_surface(&mut self, [step]: [Option<usize>; 1]) -> [Option<usize>; 1] {
        [step.filter(|&step| self.views.is_surface(self.ray.at(self.settings.steps.distances_m[step])))]
    }

    fn refine(&mut self, [hit]: [Option<usize>; 1], counters: &mut Counters) -> [Option<f32>; 1] {
        let steps = &self.settings.steps;
        [hit.map(|hit| self.views.refine(self.ray, steps.before(hit), steps.refine(), counters))]
    }

    fn seen(&mut self, [at_m]: [Option<f32>; 1]) -> [Option<Interpolated>; 1] {
        [at_m.and_then(|at_m| seen_from_eye(self.views, self.ray.at(at_m), self.settings))]
    }
}

impl Primary<'_> {
    fn march<'a>(&'a self, views: &'a ActiveViews<'a>, ray: &'a Ray) -> RayMarch<'a> {
        RayMarch { views, ray, settings: self.settings }
    }

    pub(crate) fn first_hits(&self, ray: &Ray, counters: &mut Counters) -> FirstHits {
        let mut nearest = self.nearest.as_ref().map(|nearest| self.march(nearest, ray));
        let [hits] = self.march(&self.views, ray).first_hits(nearest.as_mut(), [Some(0)], counters);
        hits
    }

    /// Returns all layers of a ray.
    pub(crate) fn hit(&self, ray: &Ray, counters: &mut Counters) -> PrimaryHit {
        let hits = self.first_hits(ray, counters);
        let mut walks = [Some(LayerWalk::new(self, ray, &hits))];
        self.march(&self.views, ray).follow(&mut walks, counters);
        let [walk] = walks;
        walk.map(|walk| walk.end(ray, counters)).unwrap_or_default()
    }
}
