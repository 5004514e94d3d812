//! A rectangle of values in row-major order.

use half::f16;

use crate::error::{Error, Result};

/// A `width`×`height` image, row 0 first, tightly packed.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane<T> {
    width: u32,
    height: u32,
    data: Vec<T>,
}

/// Linear scene-referred RGB per pixel, in Rec. 709 primaries unless stated otherwise. Half floats, since renderers write them,
/// and since their 65,536 values allow any transfer function or metric to be a table.
pub type ColorPlane = Plane<[f16; 3]>;
/// Depth in metres, `f32::INFINITY` for the background.
pub type DepthPlane = Plane<f32>;
/// Reflection weight, refraction weight and index of refraction per pixel.
pub type MaterialPlane = Plane<[f32; 3]>;
/// Coverage of each pixel by surfaces, 0 to 1.
pub type AlphaPlane = Plane<f32>;
/// Unit normals in world axes; zero for the background.
pub type NormalPlane = Plane<[f32; 3]>;

/// Clamps alpha to 0..1; half floats and filters may exceed that range by up to 0.002. Fails for other values with a message that
/// states the value.
pub fn unit_alpha(alpha: f32) -> std::result::Result<f32, String> {
    if (-0.002..=1.002).contains(&alpha) {
        Ok(alpha.clamp(0.0, 1.0))
    } else {
        Err(format!("has an alpha of {alpha}: 0 to 1 was expected"))
    }
}

impl<T> Plane<T> {
    /// Wraps `data`, whose length must be `width * height`.
    pub fn new(width: u32, height: u32, data: Vec<T>) -> Result<Self> {
        if data.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(Error::invalid(format!("an image of {width}x{height} pixels was given {} values", data.len())));
        }
        Ok(Plane { width, height, data })
    }

    pub fn from_fn(width: u32, height: u32, mut value: impl FnMut(u32, u32) -> T) -> Self {
        let mut data = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                data.push(value(x, y));
            }
        }
        Plane { width, height, data }
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    pub fn height(&self) -> u32 {
        self.height
    }

    pub fn data(&self) -> &[T] {
        &self.data
    }

    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    pub fn row(&self, y: u32) -> &[T] {
        let start = y as usize * self.width as usize;
        &self.data[start..start + self.width as usize]
    }

    pub fn row_mut(&mut self, y: u32) -> &mut [T] {
        let start = y as usize * self.width as usize;
        &mut self.data[start..start + self.width as usize]
    }

    pub fn map<U>(&self, value: impl FnMut(&T) -> U) -> Plane<U> {
        Plane { width: self.width, height: self.height, data: self.data.iter().map(value).collect() }
    }
}

impl<T: Clone> Plane<T> {
    pub fn filled(width: u32, height: u32, value: T) -> Self {
        Plane { width, height, data: vec![value; width as usize * height as usize] }
    }
}

impl<T: Copy> Plane<T> {
    /// Combines two images pixel by pixel.
    ///
    /// # Errors
    /// Fails if the sizes differ.
    pub fn zip<U: Copy, V>(&self, other: &Plane<U>, value: impl Fn(T, U) -> V) -> Result<Plane<V>> {
        if (other.width, other.height) != (self.width, self.height) {
            let [own, others] = [(self.width, self.height), (other.width, other.height)];
            return Err(Error::invalid(format!("images of {}x{} and {}x{} pixels", own.0, own.1, others.0, others.1)));
        }
        let data = self.data.iter().zip(&other.data).map(|(&one, &other)| value(one, other)).collect();
        Ok(Plane { width: self.width, height: self.height, data })
    }

    /// Returns a rectangle of the image; panics if it is not inside.
    pub fn cut(&self, origin: [u32; 2], [width, height]: [u32; 2]) -> Plane<T> {
        Plane::from_fn(width, height, |x, y| self.get(origin[0] + x, origin[1] + y))
    }

    pub fn get(&self, x: u32, y: u32) -> T {
        assert!(x < self.width && y < self.height);
        self.data[y as usize * self.width as usize + x as usize]
    }
}
