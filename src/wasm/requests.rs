//! Parts of rendering for the page's thread: units that cameras see, and texels of colour from decoded pixels.

use std::ops::Range;

use half::f16;

use crate::numbers::{Numbers, take_camera, take_rect};
use codec::container::ProbeEntry;
use codec::error::{Error, Result};
use codec::image::{Face, Transfer};
use codec::math::Viewer;
use render::views::{Rect, StraightCodes, UnitGrid, finite_half, straight_half, visible_units};

/// Returns 1 for each unit of a face that cameras see, else 0 (CALF 6.2). `numbers` has position, orientation and intrinsics of
/// the probe and the minimum distance of its surfaces in metres, then the cameras.
pub fn units_in_sight(mut numbers: Numbers<'_>, face: u32, grid: UnitGrid) -> Result<Vec<u8>> {
    let probe = ProbeEntry {
        name: String::new(),
        position: numbers.take()?,
        orientation: numbers.take()?,
        frames: [0; 2],
        intrinsics: numbers.take()?,
    };
    let [near_m] = numbers.take()?;
    let mut viewers = Vec::new();
    while !numbers.is_empty() {
        viewers.push(Viewer::new(take_camera(&mut numbers)?.sight_lines()));
    }
    let known = u8::try_from(face).ok().and_then(Face::from_index);
    let face = known.ok_or_else(|| Error::Usage(format!("there is no face {face}")))?;
    if grid.unit.contains(&0) {
        return Err(Error::Usage("units of no pixels".into()));
    }
    Ok(visible_units(&probe, near_m, face, grid, &viewers).into_iter().map(u8::from).collect())
}

/// Tables for straight colours, by the coding of colours.
#[derive(Default)]
pub struct StraightTables {
    linear: Option<StraightCodes>,
    srgb: Option<StraightCodes>,
}

impl StraightTables {
    pub const fn new() -> StraightTables {
        StraightTables { linear: None, srgb: None }
    }

    /// Returns texels of four components, bytes or bit patterns of halves: straight colours and alpha (color.md 1 and 2).
    /// `input` has the coding as of [`open_field`](crate::exports::open_field), the rectangle of the texels, and those of the
    /// units of colour and of alpha, without a width where there is no alpha; then the pixels of both.
    pub fn texels(&mut self, input: &[u8]) -> Result<Vec<u8>> {
        let mut numbers = Numbers::new(input);
        let coding = numbers.take_u32()?;
        let [rect, color, alpha] = [take_rect(&mut numbers)?, take_rect(&mut numbers)?, take_rect(&mut numbers)?];
        let pixel_bytes = if coding == 0 { 6 } else { 3 };
        let pixels = numbers.rest();
        let (colors, alphas) = pixels.split_at_checked(pixel_bytes * area(color)).ok_or_else(too_few_pixels)?;
        let alphas: Vec<u8> = match alpha[2] {
            0 => vec![255; area(rect)],
            _ => part(alphas, alpha, rect)?.into_iter().map(|[byte]| byte).collect(),
        };
        let table = match coding {
            0 => return light_texels(&part(colors, color, rect)?, &alphas),
            1 => self.linear.get_or_insert_with(|| StraightCodes::new(Transfer::Linear)),
            _ => self.srgb.get_or_insert_with(|| StraightCodes::new(Transfer::Srgb)),
        };
        let texels = part(colors, color, rect)?.into_iter().zip(alphas);
        Ok(texels.flat_map(|(color, alpha)| table.texel(color, alpha)).collect())
    }
}

fn light_texels(colors: &[[u8; 6]], alphas: &[u8]) -> Result<Vec<u8>> {
    let texels = colors.iter().zip(alphas).flat_map(|(color, &alpha)| {
        let alpha = f32::from(alpha) / 255.0;
        let light = |at: usize| straight_half(finite_half(f16::from_le_bytes([color[at], color[at + 1]])), alpha);
        [light(0), light(2), light(4), f16::from_f32(alpha)]
    });
    Ok(texels.flat_map(f16::to_le_bytes).collect())
}

fn area([_, _, width, height]: Rect) -> usize {
    width as usize * height as usize
}

/// Returns the pixels of a rectangle inside that of a unit, row by row.
fn part<const N: usize>(pixels: &[u8], unit: Rect, rect: Rect) -> Result<Vec<[u8; N]>> {
    let starts = rect[0] >= unit[0] && rect[1] >= unit[1];
    if !starts
        || [0, 1]
            .iter()
            .any(|&axis| rect[axis].saturating_add(rect[axis + 2]) > unit[axis].saturating_add(unit[axis + 2]))
    {
        return Err(Error::Usage(format!("the rectangle {rect:?} of a unit at {unit:?}")));
    }
    let (pixels, _) = pixels.as_chunks();
    let row = |row: u32| -> Range<usize> {
        let start = (row - unit[1]) as usize * unit[2] as usize + (rect[0] - unit[0]) as usize;
        start..start + rect[2] as usize
    };
    let rows = (rect[1]..rect[1] + rect[3]).map(|at| pixels.get(row(at)).ok_or_else(too_few_pixels));
    Ok(rows.collect::<Result<Vec<&[[u8; N]]>>>()?.concat())
}

fn too_few_pixels() -> Error {
    Error::Usage("the page wrote too few pixels".into())
}
