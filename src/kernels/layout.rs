//! Structs and constants that Rust and WGSL share: those of `shaders/kernels.json`, which `build.rs` turns into Rust. Their
//! WGSL declarations are in the files named `layout.wgsl`; a test compares the two by reflection.

/// A value that is stored as 32-bit words.
pub trait Words {
    fn put(&self, out: &mut Vec<u32>);
}

impl Words for u32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(*self);
    }
}

impl Words for i32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(*self as u32);
    }
}

impl Words for f32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(self.to_bits());
    }
}

impl<const N: usize, T: Words> Words for [T; N] {
    fn put(&self, out: &mut Vec<u32>) {
        self.iter().for_each(|value| value.put(out));
    }
}

pub fn words_of<T: Words>(rows: &[T]) -> Vec<u32> {
    let mut out = Vec::with_capacity(size_of_val(rows) / 4);
    rows.iter().for_each(|row| row.put(&mut out));
    out
}

macro_rules! structs {
    ($($name:ident { $($field:ident: $kind:ty),+ })+) => {
        $(
            #[doc = concat!("`", stringify!($name), "` of the WGSL, member by member.")]
            #[allow(missing_docs)]
            #[repr(C)]
            #[derive(Debug, Clone, Copy, PartialEq, Default)]
            pub struct $name { $(pub $field: $kind),+ }

            impl $name {
                pub const WORDS: usize = size_of::<$name>() / 4;
            }

            impl Words for $name {
                fn put(&self, out: &mut Vec<u32>) {
                    $(self.$field.put(out);)+
                }
            }
        )+
        /// Name of each struct, its size in bytes, and names and offsets of its members.
        pub const STRUCTS: &[(&str, usize, &[(&str, usize)])] = &[$((
            stringify!($name),
            size_of::<$name>(),
            &[$((stringify!($field), std::mem::offset_of!($name, $field))),+],
        )),+];
    };
}

macro_rules! constants {
    ($($name:ident = $value:expr;)+) => {
        $(
            #[doc = concat!("`", stringify!($name), "` of the WGSL.")]
            pub const $name: u32 = $value;
        )+
        /// Name and value of each constant.
        pub const CONSTANTS: &[(&str, u32)] = &[$((stringify!($name), $name)),+];
    };
}

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

/// Words before the rows of a list, for `Items` and all lists of jobs.
pub const LIST_HEAD_WORDS: usize = 2;

/// Returns a list as words. The head of a job list is its total work and its length; that of an item list is its length and 0.
pub fn list_of<T: Words>(head: [u32; LIST_HEAD_WORDS], rows: &[T]) -> Vec<u32> {
    [head.to_vec(), words_of(rows)].concat()
}
