//! Memory limits of image files.

/// Limits checked before memory is allocated for an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadLimits {
    /// Maximum bytes of decoded pixels of an image file, summed over all layers and channels.
    pub max_image_bytes: u64,
}

impl Default for ReadLimits {
    fn default() -> Self {
        ReadLimits { max_image_bytes: 4 << 30 }
    }
}

impl ReadLimits {
    /// Returns the peak memory in bytes of reading an image file of `file_len` bytes: its decoded pixels twice (as stored and as
    /// returned), or three times if integers are converted to floats, the display window, and the decoder's tables.
    pub fn memory_bound(&self, file_len: u64) -> u64 {
        self.believable(file_len, 64 << 20).saturating_mul(4).saturating_add(64 << 20)
    }

    /// Returns the maximum plausible bytes of pixels of a file of `file_len` bytes, within the limit. Files of any size are
    /// allowed `floor` bytes. Beyond that, no compression of real images exceeds 4096:1, so a header that claims more is damaged
    /// or hostile.
    pub fn believable(&self, file_len: u64, floor: u64) -> u64 {
        self.max_image_bytes.min(floor.max(file_len.saturating_mul(4096)))
    }
}
