//! Arguments of `place`.

use std::path::PathBuf;

use crate::options::{self, Choices, EFFORTS, check_report, one_of, parse_not_negative, parse_positive};
use crate::refuse;
use codec::effort::Effort;
use codec::error::Result;
use codec::image::sequence::FrameRange;
use scene::Scene;
use scene::capture::frames_of_animation;
use scene::footage_plan::FPS;
use scene::placement::search::{DEFAULT_MAX_CAMERAS, DEFAULT_UNTIL, MIN_THETA_DEG};
use scene::placement::{CandidateKind, Lighting, Settings, Stop};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    lightfold place courtyard --region=-0.5,1.2,-0.5,0.5,1.8,0.5 -o cameras.json\n  \
    lightfold place dragon.glb --region=-2,-2,-2,2,2,2 --cameras 8 -o cameras.json --json\n  \
    lightfold place room.glb --region walk.obj --lighting specular --theta 30 -o cameras.json\n  \
    lightfold place dragon.glb --region sphere:0,0,0,2 --plot charts --csv rows.csv -o cameras.json\n  \
    lightfold place room.glb --region=-4,1,-1,4,2,1 --start cameras.json --cameras 4 -o more.json\n  \
    lightfold place room.glb --region=-4,1,-1,4,2,1 --uniform 16 -o even.json\n\n\
    Greedy search: each camera is placed at the candidate that increases coverage most. The viewer distance of a \
    surface is its distance \
    from the region, at least --min-distance. Up to that distance a camera has full suitability for the surface; \
    beyond it, suitability decays by exp(-K) per metre. Candidates lie in the region, outside of solid objects.\n\n\
    Coverage: for diffuse surfaces the fraction of area that is visible; for specular surfaces the fraction of \
    directions above them within --theta degrees of a camera. Reachable: coverage of all candidates. Within: area \
    visible from within \
    the viewer distance, with a tolerance of 25% and at least 5% of the region's diagonal. Weighted: area weighted by \
    suitability (CALF figure 3). The last two are reported for diffuse surfaces only.")]
pub struct Args {
    /// Scene file (glTF, GLB, OBJ) or built-in scene such as courtyard
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Viewing region: x0,y0,z0,x1,y1,z1 (two corners in metres), sphere:x,y,z,r, or a file with a closed mesh;
    /// repeatable, for a union
    #[arg(long, value_name = "BOX|SPHERE|MESH", required = true, allow_hyphen_values = true)]
    pub region: Vec<String>,
    /// Output camera file, - for standard output
    #[arg(long, short, value_name = "CAMERAS.json")]
    pub output: PathBuf,
    /// Maximum number of cameras; fewer are placed if no further one adds coverage [default: limited by --until, at
    /// most 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub cameras: Option<u32>,
    /// Stop when the next camera adds at most this fraction of coverage, such as 0.005 or 0.5% [default: 0.1%, or 0
    /// with --cameras]
    #[arg(long, value_name = "GAIN", value_parser = options::parse_share)]
    pub until: Option<f64>,
    /// Place N cameras evenly in the free part of the region (Hammersley points) instead of searching, and report their
    /// coverage
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), conflicts_with_all = ["cameras", "until"])]
    pub uniform: Option<u32>,
    /// Start with the cameras of this file or lightfield.json, and write them first; --cameras 0 only measures their
    /// coverage
    #[arg(long, value_name = "CAMERAS.json")]
    pub start: Option<PathBuf>,
    /// Reflection of the surfaces
    #[arg(long, value_parser = one_of(LIGHTINGS), default_value = "diffuse")]
    pub lighting: Lighting,
    /// Angle between directions that see the same reflection, for specular lighting [default: 50]; angles below 1 need
    /// --cameras
    #[arg(long, value_name = "DEGREES", value_parser = parse_theta)]
    pub theta: Option<f64>,
    /// Minimum distance of viewers from surfaces in metres [default: 5% of the region's diagonal]
    #[arg(long, value_name = "Z", value_parser = parse_not_negative)]
    pub min_distance: Option<f64>,
    /// Decay rate K of suitability, exp(-K) per metre beyond the viewer distance [default: 4 divided by the region's
    /// diagonal]
    #[arg(long, value_name = "K", value_parser = parse_not_negative)]
    pub k: Option<f64>,
    /// Additional values of K to compare in a chart of --plot and rows of --csv
    #[arg(long, value_name = "K,K,..", value_delimiter = ',', value_parser = parse_not_negative)]
    pub compare_k: Vec<f64>,
    /// Name of the animation to play, or all that do not move the same nodes [default: all]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Frames to cover, such as 0-95 [default: the whole animation]
    #[arg(long, value_name = "A-B")]
    pub frames: Option<FrameRange>,
    /// Frames per second [default: 24]
    #[arg(long, value_name = "N", value_parser = parse_positive)]
    pub fps: Option<f64>,
    /// Search effort: 256 candidates and 2048 surface samples, 1024 and 8192, or 4096 and 32768 with plain greedy search; up
    /// to 4, 16 or 64 frames of an animation
    #[arg(long, value_parser = one_of(EFFORTS), default_value = "normal")]
    pub effort: Effort,
    /// Number of candidates [default: by --effort]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub candidates: Option<u32>,
    /// Number of surface samples over all frames [default: by --effort]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub surface_samples: Option<u32>,
    /// Use candidates on a uniform grid only, without refinement (CALF 4)
    #[arg(long)]
    pub grid: bool,
    /// Write charts into this folder: coverage within and beyond the viewer distance, convergence for both kinds of
    /// lighting
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Write coverage by number of cameras to this CSV file, for both kinds of lighting
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Default θ (CALF figure 4).
const DEFAULT_THETA_DEG: f64 = 50.0;
/// `specular` without `--theta`.
pub const SPECULAR: Lighting = Lighting::Specular { theta_deg: DEFAULT_THETA_DEG };

const LIGHTINGS: &Choices<Lighting> = &[
    ("diffuse", Lighting::Diffuse, "Surfaces look equal from all directions: one camera covers a surface"),
    ("specular", SPECULAR, "Glossy or mirroring surfaces: coverage counts directions above a surface"),
];

fn parse_theta(text: &str) -> Result<f64, String> {
    options::parse_number_where(text, |degrees| (0.0..=180.0).contains(&degrees), "0 to 180 degrees were expected")
}

impl Args {
    pub(super) fn lighting(&self) -> Lighting {
        match (self.lighting, self.theta) {
            (Lighting::Specular { .. }, Some(theta_deg)) => Lighting::Specular { theta_deg },
            (lighting, _) => lighting,
        }
    }

    pub(super) fn settings(&self) -> Settings {
        Settings {
            rate_per_m: self.k,
            min_distance_m: self.min_distance,
            effort: self.effort,
            kind: if self.grid { CandidateKind::Grid } else { CandidateKind::Refined },
            candidates: self.candidates.map(|count| count as usize),
            surface_samples: self.surface_samples.map(|count| count as usize),
        }
    }

    pub(super) fn is_endless(&self) -> bool {
        self.cameras.is_none() && self.uniform.is_none()
    }

    pub(super) fn stop(&self) -> Stop {
        if self.uniform.is_some() {
            return Stop { cameras: Some(0), until: 0.0 };
        }
        let until = self.until.unwrap_or(if self.cameras.is_some() { 0.0 } else { DEFAULT_UNTIL });
        Stop { cameras: Some(self.cameras.map_or(DEFAULT_MAX_CAMERAS, |count| count as usize)), until }
    }

    pub(super) fn check(&self) -> Result<()> {
        check_report(&self.output, self.json)?;
        if self.theta.is_some() && self.lighting == Lighting::Diffuse {
            return refuse("--theta needs --lighting specular");
        }
        let is_small = matches!(self.lighting(), Lighting::Specular { theta_deg } if theta_deg < MIN_THETA_DEG);
        if is_small && (self.is_endless() || self.until.is_some()) {
            return refuse(
                "--theta below 1 degree needs --cameras without --until: otherwise the search would hardly end",
            );
        }
        if !self.compare_k.is_empty() && self.plot.is_none() && self.csv.is_none() {
            return refuse("--compare-k needs --plot DIR or --csv FILE.csv");
        }
        if self.cameras == Some(0) && self.start.is_none() {
            return refuse("--cameras 0 needs --start");
        }
        Ok(())
    }

    pub(super) fn fps(&self) -> f64 {
        self.fps.unwrap_or(FPS)
    }

    pub(super) fn frames(&self, scene: &Scene) -> Result<[u32; 2]> {
        let range = self.frames.map_or_else(|| frames_of_animation(scene.duration_s(), self.fps()), Ok)?;
        Ok([range.first, range.last])
    }
}
