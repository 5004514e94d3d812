//! Families of streams that one kernel decodes together.

use codec::image::StreamKind;
use codec::streams::{CodecHeader, ColorBlocks, ColorFormat, DepthCoding};
use kernels::Kernel;
use kernels::layout::Unit;
use kernels::pictures::code_stride;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelWords {
    /// Two 16-bit codes per word.
    Codes,
    /// Three bytes per word.
    Bytes,
    /// Three half floats per two words.
    Halves,
}

use PixelWords::{Bytes, Codes, Halves};

/// A family: streams that the same kernel decodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// The kernel that writes pixels.
    pub kernel: &'static Kernel,
    /// The kernel for keyframe chunks, for codecs that have both chunk types.
    pub keyframes: Option<&'static Kernel>,
    pub words: PixelWords,
    /// True if any frame of a chunk can be decoded directly; otherwise frames are reached by updating a picture.
    pub is_color: bool,
}

impl Family {
    pub fn of(header: &CodecHeader) -> Family {
        let (kernel, words) = match header {
            CodecHeader::Depth(header) => match header.coding {
                // Predictive chunks are converted to boxes when they are prepared.
                DepthCoding::Boxes(_) | DepthCoding::Predictive(_) => (&kernels::BOXES_CODES, Codes),
                DepthCoding::BoxesInBlocks(_) => (&kernels::BOXES_BC5, Codes),
                DepthCoding::Nodes(_) | DepthCoding::Tree(_) | DepthCoding::Blocks => (&kernels::NODES, Codes),
            },
            CodecHeader::Alpha(_) => (&kernels::BOXES_CODES, Codes),
            CodecHeader::Material(header) if header.in_blocks => (&kernels::BOXES_BC1, Bytes),
            CodecHeader::Material(_) => (&kernels::BOXES_MATERIAL, Bytes),
            CodecHeader::Color(header) if header.tables().is_some() => match header.format {
                ColorFormat::EightBit(_) => (&kernels::TRANSFORM_8BIT, Bytes),
                ColorFormat::Half { .. } => (&kernels::TRANSFORM_HALF, Halves),
            },
            CodecHeader::Color(header) => match (header.format, header.blocks()) {
                (ColorFormat::EightBit(_), None) => (&kernels::CELLS_8BIT, Bytes),
                (ColorFormat::EightBit(_), Some(ColorBlocks::Bc1)) => (&kernels::CELLS_BC1, Bytes),
                (ColorFormat::EightBit(_), Some(_)) => (&kernels::CELLS_BC7, Bytes),
                (ColorFormat::Half { .. }, None) => (&kernels::CELLS_HALF, Halves),
                (ColorFormat::Half { .. }, Some(_)) => (&kernels::CELLS_BC6H, Halves),
            },
        };
        let keyframes = match header {
            CodecHeader::Color(header) if header.tables().is_some() => {
                Some(if header.is_half() { &kernels::CELLS_HALF } else { &kernels::CELLS_8BIT })
            }
            _ => None,
        };
        Family { kernel, keyframes, words, is_color: header.kind() == StreamKind::Color }
    }

    pub fn plan(self) -> &'static Kernel {
        if self.is_color { &kernels::PLAN_CELLS } else { &kernels::PLAN_RECORDS }
    }

    /// Returns the row stride of a picture in words.
    pub fn stride(self, width: u32) -> u32 {
        match self.words {
            Codes => code_stride(width),
            Bytes => width,
            Halves => 2 * width,
        }
    }

    /// Creates a unit whose picture starts at word `picture`.
    pub fn unit(self, header: &CodecHeader, [width, height]: [u32; 2], picture: u32) -> Unit {
        let plain = Unit { picture, width, height, stride: self.stride(width), ..Unit::default() };
        match header {
            CodecHeader::Color(_) => plain,
            CodecHeader::Material(header) => Unit { window: header.temporal.window.into(), ..plain },
            CodecHeader::Alpha(_) => Unit { window: 1, ..plain },
            CodecHeader::Depth(header) => {
                let window = header.window().into();
                match header.coding {
                    DepthCoding::Boxes(_) | DepthCoding::BoxesInBlocks(_) | DepthCoding::Predictive(_) => {
                        Unit { window, ..plain }
                    }
                    DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) => {
                        let parts = nodes.domain;
                        Unit { window, domain: parts.kind as u32, base: parts.base, scale: parts.scale, ..plain }
                    }
                    // Every frame is coded independently.
                    DepthCoding::Blocks => plain,
                }
            }
        }
    }
}

/// Groups items with equal keys. The sizes of a group sum to at most `most`; a single larger item forms its own group.
pub fn groups<T, K: PartialEq>(items: impl Iterator<Item = (T, K, u64)>, most: u64) -> Vec<Vec<T>> {
    let mut groups: Vec<(K, u64, Vec<T>)> = Vec::new();
    for (item, key, size) in items {
        match groups.iter_mut().find(|(other, used, _)| *other == key && *used + size <= most) {
            Some((_, used, group)) => {
                *used += size;
                group.push(item);
            }
            None => groups.push((key, size, vec![item])),
        }
    }
    groups.into_iter().map(|(.., group)| group).collect()
}
