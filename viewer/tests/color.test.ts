// Texture blocks and color codecs against the examples of formats/ and the vectors of tests/vectors.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeBc1Block } from "../src/codec/block/bc1.ts";
import { decodeBc4Block, decodeBc5Block } from "../src/codec/block/bc4.ts";
import { decodeBc6hBlock } from "../src/codec/block/bc6h.ts";
import { decodeBc7Block } from "../src/codec/block/bc7.ts";
import { blendOf, changedPixels, colorDecoder, parseColorHeader, prepareColor, transformTables } from "../src/codec/color/index.ts";
import { bitsOf, blendInto, keyOf } from "../src/codec/color/samples.ts";
import { SET_WORDS } from "../src/codec/color/transform_tables.ts";
import { builtInTables, colorModel, readTables } from "../src/codec/entropy.ts";
import type { ChunkArea, ChunkDecoder, Pixels } from "../src/codec/types.ts";
import { Container } from "../src/format/container.ts";
import { crc32 } from "../src/format/crc32.ts";
import { MemorySource } from "../src/format/memory.ts";
import { unpack } from "../src/format/payload.ts";
import { type ColorHeader, FormatError, type Stream, UnsupportedError } from "../src/format/types.ts";
import { CONSTANTS } from "../src/gpu/layout.ts";

const BLOCKS = readFileSync("../formats/blocks.md", "utf8");

/** Cells of the rows of a table behind a comment of blocks.md. */
function examples(name: string): string[][] {
  const [, table] = BLOCKS.split(`<!-- examples: ${name} -->\n\n`);
  const lines = table.slice(0, table.indexOf("\n\n")).split("\n").slice(2);
  assert.ok(lines.length > 0);
  return lines.map((line) =>
    line
      .split("|")
      .slice(1, -1)
      .map((cell) => cell.trim()),
  );
}

/** The bytes of a cell such as `e0 fb`, with others around them. */
function blockOf(cell: string): Uint8Array {
  const bytes = cell
    .replaceAll("`", "")
    .split(" ")
    .map((byte) => parseInt(byte, 16));
  return Uint8Array.from([0xa5, ...bytes, 0xa5]);
}

test("blocks of BC1, BC4 and BC5 decode as blocks.md says", () => {
  for (const [block, ...colors] of examples("bc1")) {
    const out = new Uint8Array(48);
    decodeBc1Block(blockOf(block), 1, out);
    for (let texel = 0; texel < 16; texel++) {
      assert.equal(out.subarray(3 * texel, 3 * texel + 3).join(" "), colors[texel % 4], `${block}, pixel ${texel}`);
    }
  }
  for (const [block, values] of examples("bc4")) {
    const out = new Uint8Array(16);
    decodeBc4Block(blockOf(block), 1, out);
    assert.equal(out.join(" "), `${values} ${values}`, block);
  }
  for (const [block, pixels] of examples("bc5")) {
    const out = new Uint8Array(32);
    decodeBc5Block(blockOf(block), 1, out);
    assert.equal(out.subarray(0, 16).join(" "), pixels.replaceAll(",", ""), block);
  }
});

test("blocks of BC6H and BC7 decode as blocks.md says", () => {
  for (const [code, block, ...pixels] of examples("bc6h")) {
    const out = new Uint16Array(48).fill(1);
    decodeBc6hBlock(blockOf(block), 1, out);
    for (const [at, texel] of [0, 6, 15].entries()) {
      const shown = Array.from(out.subarray(3 * texel, 3 * texel + 3), (half) => half.toString(16).padStart(4, "0"));
      assert.equal(shown.join(" "), pixels[at], `code ${code}, pixel ${texel}`);
    }
  }
  for (const [mode, block, ...pixels] of examples("bc7")) {
    const out = new Uint8Array(48).fill(1);
    decodeBc7Block(blockOf(block), 1, out);
    for (const [at, texel] of [0, 6, 15].entries()) {
      // Alpha, the last number, is dropped.
      const color = pixels[at].split(" ").slice(0, 3).join(" ");
      assert.equal(out.subarray(3 * texel, 3 * texel + 3).join(" "), color, `mode ${mode}, pixel ${texel}`);
    }
  }
});

const VALID = "../tests/vectors/valid";

interface VectorChunk {
  file: string;
  stream: Stream;
  header: ColorHeader;
  unit: number;
  firstFrame: number;
  payload: Uint8Array;
  area: ChunkArea;
  /** The unit's next chunk. */
  next?: VectorChunk;
}

/** All chunks of color of the valid vectors. */
async function readChunks(): Promise<VectorChunk[]> {
  const chunks: VectorChunk[] = [];
  for (const file of readdirSync(VALID).filter((name) => name.endsWith(".lfold"))) {
    const source = new MemorySource(Uint8Array.from(readFileSync(`${VALID}/${file}`)));
    const container = await Container.open(source);
    for (const [at, chunk] of container.chunks.entries()) {
      const stream = container.streams[chunk.stream];
      const { header } = stream;
      if (header.kind !== "color") {
        continue;
      }
      const payload = unpack(chunk, await source.read(chunk.offset, chunk.storedBytes));
      const { unit, firstFrame } = chunk;
      const read: VectorChunk = { file, stream, header, unit, firstFrame, payload, area: container.areaOf(at) };
      const before = chunks.at(-1);
      if (before?.stream === stream && before.unit === unit) {
        before.next = read;
      }
      chunks.push(read);
    }
  }
  return chunks;
}

const CHUNKS = await readChunks();

function decoderOf({ header, payload, area }: VectorChunk): ChunkDecoder {
  return colorDecoder(header, payload, area);
}

/** The picture of a frame, counted from the chunk's first. */
function show(chunk: VectorChunk, decoder: ChunkDecoder, frame: number): Pixels {
  const { next } = chunk;
  return decoder.frame(frame, next && (() => next.payload)).slice();
}

function picturesOf(chunk: VectorChunk): Pixels[] {
  const decoder = decoderOf(chunk);
  return Array.from({ length: chunk.area.frames }, (_, frame) => show(chunk, decoder, frame));
}

/** Whole numbers that look random, the same in each run. */
function randomFrom(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1103515245) + 12345) & 0x7fffffff;
    return (state >>> 8) % below;
  };
}

function bytesOf(pixels: Pixels): Uint8Array {
  return new Uint8Array(pixels.buffer, pixels.byteOffset, pixels.byteLength);
}

test("frames of all color vectors are those of their CRC-32s", () => {
  const pictures = new Map<string, Pixels>();
  for (const chunk of CHUNKS) {
    const { stream } = chunk;
    const [left, top, width, height] = chunk.area.area.rect;
    for (const [at, picture] of picturesOf(chunk).entries()) {
      const name = `${chunk.file} ${stream.index} ${chunk.firstFrame + at}`;
      const whole = pictures.get(name) ?? new (picture.constructor as typeof Uint16Array)(3 * stream.width * stream.height);
      pictures.set(name, whole);
      for (let row = 0; row < height; row++) {
        const from = picture.subarray(3 * row * width, 3 * (row + 1) * width);
        whole.set(from, 3 * ((top + row) * stream.width + left));
      }
    }
  }
  const codecs = new Set(CHUNKS.map(({ stream }) => stream.codec));
  assert.deepEqual([...codecs].sort(), ["CCB1", "CCB6", "CCB7", "CCL8", "CCLH", "CTR8", "CTRH"]);
  for (const [name, picture] of pictures) {
    const [file, stream, frame] = name.split(" ");
    const lines = readFileSync(`${VALID}/${file.replace(".lfold", ".crc")}`, "utf8").split("\n");
    const crc = crc32(bytesOf(picture)).toString(16).padStart(8, "0");
    assert.ok(lines.includes(`${stream} ${frame} ${crc}`), `${name} ${crc}`);
  }
});
