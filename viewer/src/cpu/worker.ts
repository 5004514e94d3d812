// The worker that renders, where there is no graphics device.

import { Field } from "./field.ts";
import type { FieldSettings, Order } from "./messages.ts";

let field: Field | undefined;

self.onmessage = ({ data }: MessageEvent<Order | FieldSettings>) => {
  if ("module" in data) {
    field = new Field(new WebAssembly.Instance(data.module), data.coding);
    return;
  }
  const rendered = field?.run(data);
  if (rendered !== undefined) {
    self.postMessage(rendered, { transfer: [rendered.rgba.buffer as ArrayBuffer] });
  }
};
