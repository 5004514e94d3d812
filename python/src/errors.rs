//! Conversion of the library's errors to Python exceptions with the same messages.

use std::io;

use library::Error as LibraryError;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    lightfold,
    Error,
    PyValueError,
    "A container that is damaged or not supported, or a setting or array that cannot be used.\n\n\
     The message is one sentence. A name in backquotes is that of a setting, which is an argument of `encode`.\n\n\
     >>> lightfold.encode(\"dark.lfold\", depth=[[[[0.0]]]])\n\
     Traceback (most recent call last):\n\
     lightfold.Error: `depth` of probe 00, face view: pixel (0, 0) of frame 0 lies at 0 m"
);

/// Converts an I/O error to `OSError`, or to its subclass for the error number; an interruption to `KeyboardInterrupt`; and all
/// other errors to `Error`.
pub fn raised(error: LibraryError) -> PyErr {
    match error {
        LibraryError::Io { file, source } => match source.raw_os_error() {
            Some(number) => {
                let text = source.to_string();
                let text = text.split(" (os error").next().unwrap_or_default().to_owned();
                PyOSError::new_err((number, text, file.into_os_string()))
            }
            None => io::Error::new(source.kind(), LibraryError::Io { file, source }.to_string()).into(),
        },
        LibraryError::Interrupted => PyKeyboardInterrupt::new_err(()),
        error => Error::new_err(error.to_string()),
    }
}

pub fn refuse<T>(message: impl Into<String>) -> PyResult<T> {
    Err(Error::new_err(message.into()))
}
