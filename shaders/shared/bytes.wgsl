// Unaligned little-endian reads of bytes, 16-bit and 32-bit words from `stream`.

fn byte_at(at: u32) -> u32 {
    return (stream[at >> 2u] >> ((at & 3u) * 8u)) & 255u;
}

fn word_at(at: u32) -> u32 {
    let shift = (at & 3u) * 8u;
    let low = stream[at >> 2u] >> shift;
    if (shift == 0u) {
        return low;
    }
    return low | (stream[(at >> 2u) + 1u] << (32u - shift));
}

fn half_at(at: u32) -> u32 {
    let shift = (at & 3u) * 8u;
    let low = stream[at >> 2u] >> shift;
    if (shift <= 16u) {
        return low & 0xffffu;
    }
    return (low | (stream[(at >> 2u) + 1u] << 8u)) & 0xffffu;
}
