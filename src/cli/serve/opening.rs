//! Start of a film in the page: its first camera, and a small picture from there, the poster.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::poster;
use super::quilt_shape::QuiltShape;
use codec::decode::Decoder;
use codec::error::Result;
use codec::streams::StartView;
use evaluate::cameras::{self, ReadSettings};
use render::views::start_view;

/// Name of the poster on the site.
pub const POSTER: &str = "poster.jpg";
pub const POSTER_MEDIA_TYPE: &str = "image/jpeg";

/// Content of a film, by which its poster is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Content {
    #[default]
    Container,
    Scene,
    Quilt(QuiltShape),
}

/// The start of a film.
#[derive(Debug, Default)]
pub struct Opening {
    path: PathBuf,
    content: Content,
    /// `None` for quilts, for containers that cannot be rendered, and for scenes without a camera.
    pub start: Option<StartView>,
    poster: OnceLock<Option<Vec<u8>>>,
}

impl Opening {
    /// Determines the start of a film. A film that cannot be read has none: the page reports why.
    pub fn new(path: &Path, content: Content) -> Opening {
        let start = match content {
            Content::Container => Decoder::open(path).ok().and_then(|decoder| start_view(&decoder)),
            Content::Scene => scene_camera(path),
            Content::Quilt(_) => None,
        };
        Opening { path: path.to_path_buf(), content, start, poster: OnceLock::new() }
    }

    /// True if a poster can be drawn, unless the film is damaged.
    pub fn has_poster(&self) -> bool {
        self.start.is_some() || matches!(self.content, Content::Quilt(_))
    }

    /// Returns the poster as JPEG, drawn by the first call; `None` if there is none.
    pub fn poster(&self) -> Option<&[u8]> {
        self.poster.get_or_init(|| self.draw()?.ok()).as_deref()
    }

    fn draw(&self) -> Option<Result<Vec<u8>>> {
        match self.content {
            Content::Container => self.start.map(|start| poster::of_container(&self.path, start)),
            Content::Scene => self.start.map(|start| poster::of_scene(&self.path, start)),
            Content::Quilt(shape) => Some(poster::of_quilt(&self.path, shape)),
        }
    }
}

/// Returns the camera that simplification stores in a scene.
fn scene_camera(path: &Path) -> Option<StartView> {
    let camera = cameras::read(path, ReadSettings::default()).ok()?.cameras.first()?.timed.camera;
    let [eye, look_at] = [camera.eye(), camera.eye() + camera.axes()[0]].map(|point| point.to_array());
    let start = StartView { eye, look_at, fov_y_deg: camera.lens().fov_y_deg };
    start.fault().is_none().then_some(start)
}
