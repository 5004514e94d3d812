// Samples of 8 bits in the transform codec: `Domain::BYTES` of src/color/transform/domain.rs.

const FRACTION_BITS: u32 = 6u;
const KEY_BITS: u32 = 8u;
const MIDDLE: i32 = 128;

fn sample_of(keys: vec3i) -> vec3u {
    return vec3u(clamp(keys, vec3i(0), vec3i(255)));
}
