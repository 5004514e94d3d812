//! Modes of blocks and of their quarters (depth.md 15.2).

/// Side of a block in pixels.
pub const BLOCK: usize = 8;
/// Side of a quarter of a block in pixels.
pub const SMALL: usize = 4;

/// Number of modes of blocks.
pub const MODES: usize = 10;
/// Mode: pixel by pixel.
pub const PIXELS: usize = 0;
/// Mode: unchanged from the frame before.
pub const SAME: usize = 1;
/// Mode: all background.
pub const BACKGROUND: usize = 2;
/// Mode: four quarters, each with a mode of its own.
pub const QUARTERS: usize = 3;
/// First of six modes: the plane from the left, from above, their mean; then the same three with a change.
pub const PLANES: usize = 4;
/// Number of sources of planes: left, above, mean.
pub const SOURCES: usize = 3;
/// Number of modes of quarters: pixels, and those of planes.
pub const SMALL_MODES: usize = 1 + 2 * SOURCES;
/// Number of states of a neighbouring block: its modes, and no block.
pub const BLOCK_STATES: usize = MODES + 1;
/// State of a neighbour that does not exist.
pub const OUTSIDE: usize = MODES;

/// Groups of block modes, for statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BlockCoding {
    Same,
    Background,
    /// A plane continued from a neighbour.
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

    /// Returns the group of a mode below [`MODES`].
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
