// Jobs of workers, without workers.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { StoredChunk } from "../src/decoder/types.ts";
import type { Answer, Job } from "../src/player/jobs.ts";
import { WorkerPool } from "../src/player/pool.ts";

class FakeWorker {
  onmessage: ((event: { data: Answer }) => void) | undefined;
  onerror: ((event: { message: string }) => void) | undefined;
  readonly jobs: Job[] = [];
  isEnded = false;

  postMessage(job: Job): void {
    this.jobs.push(job);
  }

  answer({ id, frame }: Job): void {
    this.onmessage!({ data: { id, pixels: Uint8Array.of(frame!) } });
  }

  terminate(): void {
    this.isEnded = true;
  }
}

function chunkOf(stream: number): StoredChunk {
  return { chunk: { stream, unit: 0 }, stored: new Uint8Array(), area: {} } as unknown as StoredChunk;
}

function poolOf(count: number): { pool: WorkerPool; workers: FakeWorker[]; failures: string[] } {
  const workers: FakeWorker[] = [];
  const start = (): Worker => {
    workers.push(new FakeWorker());
    return workers.at(-1) as unknown as Worker;
  };
  const pool = new WorkerPool(count, start, (stream) => ({ stream }) as never);
  const failures: string[] = [];
  pool.onFailed = (message) => failures.push(message);
  return { pool, workers, failures };
}

const always = (): boolean => true;

test("a worker has its next jobs while it is at one, in the order in which they came", async () => {
  const { pool, workers } = poolOf(1);
  const [worker] = workers;
  const answers = Array.from({ length: 20 }, (_, frame) => pool.decode(chunkOf(0), frame, always));
  const sent = worker.jobs.length;
  assert.ok(sent > 1 && sent < 20, `${sent} jobs`);
  assert.equal(pool.pending, 20);
  // Only the first job has the outline of its stream.
  assert.deepEqual(
    worker.jobs.map(({ outline }) => outline !== undefined),
    worker.jobs.map((_, at) => at === 0),
  );
  for (let at = 0; at < 20; at += 1) {
    worker.answer(worker.jobs[at]);
    assert.deepEqual(await answers[at], Uint8Array.of(at));
  }
  assert.deepEqual([worker.jobs.length, pool.pending], [20, 0]);
});

test("what is no longer wanted when its turn comes is not sent", async () => {
  const { pool, workers } = poolOf(1);
  let isWanted = true;
  const answers = Array.from({ length: 20 }, (_, frame) => pool.decode(chunkOf(0), frame, () => isWanted));
  const [{ jobs }] = workers;
  const sent = jobs.length;
  isWanted = false;
  workers[0].answer(jobs[0]);
  assert.deepEqual(await Promise.all(answers.slice(sent)), new Array(20 - sent).fill(undefined));
  assert.equal(jobs.length, sent);
});

test("jobs of a worker that ended are rejected, those that it has and later ones, and others go on", async () => {
  const { pool, workers, failures } = poolOf(2);
  const lost = Array.from({ length: 12 }, (_, frame) => pool.decode(chunkOf(0), frame, always));
  const kept = pool.decode(chunkOf(1), 5, always);
  workers[0].onerror!({ message: "out of memory" });
  workers[0].onerror!({ message: "out of memory" });
  for (const one of [...lost, pool.decode(chunkOf(0), 1, always)]) {
    await assert.rejects(one, /failed: out of memory/u);
  }
  assert.equal(failures.length, 1);
  workers[1].answer(workers[1].jobs[0]);
  assert.deepEqual(await kept, Uint8Array.of(5));
  pool.close();
  assert.deepEqual([workers[0].isEnded, workers[1].isEnded], [true, true]);
});
