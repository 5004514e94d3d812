// Workers, and the jobs that wait for them.

import type { Pixels, Prepared } from "../codec/types.ts";
import type { Answer, Job, StreamOutline } from "./jobs.ts";

export type Work = Omit<Job, "id" | "outline">;

interface Waiting {
  job: Job;
  resolve: (answer: Answer) => void;
}

interface Member {
  worker: Worker;
  /** Streams whose outlines it has. */
  knows: Set<number>;
  current: Waiting | undefined;
}

/** A pool of workers. Jobs run in the order of {@link WorkerPool.prepare}. */
export class WorkerPool {
  private readonly members: Member[] = [];
  private queue: Waiting[] = [];
  private nextId = 0;

  /** `outline` describes a stream; `start` makes a worker. */
  constructor(
    count: number,
    start: () => Worker,
    private readonly outline: (stream: number) => StreamOutline,
  ) {
    for (let made = 0; made < count; made += 1) {
      const member: Member = { worker: start(), knows: new Set(), current: undefined };
      member.worker.onmessage = (event: MessageEvent<Answer>) => this.finish(member, event.data);
      member.worker.onerror = (event) => {
        const id = member.current?.job.id ?? 0;
        this.finish(member, { id, error: `a worker failed: ${event.message ?? "it did not load"}`, isFormat: false });
      };
      this.members.push(member);
    }
  }

  /** Jobs that wait or run. */
  get pending(): number {
    return this.queue.length + this.members.filter((member) => member.current !== undefined).length;
  }

  /** The chunk in the form of the device. Rejects with the worker's sentence. */
  async prepare(work: Work): Promise<Prepared> {
    const answer = await this.run(work);
    if ("prepared" in answer) {
      return answer.prepared;
    }
    throw new Error("error" in answer ? answer.error : "a worker gave another answer");
  }

  /** The pixels of a frame of a unit. Rejects with the worker's sentence. */
  async decode(work: Work & { frame: number }): Promise<Pixels> {
    const answer = await this.run(work);
    if ("pixels" in answer) {
      return answer.pixels;
    }
    throw new Error("error" in answer ? answer.error : "a worker gave another answer");
  }

  close(): void {
    this.members.forEach((member) => member.worker.terminate());
    this.queue = [];
  }

  private run(work: Work): Promise<Answer> {
    return new Promise((resolve) => {
      this.queue.push({ job: { ...work, id: this.nextId++ }, resolve });
      this.pump();
    });
  }

  private pump(): void {
    for (const member of this.members) {
      if (member.current !== undefined) {
        continue;
      }
      const waiting = this.queue.shift();
      if (waiting === undefined) {
        return;
      }
      member.current = waiting;
      const { job } = waiting;
      const outline = member.knows.has(job.stream) ? undefined : this.outline(job.stream);
      member.knows.add(job.stream);
      // The store keeps its bytes, so that they are copied, not transferred.
      member.worker.postMessage({ ...job, outline });
    }
  }

  private finish(member: Member, answer: Answer): void {
    const done = member.current;
    member.current = undefined;
    done?.resolve(answer);
    this.pump();
  }
}
