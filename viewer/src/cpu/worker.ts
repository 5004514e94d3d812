// The worker that renders, where there is no graphics device.

import { Field } from "./field.ts";
import type { Order } from "./messages.ts";

const field = new Field();

self.onmessage = ({ data }: MessageEvent<Order>) => {
  const rendered = field.run(data);
  if (rendered !== undefined) {
    self.postMessage(rendered, { transfer: [rendered.rgba.buffer as ArrayBuffer] });
  }
};
