// Decodes on the graphics device of a browser, for gpu_decode.test.ts.

import { decoder, loadDecoder } from "../src/decoder/module.ts";
import type { Pixels, Prepared } from "../src/decoder/types.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "../src/format/memory.ts";
import type { DepthHeader, Stream } from "../src/format/types.ts";
import { FamilyDecoder } from "../src/gpu/decoder.ts";
import type { Decoded, Wanted } from "../src/gpu/decoder.ts";
import { Gpu } from "../src/gpu/device.ts";
import { familyOf } from "../src/gpu/family.ts";
import { KERNEL_NAMES, kernelSource } from "../src/gpu/kernels.ts";
import { CONSTANTS, memberOffset, putRow, rowsOf, rowWords } from "../src/gpu/layout.ts";
import { readStream } from "./readback.ts";

await loadDecoder();
const gpu = await Gpu.open();
const errors: string[] = [];
gpu.onError = (message) => errors.push(message);

/** Errors that no call waited for, since the last time. */
function uncaught(): string[] {
  return errors.splice(0);
}

/** What the browser's compiler says of each kernel of the player; nothing where it is content. */
async function messages(): Promise<string[]> {
  const found = KERNEL_NAMES.map(async (name) => {
    const module = gpu.device.createShaderModule({ label: name, code: kernelSource(name) });
    const { messages: said } = await module.getCompilationInfo();
    return said.map(({ type, message, lineNum }) => `${name}, line ${lineNum}: ${type}: ${message}`);
  });
  return (await Promise.all(found)).flat();
}

function crcOf(pixels: Pixels): string {
  const bytes = new Uint8Array(pixels.buffer, pixels.byteOffset, pixels.byteLength);
  return decoder().crc32(bytes).toString(16).padStart(8, "0");
}

/** Chunks of a container by key. */
class Chunks {
  readonly #container: Container;

  constructor(container: Container) {
    this.#container = container;
  }

  async prepared(key: number): Promise<Prepared> {
    const chunk = this.#container.chunks[key - 1]!;
    const stored = await this.#container.source.read(chunk.offset, chunk.storedBytes);
    const { [chunk.stream]: stream } = this.#container.streams;
    const opened = decoder().openStream(stream!, stream!.headerBytes);
    const prepared = decoder().prepare(opened, { chunk, stored, area: this.#container.areaOf(key - 1) });
    decoder().closeStream(opened);
    return prepared;
  }

  /** All units of streams that have a frame. */
  wanted(streams: readonly Stream[], frame: number): Wanted[] {
    return streams.flatMap((stream, position) => {
      const units = Array.from({ length: this.#container.unitCount(stream.index) }, (_, unit) => unit);
      return units.flatMap((unit) => {
        const at = this.#container.chunkIndex(stream.index, unit, frame);
        if (at < 0) {
          return [];
        }
        const one = { stream: position, unit, frame, key: at + 1, firstFrame: this.#container.chunks[at]!.firstFrame };
        return [this.#container.placeOf(at) === "last" ? one : { ...one, nextKey: at + 2 }];
      });
    });
  }
}

/** Decodes units, with the chunks that it takes. */
async function decodeAll(decoder: FamilyDecoder, chunks: Chunks, wanted: Wanted[]): Promise<Decoded> {
  for (const one of wanted) {
    const keys = [one.key];
    for (const key of keys) {
      if (!decoder.has(key)) {
        decoder.add(key, await chunks.prepared(key));
      }
      if (key === one.key && decoder.needsNext(one)) {
        keys.push(one.nextKey!);
      }
    }
  }
  let done = decoder.decode(wanted);
  while (done.behind.length > 0) {
    done = decoder.decode(wanted);
  }
  return done;
}

/** Lines of the images of a vector, as its .crc has them, and the streams of alpha, which it leaves out: frames forward, or backward with
 *  chunks dropped in between. */
async function vector({
  name,
  backward,
}: {
  name: string;
  backward: boolean;
}): Promise<{ lines: string[]; alpha: string[] }> {
  const bytes = new Uint8Array(await (await fetch(`/${name}.lfold`)).arrayBuffer());
  const container = await Container.open(new MemorySource(bytes));
  const chunks = new Chunks(container);
  const streams = container.streams.filter(({ kind }) => kind !== "alpha");
  const kernels = new Set(streams.map(({ header }) => familyOf(header).kernel));
  const lines: [number, number, string][] = [];
  for (const kernel of kernels) {
    const ofKernel = streams.filter(({ header }) => familyOf(header).kernel === kernel);
    const decoder = await FamilyDecoder.create(gpu, ofKernel, backward ? 64 : 1);
    const frames = new Set(
      ofKernel.flatMap(({ firstFrame, frameCount }) => Array.from({ length: frameCount }, (_, at) => firstFrame + at)),
    );
    const ordered = [...frames].sort((one, other) => (backward ? other - one : one - other));
    for (const frame of ordered) {
      const wanted = chunks.wanted(ofKernel, frame);
      const { missing, refused } = await decodeAll(decoder, chunks, wanted);
      if (missing.length + refused.length > 0 || !wanted.every((one) => decoder.shows(one))) {
        throw new Error(`${missing.length} units are missing, ${refused.length} refused in frame ${frame}`);
      }
      for (const [position, { index, firstFrame, frameCount }] of ofKernel.entries()) {
        if (frame >= firstFrame && frame < firstFrame + frameCount) {
          lines.push([index, frame, crcOf(await readStream(gpu, decoder, position))]);
        }
      }
      if (backward && frame % 3 === 0) {
        decoder.drop(new Set(), 0);
      }
    }
    decoder.destroy();
  }
  lines.sort(([one, first], [other, second]) => one - other || first - second);
  const alpha = container.streams.filter(({ kind }) => kind === "alpha");
  return { lines: lines.map((line) => line.join(" ")), alpha: alpha.map(({ index }) => String(index)) };
}

const WINDOW_OF_ONE: DepthHeader = {
  kind: "depth",
  range: { nearM: 1, farM: 2 },
  isDistance: false,
  coding: { name: "boxes", window: 1, inBlocks: false },
};

/** A depth stream of one unit of 2x2 pixels. */
function smallStream(frameCount: number): Stream {
  const size = { width: 2, height: 2, unitWidth: 2, unitHeight: 2 };
  return {
    ...{ index: 0, kind: "depth", face: 6, probe: 0, codec: "DAAB", ...size, firstFrame: 0, frameCount },
    header: WINDOW_OF_ONE,
    headerBytes: new Uint8Array(),
  };
}

/** A chunk that sets all codes of frame n to n. */
function countingChunk(frames: number): Prepared {
  const numbers = Array.from({ length: frames }, (_, frame) => frame);
  const bytes = Uint16Array.from({ length: frames + (frames % 2) }, (_, frame) => frame);
  const box = { width: 2, height: 2, coding: CONSTANTS.BOX_CONSTANT, end: 0 };
  return {
    kernel: "codec",
    isNodes: false,
    passes: 0,
    stream: new Uint32Array(bytes.buffer),
    records: rowsOf(
      "Record",
      numbers.map((frame) => ({ frame, first: frame, count: 1, work: 2 })),
    ),
    boxes: rowsOf(
      "BoxRow",
      numbers.map((frame) => ({ ...box, at: 2 * frame, end: 2 })),
    ),
    weights: [0, 0],
    timeline: {
      recordFrames: Uint32Array.from(numbers),
      recordPixels: new Uint32Array(frames).fill(4),
      keyframes: new Uint32Array(),
      weights: new Uint32Array(),
      frameSets: new Uint32Array(),
      framePixels: new Uint32Array(),
    },
  };
}

/** Codes and pixels written of each call that leads to a frame 150 steps away, and how many units are refused 20000 steps away. */
async function rounds(): Promise<{ codes: number[][]; pixels: number[]; refused: number }> {
  const frames = 20_000;
  const decoder = await FamilyDecoder.create(gpu, [smallStream(frames)]);
  const wanted = (frame: number): Wanted => ({ stream: 0, unit: 0, frame, key: 7, firstFrame: 0 });
  decoder.add(7, countingChunk(frames));
  const codes: number[][] = [];
  const pixels: number[] = [];
  for (let done: Decoded | undefined; done === undefined || done.behind.length > 0;) {
    done = decoder.decode([wanted(150)]);
    pixels.push(done.pixels);
    codes.push([...(await readStream(gpu, decoder, 0))]);
  }
  const { refused } = decoder.decode([wanted(frames - 1)]);
  decoder.destroy();
  return { codes, pixels, refused: refused.length };
}

/** What a decoder says and shows of a chunk that is not there, is, was dropped, and came back behind another. */
async function dropping(): Promise<Record<string, unknown>> {
  const before = gpu.bytes;
  const decoder = await FamilyDecoder.create(gpu, [smallStream(8)]);
  const wanted = (frame: number): Wanted => ({ stream: 0, unit: 0, frame, key: 1, firstFrame: 0 });
  const code = async (): Promise<number | undefined> => (await readStream(gpu, decoder, 0))[3];
  const found: Record<string, unknown> = {};
  found.absent = decoder.decode([wanted(3)]).missing.length;
  decoder.add(1, countingChunk(8));
  decoder.decode([wanted(3)]);
  found.decoded = await code();
  decoder.add(2, countingChunk(6));
  decoder.drop(new Set([2]), 0);
  found.isDropped = [decoder.has(1), decoder.has(2), decoder.chunkWords];
  found.missing = decoder.decode([wanted(4)]).missing.length;
  found.kept = [await code(), decoder.shows(wanted(3)), decoder.shows(wanted(4))];
  // Behind the second chunk, whose place it does not fit before.
  decoder.add(1, countingChunk(20));
  decoder.decode([wanted(5)]);
  found.again = await code();
  found.words = decoder.chunkWords;
  decoder.destroy();
  found.leftBytes = gpu.bytes - before;
  return found;
}

/** Rows with vectors, floats and arrays as the device has them. */
function layout(): Record<string, unknown> {
  const words = new Uint32Array(rowWords("View") + 1);
  putRow(words, 1, "View", { near_m: 1, turn_x: [0.5, 0, -2], faces: [1, 2, 3, 4, 5, 6, 7, 2 ** 32 - 1] });
  const offsets = ["from_eye", "near_m", "turn_x", "reach_m", "faces"].map((name) => memberOffset("View", name));
  return {
    words: [rowWords("View"), rowWords("Scene"), rowWords("Face"), rowWords("Chunk"), rowWords("DepthJob")],
    offsets,
    middle: memberOffset("Scene", "middle"),
    values: [words[4], words[5], words[7], words[24]],
  };
}

/** What another device says: an error that nobody waits for, a buffer that is too large, and that it was lost. */
async function failing(): Promise<{ uncaught: boolean; tooLarge: string; lost: string }> {
  const other = await Gpu.open();
  const told = new Promise<string>((resolve) => (other.onError = resolve));
  other.device.createBuffer({ size: 4, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.STORAGE });
  other.submit(() => undefined);
  const uncaught = (await told) !== "";
  let tooLarge = "";
  try {
    other.buffer("pictures", 2 ** 40);
  } catch (error) {
    tooLarge = (error as Error).message.replace(`${other.maxBindingBytes}`, "MOST");
  }
  other.destroy();
  return { uncaught, tooLarge, lost: await other.lost };
}

Object.assign(globalThis, { functions: { failing, messages, vector, rounds, dropping, layout, uncaught } });
