//! Converts errors of the `exr` crate to [`Error`].

use codec::error::Error;

pub(super) fn translate(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::NotSupported(what) => {
            Error::unsupported(format!("the EXR file cannot be read: {what}{}", way_out(&what)))
        }
        exr::error::Error::Invalid(what) => Error::invalid(format!("the EXR file is damaged: {what}")),
        exr::error::Error::Io(source) => Error::io("", source),
        exr::error::Error::Aborted => Error::Interrupted,
    }
}

/// Returns how to convert a file, by the reason why it cannot be read.
pub(super) fn way_out(reason: &str) -> &'static str {
    let hints = [
        ("compression", "; save it as ZIP, as with `oiiotool IN.exr -compression zip -o OUT.exr`"),
        ("deep", "; flatten it, as with `oiiotool IN.exr -flatten -o OUT.exr`"),
        ("subsampling", "; save luminance and chroma as RGB, as with `oiiotool IN.exr -o OUT.exr`"),
    ];
    hints.into_iter().find(|(word, _)| reason.contains(word)).map_or("", |(_, hint)| hint)
}
