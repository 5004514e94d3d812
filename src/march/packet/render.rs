//! What four rays from the eye bring: the fast form of [`crate::march::render::outcome`].

use glam::Vec3;

use crate::march::active_views::ActiveViews;
use crate::march::clip::ClipPlanes;
use crate::march::counters::Counters;
use crate::march::interpolate::Seen;
use crate::march::packet::color::{LightCurve, surface_colors};
use crate::march::packet::intersect::{Packet, PacketMarch, bits_of};
use crate::march::packet::lanes::Lanes;
use crate::march::packet::views::PacketViews;
use crate::march::ray::Ray;
use crate::march::settings::RenderSettings;
use crate::march::shading::{Outcome, background};
use crate::views::light_field::ColorCoding;

/// What all packets of a picture share.
#[derive(Debug)]
pub(crate) struct PacketScene<'a> {
    views: &'a ActiveViews<'a>,
    flat: PacketViews<'a>,
    camera_weights: &'a [f32],
    /// Of colours that are codes.
    curve: Option<LightCurve>,
    /// Of the camera, where it has them.
    clip: Option<ClipPlanes>,
}

impl<'a> PacketScene<'a> {
    pub(crate) fn new(
        views: &'a ActiveViews<'a>,
        camera_weights: &'a [f32],
        clip: Option<ClipPlanes>,
    ) -> PacketScene<'a> {
        let curve = match views.coding {
            ColorCoding::Codes(tone) => Some(LightCurve::new(tone)),
            ColorCoding::Light => None,
        };
        PacketScene { views, flat: PacketViews::new(views), camera_weights, curve, clip }
    }

    /// Makes packets of a row.
    pub(crate) fn row(&'a self, settings: &'a RenderSettings) -> PacketRow<'a> {
        PacketRow { scene: self, settings, unsure: settings.steps.unsure(), march: PacketMarch::new(&self.flat) }
    }

    fn light(&self, seen: &Seen) -> Vec3 {
        match &self.curve {
            Some(curve) => seen.color.to_array().map(|code| curve.light(code)).into(),
            None => seen.color,
        }
    }
}

/// Rays that lie beside each other.
#[derive(Debug)]
pub(crate) struct PacketRow<'a> {
    scene: &'a PacketScene<'a>,
    settings: &'a RenderSettings,
    /// [`crate::march::intersect::Steps::unsure`].
    unsure: f32,
    march: PacketMarch<'a>,
}

impl PacketRow<'_> {
    /// What up to four rays from the eye bring, by their directions of length 1, and the distances in metres at which
    /// those that meet a surface do.
    pub(crate) fn outcomes(&mut self, directions: &[Vec3], counters: &mut Counters) -> [(Option<f32>, Outcome); 4] {
        let (scene, settings) = (self.scene, self.settings);
        let packet = Packet::new(directions);
        let mut met = self.march.intersect(&packet, &settings.steps, settings.acceleration, counters);
        if let Some(clip) = &scene.clip {
            for (met, &direction) in met.iter_mut().zip(directions) {
                let ray = Ray { origin: Vec3::ZERO, direction };
                *met = met.and_then(|met_m| clip.shown((scene.views, &ray), met_m, settings, counters));
            }
        }
        let hits = bits_of(&met);
        let seen = if hits == 0 {
            [None; 4]
        } else {
            // Rays that meet nothing are taken to end where another does.
            let other_m = met.iter().flatten().next().copied().unwrap_or(1.0);
            let points = packet.at(Lanes::from_array(met.map(|distance_m| distance_m.unwrap_or(other_m))));
            surface_colors((&scene.flat, self.march.guesses()), scene.camera_weights, hits, &points)
        };
        std::array::from_fn(|lane| {
            let outcome = match directions.get(lane) {
                Some(_) if met[lane].is_some() => {
                    Outcome::of_surface(seen[lane], self.unsure, |seen| scene.light(seen))
                }
                Some(&direction) => {
                    counters.background_rays += 1;
                    background(scene.views, scene.camera_weights, direction)
                }
                None => Outcome::Hole(None),
            };
            (met[lane], outcome)
        })
    }
}
