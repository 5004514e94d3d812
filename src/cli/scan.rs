//! `lightfold scan MANIFEST -o scan.json`: collects the data about all depth images that sharded encodes need.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use crate::encode::is_one_of;
use crate::options::{CodingArgs, StoreArgs, check_report, parse_shard};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::{Error, Result, counted};
use footage::dataset::manifest;
use footage::encode::{self, ScanFile, Shard};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold scan film -o scan.json\n  \
    lightfold encode film --scan scan.json --shard 3/8 -o film-3.lfold\n  \
    lightfold scan film --shard 3/8 -o scan-3.json\n  \
    lightfold scan --merge scan-*.json -o scan.json\n\n\
    A scan has near, far and recurring distances of each probe, computed from all its frames, and digests of all \
    files: pack joins shards only if digests are equal, and encode refuses files that have changed since the scan. \
    Use the same options as for encode; options of colour, material, effort, compression and --stream have no effect \
    on a scan. --merge needs the scans of all shards.")]
pub struct Args {
    /// Dataset: a lightfield.json or its folder; with --merge, scans of shards
    #[arg(value_name = "MANIFEST", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Output scan, - for standard output
    #[arg(long, short, value_name = "SCAN.json")]
    pub output: PathBuf,
    /// Join scans of shards
    #[arg(long, conflicts_with_all = ["shard", "resume"])]
    pub merge: bool,
    /// Scan one shard of the images, such as 3/8
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Keep valid parts of an earlier scan in the output file, and scan the rest
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub store: StoreArgs,
    #[command(flatten)]
    pub coding: CodingArgs,
}

#[derive(Serialize)]
struct Report {
    /// Number of scanned images of the shard, or of joined scans.
    images: u64,
    seconds: f64,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    check_report(&args.output, args.store.json)?;
    let start = Instant::now();
    let (count, what) =
        if args.merge { (merge(&args.inputs, &args.output)?, "scan") } else { (scan(args, global)?, "image") };
    let report = Report { images: count, seconds: start.elapsed().as_secs_f64() };
    global.report(args.store.json, &report, || {
        format!("{}: {}, {:.2} s", args.output.display(), counted(count, what), report.seconds)
    })?;
    Ok(ExitStatus::Passed)
}

fn merge(inputs: &[PathBuf], output: &Path) -> Result<u64> {
    let mut scans = inputs.iter().map(|path| Ok((path, ScanFile::read(path)?)));
    let Some(first) = scans.next() else { return refuse("--merge needs at least one scan") };
    let (first, mut merged) = first?;
    let mut unfinished = merged.is_unfinished().then_some(first);
    for scan in scans {
        let (path, scan) = scan?;
        unfinished = unfinished.or(scan.is_unfinished().then_some(path));
        merged.merge(scan).map_err(|error| error.in_file(path))?;
    }
    if let Some(missing) = merged.missing() {
        return Err(match unfinished {
            Some(path) => Error::busy(
                path,
                format!(
                    "this scan is unfinished, and no scan has {missing}: wait for it, or run it again with `resume`"
                ),
            ),
            None => {
                Error::invalid(format!("no scan has {missing}: scan the missing shards, and merge the scans of all"))
            }
        });
    }
    save(&merged, output)?;
    Ok(inputs.len() as u64)
}

fn scan(args: &Args, global: &GlobalArgs) -> Result<u64> {
    let [input] = args.inputs.as_slice() else {
        return refuse("one dataset was expected: use --merge to join scans of shards");
    };
    let (options, mut settings) = args.coding.settings(&args.store)?;
    let mut source = args.coding.dataset.open(input, &options)?;
    settings.keep_colors_of(&source);
    encode::keep_few_planar_depths(&mut source, &settings);
    let mut scan = ScanFile::new(&source);
    if is_one_of(&args.output, source.files().chain([manifest::manifest_path(input)])) {
        return refuse(format!("{}: an input file would be overwritten", args.output.display()));
    }
    // True for a regular file: neither a pipe nor a device.
    let in_file = args.output != Path::new("-") && std::fs::metadata(&args.output).map_or(true, |meta| meta.is_file());
    if args.resume && args.output.exists() {
        let earlier = ScanFile::read(&args.output)?;
        if !earlier.is_of(&source) {
            return refuse(format!(
                "{}: this is a scan of other footage or with other settings: use the same ones, or leave out --resume \
                to start over",
                args.output.display()
            ));
        }
        scan = earlier;
    }
    let images = ScanFile::images(&source, &settings, args.shard)?;
    let progress = Progress::start(global, "scanning", images)?;
    let mut keep = |scan: &ScanFile| if in_file { scan.write(&args.output) } else { Ok(()) };
    let read = scan.scan(&source, &settings, args.shard, &progress, &mut keep)?;
    if args.resume && read == 0 {
        global.note(format_args!("{}: the scan is complete; nothing to scan", args.output.display()));
    }
    save(&scan, &args.output)?;
    Ok(images)
}

fn save(scan: &ScanFile, output: &Path) -> Result<()> {
    output::write_file(output, &scan.to_json()?)
}
