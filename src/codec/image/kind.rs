//! Kinds of image streams, projections and kinds of depth.

/// Quantity that the pixels of a stream hold; the discriminants are those of container.md 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum StreamKind {
    /// Linear Rec. 709 colour.
    Color = 0,
    /// Distance in metres.
    Depth = 1,
    /// Reflection weight, refraction weight, index of refraction.
    Material = 2,
    /// Coverage of a pixel by surfaces; colour of the same image is premultiplied by it.
    Alpha = 3,
}

impl StreamKind {
    /// All kinds, in the order of their discriminants.
    pub const ALL: [StreamKind; 4] = [StreamKind::Color, StreamKind::Depth, StreamKind::Material, StreamKind::Alpha];

    /// Returns `color`, `depth`, `material` or `alpha`.
    pub fn name(self) -> &'static str {
        match self {
            StreamKind::Color => "color",
            StreamKind::Depth => "depth",
            StreamKind::Material => "material",
            StreamKind::Alpha => "alpha",
        }
    }

    /// Returns the kind with that name, or `None`.
    pub fn from_name(name: &str) -> Option<StreamKind> {
        StreamKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns the kind with that index, or `None`.
    pub fn from_index(index: u8) -> Option<StreamKind> {
        StreamKind::ALL.into_iter().find(|kind| *kind as u8 == index)
    }
}

/// Projection of the images of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Projection {
    /// Faces of an OpenGL cube map.
    Cubemap,
    /// Longitude along x, latitude along y.
    Equirect,
    /// A pinhole camera.
    Perspective,
}

impl Projection {
    /// Returns the name used in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Projection::Cubemap => "cubemap",
            Projection::Equirect => "equirect",
            Projection::Perspective => "perspective",
        }
    }
}

/// Definition of a depth value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum DepthKind {
    /// Euclidean distance from the probe centre.
    #[default]
    Distance,
    /// Distance along the viewing axis (Z buffer).
    Planar,
}

impl DepthKind {
    /// Returns `distance` or `planar`.
    pub fn name(self) -> &'static str {
        if self == DepthKind::Distance { "distance" } else { "planar" }
    }
}
