// 8-bit samples in the transform codec: `Domain::BYTES` of src/codec/color/transform/domain.rs.

const FRACTION_BITS: u32 = 6u;
// Fraction bits of a pixel's channels in chunks with frequency-dependent steps (offset_set 1).
const FINE_BITS: u32 = 4u;
const KEY_BITS: u32 = 8u;
const MIDDLE: i32 = 128;
const MIN_KEY: i32 = 0;
const MAX_KEY: i32 = 255;

fn sample_of(keys: vec3i) -> vec3u {
    return vec3u(keys);
}
