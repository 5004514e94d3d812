//! Which streams one dispatch can decode together: those of one kernel.

use crate::gpu::kernels::{self, Kernel};
use crate::gpu::layout::Unit;
use crate::gpu::pictures::code_stride;
use crate::video::codec::{CodecHeader, ColorFormat, DepthCoding};

/// Streams of one kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// `DQPN`, `DQTR`, `DB4W`.
    Nodes,
    /// `DAAB`.
    Codes,
    /// `MAAB`.
    Material,
    /// `CCL8`.
    Cells8,
    /// `CCLH`.
    CellsHalf,
}

impl Family {
    /// The family of a stream.
    pub fn of(header: &CodecHeader) -> Family {
        match header {
            CodecHeader::Depth(header) => match header.coding {
                DepthCoding::Boxes(_) => Family::Codes,
                DepthCoding::Nodes(_) | DepthCoding::Tree(_) | DepthCoding::Blocks => Family::Nodes,
            },
            CodecHeader::Material(_) => Family::Material,
            CodecHeader::Color(header) => match header.format {
                ColorFormat::EightBit(_) => Family::Cells8,
                ColorFormat::Half { .. } => Family::CellsHalf,
            },
        }
    }

    /// The kernel that writes pixels.
    pub fn kernel(self) -> &'static Kernel {
        match self {
            Family::Nodes => &kernels::NODES,
            Family::Codes => &kernels::BOXES_CODES,
            Family::Material => &kernels::BOXES_MATERIAL,
            Family::Cells8 => &kernels::CELLS_8,
            Family::CellsHalf => &kernels::CELLS_HALF,
        }
    }

    /// The kernel that plans its work.
    pub fn plan(self) -> &'static Kernel {
        if self.is_color() { &kernels::PLAN_CELLS } else { &kernels::PLAN_RECORDS }
    }

    /// Whether frames are blended of keyframes; else they are reached by changing a picture.
    pub fn is_color(self) -> bool {
        matches!(self, Family::Cells8 | Family::CellsHalf)
    }

    /// Words of a row of a picture.
    pub fn stride(self, width: u32) -> u32 {
        match self {
            Family::Nodes | Family::Codes => code_stride(width),
            Family::Material | Family::Cells8 => width,
            Family::CellsHalf => 2 * width,
        }
    }

    /// A unit of so many pixels whose picture starts at word `picture`.
    pub fn unit(self, header: &CodecHeader, [width, height]: [u32; 2], picture: u32) -> Unit {
        let plain = Unit { picture, width, height, stride: self.stride(width), ..Unit::default() };
        match header {
            CodecHeader::Color(_) => plain,
            CodecHeader::Material(header) => Unit { window: header.temporal.window.into(), ..plain },
            CodecHeader::Depth(header) => {
                let window = header.window().into();
                match header.coding {
                    DepthCoding::Boxes(_) => Unit { window, ..plain },
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
