// BC1: red, green and blue, 16 pixels in 8 bytes (formats/blocks.md 3).

const colors = new Uint8Array(12);

/** Decodes the block of 8 bytes at byte `at` into red, green, blue of 16 pixels, row by row: 48 bytes. Index 3 of a block whose first
 *  endpoint is not the greater one is black (formats/blocks.md 3). */
export function decodeBc1Block(bytes: Uint8Array, at: number, out: Uint8Array): void {
  const first = bytes[at] | (bytes[at + 1] << 8);
  const second = bytes[at + 2] | (bytes[at + 3] << 8);
  expand(first, 0);
  expand(second, 3);
  for (let channel = 0; channel < 3; channel++) {
    const a = colors[channel];
    const b = colors[3 + channel];
    colors[6 + channel] = first > second ? ((2 * a + b + 1) / 3) | 0 : (a + b + 1) >> 1;
    colors[9 + channel] = first > second ? ((a + 2 * b + 1) / 3) | 0 : 0;
  }
  for (let texel = 0; texel < 16; texel++) {
    const color = 3 * ((bytes[at + 4 + (texel >> 2)] >> (2 * (texel & 3))) & 3);
    out[3 * texel] = colors[color];
    out[3 * texel + 1] = colors[color + 1];
    out[3 * texel + 2] = colors[color + 2];
  }
}

/** 5, 6 and 5 bits brought to 8 each, the high bits repeated below. */
function expand(color: number, at: number): void {
  const [red, green, blue] = [color >> 11, (color >> 5) & 63, color & 31];
  colors[at] = (red << 3) | (red >> 2);
  colors[at + 1] = (green << 2) | (green >> 4);
  colors[at + 2] = (blue << 3) | (blue >> 2);
}
