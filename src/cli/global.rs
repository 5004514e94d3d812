//! Options, exit codes and messages of every command.

use crate::error::Error;

/// Options of every command.
#[derive(Debug, Clone, clap::Args)]
pub struct GlobalArgs {
    /// Number of threads; the result does not depend on it [default: one per processor]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print results and errors only
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// Exit code of a command whose check failed ([`ExitStatus::Failed`]).
pub const EXIT_FAILED: u8 = 1;
/// Exit code for bad input, bad usage and I/O errors.
pub const EXIT_BAD_INPUT: u8 = 2;
/// Exit code after SIGINT, as shells expect it (128 + 2).
pub const EXIT_INTERRUPTED: u8 = 130;

/// Result of a command that ran to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExitStatus {
    /// Everything checked is within its bounds.
    Passed,
    /// A bound is exceeded, devices disagree, or a manifest is suspect.
    Failed,
}

/// Exit code for an error.
pub fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Interrupted => EXIT_INTERRUPTED,
        Error::Unfinished { cause, .. } => exit_code(cause),
        _ => EXIT_BAD_INPUT,
    }
}

/// Replaces settings, which messages of the library name in backquotes, by options: `` `depth_window` `` by
/// `--depth-window`. Messages of the JSON parser name keys of a file in backquotes, and stay as they are.
pub fn with_option_names(message: &str) -> String {
    let of_a_file = ["unknown field `", "missing field `", "duplicate field `", "unknown variant `"];
    if of_a_file.iter().any(|words| message.contains(words)) {
        return message.to_owned();
    }
    let is_setting = |text: &str| {
        text.starts_with(|c: char| c.is_ascii_lowercase())
            && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let mut text = String::new();
    let mut rest = message;
    while let Some((before, behind)) = rest.split_once('`') {
        text += before;
        rest = behind;
        match behind.split_once('`') {
            Some((name, behind)) if is_setting(name) => {
                text += &format!("--{}", name.replace('_', "-"));
                rest = behind;
            }
            _ => text.push('`'),
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_become_options() {
        let text = with_option_names("use a smaller `depth_tile` or `hdr`; see `lightfold inspect`, `x y`, `");
        assert_eq!(text, "use a smaller --depth-tile or --hdr; see `lightfold inspect`, `x y`, `");
        let key = "cam.json: unknown field `fvo`, expected one of `eye`, `frames`";
        assert_eq!(with_option_names(key), key);
    }
}
