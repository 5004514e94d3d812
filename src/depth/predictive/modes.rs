//! Modes of blocks and of their quarters (depth.md 15.2).

/// Side of a block.
pub const BLOCK: usize = 8;
/// Side of a quarter of a block.
pub const SMALL: usize = 4;

/// Modes of blocks, as below.
pub const MODES: usize = 10;
/// Pixel by pixel.
pub const PIXELS: usize = 0;
/// As in the frame before.
pub const SAME: usize = 1;
/// All background.
pub const BACKGROUND: usize = 2;
/// Four quarters, each with a mode of its own.
pub const QUARTERS: usize = 3;
/// The first of three: the plane from the left, from above, their mean; then the same with a change.
pub const PLANES: usize = 4;
/// Sources of planes.
pub const SOURCES: usize = 3;
/// Modes of quarters: pixels, and those of planes.
pub const SMALL_MODES: usize = 1 + 2 * SOURCES;
/// Modes, and no block.
pub const BLOCK_STATES: usize = MODES + 1;
/// The state where there is no block.
pub const OUTSIDE: usize = MODES;

/// Modes of blocks in groups, for statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BlockCoding {
    Same,
    Background,
    /// A neighbour's plane carried on.
    Plane,
    ChangedPlane,
    Quarters,
    Pixels,
}

impl BlockCoding {
    pub const ALL: [BlockCoding; 6] = {
        use BlockCoding::{Background, ChangedPlane, Pixels, Plane, Quarters, Same};
        [Same, Background, Plane, ChangedPlane, Quarters, Pixels]
    };

    /// Of a mode below [`MODES`].
    pub fn of(mode: usize) -> BlockCoding {
        match mode {
            PIXELS => BlockCoding::Pixels,
            SAME => BlockCoding::Same,
            BACKGROUND => BlockCoding::Background,
            QUARTERS => BlockCoding::Quarters,
            _ if mode < PLANES + SOURCES => BlockCoding::Plane,
            _ => BlockCoding::ChangedPlane,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            BlockCoding::Same => "same",
            BlockCoding::Background => "background",
            BlockCoding::Plane => "plane",
            BlockCoding::ChangedPlane => "changed_plane",
            BlockCoding::Quarters => "quarters",
            BlockCoding::Pixels => "pixels",
        }
    }
}
