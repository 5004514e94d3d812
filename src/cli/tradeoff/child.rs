//! Runs commands of this program as child processes.

use std::ffi::OsString;
use std::io::{ErrorKind, Read};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::EXIT_INTERRUPTED;
use crate::global::EXIT_RETRY;
use crate::report::tradeoff::runner::{Runner, shell_line};
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

    fn wait(&self, child: &mut Running) -> Result<ExitStatus> {
        loop {
            if let Some(status) = child.0.try_wait().map_err(|error| Error::io(&self.program, error))? {
                return Ok(status);
            }
            self.monitor.check()?;
            std::thread::sleep(POLL);
        }
    }
}

impl Runner for Children<'_> {
    fn run(&self, words: &[OsString]) -> Result<Value> {
        self.monitor.check()?;
        let failed = |what: String| Error::invalid(format!("{}: {what}", shell_line(words)));
        let child = Command::new(&self.program)
            .args(words)
            .env(ENDS_WITH_INPUT, "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| Error::io(&self.program, error).context("cannot start a process"))?;
        let mut child = Running(child);
        let (out, said) = (child.0.stdout.take(), child.0.stderr.take());
        // Both pipes are read while the child runs: a full pipe would block it.
        let (status, out, said) = std::thread::scope(|scope| {
            let out = scope.spawn(move || read(out));
            let said = scope.spawn(move || read(said));
            let status = self.wait(&mut child);
            // Dropping the child ends it, which closes its pipes.
            drop(child);
            (status, out.join().unwrap_or_default(), said.join().unwrap_or_default())
        });
        let status = status?;
        // A signal to all processes of a terminal may reach a child before its handler is set.
        if status.code() == Some(EXIT_INTERRUPTED.into()) || was_stopped(status) {
            return Err(Error::Interrupted);
        }
        if !status.success() {
            let said = String::from_utf8_lossy(&said);
            let said = said.trim().lines().last().unwrap_or_default();
            let said = said.strip_prefix("lightfold: ").unwrap_or(said);
            let said = if said.is_empty() { format!("it failed ({status})") } else { said.to_owned() };
            // A failure that may succeed later is not attributed to the point.
            return Err(match status.code() == Some(EXIT_RETRY.into()) {
                true => Error::io("", std::io::Error::new(ErrorKind::WouldBlock, said)).context(shell_line(words)),
                false => failed(said),
            });
        }
        serde_json::from_slice(&out).map_err(|error| failed(format!("its report is not JSON: {error}")))
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

/// A child that is killed when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn read(from: Option<impl Read>) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(mut from) = from {
        // If reading fails, the bytes read so far are reported.
        let _ = from.read_to_end(&mut bytes);
    }
    bytes
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::global::{EXIT_BAD_INPUT, exit_code};
    use codec::monitor::Silent;

    #[test]
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
}
