//! What is fuzzed: functions that take any bytes and say what became of them. The runner and the package of `cargo fuzz`
//! call the same ones.

use lightfold::error::{EXIT_BAD_INPUT, Error, Result};

pub mod container;
pub mod images;
pub mod journal;
pub mod stream;
pub mod texts;

/// What a parser did with an input that it treated properly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It was taken.
    Accepted,
    /// It was refused with an error as errors must be.
    Refused,
}

/// A verdict, or what is wrong.
pub type Judged = std::result::Result<Verdict, String>;

/// A parser under test.
#[derive(Clone, Copy)]
pub struct Target {
    /// Its name on command lines.
    pub name: &'static str,
    /// What it does with an input; panics are findings, too.
    pub run: fn(&[u8]) -> Judged,
    /// Memory that an input may take, in bytes.
    pub bound: fn(&[u8]) -> u64,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target { name: "container", run: container::run, bound: container::bound },
    Target { name: "index", run: container::run, bound: container::bound },
    Target { name: "lzma2", run: container::run_lzma2, bound: container::bound_lzma2 },
    Target { name: "DQPN", run: |bytes| stream::run(*b"DQPN", bytes), bound: |bytes| stream::bound(*b"DQPN", bytes) },
    Target { name: "DQTR", run: |bytes| stream::run(*b"DQTR", bytes), bound: |bytes| stream::bound(*b"DQTR", bytes) },
    Target { name: "DAAB", run: |bytes| stream::run(*b"DAAB", bytes), bound: |bytes| stream::bound(*b"DAAB", bytes) },
    Target { name: "DB4W", run: |bytes| stream::run(*b"DB4W", bytes), bound: |bytes| stream::bound(*b"DB4W", bytes) },
    Target { name: "DAB5", run: |bytes| stream::run(*b"DAB5", bytes), bound: |bytes| stream::bound(*b"DAB5", bytes) },
    Target { name: "MAAB", run: |bytes| stream::run(*b"MAAB", bytes), bound: |bytes| stream::bound(*b"MAAB", bytes) },
    Target { name: "MAB1", run: |bytes| stream::run(*b"MAB1", bytes), bound: |bytes| stream::bound(*b"MAB1", bytes) },
    Target { name: "CCL8", run: |bytes| stream::run(*b"CCL8", bytes), bound: |bytes| stream::bound(*b"CCL8", bytes) },
    Target { name: "CCB1", run: |bytes| stream::run(*b"CCB1", bytes), bound: |bytes| stream::bound(*b"CCB1", bytes) },
    Target { name: "CCB7", run: |bytes| stream::run(*b"CCB7", bytes), bound: |bytes| stream::bound(*b"CCB7", bytes) },
    Target { name: "CCLH", run: |bytes| stream::run(*b"CCLH", bytes), bound: |bytes| stream::bound(*b"CCLH", bytes) },
    Target { name: "CCB6", run: |bytes| stream::run(*b"CCB6", bytes), bound: |bytes| stream::bound(*b"CCB6", bytes) },
    Target { name: "journal", run: journal::run, bound: journal::bound },
    Target { name: "exr", run: images::run_exr, bound: images::bound },
    Target { name: "png", run: images::run_png, bound: images::bound },
    Target { name: "manifest", run: texts::run_manifest, bound: texts::bound },
    Target { name: "cameras", run: texts::run_cameras, bound: texts::bound },
    Target { name: "sweep", run: texts::run_sweep, bound: texts::bound },
    Target { name: "patterns", run: texts::run_patterns, bound: texts::bound },
];

/// Whether an error is one sentence for a person, and ends a command with the code of bad input.
pub fn refused(error: &Error) -> Judged {
    let text = error.to_string();
    if text.trim().is_empty() {
        return Err(format!("an error without words: {error:?}"));
    }
    if text.contains(char::is_control) {
        return Err(format!("an error with control characters: {text:?}"));
    }
    if text.chars().count() > 2000 {
        return Err(format!("an error without end: {}", text.chars().take(200).collect::<String>()));
    }
    match error.exit_code() {
        EXIT_BAD_INPUT => Ok(Verdict::Refused),
        code => Err(format!("exit code {code} for: {text}")),
    }
}

/// The verdict on what a parser answered.
pub fn judge<T>(result: &Result<T>) -> Judged {
    result.as_ref().map_or_else(refused, |_| Ok(Verdict::Accepted))
}
