// Half-float samples in the transform codec: `Domain::HALVES` of src/codec/color/transform/domain.rs. Needs `bits_of`.

const FRACTION_BITS: u32 = 0u;
const FINE_BITS: u32 = 0u;
const KEY_BITS: u32 = 16u;
const MIDDLE: i32 = 0xbc00;
const MIN_KEY: i32 = 0x0400;
const MAX_KEY: i32 = 0xfbff;

fn sample_of(keys: vec3i) -> vec3u {
    return bits_of(vec3u(keys));
}
