//! Depth as stored, for checks of the manifest.

use super::pixels::InvalidDepth;
use super::source::{Source, SourceGroup};
use crate::error::Result;
use crate::image::equirect::resample_depth;
use crate::image::{ColorSpace, DepthKind, DepthPlane};

impl Source {
    /// Depth of a frame as stored, before background, unit and kind are applied: a plane per face of the group. Values may be
    /// anything, also NaN.
    pub fn read_depth_as_stored(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        let path = self.file(group, frame)?;
        let planes = self.depth_file(&path).and_then(|plane| self.faces_of(plane, group, resample_depth));
        planes.map_err(|error| error.in_file(&path).context(format!("frame {frame}")))
    }

    /// Metres per unit of depth, as stated or 1.
    pub fn depth_scale(&self) -> f64 {
        self.rules.scale
    }

    pub fn invalid_depth(&self) -> InvalidDepth {
        self.rules.invalid
    }

    pub fn depth_kind(&self) -> DepthKind {
        self.depth_kind
    }

    pub fn color_space(&self) -> Option<ColorSpace> {
        self.color_space
    }
}
