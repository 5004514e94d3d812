//! Runs commands of this program as child processes, and quotes them for a shell.

use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::EXIT_INTERRUPTED;
use crate::global::EXIT_RETRY;
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Polling interval of a child. Its run time comes from its own clock.
const POLL: Duration = Duration::from_millis(2);

/// Set for children. The parent holds the write end of their standard input, a pipe: when it closes, the parent is
/// gone.
const ENDS_WITH_INPUT: &str = "LIGHTFOLD_ENDS_WITH_INPUT";

/// Ends this process when its parent ends or is killed, if the parent requested it.
pub fn end_with_parent() {
    if std::env::var_os(ENDS_WITH_INPUT).is_some() {
        std::thread::spawn(|| {
            // An error also means that the pipe is closed.
            let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
            std::process::exit(EXIT_INTERRUPTED.into());
        });
    }
}

/// Runs command lines of this program.
pub trait Runner {
    /// Runs a command and returns the JSON that it printed. Errors name the command.
    fn run(&self, words: &[OsString]) -> Result<Value>;

    /// Returns the seconds since the program began.
    fn now_seconds(&self) -> f64;
}

/// Runs children one after another, and ends them when the user asks to stop.
pub struct Children<'a> {
    program: PathBuf,
    monitor: &'a dyn Monitor,
    start: Instant,
}

impl<'a> Children<'a> {
    /// Creates a runner for children of this program. `start` is the time at which the program began.
    pub fn new(monitor: &'a dyn Monitor, start: Instant) -> Result<Children<'a>> {
        let program = std::env::current_exe()
            .map_err(|error| Error::Usage(format!("cannot find the path of this program: {error}")))?;
        Ok(Children { program, monitor, start })
    }
}

impl Runner for Children<'_> {
    fn run(&self, words: &[OsString]) -> Result<Value> {
        self.monitor.check()?;
        let failed = |what: String| Error::invalid(format!("{}: {what}", shell_line(words)));
        let io = |error| Error::io(&self.program, error);
        let mut child = Command::new(&self.program)
            .args(words)
            .env(ENDS_WITH_INPUT, "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| io(error).context("cannot start a process"))?;
        let mut input = child.stdin.take();
        let done = std::thread::spawn(move || child.wait_with_output());
        while !done.is_finished() {
            if self.monitor.check().is_err() {
                // The child ends when its input is closed.
                input.take();
            }
            std::thread::sleep(POLL);
        }
        let output = done.join().map_err(|_| failed("its output cannot be read".to_owned()))?.map_err(io)?;
        let status = output.status;
        // A signal to all processes of a terminal may reach a child before its handler is set.
        if status.code() == Some(EXIT_INTERRUPTED.into()) || was_stopped(status) {
            return Err(Error::Interrupted);
        }
        if !status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.trim().lines().last().unwrap_or_default();
            let said = said.strip_prefix("lightfold: ").unwrap_or(said);
            let said = if said.is_empty() { format!("it failed ({status})") } else { said.to_owned() };
            // A failure that may succeed later is not attributed to the point.
            return Err(match status.code() == Some(EXIT_RETRY.into()) {
                true => Error::io("", std::io::Error::new(ErrorKind::WouldBlock, said)).context(shell_line(words)),
                false => failed(said),
            });
        }
        serde_json::from_slice(&output.stdout).map_err(|error| failed(format!("its report is not JSON: {error}")))
    }

    fn now_seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

/// True if a process was ended by SIGINT or SIGTERM.
fn was_stopped(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        const INTERRUPT: i32 = 2;
        const TERMINATE: i32 = 15;
        matches!(std::os::unix::process::ExitStatusExt::signal(&status), Some(INTERRUPT | TERMINATE))
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// Returns a command line of this program, quoted for a POSIX shell.
pub fn shell_line<S: AsRef<OsStr>>(words: &[S]) -> String {
    let words = words.iter().map(|word| shell_word(&word.as_ref().to_string_lossy()));
    std::iter::once("lightfold".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Returns a word for a POSIX shell. It is quoted if it contains special characters.
pub fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,:@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::global::{EXIT_BAD_INPUT, exit_code};
    use codec::monitor::Silent;

    #[test]
    #[cfg(unix)]
    fn what_a_child_may_try_again_its_parent_may_too() {
        let shell = Children { program: "/bin/sh".into(), monitor: &Silent, start: Instant::now() };
        let run = |script: &str| shell.run(&["-c".into(), script.into()]);
        for (code, expected) in [(75, EXIT_RETRY), (2, EXIT_BAD_INPUT), (1, EXIT_BAD_INPUT), (130, EXIT_INTERRUPTED)] {
            let error = run(&format!("echo 'lightfold: a: the disk is full' >&2; exit {code}")).unwrap_err();
            assert_eq!(exit_code(&error), expected, "{error}");
            let said = error.to_string();
            assert!(
                code == 130 || said.starts_with("lightfold -c ") && said.ends_with(": a: the disk is full"),
                "{said}"
            );
        }
        assert_eq!(run("echo '{\"a\": 1}'").unwrap()["a"], 1);
    }

    #[test]
    fn words_of_a_shell() {
        assert_eq!(shell_word("a/b-c_1.%04d"), "a/b-c_1.%04d");
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }
}
