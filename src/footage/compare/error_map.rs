//! Per-pixel errors of one image (GDC figure 1c), and for colour the PSNR of each cell, which its encoder bounds.

use crate::compare::difference::{self, Level, half_levels, sample_error};
use crate::compare::domain::{ColorDomain, ComparedColor, Converted, Converter, Domain};
use crate::compare::pairing::Pair;
use crate::compare::side::{Coding, Side, SideReader};
use crate::metrics::depth_error::{PixelError, depth_errors};
use codec::color::quality::{Pu21, Quality};
use codec::error::{Error, Result};
use codec::image::Plane;
use codec::metrics::{SquaredError, U8_PEAK};
use codec::streams::ColorFormat;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellPsnr {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    /// PSNR in dB; +inf if the samples are equal.
    pub psnr_db: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMap {
    pub domain: Domain,
    /// Error of each pixel; for colour and material the maximum of its three samples.
    pub pixels: Plane<PixelError>,
    /// Colour cells in row order; empty for depth and material.
    pub cells: Vec<CellPsnr>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LargestError {
    pub steps: u32,
    pub background_pixels: u64,
    /// Number of pixels outside the range of the codes.
    pub outside_pixels: u64,
}

impl ErrorMap {
    pub fn largest(&self) -> LargestError {
        let mut largest = LargestError::default();
        for error in self.pixels.data() {
            match error {
                PixelError::Steps(steps) => largest.steps = largest.steps.max(*steps),
                PixelError::Background => largest.background_pixels += 1,
                PixelError::Outside => largest.outside_pixels += 1,
            }
        }
        largest
    }

    pub fn differing_pixels(&self) -> u64 {
        self.pixels.data().iter().filter(|error| **error != PixelError::Steps(0)).count() as u64
    }
}

/// Compares one frame of a pair of streams, one of which is a container's. `frame` is a frame number of the first side.
pub fn error_map(sides: &[Side; 2], pair: &Pair<'_>, frame: u32) -> Result<ErrorMap> {
    let streams = pair.streams;
    let named = |error: Error| error.context(format!("{}, frame {frame}", streams[0].id));
    let domain = Domain::of_pair(sides, streams, ColorDomain::AsCoded)
        .ok_or_else(|| named(Error::invalid("neither side has the range of its depth codes")))?;
    let convert = |at: usize, frame: u32| {
        let image = SideReader::new(&sides[at], vec![streams[at]]).image(0, frame)?;
        let color = ComparedColor { primaries: domain.primaries(sides), allows_clipping: true };
        Ok(Converter::new(domain.coding, &sides[at], streams[at], color).convert(image)?.image)
    };
    let images = [convert(0, frame).map_err(named)?, convert(1, pair.other_frame(frame)).map_err(named)?];
    let (pixels, cells) = match (&images, domain.coding) {
        ([Converted::Depth(a), Converted::Depth(b)], _) => {
            let height = a.codes.len() as u32 / a.width.max(1);
            (Plane::new(a.width, height, depth_errors(a, b))?, vec![])
        }
        ([Converted::Bytes(a), Converted::Bytes(b)], Coding::Color(_, cell)) => {
            (of_samples(a, b), cells(a, b, cell, U8_PEAK))
        }
        ([Converted::Bytes(a), Converted::Bytes(b)], _) => (of_samples(a, b), vec![]),
        ([Converted::Half(a), Converted::Half(b)], Coding::Color(ColorFormat::Half { white_cd_m2 }, cell)) => {
            let metric = Pu21::new(white_cd_m2)?;
            let (a, b) = (half_levels(a, &metric), half_levels(b, &metric));
            (of_samples(&a, &b), cells(&a, &b, cell, metric.peak()))
        }
        _ => return Err(named(Error::invalid("images of two kinds cannot be compared"))),
    };
    Ok(ErrorMap { domain, pixels, cells })
}

fn of_samples<T: Level>(a: &Plane<[T; 3]>, b: &Plane<[T; 3]>) -> Plane<PixelError> {
    Plane::from_fn(a.width(), a.height(), |x, y| PixelError::Steps(sample_error(&a.get(x, y), &b.get(x, y)).largest))
}

fn cells<T: Level>(a: &Plane<[T; 3]>, b: &Plane<[T; 3]>, cell: u32, peak: f64) -> Vec<CellPsnr> {
    let measure = |rect: [u32; 4]| {
        let [left, top, width, height] = rect;
        let columns = left as usize..(left + width) as usize;
        let rows = (top..top + height).flat_map(|y| a.row(y)[columns.clone()].iter().zip(&b.row(y)[columns.clone()]));
        let sum = rows.map(|(a, b)| u128::from(sample_error(a, b).squared)).sum();
        let error = SquaredError { sum, samples: 3 * u64::from(width) * u64::from(height), peak };
        CellPsnr { rect, psnr_db: error.psnr_db() }
    };
    difference::cells(a, cell).map(measure).collect()
}
