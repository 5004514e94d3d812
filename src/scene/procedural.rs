//! Small scenes made of formulas: footage for anyone, without a renderer and without a download.
//!
//! Enters: a time in seconds. Leaves: [`SceneAtTime`]. What moves is a function of the time alone and repeats after
//! [`DemoScene::PERIOD_S`]; what does not move is the same objects in the same order at every time.

mod cornell;
mod courtyard;
mod interior;
mod mirrors;
mod parts;
mod turning;

use glam::DVec3;

use super::object::Object;
use super::raycast::SceneAtTime;

/// The scenes there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DemoKind {
    /// A paved terrace under an open sky: brick wall to −X, striped wall with a lamp to −Z, pergola above, fence to +Z,
    /// nothing at all to +X. Three balls and a box move.
    Courtyard,
    /// A closed room with lamps, furniture and a lattice; three balls move, one of them behind the lattice.
    Interior,
    /// A knotted tube that turns in empty space: triangles, black around it, depth `+inf`.
    Object,
    /// A closed room with a glass ball and a mirror ball that moves.
    Mirrors,
    /// A box that is open to +Z, with a red and a green wall, a light in the ceiling and two blocks. Nothing moves.
    Cornell,
}

impl DemoKind {
    /// All scenes.
    pub const ALL: [DemoKind; 5] =
        [DemoKind::Courtyard, DemoKind::Interior, DemoKind::Object, DemoKind::Mirrors, DemoKind::Cornell];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            DemoKind::Courtyard => "courtyard",
            DemoKind::Interior => "interior",
            DemoKind::Object => "object",
            DemoKind::Mirrors => "mirrors",
            DemoKind::Cornell => "cornell",
        }
    }

    /// The scene of that name, if there is one.
    pub fn from_name(name: &str) -> Option<DemoKind> {
        DemoKind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A scene over time.
#[derive(Debug, Clone)]
pub struct DemoScene {
    kind: DemoKind,
    /// What never moves, the first objects of every moment.
    fixed: Vec<Object>,
}

impl DemoScene {
    /// Seconds after which everything is as it was.
    pub const PERIOD_S: f64 = 4.0;

    /// Sets the scene up.
    pub fn new(kind: DemoKind) -> Self {
        let fixed = match kind {
            DemoKind::Courtyard => courtyard::fixed(),
            DemoKind::Interior => interior::fixed(),
            DemoKind::Object => Vec::new(),
            DemoKind::Mirrors => mirrors::fixed(),
            DemoKind::Cornell => cornell::fixed(),
        };
        DemoScene { kind, fixed }
    }

    /// Which scene it is.
    pub fn kind(&self) -> DemoKind {
        self.kind
    }

    /// Seconds after which it repeats, 0 where nothing moves.
    pub fn duration_s(&self) -> f64 {
        if self.kind == DemoKind::Cornell { 0.0 } else { Self::PERIOD_S }
    }

    /// Where probes belong, in metres: the middle, and how far from it along each axis. From anywhere within, at any
    /// time, no surface is nearer than 0.4 m (in the courtyard 0.9 m), and in the courtyard the face +X sees nothing.
    pub fn probe_region(&self) -> (DVec3, DVec3) {
        match self.kind {
            DemoKind::Courtyard => courtyard::REGION,
            DemoKind::Interior => interior::REGION,
            DemoKind::Object => turning::REGION,
            DemoKind::Mirrors => mirrors::REGION,
            DemoKind::Cornell => cornell::REGION,
        }
    }

    /// The scene at a time in seconds, which may be negative; a time that is not finite is taken as 0.
    pub fn at(&self, time_s: f64) -> SceneAtTime {
        let time_s = if time_s.is_finite() { time_s } else { 0.0 };
        // 0..1 through the period.
        let phase = (time_s / Self::PERIOD_S).rem_euclid(1.0);
        match self.kind {
            DemoKind::Courtyard => courtyard::at(phase, self.fixed.clone()),
            DemoKind::Interior => interior::at(phase, self.fixed.clone()),
            DemoKind::Object => turning::at(phase),
            DemoKind::Mirrors => mirrors::at(phase, self.fixed.clone()),
            DemoKind::Cornell => cornell::at(self.fixed.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Face;
    use crate::mesh::AxisBox;
    use crate::scene::capture_face;

    #[test]
    fn names_round_trip() {
        for kind in DemoKind::ALL {
            assert_eq!(DemoKind::from_name(kind.name()), Some(kind));
            assert_eq!(DemoScene::new(kind).kind(), kind);
        }
        assert_eq!(DemoKind::from_name("castle"), None);
    }

    #[test]
    fn every_scene_keeps_its_region_free_and_moves_as_it_says() {
        for kind in DemoKind::ALL {
            let scene = DemoScene::new(kind);
            let (middle, half) = scene.probe_region();
            let region = AxisBox { min: middle - half, max: middle + half };
            let size = 16;
            let depths = |time: f64, probe: DVec3| {
                let moment = scene.at(time);
                Face::CUBE.map(|face| capture_face(&moment, probe, face, size).unwrap())
            };
            let first = depths(0.0, middle);
            let moved = [0.5, 1.3, 2.9].into_iter().any(|time| depths(time, middle) != first);
            assert_eq!(moved, scene.duration_s() > 0.0, "{kind:?}");
            assert_eq!(depths(DemoScene::PERIOD_S, middle), first, "{kind:?}");
            let mut seen = 0;
            for probe in region.corners().into_iter().chain([middle]) {
                for time in [0.0, 0.7, 1.9, 3.1] {
                    for (color, depth) in depths(time, probe) {
                        assert!(depth.data().iter().all(|&d| d > 0.4), "{kind:?} at {time} s from {probe}");
                        assert!(color.data().iter().flatten().all(|c| c.is_finite() && c.to_f32() >= 0.0));
                        seen += depth.data().iter().filter(|d| d.is_finite()).count();
                    }
                }
            }
            let all = 9 * 4 * 6 * (size * size) as usize;
            match kind {
                // No way out of a closed room.
                DemoKind::Interior | DemoKind::Mirrors => assert_eq!(seen, all, "{kind:?}"),
                DemoKind::Object => assert!(seen > all / 100 && seen < all / 5, "{seen} of {all}"),
                _ => assert!(seen > all / 3 && seen < all, "{kind:?}: {seen} of {all}"),
            }
        }
    }
}
