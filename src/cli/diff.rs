//! `lightfold diff A B`: compares two containers, datasets or image sequences.

use crate::options::{self, Choices, FrameArgs, MemoryArgs, SideArgs, one_of};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, diff_text, output};
use codec::color::quality::MAX_QUALITY;
use codec::decode::Selection;
use codec::error::{Error, Result, counted};
use codec::image::StreamKind;
use codec::image::cube::Face;
use footage::compare::{self, Bounds, ColorDomain, CompareSettings, Coverage, Measure, Pairing, SsimFrames, compare};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold diff scene/lightfield.json scene.lfold --max-error 100 --min-quality 80\n  \
    lightfold diff scene.lfold frames --json\n  \
    lightfold diff color.%04d.exr other.%04d.exr --hdr --min-cell-psnr 40\n  \
    lightfold diff a.lfold b.lfold --exact --stream depth --probe 00\n  \
    lightfold diff face_px/depth.%04d.exr decoded/depth.####.exr --frames 0-9\n\n\
    Each side is a container, a lightfield.json or its folder, or an image sequence: a pattern, a folder of images, one \
    image. Streams are matched by kind, probe and face; single streams of a kind are matched regardless of their names.\n\n\
    Depth is compared in 16-bit log codes from near to far, colour in 8-bit codes after the transfer function, half floats \
    in the PU21 encoding. Range and encoding are those of A if it is a container, else of B, else of the manifest of a \
    decoded dataset. For other pairs the range covers both sides, and colour is 8-bit sRGB, not clipped at 255; --hdr \
    compares half floats. Errors in metres are computed from the files, not from codes. Background compared with a \
    surface, and depth outside the range, count as an error of 65535 codes.\n\n\
    Colour that a container clipped to 8 bits is a difference: it is compared with the unclipped source, and the exit \
    code is 1 unless --allow-clipping is given. Colour with other primaries is converted to those of the side whose \
    encoding is used.\n\n\
    Exit codes: 0 all bounds hold; 1 a bound is exceeded, colour is clipped, bits differ (--exact), or streams or \
    frames are missing on one side, if a bound or --exact is given; 2 bad input; 75 an image does not exist yet, or a \
    file cannot be read at present."
)]
pub struct Args {
    /// Reference; - for a container on standard input
    #[arg(value_name = "A")]
    pub a: String,
    /// Input to compare with A
    #[arg(value_name = "B")]
    pub b: String,
    /// Maximum error: 16-bit log codes of depth, 8-bit codes of material
    #[arg(long, value_name = "CODES", value_parser = parse_codes)]
    pub max_error: Option<u16>,
    /// Minimum PSNR in dB of each frame of a colour stream
    #[arg(long, value_name = "DB", value_parser = parse_db)]
    pub min_psnr: Option<f64>,
    /// Minimum PSNR in dB of each frame of each colour cell, as encode --psnr
    #[arg(long, value_name = "DB", value_parser = parse_db)]
    pub min_cell_psnr: Option<f64>,
    /// Minimum perceptual quality of each frame of each colour cell, as encode --quality; A is the source
    #[arg(long, value_name = "Q", value_parser = parse_quality)]
    pub min_quality: Option<f64>,
    /// Compare colour as half floats, even if a side has 8 bits; PSNR is computed on PU21 codes with the peak at 100
    /// cd/m²
    #[arg(long)]
    pub hdr: bool,
    /// Luminance of the value 1.0 in cd/m², for --hdr [default: from the container or its manifest, else 100]
    #[arg(long, value_name = "CD_M2", requires = "hdr")]
    pub white: Option<f64>,
    /// Accept colour clipped to 8 bits: compare clipped codes
    #[arg(long)]
    pub allow_clipping: bool,
    /// Require equal bits: of depth as stored in the files, of colour as half floats or 8 bits
    #[arg(long)]
    pub exact: bool,
    /// Ignore streams and frames that exist on one side only
    #[arg(long)]
    pub common: bool,
    /// Frames of each stream for which to compute SSIM and PSNR-HVS-M (8-bit colour; slow)
    #[arg(long, value_parser = one_of(SSIM), default_value = "sampled")]
    pub ssim: SsimFrames,
    /// Also compute SSIMULACRA2 and butteraugli of these frames; images smaller than 256 pixels are extended by
    /// mirroring (8-bit sRGB; slower)
    #[arg(long)]
    pub ssimulacra2: bool,
    /// Print a row for every stream [default: up to 12 streams]
    #[arg(long)]
    pub streams: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    /// Only streams of these kinds: color, depth, material, alpha; also the kind of an image sequence
    #[arg(long, visible_alias = "kind", value_name = "KIND", value_delimiter = ',', value_parser = options::parse_kind)]
    pub stream: Vec<StreamKind>,
    /// Only these probes; also the probe of an image sequence
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Only these faces; also the face of an image sequence
    #[arg(long, value_name = "FACE", value_delimiter = ',', value_parser = options::parse_face)]
    pub face: Vec<Face>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub reading: SideArgs,
}

const SSIM: &Choices<SsimFrames> = &[
    ("every", SsimFrames::Every, "Every frame"),
    ("sampled", SsimFrames::Sampled, "The first, the middle and the last"),
    ("none", SsimFrames::None, "No frame"),
];

fn parse_codes(text: &str) -> Result<u16, String> {
    text.parse().map_err(|_| {
        "a whole number of codes from 0 to 65535 was expected, the unit of error bounds in encode and inspect".into()
    })
}

fn parse_db(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("'{text}': a number of decibels was expected"))?;
    if value.is_nan() { Err("decibels were expected".into()) } else { Ok(value) }
}

fn parse_quality(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..=MAX_QUALITY).contains(value));
    value.ok_or_else(|| format!("a quality of 0 to {MAX_QUALITY} was expected"))
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.ssimulacra2 && (args.hdr || args.ssim == SsimFrames::None) {
        return Err(Error::Usage(
            "--ssimulacra2 needs 8-bit colour and frames selected by --ssim: leave out --hdr and --ssim none".into(),
        ));
    }
    let selection = Selection {
        probes: args.probe.clone(),
        faces: args.face.clone(),
        kinds: args.stream.clone(),
        frames: args.frames.frames,
    };
    let sides = compare::open_both([&args.a, &args.b], &args.reading.options(selection)?)?;
    let settings = CompareSettings {
        coverage: if args.common { Coverage::Common } else { Coverage::Whole },
        measure: if args.exact { Measure::Bits } else { Measure::Codes },
        color: if args.hdr { ColorDomain::Half { white_cd_m2: args.white } } else { ColorDomain::AsCoded },
        ssim: args.ssim,
        ssimulacra2: args.ssimulacra2,
        allow_clipping: args.allow_clipping,
        memory: args.memory.get(),
    };
    let pairing = Pairing::new(&sides, settings.coverage)?;
    let bounds = Bounds {
        max_error: args.max_error,
        min_psnr_db: args.min_psnr,
        min_cell_psnr_db: args.min_cell_psnr,
        min_quality: args.min_quality,
        exact: args.exact,
        allow_clipping: args.allow_clipping,
    };
    bounds.check(&pairing)?;
    let progress = Progress::start(global, "comparing", pairing.images())?;
    let comparison = compare(&pairing, &settings, &progress)?;
    drop(progress);
    let judgement = bounds.judge(&comparison);
    let rows = if args.streams { usize::MAX } else { diff_text::FEW_ROWS };
    let text = || diff_text::report(&sides, &comparison, &judgement, rows);
    if let Some(total) = comparison.color().filter(|total| args.allow_clipping && total.clipped_pixels > 0) {
        output::note(format_args!(
            "{} of both sides did not fit 8 bits and were clipped: --hdr compares half floats",
            counted(total.clipped_pixels, "colour pixel")
        ));
    }
    if args.ssimulacra2 && comparison.color().is_some_and(|total| total.eye.pictures() == 0) {
        output::note("SSIMULACRA2 was not computed: it needs 8-bit sRGB colour");
    }
    output::print_either(args.json, &output::with_memory(comparison.report(&sides, &judgement)), text)?;
    Ok(if judgement.failed { ExitStatus::Failed } else { ExitStatus::Passed })
}
