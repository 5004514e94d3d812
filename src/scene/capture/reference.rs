//! Parts of an image that are equal to those of an earlier image from the same viewpoint, and are copied.
//!
//! A ray in a scene always gives the same bits, so a tile of pixels is copied if nothing differs that its rays may meet: no object
//! that moved is before or behind it, no surface in it reflects or refracts rays, and neither lights nor shadow casters changed
//! anywhere. The copy has the bits that tracing would give.

use std::sync::Arc;

use super::images::Images;
use crate::mesh::AxisBox;
use crate::{Optics, SceneAtTime};

/// Images of a viewpoint at another time.
#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    pub scene: &'a SceneAtTime,
    pub images: &'a Images,
}

/// An image to copy from, and what differs.
#[derive(Debug)]
pub(super) struct Copied<'a> {
    pub images: &'a Images,
    /// Boxes of the objects that differ, at both times.
    moved: Vec<AxisBox>,
    /// Boxes of meshes with mirrors or glass.
    optical: Vec<AxisBox>,
}

impl<'a> Copied<'a> {
    /// Compares two times of a scene. `None` if lights, shadow casters, meshes or the scene's extent differ.
    pub(super) fn new(reference: &Reference<'a>, scene: &SceneAtTime) -> Option<Copied<'a>> {
        let old = reference.scene;
        let same_meshes = old.meshes.len() == scene.meshes.len()
            && old.meshes.iter().zip(&scene.meshes).all(|(old, new)| Arc::ptr_eq(old, new));
        let comparable = same_meshes
            && old.objects.len() == scene.objects.len()
            && old.light == scene.light
            && old.light_rays == scene.light_rays
            // The offset of ray origins depends on the extent.
            && old.bounds == scene.bounds;
        if !comparable {
            return None;
        }
        let mut moved = Vec::new();
        for (old, new) in old.objects.iter().zip(&scene.objects).filter(|(old, new)| old != new) {
            if old.is_occluder() || new.is_occluder() {
                return None;
            }
            moved.extend([old.bounds, new.bounds]);
        }
        let optical = scene.meshes.iter().filter(|mesh| mesh.has_optics()).filter_map(|mesh| mesh.bvh.bounds).collect();
        Some(Copied { images: reference.images, moved, optical })
    }

    /// True if a tile may be copied, given a test for boxes outside the tile and the objects that may be visible in it.
    pub(super) fn covers(&self, scene: &SceneAtTime, outside: impl Fn(&AxisBox) -> bool, candidates: &[usize]) -> bool {
        let is_opaque = |&index: &usize| scene.objects[index].material.optics == Optics::Opaque;
        self.moved.iter().chain(&self.optical).all(outside) && candidates.iter().all(is_opaque)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::view::capture_view_after;
    use crate::capture::{PassSettings, SamplePattern, Viewpoint, capture_view};
    use crate::{DemoKind, DemoScene, Pass};
    use codec::image::{DepthKind, Face, ImageProjection};
    use codec::monitor::Silent;

    #[test]
    fn copies_have_the_bits_of_traced_images() {
        let samples = SamplePattern::new(2).unwrap();
        let settings =
            PassSettings { passes: &Pass::ALL, samples: &samples, depth: DepthKind::Distance, far_m: f64::INFINITY };
        for kind in DemoKind::ALL {
            let scene = DemoScene::new(kind);
            let position = scene.probe_region().0;
            let [old, new] = [0.0, 0.8].map(|time| scene.at(time));
            for projection in [
                ImageProjection::cube_face(Face::Nz, 64),
                ImageProjection::cube_face(Face::Px, 32),
                ImageProjection::Equirect { size: [96, 48] },
            ] {
                let from = Viewpoint { position, orientation: None, projection };
                let images = capture_view(&old, &from, &settings, &Silent).unwrap();
                let reference = Some(Reference { scene: &old, images: &images });
                let after = capture_view_after(reference, &new, &from, &settings, &Silent).unwrap();
                assert!(after == capture_view(&new, &from, &settings, &Silent).unwrap(), "{kind:?} {projection:?}");
            }
        }
    }

    #[test]
    fn only_scenes_with_the_same_light_and_shadows_are_compared() {
        let images = Images::default();
        let compared = |kind: DemoKind| {
            let [old, new] = [0.0, 0.8].map(|time| DemoScene::new(kind).at(time));
            let copied = Copied::new(&Reference { scene: &old, images: &images }, &new)?;
            let is_outside = |within: f64| move |bounds: &AxisBox| bounds.min.z > within;
            Some([-40.0, 40.0].map(|within| copied.covers(&new, is_outside(within), &[])))
        };
        // A lamp pulses; a ball casts a shadow.
        assert_eq!([DemoKind::Courtyard, DemoKind::Interior].map(compared), [None, None]);
        assert_eq!(compared(DemoKind::Street), Some([true, false]));
        let still = DemoScene::new(DemoKind::Cornell).at(0.0);
        assert!(Copied::new(&Reference { scene: &still, images: &images }, &still).is_some());
    }
}
