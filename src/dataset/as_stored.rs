//! Depth as files have it, for those who doubt what the manifest says of it.

use super::pixels::InvalidDepth;
use super::source::{Source, SourceGroup};
use super::stream::DepthKind;
use crate::error::Result;
use crate::image::equirect::resample_depth;
use crate::image::{ColorSpace, DepthPlane};

impl Source {
    /// Depth of a frame without regard to background, unit and kind: the numbers that the file holds, one plane for each
    /// face of the group. They may be anything, also NaN.
    pub fn read_depth_as_stored(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        let path = self.file(group, frame)?;
        let planes = self.depth_file(&path).and_then(|plane| self.faces_of(plane, group, resample_depth));
        planes.map_err(|error| error.in_file(&path).context(format!("frame {frame}")))
    }

    /// Metres per unit of depth, as stated or 1.
    pub fn depth_scale(&self) -> f64 {
        self.rules.scale
    }

    /// What becomes of a depth that is neither a surface nor the background.
    pub fn invalid_depth(&self) -> InvalidDepth {
        self.rules.invalid
    }

    /// What the files' depth is said to measure.
    pub fn depth_kind(&self) -> DepthKind {
        self.depth_kind
    }

    /// What the files' colour is said to mean, where anyone says it.
    pub fn color_space(&self) -> Option<ColorSpace> {
        self.color_space
    }
}
