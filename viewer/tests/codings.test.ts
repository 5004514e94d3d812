// How pixels of depth are coded, of the files of tests/vectors: against their pictures, and what `lightfold inspect` counts.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { DecoderStream } from "../src/decoder/decoder.ts";
import { decoder } from "../src/decoder/module.ts";
import type { Pixels, StoredChunk } from "../src/decoder/types.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "../src/format/memory.ts";
import { FormatError, type DepthHeader, type Stream, UnsupportedError } from "../src/format/types.ts";
import {
  BORDER,
  type Coding,
  CODING_BITS,
  CODING_LEGEND,
  CODINGS,
  codingColors,
  KEPT,
} from "../src/player/coding_colors.ts";
import { CodingMaps, type SeenUnit } from "../src/player/coding_maps.ts";
import type { DecodeContext } from "../src/player/unit_source.ts";
import { lightfold, withoutProgram } from "./films.ts";
import { chance, payloadOf, spoiled, storedChunk, vectors, withPayload } from "./vectors.ts";

interface DepthChunk {
  file: string;
  stream: Stream;
  header: DepthHeader;
  opened: DecoderStream;
  stored: StoredChunk;
}

/** All chunks of depth of the valid vectors. */
async function depthChunks(): Promise<DepthChunk[]> {
  const found: DepthChunk[] = [];
  for (const { name, bytes } of vectors("valid")) {
    const container = await Container.open(new MemorySource(bytes));
    for (const [at, chunk] of container.chunks.entries()) {
      const stream = container.streams[chunk.stream];
      if (stream.header.kind === "depth") {
        const opened = decoder().openStream(stream, stream.headerBytes);
        found.push({ file: name, stream, header: stream.header, opened, stored: storedChunk(container, bytes, at) });
      }
    }
  }
  assert.ok(found.length > 100);
  return found;
}

const CHUNKS = await depthChunks();

/** Maps of some frames of a chunk, in this order. */
function mapsOf({ opened, stored }: DepthChunk, frames: readonly number[]): Pixels[] {
  const maps = decoder().openCodings(opened, stored);
  try {
    return frames.map((frame) => maps.frame(frame).slice());
  } finally {
    maps.close();
  }
}

function framesOf({ stored }: DepthChunk): number[] {
  return Array.from({ length: stored.chunk.frameCount }, (_, frame) => frame);
}

function codingOf(byte: number): Coding {
  return CODINGS[byte & CODING_BITS];
}

function sizeOf({ stored }: DepthChunk): [number, number] {
  const [, , width, height] = stored.area.rect;
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
    const pictures = decoder().openChunk(chunk.opened, chunk.stored);
    let before: Pixels | undefined;
    mapsOf(chunk, framesOf(chunk)).forEach((map, frame) => {
      const picture = pictures.frame(frame).slice();
      const isRight = map.every((byte, at) => (byte & KEPT) === 0 || picture[at] === before?.[at]);
      assert.ok(isRight, `${chunk.file}, unit ${chunk.stored.chunk.unit}, frame ${frame}`);
      before = picture;
    });
    pictures.close();
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

test("each node, box or block begins with a border, and the unit has one", () => {
  for (const chunk of CHUNKS) {
    const [width] = sizeOf(chunk);
    const [map] = mapsOf(chunk, [0]);
    // A box has parts that are blocks, and parts that are values.
    const kindOf = (byte: number) => codingOf(byte).replace("blocks", "values");
    map.forEach((byte, at) => {
      const isEdge = at % width === 0 || at < width;
      const differs = !isEdge && [at - 1, at - width].some((other) => kindOf(map[other]) !== kindOf(byte));
      assert.ok((byte & BORDER) !== 0 || !(isEdge || differs), `${chunk.file}, pixel ${at}`);
    });
  }
});

function isTree({ stream }: DepthChunk): boolean {
  return stream.codec === "DQTR";
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
          const [frame, coding] = [chunk.stored.chunk.firstFrame + at, codingOf(byte)];
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
      const stored = withPayload(chunk.stored, spoiled(payloadOf(chunk.stored), random));
      mapsOf({ ...chunk, stored }, [0, stored.chunk.frameCount - 1]);
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
  const at = container.chunks.findIndex(({ stream }) => container.streams[stream].kind === "color");
  const stream = container.streams[container.chunks[at].stream];
  const opened = decoder().openStream(stream, stream.headerBytes);
  assert.throws(() => decoder().openCodings(opened, storedChunk(container, bytes, at)), UnsupportedError);
  decoder().closeStream(opened);
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
