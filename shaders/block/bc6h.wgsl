// BC6H UF16 (blocks.md 7). Mirrors src/codec/block/bc6h.rs. Needs bptc.wgsl.

// Fields of a block before the indices.
struct Bc6hValues {
    // 0 if the mode is reserved.
    subsets: u32,
    endpoint_bits: u32,
    // Bits of the endpoint deltas of red, green and blue; 0 if the endpoints are not delta-coded.
    delta: vec3u,
    partition_number: u32,
    w: vec3u,
    x: vec3u,
    y: vec3u,
    z: vec3u,
}

// Reverses the order of `count` bits.
fn bc6h_reversed(bits: u32, count: u32) -> u32 {
    return reverseBits(bits) >> (32u - count);
}

// Reads the fields of a block. The comment in each case is the bit layout of that mode, from the first bit after the mode.
fn bc6h_values(words: vec4u) -> Bc6hValues {
    var code = words.x & 3u;
    if (code > 1u) {
        code = words.x & 31u;
    }
    var block: Bc6hValues;
    block.subsets = 1u;
    switch (code) {
        case 0u: {
            // gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 10u;
            block.delta = vec3u(5u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u),
                bptc_bits(words, 15u, 10u),
                bptc_bits(words, 25u, 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 2u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 3u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 4u, 1u) << 4u),
            );
        }
        case 1u: {
            // gy5 gz4-5 rw0-6 bz0-1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 7u;
            block.delta = vec3u(6u, 6u, 6u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 7u),
                bptc_bits(words, 15u, 7u),
                bptc_bits(words, 25u, 7u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 2u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 22u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 3u, 2u) << 4u),
                bptc_bits(words, 12u, 2u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 32u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 2u: {
            // rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(5u, 4u, 4u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 40u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 49u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 59u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 4u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u),
                bptc_bits(words, 61u, 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u),
            );
        }
        case 6u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(4u, 5u, 4u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 39u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 50u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 59u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 4u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 4u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 75u, 1u) << 4u),
                bptc_bits(words, 61u, 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 4u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 69u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u),
            );
        }
        case 10u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1-2 rz0-3 bz4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(4u, 4u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 39u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 49u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 60u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 4u),
                bptc_bits(words, 41u, 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 4u),
                bptc_bits(words, 51u, 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 69u, 2u) << 1u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 75u, 1u) << 4u),
            );
        }
        case 14u: {
            // rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 9u;
            block.delta = vec3u(5u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 9u),
                bptc_bits(words, 15u, 9u),
                bptc_bits(words, 25u, 9u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u),
            );
        }
        case 18u: {
            // rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3-4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(6u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 13u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 33u, 2u) << 3u),
            );
        }
        case 22u: {
            // rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(5u, 6u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 23u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u) | (bptc_bits(words, 33u, 1u) << 5u),
                bptc_bits(words, 13u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u),
            );
        }
        case 26u: {
            // rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(5u, 5u, 6u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 23u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 13u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 30u: {
            // rw0-5 gz4 bz0-1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 6u;
            block.delta = vec3u(0u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 6u),
                bptc_bits(words, 15u, 6u),
                bptc_bits(words, 25u, 6u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 21u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 22u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 11u, 1u) << 4u) | (bptc_bits(words, 31u, 1u) << 5u),
                bptc_bits(words, 12u, 2u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 32u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 3u: {
            // rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9
            block.endpoint_bits = 10u;
            block.delta = vec3u(0u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u),
                bptc_bits(words, 15u, 10u),
                bptc_bits(words, 25u, 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 10u),
                bptc_bits(words, 45u, 10u),
                bptc_bits(words, 55u, 10u),
            );
        }
        case 7u: {
            // rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10
            block.endpoint_bits = 11u;
            block.delta = vec3u(9u, 9u, 9u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 44u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 54u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 64u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 9u),
                bptc_bits(words, 45u, 9u),
                bptc_bits(words, 55u, 9u),
            );
        }
        case 11u: {
            // rw0-9 gw0-9 bw0-9 rx0-7 rw11-10 gx0-7 gw11-10 bx0-7 bw11-10
            block.endpoint_bits = 12u;
            block.delta = vec3u(8u, 8u, 8u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bc6h_reversed(bptc_bits(words, 43u, 2u), 2u) << 10u),
                bptc_bits(words, 15u, 10u) | (bc6h_reversed(bptc_bits(words, 53u, 2u), 2u) << 10u),
                bptc_bits(words, 25u, 10u) | (bc6h_reversed(bptc_bits(words, 63u, 2u), 2u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 8u),
                bptc_bits(words, 45u, 8u),
                bptc_bits(words, 55u, 8u),
            );
        }
        case 15u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw15-10 gx0-3 gw15-10 bx0-3 bw15-10
            block.endpoint_bits = 16u;
            block.delta = vec3u(4u, 4u, 4u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bc6h_reversed(bptc_bits(words, 39u, 6u), 6u) << 10u),
                bptc_bits(words, 15u, 10u) | (bc6h_reversed(bptc_bits(words, 49u, 6u), 6u) << 10u),
                bptc_bits(words, 25u, 10u) | (bc6h_reversed(bptc_bits(words, 59u, 6u), 6u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 4u),
            );
        }
        default: {
            block.subsets = 0u;
        }
    }
    return block;
}

// Unquantises an endpoint to 16 bits. In delta-coded modes `value` is a signed difference from endpoint `w`.
fn bc6h_endpoint(block: Bc6hValues, value: vec3u) -> vec3u {
    var whole = value;
    if (block.delta.x > 0u) {
        let unused = 32u - block.delta;
        let difference = vec3i(value << unused) >> unused;
        whole = (block.w + vec3u(difference)) & vec3u((1u << block.endpoint_bits) - 1u);
    }
    return bc6h_widen(whole, block.endpoint_bits);
}

// Unquantises values of `endpoint_bits` bits to 16 bits.
fn bc6h_widen(value: vec3u, endpoint_bits: u32) -> vec3u {
    if (endpoint_bits >= 15u) {
        return value;
    }
    let spread = ((value << vec3u(16u)) + 0x8000u) >> vec3u(endpoint_bits);
    let last = vec3u((1u << endpoint_bits) - 1u);
    return select(select(spread, vec3u(0xffffu), value == last), vec3u(0u), value == vec3u(0u));
}

// A block with unquantised endpoints: a and b of subset 0, c and d of subset 1.
struct Bc6h {
    words: vec4u,
    subsets: u32,
    parts: BptcPartition,
    a: vec3u,
    b: vec3u,
    c: vec3u,
    d: vec3u,
}

fn bc6h_open(words: vec4u) -> Bc6h {
    let values = bc6h_values(words);
    return Bc6h(
        words,
        values.subsets,
        bptc_partition(values.subsets, values.partition_number),
        bc6h_widen(values.w, values.endpoint_bits),
        bc6h_endpoint(values, values.x),
        bc6h_endpoint(values, values.y),
        bc6h_endpoint(values, values.z),
    );
}

// Decodes one pixel: r | g << 16 in the first word, b in the second.
fn bc6h_pixel(block: Bc6h, texel: u32) -> vec2u {
    if (block.subsets == 0u) {
        return vec2u(0u);
    }
    let second = bptc_subset(block.parts, texel) == 1u;
    let a = select(block.a, block.c, second);
    let b = select(block.b, block.d, second);
    let index_bits = 5u - block.subsets;
    let indices_at = select(65u, 82u, block.subsets == 2u);
    let index = bptc_index(block.words, indices_at, index_bits, block.parts, texel);
    // Scales 0 to 65535 to the bit patterns of finite half floats.
    let halves = (bptc_mix(a, b, index, index_bits) * 31u) >> vec3u(6u);
    return vec2u(halves.x | (halves.y << 16u), halves.z);
}

// Decodes all 16 pixels of a block.
fn bc6h_texels(words: vec4u, out: ptr<function, array<vec2u, 16>>) {
    let block = bc6h_open(words);
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc6h_pixel(block, texel);
    }
}
