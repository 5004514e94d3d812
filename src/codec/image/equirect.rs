//! Resampling of equirectangular images to cube faces: colour and alpha are filtered, depth takes the nearest sample.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;

use glam::DVec3;
use half::f16;

use super::cube::Face;
use super::plane::{AlphaPlane, ColorPlane, Plane};
use super::projection::ImageProjection;
use crate::error::{Error, Result};

const SUPERSAMPLES: u32 = 4;

/// Maximum side of a face in pixels; the filters of six faces then take at most 30 GiB.
pub const MAX_FACE_SIDE: u32 = 8192;

/// Multiple of which [`full_face_size`] is, in pixels.
const FACE_ALIGN: u32 = 32;

/// Returns the side of cube faces that keep the resolution of an equirectangular image: the centre of a face then has as many
/// pixels per radian as the equator, width / π across the face, rounded up to a multiple of 32. At most half the width and
/// [`MAX_FACE_SIDE`].
pub fn full_face_size(width: u32) -> u32 {
    let side = (f64::from(width) / std::f64::consts::PI).ceil() as u32;
    side.next_multiple_of(FACE_ALIGN).min(width / 2).clamp(1, MAX_FACE_SIDE)
}

/// Checks the side of a cube face: at most [`MAX_FACE_SIDE`], and at most half the width of the equirectangular image.
pub fn check_face_size(size: u32, width: u32) -> Result<()> {
    if size > MAX_FACE_SIDE {
        return Err(Error::unsupported(format!(
            "faces of {size} pixels are too large to be resampled from a panorama: at most {MAX_FACE_SIDE} are \
            supported"
        )));
    }
    let most = (width / 2).max(1);
    if size <= most {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "faces of {size} pixels are too large for a panorama {width} pixels wide: {} keep its resolution, at most \
        {most} are supported",
        full_face_size(width)
    )))
}

/// Sample positions of a cube face in equirectangular images of one size.
///
/// Two tables are computed on first use and kept for all frames, since computing them costs far more than resampling. Nearest
/// samples, for depth and material, take 4 bytes per pixel of the face. Filters, for colour and alpha, take about 75 bytes per
/// pixel if the face is a quarter as wide as the image, and up to 520 for much smaller faces.
#[derive(Debug, Clone)]
pub struct FaceMap {
    pub face: Face,
    size: u32,
    width: u32,
    height: u32,
    filters: OnceLock<Vec<FilterRow>>,
    nearest: OnceLock<Vec<Vec<u32>>>,
}

#[derive(Debug, Clone)]
struct FilterRow {
    ends: Box<[u32]>,
    /// Source pixel index and weight; the weights of one output pixel sum to 1.
    taps: Box<[(u32, f32)]>,
}

impl FaceMap {
    pub fn new(face: Face, size: u32, width: u32, height: u32) -> Result<FaceMap> {
        if size == 0 || width == 0 || height == 0 {
            return Err(Error::invalid("an image without pixels cannot be resampled"));
        }
        if u64::from(width) * u64::from(height) > u64::from(u32::MAX) {
            return Err(Error::unsupported(format!("a panorama of {width}x{height} pixels is too large")));
        }
        check_face_size(size, width)?;
        Ok(FaceMap { face, size, width, height, filters: OnceLock::new(), nearest: OnceLock::new() })
    }

    fn panorama(&self) -> ImageProjection {
        ImageProjection::Equirect { size: [self.width, self.height] }
    }

    /// Computes the filters of colour and alpha in advance, so that the first image does not wait for them.
    pub fn prepare_filters(&self) {
        self.filters();
    }

    fn filters(&self) -> &[FilterRow] {
        self.filters.get_or_init(|| rows(self.size, |row| self.filter_row(row)))
    }

    fn nearest(&self) -> &[Vec<u32>] {
        self.nearest.get_or_init(|| {
            let (width, height, size) = (self.width, self.height, self.size);
            let panorama = self.panorama();
            let pixel = |col, row| {
                let [x, y] = panorama.project(self.face.direction(col, row, size)).unwrap_or_default();
                (y as u32).min(height - 1) * width + x as u32 % width
            };
            rows(size, |row| (0..size).map(|col| pixel(col, row)).collect())
        })
    }

    /// Returns an upper bound of the bytes of the filters; they are allocated once.
    pub fn filter_bytes(&self) -> u64 {
        // The outermost lookups of an output pixel are 3/4 of a pixel apart, and each reads two columns and two rows. In the
        // middle of a face a pixel is 4/π times as wide as the mean of a row, and narrower towards the corners. Around a pole a
        // pixel covers more columns and rows. Measured at a face width of a quarter of the image width: 7.7 taps, and 10.6 around
        // a pole.
        let columns = f64::from(self.width) / (std::f64::consts::PI * f64::from(self.size));
        let across = match self.face {
            Face::Py | Face::Ny => 2.25 + 0.85 * columns,
            _ => 2.0 + 0.65 * columns,
        };
        let taps = (across * across).min(f64::from(4 * SUPERSAMPLES * SUPERSAMPLES));
        let rows = u64::from(self.size) * size_of::<FilterRow>() as u64;
        rows + (self.pixels() as f64 * (taps * size_of::<(u32, f32)>() as f64 + size_of::<u32>() as f64)) as u64
    }

    /// Returns the bytes of the table of nearest samples; it is allocated once.
    pub fn nearest_bytes(&self) -> u64 {
        u64::from(self.size) * size_of::<Vec<u32>>() as u64 + self.pixels() * size_of::<u32>() as u64
    }

    fn pixels(&self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }

    fn filter_row(&self, row: u32) -> FilterRow {
        let cube = ImageProjection::cube_face(self.face, self.size);
        let at = |pixel: u32, sub: u32| f64::from(pixel) + (f64::from(sub) + 0.5) / f64::from(SUPERSAMPLES);
        let (mut ends, mut all) = (Vec::with_capacity(self.size as usize), Vec::new());
        let mut pixel: Vec<(u32, f64)> = Vec::new();
        for col in 0..self.size {
            pixel.clear();
            for (j, i) in (0..SUPERSAMPLES).flat_map(|j| (0..SUPERSAMPLES).map(move |i| (j, i))) {
                self.add_bilinear(cube.unproject([at(col, i), at(row, j)]), &mut pixel);
            }
            pixel.sort_by_key(|tap| tap.0);
            let scale = 1.0 / f64::from(SUPERSAMPLES * SUPERSAMPLES);
            for taps in pixel.chunk_by(|a, b| a.0 == b.0) {
                let weight = taps.iter().map(|tap| tap.1).sum::<f64>() * scale;
                if weight > 0.0 {
                    all.push((taps[0].0, weight as f32));
                }
            }
            ends.push(all.len() as u32);
        }
        FilterRow { ends: ends.into(), taps: all.into() }
    }

    /// Adds the four pixels around a direction. Columns wrap around; across a pole the image continues at the longitude 180°
    /// away.
    fn add_bilinear(&self, direction: DVec3, pixel: &mut Vec<(u32, f64)>) {
        let [x, y] = self.panorama().project(direction).unwrap_or_default().map(|at| at - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        for (dy, wy) in [(0i64, 1.0 - fy), (1, fy)] {
            for (dx, wx) in [(0i64, 1.0 - fx), (1, fx)] {
                let (mut col, mut row) = (left as i64 + dx, top as i64 + dy);
                let (width, height) = (i64::from(self.width), i64::from(self.height));
                if row < 0 || row >= height {
                    row = if row < 0 { -1 - row } else { 2 * height - 1 - row };
                    col += width / 2;
                }
                let index = row.clamp(0, height - 1) * width + col.rem_euclid(width);
                pixel.push((index as u32, wx * wy));
            }
        }
    }

    fn check(&self, width: u32, height: u32) -> Result<()> {
        if (width, height) == (self.width, self.height) {
            return Ok(());
        }
        Err(Error::invalid(format!("the image is {width}x{height}, expected {}x{}", self.width, self.height)))
    }
}

/// Computes rows 0 to `count` on several threads. These are not rayon workers: a worker that waits for the table could steal a
/// task that waits for the same table, which deadlocks.
fn rows<T: Send>(count: u32, make: impl Fn(u32) -> T + Sync) -> Vec<T> {
    let next = AtomicU32::new(0);
    let work = || {
        let taken = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&row| row < count));
        taken.map(|row| (row, make(row))).collect::<Vec<_>>()
    };
    let mut made = thread::scope(|scope| {
        // As many threads as the rayon pool of the caller has. If the system refuses a thread, the others compute its rows.
        let helpers: Vec<_> = (1..rayon::current_num_threads().min(count as usize))
            .map_while(|_| thread::Builder::new().spawn_scoped(scope, work).ok())
            .collect();
        let mut made = work();
        for helper in helpers {
            made.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        made
    });
    made.sort_unstable_by_key(|(row, _)| *row);
    made.into_iter().map(|(_, row)| row).collect()
}

/// Returns the colour of a face: the mean of 4×4 bilinear lookups per pixel.
pub fn resample_color(image: &ColorPlane, map: &FaceMap) -> Result<ColorPlane> {
    resample_filtered(image, map, |light| light.map(f16::to_f32), |sum| sum.map(f16::from_f32))
}

/// Returns the alpha of a face, filtered as colour.
pub fn resample_alpha(image: &AlphaPlane, map: &FaceMap) -> Result<AlphaPlane> {
    resample_filtered(image, map, |alpha| [alpha], |[sum]| sum)
}

fn resample_filtered<T: Copy, const N: usize>(
    image: &Plane<T>,
    map: &FaceMap,
    components: impl Fn(T) -> [f32; N],
    pixel: impl Fn([f32; N]) -> T,
) -> Result<Plane<T>> {
    map.check(image.width(), image.height())?;
    let data = image.data();
    let mut pixels = Vec::with_capacity(map.size as usize * map.size as usize);
    for row in map.filters() {
        let mut start = 0;
        for &end in &row.ends {
            let mut sum = [0f32; N];
            for &(index, weight) in &row.taps[start..end as usize] {
                for (sum, component) in sum.iter_mut().zip(components(data[index as usize])) {
                    *sum += weight * component;
                }
            }
            pixels.push(pixel(sum));
            start = end as usize;
        }
    }
    Plane::new(map.size, map.size, pixels)
}

/// Returns the depth or material of a face by nearest sample, so that surfaces are never averaged.
pub fn resample_nearest<T: Copy>(image: &Plane<T>, map: &FaceMap) -> Result<Plane<T>> {
    map.check(image.width(), image.height())?;
    Plane::new(map.size, map.size, map.nearest().iter().flatten().map(|&index| image.data()[index as usize]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_see_their_own_direction() {
        let (width, height, size) = (512, 256, 64);
        let panorama = ImageProjection::Equirect { size: [width, height] };
        let code = |d: DVec3| [d.x, d.y, d.z].map(f16::from_f64);
        let image = Plane::from_fn(width, height, |x, y| code(panorama.pixel_direction(x, y)));
        let depth = Plane::from_fn(width, height, |x, y| (y * width + x) as f32);
        for face in Face::CUBE {
            let map = FaceMap::new(face, size, width, height).unwrap();
            let faces = resample_color(&image, &map).unwrap();
            let near = resample_nearest(&depth, &map).unwrap();
            for (row, col) in (0..size).flat_map(|row| (0..size).map(move |col| (row, col))) {
                let expected = face.direction(col, row, size).normalize();
                let got = faces.get(col, row).map(f16::to_f64);
                assert!(DVec3::from_array(got).distance(expected) < 0.004, "{face:?} {col},{row}");
                let index = near.get(col, row) as u32;
                let there = panorama.pixel_direction(index % width, index / width);
                // Half the diagonal of a pixel.
                assert!(there.angle_between(expected) < 0.0088, "{face:?} {col},{row}");
            }
        }
    }

    #[test]
    fn filters_take_what_is_stated() {
        for (width, size) in [
            (512, 256),
            (512, 192),
            (512, 128),
            (512, 90),
            (512, 64),
            (512, 40),
            (512, 24),
            (512, 8),
            (64, 32),
            (64, 3),
        ] {
            let maps = Face::CUBE.map(|face| FaceMap::new(face, size, width, width / 2).unwrap());
            for map in &maps {
                let taken: u64 = map
                    .filters()
                    .iter()
                    .map(|row| size_of_val(row) + size_of_val(&*row.ends) + size_of_val(&*row.taps))
                    .sum::<usize>() as u64;
                let stated = map.filter_bytes();
                assert!(
                    taken <= stated && stated * 2 < taken * 3,
                    "{:?} {width} {size}: {taken} of {stated}",
                    map.face
                );
            }
        }
    }

    #[test]
    fn tiny_images() {
        for (width, height) in [(1, 1), (2, 1), (3, 1), (3, 2), (1, 4), (6, 3)] {
            let size = (width / 2).max(1);
            let image = Plane::filled(width, height, [f16::from_f32(2.5); 3]);
            for face in Face::CUBE {
                let map = FaceMap::new(face, size, width, height).unwrap();
                let out = resample_color(&image, &map).unwrap();
                assert!(out.data().iter().all(|pixel| *pixel == [f16::from_f32(2.5); 3]));
                assert!(resample_color(&Plane::filled(9, 9, [f16::ZERO; 3]), &map).is_err());
            }
        }
        assert!(FaceMap::new(Face::Px, 0, 4, 2).is_err());
        assert!(FaceMap::new(Face::Px, 1, 1 << 17, 1 << 16).is_err());
        let message = FaceMap::new(Face::Px, 513, 1024, 512).unwrap_err().to_string();
        assert!(message.contains("513") && message.contains("1024") && message.contains("352"), "{message}");
        FaceMap::new(Face::Px, 512, 1024, 512).unwrap();
        assert!(FaceMap::new(Face::Px, MAX_FACE_SIDE + 1, 1 << 16, 1 << 15).is_err());
    }

    #[test]
    fn plans_are_made_when_asked_for_and_on_any_threads_alike() {
        let image = Plane::from_fn(128, 64, |x, y| [x as f32, y as f32, 1.0].map(f16::from_f32));
        let cut = |threads: usize| {
            let map = FaceMap::new(Face::Py, 33, 128, 64).unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let nearest = resample_nearest(&image, &map).unwrap();
                assert!(map.filters.get().is_none(), "depth alone needs no filters");
                (nearest, resample_color(&image, &map).unwrap())
            })
        };
        assert!([2, 3, 16].into_iter().all(|threads| cut(threads) == cut(1)));
        let map = FaceMap::new(Face::Py, 33, 128, 64).unwrap();
        resample_color(&image, &map).unwrap();
        assert!(map.nearest.get().is_none(), "colour alone needs no nearest samples");
    }
}
