//! Errors of the library. Each message is one sentence with the file, the place in it, what was expected and what to do.
//!
//! A message names a setting in backquotes and snake case, such as `` `depth_window` ``; the command line replaces it by its
//! option, `--depth-window`. The command line also chooses the exit codes.

use std::fmt::{self, Write};
use std::path::{Path, PathBuf};

/// Result of all fallible functions of the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Maximum characters of a message; longer messages are cut.
const MAX_CHARACTERS: usize = 2000;

/// Reason why an operation failed.
#[derive(Debug)]
pub enum Error {
    /// The input violates its own format: damaged, truncated or contradictory.
    Invalid {
        /// The file, or `-`; empty until [`Error::in_file`] names it.
        file: PathBuf,
        /// Byte offset of the first error, where known.
        offset: Option<u64>,
        /// Violated section of a document under `formats/`, such as `container.md 4`, or empty.
        section: &'static str,
        /// What was expected and what was found.
        message: String,
    },
    /// The input is well formed, but needs something that this version does not support.
    Unsupported {
        /// The file, or `-`; empty until [`Error::in_file`] names it.
        file: PathBuf,
        /// What is not supported, and what to do instead.
        message: String,
    },
    /// The operating system failed to read or write. The kind of its error shows whether a retry may succeed.
    Io {
        /// The file, or `-`.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Invalid settings or arguments, or an invalid combination of them.
    Usage(String),
    /// The caller's monitor requested a stop. No file with a final name is incomplete.
    Interrupted,
    /// The operation stopped early and can be resumed.
    Unfinished {
        /// Error that stopped the operation.
        cause: Box<Error>,
        /// Files that were kept, where they are, and how to resume.
        safe: String,
    },
}

impl Error {
    /// Creates [`Error::Invalid`]; [`Error::in_file`] names the file later.
    pub fn invalid(message: impl Into<String>) -> Self {
        Error::Invalid { file: PathBuf::new(), offset: None, section: "", message: message.into() }
    }

    /// Creates [`Error::Invalid`] with a byte offset and the violated section of `formats/`.
    pub fn invalid_at(section: &'static str, offset: u64, message: impl Into<String>) -> Self {
        Error::Invalid { file: PathBuf::new(), offset: Some(offset), section, message: message.into() }
    }

    /// Creates [`Error::Unsupported`]; [`Error::in_file`] names the file later.
    pub fn unsupported(message: impl Into<String>) -> Self {
        Error::Unsupported { file: PathBuf::new(), message: message.into() }
    }

    /// Creates [`Error::Io`].
    pub fn io(file: impl AsRef<Path>, source: std::io::Error) -> Self {
        Error::Io { file: file.as_ref().to_path_buf(), source }
    }

    /// Creates [`Error::Io`] of kind [`std::io::ErrorKind::NotFound`], for a file that does not exist (yet).
    pub fn not_found(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Error::io(file, std::io::Error::new(std::io::ErrorKind::NotFound, message.into()))
    }

    /// Creates [`Error::Io`] of kind [`std::io::ErrorKind::ResourceBusy`], for a file or folder that another process is
    /// writing.
    pub fn busy(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Error::io(file, std::io::Error::new(std::io::ErrorKind::ResourceBusy, message.into()))
    }

    /// Returns the file that the error is about, if any.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Error::Invalid { file, .. } | Error::Unsupported { file, .. } | Error::Io { file, .. } => {
                Some(file.as_path()).filter(|file| !file.as_os_str().is_empty())
            }
            Error::Unfinished { cause, .. } => cause.file(),
            Error::Usage(_) | Error::Interrupted => None,
        }
    }

    /// Sets the file, unless an inner call has set it.
    #[must_use]
    pub fn in_file(mut self, path: impl AsRef<Path>) -> Self {
        if let Error::Invalid { file, .. } | Error::Unsupported { file, .. } | Error::Io { file, .. } = &mut self
            && file.as_os_str().is_empty()
        {
            *file = path.as_ref().to_path_buf();
        }
        self
    }

    /// Prepends text to the message, such as `frame 7`.
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
}

/// Formats a count with its noun, in the plural unless the count is 1: `1 tile`, `2 boxes`.
pub fn counted(count: u64, what: &str) -> String {
    let ending = match count {
        1 => "",
        _ if what.ends_with('x') => "es",
        _ => "s",
    };
    format!("{count} {what}{ending}")
}

/// True if a character is escaped in text: a control character, or one that breaks a line or changes the direction of text.
pub fn is_escaped(c: char) -> bool {
    let reorders = matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || reorders
}

/// Escapes the characters of [`is_escaped`] in a name, such as `\u{1b}` or `\n`.
pub fn escaped(name: &str) -> String {
    let escape = |c: char| if is_escaped(c) { c.escape_default().to_string() } else { c.to_string() };
    name.chars().map(escape).collect()
}

/// Writer of an error on one line of at most [`MAX_CHARACTERS`], with the characters of [`is_escaped`] escaped.
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
            if is_escaped(c) {
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
    fn control_characters_are_escaped_and_long_messages_cut() {
        let error = Error::invalid("probe \"a\nb\u{1b}[2J\": é").in_file("x\ty");
        assert_eq!(error.to_string(), "x\\ty: probe \"a\\nb\\u{1b}[2J\": é");
        assert_eq!(escaped("a\u{202e}b\u{2028}é"), "a\\u{202e}b\\u{2028}é");
        let long = Error::invalid("word ".repeat(100_000)).to_string();
        assert_eq!(long.chars().count(), MAX_CHARACTERS);
        assert!(long.ends_with('…'), "{long}");
    }
}
