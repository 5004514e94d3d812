//! Footage of a coding sweep and the options of all its points, checked before anything runs. Statistics of its depth
//! tiles, within a share of the time budget.

use std::ffi::OsString;
use std::hash::Hash;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::CommandFactory;

use super::fixed::{parse, read};
use crate::progress::{Progress, Until};
use crate::report::machine;
use crate::report::tradeoff::coding::{CODING, Input, into_file, pack};
use crate::report::tradeoff::point::{Point, Setting};
use crate::{Cli, GlobalArgs, refuse};
use codec::depth::tile_psnr::TilePsnr;
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::monitor::Monitor as _;
use codec::ordered::try_map_ordered;
use footage::dataset::manifest;
use footage::dataset::source::Source;
use footage::encode::{EncodeSettings, tile_quality};

/// Encoding options that are set by tradeoff.
const OWN: &[&str] = &["output", "stream", "json", "quiet"];
/// Decoding options that may be given for all points.
const OF_DECODING: &[&str] = &["device", "gpu-index"];

/// Open footage, with the settings that all points share.
pub struct Footage {
    pub input: Input,
    pub source: Source,
    /// Settings for modelling depth tiles on their own: from the options of all points, with effort fast by default.
    pub tiles: EncodeSettings,
    pub tiles_how: String,
    pub knobs: Vec<Setting>,
}

/// Returns the command that encodes footage.
fn encoder(path: &str, kinds: &[StreamKind]) -> Result<&'static str> {
    match kinds {
        _ if manifest::is_dataset(Path::new(path)) => Ok("encode"),
        [StreamKind::Color] => Ok("encode-color"),
        [StreamKind::Depth] => Ok("encode-depth"),
        _ => refuse(format!(
            "{path}: neither a lightfield.json nor a folder with one; for a single sequence add --stream depth or \
            --stream color"
        )),
    }
}

/// Opens footage. `kinds` are the requested kinds of streams, and `words` the options of all points.
pub fn open(path: &str, kinds: &[StreamKind], words: &[String], global: &GlobalArgs) -> Result<Footage> {
    let encoder = encoder(path, kinds)?;
    let (mut input, mut knobs) = fixed(encoder, path, words)?;
    if let Some(threads) = global.threads.filter(|_| knobs.iter().all(|(name, _)| *name != "threads")) {
        knobs.push(("threads", threads.to_string()));
    }
    let mut line: Vec<OsString> = [encoder, path, "-o", "point.lfold"].map(OsString::from).to_vec();
    line.extend(input.encode.iter().map(OsString::from));
    // Other knobs do not affect modelling alone, and might require a setting that is swept.
    let of_tiles = [("effort", "fast"), ("depth-domain", "log")].map(|(name, usual)| {
        let given = knobs.iter().find(|(other, _)| *other == name);
        (name, given.map_or(usual, |(_, value)| value.as_str()))
    });
    let domain_too = if encoder == "encode-color" { 1 } else { 2 };
    line.extend(of_tiles.iter().take(domain_too).map(|(name, value)| format!("--{name}={value}").into()));
    let tiles_how = of_tiles.map(|(name, value)| format!("{} {value}", name.trim_start_matches("depth-"))).join(", ");
    let cli = parse(&line)?;
    let Some(command) = cli.command.as_encoder() else { return refuse(format!("{encoder} does not encode")) };
    let (options, tiles) = command.settings()?;
    let source = command.open(&options)?;
    let frames = |kind| {
        let groups = source.groups().iter().filter(|group| group.kind == kind);
        groups.map(|group| group.frames.count()).max().map(|count| (kind, count))
    };
    let there: Vec<(StreamKind, u64)> = StreamKind::ALL.into_iter().filter_map(frames).collect();
    if let Some(missing) = kinds.iter().find(|kind| there.iter().all(|(other, _)| other != *kind)) {
        return refuse(format!("--stream {}: {path} has no such streams", missing.name()));
    }
    input.kinds = there.into_iter().filter(|(kind, _)| kinds.is_empty() || kinds.contains(kind)).collect();
    input.made_of = made_of(&input, &source)?;
    Ok(Footage { input, source, tiles, tiles_how, knobs })
}

/// Sorts options after `--` by command, and returns those that are knobs.
fn fixed(encoder: &'static str, path: &str, words: &[String]) -> Result<(Input, Vec<Setting>)> {
    let mut input = Input { path: path.into(), encoder, ..Input::default() };
    let mut knobs = Vec::new();
    if words.is_empty() {
        return Ok((input, knobs));
    }
    let line = [path, "-o", "point.lfold"];
    let options = read(encoder, words, &[], (&line, OWN), Some(("decode", OF_DECODING)))?;
    let root = Cli::command();
    let diff = root.find_subcommand("diff").into_iter();
    let of_diff: Vec<&str> = diff.flat_map(clap::Command::get_arguments).filter_map(clap::Arg::get_long).collect();
    for option in options {
        let name = option.name.as_str();
        let word = option.value().map_or_else(|| format!("--{name}"), |value| format!("--{name}={value}"));
        match (CODING.knob(name), option.value()) {
            (Some(knob), Some(value)) => knobs.push((knob.name, value)),
            _ if OF_DECODING.contains(&name) => input.decode.push(word),
            _ => {
                input.diff.extend(of_diff.contains(&name).then(|| word.clone()));
                input.encode.push(word);
            }
        }
    }
    knobs.sort_by_key(|(name, _)| CODING.knobs.iter().position(|knob| knob.name == *name));
    Ok((input, knobs))
}

pub fn check(input: &Input, points: &[Point]) -> Result<()> {
    let output = Path::new("point.lfold");
    let judge = |words: Vec<OsString>| match parse(&words)?.command.as_encoder() {
        Some(command) => command.settings().map(drop),
        None => Ok(()),
    };
    judge(pack(output, output))?;
    for point in points {
        let named = |error: Error| error.context(point);
        judge(into_file(input.encode(point), output)).map_err(named)?;
        judge(into_file(input.temporal(point), output)).map_err(|error| named(error.context("coded in time alone")))?;
        if let Some(words) = input.spatial(point) {
            judge(into_file(words, output)).map_err(|error| named(error.context("without LZMA2")))?;
        }
        judge(input.decode(point, output, 1)).map_err(named)?;
        judge(input.diff(point, output)).map_err(named)?;
    }
    Ok(())
}

/// Returns the configuration hash of the footage, the fixed options, the program and the processor. Reads all files;
/// their times do not count.
pub fn made_of(input: &Input, source: &Source) -> Result<u32> {
    // A rebuilt program may write other bytes.
    let program = std::env::current_exe().map_err(|error| Error::io(Path::new("lightfold"), error))?;
    let full = input.path.canonicalize().unwrap_or_else(|_| input.path.clone());
    let manifest = source.manifest.is_some().then(|| crc_of(&manifest::manifest_path(&full))).transpose()?;
    let groups = source.groups().iter();
    let files: Vec<PathBuf> =
        groups.flat_map(|group| group.frames.iter().filter_map(|frame| source.file(group, frame).ok()?)).collect();
    let contents = try_map_ordered(files.iter().collect(), |file: &PathBuf| crc_of(file))?;
    let names: Vec<_> = files.iter().map(|file| file.file_name()).collect();
    let mut hasher = crc32fast::Hasher::new();
    (env!("CARGO_PKG_VERSION"), crc_of(&program)?, machine::processor(), full, manifest).hash(&mut hasher);
    (&input.encode, &input.diff, &input.decode, names, contents).hash(&mut hasher);
    Ok(hasher.finalize())
}

fn crc_of(path: &Path) -> Result<u32> {
    let io = |error| Error::io(path, error);
    let mut file = std::fs::File::open(path).map_err(io)?;
    let mut hasher = crc32fast::Hasher::new();
    let mut bytes = vec![0; 1 << 20];
    loop {
        match file.read(&mut bytes).map_err(io)? {
            0 => return Ok(hasher.finalize()),
            count => hasher.update(&bytes[..count]),
        }
    }
}

/// Share of the budget that the statistics may take. The points get the rest.
const SHARE: f64 = 1.0 / 3.0;

/// Message for statistics omitted for lack of time.
const LATE: &str = "The statistics of tiles were left out: they did not fit into a third of the budget.";

/// Measures the PSNR of all depth tiles by modelling function. The inner error states why there is no result.
pub fn model_tiles(
    footage: &Footage,
    budget_seconds: Option<f64>,
    global: &GlobalArgs,
) -> Result<Result<TilePsnr, String>> {
    let steps = tile_quality::images(&footage.source);
    let progress = Progress::start(global, "modelling tiles", steps)?;
    let most = budget_seconds.map(|seconds| Duration::from_secs_f64((seconds * SHARE).min(1e9)));
    let until = Until::new(&progress, most, steps);
    match tile_quality::measure(&footage.source, &footage.tiles, &until) {
        Ok(tiles) => Ok(Ok(tiles)),
        Err(Error::Interrupted) if progress.interrupted() => Err(Error::Interrupted),
        Err(Error::Interrupted) => Ok(Err(LATE.to_owned())),
        Err(error) => Ok(Err(format!("The statistics of tiles failed: {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[test]
    fn every_knob_is_an_option_of_its_command_and_takes_its_usual_values() {
        let root = crate::command();
        for knob in &CODING.knobs {
            let commands: &[&str] = match (knob.stage, knob.is_general(), knob.streams[0]) {
                ("decode", ..) => &["decode"],
                ("both", ..) => &["encode", "encode-depth", "encode-color", "decode"],
                (_, true, _) => &["encode", "encode-depth", "encode-color"],
                (_, false, StreamKind::Color) => &["encode", "encode-color"],
                (_, false, StreamKind::Material | StreamKind::Alpha) => &["encode"],
                (_, false, StreamKind::Depth) => &["encode", "encode-depth"],
            };
            let mut built = root.clone();
            built.build();
            for name in commands {
                let found = built.find_subcommand(name).unwrap();
                let has = found.get_arguments().any(|argument| argument.get_long() == Some(knob.name));
                assert!(has, "{name} has no option --{}", knob.name);
                for value in &knob.usual {
                    let implied = knob.implies.iter().filter(|_| *name != "decode");
                    let implied = implied.map(|(name, value)| format!("--{name}={value}"));
                    let line = ["lightfold", name, "in"].map(str::to_owned).into_iter();
                    let output = if *name == "decode" { vec!["--null"] } else { vec!["-o", "out"] };
                    let output = output.into_iter().map(str::to_owned);
                    let line: Vec<String> = line.chain(knob.option(value)).chain(implied).chain(output).collect();
                    let parsed = Cli::try_parse_from(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
                    if let Some(command) = parsed.command.as_encoder() {
                        command.settings().unwrap_or_else(|error| panic!("{line:?}: {error}"));
                    }
                }
            }
        }
    }

    #[test]
    fn defaults_are_those_of_the_options() {
        let mut built = crate::command();
        built.build();
        for knob in &CODING.knobs {
            let command = if knob.stage == "decode" { "decode" } else { "encode" };
            let found = built.find_subcommand(command).unwrap();
            let option = found.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            // Other defaults are stated in the help text of the option.
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
        }
    }

    #[test]
    fn options_of_all_points_go_to_the_commands_that_have_them() {
        let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let of = |line: &str| fixed("encode", "scene", &words(line));
        let (sorted, knobs) =
            of("--hdr --frames 0-3 --psnr 40 --device gpu --gpu-index 1 --depth-channel Z --lzma2").unwrap();
        let knobs: Vec<_> = knobs.iter().map(|(name, value)| format!("{name}={value}")).collect();
        assert_eq!(knobs, ["psnr=40", "lzma2=6", "device=gpu"]);
        let sort = |mut words: Vec<String>| {
            words.sort();
            words.join(" ")
        };
        assert_eq!(sort(sorted.encode), "--depth-channel=Z --frames=0-3 --hdr");
        assert_eq!(sort(sorted.diff), "--depth-channel=Z --frames=0-3 --hdr");
        assert_eq!(sorted.decode, ["--gpu-index=1"]);
        let said = |line: &str| of(line).unwrap_err().to_string();
        assert!(said("--stream depth").contains("tradeoff sets this option"));
        assert!(said("--color-cell 0").contains("'0'"), "{}", said("--color-cell 0"));
        assert!(said("--colour").contains("unexpected argument '--colour'"));
        let (colour, _) = of("--color-channel A").unwrap();
        assert_eq!((colour.encode, colour.diff), (vec!["--color-channel=A".into()], vec!["--color-channel=A".into()]));
        assert!(!said("--color-cell 0").contains('\n'));
    }
}
