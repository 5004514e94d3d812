//! What can go wrong, and the exit code that says so.
//!
//! Every error is one sentence for a person: which file, where in it, what was expected, what to do.

use std::fmt::{self, Write};
use std::path::{Path, PathBuf};

/// Result of every fallible function of the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Exit code of a command that compared two things and found them different.
pub const EXIT_DIFFERS: u8 = 1;
/// Exit code for bad input, bad usage and I/O errors.
pub const EXIT_BAD_INPUT: u8 = 2;
/// Exit code after SIGINT, as shells expect it (128 + 2).
pub const EXIT_INTERRUPTED: u8 = 130;

/// An error has at most so many characters.
const MAX_CHARACTERS: usize = 2000;

/// Anything that stops a command.
#[derive(Debug)]
pub enum Error {
    /// The input breaks its own format: damaged, truncated or contradictory.
    Invalid {
        /// File (or `-`) that is broken; empty until [`Error::in_file`] names it.
        file: PathBuf,
        /// Byte offset of the first thing found wrong, where one is known.
        offset: Option<u64>,
        /// Section of the document under `formats/` that is broken, such as `container.md 4`, or empty.
        section: &'static str,
        /// What was expected and what was found.
        message: String,
    },
    /// The input is well formed, but asks for something this version does not do.
    Unsupported {
        /// File (or `-`); empty until [`Error::in_file`] names it.
        file: PathBuf,
        /// What is not supported and what to do instead.
        message: String,
    },
    /// The operating system refused to read or write.
    Io {
        /// File (or `-`).
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The command line asks for something that makes no sense.
    Usage(String),
    /// SIGINT or SIGTERM arrived; nothing unfinished is left under a final name.
    Interrupted,
    /// Work was cut short, and a part of it can be gone on with.
    Unfinished {
        /// Why.
        cause: Box<Error>,
        /// What of it is safe, where, and what goes on with it.
        safe: String,
    },
}

impl Error {
    /// A broken input, not yet tied to a file.
    pub fn invalid(message: impl Into<String>) -> Self {
        Error::Invalid { file: PathBuf::new(), offset: None, section: "", message: message.into() }
    }

    /// A broken input at a byte offset, with the section of `formats/` that it breaks.
    pub fn invalid_at(section: &'static str, offset: u64, message: impl Into<String>) -> Self {
        Error::Invalid { file: PathBuf::new(), offset: Some(offset), section, message: message.into() }
    }

    /// Something that this version does not do, not yet tied to a file.
    pub fn unsupported(message: impl Into<String>) -> Self {
        Error::Unsupported { file: PathBuf::new(), message: message.into() }
    }

    /// A read or write that failed.
    pub fn io(file: impl AsRef<Path>, source: std::io::Error) -> Self {
        Error::Io { file: file.as_ref().to_path_buf(), source }
    }

    /// Names the file, unless an inner call already did.
    #[must_use]
    pub fn in_file(mut self, path: impl AsRef<Path>) -> Self {
        if let Error::Invalid { file, .. } | Error::Unsupported { file, .. } | Error::Io { file, .. } = &mut self
            && file.as_os_str().is_empty()
        {
            *file = path.as_ref().to_path_buf();
        }
        self
    }

    /// Puts words in front of the message, such as `frame 7: `.
    #[must_use]
    pub fn context(mut self, before: impl fmt::Display) -> Self {
        match &mut self {
            Error::Invalid { message, .. } | Error::Unsupported { message, .. } | Error::Usage(message) => {
                *message = format!("{before}: {message}");
            }
            Error::Io { source, .. } => {
                *source = std::io::Error::new(source.kind(), format!("{before}: {source}"));
            }
            Error::Interrupted => {}
            Error::Unfinished { cause, .. } => {
                let inner = std::mem::replace(&mut **cause, Error::Interrupted);
                **cause = inner.context(before);
            }
        }
        self
    }

    /// The process exit code that goes with the error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Interrupted => EXIT_INTERRUPTED,
            Error::Unfinished { cause, .. } => cause.exit_code(),
            _ => EXIT_BAD_INPUT,
        }
    }
}

/// Writes words in which names and texts of a file may stand: control characters, which a terminal would obey, and ends of
/// lines are written as `\u{1b}` or `\n`, and words without end are cut.
struct Plain<'a, 'f> {
    out: &'a mut fmt::Formatter<'f>,
    left: usize,
}

impl Plain<'_, '_> {
    fn put(&mut self, c: char) -> fmt::Result {
        let left = self.left;
        self.left = left.saturating_sub(1);
        match left {
            0 => Ok(()),
            1 => self.out.write_char('…'),
            _ => self.out.write_char(c),
        }
    }
}

impl fmt::Write for Plain<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars() {
            if c.is_control() {
                c.escape_default().try_for_each(|c| self.put(c))?;
            } else {
                self.put(c)?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let f = &mut Plain { out: f, left: MAX_CHARACTERS };
        let name = |file: &Path, f: &mut Plain<'_, '_>| -> fmt::Result {
            if file.as_os_str().is_empty() { Ok(()) } else { write!(f, "{}: ", file.display()) }
        };
        match self {
            Error::Invalid { file, offset, section, message } => {
                name(file, f)?;
                if let Some(offset) = offset {
                    write!(f, "at byte {offset}: ")?;
                }
                f.write_str(message)?;
                if section.is_empty() { Ok(()) } else { write!(f, " (formats/{section})") }
            }
            Error::Unsupported { file, message } => {
                name(file, f)?;
                f.write_str(message)
            }
            Error::Io { file, source } => {
                name(file, f)?;
                write!(f, "{source}")
            }
            Error::Usage(message) => f.write_str(message),
            Error::Interrupted => f.write_str("interrupted; no unfinished file was left behind"),
            Error::Unfinished { cause, safe } => match &**cause {
                Error::Interrupted => write!(f, "interrupted; {safe}"),
                cause => write!(f, "{cause}; {safe}"),
            },
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::Io { source, .. } => Some(source),
            Error::Unfinished { cause, .. } => Some(&**cause),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_that_a_terminal_does_not_obey() {
        let error = Error::invalid("probe \"a\nb\u{1b}[2J\": é").in_file("x\ty");
        assert_eq!(error.to_string(), "x\\ty: probe \"a\\nb\\u{1b}[2J\": é");
        let long = Error::invalid("word ".repeat(100_000)).to_string();
        assert_eq!(long.chars().count(), MAX_CHARACTERS);
        assert!(long.ends_with('…'), "{long}");
    }
}
