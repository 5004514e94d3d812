// How pixels of depth are coded, of the files of tests/vectors: against their pictures, and what `lightfold inspect` counts.

import assert from "node:assert/strict";
import { test } from "node:test";
import { chunkCodings, chunkDecoder } from "../src/codec/decode.ts";
import { parseChunk } from "../src/codec/depth/chunk.ts";
import { BORDER, type Coding, CODING_BITS, CODINGS, KEPT } from "../src/codec/depth/coding_map.ts";
import { NodeChunk } from "../src/codec/depth/node_chunk.ts";
import { functionOf, levelOf } from "../src/codec/depth/nodes.ts";
import type { ChunkArea, Pixels } from "../src/codec/types.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "./memory_source.ts";
import { unpack } from "../src/format/payload.ts";
import { FormatError, type DepthHeader, type Rect, type Stream, UnsupportedError } from "../src/format/types.ts";
import { codingColors, CODING_LEGEND } from "../src/player/coding_colors.ts";
import { CodingMaps, type SeenUnit } from "../src/player/coding_maps.ts";
import type { DecodeContext } from "../src/player/unit_source.ts";
import { lightfold, withoutProgram } from "./films.ts";
import { chance, spoiled, vectors } from "./vectors.ts";

interface DepthChunk {
  file: string;
  stream: Stream;
  header: DepthHeader;
  unit: number;
  firstFrame: number;
  payload: Uint8Array;
  area: ChunkArea;
}

/** All chunks of depth of the valid vectors. */
async function depthChunks(): Promise<DepthChunk[]> {
  const found: DepthChunk[] = [];
  for (const { name, bytes } of vectors("valid")) {
    const container = await Container.open(new MemorySource(bytes));
    for (const [at, chunk] of container.chunks.entries()) {
      const stream = container.streams[chunk.stream];
      if (stream.header.kind === "depth") {
        const payload = unpack(chunk, bytes.subarray(chunk.offset, chunk.offset + chunk.storedBytes));
        const { unit, firstFrame } = chunk;
        const area = container.areaOf(at);
        found.push({ file: name, stream, header: stream.header, unit, firstFrame, payload, area });
      }
    }
  }
  assert.ok(found.length > 100);
  return found;
}

const CHUNKS = await depthChunks();

/** Maps of some frames of a chunk, in this order. */
function mapsOf({ header, payload, area }: DepthChunk, frames: readonly number[]): Pixels[] {
  const decoder = chunkCodings(header, payload, area);
  return frames.map((frame) => decoder.frame(frame).slice());
}

function framesOf({ area }: DepthChunk): number[] {
  return Array.from({ length: area.frames }, (_, frame) => frame);
}

function codingOf(byte: number): Coding {
  return CODINGS[byte & CODING_BITS];
}

function sizeOf({ area }: DepthChunk): [number, number] {
  const [, , width, height] = area.area.rect;
  return [width, height];
}

test("every pixel has a coding that its codec knows", () => {
  const known: Record<string, Coding[]> = {
    boxes: ["values", "one value", "blocks"],
    nodes: ["raw", "biquadratic", "platelet", "bc4w"],
    blocks: ["bc4w"],
    predictive: ["background", "plane", "changed plane", "quarters", "pixels"],
  };
  const found = new Set<Coding>();
  for (const chunk of CHUNKS) {
    const codings = known[chunk.header.coding.name];
    for (const map of mapsOf(chunk, framesOf(chunk))) {
      assert.equal(map.length, sizeOf(chunk)[0] * sizeOf(chunk)[1]);
      new Set([...map].map(codingOf)).forEach((coding) => {
        assert.ok(codings.includes(coding), `${chunk.file}: ${coding}`);
        found.add(coding);
      });
    }
  }
  assert.deepEqual([...found].sort(), CODINGS.slice(1).sort());
});

test("pixels that are kept have the code of the frame before", () => {
  for (const chunk of CHUNKS) {
    const decoder = chunkDecoder(chunk.header, chunk.payload, chunk.area);
    let before: Pixels | undefined;
    mapsOf(chunk, framesOf(chunk)).forEach((map, frame) => {
      const picture = decoder.frame(frame).slice();
      const isRight = map.every((byte, at) => (byte & KEPT) === 0 || picture[at] === before?.[at]);
      assert.ok(isRight, `${chunk.file}, unit ${chunk.unit}, frame ${frame}`);
      before = picture;
    });
  }
});

test("maps do not depend on the order in which they are asked for", () => {
  for (const chunk of CHUNKS) {
    const frames = framesOf(chunk);
    const maps = mapsOf(chunk, frames);
    assert.deepEqual(mapsOf(chunk, [...frames].reverse()).reverse(), maps, chunk.file);
    const last = frames.length - 1;
    assert.deepEqual(mapsOf(chunk, [last, last, 0]), [maps[last], maps[last], maps[0]], chunk.file);
  }
});

/** The pixels of a rectangle in a picture of `width` columns. */
function* pixelsOf([left, top, columns, rows]: Rect, width: number): Generator<{ at: number; isEdge: boolean }> {
  for (let y = top; y < top + rows; y += 1) {
    for (let x = left; x < left + columns; x += 1) {
      yield { at: y * width + x, isEdge: x === left || y === top };
    }
  }
}

test("nodes tile a unit, each with its function and its border", () => {
  let nodes = 0;
  for (const vector of CHUNKS) {
    const chunk = parseChunk(vector.header, vector.payload, vector.area);
    if (!(chunk instanceof NodeChunk) || chunk.frames.some(({ coarse }) => coarse !== undefined)) {
      continue;
    }
    const [width] = sizeOf(vector);
    const [map] = mapsOf(vector, [0]);
    const covers = new Uint8Array(map.length);
    chunk.forEachNode(chunk.frames[0], (place, coefficients, rect) => {
      const wanted = functionOf(levelOf(place), chunk.words, coefficients);
      for (const { at, isEdge } of pixelsOf(rect, width)) {
        covers[at] += 1;
        assert.deepEqual([codingOf(map[at]), map[at] & KEPT, (map[at] & BORDER) !== 0], [wanted, 0, isEdge]);
      }
      nodes += 1;
    });
    assert.ok(covers.every((count) => count === 1));
  }
  assert.ok(nodes > 100, `${nodes} nodes`);
});

function isTree({ header: { coding } }: DepthChunk): boolean {
  return coding.name === "nodes" && coding.isTree;
}

/** What `lightfold inspect --per-frame --json` says that is used here. */
interface Inspected {
  streams: {
    kind: string;
    codec: string;
    node_pixels?: Record<string, number>;
    predicted_pixels?: Record<string, number>;
  }[];
  frame_rows: { kind: string; frame: number; updated_pixels: number }[];
}

test("pixels by coding and frame are as many as lightfold inspect counts", { skip: withoutProgram }, () => {
  for (const file of new Set(CHUNKS.map((chunk) => chunk.file))) {
    const path = `../tests/vectors/valid/${file}.lfold`;
    const inspected = JSON.parse(lightfold("inspect", path, "--per-frame", "--json", "-q").toString()) as Inspected;
    const byFrame = new Map<number, number>();
    const byCoding = new Map<string, number>();
    for (const chunk of CHUNKS.filter((one) => one.file === file)) {
      mapsOf(chunk, framesOf(chunk)).forEach((map, at) => {
        for (const byte of map.filter((one) => (one & KEPT) === 0)) {
          const [frame, coding] = [chunk.firstFrame + at, codingOf(byte)];
          byFrame.set(frame, (byFrame.get(frame) ?? 0) + 1);
          byCoding.set(coding, (byCoding.get(coding) ?? 0) + Number(!isTree(chunk)));
        }
      });
    }
    for (const [frame, pixels] of byFrame) {
      const rows = inspected.frame_rows.filter((row) => row.kind === "depth" && row.frame === frame);
      assert.equal(
        pixels,
        rows.reduce((sum, row) => sum + row.updated_pixels, 0),
        `${file}, frame ${frame}`,
      );
    }
    const counted = new Map<string, number>();
    // Leaves of the intermediate form are tinted by the functions above them; blocks as before a first frame are background.
    for (const { node_pixels, predicted_pixels } of inspected.streams.filter(
      ({ kind, codec }) => kind === "depth" && codec !== "quadtree-intermediate",
    )) {
      for (const [name, pixels] of Object.entries({ ...node_pixels, ...predicted_pixels })) {
        if (name !== "same" && name !== "background") {
          counted.set(name.replace("_", " "), (counted.get(name.replace("_", " ")) ?? 0) + pixels);
        }
      }
    }
    counted.forEach((pixels, coding) => assert.equal(byCoding.get(coding) ?? 0, pixels, `${file}: ${coding}`));
  }
});

test("leaves of the intermediate form show the function above them", () => {
  const trees = CHUNKS.filter(isTree);
  const codings = new Set(trees.flatMap((chunk) => mapsOf(chunk, [0]).flatMap((map) => [...map].map(codingOf))));
  assert.deepEqual([...codings].sort(), ["bc4w", "biquadratic", "platelet", "raw"]);
});

test("a changed payload has maps or is refused", () => {
  let [mapped, refused] = [0, 0];
  const random = chance(5);
  for (let change = 0; change < 2000; change += 1) {
    const chunk = CHUNKS[random(CHUNKS.length)];
    try {
      mapsOf({ ...chunk, payload: spoiled(chunk.payload, random) }, [0, chunk.area.frames - 1]);
      mapped += 1;
    } catch (error) {
      assert.ok(error instanceof FormatError, `${chunk.file}: ${error instanceof Error ? error.stack : String(error)}`);
      refused += 1;
    }
  }
  assert.ok(mapped > 0 && refused > 0);
});

test("colors have no such maps", async () => {
  const { bytes } = vectors("valid").find(({ name }) => name === "color8-cells")!;
  const container = await Container.open(new MemorySource(bytes));
  const { header } = container.streams.find(({ kind }) => kind === "color")!;
  assert.throws(() => chunkCodings(header, new Uint8Array(), container.areaOf(0)), UnsupportedError);
});

test("the legend has all codings once, and kept ones and borders are darker", () => {
  assert.deepEqual(CODING_LEGEND.flatMap(({ codings }) => codings).sort(), CODINGS.slice(1).sort());
  const colors = codingColors();
  assert.equal(colors[0], undefined);
  assert.equal(colors[KEPT | BORDER], undefined);
  const light = (byte: number): number => colors[byte]!.reduce((sum, part) => sum + part, 0);
  for (let number = 1; number < CODINGS.length; number += 1) {
    assert.ok(light(number | BORDER | KEPT) < light(number | BORDER) && light(number | BORDER) < light(number | KEPT));
    assert.ok(light(number | KEPT) < light(number));
  }
});

/** A decoding whose workers answer when they are told to, and the maps that it has. */
function decodeContextOf(side: number): {
  decoding: DecodeContext;
  jobs: (() => Promise<void>)[];
  isHere: (chunk: number) => boolean;
} {
  const jobs: (() => Promise<void>)[] = [];
  const made = { jobs, isHere: (): boolean => true };
  const decoding = {
    container: {
      unitRect: () => [0, 0, side, side],
      chunks: Array.from({ length: 100 }, (_, unit) => ({ unit, firstFrame: 0 })),
      areaOf: () => undefined,
    },
    store: { get: ({ unit }: { unit: number }) => (made.isHere as (chunk: number) => boolean)(unit) || undefined },
    pool: {
      codings: ({ chunk }: { chunk: { unit: number } }, frame: number, isWanted: () => boolean) =>
        new Promise((resolve, reject) =>
          jobs.push(async () => {
            const map = new Uint8Array(side * side).fill(frame);
            if (chunk.unit === 99) {
              reject(new Error("A chunk is broken."));
            } else {
              resolve(isWanted() ? map : undefined);
            }
            await new Promise((next) => setTimeout(next));
          }),
        ),
    },
    onReady: () => undefined,
    frames: { shown: 0, next: [0, 0] },
    onBroken: () => assert.fail("told twice"),
  };
  return Object.assign(made, { decoding: decoding as unknown as DecodeContext });
}

const seen = (unit: number, frame: number): SeenUnit => ({ stream: 0, unit, frame, chunk: unit, next: -1 });

test("a few maps are asked for at a time, the oldest first, and none that is not wanted", async () => {
  const made = decodeContextOf(4);
  const maps = new CodingMaps(made.decoding);
  const units = (frame: number): SeenUnit[] => Array.from({ length: 12 }, (_, unit) => seen(unit, frame));
  assert.equal(maps.show(units(0), []), 12);
  assert.equal(made.jobs.length, 8);
  assert.equal(maps.show(units(1), []), 12);
  assert.equal(made.jobs.length, 8);
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  // Of another frame, which is better than none.
  assert.deepEqual([maps.of(0, 0)?.frame, maps.of(0, 8)], [0, undefined]);
  assert.equal(made.jobs.length, 8);
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  assert.deepEqual([maps.of(0, 8)?.frame, maps.of(0, 3)?.frame, maps.of(0, 4)?.frame], [1, 1, 0]);
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  assert.equal(made.jobs.length, 0);
  assert.equal(maps.show(units(1), []), 0);
  maps.show(units(2), []);
  maps.clear();
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  assert.equal(maps.of(0, 0), undefined);
});

test("maps are not asked for without their chunks, nor again of broken ones", async () => {
  const made = decodeContextOf(4);
  const maps = new CodingMaps(made.decoding);
  made.isHere = (chunk) => chunk !== 1;
  const fetch: unknown[] = [];
  assert.equal(maps.show([seen(1, 0), seen(99, 0)], fetch as never), 2);
  assert.deepEqual(fetch, [made.decoding.container.chunks[1]]);
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  assert.equal(maps.show([seen(99, 1)], []), 0);
  assert.equal(made.jobs.length, 0);
});

test("maps take bounded memory", async () => {
  const made = decodeContextOf(4096);
  const maps = new CodingMaps(made.decoding);
  // 16 MiB each: four have room.
  assert.equal(
    maps.show(
      [0, 1, 2, 3, 4, 5].map((unit) => seen(unit, 0)),
      [],
    ),
    4,
  );
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  maps.show([seen(5, 0)], []);
  await Promise.all(made.jobs.splice(0).map((job) => job()));
  assert.deepEqual(
    [0, 1, 2, 3, 4, 5].map((unit) => maps.of(0, unit) !== undefined),
    [false, true, true, true, false, true],
  );
});
