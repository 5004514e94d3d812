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
    A name that ends in .ply writes a point cloud of a frame: binary, x y z in world metres and sRGB codes, one point \
    for each pixel of \
    the selected probes and faces that shows a surface.\n\n\
    With cameras, only visible tiles and cells are decoded; in image files all others are black, or at distance 0.\n\
    A camera file contains {\"cameras\": [{\"eye\": [0, 1.5, 0], \"look_at\": [2, 1.5, 0], \"fov_y_deg\": 90}]}.\n\
    A camera may also have \"up\", \"aspect\", \"off_axis\" (offset of the picture centre at distance 1, to the right \
    and down),\n\
    \"near_m\", \"far_m\", \"frames\" ([first, last]), and an\n\
    \"orientation\" (a quaternion x, y, z, w) in place of \"look_at\" and \"up\".")]
pub struct Args {
    /// Input container, - for standard input
    #[arg(value_name = "IN.lfold", required_unless_present = "list_devices")]
    pub input: Option<PathBuf>,
    /// Output: a folder for a dataset; for a single stream a pattern such as depth.%04d.exr, or - for standard output;
    /// for point clouds a file or pattern ending in .ply
    #[arg(long, short, value_name = "DIR", required_unless_present_any = ["null", "verify", "list_devices"])]
    pub output: Option<PathBuf>,
    /// Decode without writing output, to measure decoding time
    #[arg(long, conflicts_with = "output")]
    pub null: bool,
    /// Decode N times after a warm-up run; report each time and the median
    #[arg(long, value_name = "N", requires = "null", conflicts_with_all = ["output", "verify"],
        value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,
    /// Decoding device; all devices decode the same images [default: cpu]
    #[arg(long, value_parser = one_of(DEVICES))]
    pub device: Option<DeviceChoice>,
    /// Decode on a graphics device and on the CPU, and compare; exit code 1 if any word differs
    #[arg(long, conflicts_with = "output")]
    pub verify: bool,
    /// Decode all intact images of a damaged container, list the damaged chunks, and exit with code 2. Colour whose
    /// alpha is damaged is skipped; --stream color decodes it without alpha
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
    /// Image format. PNG stores 8-bit colour and 16-bit log codes of depth losslessly; colour with alpha is
    /// unpremultiplied and rounded to 8 bits, and half-float colour is clipped to 8-bit sRGB. lightfield.json does not
    /// describe depth codes in PNG; lightfold inspect prints the range that converts them to metres
    #[arg(long, value_parser = one_of(FORMATS), default_value = "exr")]
    pub format: FileFormat,
    /// Colour space of EXR files: linear, with these primaries [default: that of the source]. PNG files always have
    /// sRGB primaries
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
