// BC5: two blocks of BC4, which have one channel of 16 pixels in 8 bytes each (formats/blocks.md 4 and 5).

const values = new Uint8Array(8);

/** Decodes the block of 16 bytes at byte `at` into red and green of 16 pixels, row by row: 32 bytes (formats/blocks.md 5). */
export function decodeBc5Block(bytes: Uint8Array, at: number, out: Uint8Array): void {
  decodeBc4Block(bytes, at, out, 0);
  decodeBc4Block(bytes, at + 8, out, 1);
}

/** Decodes the block of 8 bytes at byte `at` into a channel of 16 pixels of two channels. */
function decodeBc4Block(bytes: Uint8Array, at: number, out: Uint8Array, channel: number): void {
  const a = (values[0] = bytes[at]);
  const b = (values[1] = bytes[at + 1]);
  if (a > b) {
    for (let index = 2; index < 8; index++) {
      values[index] = (((8 - index) * a + (index - 1) * b + 3) / 7) | 0;
    }
  } else {
    for (let index = 2; index < 6; index++) {
      values[index] = (((6 - index) * a + (index - 1) * b + 2) / 5) | 0;
    }
    values[6] = 0;
    values[7] = 255;
  }
  for (let half = 0; half < 2; half++) {
    const from = at + 2 + 3 * half;
    const indices = bytes[from] | (bytes[from + 1] << 8) | (bytes[from + 2] << 16);
    for (let texel = 0; texel < 8; texel++) {
      out[channel + 2 * (8 * half + texel)] = values[(indices >> (3 * texel)) & 7];
    }
  }
}
