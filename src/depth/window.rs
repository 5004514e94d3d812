//! The picture of a decoder, and which pixels a frame must send (the window rule, depth.md 4).
//!
//! Based on: CALF 5.2, algorithm 3. The paper compares source frames with each other; a pixel that creeps by less than
//! epsilon a frame is then never sent and drifts without limit. Here the loop is closed: the source is compared with the
//! decoder's picture. A pixel is sent while fewer than W frames have passed since it changed.

use crate::depth::texel::Texel;

/// The picture that every decoder holds, and how long each pixel has been held.
#[derive(Debug, Clone)]
pub struct WindowState<T> {
    held: Vec<T>,
    /// Frames since the pixel changed, saturating; `u8::MAX` also for "not since the keyframe".
    age: Vec<u8>,
    /// One byte a pixel: 1 where the last frame must be sent.
    mask: Vec<u8>,
}

impl<T: Texel> WindowState<T> {
    /// Starts at a keyframe: everything is held as it is.
    pub fn new(keyframe: &[T]) -> Self {
        WindowState { held: keyframe.to_vec(), age: vec![u8::MAX; keyframe.len()], mask: vec![0; keyframe.len()] }
    }

    pub fn restart(&mut self, keyframe: &[T]) {
        self.held.copy_from_slice(keyframe);
        self.age.fill(u8::MAX);
    }

    /// Takes the next frame in. Afterwards [`Self::held`] is within `epsilon` of `source` in every pixel and
    /// [`Self::mask`] says what must be sent; the answer is whether that is anything.
    pub fn advance(&mut self, source: &[T], epsilon: u16, window: u8) -> bool {
        let mut any = 0;
        for (((held, age), mask), &source) in self.held.iter_mut().zip(&mut self.age).zip(&mut self.mask).zip(source) {
            let keep = T::within(*held, source, epsilon);
            *held = if keep { *held } else { source };
            *age = if keep { age.saturating_add(1) } else { 0 };
            *mask = u8::from(*age < window);
            any |= *mask;
        }
        any != 0
    }

    pub fn held(&self) -> &[T] {
        &self.held
    }

    /// 1 for every pixel that the last frame must send.
    pub fn mask(&self) -> &[u8] {
        &self.mask
    }
}
