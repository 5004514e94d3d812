//! Named colour spaces of image files.

use serde::{Deserialize, Serialize};

use codec::image::{Primaries, Transfer};

/// Encoding and primaries of the values of colour files. All spaces but sRGB are linear; the maximum code of a PNG file is 1.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColorSpace {
    /// Linear RGB, Rec. 709 primaries.
    #[serde(rename = "linear-rec709")]
    LinearRec709,
    /// sRGB codes, Rec. 709 primaries.
    #[serde(rename = "srgb")]
    Srgb,
    /// Linear RGB, AP1 primaries.
    #[serde(rename = "acescg")]
    AcesCg,
    /// Linear RGB, AP0 primaries.
    #[serde(rename = "aces2065-1")]
    Aces2065,
    /// Linear RGB, Rec. 2020 primaries.
    #[serde(rename = "linear-rec2020")]
    LinearRec2020,
    /// Linear RGB, P3 primaries with D65 white.
    #[serde(rename = "linear-p3-d65")]
    LinearP3D65,
}

impl ColorSpace {
    pub const ALL: [ColorSpace; 6] = [
        ColorSpace::LinearRec709,
        ColorSpace::Srgb,
        ColorSpace::AcesCg,
        ColorSpace::Aces2065,
        ColorSpace::LinearRec2020,
        ColorSpace::LinearP3D65,
    ];

    /// Returns the name used in manifests.
    pub fn name(self) -> &'static str {
        match self {
            ColorSpace::LinearRec709 => "linear-rec709",
            ColorSpace::Srgb => "srgb",
            ColorSpace::AcesCg => "acescg",
            ColorSpace::Aces2065 => "aces2065-1",
            ColorSpace::LinearRec2020 => "linear-rec2020",
            ColorSpace::LinearP3D65 => "linear-p3-d65",
        }
    }

    pub fn primaries(self) -> Primaries {
        match self {
            ColorSpace::LinearRec709 | ColorSpace::Srgb => Primaries::REC709,
            ColorSpace::AcesCg => Primaries::ACESCG,
            ColorSpace::Aces2065 => Primaries::ACES2065_1,
            ColorSpace::LinearRec2020 => Primaries::REC2020,
            ColorSpace::LinearP3D65 => Primaries::P3_D65,
        }
    }

    pub fn transfer(self) -> Transfer {
        if self == ColorSpace::Srgb { Transfer::Srgb } else { Transfer::Linear }
    }

    /// Returns the linear colour space with these primaries, if it is a named one.
    pub fn of_light(primaries: Primaries) -> Option<ColorSpace> {
        ColorSpace::ALL
            .into_iter()
            .find(|space| space.transfer() == Transfer::Linear && space.primaries().is_same(primaries))
    }
}
