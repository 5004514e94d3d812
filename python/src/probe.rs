//! Probes: position and orientation of captured images.

use library::{ProbeEntry, ProbePose};
use pyo3::prelude::*;

/// Position and orientation from which images were captured.
///
/// `position` is in metres, `orientation` a unit quaternion (x, y, z, w) from the probe's axes to the world's, and `intrinsics`
/// (fx, fy, cx, cy) in pixels for a probe with a single view, or `None`.
///
/// >>> lightfold.Probe("left", position=(-0.3, 1.5, 0))
/// Probe('left', position=(-0.3, 1.5, 0.0))
#[pyclass(frozen, eq, from_py_object, get_all, module = "lightfold")]
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Name, unique within a container.
    pub name: String,
    /// Centre of projection in metres.
    pub position: (f64, f64, f64),
    /// Unit quaternion (x, y, z, w) from the probe's axes to the world's.
    pub orientation: (f64, f64, f64, f64),
    /// (fx, fy, cx, cy) in pixels, or `None` for a cube map.
    pub intrinsics: Option<(f64, f64, f64, f64)>,
}

#[pymethods]
impl Probe {
    #[new]
    #[pyo3(
        signature = (name, position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0), intrinsics=None),
        text_signature = "(name, position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0), intrinsics=None)"
    )]
    pub fn new(
        name: String,
        position: (f64, f64, f64),
        orientation: (f64, f64, f64, f64),
        intrinsics: Option<(f64, f64, f64, f64)>,
    ) -> Probe {
        Probe { name, position, orientation, intrinsics }
    }

    fn __repr__(&self) -> String {
        let Probe { name, position, orientation, intrinsics } = self;
        let mut text = format!("Probe('{name}', position={position:?}");
        if *orientation != (0.0, 0.0, 0.0, 1.0) {
            text += &format!(", orientation={orientation:?}");
        }
        if let Some(intrinsics) = intrinsics {
            text += &format!(", intrinsics={intrinsics:?}");
        }
        text + ")"
    }
}

impl Probe {
    pub fn of_entry(entry: &ProbeEntry) -> Probe {
        let intrinsics = entry.intrinsics;
        Probe {
            name: entry.name.clone(),
            position: entry.position.into(),
            orientation: entry.orientation.into(),
            intrinsics: (intrinsics != [0.0; 4]).then(|| intrinsics.into()),
        }
    }

    pub fn pose(&self) -> ProbePose {
        ProbePose {
            position: self.position.into(),
            orientation: self.orientation.into(),
            intrinsics: self.intrinsics.map(Into::into),
        }
    }
}
