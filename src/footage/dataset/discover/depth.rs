//! Derives how depth is stored from the first depth image and the name of its file.

use super::Draft;
use crate::dataset::manifest::{Background, DepthInfo, FileDepth, Unit};
use crate::image_files::png;
use codec::error::Result;
use codec::image::{Projection, StreamKind};

/// Depth values from this one on, in units of the file, mark the background.
const NOTHING_FROM: f32 = 1e10;
/// Metres per unit of depth in data sets in the format of TUM RGB-D.
const TUM_SCALE: f64 = 0.0002;

impl Draft<'_> {
    /// Derives depth properties from the first depth image.
    pub(super) fn depth(&mut self, projection: Projection, is_stereo: bool) -> Result<Option<DepthInfo>> {
        let Some((files, _)) = self.kinds.get(&StreamKind::Depth) else { return Ok(None) };
        let first = files[0];
        let mut info =
            DepthInfo { unit: None, channel: is_stereo.then(|| "{probe}".to_owned()), ..DepthInfo::default() };
        if projection == Projection::Perspective && !first.has_distance() {
            info.kind = FileDepth::Planar;
        }
        if let Some(channel) = first.depth_channel.as_ref().filter(|_| !is_stereo) {
            info.channel = Some(channel.clone());
        }
        if first.is_disparity() {
            info.kind = FileDepth::Disparity;
            let is_normal =
                png::has_codes(&first.first) || self.read_depth(first)?.data().iter().all(|value| *value <= 1.0);
            let text = &first.text;
            self.unsure.push(if is_normal {
                (info.near, info.far) = (Some(0.5), Some(100.0));
                format!(
                    "{text} was taken for disparity from 0 (100 m) to 1 or the largest code (0.5 m): set \"near\" and \
                     \"far\", or \"scale\" to baseline times focal length instead"
                )
            } else {
                info.scale = Some(1.0);
                format!(
                    "{text} was taken for disparity: set \"scale\" to baseline in metres times focal length in pixels"
                )
            });
            return Ok(Some(info));
        }
        // Both lists are part of data sets in the format of TUM RGB-D.
        let is_tum = ["rgb.txt", "depth.txt"].iter().all(|name| self.folder.join(name).is_file());
        if png::has_codes(&first.first) && first.timed.is_some() && is_tum {
            info.scale = Some(TUM_SCALE);
            self.unsure.push(format!("{} was assumed to have 5000 units per metre, as TUM RGB-D has", first.text));
        } else if png::has_codes(&first.first) {
            info.unit = Some(Unit::Mm);
            self.unsure.push(format!("{} has integer depth, which was assumed to be in millimetres", first.text));
        }
        let plane = self.read_depth(first)?;
        let finite = || plane.data().iter().copied().filter(|value| value.is_finite());
        let negative = finite().filter(|value| *value < 0.0).count();
        let positive = finite().filter(|value| *value > 0.0).count();
        let sign = if negative > positive { -1.0 } else { 1.0 };
        if sign < 0.0 {
            info.scale = Some(-1.0);
            self.unsure.push(format!(
                "{} has negative depth, which was assumed to be Z of a camera that looks along -Z",
                first.text
            ));
        }
        let far = finite().map(|value| value * sign).filter(|value| *value >= NOTHING_FROM).reduce(f32::max);
        let background = far.map(|far| far * sign).or(finite().any(|value| value == 0.0).then_some(0.0));
        if let Some(background) = background {
            info.background = Background::Value(shortest(background));
            self.unsure.push(format!("depth {background:?} was assumed to be the background"));
        }
        Ok(Some(info))
    }

    /// States the size of depth files, if it is not that of the others.
    pub(super) fn sized(&mut self, depth: DepthInfo, size: (u32, u32)) -> DepthInfo {
        let first = self.kinds.get(&StreamKind::Depth).map(|(files, _)| files[0]);
        let Some(of) = first.filter(|of| of.size != size && self.own_sizes.is_empty()) else { return depth };
        self.unsure.push(format!(
            "{} is {}x{} pixels, others are {}x{}: it was assumed to show the same picture, and becomes as large by nearest \
             neighbour",
            of.text, of.size.0, of.size.1, size.0, size.1
        ));
        DepthInfo { size: Some(of.size.into()), ..depth }
    }
}

/// Returns the 64-bit float with the shortest decimal form of a 32-bit one.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
