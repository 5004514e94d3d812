// Pictures for tests, read back from the graphics device, in the form of the CPU's decoders. Mirrors src/kernels/pictures.rs.

import type { Pixels } from "../src/decoder/types.ts";
import type { Rect, Stream } from "../src/format/types.ts";
import { unitCountOf, unitRectOf } from "../src/format/index_tables.ts";
import type { FamilyDecoder, UnitPicture } from "../src/gpu/decoder.ts";
import type { Gpu } from "../src/gpu/device.ts";
import type { PixelWords } from "../src/gpu/family.ts";

/** A picture of `width` columns that units are unpacked into. */
interface Target {
  pixels: Pixels;
  width: number;
}

function emptyTarget(kind: PixelWords, width: number, height: number): Target {
  const count = width * height;
  switch (kind) {
    case "codes":
      return { width, pixels: new Uint16Array(count) };
    case "bytes":
      return { width, pixels: new Uint8Array(3 * count) };
    case "halves":
      return { width, pixels: new Uint16Array(3 * count) };
  }
}

/** Unpacks words of a unit, which start at its first, into a rectangle. */
function unpack(kind: PixelWords, words: Uint32Array, stride: number, target: Target, rect: Rect): void {
  const { pixels } = target;
  const [left, top, width, height] = rect;
  for (let y = 0; y < height; y += 1) {
    const from = y * stride;
    const to = (top + y) * target.width + left;
    for (let x = 0; x < width; x += 1) {
      if (kind === "codes") {
        pixels[to + x] = words[from + (x >>> 1)]! >>> (16 * (x & 1));
      } else if (kind === "bytes") {
        const word = words[from + x]!;
        pixels[3 * (to + x)] = word;
        pixels[3 * (to + x) + 1] = word >>> 8;
        pixels[3 * (to + x) + 2] = word >>> 16;
      } else {
        const low = words[from + 2 * x]!;
        pixels[3 * (to + x)] = low;
        pixels[3 * (to + x) + 1] = low >>> 16;
        pixels[3 * (to + x) + 2] = words[from + 2 * x + 1]!;
      }
    }
  }
}

function wordsOf({ stride, height }: UnitPicture): number {
  return stride * height;
}

/** The image of a stream, by its position among those of the decoder: all its units. */
export async function readStream(gpu: Gpu, decoder: FamilyDecoder, position: number): Promise<Pixels> {
  const stream = decoder.streams[position] as Stream;
  const units = unitCountOf(stream);
  const first = decoder.unit(position, 0);
  const last = decoder.unit(position, units - 1);
  // Units of a stream lie one behind the other.
  const count = last.picture + wordsOf(last) - first.picture;
  const words = await gpu.read(decoder.pictures, 4 * first.picture, count);
  const target = emptyTarget(decoder.family.words, stream.width, stream.height);
  for (let unit = 0; unit < units; unit += 1) {
    const { picture, stride } = decoder.unit(position, unit);
    const own = words.subarray(picture - first.picture);
    unpack(decoder.family.words, own, stride, target, unitRectOf(stream, unit));
  }
  return target.pixels;
}
