//! Picture streams on standard output, for other programs.

use std::io::Stdout;
use std::path::Path;

use clap::Args;

use super::{Choices, check_stdout, one_of};
use crate::refuse;
use codec::error::Result;
use footage::files::standard_output;
use footage::image_files::picture_stream::{FrameRate, PictureStream, StreamFormat};

const STREAM_FORMATS: &Choices<StreamFormat> = &[
    ("png", StreamFormat::Png, "Concatenated PNG files"),
    ("y4m", StreamFormat::Y4m, "YUV4MPEG2, 4:4:4, 8 bits, BT.709 limited range; colour only"),
    ("raw", StreamFormat::Raw, "A line of text, then codes"),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct StreamArgs {
    /// Format of pictures on standard output (-o -). y4m stores the frame rate of the container. png does not: ffmpeg
    /// assumes 25 unless -framerate is given. raw starts with a line of text such as "width=640 height=480
    /// pixel_format=rgb24 fps=24/1", followed by codes row by row: 8-bit red, green and blue, or 16-bit depth
    /// (gray16le). y4m and raw have no alpha; colour is composited over black [default: png]
    #[arg(long, value_name = "FORMAT", value_parser = one_of(STREAM_FORMATS))]
    pub stream_format: Option<StreamFormat>,
}

impl StreamArgs {
    /// Opens the stream on standard output. `None` if the output is something else.
    pub fn open(self, output: Option<&Path>, has_report: bool, fps: f64) -> Result<Option<PictureStream<Stdout>>> {
        if output != Some(Path::new("-")) {
            return match self.stream_format {
                Some(_) => refuse("--stream-format applies to standard output: add -o -"),
                None => Ok(None),
            };
        }
        check_stdout(Path::new("-"), has_report)?;
        let format = self.stream_format.unwrap_or(StreamFormat::Png);
        Ok(Some(PictureStream::new(standard_output()?, format, FrameRate::of(fps))))
    }
}
