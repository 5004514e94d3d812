// Texture blocks and color codecs against the examples of formats/ and the vectors of tests/vectors.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeBc1Block } from "../src/codec/block/bc1.ts";
import { decodeBc5Block } from "../src/codec/block/bc4.ts";
import { decodeBc6hBlock } from "../src/codec/block/bc6h.ts";
import { decodeBc7Block } from "../src/codec/block/bc7.ts";
import {
  blendOf,
  changedPixels,
  colorDecoder,
  parseColorHeader,
  prepareColor,
  transformTables,
} from "../src/codec/color/index.ts";
import { bitsOf, blendInto, keyOf } from "../src/codec/color/samples.ts";
import { SET_WORDS } from "../src/codec/color/transform_tables.ts";
import { builtInTables, colorModel, readTables } from "../src/codec/entropy.ts";
import type { ChunkArea, ChunkDecoder, Pixels } from "../src/codec/types.ts";
import { Container } from "../src/format/container.ts";
import { crc32 } from "../src/format/crc32.ts";
import { MemorySource } from "./memory_source.ts";
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
    const out = new Uint8Array(32);
    decodeBc5Block(blockOf(`${block} ${block}`), 1, out);
    for (const channel of [0, 1]) {
      const decoded = out.filter((_, at) => at % 2 === channel);
      assert.equal(decoded.join(" "), `${values} ${values}`, block);
    }
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
      const whole =
        pictures.get(name) ?? new (picture.constructor as typeof Uint16Array)(3 * stream.width * stream.height);
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

test("frames in any order are those of playing", () => {
  const random = randomFrom(7);
  for (const chunk of CHUNKS) {
    const expected = picturesOf(chunk);
    const decoder = decoderOf(chunk);
    for (let turn = 0; turn < Math.min(40, 2 * expected.length); turn++) {
      const frame = random(expected.length);
      assert.deepEqual(show(chunk, decoder, frame), expected[frame], `${chunk.file}, frame ${frame}`);
    }
  }
});

/** Whether a payload is refused, checked or shown; other errors than of the format fail. */
function isRefused(chunk: VectorChunk, payload: Uint8Array): boolean {
  try {
    const decoder = decoderOf({ ...chunk, payload });
    for (let frame = 0; frame < chunk.area.frames; frame++) {
      show(chunk, decoder, frame);
    }
    prepareColor(chunk.header, payload, chunk.area);
    return false;
  } catch (error) {
    assert.ok(error instanceof FormatError || error instanceof UnsupportedError, `${chunk.file}: ${String(error)}`);
    assert.match(error.message, /\(color\.md \d[.\d]*\)\.$/);
    return true;
  }
}

test("payloads that end early are refused", () => {
  const random = randomFrom(11);
  for (const chunk of CHUNKS) {
    for (let turn = 0; turn < 8; turn++) {
      const count = turn < 2 ? chunk.payload.length - 1 - turn : random(chunk.payload.length);
      assert.ok(isRefused(chunk, chunk.payload.subarray(0, count)), `${chunk.file}: ${count} bytes`);
    }
  }
});

test("damaged payloads are refused or shown", () => {
  const random = randomFrom(13);
  let refused = 0;
  for (const chunk of CHUNKS) {
    for (let turn = 0; turn < 4; turn++) {
      const payload = chunk.payload.slice();
      payload[random(Math.min(payload.length, turn < 2 ? 24 : payload.length))] ^= 1 << random(8);
      refused += isRefused(chunk, payload) ? 1 : 0;
    }
  }
  assert.ok(refused > CHUNKS.length, `${refused} refused`);
});

test("invalid color vectors are refused", async () => {
  const folder = "../tests/vectors/invalid";
  const isColor = (name: string) => /^(color|transform|bc1-keyframe|samples-keyframe)-.*\.lfold$/.test(name);
  const files = readdirSync(folder).filter(isColor);
  assert.ok(files.length > 40);
  for (const file of files) {
    const source = new MemorySource(Uint8Array.from(readFileSync(`${folder}/${file}`)));
    await assert.rejects(
      async () => {
        const container = await Container.open(source);
        for (const [at, chunk] of container.chunks.entries()) {
          const { header } = container.streams[chunk.stream];
          const payload = unpack(chunk, await source.read(chunk.offset, chunk.storedBytes));
          if (header.kind === "color") {
            prepareColor(header, payload, container.areaOf(at));
          }
        }
      },
      FormatError,
      file,
    );
  }
});

test("a frame that leads into the next chunk takes it, and others do not", () => {
  const leads = ({ header, payload, area }: VectorChunk) => {
    const { timeline } = prepareColor(header, payload, area);
    return Array.from({ length: area.frames }, (_, frame) => blendOf(timeline, frame).needsNext);
  };
  const leading = CHUNKS.filter((chunk) => leads(chunk).includes(true));
  assert.deepEqual([...new Set(leading.map(({ stream }) => stream.codec))].sort(), ["CCL8", "CCLH"]);
  for (const chunk of leading) {
    const expected = picturesOf(chunk);
    for (const next of [undefined, { ...chunk, payload: chunk.payload.subarray(0, 9) }]) {
      const decoder = decoderOf(chunk);
      for (const [frame, needsNext] of leads(chunk).entries()) {
        if (needsNext) {
          assert.throws(() => show({ ...chunk, next }, decoder, frame), FormatError);
        } else {
          assert.deepEqual(show({ ...chunk, next }, decoder, frame), expected[frame]);
        }
      }
    }
    const last: ChunkArea = { ...chunk.area, place: "last" };
    assert.throws(() => prepareColor(chunk.header, chunk.payload, last), FormatError);
  }
});

const COLOR = readFileSync("../formats/color.md", "utf8");
const ARITHMETIC = readFileSync("../formats/arithmetic.md", "utf8");

/** Cells of the rows of the table whose header row this is. */
function tableOf(text: string, header: string): string[][] {
  const start = text.indexOf(`\n${header}\n`);
  assert.ok(start >= 0, header);
  const [table] = text.slice(start + 1).split("\n\n");
  const lines = table.trim().split("\n").slice(2);
  return lines.map((line) =>
    line
      .split("|")
      .slice(1, -1)
      .map((cell) => cell.trim()),
  );
}

/** The payload of color.md 8, of a cell of 5x6 pixels in 2 frames. */
function exampleChunk(): VectorChunk {
  const [, hex] = COLOR.split("```hex\n");
  const lines = hex.slice(0, hex.indexOf("```")).trim().split("\n");
  const bytes = lines.flatMap((line) => line.slice(6).split("|")[0].trim().split(" "));
  const header: ColorHeader = {
    kind: "color",
    isHalf: false,
    transfer: "srgb",
    exposureEv: 0,
    minPsnrDb: 0,
    coding: { name: "transform", tables: builtInTables("color") },
  };
  const area: ChunkArea = { area: { imageSize: [5, 6], face: 0, rect: [0, 0, 5, 6] }, frames: 2, place: "last" };
  const payload = Uint8Array.from(bytes, (byte) => parseInt(byte, 16));
  return { ...CHUNKS[0], file: "color.md 8", header, area, payload, next: undefined };
}

test("the payload of color.md 8 shows the pixels that are listed there", () => {
  const pictures = picturesOf(exampleChunk());
  const rows = tableOf(COLOR, "| frame | x | y | red | green | blue |");
  assert.ok(rows.length > 10);
  for (const [frame, x, y, ...color] of rows.map((row) => row.map(Number))) {
    const at = 3 * (5 * y + x);
    assert.deepEqual([...pictures[frame].subarray(at, at + 3)], color, `frame ${frame}, ${x}, ${y}`);
  }
});

test("interpolation and keys are those of arithmetic.md 3 and 4", () => {
  for (const [a, b, weight, expected] of tableOf(ARITHMETIC, "| a | b | w | lerp |").map((row) => row.map(Number))) {
    const halves = new Uint16Array(1);
    blendInto(halves, Uint16Array.of(bitsOf(a)), Uint16Array.of(bitsOf(b)), weight);
    assert.equal(keyOf(halves[0]), expected, `${a}, ${b}, ${weight}`);
    if (a < 256 && b < 256) {
      const bytes = new Uint8Array(1);
      blendInto(bytes, Uint8Array.of(a), Uint8Array.of(b), weight);
      assert.equal(bytes[0], expected, `${a}, ${b}, ${weight}`);
    }
  }
  for (const [bits, key] of tableOf(ARITHMETIC, "| bits | key | value |").map((row) => row.map(Number))) {
    assert.deepEqual([keyOf(bits), bitsOf(key)], [key, bits]);
  }
});

test("timelines of prepared chunks say what changes", () => {
  for (const chunk of CHUNKS) {
    const { header, payload, area } = chunk;
    const { timeline, records, boxes, weights, stream } = prepareColor(header, payload, area);
    const pixels = area.area.rect[2] * area.area.rect[3];
    const pictures = picturesOf(chunk);
    assert.deepEqual([timeline.keyframes[0], records.length], [0, 6 * timeline.keyframes.length], chunk.file);
    assert.equal(changedPixels(timeline, 0, undefined, pixels), pixels);
    for (let frame = 1; frame < pictures.length; frame++) {
      const [one, other] = [pictures[frame], pictures[frame - 1]];
      let different = 0;
      for (let at = 0; at < one.length; at += 3) {
        different += one[at] !== other[at] || one[at + 1] !== other[at + 1] || one[at + 2] !== other[at + 2] ? 1 : 0;
      }
      const changed = changedPixels(timeline, frame, frame - 1, pixels);
      assert.ok(different <= changed && changed <= pixels, `${chunk.file}, frame ${frame}: ${different}, ${changed}`);
      if (boxes.length > 0) {
        assert.equal(timeline.keyframes.includes(frame), changed > 0, `${chunk.file}, frame ${frame}`);
      }
    }
    const [weightsAt, weightCount] = weights;
    const stored = bytesOf(new Uint8Array(stream.buffer)).subarray(weightsAt, weightsAt + weightCount);
    assert.deepEqual([...stored], [...timeline.weights], chunk.file);
    // Each set of frames holds a pixel of each frame as often as the cell has pixels.
    for (let frame = 0; boxes.length > 0 && frame < area.frames; frame++) {
      const inFrame = Array.from(
        timeline.framePixels,
        (count, set) => ((timeline.frameSets[4 * set + (frame >> 5)] >>> (frame & 31)) & 1) * count,
      );
      assert.equal(
        inFrame.reduce((sum, count) => sum + count, 0),
        pixels,
        chunk.file,
      );
    }
  }
});

test("a transform chunk on the device is its fields and whole words of its regions", () => {
  const { header, payload, area } = exampleChunk();
  const { kernel, stream, records, boxes, timeline } = prepareColor(header, payload, area);
  const words = new Int32Array(stream.buffer);
  const headerWords = 6 + 2;
  assert.deepEqual([...words.subarray(0, headerWords)], [0, 4, -8, 1, 2, 0, 16 | (32 << 16), 48]);
  // Indices of the region's steps: luma 96, chroma 90 and 3 and 8 more.
  assert.deepEqual([...words.subarray(headerWords, headerWords + 3)], [96, 93, 98]);
  assert.deepEqual(bytesOf(new Uint8Array(stream.buffer)).subarray(4 * (headerWords + 3)), payload.slice(9));
  assert.deepEqual([...boxes], [0, 0, 5, 6, 4 * headerWords, 0, 1]);
  assert.deepEqual([...records.subarray(0, 6)], [0, 0, 0, 1, 1, 0]);
  assert.deepEqual([kernel, [...timeline.keyframes]], ["codec", [0, 1]]);
  // A substream of no bytes is the first state: all symbols are 0, and take no bits.
  const frequencies = [...colorModel().alphabets].flatMap((count) => [4096, ...Array<number>(count - 2).fill(0)]);
  const tables = readTables("color", 1, () => frequencies.shift() ?? 0);
  const sets = colorModel().builtIn.length;
  const empty = Uint8Array.of(sets, ...payload.subarray(1, 5), 0);
  const short = prepareColor({ ...header, coding: { name: "transform", tables } }, empty, { ...area, frames: 1 });
  assert.deepEqual(
    [short.stream[0], ...short.stream.subarray(headerWords - 2)],
    [sets * SET_WORDS, 96, 93, 98, 0x10000],
  );
});

test("tables of the device are those of the kernels", () => {
  const own = readTables("color", 1, () => 7);
  const headers = [builtInTables("color"), own, builtInTables("color"), readTables("color", 1, () => 7)].map(
    (tables): ColorHeader => ({ ...exampleChunk().header, coding: { name: "transform", tables } }),
  );
  const { words, firstSets } = transformTables(headers);
  const first = firstSets[0];
  const sets = colorModel().builtIn.length;
  assert.deepEqual(firstSets, [first, first + sets * SET_WORDS, first, first + sets * SET_WORDS]);
  assert.equal(words.length, first + (2 * sets + 1) * SET_WORDS);
  const { SUM_CLASSES_AT, SCAN_AT, CLUSTERS_AT } = CONSTANTS;
  assert.deepEqual([...words.subarray(SUM_CLASSES_AT, SUM_CLASSES_AT + 12)], [0, 1, 2, 3, 4, 5, 5, 6, 6, 6, 6, 7]);
  // Places of 4x4 in the order of color.md 6.6.
  const scan = Array.from(words.subarray(SCAN_AT, SCAN_AT + 7), (word) => [word & 31, (word >> 5) & 31, word >> 16]);
  const order = [
    [0, 0, 0],
    [1, 0, 1],
    [0, 1, 1],
    [0, 2, 2],
    [1, 1, 2],
    [2, 0, 2],
    [3, 0, 2],
  ];
  assert.deepEqual(scan, order);
  const { distributionOf, firstContext } = colorModel();
  assert.deepEqual(
    words.subarray(CLUSTERS_AT, CLUSTERS_AT + distributionOf.length),
    Uint32Array.from(distributionOf, (distribution) => 16 * distribution),
  );
  assert.deepEqual(
    [firstContext.levels, firstContext.laterPixel],
    [CONSTANTS.CONTEXT_LEVELS, CONSTANTS.CONTEXT_LATER_PIXEL],
  );
  assert.deepEqual([words[2] & 255, words[5], words[32] & 255], [1, 9, 9]);
  for (const points of [1, 24, 32]) {
    const at = words[points] >>> 8;
    // Basis 0, and the last sample of the last one, cos(π/2 - π/2N) up to its sign.
    assert.equal(words[at], 256);
    const expected =
      points === 1 ? 256 : 256 * Math.SQRT2 * Math.cos(((2 * points - 1) * (points - 1) * Math.PI) / (2 * points));
    assert.equal(words[at + points * points - 1] | 0, Math.round(expected));
  }
  // Symbols of an own set with frequencies of 7 but for the last: four of a node, then none.
  const nodes = Array.from(words.subarray(firstSets[1] + sets * SET_WORDS, firstSets[1] + sets * SET_WORDS + 5));
  assert.deepEqual(
    nodes.map((word) => [word & 0xffff, word >>> 16]),
    [
      [0, 7],
      [7, 14],
      [14, 21],
      [21, 4096],
      [4096, 4096],
    ],
  );
  assert.deepEqual(
    transformTables(CHUNKS.map(({ header }) => header).filter(({ coding }) => coding.name === "cells")),
    {
      words: new Uint32Array(),
      firstSets: [],
    },
  );
});

test("codec headers are read, and refused where a field is illegal", () => {
  const shape = { face: 0, width: 8, height: 8, unitWidth: 8, unitHeight: 8 };
  const headerOf = (codec: string) => {
    const view = new DataView(new ArrayBuffer(codec.startsWith("CTR") ? 29 : 16));
    view.setFloat64(0, 40, true);
    const isHalf = ["CCLH", "CCB6", "CTRH"].includes(codec);
    if (isHalf) {
      view.setFloat64(8, 100, true);
    } else {
      view.setFloat32(8, -1.5, true);
      view.setUint32(12, 1, true);
    }
    if (view.byteLength > 16) {
      view.setFloat64(16, 77, true);
      view.setUint8(24, 3);
    }
    return { view, bytes: new Uint8Array(view.buffer), isHalf };
  };
  for (const codec of ["CCL8", "CCB1", "CCB7", "CTR8", "CCLH", "CCB6", "CTRH"]) {
    const refuse = (change: (view: DataView) => void, what: string) => {
      const { view, bytes } = headerOf(codec);
      change(view);
      assert.throws(() => parseColorHeader(codec, bytes, shape), FormatError, `${codec}: ${what}`);
    };
    const { bytes, isHalf } = headerOf(codec);
    const header = parseColorHeader(codec, bytes, shape);
    assert.deepEqual([header.isHalf, header.minPsnrDb, header.transfer], [isHalf, 40, "linear"]);
    assert.equal(header.exposureEv, isHalf ? 0 : -1.5);
    assert.throws(() => parseColorHeader(codec, bytes.subarray(1), shape), FormatError);
    assert.throws(() => parseColorHeader(codec, Uint8Array.from([...bytes, 0]), shape), FormatError);
    const odd = () => parseColorHeader(codec, bytes, { ...shape, unitHeight: 6 });
    if (codec.startsWith("CCB")) {
      assert.throws(odd, FormatError);
    } else {
      assert.equal(odd().kind, "color");
    }
    refuse((view) => view.setFloat64(0, NaN, true), "quality");
    for (const exposure of isHalf ? [] : [33, -33, NaN]) {
      refuse((view) => view.setFloat32(8, exposure, true), "exposure");
    }
    for (const white of isHalf ? [0, -1, Infinity] : []) {
      refuse((view) => view.setFloat64(8, white, true), "white");
    }
    if (!isHalf) {
      refuse((view) => view.setUint32(12, 2, true), "transfer");
    }
    for (const [at, value] of codec.startsWith("CTR")
      ? [
          [23, 0xc0],
          [24, 4],
          [25, 1],
          [27, 1],
          [28, 9],
          [28, 1],
        ]
      : []) {
      refuse((view) => view.setUint8(at, value), `byte ${at}`);
    }
  }
  assert.throws(() => parseColorHeader("CCLX", headerOf("CCL8").bytes, shape), UnsupportedError);
});
