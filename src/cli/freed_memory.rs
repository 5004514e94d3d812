//! Returns freed memory to the system if `--memory` limits it.
//!
//! glibc allocates blocks of at least 128 KiB with mmap and unmaps them when they are freed. Each unmapped block raises
//! this threshold to its size, up to 32 MiB, and twice the threshold of freed memory then stays in the arena of each
//! thread. Budgets count only memory in use: with images of 4096x2048 pixels and four threads a process took up to 250
//! MB more. An environment variable fixes the threshold, at the cost of 3 to 7% of the time of an encode and up to 19%
//! of a decode into files. glibc reads the variable at process start, so the process restarts itself.

use std::ffi::OsString;

#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MMAP_THRESHOLD: [&str; 2] = ["MALLOC_MMAP_THRESHOLD_", "131072"];
/// Set in the restarted program, so that it does not restart again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const STARTED_AGAIN: &str = "LIGHTFOLD_STARTED_AGAIN";

/// Restarts the program with the variable set, if `--memory` is given. Returns if it is not given or the restart fails.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn restart_within_limit(arguments: &[OsString]) {
    use std::os::unix::process::CommandExt;

    let is_limit = |word: &OsString| word == "--memory" || word.as_encoded_bytes().starts_with(b"--memory=");
    if !arguments.iter().any(is_limit) || std::env::var_os(STARTED_AGAIN).is_some() {
        return;
    }
    let (Ok(program), [typed, words @ ..]) = (std::env::current_exe(), arguments) else { return };
    // If the program was started through a dynamic loader, the loader would take the first argument for the program.
    if program.file_name().is_none_or(|name| name.as_encoded_bytes().starts_with(b"ld")) {
        return;
    }
    let [name, value] = MMAP_THRESHOLD;
    let mut again = std::process::Command::new(program);
    let _ = again.arg0(typed).args(words).env(name, value).env(STARTED_AGAIN, "1").exec();
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn restart_within_limit(_: &[OsString]) {}
