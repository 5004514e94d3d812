//! Reads the images of a group of streams and converts them to the domain of its codec.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::encode::budget::ColorMemory;
use crate::encode::plan::{GroupPlan, Plan};
use crate::encode::source::name_frame;
use codec::color::HalfKey;
use codec::color::quality::Pu21;
use codec::color::transform::encode::PricedTables;
use codec::depth::Quantiser;
use codec::error::{Error, Result};
use codec::image::transfer::EncodeTable;
use codec::image::{DepthPlane, Plane, StreamKind};
use codec::streams::{CodecHeader, ColorFormat, DepthCoding, DepthHeader, convert};

pub(super) enum Coded {
    /// Codes of depth or alpha; level indices for a depth stream that has levels.
    Codes(Plane<u16>),
    Bytes(Plane<[u8; 3]>),
    Half(Plane<[HalfKey; 3]>),
}

/// Pixel of one kind of coded picture.
pub(super) trait CodedPixel: Copy {
    fn plane_of(picture: &Coded) -> Option<&Plane<Self>>;
}

macro_rules! coded_pixel {
    ($pixel:ty, $kind:ident) => {
        impl CodedPixel for $pixel {
            fn plane_of(picture: &Coded) -> Option<&Plane<Self>> {
                if let Coded::$kind(plane) = picture { Some(plane) } else { None }
            }
        }
    };
}

coded_pixel!(u16, Codes);
coded_pixel!([u8; 3], Bytes);
coded_pixel!([HalfKey; 3], Half);

/// Nanoseconds over all threads.
#[derive(Debug, Default)]
pub(super) struct Times {
    pub reading: AtomicU64,
    pub coding: AtomicU64,
}

impl Times {
    /// Total times of reading and of coding, over all threads.
    pub fn durations(&self) -> [Duration; 2] {
        [&self.reading, &self.coding].map(|nanos| Duration::from_nanos(nanos.load(Ordering::Relaxed)))
    }
}

/// Adds the time of `work` to `nanos`.
pub(super) fn timed<T>(nanos: &AtomicU64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    nanos.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
    done
}

pub(super) struct GroupCoder<'a> {
    pub plan: &'a Plan<'a>,
    pub planned: GroupPlan<'a>,
    pub header: CodecHeader,
    pub color_memory: ColorMemory,
    pub times: Times,
    /// Quantiser of a depth group. Building its table takes longer than coding a small frame, so all faces of a probe share one.
    pub quantiser: Option<Arc<Quantiser>>,
    pu21: Option<Pu21>,
    /// Entropy tables of the transform codec.
    pub tables: Option<Arc<PricedTables>>,
    table: Option<EncodeTable>,
}

impl<'a> GroupCoder<'a> {
    pub fn new(plan: &'a Plan<'a>, planned: GroupPlan<'a>, header: CodecHeader) -> Result<GroupCoder<'a>> {
        let (mut table, mut pu21, mut tables) = (None, None, None);
        if let CodecHeader::Color(header) = &header {
            match header.format {
                ColorFormat::EightBit(tone) => table = Some(EncodeTable::new(&tone)),
                ColorFormat::Half { white_cd_m2 } => pu21 = Some(Pu21::new(white_cd_m2)?),
            }
            tables = header.tables().map(|tables| Arc::new(PricedTables::new(tables.clone())));
        }
        let color_memory = ColorMemory::new(planned.group, plan.settings);
        let times = Times::default();
        Ok(GroupCoder { plan, planned, header, color_memory, times, quantiser: None, pu21, tables, table })
    }

    /// Returns the perceptual metric of half-float colour.
    pub fn pu21(&self) -> Result<&Pu21> {
        self.pu21.as_ref().ok_or_else(|| Error::invalid("half floats in a stream of another format"))
    }

    /// Replaces codes by level indices if the stream has levels. The levels were found by an earlier scan of the same images.
    fn numbers(&self, codes: Plane<u16>) -> Result<Plane<u16>> {
        let levels = match &self.header {
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(header), .. }) => &header.levels,
            _ => return Ok(codes),
        };
        if levels.is_empty() {
            return Ok(codes);
        }
        let (width, height) = (codes.width(), codes.height());
        let numbers = levels.numbers(codes.data()).map_err(|at| {
            let (x, y) = (at % width as usize, at / width as usize);
            Error::invalid(format!(
                "pixel ({x}, {y}) has a depth that was not found in advance: the images have changed, so scan and \
                encode them again"
            ))
        })?;
        Plane::new(width, height, numbers.into_owned())
    }

    /// Reads a frame of all faces and converts it; planes that a scan `kept` are not read again. Also returns the number of
    /// clipped colour pixels, or of depth pixels outside near and far.
    pub fn read(&self, frame: u32, kept: Option<Vec<DepthPlane>>) -> Result<(Vec<Coded>, u64)> {
        let (source, group, times) = (self.plan.source, self.planned.group, &self.times);
        let named = |error: Error| {
            let error = error.context(name_frame(source, group, frame));
            match source.files(group, frame).unwrap_or_default().first() {
                Some(file) => error.in_file(file),
                None => error,
            }
        };
        let mut beyond = 0;
        let coded: Result<Vec<Coded>> = match group.kind {
            StreamKind::Depth => {
                let Some(quantiser) = &self.quantiser else { return Ok((Vec::new(), 0)) };
                let mut planes = match kept {
                    Some(planes) => planes,
                    None => timed(&times.reading, || source.read_depth(group, frame))?,
                };
                let (rule, given) = (self.plan.settings.outside_depth, self.plan.given_range);
                beyond = planes.iter_mut().map(|plane| rule.replace_outside(plane, given)).sum();
                let code = |plane| self.numbers(convert::depth_codes(plane, quantiser)?).map(Coded::Codes);
                timed(&times.coding, || planes.iter().map(code).collect())
            }
            StreamKind::Material => {
                let planes = timed(&times.reading, || source.read_material(group, frame))?;
                let code = |plane| convert::material_codes(plane).map(Coded::Bytes);
                timed(&times.coding, || planes.iter().map(code).collect())
            }
            StreamKind::Alpha => {
                let planes = timed(&times.reading, || source.read_alpha(group, frame))?;
                let code = |plane| convert::alpha_codes(plane).map(Coded::Codes);
                timed(&times.coding, || planes.iter().map(code).collect())
            }
            StreamKind::Color => {
                let planes = timed(&times.reading, || source.read_color(group, frame))?;
                let code = |plane| match &self.table {
                    Some(table) => {
                        let (codes, clipped) = convert::color_codes(plane, table);
                        beyond += clipped;
                        Coded::Bytes(codes)
                    }
                    None => Coded::Half(plane.map(|pixel| pixel.map(|value| HalfKey::from_bits(value.to_bits())))),
                };
                Ok(timed(&times.coding, || planes.iter().map(code).collect()))
            }
        };
        coded.map(|coded| (coded, beyond)).map_err(named)
    }
}
