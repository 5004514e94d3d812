//! Encoder settings from keyword arguments, named like the options of `lightfold encode`.

use library::{
    ColorBlockSettings, ColorBlocks, ColorCodec, ColorFormat, Compression, Decide, DepthCodec, DomainKind, Effort,
    EncodeSettings, ErrorBound, InvalidDepth, Target, TileSize, Transfer,
};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::refuse;

/// Default error bounds of depth and of material in texture blocks, which are rarely lossless.
const USUAL_BLOCK_ERROR: (u16, u16) = (100, 8);

/// Keyword arguments of a call.
pub struct Given<'a, 'py> {
    arguments: Option<&'a Bound<'py, PyDict>>,
    /// Names that have been looked up.
    known: Vec<&'static str>,
}

impl<'a, 'py> Given<'a, 'py> {
    pub fn new(arguments: Option<&'a Bound<'py, PyDict>>) -> Given<'a, 'py> {
        Given { arguments, known: Vec::new() }
    }

    /// Returns the value of an argument; `None` if it is absent or Python's `None`.
    pub fn take<T: FromPyObjectOwned<'py>>(&mut self, name: &'static str) -> PyResult<Option<T>> {
        self.known.push(name);
        let Some(arguments) = self.arguments else { return Ok(None) };
        let Some(value) = arguments.get_item(name)?.filter(|value| !value.is_none()) else { return Ok(None) };
        value.extract().map(Some).or_else(|error: T::Error| {
            let error: PyErr = error.into();
            let message = format!("`{name}` {}: {}", value.repr()?, error.value(arguments.py()));
            if error.is_instance_of::<PyTypeError>(arguments.py()) {
                return Err(PyTypeError::new_err(message));
            }
            refuse(message)
        })
    }

    /// Returns the value of an argument that must be one of several words.
    fn word<T: Copy>(&mut self, name: &'static str, words: &[(&str, T)]) -> PyResult<Option<T>> {
        let Some(word) = self.take::<String>(name)? else { return Ok(None) };
        match words.iter().find(|(known, _)| *known == word) {
            Some((_, value)) => Ok(Some(*value)),
            None => {
                let words: Vec<_> = words.iter().map(|(known, _)| *known).collect();
                refuse(format!("`{name}` \"{word}\": one of {} was expected", words.join(", ")))
            }
        }
    }

    /// Fails if there is an argument that was not looked up.
    pub fn finish(self) -> PyResult<()> {
        for name in self.arguments.iter().flat_map(|arguments| arguments.keys()) {
            let name: String = name.extract()?;
            if !self.known.contains(&name.as_str()) {
                let known = self.known.join(", ");
                return Err(PyTypeError::new_err(format!("encode() has no argument '{name}'; it has {known}")));
            }
        }
        Ok(())
    }
}

pub fn settings(given: &mut Given<'_, '_>) -> PyResult<EncodeSettings> {
    let mut settings = EncodeSettings::default();
    set_depth(given, &mut settings)?;
    set_depth_in_time(given, &mut settings)?;
    set_color(given, &mut settings)?;
    set_color_format(given, &mut settings)?;
    let in_blocks = given.word("material_block", &[("none", false), ("bc1", true)])?.unwrap_or(false);
    let usual = if in_blocks { USUAL_BLOCK_ERROR.1 } else { 0 };
    settings.material.in_blocks = in_blocks;
    settings.material.epsilon = given.take::<u8>("material_error")?.map_or(usual, u16::from);
    let efforts = [("fast", Effort::Fast), ("normal", Effort::Normal), ("exhaustive", Effort::Exhaustive)];
    if let Some(effort) = given.word("effort", &efforts)? {
        (settings.search.effort, settings.depth.effort) = (effort, effort);
    }
    set_compression(given, &mut settings)?;
    settings.memory.bytes = given.take("memory")?;
    Ok(settings)
}

fn set_depth(given: &mut Given<'_, '_>, settings: &mut EncodeSettings) -> PyResult<()> {
    let depth = &mut settings.depth;
    let codecs = [
        ("predictive", DepthCodec::Predictive),
        ("quadtree", DepthCodec::Quadtree),
        ("aabb", DepthCodec::Boxes),
        ("bc4w", DepthCodec::Blocks),
    ];
    let codec = given.word("depth_codec", &codecs)?.unwrap_or_default();
    let in_blocks = given.word("depth_block", &[("none", false), ("bc5", true)])?.unwrap_or(false);
    depth.codec = match (codec, in_blocks) {
        (codec, false) => codec,
        (DepthCodec::Boxes, true) => DepthCodec::BoxesInBlocks,
        (_, true) => return refuse("`depth_block` bc5 needs `depth_codec` aabb"),
    };
    let codes = given.take("max_error")?.map(ErrorBound::Codes);
    let share = given.take("max_error_relative")?.map(ErrorBound::Relative);
    let error = match (codes, share) {
        (Some(_), Some(_)) => return refuse("give one of `max_error` and `max_error_relative`"),
        (codes, share) => codes.or(share),
    };
    match (error, codec) {
        (Some(ErrorBound::Relative(share)), _) if !(0.0..=1.0).contains(&share) => {
            return refuse(format!("`max_error_relative` {share}: 0 to 1 was expected"));
        }
        (Some(ErrorBound::Codes(u16::MAX)), _) => return refuse("`max_error` 65535: 0 to 65534 was expected"),
        (Some(_), DepthCodec::Boxes) => {
            return refuse(
                "`max_error` bounds functions and predictions: with `depth_codec` aabb use `update_threshold`",
            );
        }
        (Some(_), DepthCodec::Blocks) => {
            return refuse("`depth_codec` bc4w has no error bound: leave out `max_error`, or use quadtree");
        }
        (error, _) => depth.error = error.unwrap_or(depth.error),
    }
    let domains = DomainKind::ALL.map(|kind| (kind.name(), kind));
    depth.domain = given.word("depth_domain", &domains)?.unwrap_or(depth.domain);
    depth.decide = given.word("optimize", &[("quality", Decide::Mse), ("size", Decide::Size)])?.unwrap_or(depth.decide);
    depth.min_children = given.take("min_children")?.unwrap_or(depth.min_children);
    settings.near_m = given.take("near")?;
    settings.far_m = given.take("far")?;
    let outside = [("refuse", InvalidDepth::Refuse), ("far", InvalidDepth::Far), ("near", InvalidDepth::Near)];
    settings.outside_depth = given.word("invalid_depth", &outside)?.unwrap_or_default();
    Ok(())
}

fn set_depth_in_time(given: &mut Given<'_, '_>, settings: &mut EncodeSettings) -> PyResult<()> {
    let temporal = &mut settings.temporal;
    temporal.window = given.take("depth_window")?.unwrap_or(temporal.window);
    let usual = if settings.depth.codec == DepthCodec::BoxesInBlocks { USUAL_BLOCK_ERROR.0 } else { temporal.epsilon };
    temporal.epsilon = given.take("update_threshold")?.unwrap_or(usual);
    temporal.max_aabbs = given.take("max_aabbs")?.unwrap_or(temporal.max_aabbs);
    temporal.keyframe_interval = given.take("keyframe_interval")?.unwrap_or(temporal.keyframe_interval);
    settings.tiles = given.take("depth_tile")?.map_or(settings.tiles, TileSize::Pixels);
    Ok(())
}

fn set_color(given: &mut Given<'_, '_>, settings: &mut EncodeSettings) -> PyResult<()> {
    settings.cell = given.take("color_cell")?.unwrap_or(settings.cell);
    let blocks = [
        ("none", None),
        ("bc1", Some(ColorBlocks::Bc1)),
        ("bc7", Some(ColorBlocks::Bc7)),
        ("bc6h", Some(ColorBlocks::Bc6h)),
    ];
    let blocks = given.word("color_block", &blocks)?.flatten();
    let usual = if blocks.is_some() { ColorCodec::Cells } else { ColorCodec::default() };
    let codecs = [("transform", ColorCodec::Transform), ("cells", ColorCodec::Cells)];
    let codec = given.word("color_codec", &codecs)?.unwrap_or(usual);
    let chunk = given.take("color_chunk")?;
    let [quality, psnr] = [given.take::<f64>("quality")?, given.take::<f64>("psnr")?];
    let step = given.take::<u8>("color_qp")?;
    let of_blocks = given.take::<f64>("psnr_final")?;
    if codec != ColorCodec::Transform && (quality.is_some() || step.is_some() || chunk.is_some()) {
        return refuse("`quality`, `color_qp` and `color_chunk` need `color_codec` transform");
    }
    if blocks.is_none() && of_blocks.is_some() {
        return refuse("`psnr_final` needs `color_block`");
    }
    let of_blocks = blocks.map(|blocks| (blocks, of_blocks));
    let reached = |(blocks, db): (ColorBlocks, Option<f64>)| db.unwrap_or(ColorBlockSettings::usual_psnr_db(blocks));
    let target = match (quality, psnr, step) {
        (Some(quality), None, None) => Target::Quality(quality),
        (None, Some(db), None) => Target::Psnr(db),
        (None, None, Some(step)) => Target::Step(step),
        (None, None, None) => of_blocks.map(reached).map_or(codec.usual_target(), Target::Psnr),
        _ => return refuse("give one of `quality`, `psnr` and `color_qp`"),
    };
    settings.color_codec = codec;
    settings.color_chunk = chunk.unwrap_or(settings.color_chunk);
    settings.search.target = target;
    settings.search.lookahead = given.take("lookahead")?.unwrap_or(settings.search.lookahead);
    settings.color_blocks = of_blocks.map(|(blocks, db)| {
        let usual = ColorBlockSettings::new(blocks, &settings.search);
        ColorBlockSettings { final_psnr_db: db.unwrap_or(usual.final_psnr_db), ..usual }
    });
    Ok(())
}

fn set_color_format(given: &mut Given<'_, '_>, settings: &mut EncodeSettings) -> PyResult<()> {
    let is_half = given.take("hdr")?.unwrap_or(false);
    let transfer = given.word("transfer", &[("srgb", Transfer::Srgb), ("linear", Transfer::Linear)])?;
    let (exposure_ev, white_cd_m2) = (given.take("exposure")?, given.take("white")?);
    match (is_half, &mut settings.color) {
        (true, _) if transfer.is_some() || exposure_ev.is_some() => {
            return refuse("`transfer` and `exposure` are of 8 bits: leave them out with `hdr`");
        }
        (false, _) if white_cd_m2.is_some() => return refuse("`white` needs `hdr`"),
        (true, color) => {
            *color = white_cd_m2.map_or(ColorFormat::HALF, |white_cd_m2| ColorFormat::Half { white_cd_m2 })
        }
        (false, ColorFormat::EightBit(tone)) => {
            tone.transfer = transfer.unwrap_or(tone.transfer);
            tone.exposure_ev = exposure_ev.unwrap_or(tone.exposure_ev);
        }
        (false, ColorFormat::Half { .. }) => {}
    }
    Ok(())
}

fn set_compression(given: &mut Given<'_, '_>, settings: &mut EncodeSettings) -> PyResult<()> {
    let (lzma2, zstd) = (given.take::<u32>("lzma2")?, given.take::<u32>("zstd")?);
    let none = given.take("no_compression")?.unwrap_or(false);
    settings.compression = match (lzma2, zstd, none) {
        (None, None, false) => settings.compression,
        (None, None, true) => Compression::None,
        (Some(level), None, false) if level <= 9 => Compression::Lzma2(level),
        (None, Some(level), false) if (1..=19).contains(&level) => Compression::Zstd(level),
        (Some(level), None, false) => return refuse(format!("`lzma2` {level}: 0 to 9 was expected")),
        (None, Some(level), false) => return refuse(format!("`zstd` {level}: 1 to 19 was expected")),
        _ => return refuse("give one of `lzma2`, `zstd` and `no_compression`"),
    };
    Ok(())
}
