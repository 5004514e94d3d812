//! Images whose eye moves from column to column: omnidirectional stereo.
//!
//! Takes a camera and a function that renders an image from one eye. Returns the image assembled from its columns. Each column is
//! rendered as a row, so that four rays march at once.

use rayon::prelude::*;

use crate::march::{Counters, Rendered};
use crate::rendered_image::{Aov, RenderedImage};
use codec::error::Result;
use codec::image::{Plane, Primaries};
use codec::math::Camera;
use codec::monitor::{Monitor, Uncounted};

/// Renders an image of this width and height by columns. `row` renders an image of `height` by 1 pixels. The monitor advances by
/// one per row of the image.
pub fn render_columns(
    [width, height]: [u32; 2],
    camera: &Camera,
    monitor: &dyn Monitor,
    row: impl Fn(&Camera, &dyn Monitor) -> Result<Rendered> + Sync,
) -> Result<Rendered> {
    let rows_by = |column: u32| u64::from(column) * u64::from(height) / u64::from(width);
    let column = |at: u32| {
        monitor.check()?;
        let rendered = row(&camera.column(at, width), &Uncounted(monitor))?;
        monitor.advance(rows_by(at + 1) - rows_by(at));
        Ok(rendered)
    };
    let columns: Vec<Rendered> = (0..width).into_par_iter().map(column).collect::<Result<_>>()?;
    let of = |x: u32| &columns[x as usize].image;
    let aovs = columns.first().map_or(&[][..], |first| &first.image.aovs);
    let aov = |(number, aov): (usize, &Aov)| Aov {
        channel: aov.channel,
        plane: Plane::from_fn(width, height, |x, y| of(x).aovs[number].plane.get(y, 0)),
    };
    let image = RenderedImage {
        color: Plane::from_fn(width, height, |x, y| of(x).color.get(y, 0)),
        alpha: Plane::from_fn(width, height, |x, y| of(x).alpha.get(y, 0)),
        primaries: columns.first().map_or(Primaries::REC709, |first| first.image.primaries),
        aovs: aovs.iter().enumerate().map(aov).collect(),
    };
    let counters = columns.iter().fold(Counters::default(), |sum, column| sum + column.counters);
    Ok(Rendered { image, counters })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::march::aov::AovKind;
    use crate::march::playback::frames::{CpuRenderer, PictureOptions, Renderer, Stage};
    use crate::march::synthetic::{SyntheticProbe, room};
    use crate::march::tests::field;
    use crate::views::ColorCoding;
    use codec::image::ToneMap;
    use codec::math::{Camera, Lens};
    use codec::monitor::Silent;

    #[test]
    fn each_column_is_seen_from_its_eye() {
        let coding = ColorCoding::Codes(ToneMap::default());
        let half = DVec3::new(3.0, 1.5, 2.0);
        let places = [[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]].map(|[x, z]| DVec3::new(x, 0.0, z));
        let view = |&at: &DVec3| SyntheticProbe::new(at, 64).cube(coding, &|to| room(at, to, half, 0.0));
        let light_field = field(places.iter().map(view).collect(), coding);
        let options = PictureOptions { size: [32, 16], aovs: vec![AovKind::Depth], ..PictureOptions::default() };
        let mut renderer = CpuRenderer::new(options);
        let stage = Stage { field: &light_field, views: &[0, 1, 2, 3, 4] };
        let middle = Camera::oriented(DVec3::ZERO, [0.0, 0.0, 0.0, 1.0], Lens::new(60.0)).unwrap();
        let mut seen = [0.4, 0.0].map(|offset_m| {
            let camera = middle.as_panorama(360.0, offset_m);
            let rendered = renderer.render(&stage, &camera, &Silent).unwrap();
            assert_eq!(rendered.counters.primary_rays, 32 * 16);
            let error = |x: u32, y: u32| {
                let column = camera.column(x, 32);
                let direction = column.direction([(f64::from(y) + 0.5) / 16.0, 0.5]);
                let (metres, _) = room(column.eye(), direction, half, 0.0).unwrap();
                (f64::from(rendered.image.aovs[0].plane.get(x, y)) / metres).ln().abs()
            };
            let errors: Vec<f64> =
                (0..16).flat_map(|y| (0..32).map(move |x| (x, y))).map(|(x, y)| error(x, y)).collect();
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            assert!(mean < 0.02, "{offset_m}: {mean}");
            rendered.image.color
        });
        assert!(seen[0] != seen[1]);
        // The image does not depend on the number of threads.
        let camera = middle.as_panorama(360.0, 0.4);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        seen[1] = one.install(|| renderer.render(&stage, &camera, &Silent)).unwrap().image.color;
        assert!(seen[0] == seen[1]);
    }
}
