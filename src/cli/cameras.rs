//! `lightfold cameras IN -o OUT`: converts camera files, and exports the probes of a light field.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::capture::parse_size;
use crate::options::{AccountArgs, Choices, check_report, one_of, parse_positive, read_cameras, word_of};
use crate::{ExitStatus, GlobalArgs, outputs, refuse};
use codec::container::header::is_container;
use codec::decode::Decoder;
use codec::error::{Error, Result, counted};
use evaluate::cameras::{self, CameraFormat, FileCamera, FileCameras, ReadSettings, WriteSettings, Written};
use footage::account::Account;
use footage::dataset::manifest::{MANIFEST_NAME, Manifest};
use footage::files::{OutputFile, OutputFolder};

const FPS: f64 = 24.0;
const HEIGHT: u32 = 1080;

const FORMATS: &Choices<CameraFormat> = &[
    ("lightfold", CameraFormat::Lightfold, "Camera file of decode and render"),
    ("transforms", CameraFormat::Transforms, "nerfstudio transforms.json"),
    ("colmap", CameraFormat::Colmap, "COLMAP text model; without frame numbers"),
    ("gltf", CameraFormat::Gltf, "Binary glTF: single precision, no off-axis windows"),
    ("usd", CameraFormat::Usd, "USD text (.usda)"),
];

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold cameras film.lfold -o transforms.json\n  \
    lightfold cameras shot.usda --camera-name hero -o path.json\n  \
    lightfold cameras shot.glb --fps 25 -o transforms.json\n  \
    lightfold cameras path.json --size 1920x1080 -o colmap --format colmap\n\n\
    The format of IN is detected from its content: a container, a dataset, a camera file, a file of probes to capture \
    as written by place and interpolate --cameras-out, glTF, USD as text with its layers, a COLMAP model as text \
    or binary or a project with one in sparse/0, transforms.json and camera_path.json of nerfstudio, \
    cameras.json of Gaussian splatting, or base_cam.json of instant-ngp. Without --format, the name of OUT \
    selects the format: transforms*.json, other .json files (lightfold), .glb, .usda, or a folder (COLMAP).\n\n\
    A perspective probe becomes one camera, a cube map six cameras of 90 degrees. They show the faces unmirrored; \
    datasets store faces mirrored. A moving probe has these cameras in each frame. Picture names in transforms.json \
    and images.txt are those that render writes: lightfold render film.lfold --camera transforms.json -o \
    images/view.%04d.png. In these files, cameras without frame numbers are successive poses of one camera: the first \
    belongs to the first frame of --frames, and so on; where all pictures have numbers, these give the order. A \
    transforms.json with one angle and no size describes square pictures.\n\n\
    World coordinates are kept, in metres; units and the up axis of USD files are converted. Orthographic cameras, and \
    cameras that do not move beside others that do, are left out with a note. Distortion is of the photographs that a \
    file describes, not of rendered pictures: it is left out with a note. Clip planes are written but not read. Times \
    of glTF and USD become frames by --fps; without it a USD time code is a frame.")]
pub struct Args {
    /// Input: a container, a dataset, a camera file, or a file of probes to capture
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Output file or folder, - for standard output
    #[arg(long, short, value_name = "OUT")]
    pub output: PathBuf,
    /// Output format [default: by the name of OUT]
    #[arg(long, value_parser = one_of(FORMATS))]
    pub format: Option<CameraFormat>,
    /// Frames per second of glTF and USD [default: that of the container or dataset, else 24 for glTF and a frame for
    /// each time code for USD]
    #[arg(long, value_name = "FPS", value_parser = parse_positive)]
    pub fps: Option<f64>,
    /// Picture size in pixels, height or width and height, written to transforms.json and COLMAP for cameras without a
    /// size [default: 1080]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    pub size: Option<(u32, Option<u32>)>,
    /// Camera of IN, by its name or that of its picture [default: all that move, else all]
    #[arg(long, value_name = "NAME")]
    pub camera_name: Option<String>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub account: AccountArgs,
}

#[derive(Serialize)]
struct Report {
    cameras: usize,
    format: &'static str,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let Args { input, output, .. } = args;
    let Some(format) = args.format.or_else(|| CameraFormat::of_name(output)) else {
        return refuse(format!(
            "{}: the format cannot be told from the name: set --format, or use a name ending in .json, .glb or .usda",
            output.display()
        ));
    };
    let to_stdout = output == Path::new("-");
    if to_stdout && (args.format.is_none() || format == CameraFormat::Colmap) {
        return refuse("-o -: standard output needs --format with a format other than colmap");
    }
    check_report(output, args.json)?;
    outputs::check(&[("-o", output.clone())], &[input])?;
    let (FileCameras { cameras, notes }, fps) = read(args)?;
    let mut account = Account { left_out: notes, ..Account::default() };
    let name = |(at, camera): (usize, &FileCamera)| match camera.name.as_str() {
        "" => format!("camera {at}"),
        name => name.to_owned(),
    };
    account.add("camera", cameras.iter().enumerate().map(name));
    let settings = WriteSettings { size: args.size.unwrap_or((HEIGHT, None)), fps };
    let count = cameras.len();
    match cameras::write(&cameras, format, &settings).map_err(|error| error.in_file(output))? {
        Written::File(bytes) => {
            let mut file = OutputFile::create(output)?;
            file.write_all(&bytes).map_err(|error| Error::io(output, error))?;
            file.commit()?;
        }
        Written::Folder(files) => {
            let folder = OutputFolder::create(output)?;
            for (name, text) in files {
                folder.write_bytes(Path::new(&name), text.as_ref())?;
            }
            folder.commit()?;
        }
    }
    let report = Report { cameras: count, format: word_of(FORMATS, &format) };
    let text = || format!("{}: {}", output.display(), counted(count as u64, "camera"));
    args.account.report((&account, args.json), report, text, global)?;
    Ok(ExitStatus::Passed)
}

/// Returns the cameras of the input, and the frames per second.
fn read(args: &Args) -> Result<(FileCameras, f64)> {
    let input = &args.input;
    let fps_of_field = match input.is_dir() {
        false if input != Path::new("-") && is_container(input)? => Some(Decoder::open(input)?.reader().index().fps),
        _ => dataset_fps(input)?,
    };
    let fps = args.fps.or(fps_of_field);
    let size = args.size.and_then(|(width, height)| Some([width, height?]));
    let cameras = read_cameras(input, ReadSettings { fps, size }, args.camera_name.as_deref())?;
    Ok((cameras, fps.unwrap_or(FPS)))
}

/// Returns the frames per second of a dataset. `None` if the input is not a dataset.
fn dataset_fps(input: &Path) -> Result<Option<f64>> {
    let is_manifest = input.file_name().is_some_and(|name| name == MANIFEST_NAME);
    if is_manifest || input.join(MANIFEST_NAME).is_file() {
        return Ok(Some(Manifest::read(input)?.fps));
    }
    let may_be_one = input.is_file() && input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    Ok(if may_be_one { Manifest::read(input).ok().map(|manifest| manifest.fps) } else { None })
}
