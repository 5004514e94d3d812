//! Arguments of `interpolate`.

use std::path::PathBuf;
use std::time::Duration;

use glam::DVec3;

use crate::capture::parse_size;
use crate::device::{DEVICES, GpuIndex};
use crate::options::{
    Choices, FrameArgs, MemoryArgs, one_of, parse_aspect, parse_face, parse_not_negative, parse_point, parse_positive,
    word_of,
};
use crate::refuse;
use codec::error::Result;
use codec::image::{Face, FrameRange};
use codec::math::{Camera, Lens};
use epipolar::acquire::{
    AcquireSettings, Acquisition, Culling, Hierarchy, LayerReduction, SourcePlacement, StoppingRule,
};
use epipolar::captured::CapturedSources;
use epipolar::coalesce::Coalescing;
use epipolar::fill::HoleFilling;
use epipolar::grid::GridViews;
use epipolar::highlights::DEFAULT_SPLITS;
use epipolar::interpolate::InterpolateSettings;
use epipolar::memory::Plan;
use epipolar::pipeline::Settings;
use epipolar::source::MAX_LAYERS;
use epipolar::views::{MAX_VIEWS, OutputViews, Spread};
use footage::image_files::quilt::QuiltLayout;
use gpu::device::DeviceChoice;
use scene::capture::{MAX_FACE_SIZE, MAX_SAMPLES, SamplePattern};

const DEFAULT_SIZE: u32 = 512;

#[derive(Debug, clap::Args)]
#[command(
    group(clap::ArgGroup::new("spread").args(["baseline", "view_cone"])),
    group(clap::ArgGroup::new("from").required(true).args(["eye", "probe"])),
    group(clap::ArgGroup::new("to").required(true).args(["output", "null"])),
    after_help = "Examples:\n  \
    lightfold interpolate a.glb --eye 0,1,3 --look-at 0,1,0 --views 48 --baseline 0.5 -o q.png\n  \
    lightfold interpolate a.glb --eye 0,1,3 --look-at 0,1,0 --views 66 --view-cone 35 --focus 3 \\\n      \
    --quilt go -o go.png\n  \
    lightfold interpolate footage --probe 01,02 --face pz --views 48 -o q.png\n  \
    lightfold interpolate film.lfold --eye 0,1,3 --look-at 0,1,0 --views 48 --baseline 0.3 -o q.png\n  \
    lightfold interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 45 --baseline 0.3 \\\n      \
    --frames 0-23 -o q.%04d.png\n  \
    lightfold interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 9 --baseline 0.3 -o %02d.exr\n  \
    lightfold interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 9 --baseline 0.3 \\\n      \
    --view-range 0-4 -o v/%04d.png\n  \
    lightfold interpolate interior --eye 0,1,0 --look-at 2,1,0 --views 100 --baseline 0.3 \\\n      \
    --null --compare --json\n  \
    lightfold interpolate a.glb --eye 0,1,3 --look-at 0,1,0 --views 500 --baseline 0.5 \\\n      \
    --device gpu -o v/%04d.png\n\n\
    Output views stand side by side, from view 0 at the left, and look in the same direction. Pixels of a few source \
    views, which include hidden surfaces, are reprojected to all output views. Surfaces at the distance of --focus \
    have zero disparity; without --focus, those at infinity. --rows stacks several such lines. `render --views` is a \
    number of probes, `interpolate --views` a number of output views.\n\n\
    Mirrors and glass of a scene are ray cast in every view, and so are holes with --holes trace. The source views of \
    a container are rendered from it. --device reprojects pixels, with the same bits as the CPU, and computes \
    highlights in single precision; with --rasterize it also draws triangles. Shading of source views and ray casting \
    run on the CPU.\n\n\
    The views of a line are written when all scanlines are interpolated; --resume keeps written views.\n\n\
    --json reports `seconds` of all stages together, load_seconds for reading the scene, and write_seconds for \
    writing pictures. Stages: acquire; mask, visibility of hidden surfaces; filter, conversion of pixels to lines; \
    interpolate; light, shading with highlights; and fill. Elapsed time of stages that share threads (mask with \
    acquire; filter and light with interpolate) is divided in proportion to their CPU time; on a device, light is the \
    time of highlights, and other shading is part of interpolate. After --resume, figures cover only the views of \
    this run."
)]
pub struct Args {
    /// Scene file (glTF, GLB, OBJ), built-in scene, or container; with --probe a dataset or container
    #[arg(value_name = "INPUT")]
    pub input: String,
    /// Centre of the line of cameras, in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at")]
    pub eye: Option<DVec3>,
    /// Point that the central camera looks at, in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<DVec3>,
    /// Use images of these probes, which stand side by side, as source views, such as 01,02
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Face of the probes perpendicular to their line: px nx py ny pz nz, or view
    #[arg(long, value_name = "FACE", value_parser = parse_face, default_value = "view", requires = "probe")]
    pub face: Face,
    /// Up direction [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub up: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = parse_positive, conflicts_with = "probe")]
    pub fov: f64,
    /// Number of output views
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_VIEWS)))]
    pub views: u32,
    /// Distance from the first to the last view in metres; views are evenly spaced [default: distance of the probes]
    #[arg(long, value_name = "M", value_parser = parse_not_negative)]
    pub baseline: Option<f64>,
    /// Angle from the first to the last view around the focus, in degrees; views have even angles
    #[arg(long, value_name = "DEGREES", value_parser = parse_not_negative, requires = "focus")]
    pub view_cone: Option<f64>,
    /// Number of rows of views, numbered row by row from the lowest
    #[arg(long, value_name = "N", default_value_t = 1, requires = "baseline_y", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub rows: u32,
    /// Method for rows between the lowest and the highest
    #[arg(long, value_parser = one_of(GRID_ORDERS), default_value = "columns")]
    pub grid: GridOrder,
    /// Distance from the lowest to the highest row in metres; rows are evenly spaced
    #[arg(long, value_name = "M", requires = "rows", value_parser = parse_not_negative)]
    pub baseline_y: Option<f64>,
    /// Distance in metres of the plane with zero disparity [default: that of the probes' images, else infinity]
    #[arg(long, value_name = "M", value_parser = parse_positive)]
    pub focus: Option<f64>,
    /// Width and height of a view in pixels, or the side of a square view [default: that of the quilt's device, else
    /// 512]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, conflicts_with = "probe")]
    pub size: Option<(u32, Option<u32>)>,
    /// Aspect ratio of a view as displayed, such as 16/9; its pixels are stretched where --size has another one [default:
    /// that of the quilt's device, else width / height of --size]
    #[arg(long, value_name = "W/H", value_parser = parse_aspect, conflicts_with = "probe")]
    pub aspect: Option<f64>,
    /// Columns and rows of a quilt such as 8x6, or a device: portrait, go, 16, 16-portrait, 16-gen2, 32, 32-portrait,
    /// 32-gen2, 65 [default: the device that matches the views, else a nearly square picture]
    #[arg(long, value_name = "DEVICE|CxR")]
    pub quilt: Option<QuiltLayout>,
    /// Colour samples per pixel: on a grid if a square number, else Hammersley points; for containers a square number
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
    pub samples: u32,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Frames per second of a scene
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = parse_positive)]
    pub fps: f64,
    /// Placement of source views
    #[arg(long, value_parser = one_of(ACQUISITIONS), default_value = "dual")]
    pub acquire: Acquisition,
    /// Maximum number of layers per source view
    #[arg(long, value_name = "N", default_value_t = MAX_LAYERS as u32, value_parser = clap::value_parser!(u32).range(1..=MAX_LAYERS as i64))]
    pub layers: u32,
    /// Culling of source-view surfaces that no output view shows
    #[arg(long, value_parser = one_of(CULLINGS), default_value = "full")]
    pub culling: Culling,
    /// Percentage of missing pixels above which hierarchical acquisition adds a source view
    #[arg(long, value_name = "PERCENT", default_value_t = 0.5, value_parser = parse_not_negative)]
    pub hole_threshold: f64,
    /// Estimate of missing pixels for hierarchical acquisition
    #[arg(long, value_parser = one_of(STOPS), default_value = "holes")]
    pub stop: StoppingRule,
    /// Position of a new source view between two others in hierarchical acquisition
    #[arg(long, value_parser = one_of(PLACEMENTS), default_value = "midpoint")]
    pub source_placement: SourcePlacement,
    /// Time limit in milliseconds for adding source views in hierarchical acquisition; makes results depend on speed
    #[arg(long, value_name = "MS", value_parser = parse_not_negative)]
    pub source_ms: Option<f64>,
    /// Maximum number of source views in hierarchical acquisition
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(2..=i64::from(MAX_VIEWS)))]
    pub max_sources: u32,
    /// Draw runs of pixels as one primitive if their disparities over the baseline differ by at most this many pixels;
    /// 0 disables coalescing
    #[arg(long, value_name = "PX", default_value_t = 0.0, value_parser = parse_not_negative)]
    pub coalesce: f64,
    /// Coalesce runs whose distances differ by at most this many metres; the error in pixels is unbounded
    #[arg(long, value_name = "M", value_parser = parse_not_negative, conflicts_with = "coalesce")]
    pub coalesce_depth: Option<f64>,
    /// Remove the last layer from the next frame if it covers less than LEAST percent of output pixels, and add a layer
    /// if more than MOST
    #[arg(long, value_name = "LEAST,MOST", value_parser = parse_reduction)]
    pub reduce_layers: Option<LayerReduction>,
    /// Number of ambient occlusion rays per shaded point; 0 disables ambient occlusion
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub ao_rays: u32,
    /// Shadows of suns and lamps
    #[arg(long, value_parser = one_of(SHADOWS), default_value = "rays", action = clap::ArgAction::Set)]
    pub shadows: bool,
    /// Number of times each triangle of a scene is divided into four
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=8))]
    pub subdivide: u32,
    /// Maximum number of positions between the first and last view at which highlights are computed
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SPLITS as u32, value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub splits: u32,
    /// Fill of pixels that no source view shows [default: trace for scenes, else nearest]
    #[arg(long, value_parser = one_of(HOLES))]
    pub holes: Option<HoleFilling>,
    /// Only output views in this range, such as 24-47
    #[arg(long, value_name = "A-B", value_parser = parse_range)]
    pub view_range: Option<(u32, u32)>,
    /// Ray cast every view (or draw it, with --rasterize) instead of interpolating, as ground truth
    #[arg(long, conflicts_with_all = ["compare", "probe"])]
    pub brute_force: bool,
    /// Also ray cast every view (or draw it, with --rasterize), and compare the pictures
    #[arg(long, conflicts_with = "probe")]
    pub compare: bool,
    /// Write the comparison of each view to this CSV file
    #[arg(long, value_name = "FILE.csv", requires = "compare")]
    pub csv: Option<PathBuf>,
    /// Write error maps of all views into this folder
    #[arg(long, value_name = "DIR", requires = "compare")]
    pub error_map: Option<PathBuf>,
    /// Write the cameras of all views, for `render --camera`, `cameras`, and `capture --projection perspective
    /// --cameras`
    #[arg(long, value_name = "FILE.json")]
    pub cameras_out: Option<PathBuf>,
    /// Output: a pattern such as views/%04d.png or views/%04d.exr for views, or one file for a quilt; columns, rows and
    /// aspect are appended to its name. With --frames, %04d is the frame: %V/v.%04d.png for views, q.%04d.png for
    /// quilts
    #[arg(long, short, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Render without writing output
    #[arg(long)]
    pub null: bool,
    /// Resume an interrupted run into the same files with the same options; start over if there is none
    #[arg(long, conflicts_with_all = ["compare", "reduce_layers", "source_ms"])]
    pub resume: bool,
    /// Device that interpolates; highlights may differ by rounding, and edges with --rasterize [default: cpu]
    #[arg(long, value_parser = one_of(DEVICES))]
    pub device: Option<DeviceChoice>,
    #[command(flatten)]
    pub gpu: GpuIndex,
    /// Rasterize source views (all views with --brute-force) on the device instead of casting rays; edges may shift by
    /// a fraction of a pixel
    #[arg(long)]
    pub rasterize: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Print durations and counters of all stages
    #[arg(long)]
    pub stats: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Maximum relative difference between a given focus and that of the captured images.
const SAME_FOCUS: f64 = 1e-3;

const ACQUISITIONS: &Choices<Acquisition> = &[
    ("center", Acquisition::Center, "One at the centre, with a wider window"),
    ("dual", Acquisition::Dual, "One at each end"),
    (
        "hierarchical",
        Acquisition::Hierarchical,
        "At both ends, and between them where pixels are missing; first layer only",
    ),
];

/// How the rows of a grid are interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridOrder {
    Columns,
    Rows,
}

const GRID_ORDERS: &Choices<GridOrder> = &[
    ("columns", GridOrder::Columns, "Interpolate between the outer two rows, column by column (scenes only)"),
    ("rows", GridOrder::Rows, "From source views of each row"),
];

const STOPS: &Choices<StoppingRule> = &[
    ("holes", StoppingRule::Holes, "Pixels that remain empty in a view between two source views"),
    ("erosion", StoppingRule::Erosion, "Depth edges of the source views, without interpolation"),
];

const PLACEMENTS: &Choices<SourcePlacement> = &[
    ("midpoint", SourcePlacement::Midpoint, "Halfway between them"),
    ("clusters", SourcePlacement::Clusters, "At the largest cluster of missing pixels"),
];

const SHADOWS: &Choices<bool> = &[("rays", true, "Ray-cast shadows"), ("none", false, "No shadows")];

const CULLINGS: &Choices<Culling> = &[
    ("full", Culling::Full, "Surfaces close behind others, and those hidden from all output views"),
    ("offset", Culling::DepthOffset, "Surfaces close behind others"),
    ("off", Culling::Off, "No culling"),
];

const HOLES: &Choices<HoleFilling> = &[
    ("trace", HoleFilling::Trace, "Cast rays"),
    ("nearest", HoleFilling::Nearest, "Copy the nearest pixel of the scanline"),
    ("blank", HoleFilling::Blank, "Leave empty, with alpha 0"),
];

fn parse_range(text: &str) -> std::result::Result<(u32, u32), String> {
    let ends = text.split_once('-').unwrap_or((text, text));
    let range = ends.0.parse().ok().zip(ends.1.parse().ok()).filter(|(first, last): &(u32, u32)| first <= last);
    range.ok_or_else(|| format!("'{text}': a range of views such as 24-47 was expected"))
}

fn parse_reduction(text: &str) -> std::result::Result<LayerReduction, String> {
    let percent = |text: &str| text.trim().parse::<f64>().ok().filter(|percent| (0.0..=100.0).contains(percent));
    let both = text.split_once(',').and_then(|(least, most)| percent(least).zip(percent(most)));
    let reduction = both.filter(|(least, most)| least <= most);
    let (min_percent, max_percent) =
        reduction.ok_or_else(|| format!("'{text}': two percentages such as 0.1,1 were expected"))?;
    Ok(LayerReduction { min_percent, max_percent })
}

impl Args {
    /// Returns names and values of options that affect the pictures and that users are likely to change.
    pub(super) fn options(&self) -> Vec<(&'static str, String)> {
        fn words(value: Option<impl std::fmt::Display>) -> String {
            value.map_or_else(|| "none".to_owned(), |value| value.to_string())
        }
        let switch = |is_on: bool| if is_on { "on" } else { "off" }.to_owned();
        let pixels = |(width, height): (u32, Option<u32>)| format!("{width}x{}", height.unwrap_or(width));
        vec![
            ("`eye`", words(self.eye)),
            ("`look_at`", words(self.look_at)),
            ("`probe`", if self.probe.is_empty() { "none".to_owned() } else { self.probe.join(",") }),
            ("`face`", self.face.name().to_owned()),
            ("`up`", words(self.up)),
            ("`fov`", self.fov.to_string()),
            ("`views`", self.views.to_string()),
            ("`baseline`", words(self.baseline)),
            ("`view_cone`", words(self.view_cone)),
            ("`rows`", self.rows.to_string()),
            ("`grid`", word_of(GRID_ORDERS, &self.grid).to_owned()),
            ("`baseline_y`", words(self.baseline_y)),
            ("`focus`", words(self.focus)),
            ("`size`", words(self.size.map(pixels))),
            ("`aspect`", words(self.aspect)),
            ("`quilt`", words(self.quilt)),
            ("`samples`", self.samples.to_string()),
            ("`frames`", words(self.frames.frames)),
            ("`fps`", self.fps.to_string()),
            ("`acquire`", word_of(ACQUISITIONS, &self.acquire).to_owned()),
            ("`layers`", self.layers.to_string()),
            ("`culling`", word_of(CULLINGS, &self.culling).to_owned()),
            ("`max_sources`", self.max_sources.to_string()),
            ("`ao_rays`", self.ao_rays.to_string()),
            ("`shadows`", word_of(SHADOWS, &self.shadows).to_owned()),
            ("`subdivide`", self.subdivide.to_string()),
            ("`splits`", self.splits.to_string()),
            ("`holes`", self.holes.map_or("the default", |holes| word_of(HOLES, &holes)).to_owned()),
            ("`view_range`", words(self.view_range.map(|(first, last)| format!("{first}-{last}")))),
            ("`brute_force`", switch(self.brute_force)),
            ("`rasterize`", switch(self.rasterize)),
        ]
    }

    /// Fails if an option does not apply to the input.
    pub(super) fn check(&self) -> Result<()> {
        let total = u64::from(self.views) * u64::from(self.rows);
        if total > u64::from(MAX_VIEWS) {
            return refuse(format!(
                "--views {} and --rows {}: {total} views, at most {MAX_VIEWS} are possible",
                self.views, self.rows
            ));
        }
        if self.resume && self.output.is_none() {
            return refuse("--resume needs --output");
        }
        if !self.probe.is_empty() && self.rows > 1 {
            return refuse("--rows needs a scene or container: images of probes on a line make one row");
        }
        Ok(())
    }

    /// Returns the rows of views.
    pub(super) fn grid_of(&self, views: OutputViews) -> GridViews {
        GridViews::new(views, self.rows, self.baseline_y.unwrap_or(0.0))
    }

    /// True if columns are interpolated between the outer rows.
    pub(super) fn by_columns(&self) -> bool {
        self.rows > 2 && self.grid == GridOrder::Columns && !self.brute_force
    }

    /// True if a later run can resume this one: no result depends on pictures or times of earlier views.
    pub(super) fn is_resumable(&self) -> bool {
        !self.compare && self.reduce_layers.is_none() && self.source_ms.is_none()
    }

    /// Returns the name of the rendered part of all pictures.
    pub(super) fn part(&self) -> String {
        let views = self.view_range.map_or(String::new(), |(first, last)| format!(".{first}-{last}"));
        views + &self.frames.frames.map_or(String::new(), |frames| format!(".f{frames}"))
    }

    pub(super) fn frame_count(&self) -> u64 {
        self.frames.frames.map_or(1, FrameRange::count)
    }

    pub(super) fn hierarchy(&self) -> Hierarchy {
        Hierarchy {
            stop: self.stop,
            placement: self.source_placement,
            hole_threshold_percent: self.hole_threshold,
            max_sources: self.max_sources as usize,
            time: self.source_ms.map(|ms| Duration::try_from_secs_f64(1e-3 * ms).unwrap_or(Duration::MAX)),
        }
    }

    /// Returns the output views of a scene or a container.
    pub(super) fn views_from_eye(&self) -> Result<OutputViews> {
        let (Some(eye), Some(look_at)) = (self.eye, self.look_at) else {
            return refuse("--eye and --look-at are required");
        };
        let Some(spread) = self.spread() else {
            return refuse("--baseline or --view-cone is required");
        };
        let camera = Camera::look_at(eye, look_at, self.up.unwrap_or(DVec3::Y), Lens::new(self.fov))?;
        let size = match self.size {
            Some((width, Some(height))) => [width, height],
            Some((side, None)) => [side; 2],
            None => self.quilt.and_then(QuiltLayout::view_size).unwrap_or([DEFAULT_SIZE; 2]),
        };
        if size.iter().any(|&side| side > MAX_FACE_SIZE) {
            return refuse(format!(
                "--size {}x{}: up to {MAX_FACE_SIZE} pixels a side were expected",
                size[0], size[1]
            ));
        }
        let of_pixels = f64::from(size[0]) / f64::from(size[1]);
        let of_device = || self.quilt.map_or(of_pixels, |layout| layout.aspect(size));
        let camera = camera.with_aspect(self.aspect.unwrap_or_else(of_device));
        OutputViews::new(camera, size, self.views, spread, self.focus.unwrap_or(f64::INFINITY))
    }

    /// Returns the output views between captured images.
    pub(super) fn views_between(&self, captured: &CapturedSources) -> Result<OutputViews> {
        let spread = self.spread().unwrap_or(Spread::Baseline(captured.length_m));
        let focus_m = captured.focus_m;
        if let Some(wanted_m) = self.focus.filter(|wanted_m| (wanted_m / focus_m - 1.0).abs() > SAME_FOCUS) {
            let found = if focus_m.is_finite() { format!("is {focus_m:.4} m") } else { "is infinity".to_owned() };
            return refuse(format!(
                "--focus {wanted_m}: the focus of these images {found} and cannot be changed: leave out --focus"
            ));
        }
        OutputViews::new(captured.camera, captured.size, self.views, spread, focus_m)
    }

    fn spread(&self) -> Option<Spread> {
        self.view_cone.map(Spread::Cone).or(self.baseline.map(Spread::Baseline))
    }

    /// Returns the range of views to render.
    pub(super) fn range(&self) -> Result<std::ops::Range<usize>> {
        let all = self.views * self.rows;
        match self.view_range {
            None => Ok(0..all as usize),
            Some((first, last)) if last < all => Ok(first as usize..last as usize + 1),
            Some((first, last)) => refuse(format!("--view-range {first}-{last}: the views are 0 to {}", all - 1)),
        }
    }

    /// Fails if an option is not supported on devices.
    pub(super) fn check_device(&self) -> Result<()> {
        if !self.gpu.is_on_device(self.device) {
            if self.rasterize {
                return refuse("--rasterize needs a graphics device: add --device gpu or --device auto");
            }
            return Ok(());
        }
        if self.brute_force && !self.rasterize {
            return refuse("--brute-force casts rays on the CPU: leave out --device, or add --rasterize");
        }
        if self.reduce_layers.is_some() {
            return refuse("--reduce-layers runs on the CPU only: leave out --device");
        }
        if self.memory.memory.is_some() {
            return refuse("--memory limits the CPU only, not graphics devices: leave out one of them");
        }
        Ok(())
    }

    pub(super) fn acquire_settings(&self) -> Result<AcquireSettings> {
        Ok(AcquireSettings {
            acquisition: self.acquire,
            layers: self.layers as usize,
            culling: self.culling,
            hierarchy: self.hierarchy(),
            ..AcquireSettings::new(SamplePattern::new(self.samples)?)
        })
    }

    pub(super) fn settings(&self, plan: Plan, has_scene: bool) -> Result<Settings> {
        let acquire = self.acquire_settings()?;
        let coalesce = match self.coalesce_depth {
            Some(metres) => Coalescing::Depth(metres),
            None if self.coalesce > 0.0 => Coalescing::Disparity(self.coalesce),
            None => Coalescing::Off,
        };
        let interpolate = InterpolateSettings { coalesce, splits: self.splits as usize };
        let usual = if has_scene { HoleFilling::Trace } else { HoleFilling::Nearest };
        let holes = self.holes.unwrap_or(usual);
        if holes == HoleFilling::Trace && !has_scene {
            return refuse("--holes trace needs a scene: use nearest or blank for images");
        }
        let Plan { at_once, storage, .. } = plan;
        Ok(Settings { acquire, interpolate, holes, at_once, storage, keeps_unfilled: self.compare })
    }
}
