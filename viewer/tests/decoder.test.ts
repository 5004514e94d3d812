// The decoder as a worker has it: instances that stop, and decoders of chunks that are kept.

import assert from "node:assert/strict";
import { test } from "node:test";
import { DecoderCache } from "../src/decoder/cache.ts";
import { Decoder } from "../src/decoder/decoder.ts";
import { DecoderStopped } from "../src/decoder/instance.ts";
import { JobRunner } from "../src/decoder/job_runner.ts";
import { decoderModule } from "../src/decoder/module.ts";
import { Container } from "../src/format/container.ts";
import { stepsOver } from "../src/gpu/steps.ts";
import { blendOf, changedPixels } from "../src/gpu/timeline.ts";
import type { Job } from "../src/player/jobs.ts";
import { MemorySource } from "../src/format/memory.ts";
import { MODULE } from "./use_decoder.ts";
import { storedChunk, valid, vectors } from "./vectors.ts";
import { vectorOpcodes } from "./wasm_opcodes.ts";

/** Opcode of the first relaxed instruction of vectors; none is beyond those. */
const FIRST_RELAXED = 0x100;

/** Asks for keys in turn; answers those whose decoders were made, and those that were closed. */
function madeOf(cache: DecoderCache, keys: readonly string[], bytes = 10): [made: string[], closed: string[]] {
  const [made, closed]: [string[], string[]] = [[], []];
  for (const key of keys) {
    const make = () => {
      made.push(key);
      return { frame: () => new Uint8Array(), close: () => void closed.push(key) };
    };
    assert.equal(
      cache.use(key, bytes, make, (decoder) => typeof decoder.frame),
      "function",
    );
  }
  return [made, closed];
}

test("a film that has more decoders than there is room for keeps as many as fit", () => {
  let now = 0;
  const cache = new DecoderCache(30, () => now);
  const all = ["a", "b", "c", "d", "e"];
  assert.deepEqual(madeOf(cache, all), [all, ["d", "e"]]);
  for (let frame = 1; frame < 5; frame += 1) {
    now += 40;
    assert.deepEqual(madeOf(cache, all), [
      ["d", "e"],
      ["d", "e"],
    ]);
  }
  // Those of another view take their places once they are no longer used.
  now += 1000;
  assert.deepEqual(madeOf(cache, ["x", "y", "x"])[0], ["x", "y", "x"]);
  now += 1500;
  assert.deepEqual(madeOf(cache, ["x", "y", "x", "y", "z", "z"])[0], ["x", "y", "z"]);
  assert.deepEqual(madeOf(cache, ["a"])[0], ["a"]);
});

test("what is larger than all room is not kept, and drops nothing that is in use", () => {
  const cache = new DecoderCache(30, () => 0);
  madeOf(cache, ["a", "b"]);
  assert.deepEqual(madeOf(cache, ["large", "large"], 31)[1], ["large", "large"]);
  assert.deepEqual(madeOf(cache, ["a", "b"])[0], []);
});

/** An instance that stops at certain calls of a function, counted from 0 over all instances. */
function startWith(name: string, stops: (call: number) => boolean): { start: () => Decoder; instances: Decoder[] } {
  const instances: Decoder[] = [];
  let calls = 0;
  const start = (): Decoder => {
    const { exports } = new WebAssembly.Instance(decoderModule());
    const real = exports[name] as (...numbers: number[]) => number;
    const stopping = (...numbers: number[]): number => {
      calls += 1;
      // More memory than there is: the real function panics.
      return stops(calls - 1) ? (exports.input as typeof real)(-1) : real(...numbers);
    };
    instances.push(new Decoder({ exports: { ...exports, [name]: stopping } }));
    return instances.at(-1)!;
  };
  return { start, instances };
}

async function jobsOf(name: string): Promise<(frame: number) => Job> {
  const bytes = valid(name);
  const container = await Container.open(new MemorySource(bytes));
  const [stream] = container.streams;
  const { headerBytes } = stream;
  let id = 0;
  return (frame) => {
    const job = { ...storedChunk(container, bytes, 0), id: (id += 1), frame };
    return id === 1 ? { ...job, outline: { stream, headerBytes } } : job;
  };
}

test("an instance that panics is replaced by another, which does the job", async () => {
  const job = await jobsOf("lzma2");
  const wanted = new JobRunner(() => new Decoder(new WebAssembly.Instance(decoderModule())), 1 << 20).run(job(0))[0];
  const again = await jobsOf("lzma2");
  const { start, instances } = startWith("show_frame", (call) => call === 1);
  const runner = new JobRunner(start, 1 << 20);
  assert.deepEqual(runner.run(again(0))[0], wanted);
  assert.equal(instances.length, 1);
  const [{ ...second }] = runner.run(again(0));
  assert.ok("pixels" in second && "pixels" in wanted);
  assert.deepEqual(second.pixels, wanted.pixels);
  assert.deepEqual(
    instances.map(({ isStopped }) => isStopped),
    [true, false],
  );
  assert.throws(() => instances[0].crc32(new Uint8Array()), DecoderStopped);
});

test("a job that stops every instance is answered with a sentence, and later ones are done", async () => {
  const job = await jobsOf("lzma2");
  const { start, instances } = startWith("open_chunk", (call) => call < 2);
  const runner = new JobRunner(start, 1 << 20);
  const [refused, transfer] = runner.run(job(0));
  assert.ok("error" in refused && transfer.length === 0);
  assert.match(refused.error, /^The decoder has stopped: .*\.$/u);
  assert.ok("pixels" in runner.run(job(0))[0]);
  assert.equal(instances.length, 3);
});

test("memory of closed chunks is used again", async () => {
  const job = await jobsOf("lzma2");
  const decoder = new Decoder(new WebAssembly.Instance(decoderModule()));
  const runner = new JobRunner(() => decoder, 0);
  runner.run(job(0));
  const before = decoder.memoryBytes;
  for (let turn = 0; turn < 2000; turn += 1) {
    runner.run(job(0));
  }
  assert.equal(decoder.memoryBytes, before);
});

test("the module imports nothing and has no relaxed instructions, which differ between machines", () => {
  assert.deepEqual(WebAssembly.Module.imports(decoderModule()), []);
  const opcodes = [...vectorOpcodes(MODULE)];
  assert.ok(opcodes.length > 20, `${opcodes.length} kinds of vector instructions`);
  assert.deepEqual(
    opcodes.filter((opcode) => opcode >= FIRST_RELAXED),
    [],
  );
});

test("relaxed instructions are found", () => {
  // A function of no locals: three vectors of zeros, and a relaxed multiplication and addition of them.
  const zeros = [0xfd, 0x0c, ...Array<number>(16).fill(0)];
  const body = [0, ...zeros, ...zeros, ...zeros, 0xfd, 0x85, 0x02, 0x1a, 0x0b];
  const module = Uint8Array.from([...MODULE.subarray(0, 8), 10, body.length + 2, 1, body.length, ...body]);
  assert.deepEqual([...vectorOpcodes(module)], [0x0c, 0x105]);
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

test("timelines of prepared chunks say what changes, and which frames need the next chunk", async () => {
  const leading = new Set<string>();
  for (const { name, bytes } of vectors("valid")) {
    const container = await Container.open(new MemorySource(bytes));
    for (const [at, { stream: number, frameCount }] of container.chunks.entries()) {
      const stream = container.streams[number];
      if (stream.kind !== "color") {
        continue;
      }
      const chunk = storedChunk(container, bytes, at);
      const [, , width, height] = chunk.area.rect;
      const decoder = new Decoder(new WebAssembly.Instance(decoderModule()));
      const opened = decoder.openStream(stream, stream.headerBytes);
      const { timeline } = decoder.prepare(opened, chunk);
      const frames = decoder.openChunk(opened, chunk);
      let before: Uint8Array | Uint16Array | undefined;
      for (let frame = 0; frame < frameCount; frame += 1) {
        if (blendOf(timeline, frame).needsNext) {
          leading.add(stream.codec);
          assert.throws(() => frames.frame(frame), /next chunk/u);
          before = undefined;
          continue;
        }
        const picture = frames.frame(frame).slice();
        let differing = 0;
        for (let sample = 0; before !== undefined && sample < picture.length; sample += 3) {
          differing += [0, 1, 2].some((part) => picture[sample + part] !== before![sample + part]) ? 1 : 0;
        }
        const shown = frame === 0 ? undefined : frame - 1;
        const changed = changedPixels(timeline, frame, shown, width * height);
        assert.ok(differing <= changed && changed <= width * height, `${name}, frame ${frame}`);
        before = picture;
      }
    }
  }
  assert.deepEqual([...leading].sort(), ["CCL8", "CCLH"]);
});
