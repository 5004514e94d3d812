//! Cameras that select parts of a container.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;

use crate::output::{self, human_bytes};
use codec::decode::{self, AllUnits, DecodeSummary, Decoder, StreamFrames, UnitFilter};
use codec::error::Result;
use codec::math::{Camera, Lens};
use evaluate::cameras::{self, FileCameras, ReadSettings};
use render::camera_path::TimedCamera;
use render::views::camera_units::{CameraUnitCounts, CameraUnits, CameraUnitsReport};

pub fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|number| number.trim().parse().ok().filter(|value: &f64| value.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("'{text}': x,y,z was expected, three finite numbers such as -0.5,1.75,2")),
    }
}

pub fn parse_aspect(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let ratio = match text.split_once(['/', ':']) {
        Some((width, height)) => number(width).zip(number(height)).map(|(width, height)| width / height),
        None => number(text),
    };
    ratio
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .ok_or_else(|| format!("'{text}': a ratio such as 16/9 or a number above 0 was expected"))
}

/// Reads a camera file, chooses a camera by its name, and prints what was left out.
pub fn read_cameras(path: &Path, settings: ReadSettings, name: Option<&str>) -> Result<FileCameras> {
    let mut found = cameras::read(path, settings)?;
    match name {
        Some(name) => found.choose(name).map_err(|error| error.context(path.display()))?,
        None => found.leave_out_still(),
    }
    for note in &found.notes {
        output::note(format_args!("{}: {note}", path.display()));
    }
    if found.share_frames() && found.names().len() > 1 {
        let names = found.listed();
        output::note(format_args!("{}: its cameras are {names}; --camera-name chooses one", path.display()));
    }
    Ok(found)
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "View")]
pub struct CameraArgs {
    /// Camera file, - for standard input; repeatable. Formats: lightfold, files of place and interpolate --cameras-out,
    /// probes of a container or dataset, glTF, USD, COLMAP, and the files of nerfstudio, Gaussian splatting and
    /// instant-ngp; see lightfold cameras
    #[arg(long, value_name = "FILE")]
    pub camera: Vec<PathBuf>,
    /// Camera of the files, by its name or that of its picture [default: all that move, else all]
    #[arg(long, value_name = "NAME", requires = "camera")]
    pub camera_name: Option<String>,
    /// Position of a camera in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// Point that the camera looks at, in metres [default: along −Z]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<DVec3>,
    /// Up direction of the camera [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub up: Option<DVec3>,
    /// Vertical field of view of the camera in degrees [default: 60]
    #[arg(long, value_name = "DEGREES", requires = "eye")]
    pub fov: Option<f64>,
    /// Aspect ratio of the camera, such as 16/9 [default: 1]
    #[arg(long, value_name = "W/H", value_parser = parse_aspect, requires = "eye")]
    pub aspect: Option<f64>,
    /// Report counters of tiles, cells and bytes
    #[arg(long)]
    pub stats: bool,
}

impl CameraArgs {
    /// Returns all cameras. `fps` converts files with times in seconds to frames.
    pub fn cameras(&self, fps: f64) -> Result<Vec<TimedCamera>> {
        let mut cameras = Vec::new();
        for path in &self.camera {
            let found = read_cameras(path, ReadSettings::with_fps(fps), self.camera_name.as_deref())?;
            cameras.extend(found.cameras.into_iter().map(|camera| camera.timed));
        }
        if let Some(eye) = self.eye {
            let target = self.look_at.unwrap_or(eye + DVec3::NEG_Z);
            let lens = Lens { aspect: self.aspect.unwrap_or(1.0), ..Lens::new(self.fov.unwrap_or(60.0)) };
            let camera = Camera::look_at(eye, target, self.up.unwrap_or(DVec3::Y), lens)?;
            cameras.push(TimedCamera { camera, frames: None });
        }
        Ok(cameras)
    }

    /// Returns the units of the selection that the cameras see.
    pub fn view(&self, decoder: &Decoder, chosen: &[StreamFrames<'_>]) -> Result<View> {
        let cameras = self.cameras(decoder.reader().index().fps)?;
        let seen = (!cameras.is_empty()).then(|| CameraUnits::find(decoder, chosen, &cameras));
        let units = chosen.iter().map(|part| u64::from(part.stream.entry.unit_count())).sum();
        let counts = match &seen {
            Some(seen) => seen.counts,
            None => CameraUnitCounts { units, visible_units: units, ..Default::default() },
        };
        if let (Some(_), 0) = (&seen, counts.visible_units) {
            output::note("nothing in the selected frames and streams is visible to any camera");
        }
        let bytes_total = if self.stats { decode::stored_bytes(decoder, chosen) } else { 0 };
        Ok(View { seen, counts, bytes_total, stats: self.stats })
    }
}

#[derive(Debug)]
pub struct View {
    seen: Option<CameraUnits>,
    counts: CameraUnitCounts,
    bytes_total: u64,
    stats: bool,
}

impl View {
    pub fn filter(&self) -> &dyn UnitFilter {
        match &self.seen {
            Some(seen) => seen,
            None => &AllUnits,
        }
    }

    /// Returns the JSON that `--stats` adds to a report.
    pub fn report(&self) -> Option<CameraUnitsReport> {
        self.stats.then(|| self.counts.report(self.bytes_total))
    }

    /// Returns the second line that `--stats` adds to a report. Empty without it.
    pub fn line(&self, summary: &DecodeSummary) -> String {
        let Some(CameraUnitsReport { visible_fraction, bytes_total, .. }) = self.report() else { return String::new() };
        let counts = &self.counts;
        let read = format!(
            "{} of {} read ({:.1}%)",
            human_bytes(summary.cost.bytes_read),
            human_bytes(bytes_total),
            100.0 * summary.cost.bytes_read as f64 / bytes_total.max(1) as f64,
        );
        let who = match counts.cameras {
            0 => return format!("\nno camera: all {} tiles and cells; {read}", counts.units),
            1 => "1 camera sees".to_owned(),
            cameras => format!("{cameras} cameras see"),
        };
        format!(
            "\n{who} {} of {} tiles and cells ({:.1}%); {} frustum tests instead of {}; {read}",
            counts.visible_units,
            counts.units,
            100.0 * visible_fraction,
            counts.hierarchical_tests,
            counts.regular_tests,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_ratios_are_parsed() {
        assert_eq!(parse_point("-0.5,1.75, -3e-1"), Ok(DVec3::new(-0.5, 1.75, -0.3)));
        for text in ["", "1", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,inf", "1 2 3"] {
            assert!(parse_point(text).unwrap_err().contains("three finite numbers"), "{text}");
        }
        assert_eq!(parse_aspect("3/2"), Ok(1.5));
        assert_eq!(parse_aspect("16:8"), Ok(2.0));
        assert_eq!(parse_aspect("1.25"), Ok(1.25));
        for text in ["", "0", "-1", "1/0", "0/0", "a/b", "1/2/3", "inf", "nan"] {
            assert!(parse_aspect(text).is_err(), "{text}");
        }
    }
}
