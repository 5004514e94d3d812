//! Hits of four primary rays at once.

use glam::Vec3;

use crate::march::layers::{LayerWalk, Query};
use crate::march::packet::color::seen_from_eye;
use crate::march::packet::intersect::{Packet, PacketMarch, bits_of};
use crate::march::packet::lanes::Lanes;
use crate::march::packet::views::PacketViews;
use crate::march::{Counters, Interpolated, Primary, PrimaryHit, Ray};

pub(crate) struct PacketScene<'a> {
    primary: &'a Primary<'a>,
    flat: PacketViews<'a>,
}

impl<'a> PacketScene<'a> {
    pub(crate) fn new(primary: &'a Primary<'a>) -> PacketScene<'a> {
        PacketScene { primary, flat: PacketViews::new(&primary.views) }
    }

    pub(crate) fn row(&'a self) -> PacketRow<'a> {
        PacketRow { scene: self, march: PacketMarch::new(&self.flat) }
    }
}

pub(crate) struct PacketRow<'a> {
    scene: &'a PacketScene<'a>,
    march: PacketMarch<'a>,
}

impl PacketRow<'_> {
    /// Returns the hits of up to four rays from the eye, given their directions of length 1.
    pub(crate) fn hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [PrimaryHit; 4] {
        let primary = self.scene.primary;
        let packet = Packet::new(directions);
        let hits = self.march.first_hits(&packet, primary.settings, counters);
        let met = hits.map(|hits| hits.all_m);
        let seen = self.seen(&packet, met);
        let ray = |lane: usize| Ray { origin: Vec3::ZERO, direction: directions[lane] };
        let mut shown = std::array::from_fn(|_| PrimaryHit::default());
        let mut walks = std::array::from_fn(|_| None);
        for lane in 0..directions.len().min(4) {
            match seen[lane].filter(|seen| primary.is_whole(&ray(lane), &hits[lane], seen)) {
                Some(seen) => shown[lane] = PrimaryHit::whole(met[lane], primary.light(seen.color)),
                None => {
                    let mut walk = LayerWalk::new(primary, &ray(lane), &hits[lane]);
                    if let (Query::Color(at_m), Some(hit_m)) = (walk.query, met[lane])
                        && at_m == hit_m
                    {
                        walk.answer_color(at_m, seen[lane]);
                    }
                    walks[lane] = Some(walk);
                }
            }
        }
        if walks.iter().any(Option::is_some) {
            self.follow(&packet, &mut walks, counters);
        }
        for (lane, walk) in walks.into_iter().enumerate() {
            if let Some(walk) = walk {
                shown[lane] = walk.end(&ray(lane), counters);
            }
        }
        shown
    }

    /// Advances the walks of all rays until they are done, as [`Primary::follow`] does for one ray.
    fn follow(&mut self, packet: &Packet, walks: &mut [Option<LayerWalk<'_, '_>>; 4], counters: &mut Counters) {
        let settings = self.scene.primary.settings;
        loop {
            let queries = walks.each_ref().map(|walk| walk.as_ref().map_or(Query::Done, |walk| walk.query));
            if queries == [Query::Done; 4] {
                return;
            }
            let seen_m = queries.map(|query| if let Query::Color(at_m) = query { Some(at_m) } else { None });
            let tested = queries.map(|query| if let Query::Occupancy(step) = query { Some(step) } else { None });
            let marched = queries.map(|query| if let Query::Hit(first) = query { Some(first) } else { None });
            let seen = self.seen(packet, seen_m);
            let surfaces = self.march.surfaces(packet, &settings.steps, tested, counters);
            let hits = self.march.hits(packet, settings, marched, counters);
            for (lane, walk) in walks.iter_mut().enumerate() {
                let Some(walk) = walk else { continue };
                match walk.query {
                    Query::Color(at_m) => walk.answer_color(at_m, seen[lane]),
                    Query::Occupancy(step) => walk.answer_occupancy(step, surfaces >> lane & 1 != 0),
                    Query::Hit(_) => walk.answer_hit(hits[lane]),
                    Query::Done => {}
                }
            }
        }
    }

    /// Interpolates the colours of the points at these distances in metres along the rays.
    fn seen(&mut self, packet: &Packet, at_m: [Option<f32>; 4]) -> [Option<Interpolated>; 4] {
        // Lanes without a distance copy that of another lane.
        let Some(other_m) = at_m.iter().flatten().next().copied() else { return [None; 4] };
        let points = packet.at(Lanes::from_array(at_m.map(|at_m| at_m.unwrap_or(other_m))));
        let asked = (bits_of(&at_m), &points);
        seen_from_eye(&self.scene.flat, self.march.guesses(), asked, self.scene.primary.settings)
    }
}
