//! Converts errors of the `exr` crate to [`Error`].

use codec::error::Error;

pub(super) fn translate(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::NotSupported(what) => Error::unsupported(format!("the EXR file cannot be read: {what}")),
        exr::error::Error::Invalid(what) => Error::invalid(format!("the EXR file is damaged: {what}")),
        exr::error::Error::Io(source) => Error::io("", source),
        exr::error::Error::Aborted => Error::Interrupted,
    }
}
