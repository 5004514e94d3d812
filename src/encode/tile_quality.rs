//! Measures modelling functions on the depth of a source, tile by tile (GDC figure 6).

use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::StreamKind;
use crate::depth::domain::Domain;
use crate::depth::quantise::Quantiser;
use crate::depth::tile_psnr::{TILE_SIDE, TilePsnr};
use crate::encode::dataset::{self, EncodeSettings};
use crate::error::Result;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;
use crate::streams::convert;

/// Images that [`measure`] advances its monitor by.
pub fn images(source: &Source) -> u64 {
    let depth = source.groups().iter().filter(|group| group.kind == StreamKind::Depth);
    depth.map(|group| group.frames.count() * group.faces.len() as u64).sum()
}

/// Models all tiles of all depth images of a source with each function, without a bound. Of the settings, near, far,
/// domain and effort count.
///
/// The result does not depend on the number of threads.
pub fn measure(source: &Source, settings: &EncodeSettings, monitor: &dyn Monitor) -> Result<TilePsnr> {
    let mut found = TilePsnr::default();
    for probe in 0..source.probes().len() {
        let groups: Vec<(usize, &SourceGroup)> = source
            .groups()
            .iter()
            .enumerate()
            .filter(|(_, group)| group.kind == StreamKind::Depth && group.probe == probe)
            .collect();
        if groups.is_empty() {
            continue;
        }
        let mut probe = dataset::depth_of_probe(source, settings, &groups, monitor)?;
        let quantiser = Quantiser::new(probe.range);
        let domain = Domain::new(settings.depth.domain, probe.range)?;
        for (at, group) in groups {
            for frame in group.frames.iter() {
                monitor.check()?;
                let planes = match probe.kept.remove(&(at, frame)) {
                    Some(planes) => planes,
                    None => source.read_depth(group, frame)?,
                };
                for plane in &planes {
                    let codes = convert::depth_codes(plane, &quantiser)
                        .map_err(|error| error.context(crate::encode::settings::name_frame(source, group, frame)))?;
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
