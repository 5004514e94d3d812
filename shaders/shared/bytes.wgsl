// Bytes and halves of `stream` at any offset, little endian.

fn byte_at(at: u32) -> u32 {
    return (stream[at >> 2u] >> ((at & 3u) * 8u)) & 255u;
}

fn half_at(at: u32) -> u32 {
    return byte_at(at) | (byte_at(at + 1u) << 8u);
}
