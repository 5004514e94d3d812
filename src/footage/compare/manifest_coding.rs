//! Reads the coding of a decoded dataset from its manifest.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::compare::side::Coding;
use crate::dataset::Manifest;
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::{Face, StreamKind, ToneMap, Transfer};
use codec::streams::ColorFormat;

/// The value `extra.lightfold` in the manifest of a decoded dataset.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct ManifestCoding {
    color: Option<ColorCoding>,
    /// Depth codings by `probe/face`.
    depth: Option<BTreeMap<String, DepthCoding>>,
}

#[derive(Debug, Clone, Deserialize)]
struct DepthCoding {
    near_m: f32,
    far_m: f32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "format")]
enum ColorCoding {
    #[serde(rename = "8bit")]
    EightBit { transfer: Transfer, exposure_ev: f32, cell: u32 },
    #[serde(rename = "half")]
    Half { white_cd_m2: f64, cell: u32 },
}

impl ManifestCoding {
    pub fn of(manifest: &Manifest) -> Result<Option<ManifestCoding>> {
        let Some(coding) = manifest.extra.as_ref().and_then(|extra| extra.get("lightfold")) else {
            return Ok(None);
        };
        ManifestCoding::deserialize(coding)
            .map(Some)
            .map_err(|error| Error::invalid(format!("extra.lightfold was not written by lightfold: {error}")))
    }

    pub fn stream(&self, kind: StreamKind, probe: &str, face: Face) -> Result<Option<Coding>> {
        Ok(match kind {
            StreamKind::Depth => {
                let range = self.depth.as_ref().and_then(|ranges| ranges.get(&format!("{probe}/{}", face.name())));
                range.map(|range| DepthRange::new(range.near_m, range.far_m).map(Coding::Depth)).transpose()?
            }
            StreamKind::Color => self.color.as_ref().map(|coding| match *coding {
                ColorCoding::EightBit { transfer, exposure_ev, cell } => {
                    Coding::Color(ColorFormat::EightBit(ToneMap { transfer, exposure_ev }), cell.max(1))
                }
                ColorCoding::Half { white_cd_m2, cell } => {
                    Coding::Color(ColorFormat::Half { white_cd_m2 }, cell.max(1))
                }
            }),
            StreamKind::Material | StreamKind::Alpha => Some(Coding::Bytes),
        })
    }
}
