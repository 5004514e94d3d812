//! Video files, which ffmpeg encodes from a picture stream.
//!
//! Takes pictures of one even size, in order, and their frame rate. ffmpeg writes into a temporary folder beside the output,
//! from which the file is moved when it is complete.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::refuse;
use codec::error::{Error, Result};
use codec::image::Transfer;
use codec::monitor::Monitor;
use footage::files::OutputFolder;
use footage::image_files::picture_stream::{CodePicture, FrameRate, PictureStream, StreamFormat};

const FFMPEG: &str = "ffmpeg";
/// Polling interval of ffmpeg while it encodes its last pictures.
const POLL: Duration = Duration::from_millis(10);
/// Maximum number of lines of ffmpeg that an error quotes.
const MAX_LINES: usize = 3;

const H264: &[&str] = &["-c:v", "libx264", "-crf", "16"];
const VP9: &[&str] = &["-c:v", "libvpx-vp9", "-crf", "18", "-b:v", "0", "-row-mt", "1"];
const FAST_START: &[&str] = &["-movflags", "+faststart"];

/// File name endings, each with the options of its encoder and of its container.
const KINDS: &[(&str, &[&str], &[&str])] =
    &[("mp4", H264, FAST_START), ("mov", H264, FAST_START), ("mkv", H264, &[]), ("webm", VP9, &[])];

/// The endings, for messages.
pub const FILM_ENDINGS: &str = ".mp4, .mov, .mkv or .webm";

/// True if a file name ends as a video file.
pub fn is_film(path: &Path) -> bool {
    kind_of(path).is_some() && !path.is_dir()
}

fn kind_of(path: &Path) -> Option<&'static (&'static str, &'static [&'static str], &'static [&'static str])> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    KINDS.iter().find(|(name, ..)| *name == ending)
}

/// Properties of the pictures of a film.
#[derive(Debug, Clone, Copy)]
pub struct FilmFormat {
    pub size: [u32; 2],
    pub fps: f64,
    /// Transfer function of the codes, which the file names.
    pub transfer: Transfer,
    /// Number of threads; `None` for the choice of ffmpeg.
    pub threads: Option<u16>,
}

impl FilmFormat {
    /// Returns the options of ffmpeg for a stream in Y4M: 8 bits, 4:2:0, limited range, with the primaries, the matrix and
    /// the transfer function of BT.709.
    fn words(&self, path: &Path) -> Vec<String> {
        let transfer = if self.transfer == Transfer::Linear { "linear" } else { "bt709" };
        let filter =
            format!("format=yuv420p,setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc={transfer}");
        let (_, encoder, container) = kind_of(path).copied().unwrap_or(("mkv", H264, &[]));
        let mut words: Vec<String> = ["-i", "-", "-vf", &filter].map(str::to_owned).into();
        let tags = ["-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", transfer];
        words.extend(tags.iter().chain(encoder).chain(container).map(|&word| word.to_owned()));
        words.extend(self.threads.into_iter().flat_map(|threads| ["-threads".to_owned(), threads.to_string()]));
        words
    }
}

/// A video file that ffmpeg is encoding. Dropping it ends ffmpeg and removes the unfinished file.
#[derive(Debug)]
pub struct Film {
    path: PathBuf,
    name: OsString,
    stream: PictureStream<ChildStdin>,
    encoder: Encoder,
    /// Dropped after ffmpeg, which writes into it.
    folder: OutputFolder,
}

impl Film {
    /// Starts ffmpeg. Fails if it is not installed, or if the size is odd.
    pub fn create(path: &Path, format: FilmFormat) -> Result<Film> {
        if path.to_string_lossy().contains('%') {
            return refuse(format!("{}: a film is one file: leave out the field of its name", path.display()));
        }
        let [width, height] = format.size;
        if width % 2 != 0 || height % 2 != 0 {
            return refuse(format!(
                "{}: pictures of {width}x{height} pixels, where a film needs an even width and height: set --size WxH",
                path.display(),
            ));
        }
        let name = path.file_name().unwrap_or_default().to_owned();
        let root = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = OutputFolder::create(root)?;
        let (encoder, pipe) = Encoder::start(path, &folder.work_path().join(&name), &format.words(path))?;
        let stream = PictureStream::new(pipe, StreamFormat::Y4m, FrameRate::of(format.fps));
        Ok(Film { path: path.to_path_buf(), name, stream, encoder, folder })
    }

    /// Writes the next picture.
    pub fn put(&mut self, picture: &CodePicture) -> Result<()> {
        match self.stream.put(picture) {
            // ffmpeg has closed the pipe, and says why.
            Err(Error::Io { source, .. }) => {
                let status = self.encoder.child.wait().map_err(|error| Error::io(&self.path, error))?;
                Err(self.failure(status).unwrap_or_else(|| Error::io(&self.path, source)))
            }
            put => put.map_err(|error| error.in_file(&self.path)),
        }
    }

    /// Waits until ffmpeg has written the file, and moves it into place. Returns its size in bytes.
    pub fn commit(self, monitor: &dyn Monitor) -> Result<u64> {
        let Film { path, name, stream, mut encoder, folder } = self;
        // Closes the pipe.
        drop(stream);
        let io = |error| Error::io(&path, error);
        let status = loop {
            if let Some(status) = encoder.child.try_wait().map_err(io)? {
                break status;
            }
            monitor.check()?;
            std::thread::sleep(POLL);
        };
        let file = folder.work_path().join(&name);
        encoder.check(status, [&path, &file])?;
        let bytes = std::fs::metadata(file).map_err(io)?.len();
        folder.commit()?;
        Ok(bytes)
    }

    fn failure(&mut self, status: ExitStatus) -> Option<Error> {
        self.encoder.check(status, [&self.path, &self.folder.work_path().join(&self.name)]).err()
    }
}

/// A process of ffmpeg. Dropping it ends the process.
#[derive(Debug)]
struct Encoder {
    child: Child,
    /// Returns the last lines that ffmpeg wrote.
    said: Option<JoinHandle<VecDeque<String>>>,
}

impl Encoder {
    /// Starts ffmpeg, which writes to `file`. Returns the pipe that it reads.
    fn start(path: &Path, file: &Path, words: &[String]) -> Result<(Encoder, ChildStdin)> {
        // Not a protocol, whatever characters the name contains.
        let mut output = OsString::from("file:");
        output.push(file);
        let mut command = Command::new(FFMPEG);
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-f", "yuv4mpegpipe"]).args(words).arg(output);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        // Ctrl-C reaches this process only, which then ends ffmpeg.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::Usage(format!(
                "{0}: ffmpeg, which encodes films, is not installed: install it, or pipe the pictures to it: lightfold \
                render ... --stream-format y4m -o - | ffmpeg {1} {0}",
                path.display(),
                words.join(" "),
            )),
            _ => Error::io(FFMPEG, error).context("cannot start a process"),
        })?;
        let said = child.stderr.take().map(|errors| std::thread::spawn(move || last_lines(errors)));
        let pipe = child.stdin.take();
        let encoder = Encoder { child, said };
        let pipe = pipe.ok_or_else(|| Error::invalid("ffmpeg has no standard input").in_file(path))?;
        Ok((encoder, pipe))
    }

    /// Fails with the last lines of ffmpeg, in which the path of the output replaces that of the unfinished file.
    fn check(&mut self, status: ExitStatus, [path, file]: [&Path; 2]) -> Result<()> {
        if status.success() {
            return Ok(());
        }
        let lines: Vec<String> = self.said.take().and_then(|said| said.join().ok()).into_iter().flatten().collect();
        let said = lines.join("; ").replace(&file.display().to_string(), &path.display().to_string());
        if said.contains("No space left on device") {
            return Err(Error::io(path, ErrorKind::StorageFull.into()));
        }
        let said = if said.is_empty() { status.to_string() } else { said };
        Err(Error::invalid(format!("ffmpeg failed: {said}")).in_file(path))
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        // It is killed only if it is still running; errors mean that it has ended.
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Reads lines to the end of a pipe, and returns the last ones.
fn last_lines(pipe: impl Read) -> VecDeque<String> {
    let mut lines = VecDeque::new();
    for line in BufReader::new(pipe).split(b'\n').map_while(std::result::Result::ok) {
        let line = String::from_utf8_lossy(&line).trim().to_owned();
        if !line.is_empty() {
            lines.push_back(line);
        }
        if lines.len() > MAX_LINES {
            lines.pop_front();
        }
    }
    lines
}
