//! Hits of four primary rays at once.

use glam::Vec3;

use crate::march::packet::color::{LightCurve, seen_from_eye};
use crate::march::packet::intersect::{Packet, PacketMarch, bits_of};
use crate::march::packet::lanes::Lanes;
use crate::march::packet::views::PacketViews;
use crate::march::{Counters, Primary, PrimaryHit, Ray};
use crate::views::ColorCoding;

pub(crate) struct PacketScene<'a> {
    primary: &'a Primary<'a>,
    flat: PacketViews<'a>,
    curve: Option<LightCurve>,
}

impl<'a> PacketScene<'a> {
    pub(crate) fn new(primary: &'a Primary<'a>) -> PacketScene<'a> {
        let curve = match primary.views.coding {
            ColorCoding::Codes(tone) => Some(LightCurve::new(tone)),
            ColorCoding::Light => None,
        };
        PacketScene { primary, flat: PacketViews::new(&primary.views), curve }
    }

    pub(crate) fn row(&'a self) -> PacketRow<'a> {
        PacketRow { scene: self, march: PacketMarch::new(&self.flat) }
    }

    fn light(&self, color: Vec3) -> Vec3 {
        match &self.curve {
            Some(curve) => color.to_array().map(|code| curve.light(code)).into(),
            None => color,
        }
    }
}

pub(crate) struct PacketRow<'a> {
    scene: &'a PacketScene<'a>,
    march: PacketMarch<'a>,
}

impl PacketRow<'_> {
    /// Hits of up to four rays from the eye, by their directions of length 1. Those that show more than one surface are followed one by one.
    pub(crate) fn hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [PrimaryHit; 4] {
        let primary = self.scene.primary;
        let packet = Packet::new(directions);
        let hits = self.march.first_hits(&packet, primary.settings, counters);
        let met = hits.map(|hits| hits.all_m);
        let asked = bits_of(&met);
        let seen = if asked == 0 {
            [None; 4]
        } else {
            // Rays without a hit take the distance of another.
            let other_m = met.iter().flatten().next().copied().unwrap_or(1.0);
            let points = packet.at(Lanes::from_array(met.map(|distance_m| distance_m.unwrap_or(other_m))));
            seen_from_eye(&self.scene.flat, self.march.guesses(), (asked, &points), primary.settings.refinements)
        };
        std::array::from_fn(|lane| {
            let Some(&direction) = directions.get(lane) else { return PrimaryHit::default() };
            let ray = Ray { origin: Vec3::ZERO, direction };
            match seen[lane].filter(|seen| primary.is_whole(&ray, &hits[lane], seen)) {
                Some(seen) => PrimaryHit::whole(met[lane], self.scene.light(seen.color)),
                None => primary.follow(&ray, &hits[lane], counters),
            }
        })
    }
}
