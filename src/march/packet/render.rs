//! Hits of four primary rays at once.

use glam::Vec3;

use crate::march::layers::{Ask, Follower};
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
    /// Hits of up to four rays from the eye, by their directions of length 1.
    pub(crate) fn hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [PrimaryHit; 4] {
        let primary = self.scene.primary;
        let packet = Packet::new(directions);
        let hits = self.march.first_hits(&packet, primary.settings, counters);
        let met = hits.map(|hits| hits.all_m);
        let seen = self.seen(&packet, met);
        let ray = |lane: usize| Ray { origin: Vec3::ZERO, direction: directions[lane] };
        let mut shown = std::array::from_fn(|_| PrimaryHit::default());
        let mut followers = std::array::from_fn(|_| None);
        for lane in 0..directions.len().min(4) {
            match seen[lane].filter(|seen| primary.is_whole(&ray(lane), &hits[lane], seen)) {
                Some(seen) => shown[lane] = PrimaryHit::whole(met[lane], primary.light(seen.color)),
                None => {
                    let mut follower = Follower::new(primary, &ray(lane), &hits[lane]);
                    if let (Ask::Seen(at_m), Some(hit_m)) = (follower.ask, met[lane])
                        && at_m == hit_m
                    {
                        follower.saw(at_m, seen[lane]);
                    }
                    followers[lane] = Some(follower);
                }
            }
        }
        if followers.iter().any(Option::is_some) {
            self.follow(&packet, &mut followers, counters);
        }
        for (lane, follower) in followers.into_iter().enumerate() {
            if let Some(follower) = follower {
                shown[lane] = follower.end(&ray(lane), counters);
            }
        }
        shown
    }

    /// Drives rays until they are done, as [`Primary::follow`] does one.
    fn follow(&mut self, packet: &Packet, followers: &mut [Option<Follower<'_, '_>>; 4], counters: &mut Counters) {
        let settings = self.scene.primary.settings;
        loop {
            let asks =
                followers.each_ref().map(|follower| follower.as_ref().map_or(Ask::Done, |follower| follower.ask));
            if asks == [Ask::Done; 4] {
                return;
            }
            let seen_m = asks.map(|ask| if let Ask::Seen(at_m) = ask { Some(at_m) } else { None });
            let tested = asks.map(|ask| if let Ask::IsSurface(step) = ask { Some(step) } else { None });
            let marched = asks.map(|ask| if let Ask::Hit(first) = ask { Some(first) } else { None });
            let seen = self.seen(packet, seen_m);
            let surfaces = self.march.surfaces(packet, &settings.steps, tested, counters);
            let hits = self.march.hits(packet, settings, marched, counters);
            for (lane, follower) in followers.iter_mut().enumerate() {
                let Some(follower) = follower else { continue };
                match follower.ask {
                    Ask::Seen(at_m) => follower.saw(at_m, seen[lane]),
                    Ask::IsSurface(step) => follower.tested(step, surfaces >> lane & 1 != 0),
                    Ask::Hit(_) => follower.hit(hits[lane]),
                    Ask::Done => {}
                }
            }
        }
    }

    /// What the views see on rays at these distances in metres.
    fn seen(&mut self, packet: &Packet, at_m: [Option<f32>; 4]) -> [Option<Interpolated>; 4] {
        // Rays without a distance take that of another.
        let Some(other_m) = at_m.iter().flatten().next().copied() else { return [None; 4] };
        let points = packet.at(Lanes::from_array(at_m.map(|at_m| at_m.unwrap_or(other_m))));
        let asked = (bits_of(&at_m), &points);
        seen_from_eye(&self.scene.flat, self.march.guesses(), asked, self.scene.primary.settings)
    }
}
