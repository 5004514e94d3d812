//! Display options: exposure, tone map and lookup table of 8-bit pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::value::{Choices, one_of, parse_number_where};
use crate::look::{Look, TableInput, TableLook};
use crate::refuse;
use codec::error::Result;
use codec::image::{Display, ToneCurve, ToneMap};
use footage::export::FileFormat;
use footage::image_files::lookup_table::read_cube;

/// The tone maps of the player (`viewer/src/views/presentation.ts`).
const TONE_MAPS: &Choices<ToneCurve> = &[
    ("none", ToneCurve::None, "Clip light above 1"),
    ("reinhard", ToneCurve::Reinhard, "x / (1 + x)"),
    ("filmic", ToneCurve::Filmic, "A rational curve with a toe and a shoulder"),
];

/// Maximum exposure in stops, in both directions, as in the player.
const MAX_STOPS: f64 = 10.0;

const TABLE_INPUTS: &Choices<TableInput> = &[
    ("linear", TableInput::Linear, "Linear light with the primaries of the container"),
    ("acescct", TableInput::AcesCct, "ACEScct codes with AP1 primaries"),
];

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Display")]
pub struct DisplayArgs {
    /// Exposure of 8-bit pictures in stops, -10 to 10, as in the player: 2 makes dark footage 4 times as bright [default:
    /// 0 with --tone-map, else that of the container]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: Option<f64>,
    /// Tone map of 8-bit pictures after the exposure, as in the player [default: none]
    #[arg(long, value_name = "NAME", value_parser = one_of(TONE_MAPS))]
    pub tone_map: Option<ToneCurve>,
    /// Lookup table of 8-bit pictures, applied after the exposure, instead of tone map and transfer function; values
    /// outside its range are clamped, interpolation is tetrahedral
    #[arg(long, value_name = "FILE.cube", conflicts_with = "tone_map")]
    pub lut: Option<PathBuf>,
    /// Values that the lookup table takes
    #[arg(long, value_name = "SPACE", value_parser = one_of(TABLE_INPUTS), default_value = "linear", requires = "lut")]
    pub lut_input: TableInput,
}

fn parse_stops(text: &str) -> std::result::Result<f64, String> {
    parse_number_where(text, |stops| stops.abs() <= MAX_STOPS, "-10 to 10 stops were expected")
}

impl DisplayArgs {
    fn is_given(&self) -> bool {
        self.exposure.is_some() || self.tone_map.is_some() || self.lut.is_some()
    }

    /// Returns the look that the options select: a table, or a display with the transfer function of sRGB; else `usual`.
    pub fn look(&self, usual: ToneMap) -> Result<Look> {
        if !self.is_given() {
            return Ok(usual.into());
        }
        let exposure_ev = self.exposure.unwrap_or(0.0) as f32;
        let tone = ToneMap { exposure_ev, ..ToneMap::default() };
        Ok(match &self.lut {
            Some(path) => {
                let table = read_cube(path)?;
                Look::Table(Arc::new(TableLook { table, input: self.lut_input, gain: tone.gain() }))
            }
            None => Look::Display(Display { tone, curve: self.tone_map.unwrap_or_default() }),
        })
    }

    /// Fails if the options apply to none of the outputs, or if one of these is an EXR image.
    pub fn check(&self, pictures: Option<&Path>, contact_sheet: Option<&Path>) -> Result<()> {
        if !self.is_given() {
            return Ok(());
        }
        if pictures.is_some_and(|path| FileFormat::of(path) == Some(FileFormat::Exr)) {
            return refuse(
                "EXR images store linear light of the scene: leave out --exposure, --tone-map and --lut, or write PNG images",
            );
        }
        match pictures.or(contact_sheet) {
            Some(_) => Ok(()),
            None => refuse("--exposure, --tone-map and --lut apply to 8-bit pictures: add -o or --contact-sheet"),
        }
    }
}
