// What is said where there is no graphics device.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Gpu, NoWebGpuError } from "../src/gpu/device.ts";

/** The message of opening a device where these globals are as given. */
async function refusal(globals: { isSecureContext: boolean; navigator: object }): Promise<string> {
  for (const [name, value] of Object.entries(globals)) {
    Object.defineProperty(globalThis, name, { value, configurable: true });
  }
  const error: unknown = await Gpu.open().then(
    () => undefined,
    (reason: unknown) => reason,
  );
  assert.ok(error instanceof NoWebGpuError);
  return error.message;
}

test("A missing device is named in one sentence", async () => {
  const without = (adapter: unknown): object => ({ gpu: { requestAdapter: () => Promise.resolve(adapter) } });
  assert.match(
    await refusal({ isSecureContext: false, navigator: without(null) }),
    /^WebGPU needs a secure page:.*\.$/,
  );
  assert.equal(await refusal({ isSecureContext: true, navigator: {} }), "This browser has no WebGPU.");
  assert.match(
    await refusal({ isSecureContext: true, navigator: without(null) }),
    /no graphics device that it may use\.$/,
  );
  const few = { limits: { maxStorageBuffersPerShaderStage: 4 } };
  assert.match(await refusal({ isSecureContext: true, navigator: without(few) }), /fewer than 8 buffers\.$/);
  const busy = {
    limits: { maxStorageBuffersPerShaderStage: 8 },
    features: new Set(),
    requestDevice: () => Promise.reject(new Error("busy")),
  };
  assert.match(await refusal({ isSecureContext: true, navigator: without(busy) }), /cannot be opened: Error: busy\.$/);
});
