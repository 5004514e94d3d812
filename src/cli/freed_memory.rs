//! Freed memory is given back to the system where `--memory` limits it.
//!
//! glibc maps blocks from 128 KiB on and unmaps them when they are freed, but raises that size to each block that it unmaps, up to 32 MiB,
//! and from then on keeps twice as much of freed memory in the arena of each thread. Budgets count what is in use: with images of 4096x2048
//! pixels and four threads a process took up to 250 MB more. An environment variable keeps the size as it is, for 3 to 7% of the time of an
//! encode and up to 19% of a decode into files; glibc reads it when a process starts, so the process starts itself again.

use std::ffi::OsString;

#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MMAP_THRESHOLD: [&str; 2] = ["MALLOC_MMAP_THRESHOLD_", "131072"];
/// Set in a program that was started again: it starts no other.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const STARTED_AGAIN: &str = "LIGHTFOLD_STARTED_AGAIN";

/// Starts the program again with the variable set, where `--memory` is given. Returns where it is not, or where starting fails.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn restart_within_limit(arguments: &[OsString]) {
    use std::os::unix::process::CommandExt;

    let is_limit = |word: &OsString| word == "--memory" || word.as_encoded_bytes().starts_with(b"--memory=");
    if !arguments.iter().any(is_limit) || std::env::var_os(STARTED_AGAIN).is_some() {
        return;
    }
    let (Ok(program), [typed, words @ ..]) = (std::env::current_exe(), arguments) else { return };
    // A loader that was given the program would take the first word for one.
    if program.file_name().is_none_or(|name| name.as_encoded_bytes().starts_with(b"ld")) {
        return;
    }
    let [name, value] = MMAP_THRESHOLD;
    let mut again = std::process::Command::new(program);
    let _ = again.arg0(typed).args(words).env(name, value).env(STARTED_AGAIN, "1").exec();
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn restart_within_limit(_: &[OsString]) {}
