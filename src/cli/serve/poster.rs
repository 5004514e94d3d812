//! Posters: small JPEG pictures of the start of a film.

use std::path::Path;

use glam::DVec3;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, resize};
use image::{Rgb, RgbImage};

use super::quilt_shape::QuiltShape;
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::{ReadLimits, ToneMap};
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use codec::streams::StartView;
use footage::image_files::png;
use footage::image_files::quilt::QuiltLayout;
use render::frame_requests::FrameRequest;
use render::march::SpecularMode;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions};
use render::march::playback::selection::SelectionSettings;
use render::rendered_image::RenderedImage;
use simplify::raster::draw;
use simplify::read_glb::read_glb;

/// Width and height in pixels: that of most windows. The page cuts off the sides.
const SIZE: [u32; 2] = [640, 320];
/// Steps of a ray, and probes that are decoded: a poster is worth no more time.
const STEPS: u32 = 256;
const MAX_VIEWS: usize = 4;
const JPEG_QUALITY: u8 = 80;

/// Renders the first frame of a container.
pub fn of_container(path: &Path, start: StartView) -> Result<Vec<u8>> {
    let decoder = Decoder::open(path)?;
    let selection = SelectionSettings { most: Some(MAX_VIEWS), ..SelectionSettings::default() };
    let mut playback = Playback::new(&decoder, PlaybackOptions { selection, ..PlaybackOptions::default() })?;
    let request = FrameRequest { frame: playback.player.frames().first, cameras: vec![camera(start)?] };
    let options =
        PictureOptions { size: SIZE, steps: STEPS, specular: SpecularMode::None, ..PictureOptions::default() };
    let shown = playback.show(&request, &mut CpuRenderer::new(options), &Silent)?;
    let rendered = shown.pictures.first().ok_or_else(|| Error::invalid("no picture was rendered"))?;
    rendered_jpeg(&rendered.image)
}

/// Draws a simplified scene.
pub fn of_scene(path: &Path, start: StartView) -> Result<Vec<u8>> {
    let drawn = draw(&read_glb(path)?.quads, &camera(start)?, SIZE);
    rendered_jpeg(&drawn.over_black(SIZE)?)
}

/// Scales the middle view of a quilt, where the page opens it (viewer/src/quilt.ts).
pub fn of_quilt(path: &Path, shape: QuiltShape) -> Result<Vec<u8>> {
    let quilt = png::read_rgba8(path, &ReadLimits::default())?;
    let layout = QuiltLayout::new(shape.columns, shape.rows)?;
    let [width, height] = [quilt.width() / shape.columns, quilt.height() / shape.rows];
    let corner = layout.corner(shape.columns * shape.rows / 2, [width, height]);
    let [left, top] = corner.ok_or_else(|| Error::invalid("the quilt has no middle view"))?;
    let view = RgbImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = quilt.get(left + x, top + y);
        Rgb([r, g, b])
    });
    let [most_wide, most_high] = SIZE.map(f64::from);
    let wide = most_wide.min(most_high * shape.aspect);
    let size = [wide, wide / shape.aspect].map(|side| (side.round() as u32).max(1));
    jpeg(&resize(&view, size[0], size[1], FilterType::Triangle))
}

fn camera(start: StartView) -> Result<Camera> {
    let [width, height] = SIZE.map(f64::from);
    let lens = Lens { aspect: width / height, ..Lens::new(start.fov_y_deg) };
    let [eye, look_at] = [start.eye, start.look_at].map(DVec3::from_array);
    Camera::look_at(eye, look_at, DVec3::Y, lens)
}

fn rendered_jpeg(image: &RenderedImage) -> Result<Vec<u8>> {
    let codes = image.codes(ToneMap::default());
    jpeg(&RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| Rgb(codes.get(x, y))))
}

fn jpeg(picture: &RgbImage) -> Result<Vec<u8>> {
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY);
    picture.write_with_encoder(encoder).map_err(|error| Error::invalid(error.to_string()))?;
    Ok(jpeg)
}
