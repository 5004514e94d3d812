//! Hits of four primary rays at once.

use glam::Vec3;

use crate::march::packet::color::{LightCurve, surface_colors};
use crate::march::packet::intersect::{Packet, PacketMarch, bits_of};
use crate::march::packet::lanes::Lanes;
use crate::march::packet::views::PacketViews;
use crate::march::{ActiveViews, ClipPlanes, Counters, PrimaryHit, Ray, RayResult, RenderSettings, background};
use crate::views::ColorCoding;

pub(crate) struct PacketScene<'a> {
    views: &'a ActiveViews<'a>,
    flat: PacketViews<'a>,
    curve: Option<LightCurve>,
    clip: Option<ClipPlanes>,
}

impl<'a> PacketScene<'a> {
    pub(crate) fn new(views: &'a ActiveViews<'a>, clip: Option<ClipPlanes>) -> PacketScene<'a> {
        let curve = match views.coding {
            ColorCoding::Codes(tone) => Some(LightCurve::new(tone)),
            ColorCoding::Light => None,
        };
        PacketScene { views, flat: PacketViews::new(views), curve, clip }
    }

    pub(crate) fn row(&'a self, settings: &'a RenderSettings) -> PacketRow<'a> {
        PacketRow {
            scene: self,
            settings,
            uncertainty: settings.steps.uncertainty(),
            march: PacketMarch::new(&self.flat),
        }
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
    settings: &'a RenderSettings,
    /// [`crate::march::ray::Steps::uncertainty`].
    uncertainty: f32,
    march: PacketMarch<'a>,
}

impl PacketRow<'_> {
    /// Hits of up to four rays from the eye, by their directions of length 1.
    pub(crate) fn hits(&mut self, directions: &[Vec3], counters: &mut Counters) -> [PrimaryHit; 4] {
        let (scene, settings) = (self.scene, self.settings);
        let packet = Packet::new(directions);
        let mut met = self.march.intersect(&packet, &settings.steps, settings.acceleration, counters);
        if let Some(clip) = &scene.clip {
            for (met, &direction) in met.iter_mut().zip(directions) {
                let ray = Ray { origin: Vec3::ZERO, direction };
                *met = met.and_then(|met_m| clip.visible_hit(scene.views, &ray, met_m, settings, counters));
            }
        }
        let hits = bits_of(&met);
        let seen = if hits == 0 {
            [None; 4]
        } else {
            // Rays without a hit take the distance of another.
            let other_m = met.iter().flatten().next().copied().unwrap_or(1.0);
            let points = packet.at(Lanes::from_array(met.map(|distance_m| distance_m.unwrap_or(other_m))));
            surface_colors(&scene.flat, self.march.guesses(), hits, &points)
        };
        std::array::from_fn(|lane| {
            let result = match directions.get(lane) {
                Some(_) if met[lane].is_some() => {
                    RayResult::of_surface(seen[lane], self.uncertainty, |color| scene.light(color))
                }
                Some(&direction) => {
                    counters.background_rays += 1;
                    background(scene.views, direction)
                }
                None => RayResult::Disoccluded(None),
            };
            PrimaryHit { distance_m: met[lane], result }
        })
    }
}
