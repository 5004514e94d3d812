//! Hits of four primary rays at once.

use glam::Vec3;

use crate::march::layers::{LayerWalk, Query};
use crate::march::packet::intersect::{Packet, PacketMarch};
use crate::march::packet::views::PacketViews;
use crate::march::primary_rays::March;
use crate::march::{Counters, FirstHits, Primary, PrimaryHit, Ray};

pub(crate) struct PacketScene<'a> {
    primary: &'a Primary<'a>,
    views: PacketViews<'a>,
    /// [`Primary::nearest`].
    nearest: Option<PacketViews<'a>>,
}

impl<'a> PacketScene<'a> {
    pub(crate) fn new(primary: &'a Primary<'a>) -> PacketScene<'a> {
        let nearest = primary.nearest.as_ref().map(PacketViews::new);
        PacketScene { primary, views: PacketViews::new(&primary.views), nearest }
    }

    pub(crate) fn row(&'a self) -> PacketRow<'a> {
        let march = |views| PacketMarch::new(views, self.primary.settings);
        PacketRow { primary: self.primary, march: march(&self.views), nearest: self.nearest.as_ref().map(march) }
    }

    /// Returns the hits of rays from the eye, given their directions of length 1.
    pub(crate) fn hits(&self, directions: &[Vec3], counters: &mut Counters) -> Vec<PrimaryHit> {
        let mut row = self.row();
        directions.chunks(4).flat_map(|four| row.hits(four, counters).into_iter().take(four.len())).collect()
    }
}

pub(crate) struct PacketRow<'a> {
    primary: &'a Primary<'a>,
    march: PacketMarch<'a>,
    nearest: Option<PacketMarch<'a>>,
}

impl PacketRow<'_> {
    /// Returns the first hits of up to four rays from the eye, given their directions of length 1.
    pub(crate) fn first_hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [FirstHits; 4] {
        let packet = Packet::new(directions);
        self.nearest.iter_mut().chain([&mut self.march]).for_each(|march| march.packet = packet);
        let from = std::array::from_fn(|lane| directions.get(lane).map(|_| 0));
        self.march.first_hits(self.nearest.as_mut(), from, counters)
    }

    /// Like [`PacketRow::first_hits`], with all layers.
    fn hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [PrimaryHit; 4] {
        let primary = self.primary;
        let hits = self.first_hits(directions, counters);
        let seen = self.march.seen(hits.map(|hits| hits.all_m));
        let ray = |lane: usize| Ray { origin: Vec3::ZERO, direction: directions[lane] };
        let mut shown = std::array::from_fn(|_| PrimaryHit::default());
        let mut walks = std::array::from_fn(|_| None);
        for lane in 0..directions.len().min(4) {
            match seen[lane].and_then(|seen| primary.whole(&ray(lane), &hits[lane], &seen)) {
                Some(whole) => shown[lane] = whole,
                None => {
                    let mut walk = LayerWalk::new(primary, &ray(lane), &hits[lane]);
                    if let (Query::Color(at_m), Some(hit_m)) = (walk.query, hits[lane].all_m)
                        && at_m == hit_m
                    {
                        walk.answer_color(at_m, seen[lane]);
                    }
                    walks[lane] = Some(walk);
                }
            }
        }
        self.march.follow(&mut walks, counters);
        for (lane, walk) in walks.into_iter().enumerate() {
            if let Some(walk) = walk {
                shown[lane] = walk.end(&ray(lane), counters);
            }
        }
        shown
    }
}
