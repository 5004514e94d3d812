//! Settings of an encode.

use crate::dataset::manifest::Keep;
use crate::dataset::{InvalidDepth, Source};
use codec::block::SIDE;
use codec::color::quality::MAX_QUALITY;
use codec::color::transform::blocks::MAX_FRAMES;
use codec::color::transform::encode::COARSEST;
use codec::color::transform::{TableSet, Tables};
use codec::color::{SearchSettings, Target};
use codec::container::Compression;
use codec::container::index::MAX_SIZE;
use codec::depth::block::MAX_TILE;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::predictive::projection::{Projection, Shape};
use codec::depth::predictive::{self, Levels, PredictiveHeader};
use codec::depth::quantise::{FAR_CODE, rounded_up};
use codec::depth::{DepthRange, TemporalSettings};
use codec::effort::Effort;
use codec::entropy::tables::MAX_OWN;
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::image::transfer::ToneMap;
use codec::memory::Budget;
use codec::metrics::DEFAULT_WHITE_CD_M2;
use codec::streams::{
    AlphaHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader, DepthCoding, MaterialHeader, NodeHeader,
};

/// Alignment in pixels of the sides of tiles, so that tiles can be halved down to blocks.
const TILE_ALIGN: u32 = 8;
/// Default side in pixels of the tiles of predictive depth.
const PREDICTIVE_TILE: u32 = 128;

/// Segment length of the transform codec in chunks; its search restarts at each segment.
const SEGMENT_CHUNKS: u32 = 4;
/// Segment length of keyframe-and-weight cells in frames. Each segment costs one more keyframe.
const CELL_SEGMENT_FRAMES: u32 = 96;

/// Depth codecs (depth.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DepthCodec {
    /// Packed nodes of a quadtree.
    Quadtree,
    /// The unpacked quadtree, which `pack` converts to packed nodes at any bound.
    Tree,
    /// Codes, updated in boxes around changed pixels.
    Boxes,
    /// As `Boxes`, with tiles of BC5 blocks wherever these stay within epsilon.
    BoxesInBlocks,
    /// BC4w blocks, without an error bound.
    Blocks,
    /// Predicted codes with residuals; the smallest output.
    #[default]
    Predictive,
}

/// Maximum error of a decoded depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ErrorBound {
    /// Number of log codes.
    Codes(u16),
    /// Fraction of the distance: 0.001 is 0.1%.
    Relative(f64),
}

/// Spatial coding of depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthSettings {
    pub codec: DepthCodec,
    /// Maximum error of a decoded depth, for the quadtree, tree and predictive codecs.
    pub error: ErrorBound,
    /// Quantity to which modelling functions are fitted.
    pub domain: DomainKind,
    /// Criterion for choosing among candidates within the bound: squared error or size.
    pub decide: Decide,
    /// Search effort of depth encoders, and of BC1 blocks of material.
    pub effort: Effort,
    /// Number of children of a node that must have changed before a function is tried for the whole node, 1 to 4.
    pub min_children: u8,
}

impl Default for DepthSettings {
    fn default() -> Self {
        let NodeSettings { bound, decide, effort, min_children, .. } = NodeSettings::default();
        DepthSettings {
            codec: DepthCodec::default(),
            error: ErrorBound::Codes(bound),
            domain: DomainKind::default(),
            decide,
            effort,
            min_children,
        }
    }
}

/// Colour codecs (color.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorCodec {
    /// A transform in space and time.
    #[default]
    Transform,
    /// Keyframes and weights.
    Cells,
}

impl ColorCodec {
    /// Default quality target for every frame of every cell.
    pub fn usual_target(self) -> Target {
        match self {
            ColorCodec::Transform => Target::Quality(79.0),
            ColorCodec::Cells => Target::Psnr(50.0),
        }
    }
}

/// Storage of colour keyframes as texture blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorBlockSettings {
    /// Block format: BC1 or BC7 for 8 bits, BC6H for half floats.
    pub blocks: ColorBlocks,
    /// Minimum PSNR in dB of every frame of every cell after block compression; at most the target of the search.
    pub final_psnr_db: f64,
}

impl ColorBlockSettings {
    /// Creates settings with the default PSNR of the format, or the search's target if that is lower.
    pub fn new(blocks: ColorBlocks, search: &SearchSettings) -> ColorBlockSettings {
        ColorBlockSettings { blocks, final_psnr_db: Self::usual_psnr_db(blocks).min(search.target.min_psnr_db()) }
    }

    /// Default minimum PSNR in dB of a format, which it reaches on most footage.
    pub fn usual_psnr_db(blocks: ColorBlocks) -> f64 {
        match blocks {
            ColorBlocks::Bc1 => 30.0,
            ColorBlocks::Bc7 | ColorBlocks::Bc6h => 40.0,
        }
    }
}

/// Coding of material streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MaterialSettings {
    /// Maximum difference of each of the three bytes from the source.
    pub epsilon: u16,
    /// True to use tiles of BC1 blocks wherever these stay within epsilon.
    pub in_blocks: bool,
}

impl ErrorBound {
    /// Returns the bound in codes for a range; a relative bound becomes the largest number of codes within it.
    ///
    /// # Errors
    /// [`Error::Usage`] for a relative bound that rounding to codes alone exceeds; a relative bound of 0 is 0 codes.
    pub fn codes(self, range: DepthRange) -> Result<u16> {
        match self {
            ErrorBound::Codes(codes) => Ok(codes),
            ErrorBound::Relative(0.0) => Ok(0),
            ErrorBound::Relative(share) => range.codes_within(share).ok_or_else(|| {
                Error::Usage(format!(
                    "`max_error` {}%: 16-bit codes for {range} are accurate to {}% of the distance at best: increase \
                    `max_error`, or set `near` and `far` closer together",
                    rounded_up(100.0 * share),
                    rounded_up(100.0 * range.relative_error(0)),
                ))
            }),
        }
    }
}

/// Side of the square tiles of depth and material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileSize {
    /// Maximum number of tiles along each side of a face.
    PerSide(u32),
    /// Side in pixels, rounded up to a multiple of 8.
    Pixels(u32),
    /// Default of the codec: 128 pixels for predictive depth, half of the face for all others.
    Usual,
}

impl TileSize {
    /// Returns the side in pixels of tiles on a face of `face_side` pixels; `most` is the limit of the codec.
    fn side(self, face_side: u32, most: u32) -> u32 {
        let side = match self {
            TileSize::PerSide(tiles) => face_side.div_ceil(tiles.max(face_side.div_ceil(most))),
            TileSize::Pixels(side) => side.min(face_side).min(most),
            TileSize::Usual => return TileSize::PerSide(2).side(face_side, most),
        };
        side.next_multiple_of(TILE_ALIGN)
    }
}

/// Treatment of colour that would be clipped to 8 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clipping {
    /// [`crate::encode::FirstFrames::check`] fails if the first frame of a stream has clipped pixels.
    Refuse,
    /// Clipped pixels are counted, and the container stores their number.
    #[default]
    Allow,
}

/// Settings of an encode. The defaults are those of `lightfold encode`.
#[derive(Debug, Clone)]
pub struct EncodeSettings {
    /// Temporal coding of depth and material; material has its own epsilon.
    pub temporal: TemporalSettings,
    pub material: MaterialSettings,
    /// Spatial coding of depth.
    pub depth: DepthSettings,
    /// Tile size of depth and material.
    pub tiles: TileSize,
    /// Distance of the nearest surface in metres; `None` finds it in the images.
    pub near_m: Option<f32>,
    /// Distance of the farthest surface in metres; `None` finds it in the images.
    pub far_m: Option<f32>,
    /// Treatment of depth outside `near_m` and `far_m`, or outside the range that the source states.
    pub outside_depth: InvalidDepth,
    /// Width and height of colour cells in pixels.
    pub cell: u32,
    /// Colour samples: 8 bits or half floats.
    pub color: ColorFormat,
    /// Treatment of clipped pixels of 8-bit colour.
    pub clipping: Clipping,
    pub color_codec: ColorCodec,
    /// Number of frames in a chunk of the transform codec, 1 to 96.
    pub color_chunk: u32,
    /// Entropy tables of the transform codec in addition to the built-in ones, stored in each colour stream.
    pub color_tables: Option<TableSet>,
    /// Entropy tables of predictive depth in addition to the built-in ones, at most eight sets, stored in each depth stream.
    pub depth_tables: Vec<predictive::TableSet>,
    /// Quality target of colour and search effort.
    pub search: SearchSettings,
    /// Storage of keyframes of [`ColorCodec::Cells`] as texture blocks; `None` stores samples.
    pub color_blocks: Option<ColorBlockSettings>,
    /// Compression of chunks; used only for chunks that it makes smaller.
    pub compression: Compression,
    /// Kinds of streams to encode.
    pub kinds: Vec<StreamKind>,
    /// Memory limit for frames and encoders; the output does not depend on it.
    pub memory: Budget,
}

impl Default for EncodeSettings {
    fn default() -> Self {
        EncodeSettings {
            temporal: TemporalSettings::default(),
            material: MaterialSettings::default(),
            depth: DepthSettings::default(),
            tiles: TileSize::Usual,
            near_m: None,
            far_m: None,
            outside_depth: InvalidDepth::default(),
            cell: 64,
            color: ColorFormat::EightBit(ToneMap::default()),
            clipping: Clipping::default(),
            color_codec: ColorCodec::default(),
            color_chunk: 24,
            color_tables: None,
            depth_tables: Vec::new(),
            search: SearchSettings { target: ColorCodec::default().usual_target(), ..SearchSettings::default() },
            color_blocks: None,
            compression: Compression::default(),
            kinds: StreamKind::ALL.to_vec(),
            memory: Budget::UNLIMITED,
        }
    }
}

impl EncodeSettings {
    /// Selects half floats or clipping as a manifest states (`color.keep`), if nothing else selects one of them. Returns its
    /// selection.
    pub fn keep_colors_of(&mut self, source: &Source) -> Option<Keep> {
        let color = source.manifest.as_ref().and_then(|manifest| manifest.color.as_ref());
        let is_8_bit_block = self.color_blocks.is_some_and(|blocks| blocks.blocks != ColorBlocks::Bc6h);
        let is_open =
            self.clipping == Clipping::Refuse && matches!(self.color, ColorFormat::EightBit(_)) && !is_8_bit_block;
        let keep = color.and_then(|color| color.keep).filter(|_| is_open);
        match keep {
            Some(Keep::Hdr) => self.color = ColorFormat::Half { white_cd_m2: DEFAULT_WHITE_CD_M2 },
            Some(Keep::Clip) => self.clipping = Clipping::Allow,
            None => {}
        }
        keep
    }

    pub(super) fn check(&self) -> Result<()> {
        self.temporal.check()?;
        self.nodes(0).check()?;
        self.check_ranges()?;
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        let no_tiles = matches!(self.tiles, TileSize::PerSide(0) | TileSize::Pixels(0));
        if no_tiles || self.cell == 0 || self.search.lookahead == 0 {
            return wrong("tiles, cell size and lookahead must be at least 1");
        }
        if !(1..=MAX_FRAMES).contains(&self.color_chunk) {
            return wrong(&format!("colour chunks of {} frames: 1 to {MAX_FRAMES} were expected", self.color_chunk));
        }
        if self.color_tables.is_some() && self.color_codec != ColorCodec::Transform {
            return wrong("`color_tables` needs `color_codec` transform");
        }
        if !self.depth_tables.is_empty() && self.depth.codec != DepthCodec::Predictive {
            return wrong("`depth_tables` needs `depth_codec` predictive");
        }
        if self.depth_tables.len() > MAX_OWN {
            return wrong(&format!("`depth_tables`: at most {MAX_OWN} table sets are possible"));
        }
        if self.color_codec == ColorCodec::Cells && !matches!(self.search.target, Target::Psnr(_)) {
            return wrong("`quality` and `color_qp` need `color_codec` transform: with cells use `psnr`");
        }
        self.color_blocks.map_or(Ok(()), |blocks| self.check_color_blocks(blocks))
    }

    fn check_color_blocks(&self, ColorBlockSettings { blocks, final_psnr_db }: ColorBlockSettings) -> Result<()> {
        let searched_db = self.search.target.min_psnr_db();
        let message = if self.color_codec == ColorCodec::Transform {
            "`color_block` needs `color_codec` cells: use cells, or leave out `color_block`".into()
        } else if (blocks == ColorBlocks::Bc6h) != matches!(self.color, ColorFormat::Half { .. }) {
            "BC1 and BC7 store 8 bits, BC6H stores half floats: use bc6h with `hdr`, bc1 or bc7 without or with `clip`"
                .into()
        } else if !self.cell.is_multiple_of(SIDE as u32) {
            format!("cells of {} pixels: blocks of 4x4 pixels need a multiple of 4", self.cell)
        } else if final_psnr_db > searched_db {
            format!(
                "`psnr_final` {final_psnr_db} dB exceeds `psnr` {searched_db} dB, but blocks only lose quality: \
                reduce `psnr_final`"
            )
        } else {
            return Ok(());
        };
        Err(Error::Usage(message))
    }

    /// Fails if a value is outside the range that the codecs accept.
    fn check_ranges(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::Usage(message));
        let target = self.search.target;
        let of_blocks = self.color_blocks.map(|blocks| blocks.final_psnr_db);
        for (name, db) in [("`psnr_final`", of_blocks), ("`psnr`", Some(target.min_psnr_db()))] {
            if let Some(db) = db.filter(|db| !(0.0..=200.0).contains(db)) {
                return wrong(format!("{name} {db}: 0 to 200 dB was expected"));
            }
        }
        match target {
            Target::Step(step) if i32::from(step) > COARSEST => {
                return wrong(format!("`color_qp` {step}: 0 to {COARSEST} was expected"));
            }
            Target::Quality(quality) if !(0.0..=MAX_QUALITY).contains(&quality) => {
                return wrong(format!("`quality` {quality}: 0 to {MAX_QUALITY} was expected"));
            }
            _ => {}
        }
        // Check each alone, and both together.
        if let (Some(near_m), Some(far_m)) = (self.near_m.or(self.far_m), self.far_m.or(self.near_m)) {
            DepthRange::new(near_m, far_m).map_err(|error| Error::Usage(format!("`near` and `far`: {error}")))?;
        }
        match self.color {
            ColorFormat::EightBit(ToneMap { exposure_ev, .. }) if !(-8.0..=8.0).contains(&exposure_ev) => {
                wrong(format!("`exposure` {exposure_ev}: -8 to 8 stops were expected"))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn color_header(&self) -> ColorHeader {
        let target = self.search.target;
        let min_psnr_db = self.color_blocks.map_or(target.min_psnr_db(), |blocks| blocks.final_psnr_db);
        let coding = match self.color_codec {
            ColorCodec::Cells => ColorCoding::Cells(self.color_blocks.map(|settings| settings.blocks)),
            ColorCodec::Transform => ColorCoding::Transform(self.tables()),
        };
        ColorHeader { format: self.color, coding, min_psnr_db, min_quality: target.min_quality() }
    }

    pub(super) fn tables(&self) -> Tables {
        match &self.color_tables {
            Some(set) => Tables::with_own(vec![set.clone()]),
            None => Tables::default(),
        }
    }

    pub(super) fn material_header(&self) -> MaterialHeader {
        let MaterialSettings { epsilon, in_blocks } = self.material;
        MaterialHeader { temporal: TemporalSettings { epsilon, ..self.temporal }, in_blocks }
    }

    pub(super) fn alpha_header(&self) -> AlphaHeader {
        AlphaHeader { keyframe_interval: self.temporal.keyframe_interval }
    }

    /// Returns true if the bytes depend on the instruction sets of the processor, as those of texture block encoders do.
    pub fn depends_on_processor(&self) -> bool {
        self.color_blocks.is_some() || self.material.in_blocks || self.depth.codec == DepthCodec::BoxesInBlocks
    }

    /// Number of frames after which all encoders of a kind restart, counted from the first frame of a stream. No chunk crosses
    /// such a frame, and nothing before it affects the frames after it. Shards start at these frames.
    pub(super) fn segment_frames(&self, kind: StreamKind) -> u32 {
        match (kind, self.color_codec) {
            (StreamKind::Depth | StreamKind::Material | StreamKind::Alpha, _) => self.temporal.keyframe_interval,
            (StreamKind::Color, ColorCodec::Transform) => SEGMENT_CHUNKS * self.color_chunk,
            (StreamKind::Color, ColorCodec::Cells) => CELL_SEGMENT_FRAMES,
        }
    }

    pub(super) fn unit_size(&self, kind: StreamKind, size: [u32; 2]) -> [u32; 2] {
        let boxes = matches!(self.depth.codec, DepthCodec::Boxes | DepthCodec::BoxesInBlocks);
        size.map(|side| match kind {
            StreamKind::Color => self.cell.min(MAX_SIZE),
            StreamKind::Depth if !boxes => self.tiles_of(self.depth.codec).side(side, MAX_TILE),
            StreamKind::Alpha => self.tiles_of(DepthCodec::Predictive).side(side, MAX_TILE),
            StreamKind::Depth | StreamKind::Material => self.tiles.side(side, u32::MAX),
        })
    }

    /// Returns the requested tile size, or the default of the codec.
    fn tiles_of(&self, codec: DepthCodec) -> TileSize {
        match (self.tiles, codec) {
            (TileSize::Usual, DepthCodec::Predictive) => TileSize::Pixels(PREDICTIVE_TILE),
            (tiles, _) => tiles,
        }
    }

    pub(super) fn nodes(&self, bound: u16) -> NodeSettings {
        let TemporalSettings { window, epsilon, keyframe_interval, .. } = self.temporal;
        let DepthSettings { decide, effort, min_children, .. } = self.depth;
        NodeSettings { window, epsilon, keyframe_interval, bound, decide, effort, min_children }
    }

    /// Returns true if depth streams may have levels. Levels are exact, so they are not used with an update threshold.
    pub(super) fn finds_levels(&self) -> bool {
        self.depth.codec == DepthCodec::Predictive && self.temporal.epsilon == 0
    }

    /// Returns the depth coding. `shape` relates depth to the viewing axis; `levels` are the codes that occur, if they are few.
    pub(super) fn depth_coding(&self, range: DepthRange, shape: Shape, levels: &Levels) -> Result<DepthCoding> {
        let TemporalSettings { window, epsilon, keyframe_interval, .. } = self.temporal;
        let nodes = || {
            // Linear and inverse domains need far = 1.003 near or more; a probe with one distance, or no surface, uses log.
            let domain = Domain::new(self.depth.domain, range).or_else(|_| Domain::new(DomainKind::Log, range))?;
            let bound = self.depth.error.codes(range)?;
            Ok(NodeHeader { window, epsilon, keyframe_interval, bound, domain: domain.parts })
        };
        Ok(match self.depth.codec {
            DepthCodec::Boxes => DepthCoding::Boxes(self.temporal),
            DepthCodec::BoxesInBlocks => DepthCoding::BoxesInBlocks(self.temporal),
            DepthCodec::Quadtree => DepthCoding::Nodes(nodes()?),
            DepthCodec::Tree => DepthCoding::Tree(NodeHeader { window: 1, epsilon: 0, ..nodes()? }),
            DepthCodec::Blocks => DepthCoding::Blocks,
            DepthCodec::Predictive => {
                let tables = predictive::Tables::with_own(self.depth_tables.clone());
                let bound = self.depth.error.codes(range)?;
                let steps = (u32::from(FAR_CODE) + 1) / (2 * u32::from(bound) + 1);
                // Use levels only if they are no more than the quantisation steps at this bound. Measured: half the bytes if the
                // steps are small, 2% more at worst; levels are exact.
                let is_few = !levels.is_empty() && levels.codes().len() as u32 <= steps;
                let (bound, projection, levels) = if self.finds_levels() && is_few {
                    (0, Projection::default(), levels.clone())
                } else {
                    (bound, Projection::new(shape, range), Levels::default())
                };
                DepthCoding::Predictive(PredictiveHeader {
                    bound,
                    epsilon,
                    keyframe_interval,
                    projection,
                    tables,
                    levels,
                })
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_becomes_as_many_codes_as_keep_it() {
        for (near, far) in [(1.0, 1.5), (0.5, 37.25), (0.001, 1000.0)] {
            let range = DepthRange::new(near, far).unwrap();
            for share in [0.0, 0.0001, 0.001, 0.01, 0.5] {
                let Ok(codes) = ErrorBound::Relative(share).codes(range) else {
                    assert!(range.relative_error(0) > share, "{share} is refused");
                    continue;
                };
                assert!(share == 0.0 || range.relative_error(codes) <= share, "{share}: {codes}");
                assert!(codes == FAR_CODE || range.relative_error(codes + 1) > share, "{share}: {codes}");
            }
        }
        let single = DepthRange::new(2.0, 2.0).unwrap();
        assert_eq!(ErrorBound::Relative(0.1).codes(single).unwrap(), 0);
        assert_eq!(ErrorBound::Codes(7).codes(single).unwrap(), 7);
        // Half a quantisation step is 0.14% of the distance, more than the bound of 0.1%.
        let wide = DepthRange::new(1e-40, 1e38).unwrap();
        let refused = ErrorBound::Relative(0.001).codes(wide).unwrap_err().to_string();
        assert!(refused.contains("0.1%") && refused.contains("0.14%"), "{refused}");
        assert_eq!(ErrorBound::Relative(0.0).codes(wide).unwrap(), 0);
    }
}
