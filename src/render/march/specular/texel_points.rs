//! Surface points of texels with specular materials.

use glam::DVec3;

use crate::march::{ActiveView, ActiveViews};
use crate::views::{BACKGROUND, FaceTexels, UNKNOWN};
use codec::image::Face;

#[derive(Debug, Clone, Copy)]
pub struct SpecularImage<'a> {
    pub view: &'a ActiveView<'a>,
    /// Index of its face.
    pub face: usize,
    pub texels: &'a FaceTexels,
}

impl<'a> SpecularImage<'a> {
    /// Returns the specular images of all views that are decoded on the CPU.
    pub fn all(views: &'a ActiveViews<'a>) -> Vec<SpecularImage<'a>> {
        let of_view = |view: &'a ActiveView<'a>| {
            let faces = view.view.faces.iter().enumerate();
            faces.filter_map(move |(face, texels)| Some(SpecularImage { view, face, texels: texels.as_ref()? }))
        };
        let all = views.views.iter().flat_map(of_view);
        all.filter(|image| image.texels.is_specular && !image.texels.is_in_backend()).collect()
    }

    /// Returns the centre of a texel on its surface, in metres relative to the eye. None if the texel has no surface.
    pub fn point(&self, at: usize) -> Option<DVec3> {
        let inverse = self.texels.inverse_depth[at];
        if inverse == BACKGROUND || inverse == UNKNOWN {
            return None;
        }
        let local = self.texels.direction(Face::from_index(self.face as u8)?, at) / f64::from(inverse);
        let point = self.view.probe_from_world.as_dmat3().transpose() * local + self.view.from_eye.as_dvec3();
        point.is_finite().then_some(point)
    }

    pub fn is_refractive(&self, at: usize) -> bool {
        self.texels.material.as_ref().is_some_and(|material| material[at][1] > 0)
    }
}
