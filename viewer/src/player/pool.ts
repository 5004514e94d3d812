// Workers, and the jobs that wait for them.

import type { Pixels, Prepared, StoredChunk } from "../decoder/types.ts";
import type { Answer, Job, StreamOutline } from "./jobs.ts";

interface Waiting {
  job: Job;
  /** Asked when the job's turn comes. */
  isWanted: () => boolean;
  resolve: (answer: Answer | undefined) => void;
}

/** Jobs that a worker has at a time: while one is done, the next ones are there. */
const MAX_SENT = 8;

interface Member {
  worker: Worker;
  /** Streams whose outlines it has. */
  knows: Set<number>;
  queue: Waiting[];
  /** Jobs that it has, by their numbers. */
  sent: Map<number, Waiting>;
  /** Why it does nothing any more. */
  failure: string | undefined;
}

/** A pool of workers. Each has the chunks of certain units, whose decoders it keeps; its jobs run in the order in which they come. */
export class WorkerPool {
  private readonly members: Member[];
  private nextId = 0;

  /** A worker does not load, or ended: its jobs, also later ones, are rejected. */
  onFailed: (message: string) => void = () => undefined;

  /** `start` makes a worker; `outline` describes a stream. */
  constructor(
    count: number,
    start: () => Worker,
    private readonly outline: (stream: number) => StreamOutline,
  ) {
    this.members = Array.from({ length: count }, () => this.member(start()));
  }

  /** Jobs that wait or run. */
  get pending(): number {
    return this.members.reduce((sum, { queue, sent }) => sum + queue.length + sent.size, 0);
  }

  /** A chunk in the form of the device; `undefined` where it was no longer wanted when its turn came. Rejects with the worker's
   *  sentence. */
  async prepare(chunk: StoredChunk, isWanted: () => boolean): Promise<Prepared | undefined> {
    const answer = await this.run({ ...chunk, id: this.nextId++ }, isWanted);
    return answer && "prepared" in answer ? answer.prepared : undefined;
  }

  /** The pixels of a frame, counted from the chunk's first, like {@link WorkerPool.prepare}; `"next"` where it blends into the unit's next
   *  chunk and that was not given. */
  async decode(
    chunk: StoredChunk,
    frame: number,
    isWanted: () => boolean,
    next?: StoredChunk,
  ): Promise<Pixels | "next" | undefined> {
    const job = { ...chunk, id: this.nextId++, frame, ...(next && { next }) };
    const answer = await this.run(job, isWanted);
    if (answer && "needsNext" in answer) {
      return "next";
    }
    return answer && "pixels" in answer ? answer.pixels : undefined;
  }

  /** How each pixel of a frame of depth is coded (player/coding_colors.ts), like {@link WorkerPool.decode}. */
  async codings(chunk: StoredChunk, frame: number, isWanted: () => boolean): Promise<Uint8Array | undefined> {
    const answer = await this.run({ ...chunk, id: this.nextId++, frame, asksCodings: true }, isWanted);
    return answer && "pixels" in answer ? (answer.pixels as Uint8Array) : undefined;
  }

  /** Ends the workers. Jobs that wait answer nothing more. */
  close(): void {
    this.members.forEach(({ worker }) => worker.terminate());
    this.members.forEach((member) => (member.queue = []));
  }

  private member(worker: Worker): Member {
    const member: Member = { worker, knows: new Set(), queue: [], sent: new Map(), failure: undefined };
    worker.onmessage = ({ data }: MessageEvent<Answer>) => this.finish(member, data);
    worker.onerror = ({ message }) =>
      this.fail(member, `A worker of the player failed: ${message ?? "it did not load"}`);
    worker.onmessageerror = () => this.fail(member, "A worker of the player failed: its answer cannot be read");
    return member;
  }

  private async run(job: Job, isWanted: () => boolean): Promise<Answer | undefined> {
    const { stream, unit } = job.chunk;
    const member = this.members[(stream + unit) % this.members.length];
    const answer = await new Promise<Answer | undefined>((resolve) => {
      member.queue.push({ job, isWanted, resolve });
      this.pump(member);
    });
    if (answer && "error" in answer) {
      throw new Error(answer.error);
    }
    return answer;
  }

  private pump(member: Member): void {
    while (member.sent.size < MAX_SENT && member.queue.length > 0) {
      const waiting = member.queue.shift()!;
      const { job } = waiting;
      if (member.failure !== undefined) {
        waiting.resolve({ id: job.id, error: member.failure });
        continue;
      }
      if (!waiting.isWanted()) {
        waiting.resolve(undefined);
        continue;
      }
      member.sent.set(job.id, waiting);
      const { stream } = job.chunk;
      const outline = member.knows.has(stream) ? undefined : this.outline(stream);
      member.knows.add(stream);
      // The store keeps its bytes: they are copied, not transferred.
      member.worker.postMessage({ ...job, ...(outline && { outline }) });
    }
  }

  private fail(member: Member, failure: string): void {
    if (member.failure === undefined) {
      member.failure = failure;
      this.onFailed(failure);
    }
    [...member.sent.keys()].forEach((id) => this.finish(member, { id, error: failure }));
    this.pump(member);
  }

  private finish(member: Member, answer: Answer): void {
    const done = member.sent.get(answer.id);
    member.sent.delete(answer.id);
    done?.resolve(answer);
    this.pump(member);
  }
}
