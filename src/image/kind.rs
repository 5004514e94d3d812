//! What the pixels of an image are, and how they were projected.

/// What the pixels of a stream are; the numbers are those of container.md 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum StreamKind {
    /// Linear Rec. 709 colour.
    Color = 0,
    /// Distance in metres.
    Depth = 1,
    /// Weights of reflection and refraction, index of refraction.
    Material = 2,
    /// The part of a pixel that surfaces cover; colour beside it is multiplied by it.
    Alpha = 3,
}

impl StreamKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [StreamKind; 4] = [StreamKind::Color, StreamKind::Depth, StreamKind::Material, StreamKind::Alpha];

    /// `color`, `depth`, `material` or `alpha`.
    pub fn name(self) -> &'static str {
        match self {
            StreamKind::Color => "color",
            StreamKind::Depth => "depth",
            StreamKind::Material => "material",
            StreamKind::Alpha => "alpha",
        }
    }

    /// The kind of that name, if there is one.
    pub fn from_name(name: &str) -> Option<StreamKind> {
        StreamKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The kind of that number, if there is one.
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
    /// Longitude across, latitude down.
    Equirect,
    /// A pinhole camera.
    Perspective,
}

impl Projection {
    /// As in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Projection::Cubemap => "cubemap",
            Projection::Equirect => "equirect",
            Projection::Perspective => "perspective",
        }
    }
}

/// What a depth value measures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum DepthKind {
    /// Euclidean distance from the centre of the probe.
    #[default]
    Distance,
    /// Distance along the viewing axis (Z buffer).
    Planar,
}

impl DepthKind {
    /// `distance` or `planar`.
    pub fn name(self) -> &'static str {
        if self == DepthKind::Distance { "distance" } else { "planar" }
    }
}
