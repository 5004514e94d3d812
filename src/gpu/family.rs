//! Families of streams that one dispatch can decode together: those of one kernel.

use crate::gpu::kernels::{self, Kernel};
use crate::gpu::layout::Unit;
use crate::gpu::pictures::code_stride;
use crate::streams::{CodecHeader, ColorBlocks, ColorFormat, DepthCoding};

/// Streams of one kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// `DQPN`, `DQTR`, `DB4W`.
    Nodes,
    /// `DAAB`.
    Codes,
    /// `DAB5`.
    CodesBc5,
    /// `MAAB`.
    Material,
    /// `MAB1`.
    MaterialBc1,
    /// `CCL8`.
    Cells8,
    /// `CCB1`.
    CellsBc1,
    /// `CCB7`.
    CellsBc7,
    /// `CCLH`.
    CellsHalf,
    /// `CCB6`.
    CellsBc6h,
}

/// What the words of a picture are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelWords {
    /// Two codes in a word.
    Codes,
    /// Three bytes in a word.
    Bytes,
    /// Three halves in two words.
    Halves,
}

impl Family {
    pub const ALL: [Family; 10] = [
        Family::Nodes,
        Family::Codes,
        Family::CodesBc5,
        Family::Material,
        Family::MaterialBc1,
        Family::Cells8,
        Family::CellsBc1,
        Family::CellsBc7,
        Family::CellsHalf,
        Family::CellsBc6h,
    ];

    /// The family of a stream.
    pub fn of(header: &CodecHeader) -> Family {
        match header {
            CodecHeader::Depth(header) => match header.coding {
                DepthCoding::Boxes(_) => Family::Codes,
                DepthCoding::BoxesInBlocks(_) => Family::CodesBc5,
                DepthCoding::Nodes(_) | DepthCoding::Tree(_) | DepthCoding::Blocks => Family::Nodes,
            },
            CodecHeader::Material(header) if header.in_blocks => Family::MaterialBc1,
            CodecHeader::Material(_) => Family::Material,
            CodecHeader::Color(header) => match (header.format, header.blocks) {
                (ColorFormat::EightBit(_), None) => Family::Cells8,
                (ColorFormat::EightBit(_), Some(ColorBlocks::Bc1)) => Family::CellsBc1,
                (ColorFormat::EightBit(_), Some(_)) => Family::CellsBc7,
                (ColorFormat::Half { .. }, None) => Family::CellsHalf,
                (ColorFormat::Half { .. }, Some(_)) => Family::CellsBc6h,
            },
        }
    }

    /// The kernel that writes pixels.
    pub fn kernel(self) -> &'static Kernel {
        match self {
            Family::Nodes => &kernels::NODES,
            Family::Codes => &kernels::BOXES_CODES,
            Family::CodesBc5 => &kernels::BOXES_BC5,
            Family::Material => &kernels::BOXES_MATERIAL,
            Family::MaterialBc1 => &kernels::BOXES_BC1,
            Family::Cells8 => &kernels::CELLS_8BIT,
            Family::CellsBc1 => &kernels::CELLS_BC1,
            Family::CellsBc7 => &kernels::CELLS_BC7,
            Family::CellsHalf => &kernels::CELLS_HALF,
            Family::CellsBc6h => &kernels::CELLS_BC6H,
        }
    }

    /// The kernel that plans its work.
    pub fn plan(self) -> &'static Kernel {
        if self.is_color() { &kernels::PLAN_CELLS } else { &kernels::PLAN_RECORDS }
    }

    /// Whether frames are blended of keyframes; else they are reached by changing a picture.
    pub fn is_color(self) -> bool {
        use Family::{Cells8, CellsBc1, CellsBc6h, CellsBc7, CellsHalf};
        matches!(self, Cells8 | CellsBc1 | CellsBc7 | CellsHalf | CellsBc6h)
    }

    /// What the words of its pictures are.
    pub fn words(self) -> PixelWords {
        match self {
            Family::Nodes | Family::Codes | Family::CodesBc5 => PixelWords::Codes,
            Family::CellsHalf | Family::CellsBc6h => PixelWords::Halves,
            _ => PixelWords::Bytes,
        }
    }

    /// Words of a row of a picture.
    pub fn stride(self, width: u32) -> u32 {
        match self.words() {
            PixelWords::Codes => code_stride(width),
            PixelWords::Bytes => width,
            PixelWords::Halves => 2 * width,
        }
    }

    /// A unit whose picture starts at word `picture`.
    pub fn unit(self, header: &CodecHeader, [width, height]: [u32; 2], picture: u32) -> Unit {
        let plain = Unit { picture, width, height, stride: self.stride(width), ..Unit::default() };
        match header {
            CodecHeader::Color(_) => plain,
            CodecHeader::Material(header) => Unit { window: header.temporal.window.into(), ..plain },
            CodecHeader::Depth(header) => {
                let window = header.window().into();
                match header.coding {
                    DepthCoding::Boxes(_) | DepthCoding::BoxesInBlocks(_) => Unit { window, ..plain },
                    DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) => {
                        let parts = nodes.domain;
                        Unit { window, domain: parts.kind as u32, base: parts.base, scale: parts.scale, ..plain }
                    }
                    // Each frame is whole: none is needed before another.
                    DepthCoding::Blocks => Unit { window: 0, ..plain },
                }
            }
        }
    }
}
