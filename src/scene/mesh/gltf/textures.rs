//! Textures of a glTF file (glTF 2.0, section 3.8). Each image is decoded once.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine2, DVec3, Vec2};
use gltf::texture::{Info, Texture, WrappingMode};

use super::buffers::Buffers;
use super::document::is_without_image;
use super::primitives::Coordinates;
use crate::mesh::texture::{ImageTexture, Wrap};
use codec::error::{Error, Result};

/// Textures read so far, `None` for images that cannot be read.
#[derive(Debug, Default)]
pub struct Textures {
    images: BTreeMap<(usize, [Wrap; 2]), Option<Arc<ImageTexture>>>,
    /// [`ImageTexture::means`] by image index.
    means: BTreeMap<usize, [DVec3; 2]>,
    /// One note per image that cannot be read.
    pub notes: Vec<String>,
}

impl Textures {
    pub fn get(&mut self, texture: &Texture, buffers: &mut Buffers) -> Option<Arc<ImageTexture>> {
        let Some(image) = source(texture, buffers) else {
            let number = texture.index();
            let note = format!("texture {number} is ignored: it has no PNG, JPEG, WebP or KTX2 image");
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
            return None;
        };
        let sampler = texture.sampler();
        let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        });
        if let Some(known) = self.images.get(&(image, wrap)) {
            return known.clone();
        }
        let other = self.images.range((image, [Wrap::Repeat; 2])..=(image, [Wrap::Clamp; 2])).next();
        let read = match other.map(|(_, known)| known.clone()) {
            // Decoded before with another wrap mode, or known to be unreadable.
            Some(None) => None,
            Some(Some(known)) => {
                let size = known.pixels.len() as u64;
                let taken = buffers.budget.take(size, 4, format_args!("image {image}"));
                self.noted(image, taken.map(|()| Arc::new(ImageTexture { wrap, ..(*known).clone() })))
            }
            None => self.noted(image, read(image, wrap, buffers).map(Arc::new)),
        };
        self.images.insert((image, wrap), read.clone());
        read
    }

    /// Returns the mean linear colour and the mean codes of a texture; 1 without a texture, or if it cannot be read.
    pub fn means(&mut self, info: Option<&Info>, buffers: &mut Buffers) -> [DVec3; 2] {
        let Some(texture) = info.map(Info::texture) else { return [DVec3::ONE; 2] };
        let Some(image) = self.get(&texture, buffers) else { return [DVec3::ONE; 2] };
        let Some(source) = source(&texture, buffers) else { return [DVec3::ONE; 2] };
        *self.means.entry(source).or_insert_with(|| image.means())
    }

    fn noted(&mut self, image: usize, read: Result<Arc<ImageTexture>>) -> Option<Arc<ImageTexture>> {
        read.map_err(|error| self.notes.push(format!("image {image} is ignored: {error}"))).ok()
    }
}

/// Returns the index of the image of a texture, if it has one.
fn source(texture: &Texture, buffers: &Buffers) -> Option<usize> {
    let texture = buffers.root.textures.get(texture.index())?;
    (!is_without_image(texture)).then(|| texture.source.value())
}

fn read(image: usize, wrap: [Wrap; 2], buffers: &mut Buffers) -> Result<ImageTexture> {
    let image = buffers.root.images.get(image).ok_or_else(|| Error::invalid("it does not exist"))?;
    match (image.buffer_view, &image.uri) {
        (Some(view), _) => {
            let (bytes, range) = buffers.view(view.value())?;
            ImageTexture::decode(&bytes[range], wrap, &mut buffers.budget)
        }
        (None, Some(uri)) => {
            let bytes = buffers.fetch(uri)?;
            let shown = if uri.starts_with("data:") { "data in a URI" } else { uri };
            ImageTexture::decode(&bytes, wrap, &mut buffers.budget).map_err(|error| error.context(shown))
        }
        (None, None) => Err(Error::invalid("it has neither a URI nor a buffer view")),
    }
}

/// Returns the texture coordinates, with the KHR_texture_transform: scale, then rotation, then translation.
pub fn coordinates(info: &Info) -> Coordinates {
    let Some(moved) = info.texture_transform() else {
        return Coordinates { set: info.tex_coord(), transform: Affine2::IDENTITY };
    };
    // The rotation is counter-clockwise on screen, and v grows downwards.
    let transform = Affine2::from_scale_angle_translation(
        Vec2::from_array(moved.scale()),
        -moved.rotation(),
        Vec2::from_array(moved.offset()),
    );
    Coordinates { set: moved.tex_coord().unwrap_or(info.tex_coord()), transform }
}
