//! Short help (`-h`) that fits a screen: only the main options. `--help` shows all of them, with examples.

use clap::{Arg, Command};

/// Options that `-h` shows, in addition to required ones.
const SHOWN: &[(&str, &[&str])] = &[
    ("bc4w", &["output", "stats", "frames", "face", "effort", "json"]),
    ("cameras", &["output", "format", "fps", "json"]),
    ("capture", &["output", "position", "cameras", "frames", "size", "samples", "aov", "resume"]),
    ("decode", &["output", "null", "frames", "stream", "probe", "format", "device", "verify", "keep-going", "json"]),
    ("demo", &["output", "frame-count", "size", "probes", "json"]),
    ("diff", &["max-error", "min-quality", "min-cell-psnr", "exact", "common", "frames", "stream", "streams", "json"]),
    ("encode", &["output", "preset", "max-error", "quality", "stream", "frames", "hdr", "clip", "resume", "json"]),
    ("encode-color", &["output", "quality", "frames", "face", "probe", "hdr", "effort", "resume", "json"]),
    (
        "encode-depth",
        &["output", "max-error", "frames", "face", "probe", "depth-codec", "depth-scale", "effort", "resume", "json"],
    ),
    ("init", &["output", "views", "up", "force", "json"]),
    ("inspect", &["streams", "per-frame", "frames", "verify", "check", "plot", "json", "csv"]),
    (
        "interpolate",
        &["output", "eye", "look-at", "views", "baseline", "view-cone", "focus", "size", "device", "resume", "json"],
    ),
    ("pack", &["output", "max-error", "lzma2", "zstd", "json"]),
    ("place", &["output", "region", "cameras", "until", "start", "lighting", "effort", "plot", "json"]),
    ("quadtree", &["output", "max-error", "frames", "face", "probe", "effort", "resume", "json"]),
    ("quilt", &["output", "quilt", "views", "aspect", "json"]),
    (
        "render",
        &[
            "output",
            "eye",
            "look-at",
            "fov",
            "camera",
            "size",
            "frames",
            "device",
            "reference",
            "error-map",
            "stats",
            "json",
        ],
    ),
    ("scan", &["output", "merge", "shard", "resume", "frames", "json"]),
    ("selftest", &["hard-cases", "family", "list-devices", "json"]),
    ("simplify", &["output", "triangles", "atlas", "region", "effort", "hdr", "ktx2", "stats", "resume", "json"]),
    ("tradeoff", &["output", "sweep", "preset", "budget-seconds", "recommend", "list-knobs", "overwrite", "json"]),
    ("train-color", &["output", "sets", "held-out", "json"]),
    ("train-depth", &["output", "sets", "held-out", "json"]),
    ("view", &["port", "open", "listen", "export", "json"]),
];

const MORE: &str = "--help lists all options";

/// Shortens `-h` of every command.
pub fn with_short_help(root: Command) -> Command {
    shortened(root).mut_arg("progress", hidden).mut_subcommands(|command| {
        let shown = SHOWN.iter().find(|(name, _)| *name == command.get_name()).map_or(&[][..], |(_, shown)| shown);
        let is_shown = |arg: &Arg| {
            arg.is_positional() || arg.is_required_set() || arg.get_long().is_some_and(|name| shown.contains(&name))
        };
        shortened(command).mut_args(|arg| if is_shown(&arg) { arg } else { hidden(arg) })
    })
}

fn hidden(arg: Arg) -> Arg {
    arg.hide_short_help(true)
}

/// Restricts examples and notes to `--help`.
fn shortened(command: Command) -> Command {
    let notes = command.get_after_help().cloned().unwrap_or_default();
    command.after_long_help(notes).after_help(MORE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_help_fits_a_screen_and_names_the_long_one() {
        let root = crate::command();
        let names = root.get_subcommands().filter(|command| !command.is_hide_set()).map(|command| command.get_name());
        let names: Vec<Option<&str>> = std::iter::once(None).chain(names.map(Some)).collect();
        assert!(names.len() > 20);
        for name in names {
            let help = |option: &str| {
                let words = std::iter::once("lightfold").chain(name).chain([option]);
                with_short_help(root.clone()).term_width(100).try_get_matches_from(words).unwrap_err().to_string()
            };
            let (short, long) = (help("-h"), help("--help"));
            let count = short.lines().count();
            assert!(count <= 40, "{name:?} -h has {count} lines:\n{short}");
            // clap does not wrap the usage line.
            let fits = |line: &str| line.chars().count() <= 100 || line.starts_with("Usage: ");
            assert!(short.lines().all(fits), "{short}");
            assert!(short.trim_end().ends_with(MORE), "{short}");
            assert!(long.contains("--progress <FORM>") && !long.contains(MORE), "{long}");
            assert!(name.is_some() || long.contains("Exit codes:"), "{long}");
        }
    }

    #[test]
    fn options_that_are_shown_exist() {
        let root = crate::command();
        for (name, shown) in SHOWN {
            let command = root.find_subcommand(name).unwrap_or_else(|| panic!("{name}"));
            for option in *shown {
                let has = command.get_arguments().any(|arg| arg.get_long() == Some(option));
                assert!(has, "{name} has no option --{option}");
            }
        }
    }
}
