//! Arguments of `render`.

use std::path::{Path, PathBuf};

use super::options::{Given, MarchArgs, ProjectionArgs, TruthArgs, ViewArgs, parse_size};
use crate::device::{DEVICES, GpuArgs};
use crate::options::{CameraArgs, DisplayArgs, FrameArgs, MemoryArgs, StreamArgs, one_of, parse_shard};
use footage::encode::Shard;
use gpu::device::DeviceChoice;

#[derive(Debug, clap::Args)]
#[command(
    mut_arg("frames", |frames| frames.help("Only these frames, such as 10-99 or 12 [default: frames of the cameras or \
        the reference, else the first]")),
    after_help = "Examples:\n  lightfold render film.lfold -o first.png\n  \
    lightfold render film.lfold --eye 0,1.5,0 --look-at 2,1.5,0 --fov 90 -o view.png\n  \
    lightfold render film.lfold --camera path.json --frames 0-23 --size 1280x720 -o view.%04d.png\n  \
    lightfold render film.lfold --camera path.json -o view.%04d.exr --trace views.jsonl --stats\n  \
    lightfold render film.lfold --camera path.json --stereo side-by-side -o view.%V.%04d.png\n  \
    lightfold render film.lfold --camera path.json --size 1280x720 -o film.mp4\n  \
    lightfold render film.lfold --camera path.json --exposure 1.5 --tone-map filmic -o view.%04d.png\n  \
    lightfold render film.lfold --lut aces.cube --lut-input acescct -o view.png\n  \
    lightfold render film.lfold --camera path.json --stream-format y4m -o - | ffplay -\n  \
    lightfold render film.lfold --projection vr180 --stereo side-by-side --size 2048 -o vr.png\n  \
    lightfold render film.lfold --projection equirect --stereo over-under --aov depth -o all.exr\n  \
    lightfold render film.lfold --camera path.json --shard 3/8 -o view.%04d.exr\n  \
    lightfold render film.lfold --camera path.json --null --stats --json\n  \
    lightfold render film.lfold --camera path.json --contact-sheet sheet.png\n  \
    lightfold render film.lfold --camera path.json --aov depth,normal,holes -o view.%04d.exr\n  \
    lightfold render film.lfold --samples 4 --background transparent -o view.exr\n  \
    lightfold render film.lfold --exclude-probe 00 --reference film --reference-probe 00\n  \
    lightfold render film.lfold --eye 0,1.5,0 --look-at 2,1.5,0 --fov 90 -o - | display -\n  \
    lightfold render scene.glb --camera path.json -o view.%04d.png\n  \
    lightfold render scene.glb --reference footage --error-map maps --json\n\n\
    A simplified scene (.glb) is still: all frames are equal, and it is compared with the frame of the reference from \
    which it was made. Options for rays, probes and decoding are refused. --method painter blends all triangles in \
    the order of the file, double-sided and without depth test. z-buffer shows the nearest triangle at each of the N \
    x N samples of --samples; a triangle covers a sample if its alpha exceeds the threshold of the sample, one of \
    (0.5, 1.5, 2.5, ...) / N^2. PNG and EXR images have the alpha of the scene; with --reference it is composited \
    over black.\n\n\
    Without a camera, a container is rendered from its first probe: face nz of a cube map, or its perspective view; a \
    simplified scene from the camera of its file, at the centre of the viewing region. A camera path is a camera file as for decode: {\"cameras\": [{\"eye\": [0, 1.5, \
    0], \"look_at\": [2, 1.5, 0], \
    \"fov_y_deg\": 90}]}. Cameras without \"frames\" are poses of one camera, one per frame of --frames; if --frames \
    is one frame or absent, all of them show the same frame. Either all cameras of a path have \"frames\", or none. \
    Poses with a \
    \"frame\" are key poses: position is interpolated linearly, orientation by slerp: {\"cameras\": [{\"eye\": \
    [0, 1.5, 0], \"look_at\": [2, 1.5, 0], \"fov_y_deg\": 90, \"frame\": 0}, {\"eye\": [1, 1.5, 0], \"look_at\": [2, 1.5, 1], \
    \"fov_y_deg\": 60, \"frame\": 95}]}. near_m and far_m of a camera, in metres along its axis, clip surfaces; \
    behind a surface clipped by near_m, farther texels become visible. --near and --far are distances from the eye, \
    and limit the steps of rays. --size WxH overrides the aspect ratio of a camera.\n\n\
    The number in a file name is the frame. If several cameras share a frame, it is the index of the image in the \
    path, from 0. With --reference it is the frame, and files in a folder are named by probe and face, such as \
    00_px.0000.png. Files in a folder are PNG; use a pattern for EXR. With --shard, reports, --trace and \
    --contact-sheet cover the pictures of the shard.\n\n\
    EXR images store linear light premultiplied by alpha; PNG images store codes after the transfer function of the \
    container, with straight alpha. Dark footage needs a higher --exposure, such as 2. With --exposure EV or --tone-map, 8-bit pictures (PNG, streams, films and contact \
    sheets) are those of the player: light times 2^EV, then the tone map, then the transfer function of sRGB, whatever \
    the exposure and the transfer function of the container. They do not change the figures of --reference.\n\n\
    --lut applies a .cube table (of one dimension, of three, or both) to light times 2^EV, and shows its values as they \
    are. With --lut-input linear the table takes linear light with the primaries of the container; a log shaper needs \
    no option, but is coarse in shadows. With acescct it takes ACEScct, for footage of any primaries. OpenColorIO writes \
    such tables: ociobakelut --inputspace ACEScct --displayview \"sRGB - Display\" \"ACES 1.0 - SDR Video\" --cubesize 65 \
    --format iridas_cube aces.cube.\n\n\
    Films are encoded by ffmpeg, which must be installed: H.264 at crf 16 (VP9 at crf 18 in .webm), 8 bits, 4:2:0, \
    limited range, with the primaries, the matrix and the transfer function of BT.709, at the frame rate of the \
    container. Colour is composited over black. Width and height must be even. Alpha is 1 where footage is opaque, including background and holes filled from \
    behind. It is 0 where nothing is known, and in holes with --holes blank or nearest; with nearest, EXR images keep \
    the colour of holes. With --background transparent, alpha is the fraction of a pixel that surfaces cover, and \
    colour is that of surfaces only. --aov holes adds a channel that marks holes, which are surfaces that no probe \
    saw.\n\n\
    With --reference, ghost_ratio of --json is the RMS error of pixels within 3 pixels of projected silhouettes of \
    probes, divided by the RMS error of all others; it is absent if depth is not on the CPU.\n\n\
    Each line of --trace has: shot, a counter from 0; frame; eye in metres; active probes by priority, with slot \
    (constant while a probe is active), distance_m from the eye and angle_deg at --pivot; culled probes with the \
    reason: limit (--views), angle (--cull-angle, and the probe of higher priority) or performance (--target-ms); \
    cells_decoded and cells_skipped, which count tiles and cells; bytes_read; \
    update_ms and render_ms."
)]
pub struct Args {
    // Must be first: options that are read are removed from the matches.
    #[command(flatten)]
    pub given: Given,
    /// Input container, - for standard input; or a scene written by simplify (.glb)
    #[arg(value_name = "IN.lfold", required_unless_present = "list_devices")]
    pub input: Option<PathBuf>,
    /// Output: an image ending in .png or .exr, a pattern such as view.%04d.png (%V is left or right), a folder for PNG
    /// files, a film ending in .mp4, .mov, .mkv or .webm, or - for a picture stream on standard output
    #[arg(long, short, value_name = "OUT",
        required_unless_present_any = ["null", "list_devices", "contact_sheet", "trace", "reference"])]
    pub output: Option<PathBuf>,
    /// Render without writing output
    #[arg(long, conflicts_with = "output")]
    pub null: bool,
    /// Height, or width and height, in pixels [default: 512; with --reference the size of its images]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, conflicts_with = "reference")]
    pub size: Option<(u32, Option<u32>)>,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Render one shard of the pictures, such as 3/8; the output must be a pattern or a folder
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub projection: ProjectionArgs,
    #[command(flatten)]
    pub stream: StreamArgs,
    /// Rendering device [default: cpu]
    #[arg(long, value_parser = one_of(DEVICES))]
    pub device: Option<DeviceChoice>,
    #[command(flatten)]
    pub gpu: GpuArgs,
    /// Write a contact sheet of all images to this PNG file
    #[arg(long, value_name = "FILE.png")]
    pub contact_sheet: Option<PathBuf>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub display: DisplayArgs,
    #[command(flatten)]
    pub march: MarchArgs,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub truth: TruthArgs,
    #[command(flatten)]
    pub cameras: CameraArgs,
}

impl Args {
    /// True if a graphics device is requested.
    pub fn is_on_device(&self) -> bool {
        self.gpu.index.is_on_device(self.device)
    }

    pub fn results_to_stdout(&self) -> usize {
        let paths = [&self.output, &self.contact_sheet, &self.views.trace];
        paths.into_iter().flatten().filter(|path| *path == Path::new("-")).count()
    }
}
