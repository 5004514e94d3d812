//! Decoded pictures as a display shows them.

use codec::decode::Picture;
use codec::image::plane::Plane;
use codec::image::transfer::{DecodeTable, EncodeTable, ToneMap, Transfer};
use codec::streams::{CodecHeader, ColorFormat, ColorHeader, convert};

/// Returns the sRGB codes of a colour picture; half floats above 1 are clipped. `None` for depth and alpha.
pub fn srgb(header: &CodecHeader, picture: &Picture) -> Option<Plane<[u8; 3]>> {
    let usual = || EncodeTable::new(&ToneMap::default());
    match (picture, header) {
        (Picture::Color8(codes), CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }))
            if tone.transfer == Transfer::Linear =>
        {
            let light = convert::color_light(codes, &DecodeTable::new(tone));
            Some(convert::color_codes(&light, &usual()).0)
        }
        (Picture::Color8(codes) | Picture::Material(codes), _) => Some(codes.clone()),
        (Picture::ColorHalf(light), _) => Some(convert::color_codes(light, &usual()).0),
        (Picture::Depth(_) | Picture::Alpha(_), _) => None,
    }
}
