// Returns the 64-bit product of two words, low word first, computed from four 16-bit products.
fn product(one: u32, other: u32) -> vec2u {
    let a = vec2u(one & 0xffffu, one >> 16u);
    let b = vec2u(other & 0xffffu, other >> 16u);
    let low = a.x * b.x;
    let across = a.y * b.x;
    let down = a.x * b.y;
    let middle = (low >> 16u) + (across & 0xffffu) + (down & 0xffffu);
    let high = a.y * b.y + (across >> 16u) + (down >> 16u) + (middle >> 16u);
    return vec2u((middle << 16u) | (low & 0xffffu), high);
}
