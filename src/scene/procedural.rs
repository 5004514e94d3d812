//! Built-in scenes. Moving objects depend on the time alone and repeat after [`DemoScene::PERIOD_S`]; static objects are the
//! same and in the same order at every time.

mod cornell;
mod courtyard;
mod fence;
mod interior;
mod lathe;
mod lettering;
mod mirrors;
mod parts;
mod street;
mod turning;

use glam::DVec3;

use self::parts::Definition;
use super::{Object, SceneAtTime};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DemoKind {
    Courtyard,
    Interior,
    Object,
    Mirrors,
    Cornell,
    Fence,
    Street,
}

impl DemoKind {
    pub const ALL: [DemoKind; 7] = [
        DemoKind::Courtyard,
        DemoKind::Interior,
        DemoKind::Object,
        DemoKind::Mirrors,
        DemoKind::Cornell,
        DemoKind::Fence,
        DemoKind::Street,
    ];

    fn definition(self) -> &'static Definition {
        match self {
            DemoKind::Courtyard => &courtyard::SCENE,
            DemoKind::Interior => &interior::SCENE,
            DemoKind::Object => &turning::SCENE,
            DemoKind::Mirrors => &mirrors::SCENE,
            DemoKind::Cornell => &cornell::SCENE,
            DemoKind::Fence => &fence::SCENE,
            DemoKind::Street => &street::SCENE,
        }
    }

    pub fn name(self) -> &'static str {
        self.definition().name
    }

    pub fn from_name(name: &str) -> Option<DemoKind> {
        DemoKind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

#[derive(Debug, Clone)]
pub struct DemoScene {
    pub kind: DemoKind,
    /// Static objects; they precede the moving objects at every time.
    fixed: Vec<Object>,
}

impl DemoScene {
    pub const PERIOD_S: f64 = 4.0;

    pub fn new(kind: DemoKind) -> Self {
        DemoScene { kind, fixed: (kind.definition().fixed)() }
    }

    /// Returns the period in seconds; 0 for a static scene.
    pub fn duration_s(&self) -> f64 {
        if self.kind == DemoKind::Cornell { 0.0 } else { Self::PERIOD_S }
    }

    /// Returns the region for probes: centre and half size, metres. Seen from any point of the region, at any time, no surface
    /// is nearer than 0.4 m (0.9 m in the courtyard).
    pub fn probe_region(&self) -> (DVec3, DVec3) {
        self.kind.definition().region
    }

    /// Returns the scene at a time. A negative time is allowed; a time that is not finite counts as 0.
    pub fn at(&self, time_s: f64) -> SceneAtTime {
        let time_s = if time_s.is_finite() { time_s } else { 0.0 };
        // 0..1 over the period.
        let phase = (time_s / Self::PERIOD_S).rem_euclid(1.0);
        (self.kind.definition().at)(phase, self.fixed.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture_face;
    use crate::mesh::AxisBox;
    use codec::image::Face;

    #[test]
    fn names_round_trip() {
        for kind in DemoKind::ALL {
            assert_eq!(DemoKind::from_name(kind.name()), Some(kind));
            assert_eq!(DemoScene::new(kind).kind, kind);
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
                let at_time = scene.at(time);
                Face::CUBE.map(|face| capture_face(&at_time, probe, face, size).unwrap())
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
                // Closed rooms have no background.
                DemoKind::Interior | DemoKind::Mirrors => assert_eq!(seen, all, "{kind:?}"),
                DemoKind::Object => assert!(seen > all / 100 && seen < all / 5, "{seen} of {all}"),
                _ => assert!(seen > all / 3 && seen < all, "{kind:?}: {seen} of {all}"),
            }
        }
    }
}
