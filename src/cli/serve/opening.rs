//! Start of a film in the page: its first camera, and a small picture from there, the poster.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use glam::DVec3;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::ToneMap;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use codec::streams::StartView;
use render::frame_requests::FrameRequest;
use render::march::SpecularMode;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions};
use render::march::playback::selection::SelectionSettings;
use render::views::start_view;

/// Name of the poster on the site.
pub const POSTER: &str = "poster.jpg";
pub const POSTER_MEDIA_TYPE: &str = "image/jpeg";

/// Width and height in pixels: that of most windows. The page cuts off the sides.
const SIZE: [u32; 2] = [640, 320];
/// Steps of a ray, and probes that are decoded: a poster is worth no more time.
const STEPS: u32 = 256;
const MAX_VIEWS: usize = 4;
const JPEG_QUALITY: u8 = 80;

/// The start of a container.
#[derive(Debug, Default)]
pub struct Opening {
    path: PathBuf,
    /// `None` for films other than containers, and for containers that cannot be rendered.
    pub start: Option<StartView>,
    poster: OnceLock<Option<Vec<u8>>>,
}

impl Opening {
    /// Determines the start of a container. A film that cannot be read has none: the page reports why.
    pub fn of_container(path: &Path) -> Opening {
        let start = Decoder::open(path).ok().and_then(|decoder| start_view(&decoder));
        Opening { path: path.to_path_buf(), start, poster: OnceLock::new() }
    }

    /// Returns the poster as JPEG, rendered by the first call; `None` if there is none.
    pub fn poster(&self) -> Option<&[u8]> {
        let render = || self.start.and_then(|start| render_poster(&self.path, start).ok());
        self.poster.get_or_init(render).as_deref()
    }
}

fn render_poster(path: &Path, start: StartView) -> Result<Vec<u8>> {
    let decoder = Decoder::open(path)?;
    let selection = SelectionSettings { most: Some(MAX_VIEWS), ..SelectionSettings::default() };
    let mut playback = Playback::new(&decoder, PlaybackOptions { selection, ..PlaybackOptions::default() })?;
    let [width, height] = SIZE.map(f64::from);
    let lens = Lens { aspect: width / height, ..Lens::new(start.fov_y_deg) };
    let [eye, look_at] = [start.eye, start.look_at].map(DVec3::from_array);
    let camera = Camera::look_at(eye, look_at, DVec3::Y, lens)?;
    let request = FrameRequest { frame: playback.player.frames().first, cameras: vec![camera] };
    let options =
        PictureOptions { size: SIZE, steps: STEPS, specular: SpecularMode::None, ..PictureOptions::default() };
    let shown = playback.show(&request, &mut CpuRenderer::new(options), &Silent)?;
    let rendered = shown.pictures.first().ok_or_else(|| Error::invalid("no picture was rendered"))?;
    let codes: Vec<u8> = rendered.image.codes(ToneMap::default()).data().iter().flatten().copied().collect();
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY)
        .encode(&codes, SIZE[0], SIZE[1], ExtendedColorType::Rgb8)
        .map_err(|error| Error::invalid(error.to_string()))?;
    Ok(jpeg)
}
