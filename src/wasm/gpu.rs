//! The form of chunks that graphics devices read: files of `src/gpu` that need no device, under the paths that they use.

#[allow(dead_code)]
#[path = "../gpu/layout.rs"]
pub mod layout;
#[allow(dead_code)]
#[path = "../gpu/prepare.rs"]
pub mod prepare;
#[allow(dead_code)]
#[path = "../gpu/transform_tables.rs"]
pub mod transform_tables;

/// The functions of `src/gpu/pictures.rs` that prepared chunks use.
pub mod pictures {
    /// Returns the words of a row of `width` codes.
    pub fn code_stride(width: u32) -> u32 {
        width.div_ceil(2)
    }

    /// Packs three half floats into two words.
    pub fn pack_halves([r, g, b]: [u16; 3]) -> [u32; 2] {
        [u32::from(r) | u32::from(g) << 16, u32::from(b)]
    }
}
