// Codecs of depth, material and alpha against the examples of formats/ and the vectors of tests/vectors.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import type { DepthLikeHeader } from "../src/codec/depth/chunk.ts";
import { codeIn, integerLog2, LOG2_TABLE } from "../src/codec/depth/domain.ts";
import { parseAlphaHeader, parseDepthHeader, parseMaterialHeader } from "../src/codec/depth/header.ts";
import { depthDecoder, prepareDepth } from "../src/codec/depth/index.ts";
import { stepsOver } from "../src/codec/depth/record_table.ts";
import { CODES, MATERIALS } from "../src/codec/depth/texel.ts";
import { builtInTables, depthModel, readTables, tableSet } from "../src/codec/entropy.ts";
import { RansDecoder } from "../src/codec/rans.ts";
import type { ChunkArea, Pixels, Prepared } from "../src/codec/types.ts";
import { Container } from "../src/format/container.ts";
import { crc32 } from "../src/format/crc32.ts";
import { MemorySource } from "./memory_source.ts";
import { unpack } from "../src/format/payload.ts";
import { FormatError, type Stream, UnsupportedError } from "../src/format/types.ts";

const ARITHMETIC = readFileSync("../formats/arithmetic.md", "utf8");
const DEPTH = readFileSync("../formats/depth.md", "utf8");
const VALID = "../tests/vectors/valid";

/** Numbers of the rows of the table whose header row this is. */
function tableOf(text: string, header: string): number[][] {
  const start = text.indexOf(`\n${header}\n`);
  assert.ok(start >= 0, header);
  const lines = text
    .slice(start + 1)
    .split("\n\n")[0]
    .split("\n")
    .slice(2);
  const kinds: Record<string, number> = { linear: 1, inverse: 2 };
  const cells = lines.map((line) => line.split("|").slice(1, -1));
  return cells.map((row) => row.map((cell) => kinds[cell.trim()] ?? Number(cell)));
}

/** The bytes of the first example in hexadecimal behind a heading. */
function exampleOf(heading: string): Uint8Array {
  const [, behind] = DEPTH.split(`\n${heading}`);
  const hex = behind.split("```hex\n")[1].split("```")[0];
  const bytes = hex.split("\n").flatMap((line) => line.slice(6).split("|")[0].split(" ").filter(Boolean));
  return Uint8Array.from(bytes, (byte) => parseInt(byte, 16));
}

interface VectorChunk {
  name: string;
  stream: Stream;
  header: DepthLikeHeader;
  unit: number;
  firstFrame: number;
  payload: Uint8Array;
  area: ChunkArea;
}

/** All chunks of depth, material and alpha of the valid vectors. */
async function readChunks(): Promise<VectorChunk[]> {
  const chunks: VectorChunk[] = [];
  for (const file of readdirSync(VALID).filter((name) => name.endsWith(".lfold"))) {
    const source = new MemorySource(Uint8Array.from(readFileSync(`${VALID}/${file}`)));
    const container = await Container.open(source);
    for (const [at, chunk] of container.chunks.entries()) {
      const stream = container.streams[chunk.stream];
      const { header } = stream;
      if (header.kind === "color") {
        continue;
      }
      const payload = unpack(chunk, await source.read(chunk.offset, chunk.storedBytes));
      const { unit, firstFrame } = chunk;
      chunks.push({ name: file, stream, header, unit, firstFrame, payload, area: container.areaOf(at) });
    }
  }
  assert.ok(chunks.length > 100);
  return chunks;
}

const CHUNKS = await readChunks();

/** Pictures of all frames of a chunk, one after the other. */
function picturesOf({ header, payload, area }: VectorChunk): Pixels[] {
  const decoder = depthDecoder(header, payload, area);
  return Array.from({ length: area.frames }, (_, frame) => decoder.frame(frame).slice());
}

/** Whole numbers below 2^31 that look random, the same in each run. */
function randomFrom(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1103515245) + 12345) & 0x7fffffff;
    return (state >>> 8) % below;
  };
}

test("logarithms and codes are those of arithmetic.md 7", () => {
  assert.deepEqual(
    tableOf(ARITHMETIC, "| i | +0 | +1 | +2 | +3 | +4 | +5 | +6 | +7 |")
      .slice(0, 32)
      .flatMap((row) => row.slice(1)),
    [...LOG2_TABLE.subarray(0, 256)],
  );
  for (const [value, log] of tableOf(ARITHMETIC, "| V | log |")) {
    assert.equal(integerLog2(value), log, `${value}`);
  }
  for (const [kind, base, scale, r, code] of tableOf(ARITHMETIC, "| domain | base | scale | r | code |")) {
    assert.equal(codeIn({ kind, base, scale })(r), code, `domain ${kind}, r ${r}`);
  }
  // The product of a logarithm and the largest scale has 61 bits.
  const widest = codeIn({ kind: 1, base: 0, scale: 0xffffffff });
  assert.equal(widest(1073725440), 65534);
  assert.equal(widest(64), 0);
});

test("steps take the window, and skip records between", () => {
  const frames = Uint32Array.of(0, 1, 2, 3, 7, 2 ** 31);
  assert.deepEqual(stepsOver(frames, undefined, 3, 1), [0, 1, 2, 3]);
  assert.deepEqual(stepsOver(frames, undefined, 3, 2), [0, 2, 3]);
  assert.deepEqual(stepsOver(frames, 1, 3, 2), [3]);
  assert.deepEqual(stepsOver(frames, 3, 1, 2), [0, 1]);
  assert.deepEqual(stepsOver(frames, 3, 3, 2), []);
  assert.deepEqual(stepsOver(frames, 2, 8, 3), []);
  assert.deepEqual(stepsOver(frames, 2, 2 ** 31, 3), [5]);
  assert.deepEqual(stepsOver(frames, 5, 7, 0), [4]);
});

test("the examples of depth.md decode to the codes that it says", () => {
  const stream = { face: 0, width: 12, height: 8, unitWidth: 12, unitHeight: 8 };
  const area = (width: number, height: number, frames: number): ChunkArea => {
    return { area: { imageSize: [width, height], face: 0, rect: [0, 0, width, height] }, frames, place: "last" };
  };
  const header = (codec: string, rest: number[]): DepthLikeHeader => {
    const bytes = new Uint8Array([0, 0, 0x80, 0x3f, 0, 0, 0, 0x40, 0, 0, 0x80, 0x7f, 0, 0, 0, 0, ...rest]);
    return parseDepthHeader(codec, bytes, stream);
  };
  const nodes = [1, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
  const decoder = depthDecoder(header("DQPN", nodes), exampleOf("## 9."), area(12, 8, 2));
  const first = Array.from(decoder.frame(0));
  assert.deepEqual(first.slice(0, 12), [
    20000,
    20032,
    20064,
    20096,
    20128,
    20160,
    20192,
    20224,
    ...Array<number>(4).fill(65535),
  ]);
  assert.deepEqual(first.slice(84), [20448, 20480, 20512, 20544, 20576, 20608, 20640, 20672, 5000, 5000, 5000, 5000]);
  const second = Array.from(decoder.frame(1));
  assert.deepEqual(second, first.with(47, 5008));
  assert.equal(first[47], 5005);

  const tree = depthDecoder(header("DQTR", nodes), exampleOf("## 11."), area(8, 4, 1)).frame(0);
  assert.deepEqual(
    Array.from(tree),
    Array.from({ length: 32 }, (_, at) => 20000 + 32 * (at % 8) + 64 * (at >> 3)),
  );

  const predictive = [2, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
  const predicted = depthDecoder(header("DPRD", predictive), exampleOf("### 15.9 "), area(12, 8, 2));
  const row = [19998, 20033, 20063, 20096, 20129, 20160, 20192, 20224, 65535, 65535, 65535, 65535];
  assert.deepEqual(Array.from(predicted.frame(1).subarray(0, 12)), row);
  assert.equal(predicted.frame(1)[47], 5010);
  assert.deepEqual(Array.from(predicted.frame(0).subarray(0, 12)), row);

  // Two rows of section 14: the second block tile is of values.
  const halves = ["12 12 00 00 00 00 00 00", "34 34 00 00 00 00 00 00"].join(" ");
  const blocks = Array<string>(4).fill(halves).join(" ").split(" ");
  const values = Array<string[]>(16).fill(["34", "12"]).flat();
  const head = "01 00 00 00 00 00 00 00 0c 00 00 00 00 00 00 00 01".split(" ");
  const payload = Uint8Array.from([...head, ...blocks, ...values], (byte) => parseInt(byte, 16));
  const temporal = [1, 0, 1, 0, 0, 0, 0, 0, 8, 0, 0, 0];
  const boxes = depthDecoder(header("DAB5", temporal), payload, area(20, 4, 1)).frame(0);
  assert.deepEqual(Array.from(boxes), Array<number>(80).fill(4660));
});

test("headers with illegal values are refused", () => {
  const stream = { face: 0, width: 64, height: 64, unitWidth: 32, unitHeight: 32 };
  const temporal = [3, 0, 8, 0, 0, 0, 0, 0, 64, 0, 0, 0];
  const material = parseMaterialHeader("MAB1", Uint8Array.from(temporal), stream);
  assert.deepEqual(material, { kind: "material", window: 3, inBlocks: true });
  for (const [at, value] of [
    [0, 0],
    [1, 1],
    [2, 0],
    [3, 2],
    [6, 1],
    [8, 0],
  ]) {
    assert.throws(
      () => parseMaterialHeader("MAAB", Uint8Array.from(temporal).fill(value, at, at + 1), stream),
      FormatError,
    );
  }
  assert.throws(() => parseMaterialHeader("MAAB", Uint8Array.from([...temporal, 0]), stream), FormatError);
  assert.throws(() => parseMaterialHeader("DAAB", Uint8Array.from(temporal), stream), UnsupportedError);
  assert.throws(
    () => parseMaterialHeader("MAB1", Uint8Array.from(temporal), { ...stream, unitWidth: 30 }),
    FormatError,
  );
  assert.equal(parseAlphaHeader("APRD", Uint8Array.of(9, 0, 0, 0), stream).coding.keyframeInterval, 9);
  assert.throws(
    () => parseAlphaHeader("APRD", Uint8Array.of(9, 0, 0, 0), { ...stream, unitHeight: 1025 }),
    FormatError,
  );
});

test("own table sets stand behind the built-in ones", () => {
  const { alphabets, distributionOf } = depthModel();
  const bytes = Array.from(alphabets, (alphabet) => Array<number>(alphabet - 1).fill(100)).flat();
  let at = 0;
  const tables = readTables("depth", 1, () => bytes[at++]);
  assert.equal(at, bytes.length);
  assert.equal(tableSet(tables, 10), undefined);
  const own = tableSet(tables, 9);
  assert.ok(own);
  // Slot 150 is of symbol 1, in which 50 slots lie below it.
  const decoder = new RansDecoder(Uint8Array.of(150, 0, 0, 0x10), own, distributionOf);
  assert.equal(decoder.symbol(409), 1);
  // The state is 100 · 65536 + 50 now: its four low bits are the high ones of the value.
  assert.equal(decoder.bits(16), (2 << 12) | 3);
  assert.throws(() => readTables("depth", 9, () => 0), FormatError);
  assert.throws(() => readTables("depth", 1, () => 2100), FormatError);
  assert.equal(tableSet(builtInTables("depth"), 9), undefined);
});

test("all frames of the vectors decode to the images that are listed", () => {
  const images = new Map<string, { name: string; line: string; bytes: Uint8Array }>();
  for (const chunk of CHUNKS) {
    const { stream, area, firstFrame, name } = chunk;
    const [left, top, width, height] = area.area.rect;
    picturesOf(chunk).forEach((picture, frame) => {
      const samples = picture.length / (width * height);
      const pixelBytes = samples * picture.BYTES_PER_ELEMENT;
      const line = `${stream.index} ${firstFrame + frame} `;
      const key = `${name} ${line}`;
      const image = images.get(key) ?? { name, line, bytes: new Uint8Array(stream.width * stream.height * pixelBytes) };
      images.set(key, image);
      const view = new DataView(image.bytes.buffer);
      for (let at = 0; at < picture.length; at += 1) {
        const pixel = Math.floor(at / samples);
        const place = (top + Math.floor(pixel / width)) * stream.width + left + (pixel % width);
        const to = place * pixelBytes + (at % samples) * picture.BYTES_PER_ELEMENT;
        if (picture.BYTES_PER_ELEMENT === 2) {
          view.setUint16(to, picture[at], true);
        } else {
          view.setUint8(to, picture[at]);
        }
      }
    });
  }
  for (const { name, line, bytes } of images.values()) {
    const listed = readFileSync(`${VALID}/${name.replace(".lfold", ".crc")}`, "utf8").split("\n");
    const expected = listed.find((row) => row.startsWith(line));
    assert.equal(`${line}${crc32(bytes).toString(16).padStart(8, "0")}`, expected, name);
  }
  const codecs = new Set(CHUNKS.map(({ stream }) => stream.codec));
  assert.deepEqual([...codecs].sort(), ["APRD", "DAAB", "DAB5", "DB4W", "DPRD", "DQPN", "DQTR", "MAAB", "MAB1"]);
});

test("frames in any order are those in their order", () => {
  const random = randomFrom(1);
  for (const chunk of CHUNKS) {
    const pictures = picturesOf(chunk);
    const decoder = depthDecoder(chunk.header, chunk.payload, chunk.area);
    for (let step = 0; step < Math.min(12, 3 * pictures.length); step += 1) {
      const frame = random(pictures.length);
      assert.deepEqual(decoder.frame(frame), pictures[frame], `${chunk.name}, unit ${chunk.unit}, frame ${frame}`);
    }
    assert.throws(() => decoder.frame(chunk.area.frames), RangeError);
  }
});

/** Applies the boxes of a prepared record to a picture of `width` columns, as the kernels of shaders/depth do. */
function applyBoxes({ stream, boxes }: Prepared, [first, count, work]: number[], picture: Pixels, width: number): void {
  const texel = picture instanceof Uint16Array ? CODES : MATERIALS;
  const bytes = new Uint8Array(stream.buffer);
  const block = texel.picture(16);
  let end = 0;
  for (let box = first; box < first + count; box += 1) {
    const [x, y, columns, rows, at, coding, boxEnd] = boxes.subarray(7 * box, 7 * box + 7);
    for (let row = 0; row < rows; row += 1) {
      for (let column = 0; column < columns; column += 1) {
        const to = texel.samples * ((y + row) * width + x + column);
        if (coding === 2) {
          const blockAt = Math.floor(row / 4) * Math.ceil(columns / 4) + Math.floor(column / 4);
          texel.decodeBlock(bytes, at + blockAt * texel.blockBytes, block);
          const from = texel.samples * (4 * (row % 4) + (column % 4));
          picture.set(block.subarray(from, from + texel.samples), to);
        } else {
          const pixel = coding === 1 ? 0 : row * columns + column;
          texel.decodeValues(bytes, at + pixel * texel.bytes, picture, to, 1);
        }
      }
    }
    // Words of the rows of a picture that it touches.
    const words = texel === CODES ? Math.floor((x + columns - 1) / 2) - Math.floor(x / 2) + 1 : columns;
    end += words * rows;
    assert.equal(boxEnd, end);
  }
  assert.equal(work, end);
}

test("prepared boxes lead to the decoded pictures", () => {
  let blocks = 0;
  for (const chunk of CHUNKS) {
    const prepared = prepareDepth(chunk.header, chunk.payload, chunk.area);
    if (prepared.isNodes) {
      continue;
    }
    const [, , width, height] = chunk.area.area.rect;
    // On devices alpha is codes, which are cut off at 255 when they are shown.
    const isAlpha = chunk.header.kind === "alpha";
    const pictures = picturesOf(chunk).map((picture) => (isAlpha ? Uint16Array.from(picture) : picture));
    const shown = pictures[0].slice().fill(1);
    const { recordFrames, recordPixels } = prepared.timeline;
    assert.equal(prepared.records.length, 6 * recordFrames.length);
    assert.equal(recordFrames[0], 0);
    assert.equal(recordPixels[0], width * height);
    let record = 0;
    pictures.forEach((picture, frame) => {
      if (recordFrames[record] === frame) {
        const [rowFrame, , first, count, work] = prepared.records.subarray(6 * record, 6 * record + 6);
        assert.equal(rowFrame, frame);
        applyBoxes(prepared, [first, count, work], shown, width);
        record += 1;
      }
      const picked = isAlpha ? shown.map((code) => Math.min(code, 255)) : shown;
      assert.deepEqual(picked, picture, `${chunk.name}, unit ${chunk.unit}, frame ${frame}`);
    });
    assert.equal(record, recordFrames.length);
    for (let row = 5; row < prepared.boxes.length; row += 7) {
      blocks += prepared.boxes[row] === 2 ? 1 : 0;
    }
  }
  assert.ok(blocks > 0);
});

test("prepared nodes cover what changes, with the leaves of the pictures", () => {
  let leaves = 0;
  for (const chunk of CHUNKS) {
    const prepared = prepareDepth(chunk.header, chunk.payload, chunk.area);
    if (!prepared.isNodes) {
      continue;
    }
    const [, , width, height] = chunk.area.area.rect;
    const pictures = picturesOf(chunk);
    const { stream, records, timeline } = prepared;
    let before: Pixels = new Uint16Array(width * height);
    let record = 0;
    pictures.forEach((picture, frame) => {
      const covered = new Uint8Array(width * height);
      if (timeline.recordFrames[record] === frame) {
        const [rowFrame, at, , , work] = records.subarray(6 * record, 6 * record + 6);
        assert.equal(rowFrame, frame);
        assert.equal(at % 4, 0);
        const places = new Uint8Array(stream.buffer, 4 * at + 48, 2 * stream[at]);
        const coefficients = 16 * Math.ceil((4 * at + 48 + places.length) / 16);
        let [node, sum] = [0, 0];
        for (let level = 0; level < 9; level += 1) {
          for (const last = node + stream[at + 1 + level]; node < last; node += 1) {
            sum += 4 ** level;
            const codes = new Uint16Array(stream.buffer, coefficients + 32 * node, 16);
            const [left, top] = [places[2 * node] * (4 << level), places[2 * node + 1] * (4 << level)];
            for (let y = top; y < Math.min(height, top + (4 << level)); y += 1) {
              for (let x = left; x < Math.min(width, left + (4 << level)); x += 1) {
                covered[y * width + x] += 1;
                if (level === 0) {
                  assert.equal(codes[4 * (y - top) + x - left], picture[y * width + x]);
                  leaves += 1;
                }
              }
            }
          }
        }
        assert.equal(node, stream[at]);
        assert.equal(sum, work);
        assert.equal(
          covered.reduce((count, times) => count + times, 0),
          timeline.recordPixels[record],
        );
        record += 1;
      }
      for (let pixel = 0; pixel < covered.length; pixel += 1) {
        assert.ok(covered[pixel] === 1 || (frame > 0 && covered[pixel] === 0 && picture[pixel] === before[pixel]));
      }
      before = picture;
    });
    assert.equal(record, timeline.recordFrames.length);
  }
  assert.ok(leaves > 0);
});

test("damaged payloads decode or are refused with a sentence, and cut ones are refused", () => {
  const random = randomFrom(7);
  let refused = 0;
  const check = (chunk: VectorChunk, payload: Uint8Array): boolean => {
    try {
      picturesOf({ ...chunk, payload });
      prepareDepth(chunk.header, payload, chunk.area);
      return true;
    } catch (error) {
      assert.ok(error instanceof FormatError || error instanceof UnsupportedError, `${chunk.name}: ${String(error)}`);
      assert.match(error.message, /^[A-Z0-9].*\.$/);
      refused += 1;
      return false;
    }
  };
  const seen = new Map<string, number>();
  for (const chunk of CHUNKS) {
    const times = seen.get(chunk.name) ?? 0;
    seen.set(chunk.name, times + 1);
    const { payload } = chunk;
    // Of predictive coding, fewer than four bytes may be a whole substream that is as good with a zero more or less.
    if (times > 2 || payload.length < 6) {
      continue;
    }
    for (const length of [0, 1, 3, 4, 11, 12, payload.length - 1, random(payload.length), random(payload.length)]) {
      if (length < payload.length) {
        assert.equal(check(chunk, payload.slice(0, length)), false, `${chunk.name}, ${length} bytes`);
      }
    }
    assert.equal(check(chunk, Uint8Array.from([...payload, 0])), false, chunk.name);
    for (let time = 0; time < 6; time += 1) {
      const damaged = payload.slice();
      damaged[random(Math.min(payload.length, time < 3 ? 40 : payload.length))] ^= 1 << random(8);
      check(chunk, damaged);
    }
  }
  assert.ok(refused > 500);
});

test("after a frame that is refused, those before it decode again", () => {
  const chunk = CHUNKS.find(
    ({ stream, payload, area }) => stream.codec === "DPRD" && area.frames > 2 && payload.length > 8,
  );
  assert.ok(chunk);
  const pictures = picturesOf(chunk);
  const decoder = depthDecoder(chunk.header, Uint8Array.from([...chunk.payload, 0, 0]), chunk.area);
  const last = pictures.length - 1;
  assert.throws(() => decoder.frame(last), FormatError);
  assert.throws(() => decoder.frame(last), FormatError);
  assert.deepEqual(decoder.frame(1), pictures[1]);
  assert.deepEqual(decoder.frame(last - 1), pictures[last - 1]);
  assert.throws(() => decoder.frame(last), FormatError);
});
