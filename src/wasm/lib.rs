//! The decoder for the page of the player: chunks in, pixels out.

mod chunk_decoder;
mod coding_map;
mod device;
mod exports;
mod slots;
mod stream;
