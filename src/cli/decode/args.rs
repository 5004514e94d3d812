//! Arguments of `lightfold decode`.

use std::path::PathBuf;

use crate::device::{DEVICES, GpuArgs};
use crate::options::{CameraArgs, Choices, FrameArgs, LIGHT_SPACES, MemoryArgs, SelectionArgs, StreamArgs, one_of};
use footage::export::FileFormat;
use footage::image_files::ColorSpace;
use gpu::device::DeviceChoice;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold decode film.lfold -o frames\n  \
    lightfold decode film.lfold --probe 00 --face px --stream depth -o depth.%04d.exr\n  \
    lightfold decode film.lfold --frames 10-19 --format png -o look\n  \
    lightfold decode film.lfold --probe 00 --face px --stream color -o - | ffmpeg -i - px.mp4\n  \
    lightfold decode film.lfold --frames 12 -o frame.ply\n  \
    lightfold decode film.lfold --null --repeat 9 --json\n  \
    lightfold decode film.lfold --eye 0,1.5,0 --look-at 2,1.5,0 --fov 90 --null --stats\n  \
    lightfold decode film.lfold --camera cam.json -o seen\n  \
    lightfold decode film.lfold --device gpu --null\n  \
    lightfold decode film.lfold --verify\n  \
    lightfold decode damaged.lfold --keep-going -o rescued\n\n\
    A name that ends in .ply is a point cloud of a frame: binary, x y z in metres of the world and sRGB codes, a point for each pixel of\n\
    the selected probes and faces that has a surface.\n\n\
    With cameras, only the tiles and cells that they see are decoded; in image files all others are black, or at distance 0.\n\
    A file of cameras holds {\"cameras\": [{\"eye\": [0, 1.5, 0], \"look_at\": [2, 1.5, 0], \"fov_y_deg\": 90}]}.\n\
    A camera may also have \"up\", \"aspect\", \"off_axis\" (middle of the picture at distance 1, to the right and down),\n\
    \"near_m\", \"far_m\", \"frames\" ([first, last]), and an\n\
    \"orientation\" (a quaternion x, y, z, w) in place of \"look_at\" and \"up\".")]
pub struct Args {
    /// The container, - for standard input
    #[arg(value_name = "IN.lfold", required_unless_present = "list_devices")]
    pub input: Option<PathBuf>,
    /// Folder to write a dataset into; a pattern such as depth.%04d.exr, or - for standard output, for a single stream; a point cloud
    /// of a frame, or a pattern of them, that ends in .ply
    #[arg(long, short, value_name = "DIR", required_unless_present_any = ["null", "verify", "list_devices"])]
    pub output: Option<PathBuf>,
    /// Decode without writing, to measure decoding time
    #[arg(long, conflicts_with = "output")]
    pub null: bool,
    /// Decode once to warm up, then N times; report each time and their median
    #[arg(long, value_name = "N", requires = "null", conflicts_with_all = ["output", "verify"],
        value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,
    /// Decoding device; the images do not depend on it [default: cpu]
    #[arg(long, value_parser = one_of(DEVICES))]
    pub device: Option<DeviceChoice>,
    /// Decode on a graphics device and on the CPU and compare; exit code 1 if a word differs
    #[arg(long, conflicts_with = "output")]
    pub verify: bool,
    /// Decode every intact image of a damaged container, list the damaged chunks, and exit with code 2. Colour beside damaged alpha
    /// is left out with it; --stream color writes it alone
    #[arg(long, conflicts_with_all = ["verify", "repeat"])]
    pub keep_going: bool,
    #[command(flatten)]
    pub gpu: GpuArgs,
    #[command(flatten)]
    pub selection: SelectionArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Image format. PNG stores 8-bit colour and 16-bit log codes of depth without loss; colour beside alpha is divided by it
    /// and rounded to 8 bits, and colour of half floats is clipped to 8-bit sRGB. Its depth codes are not part of lightfield.json; lightfold inspect prints the range that turns them into metres
    #[arg(long, value_parser = one_of(FORMATS), default_value = "exr")]
    pub format: FileFormat,
    /// Convert colour of EXR files to linear light of this space [default: that of the container, which is the source's]. PNG is always
    /// converted to the primaries of sRGB
    #[arg(long, value_parser = one_of(LIGHT_SPACES))]
    pub color_space: Option<ColorSpace>,
    #[command(flatten)]
    pub stream: StreamArgs,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub cameras: CameraArgs,
}

const FORMATS: &Choices<FileFormat> = &[("exr", FileFormat::Exr, "OpenEXR"), ("png", FileFormat::Png, "PNG")];
