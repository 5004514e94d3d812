//! Rows of numbers that the page writes, as 64-bit floats.

use glam::DVec3;

use codec::error::{Error, Result};
use codec::math::Camera;
use render::views::Rect;

/// Reads numbers in order.
pub struct Numbers<'a> {
    bytes: &'a [u8],
}

impl<'a> Numbers<'a> {
    pub fn new(bytes: &'a [u8]) -> Numbers<'a> {
        Numbers { bytes }
    }

    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Returns the bytes behind the numbers that were read.
    pub fn rest(self) -> &'a [u8] {
        self.bytes
    }

    pub fn take<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let (first, rest) = self.bytes.split_first_chunk().ok_or_else(too_few)?;
            *number = f64::from_le_bytes(*first);
            self.bytes = rest;
        }
        Ok(numbers)
    }

    /// Reads a number from 0 to 2³² − 1 without a fraction.
    pub fn take_u32(&mut self) -> Result<u32> {
        let [number] = self.take()?;
        let integer = number as u32;
        if f64::from(integer) == number { Ok(integer) } else { Err(Error::Usage(format!("{number} is no integer"))) }
    }
}

/// Reads left, top, width and height of a rectangle.
pub fn take_rect(numbers: &mut Numbers<'_>) -> Result<Rect> {
    Ok([numbers.take_u32()?, numbers.take_u32()?, numbers.take_u32()?, numbers.take_u32()?])
}

/// Reads a camera: its eye, forward, right and down, and half the width and half the height of its picture at distance 1.
pub fn take_camera(numbers: &mut Numbers<'_>) -> Result<Camera> {
    let mut vector = || numbers.take().map(DVec3::from_array);
    let (eye, axes) = (vector()?, [vector()?, vector()?, vector()?]);
    Camera::with_window(eye, axes, numbers.take()?, [0.0; 2])
}

fn too_few() -> Error {
    Error::Usage("the page wrote too few numbers".into())
}
