// What is said where there is no graphics device.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Gpu, NoWebGpuError } from "../src/gpu/device.ts";
import { DeviceRenderer } from "../src/player/device_renderer.ts";
import type { Scene } from "../src/player/renderer.ts";

/** A browser with this adapter. */
function browserWith(adapter: unknown): { gpu: object } {
  return { gpu: { requestAdapter: () => Promise.resolve(adapter) } };
}

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
  assert.match(
    await refusal({ isSecureContext: false, navigator: browserWith(null) }),
    /^WebGPU needs a secure page:.*\.$/,
  );
  assert.equal(await refusal({ isSecureContext: true, navigator: {} }), "This browser has no WebGPU.");
  assert.match(
    await refusal({ isSecureContext: true, navigator: browserWith(null) }),
    /no graphics device that it may use\.$/,
  );
  const blocked = { gpu: { requestAdapter: () => Promise.reject(new Error("blocked")) } };
  assert.match(await refusal({ isSecureContext: true, navigator: blocked }), /no graphics device that it may use\.$/);
  const few = { limits: { maxStorageBuffersPerShaderStage: 4 } };
  assert.match(await refusal({ isSecureContext: true, navigator: browserWith(few) }), /fewer than 8 buffers\.$/);
  const busy = {
    limits: { maxStorageBuffersPerShaderStage: 8 },
    features: new Set(),
    requestDevice: () => Promise.reject(new Error("busy")),
  };
  assert.match(
    await refusal({ isSecureContext: true, navigator: browserWith(busy) }),
    /cannot be opened: Error: busy\.$/,
  );
});

test("A device that cannot be set up counts as none", async () => {
  const gpu = { pipeline: () => Promise.reject(new Error("no compiler")) };
  const scene = { canvas: { getContext: () => null } };
  await assert.rejects(DeviceRenderer.create(gpu as unknown as Gpu, scene as unknown as Scene), NoWebGpuError);
});

test("The device gets as much as the adapter has of what the player uses", async () => {
  const limits = {
    maxStorageBuffersPerShaderStage: 10,
    maxBufferSize: 2 ** 31,
    maxStorageBufferBindingSize: 2 ** 30,
    maxTextureArrayLayers: 2048,
    maxTextureDimension2D: 16384,
    maxTextureDimension3D: 2048,
  };
  let asked: GPUDeviceDescriptor = {};
  const requestDevice = (descriptor: GPUDeviceDescriptor): Promise<never> => {
    asked = descriptor;
    return Promise.reject(new Error("enough"));
  };
  const adapter = { limits, features: new Set(["timestamp-query"]), requestDevice };
  await refusal({ isSecureContext: true, navigator: browserWith(adapter) });
  const { maxStorageBuffersPerShaderStage, maxTextureDimension3D, ...used } = limits;
  assert.deepEqual(asked.requiredLimits, used);
  assert.deepEqual(asked.requiredFeatures, ["timestamp-query"]);
});
