//! Upper bounds of the memory used by an encode, and the number of frames read at once that follows from them.
//!
//! The output does not depend on these limits, except on [`ColorMemory`], which is derived only from footage and settings. A
//! batch has as many frames as fit; if the state of the encoders does not fit, the encode fails before it starts. Memory does not
//! accumulate over probes or groups, which are encoded one after the other.

use crate::dataset::SourceGroup;
use crate::encode::{ColorCodec, DepthCodec, EncodeSettings};
use codec::color::SearchSettings;
use codec::color::temporal::CLOSE_AT_BYTES as COLOR_CLOSE_AT_BYTES;
use codec::color::transform::blocks::padded_pixels;
use codec::decode::memory::compressing_bytes;
use codec::depth::open_chunk::close_at_bytes;
use codec::depth::predictive::encoder::FRAME_BYTES_A_PIXEL;
use codec::error::Result;
use codec::image::{Face, StreamKind};
use codec::memory::{Budget, Need};
use codec::streams::CodecHeader;

const BATCH_FRAMES: usize = 16;
const BATCH_PIXELS: usize = 64 << 20;
/// Maximum bytes of depth images that a scan keeps to avoid reading them twice.
const KEEP_BYTES: u64 = 512 << 20;
/// Maximum bytes of pictures that the cells of a group hold until the next keyframe.
const PENDING_BYTES: u64 = 768 << 20;
/// Maximum bytes of keyframes in the open chunks of a group.
const OPEN_BYTES: usize = 384 << 20;

/// Bytes per pixel of a tile, for the thread that encodes it. For node codecs: the codes; one leaf per 16 pixels (1 byte a
/// pixel); nodes of 48 bytes with their positions, at most 4/3 per 16 pixels, held three times: as found, as sent, and as
/// children while their parent is tried (3 times 4 bytes a pixel, plus half of that for growth of vectors).
const TILE_WORK_BYTES: u64 = 24;
/// Bytes per pixel of a tile of predictive depth: its codes. The chunk that is being finished is counted separately.
const PREDICTIVE_WORK_BYTES: u64 = 2;
/// Bytes per byte of the open chunk of predictive depth while it is finished: 6 for each coding step, which takes 2 bytes.
const PREDICTIVE_FINISHING: u64 = 3;
const PREDICTIVE_FRAME_BYTES: u64 = FRAME_BYTES_A_PIXEL as u64;

/// Bytes per pixel of a chunk of a cell for the search of the transform codec: coefficients of four block sizes in three channels
/// (48), keys and samples (24), levels of two partitions and of the candidates (48), and at most 100 for nodes and positions of
/// 4x4 blocks in them.
const SEARCH_BYTES: u64 = 220;

#[derive(Debug, Clone, Copy)]
pub(super) struct ScanLimits {
    pub keep_bytes: u64,
    pub frames_at_once: usize,
    /// True if the set of distinct distances is needed to find levels.
    pub finds_levels: bool,
}

impl Default for ScanLimits {
    fn default() -> Self {
        ScanLimits { keep_bytes: KEEP_BYTES, frames_at_once: usize::MAX, finds_levels: false }
    }
}

/// Limits for the keyframe-and-weight cells of a group. They are derived only from footage and settings, because the output
/// depends on them.
#[derive(Clone, Copy)]
pub(super) struct ColorMemory {
    /// Search settings, with a shorter lookahead if more pictures than `PENDING_BYTES` would be pending.
    pub search: SearchSettings,
    pub close_at_bytes: usize,
}

impl ColorMemory {
    pub fn new(group: &SourceGroup, settings: &EncodeSettings) -> ColorMemory {
        let search = settings.search;
        let picture = group_pixels(group) * CodecHeader::Color(settings.color_header()).raw_pixel_bytes();
        let lookahead = (PENDING_BYTES / picture.max(1)).clamp(1, u64::from(search.lookahead.max(1))) as u32;
        let close_at_bytes = COLOR_CLOSE_AT_BYTES.min(OPEN_BYTES / unit_count(group, settings).max(1) as usize);
        ColorMemory { search: SearchSettings { lookahead, ..search }, close_at_bytes }
    }
}

/// Memory needed to encode one group, in bytes, and the parallelism that follows from it.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupNeed {
    /// Tables shared by all groups for reading.
    tables: u64,
    /// One frame while it is read and converted.
    reading: u64,
    /// Depth images that a scan may keep.
    pub keep: u64,
    /// Number of units coded at the same time.
    pub units_at_once: usize,
    /// Tables, encoders with their open chunks, depth images that a scan kept, and working memory of units.
    fixed: u64,
    /// One frame of a batch.
    frame: u64,
    /// Usual number of frames of a batch.
    usual_frames: usize,
    /// Advice other than allowing more memory; may be empty.
    instead: &'static str,
}

/// Memory in bytes that the encoders of a group hold, and working memory of a thread for the unit that it codes.
struct State {
    held: u64,
    unit: u64,
}

impl GroupNeed {
    /// Computes the need of a group. `tables` and `reading` are the bytes of tables and of reading a frame.
    pub fn new(group: &SourceGroup, settings: &EncodeSettings, tables: u64, reading: u64) -> GroupNeed {
        let (pixels, threads) = (group_pixels(group), rayon::current_num_threads());
        let coded = pixels
            * match group.kind {
                StreamKind::Depth | StreamKind::Alpha => 2,
                StreamKind::Color => CodecHeader::Color(settings.color_header()).raw_pixel_bytes(),
                StreamKind::Material => 3,
            };
        let reading = reading + coded;
        let State { held, unit } = match (group.kind, settings.color_codec) {
            (StreamKind::Color, ColorCodec::Transform) => transform_state(group, settings),
            (StreamKind::Color, ColorCodec::Cells) => color_state(group, settings),
            _ => tile_state(group, settings),
        };
        let held = tables + held;
        let units = Need { what: "", fixed: held + coded, each: unit, instead: "" };
        // At least one; if even one does not fit, a later check reports it.
        let units_at_once = settings.memory.at_once(&units, threads).unwrap_or(1);
        let work = unit * units_at_once as u64;
        // A single thread reads all frames of a batch before any is coded.
        let (fixed, frame) = match threads {
            1 => (held + work.max(reading - coded), coded),
            _ => (held + (work + coded).saturating_sub(reading), reading),
        };
        let least = fixed.saturating_add(frame);
        let keep = settings.memory.bytes.map_or(KEEP_BYTES, |bytes| KEEP_BYTES.min(bytes.saturating_sub(least) / 2));
        GroupNeed {
            tables,
            reading,
            keep,
            units_at_once,
            fixed: fixed + if group.kind == StreamKind::Depth { keep } else { 0 },
            frame,
            usual_frames: (BATCH_PIXELS / (pixels as usize).max(1)).clamp(1, BATCH_FRAMES),
            instead: smaller_setting(group.kind, settings),
        }
    }

    /// Bytes for batches of one frame.
    pub fn min_bytes(&self) -> u64 {
        self.need("").bytes(1)
    }

    /// Number of frames that are read and coded as one batch. Fails if one frame does not fit; `what` names the work.
    pub fn batch_frames(&self, memory: Budget, what: &str) -> Result<usize> {
        memory.at_once(&self.need(what), self.usual_frames)
    }

    /// Number of frames, at most `most`, that a scan reads at the same time.
    pub fn scanned_at_once(&self, memory: Budget, most: usize) -> Result<usize> {
        let fixed = self.tables + self.keep;
        memory.at_once(&Need { what: "scanning", fixed, each: self.reading, instead: "" }, most)
    }

    fn need<'a>(&self, what: &'a str) -> Need<'a> {
        Need { what, fixed: self.fixed, each: self.frame, instead: self.instead }
    }
}

/// Advice on a setting that needs less memory if it is smaller; empty if there is none.
fn smaller_setting(kind: StreamKind, settings: &EncodeSettings) -> &'static str {
    match (kind, settings.color_codec) {
        (StreamKind::Color, ColorCodec::Transform) if settings.color_chunk > 1 => "a smaller `color_chunk`",
        (StreamKind::Color, ColorCodec::Cells) if settings.search.lookahead > 1 => "a smaller `lookahead`",
        (StreamKind::Depth | StreamKind::Material | StreamKind::Alpha, _)
            if settings.temporal.keyframe_interval > 1 =>
        {
            "a smaller `keyframe_interval`"
        }
        _ => "",
    }
}

/// State of keyframe-and-weight cells: pending pictures and open chunks.
fn color_state(group: &SourceGroup, settings: &EncodeSettings) -> State {
    let header = CodecHeader::Color(settings.color_header());
    let units = unit_count(group, settings);
    let memory = ColorMemory::new(group, settings);
    let picture = group_pixels(group) * header.raw_pixel_bytes();
    let frames = group.frames.count();
    // Includes the keyframe before the pending pictures; with blocks, also its stored and its decoded form.
    let in_blocks = if settings.color_blocks.is_some() { 2 } else { 0 };
    let pending = picture * ((u64::from(memory.search.lookahead) + 2).min(frames) + in_blocks);
    // A chunk exceeds its limit by at most one keyframe.
    let open = (units * memory.close_at_bytes as u64 + picture).min(frames * picture);
    // A frame is either pending or in a chunk; the last keyframe is both.
    let held = (pending + open).min(picture * (frames + 1 + in_blocks));
    let cell = picture.div_ceil(units.max(1));
    State { held, unit: cell + compressing_bytes(settings.compression, open.div_ceil(units.max(1))) }
}

/// State of transform cells: the frames of a chunk, and the working memory of the search for one cell.
fn transform_state(group: &SourceGroup, settings: &EncodeSettings) -> State {
    let header = CodecHeader::Color(settings.color_header());
    let frames = u64::from(settings.color_chunk).min(group.frames.count());
    let cell = settings.unit_size(group.kind, [group.width, group.height]);
    let size = [cell[0].min(group.width) as usize, cell[1].min(group.height) as usize];
    let held = frames * group_pixels(group) * header.raw_pixel_bytes();
    let chunk = frames * size[0] as u64 * size[1] as u64 * header.raw_pixel_bytes();
    let search = frames * padded_pixels(size) * SEARCH_BYTES;
    State { held, unit: search + compressing_bytes(settings.compression, chunk) }
}

/// State of tiles of depth, material or alpha: pictures and open chunks, assuming that every frame may change every pixel.
fn tile_state(group: &SourceGroup, settings: &EncodeSettings) -> State {
    let (pixels, units) = (group_pixels(group), unit_count(group, settings));
    let frames = u64::from(settings.temporal.keyframe_interval).min(group.frames.count());
    let codec = match group.kind {
        StreamKind::Alpha => DepthCodec::Predictive,
        _ => settings.depth.codec,
    };
    // Bytes per pixel held by decoders and encoder state; half bytes per pixel that a frame adds to a chunk, including rows and
    // positions; and bytes per pixel of working memory of a thread.
    let (held, frame_halves, work) = match (group.kind, codec) {
        // The picture, the age of its pixels and the changes.
        (StreamKind::Material, _) => (5, 7, 6),
        // Reference pixels, their corrections, blocks, and logarithms per pixel of a cube face.
        (_, DepthCodec::Predictive) => (
            16 + 4 + 1 + if group.faces == [Face::View] { 0 } else { 2 },
            2 * PREDICTIVE_FRAME_BYTES,
            PREDICTIVE_WORK_BYTES,
        ),
        (_, DepthCodec::Blocks) => (0, 1, 4),
        // The picture, leaves, and recently sent nodes.
        (_, DepthCodec::Tree) => (3, 8, TILE_WORK_BYTES),
        (_, DepthCodec::Quadtree) => (6, 5, TILE_WORK_BYTES),
        _ => (4, 5, 6),
    };
    let unit_pixels = pixels.div_ceil(units.max(1));
    let frame = unit_pixels * frame_halves / 2;
    // All frames of BC4w blocks have the same size, so chunks are not closed early.
    let is_constant = group.kind == StreamKind::Depth && codec == DepthCodec::Blocks;
    let most = if is_constant { u64::MAX } else { close_at_bytes(unit_pixels as usize) as u64 + frame };
    let open = (frames * frame).min(most);
    let finishing =
        if codec == DepthCodec::Predictive && group.kind != StreamKind::Material { PREDICTIVE_FINISHING } else { 0 };
    let unit = unit_pixels * work + finishing * open + compressing_bytes(settings.compression, open);
    State { held: pixels * held + units * open, unit }
}

fn group_pixels(group: &SourceGroup) -> u64 {
    u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64
}

fn unit_count(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let [width, height] = settings.unit_size(group.kind, [group.width, group.height]);
    let of = |side: u32, unit: u32| u64::from(side.div_ceil(unit.max(1)));
    of(group.width, width) * of(group.height, height) * group.faces.len() as u64
}
