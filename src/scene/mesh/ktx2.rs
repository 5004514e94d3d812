//! KTX2 images of Basis Universal (ETC1S and UASTC), as glTF files have them (KHR_texture_basisu).

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use footage::guard::guarded;

use super::budget::Budget;
use codec::error::{Error, Result};

/// First bytes of a KTX2 file (KTX 2.0, section 3.1).
const IDENTIFIER: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes of the header and of the index of its sections; entries of the levels follow (KTX 2.0, section 3).
const HEADER_BYTES: usize = 80;
/// Bytes of the entry of a level: offset, size, and size without supercompression.
const LEVEL_BYTES: usize = 24;
/// Maximum number of levels: those of 2^31 pixels a side.
const MAX_LEVELS: usize = 32;

pub fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(IDENTIFIER)
}

/// Returns width, height and RGBA codes of the largest level. `cap` is the maximum of bytes that an image of this size in the
/// file may take.
pub fn decode(bytes: &[u8], cap: u64, budget: &mut Budget) -> Result<([u32; 2], Vec<[u8; 4]>)> {
    let [width, height] = claimed_size(bytes, cap)?;
    let pixels = u64::from(width) * u64::from(height);
    // Pixels as transcoded, and as returned.
    budget.take(pixels, 8, "an image")?;
    // The crate reads files of all kinds of tools, and does not promise that it never panics.
    let transcoded = guarded(|| {
        let transcoder = Transcoder::new(bytes)?;
        transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
    });
    let rgba = match transcoded {
        Some(Ok(rgba)) => rgba,
        Some(Err(_)) => {
            return Err(Error::unsupported("the KTX2 image has no 8-bit colours of Basis Universal; save it as PNG"));
        }
        None => return Err(Error::invalid("the KTX2 image is damaged")),
    };
    let rgba = rgba.as_chunks::<4>().0.to_vec();
    if rgba.len() as u64 != pixels {
        return Err(Error::invalid(format!("the KTX2 image has {} pixels, its header {width}x{height}", rgba.len())));
    }
    Ok(([width, height], rgba))
}

/// Returns the size that the header states, if it and the levels fit in `cap` bytes.
fn claimed_size(bytes: &[u8], cap: u64) -> Result<[u32; 2]> {
    let ends = || Error::invalid(format!("the KTX2 image ends early, after {} bytes", bytes.len()));
    let word = |at: usize| bytes.get(at..)?.first_chunk::<4>().map(|word| u32::from_le_bytes(*word));
    let [Some(width), Some(height), Some(levels)] = [20, 24, 40].map(word) else { return Err(ends()) };
    let long = |at: usize| bytes.get(at..)?.first_chunk::<8>().map(|word| u64::from_le_bytes(*word));
    let mut claimed = 4 * u64::from(width) * u64::from(height);
    if levels as usize > MAX_LEVELS {
        return Err(Error::invalid(format!("the KTX2 image has {levels} levels, at most {MAX_LEVELS} are possible")));
    }
    for level in 0..levels.max(1) as usize {
        claimed = claimed.saturating_add(long(HEADER_BYTES + LEVEL_BYTES * level + 16).ok_or_else(ends)?);
    }
    match (width, height, claimed) {
        (0, ..) | (_, 0, _) => Err(Error::invalid("the image has no pixels")),
        (.., claimed) if claimed > cap => {
            let claims = format!("the image claims {width}x{height} pixels");
            Err(Error::invalid(format!("{claims} and {claimed} bytes, more than its {} bytes can hold", bytes.len())))
        }
        _ => Ok([width, height]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a KTX2 file of 8x4 pixels: two solid blocks of UASTC.
    fn solid(colors: [[u8; 4]; 2]) -> Vec<u8> {
        let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        let mut file = IDENTIFIER.to_vec();
        // No Vulkan format; one level, face and layer; no supercompression.
        file.extend(words(&[0, 1, 8, 4, 0, 0, 1, 1, 0]));
        // Data format descriptor behind the entry of the level; no keys, no global data.
        file.extend(words(&[104, 44, 0, 0, 0, 0, 0, 0]));
        file.extend([148u64, 32, 32].into_iter().flat_map(u64::to_le_bytes));
        // Colour model 166, UASTC, of sRGB in blocks of 4x4 pixels and 16 bytes; one sample of 128 bits.
        file.extend(words(&[
            44,
            0,
            2 | 40 << 16,
            166 | 1 << 8 | 2 << 16,
            3 | 3 << 8,
            16,
            0,
            127 << 16 | 3 << 24,
            0,
            0,
            u32::MAX,
        ]));
        for [r, g, b, a] in colors {
            let place = |code: u8, bit: u32| u128::from(code) << bit;
            // Mode 8, a solid colour.
            file.extend((place(0x17, 0) | place(r, 5) | place(g, 13) | place(b, 21) | place(a, 29)).to_le_bytes());
        }
        file
    }

    fn decoded(bytes: &[u8]) -> Result<([u32; 2], Vec<[u8; 4]>)> {
        decode(bytes, 1 << 20, &mut Budget::new(bytes.len() as u64))
    }

    #[test]
    fn blocks_of_uastc_become_pixels() {
        let colors = [[200, 10, 30, 255], [0, 100, 250, 128]];
        let (size, pixels) = decoded(&solid(colors)).unwrap();
        assert_eq!(size, [8, 4]);
        assert!((0..32).all(|at| pixels[at] == colors[at % 8 / 4]), "{pixels:?}");
    }

    #[test]
    fn damaged_files_are_refused() {
        let file = solid([[1; 4]; 2]);
        assert!(is_ktx2(&file));
        for length in IDENTIFIER.len()..file.len() {
            assert!(decoded(&file[..length]).is_err(), "{length}");
        }
        for (at, byte) in (0..file.len()).flat_map(|at| [0, 1, 127, 255].map(|byte| (at, byte))) {
            let mut other = file.clone();
            other[at] = byte;
            // Some are valid.
            assert!(
                decoded(&other).is_ok_and(|([width, height], pixels)| pixels.len() as u32 == width * height)
                    || decoded(&other).is_err()
            );
        }
        let mut large = file.clone();
        large[20..28].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
        let said = decoded(&large).unwrap_err().to_string();
        assert!(said.contains("65536x65536"), "{said}");
        let mut bomb = file;
        bomb[96..104].copy_from_slice(&(1u64 << 40).to_le_bytes());
        assert!(decoded(&bomb).unwrap_err().to_string().contains("1099511627904"));
    }
}
