//! The domain (kind of codes) in which two streams are compared, and the conversion of each side to it.

use half::f16;

use crate::compare::side::{Coding, Image, Side, SideForm, SideStream, Values};
use crate::dataset::InvalidDepth;
use crate::metrics::depth_error::{DepthPicture, OUTSIDE};
use codec::decode::Picture;
use codec::depth::quantise::FAR_CODE;
use codec::depth::{BACKGROUND_CODE, CodeTable, DepthRange, Quantiser};
use codec::error::{Error, Result};
use codec::image::{
    ColorPlane, DecodeTable, DepthPlane, EncodeTable, LightMatrix, Plane, Primaries, StreamKind, ToneMap,
};
use codec::metrics::pu21::DEFAULT_WHITE_CD_M2;
use codec::streams::{ColorFormat, convert};

/// Cell side in pixels if neither side states it.
const DEFAULT_CELL: u32 = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Coding of the container on side 0 or 1.
    Container(usize),
    /// Coding in the manifest of the decoded dataset on side 0 or 1.
    Manifest(usize),
    /// Neither side has a coding: depth codes span the surfaces of both sides, colour is 8-bit sRGB.
    Default,
}

/// Kind of codes in which colour is compared.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum ColorDomain {
    /// The coding of the container or of the decoded dataset, else 8-bit sRGB.
    #[default]
    AsCoded,
    /// Half floats. Without a white luminance, that of the coding is used, else that of a standard display.
    Half { white_cd_m2: Option<f64> },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    pub coding: Coding,
    pub origin: Origin,
}

impl Domain {
    /// Returns the primaries in which colours are compared: those of the side that states the coding, else of the first side.
    pub fn primaries(&self, sides: &[Side; 2]) -> Primaries {
        match self.origin {
            Origin::Container(at) | Origin::Manifest(at) => sides[at].primaries,
            Origin::Default => sides[0].primaries,
        }
    }

    /// Returns the domain of a pair of streams; `None` if its depth range must be found by a scan.
    pub fn of_pair(sides: &[Side; 2], streams: [&SideStream; 2], color: ColorDomain) -> Option<Domain> {
        Domain::of_codings(sides, streams).map(|domain| domain.with_color(color))
    }

    fn of_codings(sides: &[Side; 2], streams: [&SideStream; 2]) -> Option<Domain> {
        for (origin, container) in [(Origin::Container as fn(usize) -> Origin, true), (Origin::Manifest, false)] {
            for at in 0..2 {
                if (sides[at].form == SideForm::Container) == container
                    && let Some(coding) = streams[at].coding
                {
                    return Some(Domain { coding, origin: origin(at) });
                }
            }
        }
        let coding = match streams[0].id.kind {
            StreamKind::Depth => return None,
            StreamKind::Color => Coding::Color(ColorFormat::EightBit(ToneMap::default()), DEFAULT_CELL),
            StreamKind::Material | StreamKind::Alpha => Coding::Bytes,
        };
        Some(Domain { coding, origin: Origin::Default })
    }

    fn with_color(self, color: ColorDomain) -> Domain {
        let (Coding::Color(format, cell), ColorDomain::Half { white_cd_m2 }) = (self.coding, color) else {
            return self;
        };
        let (own, origin) = match format {
            ColorFormat::Half { white_cd_m2 } => (white_cd_m2, self.origin),
            ColorFormat::EightBit(_) => (DEFAULT_WHITE_CD_M2, Origin::Default),
        };
        let format = ColorFormat::Half { white_cd_m2: white_cd_m2.unwrap_or(own) };
        Domain { coding: Coding::Color(format, cell), origin }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Converted {
    Depth(DepthPicture),
    Bytes(Plane<[u8; 3]>),
    Half(ColorPlane),
}

#[derive(Debug, Clone, PartialEq)]
pub struct ConvertedImage {
    pub image: Converted,
    pub clipped_pixels: u64,
    /// Codes that extend beyond 8 bits; `None` unless pixels are clipped and clipping is not allowed.
    pub unclipped: Option<Plane<[i32; 3]>>,
}

/// Settings of the comparison of colour.
#[derive(Debug, Clone, Copy)]
pub struct ComparedColor {
    pub primaries: Primaries,
    pub allows_clipping: bool,
}

pub struct Converter {
    domain: Coding,
    own: Option<Coding>,
    quantiser: Option<Quantiser>,
    metres: Option<CodeTable>,
    codes: Option<EncodeTable>,
    light: Option<DecodeTable>,
    /// Conversion to the primaries of the comparison; `None` if the side has them.
    matrix: Option<LightMatrix>,
    allows_clipping: bool,
    /// Treatment of depth outside the range of the codes.
    invalid_depth: InvalidDepth,
}

impl Converter {
    /// Creates a converter for a stream of `side`; colour is converted to `color.primaries`.
    pub fn new(domain: Coding, side: &Side, stream: &SideStream, color: ComparedColor) -> Converter {
        let own = if side.form == SideForm::Container { stream.coding } else { None };
        let mut converter = Converter {
            domain,
            own,
            quantiser: None,
            metres: None,
            codes: None,
            light: None,
            matrix: side.primaries.conversion_to(color.primaries),
            allows_clipping: color.allows_clipping,
            invalid_depth: side.invalid_depth(),
        };
        let same = converter.keeps_codes();
        match domain {
            Coding::Depth(range) if !same => converter.quantiser = Some(Quantiser::new(range)),
            Coding::Color(ColorFormat::EightBit(tone), _) if !same => converter.codes = Some(EncodeTable::new(&tone)),
            _ => {}
        }
        match own {
            Some(Coding::Depth(range)) => converter.metres = Some(CodeTable::new(range, f32::INFINITY)),
            Some(Coding::Color(ColorFormat::EightBit(tone), _)) => converter.light = Some(DecodeTable::new(&tone)),
            _ => {}
        }
        converter
    }

    /// Returns true if the side's own codes are those of the domain; the cell size is ignored.
    fn keeps_codes(&self) -> bool {
        match (self.own, self.domain) {
            (Some(Coding::Color(own, _)), Coding::Color(domain, _)) => match (own, domain) {
                _ if self.matrix.is_some() => false,
                (ColorFormat::Half { .. }, ColorFormat::Half { .. }) => true,
                _ => own == domain,
            },
            (own, domain) => own == Some(domain),
        }
    }

    pub fn convert(&self, image: Image) -> Result<ConvertedImage> {
        let unclipped = |image| Ok(ConvertedImage { image, clipped_pixels: 0, unclipped: None });
        match (image, self.domain) {
            (Image::Coded(Picture::Depth(codes)), Coding::Depth(_)) if self.keeps_codes() => {
                let (width, metres) = (codes.width(), self.metres_of(&codes).into_data());
                let codes = codes.data().iter().map(|&code| i32::from(code)).collect();
                unclipped(Converted::Depth(DepthPicture { width, codes, metres }))
            }
            (Image::File(Values::Metres(metres)), Coding::Depth(range)) => {
                unclipped(Converted::Depth(self.quantise(metres, range)))
            }
            (image, Coding::Depth(range)) => {
                let Values::Metres(metres) = self.values(&image) else { return Err(wrong_kind()) };
                unclipped(Converted::Depth(self.quantise(metres, range)))
            }
            (Image::Coded(Picture::Color8(codes)), Coding::Color(ColorFormat::EightBit(_), _))
                if self.keeps_codes() =>
            {
                unclipped(Converted::Bytes(codes))
            }
            (Image::Coded(Picture::Material(codes)), Coding::Bytes) => unclipped(Converted::Bytes(codes)),
            (Image::File(Values::Weights(weights)), Coding::Bytes) => {
                unclipped(Converted::Bytes(convert::material_codes(&weights)?))
            }
            // Repeating alpha in three samples changes neither its mean nor its maximum error.
            (Image::Coded(Picture::Alpha(codes)), Coding::Bytes) => {
                unclipped(Converted::Bytes(codes.map(|&code| [code; 3])))
            }
            (Image::File(Values::Alpha(alpha)), Coding::Bytes) => {
                unclipped(Converted::Bytes(convert::alpha_codes(&alpha)?.map(|&code| [convert::alpha_byte(code); 3])))
            }
            (image, Coding::Color(..)) => {
                let values = match image {
                    Image::File(values) if self.matrix.is_none() => values,
                    image => self.values(&image),
                };
                let Values::Light(light) = values else { return Err(wrong_kind()) };
                let Some(table) = &self.codes else { return unclipped(Converted::Half(light)) };
                let (codes, clipped_pixels) = convert::color_codes(&light, table);
                let goes_on = clipped_pixels > 0 && !self.allows_clipping;
                let beyond = || light.map(|pixel| pixel.map(|value| table.unclipped_code(value)));
                let unclipped = goes_on.then(beyond);
                Ok(ConvertedImage { image: Converted::Bytes(codes), clipped_pixels, unclipped })
            }
            _ => Err(wrong_kind()),
        }
    }

    /// Returns metres, weights, alpha, or linear RGB in the primaries of the comparison.
    pub fn values(&self, image: &Image) -> Values {
        match (self.own_values(image), self.matrix) {
            (Values::Light(light), Some(matrix)) => Values::Light(matrix.convert_plane(&light)),
            (values, _) => values,
        }
    }

    fn own_values(&self, image: &Image) -> Values {
        match image {
            Image::Coded(Picture::Depth(codes)) => Values::Metres(self.metres_of(codes)),
            Image::Coded(Picture::Color8(codes)) => {
                let light = |code: &u8| self.light.as_ref().map_or(f16::ZERO, |table| table.value(*code));
                Values::Light(codes.map(|pixel| pixel.each_ref().map(light)))
            }
            Image::Coded(Picture::ColorHalf(light)) => Values::Light(light.clone()),
            Image::Coded(Picture::Material(codes)) => {
                // Decoded files store half floats.
                let half = |value: f32| f16::from_f32(value).to_f32();
                Values::Weights(convert::material_values(codes).map(|pixel| pixel.map(half)))
            }
            Image::Coded(Picture::Alpha(codes)) => {
                // Decoded files store half floats.
                let half = |code: u8| f16::from_f32(convert::alpha_value(code.into())).to_f32();
                Values::Alpha(codes.map(|&code| half(code)))
            }
            Image::File(values) => values.clone(),
        }
    }

    fn metres_of(&self, codes: &Plane<u16>) -> DepthPlane {
        codes.map(|&code| self.metres.as_ref().map_or(f32::INFINITY, |table| table.metres(code)))
    }

    fn quantise(&self, mut metres: DepthPlane, range: DepthRange) -> DepthPicture {
        // A container with another range has rounded depth by up to half a step of its own.
        let own = if let Some(Coding::Depth(own)) = self.own { own.step_ratio() } else { 0.0 };
        let tolerance = (range.step_ratio() + own) / 2.0;
        let code = |z: f32| match self.quantiser.as_ref().and_then(|quantiser| quantiser.code(z)) {
            Some(code) => i32::from(code),
            None => code_beyond(z, range, tolerance),
        };
        let (near, far) = (range.near_m(), range.far_m());
        let codes = metres.data_mut().iter_mut().map(|z| {
            match (code(*z), self.invalid_depth) {
                // Encoders replace such depth by the same rule.
                (OUTSIDE, InvalidDepth::Near) => *z = z.max(near).min(far),
                (OUTSIDE, InvalidDepth::Far) => *z = f32::INFINITY,
                (found, _) => {
                    if *z == 0.0 {
                        // `InvalidDepth::Near` reads invalid depth as 0.
                        *z = near;
                    }
                    return found;
                }
            }
            code(*z)
        });
        let codes = codes.collect();
        DepthPicture { width: metres.width(), codes, metres: metres.into_data() }
    }
}

/// Returns the code of a depth outside the range: the code of an end of the range that is within `tolerance` (a ratio), so that
/// the rounding of another coding is not counted as an error, else [`OUTSIDE`]. `+inf` is background.
fn code_beyond(z_m: f32, range: DepthRange, tolerance: f64) -> i32 {
    let (near, far, z) = (f64::from(range.near_m()), f64::from(range.far_m()), f64::from(z_m));
    if z_m == f32::INFINITY {
        i32::from(BACKGROUND_CODE)
    } else if z < near && near <= z * (1.0 + tolerance) {
        0
    } else if z > far && z <= far * (1.0 + tolerance) {
        i32::from(FAR_CODE)
    } else {
        OUTSIDE
    }
}

fn wrong_kind() -> Error {
    Error::invalid("an image of another kind than its stream")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_beyond_the_range_has_no_code_unless_rounding_put_it_there() {
        let range = DepthRange::new(1.0, 10.0).unwrap();
        let step = range.step_ratio();
        let code = |z: f64| code_beyond(z as f32, range, step / 2.0);
        assert_eq!(code(1.0 - 0.4 * step), 0);
        assert_eq!(code(1.0 - 0.6 * step), OUTSIDE);
        assert_eq!(code(10.0 * (1.0 + 0.4 * step)), i32::from(FAR_CODE));
        assert_eq!(code(10.0 * (1.0 + 0.6 * step)), OUTSIDE);
        assert_eq!(code(f64::INFINITY), i32::from(BACKGROUND_CODE));
        let single = DepthRange::new(1.0, 1.0).unwrap();
        assert_eq!(code_beyond(1.5, single, single.step_ratio()), OUTSIDE);
    }
}
