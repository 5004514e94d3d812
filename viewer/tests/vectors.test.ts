// The frozen vectors of the format: images of all valid ones, refusal of all others (tests/vectors/README.md).

import assert from "node:assert/strict";
import { test } from "node:test";
import type { ChunkDecoder, DecoderStream } from "../src/decoder/decoder.ts";
import { decoder } from "../src/decoder/module.ts";
import type { Pixels } from "../src/decoder/types.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "../src/format/memory.ts";
import { FormatError, type Stream, UnsupportedError } from "../src/format/types.ts";
import {
  chance,
  fileOf,
  indexRange,
  payloadOf,
  seal,
  spoiled,
  storedChunk,
  type Vector,
  vectors,
  withPayload,
} from "./vectors.ts";

/** Byte changes of each valid vector. */
const CHANGES = 200;
/** Frames that are decoded of a chunk with changes. */
const FRAMES_OF_CHANGED = 4;

/** Samples of a pixel in the image as bytes. */
function samplesOf(stream: Stream): number {
  return stream.kind === "color" || stream.kind === "material" ? 3 : 1;
}

/** Runs a function with a stream of the decoder. */
function withStream<T>(stream: Stream, use: (opened: DecoderStream) => T): T {
  const opened = decoder().openStream(stream, stream.headerBytes);
  try {
    return use(opened);
  } finally {
    decoder().closeStream(opened);
  }
}

/** The lines of a `.crc` file; of each chunk only the first `most` frames. */
function decodeAll(container: Container, file: Uint8Array, most = Infinity): string[] {
  return container.streams.flatMap((stream) => {
    const first = stream.firstFrame;
    const frames = Math.min(stream.frameCount, most);
    return withDecoders(container, file, stream, (imageOf) =>
      Array.from({ length: frames }, (_, frame) => `${stream.index} ${first + frame} ${crcOf(imageOf(first + frame))}`),
    );
  });
}

function crcOf(image: Pixels): string {
  const bytes = new Uint8Array(image.buffer, image.byteOffset, image.byteLength);
  return decoder().crc32(bytes).toString(16).padStart(8, "0");
}

/** Runs a function with what decodes images of a stream, whose chunks are opened once. */
function withDecoders<T>(
  container: Container,
  file: Uint8Array,
  stream: Stream,
  use: (imageOf: (frame: number) => Pixels) => T,
): T {
  const decoders = new Map<number, ChunkDecoder>();
  return withStream(stream, (opened) => {
    const open = (at: number): ChunkDecoder => {
      const known = decoders.get(at) ?? decoder().openChunk(opened, storedChunk(container, file, at));
      decoders.set(at, known);
      return known;
    };
    try {
      return use((frame) => imageOf(container, file, { stream, frame }, open));
    } finally {
      decoders.forEach((one) => one.close());
    }
  });
}

function imageOf(
  container: Container,
  file: Uint8Array,
  { stream, frame }: { stream: Stream; frame: number },
  open: (at: number) => ChunkDecoder,
): Pixels {
  let image: Pixels | undefined;
  const samples = samplesOf(stream);
  for (let unit = 0; unit < container.unitCount(stream.index); unit += 1) {
    const at = container.chunkIndex(stream.index, unit, frame);
    const next = () => storedChunk(container, file, at + 1);
    const pixels = open(at).frame(frame - container.chunks[at].firstFrame, next);
    const [left, top, width, height] = container.unitRect(stream.index, unit);
    assert.equal(pixels.length, width * height * samples);
    image ??= new (pixels instanceof Uint8Array ? Uint8Array : Uint16Array)(stream.width * stream.height * samples);
    for (let row = 0; row < height; row += 1) {
      const from = row * width * samples;
      image.set(pixels.subarray(from, from + width * samples), ((top + row) * stream.width + left) * samples);
    }
  }
  assert.ok(image);
  return image;
}

function isRefusal(error: unknown): boolean {
  return error instanceof FormatError || error instanceof UnsupportedError;
}

/** Opens a file and decodes it whole: the lines, or the refusal; any other error fails the test. */
async function outcome(file: Uint8Array, most = Infinity): Promise<string[] | Error> {
  try {
    return decodeAll(await Container.open(new MemorySource(file)), file, most);
  } catch (error) {
    assert.ok(isRefusal(error), error instanceof Error ? error.stack : String(error));
    return error as Error;
  }
}

for (const { name, bytes, lines } of vectors("valid")) {
  void test(`valid/${name} decodes`, async () => {
    assert.deepEqual(decodeAll(await Container.open(new MemorySource(bytes)), bytes), lines);
  });
}

void test("frames decode in any order", async () => {
  for (const { name, bytes, lines } of vectors("valid")) {
    const container = await Container.open(new MemorySource(bytes));
    for (const stream of container.streams) {
      withDecoders(container, bytes, stream, (imageOf) => {
        for (let frame = stream.frameCount - 1; frame >= 0; frame -= 1) {
          const line = `${stream.index} ${stream.firstFrame + frame} ${crcOf(imageOf(stream.firstFrame + frame))}`;
          assert.ok(lines.includes(line), `${name}: ${line}`);
        }
      });
    }
  }
});

for (const folder of ["invalid", "limits"] as const) {
  for (const { name, bytes } of vectors(folder)) {
    void test(`${folder}/${name} is refused with a sentence`, async () => {
      const refusal = await outcome(bytes);
      assert.ok(refusal instanceof Error, "it was decoded");
      assert.match(refusal.message, /^[^\p{Cc}]+\.$/u);
    });
  }
}

void test("chunks of all valid vectors come in the form of the device, or are refused as unsupported", async () => {
  for (const { bytes } of vectors("valid")) {
    const container = await Container.open(new MemorySource(bytes));
    container.chunks.forEach(({ stream }, at) => {
      try {
        withStream(container.streams[stream], (opened) => decoder().prepare(opened, storedChunk(container, bytes, at)));
      } catch (error) {
        assert.ok(error instanceof UnsupportedError, String(error));
      }
    });
  }
});

void test("a changed file decodes to the same images or is refused", async () => {
  let refused = 0;
  for (const [seed, { name, bytes, lines }] of vectors("valid").entries()) {
    const random = chance(seed);
    for (let change = 0; change < CHANGES; change += 1) {
      const found = await outcome(spoiled(bytes, random));
      refused += Number(found instanceof Error);
      assert.ok(found instanceof Error || found.join() === lines.join(), `${name}, change ${change}`);
    }
  }
  assert.ok(refused > 0);
});

void test("a changed index with a right CRC-32 opens or is refused", async () => {
  let opened = 0;
  for (const [seed, { bytes }] of vectors("valid").entries()) {
    const random = chance(1000 + seed);
    const [start, end] = indexRange(bytes);
    for (let change = 0; change < CHANGES; change += 1) {
      const index = spoiled(bytes.subarray(start, end), random);
      const file = bytes.slice();
      file.set(index, start);
      try {
        await Container.open(new MemorySource(seal(file)));
        opened += 1;
      } catch (error) {
        assert.ok(isRefusal(error), error instanceof Error ? error.stack : String(error));
      }
    }
  }
  assert.ok(opened > 0);
});

void test("a changed payload with a right CRC-32 decodes to something or is refused", async () => {
  let [decoded, refused] = [0, 0];
  for (const [seed, vector] of vectors("valid").entries()) {
    const random = chance(2000 + seed);
    const container = await Container.open(new MemorySource(vector.bytes));
    for (let change = 0; change < CHANGES && container.chunks.length > 0; change += 1) {
      if (changedChunk(container, vector, random)) {
        decoded += 1;
      } else {
        refused += 1;
      }
    }
  }
  assert.ok(decoded > 0 && refused > 0);
});

/** Decodes frames of a chunk whose payload has changes; answers whether it was not refused. */
function changedChunk(container: Container, { name, bytes }: Vector, random: (most: number) => number): boolean {
  const at = random(container.chunks.length);
  const { stream, frameCount } = container.chunks[at];
  const chunk = storedChunk(container, bytes, at);
  const changed = withPayload(chunk, spoiled(payloadOf(chunk), random));
  try {
    withStream(container.streams[stream], (opened) => {
      const frames = decoder().openChunk(opened, changed);
      try {
        for (let frame = 0; frame < Math.min(frameCount, FRAMES_OF_CHANGED); frame += 1) {
          frames.frame(frame, () => storedChunk(container, bytes, at + 1));
        }
      } finally {
        frames.close();
      }
    });
    return true;
  } catch (error) {
    assert.ok(isRefusal(error), `${name}, chunk ${at}: ${error instanceof Error ? error.stack : String(error)}`);
    return false;
  }
}

void test("sizes near the limits of a field are refused before memory is reserved", async () => {
  const dataset = new DataView(new ArrayBuffer(15));
  dataset.setFloat64(5, 24, true);
  for (const count of [0, 1, 2]) {
    const counts = [[0], [0], [0]];
    counts[count] = [0x80, 0x80, 0x80, 0x80, 0x08];
    const index = Uint8Array.from([...counts.flat(), ...new Uint8Array(dataset.buffer)]);
    const found = await outcome(fileOf(new Uint8Array(0), index));
    assert.match((found as Error).message, /do not fit/u);
  }
});
