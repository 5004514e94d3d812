//! How much memory a file may ask for.

/// Caps that are checked before anything is allocated for an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadLimits {
    /// Most bytes that the decoded pixels of one image file may take, over all its layers and channels.
    pub max_image_bytes: u64,
}

impl Default for ReadLimits {
    /// 4 GiB an image.
    fn default() -> Self {
        ReadLimits { max_image_bytes: 4 << 30 }
    }
}

impl ReadLimits {
    /// Most bytes that reading an image file of `file_len` bytes takes: its decoded pixels twice (as the file has them and
    /// as they leave), or three times where integers become floats, the display window, and the decoder's tables.
    pub fn memory_bound(&self, file_len: u64) -> u64 {
        self.believable(file_len, 64 << 20).saturating_mul(4).saturating_add(64 << 20)
    }

    /// Bytes of pixels that a file of `file_len` bytes can be believed to hold, never above the cap.
    ///
    /// `floor` is allowed to any file. Beyond it no compression of real images exceeds 4096 to 1, so a header that
    /// claims more is damaged or hostile.
    pub(crate) fn believable(&self, file_len: u64, floor: u64) -> u64 {
        self.max_image_bytes.min(floor.max(file_len.saturating_mul(4096)))
    }
}
