//! `lightfold bc4w SEQ`: encodes depth as plain BC4w blocks, and measures the error of BC4w and of the other functions.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use crate::encode::{self, Encode};
use crate::options::{DepthUnitArgs, DomainArgs, SequenceInputArgs, StoreArgs, Target, Unfinished};
use crate::progress::Progress;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::depth::tile_psnr::{BIN_DB, TileModel, TilePsnr};
use codec::error::{Result, counted};
use codec::image::StreamKind;
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::tile_quality::{self, TileQualityReport};
use footage::encode::{DepthCodec, EncodeReport, EncodeSettings};

const BAR_COLUMNS: u64 = 8;

#[derive(Debug, clap::Args)]
#[command(mut_arg("lzma2", |arg| arg.requires("output")), mut_arg("zstd", |arg| arg.requires("output")),
    mut_arg("no_compression", |arg| arg.requires("output")), after_help = "Examples:\n  lightfold bc4w depth.%04d.exr -o depth.lfold\n  \
    lightfold bc4w depth.0000.exr --effort fast -o depth.lfold\n  \
    lightfold bc4w depth.%04d.exr --stats\n\n\
    Each block of 8x8 pixels takes 32 bytes, a quarter of its 16-bit codes. There is no error bound; background is \
    exact. \
    --stats fits each tile with BC4w, a platelet and a biquadratic, and reports their PSNR (peak 65535) and that of the best \
    of the last two and of all three. A tile without error counts as 114.39 dB in the mean, the PSNR of the smallest \
    possible error, and as inf elsewhere. A tile that a function cannot model, because it has both background and \
    surfaces, counts as 0 dB.")]
pub struct Args {
    /// Output container, - for standard output
    #[arg(long, short, value_name = "OUT.lfold")]
    pub output: Option<PathBuf>,
    /// Measure the PSNR of each tile with each modelling function
    #[arg(long)]
    pub stats: bool,
    #[command(flatten)]
    pub store: StoreArgs,
    #[command(flatten)]
    pub input: SequenceInputArgs,
    #[command(flatten)]
    pub domain: DomainArgs,
    #[command(flatten)]
    pub units: DepthUnitArgs,
}

#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    quality: TileQualityReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    encode: Option<EncodeReport>,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
    settings.depth.domain = args.domain.depth_domain;
    args.units.apply(&mut options, &mut settings);
    args.input.apply(&mut options, &mut settings);
    args.store.apply(&mut settings);
    settings.depth.codec = DepthCodec::Blocks;
    let output = args.output.as_deref();
    if output.is_none() && !args.stats {
        return refuse("nothing to do: write a container with -o, or measure the tiles with --stats");
    }
    if output == Some(Path::new("-")) && args.stats {
        return refuse("--stats and -o - would both write to standard output: write the container to a file");
    }
    let source = args.input.open(StreamKind::Depth, &options)?;
    let target = output.map(|path| Target { path, unfinished: Unfinished::Discard, json: args.store.json });
    let encode = |target| Encode {
        source: &source,
        part: None,
        settings: &settings,
        target,
        time: None,
        smaller: None,
        start,
        global,
    };
    match target {
        Some(target) if !args.stats => encode(target).run(),
        target => {
            let encoded = target.map(|target| encode(target).encode()).transpose()?;
            measure(args, &source, &settings, encoded, global)
        }
    }
}

fn measure(
    args: &Args,
    source: &Source,
    settings: &EncodeSettings,
    encoded: Option<EncodeReport>,
    global: &GlobalArgs,
) -> Result<ExitStatus> {
    let start = Instant::now();
    let progress = Progress::start(global, "measuring", tile_quality::images(source))?;
    let found = tile_quality::measure(source, settings, &progress)?;
    drop(progress);
    let seconds = start.elapsed().as_secs_f64();
    if args.store.json {
        let quality = TileQualityReport::new(&found, seconds);
        output::print_json(&output::with_memory(Document { quality, encode: encoded }))?;
    } else {
        if let (Some(encoded), Some(path)) = (encoded, &args.output) {
            global.note(encode::text(path, &encoded));
        }
        output::print_text(&stats_text(&found, seconds))?;
    }
    Ok(ExitStatus::Passed)
}

fn stats_text(found: &TilePsnr, seconds: f64) -> String {
    let mut table = Table::new("PSNR in dB|>Mean|>Min|>5%|>50%|>95%|>Exact|>Not modelled");
    for of in TileModel::ALL {
        let psnr = found.of(of);
        let quantiles = [0.05, 0.5, 0.95].map(|part| psnr.quantile_db(part));
        let db = [psnr.mean_db(), psnr.min_db].into_iter().chain(quantiles).map(|db| format!("{db:.2}"));
        let counts = [psnr.exact, psnr.unmodelled].map(|count| count.to_string());
        table.row(std::iter::once(title(of).to_owned()).chain(db).chain(counts));
    }
    format!(
        "{table}\n{}\n{} of 8x8 pixels, largest error of BC4w {} codes, {seconds:.2} s\n",
        histogram_text(found),
        counted(found.tiles(), "tile"),
        found.bc4w_max_error
    )
}

fn histogram_text(found: &TilePsnr) -> String {
    let all = TileModel::ALL.map(|of| {
        let mut bins = found.of(of).histogram();
        bins.push(found.of(of).exact);
        bins
    });
    let used = |bin: usize| all.iter().any(|bins| bins[bin] > 0);
    let most = all.iter().flatten().copied().max().unwrap_or(0).max(1);
    let bins = all[0].len();
    let Some(first) = (0..bins).find(|&bin| used(bin)) else { return String::new() };
    let mut table = Table::new(&format!("Tiles by dB|{}", TileModel::ALL.map(title).join("|")));
    for bin in (first..bins).filter(|&bin| bin + 1 < bins || used(bin)) {
        if bin + 1 < bins && !(bin..bins - 1).any(used) {
            continue;
        }
        let name =
            if bin + 1 == bins { "exact".to_owned() } else { format!("{:>3} to {}", bin * BIN_DB, (bin + 1) * BIN_DB) };
        let cell = |bins: &Vec<u64>| {
            let percent = 100.0 * bins[bin] as f64 / found.tiles().max(1) as f64;
            let bar = "#".repeat((bins[bin] * BAR_COLUMNS).div_ceil(most) as usize);
            if bins[bin] == 0 { String::new() } else { format!("{percent:>4.1}% {bar}") }
        };
        table.row(std::iter::once(name).chain(all.iter().map(cell)));
    }
    table.to_string()
}

fn title(of: TileModel) -> &'static str {
    match of {
        TileModel::Bc4w => "BC4w",
        TileModel::Platelet => "Platelet",
        TileModel::Biquadratic => "Biquadratic",
        TileModel::PlateletOrBiquadratic => "Best of two",
        TileModel::BestOf => "Best of all",
    }
}
