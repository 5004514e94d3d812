//! Arguments of `capture`.

use std::path::PathBuf;

use glam::DVec3;

use crate::options::{self, AccountArgs, Choices, FrameArgs, one_of, parse_point, parse_shard};
use codec::image::{DepthKind, Projection};
use footage::dataset::manifest::parse_frame_rate;
use footage::encode::Shard;
use scene::Pass;

#[derive(Debug, clap::Args)]
#[command(
    group(clap::ArgGroup::new("from").required(true).args(["cameras", "position"])),
    after_help = "Examples:\n  lightfold capture sponza.glb --cameras cameras.json --size 256 -o cap\n  \
    lightfold capture mirrors --position 0,1.5,0 --frames 0-23 --samples 4 --aov depth,material -o cap\n  \
    lightfold capture scene.gltf --cameras old/lightfield.json --aov depth,normal,material -o cap\n  \
    lightfold capture scene.obj --position 0,1.5,0 --projection equirect --size 2048 -o pano\n  \
    lightfold capture scene.glb --cameras views.json --size 1280x720 -o truth\n  \
    lightfold capture scene.glb --position 0,1,3 --look-at 0,1,0 --fov 50 -o view\n  \
    lightfold capture scene.glb --cameras cameras.json --resume -o cap --json\n  \
    lightfold capture scene.glb --cameras cameras.json --shard 3/8 -o cap\n\n\
    SCENE is a file (glTF, GLB, OBJ) or built in: courtyard, interior, object, mirrors, cornell, fence, street. Files that \
    a scene refers to (buffers, materials, textures) are only read from its folder and the folders below it, and from \
    below its parent by a name that begins with ../; symbolic links are resolved first. A file that is not where the \
    scene says is searched there by its name, in any case, with a note. Textures are PNG, JPEG, BMP, TGA, WebP or KTX2.\n\n\
    --cameras reads the files that `place` and `interpolate --cameras-out` write: {\"lightfold_cameras\": 1, \
    \"cameras\": [{\"position\": [0, 1.5, 0]}]}, in which a camera may have a \"name\", an \"orientation\" (a \
    quaternion x, y, z, w), \"fov_y_deg\", \"aspect\" (width over height), \"shift\" (offset of the image centre from \
    the viewing axis, in widths and heights) and \"frames\" ([first, last]). It also reads the probes of a \
    lightfield.json, and camera files of `decode --camera`, which capture perspective images, such as ground truth \
    for rendered views.\n\n\
    A scene without lights gets a sun at an elevation of 51 degrees towards (0.5, 0.78, 0.38), radiance 1.75, 1.6, 1.35 (of a \
    white surface facing it), and ambient light of 0.3, 0.36, 0.46. Scenes from files have a sky of 0.5, 0.66, 0.86 at the \
    horizon and 0.16, 0.32, 0.68 at the zenith.\n\n\
    Colour is the mean of a pixel's samples. Where it exceeds 1, as in all built-in scenes, encode keeps it as half floats \
    (\"keep\": \"hdr\" in the manifest). Other outputs are sampled by one ray through the pixel centre, \
    unfiltered. The result does not depend on the number of threads.\n\n\
    An interrupted capture keeps its images beside DIR. The same command with --resume continues it and writes the \
    same bytes. An existing dataset in DIR is replaced only once the new one is complete.\n\n\
    With --shard I/N, each of N machines captures a share of the images, divided by probe, then by frame, into one \
    new folder. The images of a shard appear in DIR once all of them are captured, together with the manifest of all \
    images. When all N shards have run, in any order, DIR has the same files as \
    after a single run. Until then, commands that need a missing image end with exit code 75."
)]
pub struct Args {
    /// Scene file (glTF, GLB, OBJ) or built-in scene
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Output folder of the dataset
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Camera file or lightfield.json, - for standard input
    #[arg(long, value_name = "FILE")]
    pub cameras: Option<PathBuf>,
    /// Position of a camera in metres; repeatable
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub position: Vec<DVec3>,
    /// Capture a perspective image from each --position towards this point in metres, with +Y up; see --fov
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "position")]
    pub look_at: Option<DVec3>,
    /// Name of the animation to play, or all that do not move the same nodes [default: all]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Capture one shard of the images, such as 3/8, into a folder that all shards share
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Frames per second
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = parse_fps)]
    pub fps: f64,
    /// Image size in pixels: side of a cube face, width of a panorama or height of a perspective image; or width and
    /// height [default: 512, for panoramas 2048]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    pub size: Option<(u32, Option<u32>)>,
    /// Projection [default: cube; perspective with --look-at or a camera file of decode]
    #[arg(long, value_parser = one_of(PROJECTIONS))]
    pub projection: Option<Projection>,
    /// Vertical field of view in degrees, for perspective cameras without one
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Colour samples per pixel: on a grid if a square number, else Hammersley points
    #[arg(long, value_name = "N", default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(scene::capture::MAX_SAMPLES)))]
    pub samples: u32,
    /// Outputs besides colour: depth, normal, material, or none
    #[arg(long, value_parser = one_of(AOVS), value_name = "KIND", value_delimiter = ',', default_value = "depth")]
    pub aov: Vec<OutputPass>,
    /// Do not capture colour
    #[arg(long)]
    pub no_color: bool,
    /// Kind of depth
    #[arg(long, value_parser = one_of(DEPTHS), default_value = "distance")]
    pub depth: DepthKind,
    /// Distance in metres beyond which surfaces are background, except in colour [default: unlimited]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub far: Option<f64>,
    /// Resume an interrupted capture into this folder with the same options; start a new one if there is none
    #[arg(long)]
    pub resume: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub account: AccountArgs,
}

const PROJECTIONS: &Choices<Projection> = &[
    ("cube", Projection::Cubemap, "Six faces of an OpenGL cube map"),
    ("equirect", Projection::Equirect, "Panorama: longitude across, latitude down"),
    (
        "perspective",
        Projection::Perspective,
        "Pinhole camera that looks along -Z with +Y up, rotated by its orientation",
    ),
];

/// An output besides colour, or none. An alias, because clap treats an `Option` as an option that may be absent.
type OutputPass = Option<Pass>;

const AOVS: &Choices<OutputPass> = &[
    ("depth", Some(Pass::Depth), "Distance or planar depth in metres; see --depth"),
    ("normal", Some(Pass::Normal), "Shading normals in world axes"),
    ("material", Some(Pass::Material), "Weights of reflection and refraction, index of refraction"),
    ("none", None, "Colour only"),
];

const DEPTHS: &Choices<DepthKind> = &[
    ("distance", DepthKind::Distance, "From the camera along the ray"),
    ("planar", DepthKind::Planar, "Along the viewing axis"),
];

pub fn parse_size(text: &str) -> Result<(u32, Option<u32>), String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|side| *side > 0);
    let size = match text.split_once('x') {
        Some((width, height)) => side(width).zip(side(height)).map(|(width, height)| (width, Some(height))),
        None => side(text).map(|side| (side, None)),
    };
    size.ok_or_else(|| format!("'{text}' is neither a number of pixels such as 256 nor WxH such as 640x480"))
}

pub fn parse_fps(text: &str) -> Result<f64, String> {
    parse_frame_rate(text).ok_or_else(|| {
        format!("'{text}': frames per second above 0 were expected, a number or a ratio such as 24000/1001")
    })
}

pub fn parse_metres(text: &str) -> Result<f64, String> {
    options::parse_positive(text).map_err(|_| format!("'{text}': a number of metres above 0 was expected"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_numbers_are_parsed() {
        assert_eq!(parse_size("256"), Ok((256, None)));
        assert_eq!(parse_size("640x480"), Ok((640, Some(480))));
        for text in ["", "0", "-1", "4x", "4x0", "x4", "4x4x4", "99999999999", "a"] {
            assert!(parse_size(text).unwrap_err().contains("640x480"), "{text}");
        }
        assert_eq!(parse_fps("29.97"), Ok(29.97));
        assert_eq!(parse_fps("24000/1001"), Ok(24000.0 / 1001.0));
        for text in ["", "0", "-1", "inf", "nan", "x"] {
            assert!(parse_fps(text).is_err() && parse_metres(text).is_err(), "{text}");
        }
    }

    /// The help states the default light of scenes that have no lights.
    #[test]
    fn the_help_has_the_default_light() {
        use clap::Args as _;
        let help = Args::augment_args(clap::Command::new("capture")).get_after_help().unwrap().to_string();
        let light = scene::Light::default();
        let sun = light.suns[0];
        let elevation = format!("{:.0} degrees", sun.direction.y.asin().to_degrees());
        assert!(help.contains(&elevation), "{elevation}");
        for figures in [sun.radiance, light.sky.horizon, light.sky.zenith, light.sky.ambient] {
            let figures = figures.to_array().map(|value| value.to_string()).join(", ");
            assert!(help.contains(&figures), "{figures}");
        }
    }
}
