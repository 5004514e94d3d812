//! Content and size of the image files of a probe, and of the faces that are read from them.

use codec::error::{Error, Result};
use codec::image::equirect::{FaceMap, check_face_size, full_face_size};
use codec::image::layout::face_size;
use codec::image::{Face, FaceLayout};

use crate::dataset::manifest::MAX_SIDE;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Content {
    Face,
    /// A face as a camera sees it ([`crate::dataset::manifest::FaceFiles::Cameras`]).
    Camera,
    Faces(FaceLayout),
    Equirect,
}

impl Content {
    pub fn words(self) -> &'static str {
        match self {
            Content::Face => "one face",
            Content::Camera => "one face as a camera sees it",
            Content::Faces(FaceLayout::Cross) => "a cross of six faces",
            Content::Faces(FaceLayout::Strip) => "a strip of six faces",
            Content::Equirect => "an equirectangular image",
        }
    }
}

/// Size of image files, and of the faces that are cut or resampled from them.
#[derive(Debug)]
pub(super) struct Shape {
    pub file_size: (u32, u32),
    pub delivered_size: (u32, u32),
    /// Maps of the faces of a panorama; empty for other content.
    pub maps: Vec<FaceMap>,
}

impl Shape {
    /// Creates the shape of files of `file_size`, each with one picture of `picture_size`, or with those of two eyes. `side` is the
    /// side of the faces of panoramas, if the caller chose one.
    pub fn new(content: Content, file_size: (u32, u32), picture_size: (u32, u32), side: Option<u32>) -> Result<Shape> {
        let (width, height) = picture_size;
        if content == Content::Equirect && u64::from(width) != 2 * u64::from(height) {
            return Err(Error::invalid(format!(
                "an equirectangular image is twice as wide as it is high, but the size here is {width}x{height}"
            )));
        }
        let delivered_size = match (content, side) {
            (Content::Face | Content::Camera, None) => picture_size,
            (Content::Faces(layout), None) => {
                let side = face_size(layout, width, height)?;
                (side, side)
            }
            (Content::Equirect, side) => {
                let side = side.unwrap_or(full_face_size(width));
                if side == 0 || side > MAX_SIDE {
                    return Err(Error::Usage(format!("a face size is 1 to {MAX_SIDE} pixels, not {side}")));
                }
                check_face_size(side, width)?;
                (side, side)
            }
            (_, Some(_)) => {
                return Err(Error::Usage("a face size is only for equirectangular input".into()));
            }
        };
        let cut = if content == Content::Equirect { &Face::CUBE[..] } else { &[] };
        let maps = cut.iter().map(|&face| FaceMap::new(face, delivered_size.0, width, height));
        Ok(Shape { file_size, delivered_size, maps: maps.collect::<Result<_>>()? })
    }
}

/// Shapes of the probes of a source, one for each size of files.
#[derive(Debug)]
pub(super) struct Shapes {
    /// Shape of all probes without one of their own.
    common: Shape,
    own: Vec<Shape>,
    /// Index into `own` by probe; `None` for the common shape. It may be shorter than the list of probes.
    by_probe: Vec<Option<usize>>,
}

impl Shapes {
    pub fn new(common: Shape) -> Shapes {
        Shapes { common, own: Vec::new(), by_probe: Vec::new() }
    }

    /// Gives a probe files of a size; `create` makes a shape that no probe has yet.
    pub fn set(&mut self, probe: usize, file_size: (u32, u32), create: impl FnOnce() -> Result<Shape>) -> Result<()> {
        if file_size == self.common.file_size {
            return Ok(());
        }
        let known = self.own.iter().position(|shape| shape.file_size == file_size);
        let at = match known {
            Some(at) => at,
            None => {
                self.own.push(create()?);
                self.own.len() - 1
            }
        };
        if self.by_probe.len() <= probe {
            self.by_probe.resize(probe + 1, None);
        }
        self.by_probe[probe] = Some(at);
        Ok(())
    }

    pub fn of(&self, probe: usize) -> &Shape {
        let own = self.by_probe.get(probe).copied().flatten();
        own.and_then(|at| self.own.get(at)).unwrap_or(&self.common)
    }

    /// The shapes, one for each size of files.
    pub fn all(&self) -> impl Iterator<Item = &Shape> {
        [&self.common].into_iter().chain(&self.own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_with_files_of_one_size_share_a_shape() {
        let of = |width: u32| Shape::new(Content::Equirect, (width, width / 2), (width, width / 2), None);
        let mut shapes = Shapes::new(of(64).unwrap());
        for (probe, width) in [(0, 64), (2, 128), (3, 128), (5, 256)] {
            shapes.set(probe, (width, width / 2), || of(width)).unwrap();
        }
        let widths: Vec<u32> = (0..7).map(|probe| shapes.of(probe).file_size.0).collect();
        assert_eq!(widths, [64, 64, 128, 128, 64, 256, 64]);
        let counts: Vec<usize> = shapes.all().map(|shape| shape.maps.len()).collect();
        assert_eq!(counts, [6; 3], "one map for each face of each size");
        assert!(shapes.set(1, (64, 64), || Shape::new(Content::Equirect, (64, 64), (64, 64), None)).is_err());
    }
}
