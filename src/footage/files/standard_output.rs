//! Standard output as the destination of a result.

use std::io::{Stdout, stdout};

use codec::error::{Error, Result};

/// Returns standard output. Fails if it is closed: if a shell closes it by `>&-`, Rust opens the null device in its place,
/// for reading and writing, and a result would be lost without an error. A user who discards a result opens the null device
/// for writing only (`>/dev/null`).
pub fn standard_output() -> Result<Stdout> {
    let out = stdout();
    match is_closed(&out) {
        true => Err(Error::Usage(
            "standard output is closed, but the result is written to it: redirect it to a file or a pipe, or specify \
            a file"
                .into(),
        )),
        false => Ok(out),
    }
}

#[cfg(unix)]
fn is_closed(out: &Stdout) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;

    use rustix::fs::{OFlags, fcntl_getfl};
    let place = |meta: std::fs::Metadata| (meta.dev(), meta.ino());
    let opened = out.as_fd().try_clone_to_owned().and_then(|copy| std::fs::File::from(copy).metadata());
    let (Ok(opened), Ok(flags)) = (opened, fcntl_getfl(out)) else { return true };
    let is_null = std::fs::metadata("/dev/null").is_ok_and(|null| place(null) == place(opened));
    is_null && flags & OFlags::RWMODE == OFlags::RDWR
}

#[cfg(not(unix))]
fn is_closed(_out: &Stdout) -> bool {
    false
}
