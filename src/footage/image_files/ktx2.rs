//! Writes textures of compressed blocks as KTX 2.0 (Khronos Texture 2.0, revision 4): one mip level, no supercompression.

use codec::error::{Error, Result};

const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes of the header, the index and the index entry of one level (sections 3.1 to 3.9).
const HEAD: usize = 80 + 24;
/// Bytes per block, equal for all formats of this module; levels start at multiples of it (section 3.9.7).
pub const BLOCK_BYTES: usize = 16;
/// Row 0 is the top row.
const ORIENTATION: (&str, &str) = ("KTXorientation", "rd");
const WRITER: (&str, &str) = ("KTXwriter", "lightfold");

/// Compressed texture formats with 16 bytes per block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockFormat {
    /// sRGB codes with straight (not premultiplied) alpha.
    Bc7Srgb,
    /// Linear RGB, unsigned.
    Bc6hUnsigned,
    /// ASTC of 8 bits with this block footprint: sRGB codes with straight alpha.
    AstcSrgb(AstcBlock),
}

/// Block footprints of ASTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AstcBlock {
    /// 8 bits per pixel.
    Pixels4x4,
    /// 3.56 bits per pixel.
    Pixels6x6,
    /// 2 bits per pixel.
    Pixels8x8,
}

impl AstcBlock {
    /// Returns the width and height of a block in pixels.
    pub fn side(self) -> u32 {
        match self {
            AstcBlock::Pixels4x4 => 4,
            AstcBlock::Pixels6x6 => 6,
            AstcBlock::Pixels8x8 => 8,
        }
    }

    fn vk_format(self) -> u32 {
        match self {
            AstcBlock::Pixels4x4 => 158,
            AstcBlock::Pixels6x6 => 166,
            AstcBlock::Pixels8x8 => 172,
        }
    }
}

/// Fields of the header and the data format descriptor that depend on the block format.
struct Description {
    vk_format: u32,
    /// Khronos Data Format 1.3, section 5.6.
    color_model: u8,
    /// Transfer function: 1 linear, 2 sRGB.
    transfer: u8,
    /// Qualifiers of the single sample: 0x80 for floating point.
    qualifiers: u8,
    /// Bits of the sample value that represents 1.0.
    upper: u32,
}

impl BlockFormat {
    /// Returns the width and height of a block in pixels.
    pub fn side(self) -> u32 {
        match self {
            BlockFormat::Bc7Srgb | BlockFormat::Bc6hUnsigned => 4,
            BlockFormat::AstcSrgb(block) => block.side(),
        }
    }

    fn description(self) -> Description {
        match self {
            BlockFormat::Bc6hUnsigned => {
                Description { vk_format: 143, color_model: 133, transfer: 1, qualifiers: 0x80, upper: 1f32.to_bits() }
            }
            BlockFormat::Bc7Srgb => {
                Description { vk_format: 146, color_model: 134, transfer: 2, qualifiers: 0, upper: u32::MAX }
            }
            BlockFormat::AstcSrgb(block) => Description {
                vk_format: block.vk_format(),
                color_model: 162,
                transfer: 2,
                qualifiers: 0,
                upper: u32::MAX,
            },
        }
    }
}

/// Returns the bytes of a file with one texture of `width`×`height` pixels; `blocks` are in row order.
pub fn bytes(format: BlockFormat, [width, height]: [u32; 2], blocks: &[u8]) -> Result<Vec<u8>> {
    let [columns, rows] = [width, height].map(|side| u64::from(side.div_ceil(format.side())));
    if columns * rows == 0 || blocks.len() as u64 != columns * rows * BLOCK_BYTES as u64 {
        return Err(Error::invalid(format!("{} bytes of blocks for a texture of {width}x{height}", blocks.len())));
    }
    let Description { vk_format, .. } = format.description();
    let (descriptor, pairs) = (data_format_descriptor(format), key_value_data());
    let (first_descriptor, first_pair) = (HEAD, HEAD + descriptor.len());
    let first_block = (first_pair + pairs.len()).next_multiple_of(BLOCK_BYTES);
    // Type size 1 for block formats, depth 0, layer count 0 (no array), one face, one level, no supercompression.
    let header = [vk_format, 1, width, height, 0, 0, 1, 1, 0];
    let index = [first_descriptor, descriptor.len(), first_pair, pairs.len()].map(|at| at as u32);
    let of_level = [first_block, blocks.len(), blocks.len()].map(|at| at as u64);
    let mut file = IDENTIFIER.to_vec();
    file.extend(header.into_iter().chain(index).flat_map(u32::to_le_bytes));
    // Offset and length of the supercompression global data: none.
    file.extend([0; 2].into_iter().chain(of_level).flat_map(u64::to_le_bytes));
    file.extend(descriptor);
    file.extend(pairs);
    file.resize(first_block, 0);
    file.extend_from_slice(blocks);
    Ok(file)
}

/// Returns the descriptor: its size in bytes and one basic block with one sample of 128 bits (Khronos Data Format
/// 1.3, section 5).
fn data_format_descriptor(format: BlockFormat) -> Vec<u8> {
    let Description { color_model, transfer, qualifiers, upper, .. } = format.description();
    let (block_bytes, version, primaries_bt709, flag_straight_alpha) = (24 + 16, 2u16, 1, 0);
    let mut bytes = u32::to_le_bytes(4 + block_bytes).to_vec();
    // Vendor Khronos, descriptor type basic.
    bytes.extend([0; 4]);
    bytes.extend(version.to_le_bytes());
    bytes.extend((block_bytes as u16).to_le_bytes());
    bytes.extend([color_model, primaries_bt709, transfer, flag_straight_alpha]);
    let last = format.side() as u8 - 1;
    bytes.extend([last, last, 0, 0]);
    bytes.extend([BLOCK_BYTES as u8, 0, 0, 0, 0, 0, 0, 0]);
    // Bits 0 to 127, channel 0 (colour), sample position at the block corner.
    bytes.extend([0, 0, 127, qualifiers, 0, 0, 0, 0]);
    bytes.extend([0, upper].into_iter().flat_map(u32::to_le_bytes));
    bytes
}

/// Returns the key/value entries, sorted by key, each padded to a multiple of four bytes (section 3.11).
fn key_value_data() -> Vec<u8> {
    let mut bytes = Vec::new();
    for (key, value) in [ORIENTATION, WRITER] {
        let pair = [key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use ::ktx2::{ColorModel, Reader, TransferFunction};

    use super::*;

    const ASTC: [BlockFormat; 3] = [
        BlockFormat::AstcSrgb(AstcBlock::Pixels4x4),
        BlockFormat::AstcSrgb(AstcBlock::Pixels6x6),
        BlockFormat::AstcSrgb(AstcBlock::Pixels8x8),
    ];

    fn blocks(count: usize) -> Vec<u8> {
        (0..count * BLOCK_BYTES).map(|at| at as u8).collect()
    }

    #[test]
    fn an_independent_reader_finds_the_texture() {
        let cases = [
            (BlockFormat::Bc7Srgb, ::ktx2::Format::BC7_SRGB_BLOCK, ColorModel::BC7, TransferFunction::SRGB),
            (BlockFormat::Bc6hUnsigned, ::ktx2::Format::BC6H_UFLOAT_BLOCK, ColorModel::BC6H, TransferFunction::Linear),
            (ASTC[0], ::ktx2::Format::ASTC_4x4_SRGB_BLOCK, ColorModel::ASTC, TransferFunction::SRGB),
            (ASTC[1], ::ktx2::Format::ASTC_6x6_SRGB_BLOCK, ColorModel::ASTC, TransferFunction::SRGB),
            (ASTC[2], ::ktx2::Format::ASTC_8x8_SRGB_BLOCK, ColorModel::ASTC, TransferFunction::SRGB),
        ];
        for (format, vk_format, model, transfer) in cases {
            let count = 10u32.div_ceil(format.side()) * 8u32.div_ceil(format.side());
            let blocks = blocks(count as usize);
            let file = bytes(format, [10, 8], &blocks).unwrap();
            let reader = Reader::new(&file).unwrap();
            let header = reader.header();
            assert_eq!(header.format, Some(vk_format));
            assert_eq!((header.type_size, header.pixel_width, header.pixel_height), (1, 10, 8));
            assert_eq!((header.pixel_depth, header.layer_count, header.face_count, header.level_count), (0, 0, 1, 1));
            assert_eq!((reader.color_model(), reader.transfer_function()), (Some(model), Some(transfer)));
            assert_eq!(reader.color_primaries(), Some(::ktx2::ColorPrimaries::BT709));
            assert_eq!(reader.is_alpha_premultiplied(), Some(false));
            // Both values are NUL-terminated.
            assert_eq!(reader.writer(), Some("lightfold\0"));
            let levels: Vec<_> = reader.levels().collect();
            assert_eq!(levels.len(), 1);
            assert_eq!((levels[0].data, levels[0].uncompressed_byte_length), (&blocks[..], u64::from(16 * count)));
        }
    }

    /// Checks rules of the specification that readers do not have to enforce.
    #[test]
    fn descriptor_keys_and_alignment_are_as_the_specification_has_them() {
        for format in [BlockFormat::Bc7Srgb, BlockFormat::Bc6hUnsigned, ASTC[0], ASTC[2]] {
            let file = bytes(format, [4, 4], &blocks(1)).unwrap();
            let word = |at: usize| u32::from_le_bytes(*file[at..].first_chunk().unwrap()) as usize;
            let long = |at: usize| u64::from_le_bytes(*file[at..].first_chunk().unwrap()) as usize;
            let [descriptor, descriptor_bytes, pairs, pairs_bytes] = [48, 52, 56, 60].map(word);
            let [global, global_bytes, level, level_bytes, plain_bytes] = [64, 72, 80, 88, 96].map(long);
            assert_eq!((descriptor, descriptor_bytes, word(descriptor)), (104, 44, 44));
            assert_eq!((pairs, pairs % 4, global, global_bytes), (148, 0, 0, 0));
            assert_eq!((level % 16, level_bytes, plain_bytes, level + 16), (0, 16, 16, file.len()));
            assert!(file[pairs + pairs_bytes..level].iter().all(|byte| *byte == 0));
            let last = format.side() as u8 - 1;
            // One basic block of version 2, with texel blocks of 16 bytes in its single plane.
            assert_eq!([word(descriptor + 4), word(descriptor + 8)], [0, 2 | 40 << 16]);
            assert_eq!(file[descriptor + 16..descriptor + 28], [last, last, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0]);
            // The sample: 128 bits, range 0 to 1.
            let is_float = format == BlockFormat::Bc6hUnsigned;
            let (kind, upper) = if is_float { (0x80, 0x3f80_0000) } else { (0, u32::MAX as usize) };
            assert_eq!(file[descriptor + 28..descriptor + 36], [0, 0, 127, kind, 0, 0, 0, 0]);
            assert_eq!([word(descriptor + 36), word(descriptor + 40)], [0, upper]);
            // Keys are sorted and NUL-terminated, and lengths do not include the padding.
            let (mut at, mut keys) = (pairs, Vec::new());
            while at < pairs + pairs_bytes {
                let pair = &file[at + 4..at + 4 + word(at)];
                assert_eq!(pair.last(), Some(&0));
                keys.push(pair.split(|byte| *byte == 0).next().unwrap());
                at += (4 + pair.len()).next_multiple_of(4);
            }
            assert_eq!((at, keys), (pairs + pairs_bytes, vec![&b"KTXorientation"[..], b"KTXwriter"]));
        }
    }

    #[test]
    fn blocks_of_another_size_are_refused() {
        for (size, count) in [([8, 8], 3), ([9, 8], 4), ([0, 4], 0)] {
            let said = bytes(BlockFormat::Bc7Srgb, size, &blocks(count)).unwrap_err().to_string();
            assert!(said.contains(&format!("{}x{}", size[0], size[1])), "{said}");
        }
    }
}
