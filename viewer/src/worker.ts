// The worker: checks, decompresses and decodes chunks.

import { JobRunner } from "./decoder/job_runner.ts";
import { newDecoder, useModule } from "./decoder/module.ts";
import type { Job, WorkerSettings } from "./player/jobs.ts";

let runner: JobRunner | undefined;

self.onmessage = ({ data }: MessageEvent<Job | WorkerSettings>) => {
  if ("module" in data) {
    useModule(data.module);
    runner = new JobRunner(newDecoder, data.keptBytes);
  } else if (runner !== undefined) {
    const [answer, transfer] = runner.run(data);
    self.postMessage(answer, { transfer });
  }
};
