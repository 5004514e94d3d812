import assert from "node:assert/strict";
import { test } from "node:test";

import { FileChangedError, TransportError } from "../src/format/http.ts";
import type { ByteSource, Chunk } from "../src/format/types.ts";
import { ChunkStore, STORE_SETTINGS } from "../src/player/store.ts";
import type { StoreSettings } from "../src/player/store.ts";

/** A file whose byte at an offset is the offset, and whose requests are answered when the test says so. */
class SlowSource implements ByteSource {
  readonly byteCount = 1 << 20;
  readonly asked: { offset: number; count: number; answer: () => void; fail: (error: unknown) => void }[] = [];

  read(offset: number, count: number): Promise<Uint8Array> {
    return new Promise((resolve, reject) => {
      const bytes = Uint8Array.from({ length: count }, (_, at) => offset + at);
      this.asked.push({ offset, count, answer: () => resolve(bytes), fail: reject });
    });
  }
}

function chunk(offset: number, storedBytes: number): Chunk {
  const place = { stream: 0, unit: 0, firstFrame: 0, frameCount: 1 };
  return { ...place, offset, storedBytes, rawBytes: storedBytes, crc32: 0, storage: "raw" };
}

function storeOf(source: ByteSource, settings: Partial<StoreSettings> = {}): ChunkStore {
  return new ChunkStore(source, { ...STORE_SETTINGS, retryDelayMs: 1, maxDelayMs: 4, ...settings });
}

const turn = (ms = 0) => new Promise((resolve) => setTimeout(resolve, ms));

test("neighbours in the file are one request, in the order of need", async () => {
  const source = new SlowSource();
  const store = storeOf(source);
  const [first, second, third, far] = [chunk(100, 10), chunk(110, 20), chunk(130, 5), chunk(500, 7)];
  store.want([second, far, third, first]);
  assert.deepEqual(
    source.asked.map(({ offset, count }) => [offset, count]),
    [
      [110, 25],
      [500, 7],
      [100, 10],
    ],
  );
  const arrived: string[] = [];
  store.onChunk = (key) => arrived.push(key);
  source.asked[0].answer();
  await turn();
  assert.deepEqual(arrived, ["110 20", "130 5"]);
  assert.deepEqual([...store.get(third)!], [130, 131, 132, 133, 134]);
  assert.equal(store.get(first), undefined);
  assert.equal(store.stats.bytesFetched, 25);
});

test("chunks of one place are fetched once, and those that are here are not fetched again", async () => {
  const source = new SlowSource();
  const store = storeOf(source);
  store.want([chunk(50, 8), chunk(50, 8)]);
  store.want([chunk(50, 8)]);
  assert.equal(source.asked.length, 1);
  source.asked[0].answer();
  await turn();
  store.want([chunk(50, 8)]);
  assert.deepEqual([source.asked.length, store.stats.chunksFetched, store.stats.chunksRefetched], [1, 1, 0]);
});

test("the cache keeps to its budget, but for what is needed now", async () => {
  const source = new SlowSource();
  const store = storeOf(source, { cacheBytes: 25 });
  const chunks = [chunk(100, 10), chunk(200, 10), chunk(300, 10)];
  for (const one of chunks) {
    store.want([one]);
    source.asked.at(-1)!.answer();
    await turn();
  }
  assert.equal(store.get(chunks[0]), undefined);
  assert.notEqual(store.get(chunks[1]), undefined);
  assert.equal(store.stats.cacheBytes, 20);
  store.want(chunks);
  source.asked.at(-1)!.answer();
  await turn();
  assert.deepEqual([store.stats.cacheBytes, store.stats.chunksRefetched], [30, 1]);
});

test("what is in use stays, and ranges may overlap", async () => {
  const source = new SlowSource();
  const store = storeOf(source, { cacheBytes: 25 });
  const [used, wide] = [chunk(100, 10), chunk(100, 12)];
  store.want([used]);
  source.asked.at(-1)!.answer();
  await turn();
  for (const one of [wide, chunk(200, 10), chunk(300, 10)]) {
    store.want([one], [used]);
    source.asked.at(-1)!.answer();
    await turn();
  }
  assert.deepEqual([store.get(used)?.length, store.get(wide)?.length], [10, undefined]);
  assert.equal(source.asked.length, 4);
});

test("a failing server is asked again, and the viewer is told as long as it fails", async () => {
  const source = new SlowSource();
  const store = storeOf(source);
  const problems: string[] = [];
  store.onProblem = (problem) => problems.push(`${problem.passes ? "passes" : "stays"}: ${problem.message}`);
  store.want([chunk(100, 4)]);
  for (let failure = 0; failure < 6; failure += 1) {
    assert.equal(source.asked.length, failure + 1);
    source.asked[failure].fail(new TransportError("the server answered 500"));
    await turn(20);
  }
  // From the fourth failure in a row on.
  const said = "passes: the server answered 500; trying again";
  assert.deepEqual(problems, [said, said, said]);
  source.asked[6].answer();
  await turn();
  assert.deepEqual([...store.get(chunk(100, 4))!], [100, 101, 102, 103]);
});

test("what is no longer needed is not asked for again", async () => {
  const source = new SlowSource();
  const store = storeOf(source);
  store.want([chunk(100, 4)]);
  store.want([]);
  source.asked[0].fail(new TransportError("the connection was cut"));
  await turn(20);
  assert.equal(source.asked.length, 1);
});

test("a file that changes ends fetching", async () => {
  const source = new SlowSource();
  const store = storeOf(source);
  const problems: boolean[] = [];
  store.onProblem = (problem) => problems.push(problem.fatal);
  store.want([chunk(100, 4), chunk(200, 4)]);
  source.asked[0].fail(new FileChangedError("the file has changed"));
  await turn();
  source.asked[1].answer();
  await turn();
  store.want([chunk(300, 4)]);
  assert.deepEqual([problems, source.asked.length], [[true], 2]);
  assert.equal(store.get(chunk(200, 4)), undefined);
});
