//! PSNR of modelling functions on 8x8 tiles of depth (GDC figure 6).

use crate::depth::Quantiser;
use crate::depth::domain::Domain;
use crate::depth::tile_psnr::{TILE_SIDE, TilePsnr};
use crate::encode::EncodeSettings;
use crate::encode::depth_range::depth_of_probe;
use crate::encode::source::{FrameSource, GroupRef, name_frame, selected_groups};
use crate::error::Result;
use crate::image::StreamKind;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;
use crate::streams::convert;

fn depth_groups(source: &dyn FrameSource) -> Vec<GroupRef<'_>> {
    selected_groups(source, &EncodeSettings { kinds: vec![StreamKind::Depth], ..EncodeSettings::default() })
}

/// Images that [`measure`] advances its monitor by.
pub fn images(source: &dyn FrameSource) -> u64 {
    depth_groups(source).iter().map(GroupRef::images).sum()
}

/// Models all tiles of all depth images with each function, without a bound. Of the settings, near, far, domain and effort
/// count. The result does not depend on the number of threads.
pub fn measure(source: &dyn FrameSource, settings: &EncodeSettings, monitor: &dyn Monitor) -> Result<TilePsnr> {
    let mut found = TilePsnr::default();
    let all = depth_groups(source);
    for groups in all.chunk_by(|one, next| one.group.probe == next.group.probe) {
        let mut probe = depth_of_probe(source, settings, groups, None, monitor)?;
        let quantiser = Quantiser::new(probe.range);
        let domain = Domain::new(settings.depth.domain, probe.range)?;
        for &GroupRef { at, group } in groups {
            for frame in group.frames.iter() {
                monitor.check()?;
                let planes = match probe.kept.remove(&(at, frame)) {
                    Some(planes) => planes,
                    None => source.read_depth(group, frame)?,
                };
                for plane in &planes {
                    let codes = convert::depth_codes(plane, &quantiser)
                        .map_err(|error| error.context(name_frame(source, group, frame)))?;
                    let rows = (0..codes.height() as usize).step_by(TILE_SIDE).collect();
                    let measured = try_map_ordered(rows, |y| {
                        monitor.check()?;
                        let how = (&domain, settings.depth.effort);
                        Ok(TilePsnr::of_row(codes.data(), codes.width() as usize, y, how))
                    })?;
                    measured.iter().for_each(|row| found.add(row));
                    monitor.advance(1);
                }
            }
        }
    }
    Ok(found)
}
