//! `lightfold encode MANIFEST -o OUT`: encodes all streams of a dataset into one container.

use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use crate::options::{CodingArgs, EncodeOutputArgs, SequenceInputArgs, ShardArgs, Target, Unfinished, check_stdout};
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, depth_bound, encode_advice, refuse};
use codec::container::{Recovered, journal};
use codec::error::{Error, Result, counted};
use codec::image::StreamKind;
use codec::monitor::Monitor;
use footage::dataset::manifest;
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::{
    self, EncodeReport, EncodeSettings, EncodeSummary, FirstFrames, Footage, FrameSource, Kept, Part, Plan, Resumable,
    ScanFile, Scans, Stopped,
};
use footage::files::{IntactBytes, OutputFile};

const SMALLER: &str = "a lower --quality or a higher --max-error";

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode scene/lightfield.json -o scene.lfold\n  \
    lightfold encode scene -o scene.lfold --lzma2 --psnr 45 --depth-window 4 --json\n  \
    lightfold encode scene -o small.lfold --color-block bc7 --psnr-final 38 --material-block bc1\n  \
    lightfold encode scene -o - --stream depth | ssh studio 'cat > depth.lfold'\n  \
    lightfold encode scene -o small.lfold --preset small --clip\n  \
    lightfold encode scene -o scene.lfold --missing hold\n  \
    lightfold encode scene -o scene.lfold --resume\n  \
    lightfold encode scene --shard 3/8 -o scene-3.lfold\n  \
    lightfold encode scene --shard 1/2 --shard-frames 0-383 -o scene-1.lfold\n\n\
    An encode interrupted by a signal, a full disk or an invalid frame keeps its complete chunks beside the output. \
    The same command with --resume continues after them and writes the same bytes. With --resume, a complete shard \
    with the same options that is newer than its images is not encoded again.\n\n\
    --shard-by divides the footage evenly among the shards. --shard-probe, --shard-stream and --shard-frames select \
    the content of a shard instead; then every frame of every stream must be in exactly one shard. pack reports \
    frames that are missing or duplicated.")]
pub struct Args {
    /// Dataset: a lightfield.json or its folder
    #[arg(value_name = "MANIFEST")]
    pub input: PathBuf,
    #[command(flatten)]
    pub output: EncodeOutputArgs,
    #[command(flatten)]
    pub coding: CodingArgs,
    #[command(flatten)]
    pub shards: ShardArgs,
}

pub trait Encodes {
    fn settings(&self) -> Result<(SourceOptions, EncodeSettings)>;
    fn open(&self, options: &SourceOptions) -> Result<Source>;
    fn target(&self) -> Target<'_>;
    /// Suggestion for a smaller container.
    fn smaller(&self) -> &'static str {
        SMALLER
    }
}

pub trait SequenceCodec: clap::Args {
    const KIND: StreamKind;
    fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()>;
}

#[derive(Debug, clap::Args)]
pub struct EncodeSequence<C: SequenceCodec> {
    #[command(flatten)]
    output: EncodeOutputArgs,
    #[command(flatten)]
    input: SequenceInputArgs,
    #[command(flatten)]
    codec: C,
}

impl<C: SequenceCodec> Encodes for EncodeSequence<C> {
    fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.codec.apply(&mut options, &mut settings)?;
        self.input.apply(&mut options, &mut settings);
        self.output.container.store.apply(&mut settings);
        Ok((options, settings))
    }

    fn open(&self, options: &SourceOptions) -> Result<Source> {
        self.input.open(C::KIND, options)
    }

    fn target(&self) -> Target<'_> {
        self.output.target()
    }
}

impl Encodes for Args {
    fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        self.coding.settings(&self.output.container.store)
    }

    fn open(&self, options: &SourceOptions) -> Result<Source> {
        self.coding.dataset.open(&self.input, options)
    }

    fn smaller(&self) -> &'static str {
        if self.coding.preset.is_small() { SMALLER } else { "--preset small" }
    }

    fn target(&self) -> Target<'_> {
        self.output.target()
    }
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (start, begun) = (Instant::now(), SystemTime::now());
    let stages = Progress::start(global, "opening", 0)?;
    let (options, mut settings) = args.settings()?;
    let inputs = [manifest::manifest_path(&args.input)].into_iter().chain(args.shards.scan.clone());
    if is_one_of(&args.output.container.path, inputs) {
        return refuse(format!("{}: an input file would be overwritten", args.output.container.path.display()));
    }
    let mut source = args.open(&options)?;
    let keep = settings.keep_colors_of(&source);
    encode_advice::note_keep(keep, &source, &settings, global);
    encode::keep_few_planar_depths(&mut source, &settings);
    let part = args.shards.part(&source, &settings)?;
    drop(stages);
    let (part, scans) = with_footage(part, args.shards.scan.as_deref(), (&source, &settings), global)?;
    let path = &args.output.container.path;
    if let Some(part) = part.as_ref().filter(|_| args.output.resume)
        && let Some(summary) = encode::complete_shard(part, path)
    {
        let report = EncodeReport::new(summary, start.elapsed().as_secs_f64());
        let words = || format!("{}: this shard is complete; nothing to encode", path.display());
        return global.report(args.output.container.store.json, &report, words).map(|()| ExitStatus::Passed);
    }
    let part = with_scans(part, scans, &settings, global)?;
    let smaller = Some(args.smaller());
    // `encode::complete_shard` compares this time with those of the images, to detect changed images.
    let time = part.as_ref().filter(|part| part.is_shard()).map(|_| begun);
    Encode { source: &source, part, settings: &settings, target: args.target(), time, smaller, start, global }.run()
}

/// Runs a command that needs no further checks.
pub fn run_on(command: &dyn Encodes, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    let stages = Progress::start(global, "opening", 0)?;
    let (options, mut settings) = command.settings()?;
    let mut source = command.open(&options)?;
    let keep = settings.keep_colors_of(&source);
    encode_advice::note_keep(keep, &source, &settings, global);
    encode::keep_few_planar_depths(&mut source, &settings);
    drop(stages);
    let (smaller, target) = (Some(command.smaller()), command.target());
    Encode { source: &source, part: None, settings: &settings, target, time: None, smaller, start, global }.run()
}

/// Returns the part of the source to encode, with the content hashes of the footage from a scan or read now, and the
/// scans. The part is `None` if there is neither a shard nor a scan.
fn with_footage<'a>(
    part: Option<Part<'a>>,
    scan: Option<&Path>,
    (source, settings): (&'a Source, &EncodeSettings),
    global: &GlobalArgs,
) -> Result<(Option<Part<'a>>, Option<Scans>)> {
    let known = match scan {
        Some(path) => Some(ScanFile::read(path)?.scans(source).map_err(|error| error.in_file(path))?),
        None => None,
    };
    Ok(match (part, known) {
        (None, None) => (None, None),
        (None, Some((scans, footage))) => (Some(Part::whole(source, footage)), Some(scans)),
        (Some(part), Some((scans, footage))) => (Some(part.with_footage(footage)), Some(scans)),
        (Some(part), None) => {
            let images = Plan::new(source, settings).images();
            let progress = Progress::start(global, "reading footage", images)?;
            (Some(part.with_footage(Footage::read(source, settings, &progress)?)), None)
        }
    })
}

/// Returns the part with the known scans, or with scans made now.
fn with_scans<'a>(
    part: Option<Part<'a>>,
    known: Option<Scans>,
    settings: &EncodeSettings,
    global: &GlobalArgs,
) -> Result<Option<Part<'a>>> {
    let Some(part) = part else { return Ok(None) };
    if part.is_shard() && settings.depends_on_processor() {
        global.note(
            "texture blocks depend on the instruction set of the processor: encode all shards on processors of the \
            same kind, otherwise pack refuses them",
        );
    }
    match known {
        Some(scans) => Ok(Some(part.with_scans(scans))),
        None => {
            let progress = Progress::start(global, "finding near and far", part.images_to_scan(settings))?;
            part.scan(settings, &progress).map(Some)
        }
    }
}

pub struct Encode<'a> {
    pub source: &'a Source,
    /// Part of the source to encode. `None` for all.
    pub part: Option<Part<'a>>,
    pub settings: &'a EncodeSettings,
    pub target: Target<'a>,
    /// Modification time of the container. `None` for the time at which it is finished.
    pub time: Option<SystemTime>,
    /// Suggestion for a smaller container, if any.
    pub smaller: Option<&'a str>,
    /// Time at which the command began.
    pub start: Instant,
    pub global: &'a GlobalArgs,
}

impl Encode<'_> {
    pub fn run(&self) -> Result<ExitStatus> {
        let Target { path, unfinished, json } = self.target;
        check_stdout(path, json)?;
        if unfinished == Unfinished::Resume && path == Path::new("-") {
            return refuse("--resume needs a file: an encode to standard output cannot be resumed");
        }
        encode_advice::note_values(self.source, self.settings, self.global)?;
        let done = self.encode()?;
        note_clipping(path, &done.summary);
        encode_advice::note_depth(&done.summary, self.global);
        if let Some(smaller) = self.smaller {
            encode_advice::note_size(self.frames(), self.settings, (done.summary.bytes, smaller), self.global);
        }
        self.global.report(json, &done, || text(path, &done)).map(|()| ExitStatus::Passed)
    }

    pub fn encode(&self) -> Result<EncodeReport> {
        let Target { path, unfinished, .. } = self.target;
        if is_one_of(path, self.source.files()) {
            return refuse(format!("{}: an input file would be overwritten", path.display()));
        }
        self.note_block_bound();
        // Checked before an earlier encode is replaced.
        let plan = Plan::new(self.frames(), self.settings);
        plan.check()?;
        self.prepare_filters()?;
        let first_frames = FirstFrames::new(&plan)?;
        let progress = Progress::start(self.global, "reading first frames", first_frames.images())?;
        first_frames.check(&progress)?;
        drop(progress);
        let progress = Progress::start(self.global, "encoding", plan.images())?;
        let summary = if unfinished == Unfinished::Discard {
            self.encode_whole(&plan, OutputFile::create(path)?, &progress)?
        } else {
            let file = OutputFile::open(path)?;
            if file.is_resumable() {
                self.encode_resumable(&plan, file, &progress)?
            } else {
                if unfinished == Unfinished::Resume {
                    self.say("not a regular file, so there is nothing to resume");
                }
                self.encode_whole(&plan, file, &progress)?
            }
        };
        Ok(EncodeReport::new(summary, self.start.elapsed().as_secs_f64()))
    }

    fn frames(&self) -> &dyn FrameSource {
        match &self.part {
            Some(part) => part,
            None => self.source,
        }
    }

    /// Computes the filters of panoramas, as a separate progress stage.
    fn prepare_filters(&self) -> Result<()> {
        let groups = encode::selected_groups(self.frames(), self.settings);
        let maps = self.source.filtered_maps(&groups);
        if maps.is_empty() {
            return Ok(());
        }
        let progress = Progress::start(self.global, "preparing panoramas", maps.len() as u64)?;
        maps.into_iter().try_for_each(|map| {
            progress.check()?;
            map.prepare_filters();
            progress.advance(1);
            Ok(())
        })
    }

    /// Notes that keyframes in blocks have a lower PSNR than the keyframe search requires.
    fn note_block_bound(&self) {
        let searched_db = self.settings.search.target.min_psnr_db();
        let has_color =
            encode::selected_groups(self.frames(), self.settings).iter().any(|group| group.kind == StreamKind::Color);
        if let Some(blocks) =
            self.settings.color_blocks.filter(|blocks| has_color && blocks.final_psnr_db < searched_db)
        {
            self.global.note(format_args!(
                "keyframes in blocks have at least {} dB (--psnr-final); --psnr {searched_db} applies before block \
                compression",
                blocks.final_psnr_db
            ));
        }
    }

    fn say(&self, words: &str) {
        self.global.note(format_args!("{}: {words}", self.target.path.display()));
    }

    /// Encodes, and leaves no file on failure.
    fn encode_whole(&self, plan: &Plan<'_>, file: OutputFile, progress: &Progress) -> Result<EncodeSummary> {
        let done = plan.encode(file, progress);
        let (mut file, summary) = done.map_err(|error| output::name_output(error, self.target.path))?;
        self.commit(&mut file).map(|()| summary)
    }

    fn commit(&self, file: &mut OutputFile) -> Result<()> {
        match self.time {
            Some(time) => file.commit_as_of(time),
            None => file.commit(),
        }
    }

    /// Resumes if requested, and keeps complete chunks on failure.
    fn encode_resumable(&self, plan: &Plan<'_>, mut file: OutputFile, progress: &Progress) -> Result<EncodeSummary> {
        if !file.is_locked() {
            self.say("the file system does not support locks: do not run two encodes to this file at the same time");
        }
        let begun = file
            .recover(|records, bytes| journal::recover_watched(records, bytes, progress))
            .map_err(|error| stays(error, &file))?;
        let recovered = match (begun, self.target.unfinished) {
            (Some(begun), Unfinished::Resume) if !begun.chunks.is_empty() => {
                // A shard of changed footage is encoded anew, even if it is complete.
                if self.is_shard() && plan.is_of_changed_footage(&begun, progress)? {
                    self.say("input files have changed since the unfinished encode; starting over");
                    return self.encode_recovered(plan, file, None, progress);
                }
                plan.check_recovered(&begun).map_err(|error| error.context(self.target.path.display()))?;
                let words = plan.describe(begun.safe()).unwrap_or_default();
                self.say(&format!("resuming after {words}"));
                Some(begun)
            }
            (begun, Unfinished::Resume) => {
                self.say("nothing to resume; starting from the beginning");
                // The results of its scan may still be usable.
                begun.filter(|begun| plan.check_recovered(begun).is_ok())
            }
            (begun, _) => {
                if let Some(begun) = begun.filter(|begun| !begun.chunks.is_empty()) {
                    let chunks = counted(begun.chunks.len() as u64, "chunk");
                    let more = match Plan::new(self.source, self.settings).check_recovered(&begun) {
                        Ok(()) => "; --resume would continue it",
                        Err(_) => " with other options",
                    };
                    self.say(&format!("replacing an unfinished encode of {chunks}{more}"));
                }
                None
            }
        };
        self.encode_recovered(plan, file, recovered, progress)
    }

    fn is_shard(&self) -> bool {
        self.part.as_ref().is_some_and(Part::is_shard)
    }

    /// Continues after the recovered chunks, if any.
    fn encode_recovered(
        &self,
        plan: &Plan<'_>,
        mut file: OutputFile,
        recovered: Option<Recovered>,
        progress: &Progress,
    ) -> Result<EncodeSummary> {
        let goes_on = recovered.is_some();
        let intact =
            recovered.as_ref().map(|found| IntactBytes { file: found.container_bytes, journal: found.journal_bytes });
        let journal = file.resume(intact).map_err(|error| if goes_on { stays(error, &file) } else { error })?;
        let resumable = Resumable { out: &mut file, journal: Some(journal), recovered };
        let done = plan.encode_resumable(resumable, progress);
        let stopped = match done.map(|(_, summary)| summary) {
            Err(stopped) => stopped,
            Ok(summary) => match self.commit(&mut file) {
                Ok(()) => return Ok(summary),
                Err(error) if !file.is_resumable() => return Err(error),
                Err(error) => Stopped { error, kept: Kept::Chunks("all chunks".to_owned()) },
            },
        };
        let error = output::name_output(stopped.error, self.target.path);
        match stopped.kept {
            Kept::Nothing => {
                file.discard();
                Err(error)
            }
            Kept::Unchanged => {
                // The file is not reported as kept, so a failure is ignored.
                let _ = file.keep();
                Err(error.context(self.target.path.display()))
            }
            Kept::Chunks(words) => {
                let on_disk = file.keep();
                let how = match error {
                    // The scan of a shard describes the footage before the change.
                    Error::Invalid { .. } if self.is_shard() => "after a new scan, --resume starts this shard again",
                    _ => output::how_to_resume(&error),
                };
                let safe = kept(file.work_path(), &words, &on_disk) + "; " + how;
                Err(Error::Unfinished { cause: Box::new(error), safe })
            }
        }
    }
}

/// True if `path` exists and is one of the given files.
pub fn is_one_of(path: &Path, mut files: impl Iterator<Item = PathBuf>) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    files.any(|file| file.canonicalize().is_ok_and(|file| file == path))
}

/// Returns an error that leaves an earlier unfinished encode unchanged.
fn stays(error: Error, file: &OutputFile) -> Error {
    let safe = format!("the unfinished encode is kept in {}; remove it to start again", file.work_path().display());
    Error::Unfinished { cause: Box::new(error), safe }
}

/// Describes the kept chunks of an unfinished encode.
fn kept(partial: &Path, chunks: &str, on_disk: &std::io::Result<()>) -> String {
    let how = match on_disk {
        Ok(()) => "safe".to_owned(),
        Err(error) => format!("kept, possibly not on disk ({error}),"),
    };
    format!("{how} in {}: {chunks}", partial.display())
}

/// Notes clipped pixels, also with --quiet.
fn note_clipping(path: &Path, summary: &EncodeSummary) {
    if summary.clipped_pixels > 0 {
        output::note(format_args!(
            "{}: {} of {} colour pixels ({:.2}%) were clipped to 8 bits: see --exposure and --hdr",
            path.display(),
            summary.clipped_pixels,
            summary.color_pixels,
            100.0 * summary.clipped_pixels as f64 / summary.color_pixels as f64
        ));
    }
}

pub fn text(path: &Path, report: &EncodeReport) -> String {
    let EncodeReport { summary, ratio_percent, seconds, .. } = report;
    let resumed = match summary.resumed_chunks {
        0 => String::new(),
        count => format!(", {}", counted(count, "resumed chunk")),
    };
    format!(
        "{}: {}, {}, {} of {} raw ({:.2}%), {seconds:.2} s{resumed}",
        path.display(),
        counted(summary.streams as u64, "stream"),
        counted(summary.frames, "image"),
        human_bytes(summary.bytes),
        human_bytes(summary.raw_bytes),
        ratio_percent,
    ) + &depth_lines(summary)
}

fn depth_lines(summary: &EncodeSummary) -> String {
    let probes: Vec<_> = summary.depth.iter().map(|known| (known.probe.as_str(), known.bound)).collect();
    depth_bound::lines(&probes, depth_bound::FEW_PROBES).iter().map(|line| format!("\n{line}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_safe_once_on_disk() {
        let words = |on_disk| kept(Path::new(".a.partial"), "2 chunks", &on_disk);
        let end = "in .a.partial: 2 chunks";
        assert_eq!(words(Ok(())), format!("safe {end}"));
        let lost = words(Err(std::io::Error::other("broken")));
        assert_eq!(lost, format!("kept, possibly not on disk (broken), {end}"));
    }
}
