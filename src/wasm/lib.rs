//! The decoder for the page of the player: chunks in, pixels out. Its CPU renderer: texels in, pictures out.

mod chunk_decoder;
mod coding_map;
mod device;
mod exports;
mod numbers;
mod picture;
mod present;
mod requests;
mod slots;
mod stream;
