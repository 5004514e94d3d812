//! Images of a capture from one viewpoint.

use codec::image::plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};

/// Planes of the requested passes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Images {
    pub color: Option<ColorPlane>,
    pub depth: Option<DepthPlane>,
    pub normal: Option<Plane<[f32; 3]>>,
    pub material: Option<MaterialPlane>,
}

impl Images {
    /// Returns the size of each plane.
    pub(super) fn shape(&self) -> [Option<[u32; 2]>; 4] {
        fn size<T: Copy>(plane: &Option<Plane<T>>) -> Option<[u32; 2]> {
            plane.as_ref().map(|plane| [plane.width(), plane.height()])
        }
        [size(&self.color), size(&self.depth), size(&self.normal), size(&self.material)]
    }
}
