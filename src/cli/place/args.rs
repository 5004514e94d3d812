//! Arguments of `place`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::cli::options::{self, EffortArg, parse_not_negative, parse_positive};
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::image::sequence::FrameRange;
use crate::placement::search::{DEFAULT_MOST_CAMERAS, DEFAULT_UNTIL, LEAST_THETA_DEG};
use crate::placement::{CandidateKind, Lighting, Settings, Stop};
use crate::scene::Scene;
use crate::scene::capture::frames_of_animation;
use crate::scene::footage::FPS;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    lightfold place courtyard --region=-0.5,1.2,-0.5,0.5,1.8,0.5 -o cameras.json\n  \
    lightfold place dragon.glb --region=-2,-2,-2,2,2,2 --cameras 8 -o cameras.json --json\n  \
    lightfold place room.glb --region walk.obj --lighting specular --theta 30 -o cameras.json\n  \
    lightfold place dragon.glb --region sphere:0,0,0,2 --plot charts --csv rows.csv -o cameras.json\n  \
    lightfold place room.glb --region=-4,1,-1,4,2,1 --start cameras.json --cameras 4 -o more.json\n  \
    lightfold place room.glb --region=-4,1,-1,4,2,1 --uniform 16 -o even.json\n\n\
    Cameras are placed one after the other, each where it adds most to what is seen and not seen well already. Within the \
    viewer distance, which is that of a surface from the region and at least --min-distance, a camera sees as well as any \
    viewer; with each metre beyond, it is worth less by the factor exp(-K). Candidates lie in the region, outside of solids.\n\n\
    Coverage is, for diffuse surfaces, the part of all surface that cameras see; for specular ones, the part of all directions \
    above the surface that are less than --theta degrees from a camera that sees it. 'Reachable' is what all candidates \
    together cover: the rest is hidden from everywhere in the region. 'Within' counts only what is seen from within the viewer \
    distance (or from a quarter of it beyond, and at least 5% of the region's diagonal: without that, only a camera at the one \
    place nearest to a surface would count), 'weighted' counts the rest at its reduced worth, as in figure 3 of the paper. Both \
    are parts of the surface, so they stand beside diffuse coverage only.")]
pub struct Args {
    /// The scene: a glTF, GLB or OBJ file, or the name of a built-in one, such as courtyard
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Where viewers may be: x0,y0,z0,x1,y1,z1 (two corners, metres), sphere:x,y,z,r, or a file with a closed mesh. May be
    /// given more than once, for the union
    #[arg(long, value_name = "BOX|SPHERE|MESH", required = true, allow_hyphen_values = true)]
    pub region: Vec<String>,
    /// The file of cameras to write, - for standard output
    #[arg(long, short, value_name = "CAMERAS.json")]
    pub output: PathBuf,
    /// Place so many cameras; fewer only where no further one adds anything [default: until --until, and no more than 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub cameras: Option<u32>,
    /// Stop where the next camera adds no more than this part of the surface, such as 0.005 or 0.5% [default: 0.1%, or 0 with
    /// --cameras]
    #[arg(long, value_name = "GAIN", value_parser = options::parse_share)]
    pub until: Option<f64>,
    /// Place N cameras evenly in the open part of the region (Hammersley points) instead of searching, and report their
    /// coverage
    #[arg(long, alias = "spread", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), conflicts_with_all = ["cameras", "until"])]
    pub uniform: Option<u32>,
    /// Go on behind the cameras of this file (or a lightfield.json): they count, and are written first; --cameras 0 only
    /// measures them
    #[arg(long, value_name = "CAMERAS.json")]
    pub start: Option<PathBuf>,
    /// Whether surfaces look alike from everywhere, or each side has to be seen
    #[arg(long, value_enum, default_value_t = LightingArg::Diffuse)]
    pub lighting: LightingArg,
    /// With specular lighting: cameras less than so many degrees apart, seen from a surface, see the same there [default: 50]. Below 1
    /// degree nearly every camera is new everywhere, and --cameras has to say how many
    #[arg(long, value_name = "DEGREES", value_parser = parse_theta)]
    pub theta: Option<f64>,
    /// The least distance in metres that a viewer has from a surface [default: 5% of the region's diagonal]
    #[arg(long, value_name = "Z", value_parser = parse_not_negative)]
    pub min_distance: Option<f64>,
    /// How much less a camera is worth with each metre beyond the viewer distance, exp(-K) [default: 4 divided by the region's
    /// diagonal]
    #[arg(long, value_name = "K", value_parser = parse_not_negative)]
    pub k: Option<f64>,
    /// More values of K to place for, for a chart of --plot and rows of --csv: coverage by camera, a line for each
    #[arg(long, value_name = "K,K,..", value_delimiter = ',', value_parser = parse_not_negative)]
    pub compare_k: Vec<f64>,
    /// Which animation of the file is played, by its name [default: the first]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// The frames that the cameras are to serve, such as 0-95 [default: all of the animation]
    #[arg(long, value_name = "A-B", value_parser = options::parse_frames)]
    pub frames: Option<FrameRange>,
    /// Frames a second [default: 24]
    #[arg(long, value_name = "N", value_parser = parse_positive)]
    pub fps: Option<f64>,
    /// How hard to look: 256 candidates and 2048 points on surfaces, 1024 and 8192, or 4096 and 32768 with the plain search;
    /// of an animation, up to 4, 16 or 64 frames
    #[arg(long, value_enum, default_value_t = EffortArg::Normal)]
    pub effort: EffortArg,
    /// Candidates [default: as --effort says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub candidates: Option<u32>,
    /// Points on surfaces, over all frames that are looked at [default: as --effort says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub surface_samples: Option<u32>,
    /// Candidates on a uniform grid and nowhere else, as in the paper
    #[arg(long)]
    pub grid: bool,
    /// Folder for charts: coverage by camera within and beyond the viewer distance, and how both kinds of lighting converge
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// File for coverage by camera, of both kinds of lighting on the same candidates
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// `--lighting`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LightingArg {
    /// Surfaces look alike from everywhere: one camera is enough for each
    Diffuse,
    /// Surfaces mirror or shine: they are to be seen from each side
    Specular,
}

/// θ where nobody says, as in the paper's figure 4.
const DEFAULT_THETA_DEG: f64 = 50.0;

fn parse_theta(text: &str) -> Result<f64, String> {
    let degrees = options::parse_number(text)?;
    if (0.0..=180.0).contains(&degrees) {
        Ok(degrees)
    } else {
        Err(format!("'{text}': 0 to 180 degrees were expected"))
    }
}

impl Args {
    pub(super) fn lighting(&self) -> Lighting {
        match self.lighting {
            LightingArg::Diffuse => Lighting::Diffuse,
            LightingArg::Specular => Lighting::Specular { theta_deg: self.theta.unwrap_or(DEFAULT_THETA_DEG) },
        }
    }

    /// The lighting that is not asked for, for comparison.
    pub(super) fn other_lighting(&self) -> Lighting {
        match self.lighting {
            LightingArg::Diffuse => Lighting::Specular { theta_deg: DEFAULT_THETA_DEG },
            LightingArg::Specular => Lighting::Diffuse,
        }
    }

    pub(super) fn effort(&self) -> Effort {
        self.effort.into()
    }

    pub(super) fn settings(&self) -> Settings {
        Settings {
            rate_per_m: self.k,
            min_distance_m: self.min_distance,
            effort: self.effort(),
            kind: if self.grid { CandidateKind::Grid } else { CandidateKind::Refined },
            candidates: self.candidates.map(|count| count as usize),
            surface_samples: self.surface_samples.map(|count| count as usize),
        }
    }

    /// When a search ends that was told no number.
    pub(super) fn is_endless(&self) -> bool {
        self.cameras.is_none() && self.uniform.is_none()
    }

    pub(super) fn stop(&self) -> Stop {
        if self.uniform.is_some() {
            return Stop { cameras: Some(0), until: 0.0 };
        }
        let until = self.until.unwrap_or(if self.cameras.is_some() { 0.0 } else { DEFAULT_UNTIL });
        Stop { cameras: Some(self.cameras.map_or(DEFAULT_MOST_CAMERAS, |count| count as usize)), until }
    }

    /// Refuses what makes no sense together.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |text: &str| Err(Error::Usage(text.into()));
        if self.json && self.output == Path::new("-") {
            return wrong("--json and -o - would both write to standard output; name a file");
        }
        if self.theta.is_some() && self.lighting == LightingArg::Diffuse {
            return wrong("--theta means nothing for diffuse surfaces; add --lighting specular");
        }
        let is_small = matches!(self.lighting(), Lighting::Specular { theta_deg } if theta_deg < LEAST_THETA_DEG);
        if is_small && (self.is_endless() || self.until.is_some()) {
            return wrong(
                "with --theta below 1 degree hardly any camera is ever redundant, and gains hardly shrink, so that a search would \
                 not end; say how many by --cameras alone",
            );
        }
        if !self.compare_k.is_empty() && self.plot.is_none() && self.csv.is_none() {
            return wrong("--compare-k is for a chart and for rows; add --plot DIR or --csv FILE.csv");
        }
        if self.cameras == Some(0) && self.start.is_none() {
            return wrong("--cameras 0 measures the cameras of a file; name it by --start");
        }
        Ok(())
    }

    pub(super) fn fps(&self) -> f64 {
        self.fps.unwrap_or(FPS)
    }

    /// All frames that cameras serve.
    pub(super) fn frames(&self, scene: &Scene) -> Result<[u32; 2]> {
        let range = self.frames.map_or_else(|| frames_of_animation(scene.duration_s(), self.fps()), Ok)?;
        Ok([range.first, range.last])
    }
}
