//! `lightfold init DIR`: proposes a manifest for a folder of images.

mod cameras;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::options::{AccountArgs, Choices, check_report, one_of};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::{Error, Result, counted};
use codec::image::StreamKind;
use footage::account::Account;
use footage::convention::{self, Verdict};
use footage::dataset::discover::{self, Numbers, Proposal};
use footage::dataset::manifest::{FileDepth, MANIFEST_NAME, Manifest, UpAxis};
use footage::dataset::{Projection, Source, SourceOptions};

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  lightfold init my-renders\n  lightfold encode my-renders -o film.lfold\n\n\
    Detects image sequences by the frame numbers in file names; probes and faces by folder or file names; panoramas \
    (mono or stereo), crosses and strips by image shape; colour, depth and alpha by channels; and the colour space by \
    chromaticities. Colour above 1 is kept as half floats by encode (\"keep\": \"hdr\"). Cameras are read from the EXR attributes worldToCamera and worldToNDC, or from a file in DIR: \
    transforms.json, images.txt or images.bin of COLMAP, or USD text. The manifest is then checked as by inspect --check, \
    which lists each check; here one line says how many are suspect. Values that images do not define are printed, one per \
    line: correct them in the manifest.")]
pub struct Args {
    /// Folder of images
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Output manifest, - for standard output [default: lightfield.json in DIR]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Numbers in file names name views of one moment, not frames
    #[arg(long)]
    pub views: bool,
    /// Axis of the footage's world that points up: cameras of Blender and Unreal have z; lightfold has y
    #[arg(long, value_name = "AXIS", value_parser = one_of(UP_AXES), default_value = "y")]
    pub up: UpAxis,
    /// Overwrite an existing manifest
    #[arg(long)]
    pub force: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub account: AccountArgs,
}

const UP_AXES: &Choices<UpAxis> = &[
    ("y", UpAxis::Y, "Positions and orientations are kept"),
    ("z", UpAxis::Z, "Positions and stated orientations are turned: z becomes y, y becomes −z"),
];

#[derive(Serialize)]
struct Report<'a> {
    /// Path of the manifest.
    manifest: std::borrow::Cow<'a, str>,
    /// Properties that the images do not determine.
    unsure: &'a [String],
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let inside = args.folder.join(MANIFEST_NAME);
    let to = args.output.as_ref().unwrap_or(&inside);
    let is_standard_output = to == Path::new("-");
    check_report(to, args.json)?;
    if !is_standard_output && to.exists() && !args.force {
        return refuse(format!("{}: a manifest exists already: use --force to replace it", to.display()));
    }
    if !args.folder.exists() {
        return Err(Error::not_found(&args.folder, "there is no such file or folder"));
    }
    if !args.folder.is_dir() {
        return refuse(format!("{}: a folder of images was expected", args.folder.display()));
    }
    let mut proposal = discover::propose(&args.folder, if args.views { Numbers::Views } else { Numbers::Frames })?;
    // Cameras stated in the images take precedence over camera files in the folder.
    let has_poses = proposal.unsure_of_cameras.is_empty() || cameras::place(&args.folder, &mut proposal);
    let file = if is_standard_output { &inside } else { to };
    if !is_below(file, &args.folder) {
        proposal = proposal.outside(&args.folder)?;
    }
    if args.up == UpAxis::Z {
        proposal.manifest.probes.iter_mut().for_each(|probe| probe.turn_z_up(has_poses));
    }
    let Proposal { mut manifest, mut unsure, unsure_of_cameras, left_out } = proposal;
    if has_alpha(&manifest, file) {
        manifest.files.alpha.clone_from(&manifest.files.color);
    }
    unsure.extend(unsure_of_cameras);
    args.account.notes(&Account { left_out: left_out.clone(), ..Account::default() }, global);
    let Checked { manifest, doubts, summary } = match checked(&manifest, file, global) {
        Ok(checked) => checked,
        Err(Error::Interrupted) => return Err(Error::Interrupted),
        // The manifest is still useful.
        Err(error) => {
            Checked { manifest, doubts: vec![format!("the checks stopped early: {error}")], summary: String::new() }
        }
    };
    unsure.extend(doubts);
    output::write_file(to, &manifest.to_json()?)?;
    let source = Source::of_manifest(manifest.clone(), file, &SourceOptions::default());
    // Without a file that can be opened, channels are unknown.
    let mut account = source.and_then(|source| source.account()).unwrap_or_else(|_| manifest.account());
    args.account.notes(&account, global);
    account.left_out.splice(0..0, left_out);
    let report = Report { manifest: to.to_string_lossy(), unsure: &unsure };
    if !args.json {
        if !summary.is_empty() {
            global.note(summary);
        }
        unsure.iter().for_each(|line| output::note(format_args!("unsure: {line}")));
        if !unsure.is_empty() && !is_standard_output {
            let file = to.display();
            output::note(format_args!("next: correct {file}, then check it by lightfold inspect {file} --check"));
        }
    }
    args.account.report((&account, args.json), report, || text(to, &manifest), global)?;
    Ok(ExitStatus::Passed)
}

/// True if the first colour file has alpha below 1. Unreadable files are found by the checks.
fn has_alpha(manifest: &Manifest, file: &Path) -> bool {
    let source = Source::of_manifest(manifest.clone(), file, &SourceOptions::default());
    source.is_ok_and(|source| source.unnamed_alpha().is_some())
}

/// True if a file lies directly in a folder.
fn is_below(file: &Path, folder: &Path) -> bool {
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (parent.canonicalize(), folder.canonicalize()) {
        (Ok(parent), Ok(folder)) => parent == folder,
        _ => false,
    }
}

/// Result of the checks.
struct Checked {
    /// The manifest with the kind of depth that fits the images.
    manifest: Manifest,
    /// Suspected errors.
    doubts: Vec<String>,
    /// One line; empty if the checks stopped early.
    summary: String,
}

fn checked(manifest: &Manifest, file: &Path, global: &GlobalArgs) -> Result<Checked> {
    let source = Source::of_manifest(manifest.clone(), file, &SourceOptions::default())?;
    let steps =
        convention::steps(&source, &convention::Choice { max_probes: convention::MAX_PROBES, ..Default::default() })?;
    let progress = Progress::start(global, "checking", steps)?;
    let (manifest, report) = convention::settle::settle(manifest.clone(), file, &progress)?;
    let mut doubts: Vec<String> =
        report.suspected().map(|finding| format!("{}: {}", finding.check, finding.says)).collect();
    let is_settled = report.findings.iter().any(|of| of.check.starts_with("depth.kind") && of.verdict == Verdict::Fine);
    let kind = manifest.depth.as_ref().map(|depth| depth.kind);
    let assumed = match kind.filter(|_| !is_settled && manifest.projection != Projection::Equirect) {
        Some(FileDepth::Planar) => Some(["Z along the camera axis", "distance along rays", "distance"]),
        Some(FileDepth::Distance) => Some(["distance along rays", "Z", "planar"]),
        Some(FileDepth::Disparity) | None => None,
    };
    doubts.extend(assumed.map(|[assumed, other, word]| {
        format!("depth was assumed to be {assumed}; if it is {other}, set \"kind\": \"{word}\"")
    }));
    let suspects = match report.suspected().count() {
        0 => "no check is suspect".to_owned(),
        1 => "one check is suspect".to_owned(),
        count => format!("{count} checks are suspect"),
    };
    Ok(Checked { manifest, doubts, summary: format!("checked {}: {suspects}", report.extent()) })
}

fn text(file: &Path, manifest: &Manifest) -> String {
    let kinds: Vec<&str> =
        StreamKind::ALL.into_iter().filter(|kind| manifest.files.get(*kind).is_some()).map(StreamKind::name).collect();
    let mut sizes: Vec<String> = Vec::new();
    for [width, height] in manifest.probes.iter().map(|probe| manifest.size_of(probe)) {
        let size = format!("{width}x{height}");
        if !sizes.contains(&size) {
            sizes.push(size);
        }
    }
    format!(
        "{}: {} of {} in {}, frames {}, {} pixels",
        file.display(),
        kinds.join(" and "),
        counted(manifest.probes.len() as u64, "probe"),
        manifest.projection.name(),
        manifest.frame_range(),
        sizes.join(" or ")
    )
}
