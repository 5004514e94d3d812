//! Reads the first frame of every stream before anything is encoded, so that a wrong channel or size, or colour that would be
//! clipped to 8 bits, is reported early.

use crate::dataset::SourceGroup;
use crate::encode::Clipping;
use crate::encode::plan::Plan;
use crate::encode::source::{FrameSource, name_frame, selected_groups};
use codec::error::{Error, Result};
use codec::image::{EncodeTable, StreamKind};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams::{ColorFormat, convert};

/// The first frame of each group of an encode that is read from a file.
pub struct FirstFrames<'a> {
    plan: &'a Plan<'a>,
    frames: Vec<(&'a SourceGroup, u32)>,
}

impl<'a> FirstFrames<'a> {
    pub fn new(plan: &'a Plan<'a>) -> Result<FirstFrames<'a>> {
        let mut frames = Vec::new();
        for group in selected_groups(plan.source, plan.settings) {
            for frame in group.frames.iter() {
                if !plan.source.files(group, frame)?.is_empty() {
                    frames.push((group, frame));
                    break;
                }
            }
        }
        Ok(FirstFrames { plan, frames })
    }

    pub fn images(&self) -> u64 {
        self.frames.iter().map(|(group, _)| group.faces.len() as u64).sum()
    }

    /// Reads the frames. The monitor advances by one per image.
    ///
    /// # Errors
    /// Fails if a file cannot be read as its stream, or with [`Clipping::Refuse`] if colour pixels would be clipped to 8 bits.
    pub fn check(&self, monitor: &dyn Monitor) -> Result<()> {
        let Plan { source, settings, .. } = *self.plan;
        let table = match settings.color {
            ColorFormat::EightBit(tone) => Some(EncodeTable::new(&tone)),
            ColorFormat::Half { .. } => None,
        };
        // One image at a time fits into any budget that is large enough to start the encode.
        let at_once = if settings.memory.bytes.is_some() { 1 } else { usize::MAX };
        let found = try_map_at_once(self.frames.iter().collect(), at_once, |&(group, frame)| {
            monitor.check()?;
            let [pixels, clipped] = read(source, group, frame, table.as_ref())?;
            monitor.advance(group.faces.len() as u64);
            Ok((group, frame, pixels, clipped))
        })?;
        let most = found.iter().filter(|(.., clipped)| *clipped > 0).max_by_key(|(.., clipped)| *clipped);
        let Some(&(group, frame, ..)) = most.filter(|_| settings.clipping == Clipping::Refuse) else { return Ok(()) };
        let [pixels, clipped] =
            found.iter().fold([0, 0], |[all, sum], (.., pixels, clipped)| [all + pixels, sum + clipped]);
        Err(Error::Usage(format!(
            "{clipped} of {pixels} colour pixels of the first frames ({:.2}%) do not fit 8 bits, most in {}: `hdr` keeps them as \
             half floats, `clip` accepts the loss, `exposure` darkens all",
            100.0 * clipped as f64 / pixels as f64,
            name_frame(source, group, frame)
        )))
    }
}

/// Returns the number of colour pixels of a frame, and how many of them `table` clips.
fn read(source: &dyn FrameSource, group: &SourceGroup, frame: u32, table: Option<&EncodeTable>) -> Result<[u64; 2]> {
    match group.kind {
        StreamKind::Depth => source.read_depth(group, frame).map(|_| [0, 0]),
        StreamKind::Material => source.read_material(group, frame).map(|_| [0, 0]),
        StreamKind::Alpha => source.read_alpha(group, frame).map(|_| [0, 0]),
        StreamKind::Color => {
            let planes = source.read_color(group, frame)?;
            let pixels = planes.iter().map(|plane| plane.data().len() as u64).sum();
            let clipped = table.map(|table| planes.iter().map(|plane| convert::color_codes(plane, table).1).sum());
            Ok([pixels, clipped.unwrap_or(0)])
        }
    }
}
