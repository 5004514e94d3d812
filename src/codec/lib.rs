//! The codec of lightfold: containers, entropy coding, depth, colour, and the decoder of streams (`formats/`).
//!
//! The feature `encode` adds the encoders and the container writer. Everything else is in `lightfold`. No stability is promised:
//! use `lightfold`.

// Tests make their inputs as they like (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod block;
pub mod color;
pub mod container;
pub mod decode;
pub mod depth;
pub mod effort;
pub mod entropy;
pub mod error;
pub mod image;
pub mod math;
pub mod memory;
pub mod metrics;
pub mod monitor;
pub mod ordered;
pub mod streams;
pub mod unit_map;

/// Hash of the sources and tables of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");

/// Implements `+` for a struct of counts or costs, with all its members listed.
#[macro_export]
macro_rules! add_members {
    ($name:ident: $($member:ident),+) => {
        impl std::ops::Add for $name {
            type Output = $name;

            fn add(self, other: $name) -> $name {
                $name { $($member: self.$member + other.$member),+ }
            }
        }
    };
}
