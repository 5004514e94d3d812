// The graphics device: opened once, with its pipelines by kernel. Mirrors src/gpu/device.rs.

import { kernel, kernelSource } from "./kernels.ts";
import type { Binding, KernelName } from "./kernels.ts";

/** Largest buffer of a kernel in bytes, on any device: byte offsets must fit 32 bits. */
const MAX_BUFFER_BYTES = 2 ** 30;

/** Storage buffers that a kernel is given at most. */
const STORAGE_BUFFERS = 8;

/** Limits that are asked for as great as the adapter has them: sizes of buffers, and of the texture arrays of texture_arrays.ts. */
const LIMITS = [
  "maxBufferSize",
  "maxStorageBufferBindingSize",
  "maxTextureArrayLayers",
  "maxTextureDimension2D",
] as const;

/** This browser has no WebGPU device for the page. The message says in one sentence what is missing. */
export class NoWebGpuError extends Error {
  override name = "NoWebGpuError";
}

/** The device cannot do what it was asked. One sentence. */
export class DeviceError extends Error {
  override name = "DeviceError";
}

/** A compute pipeline, and the bindings of its group 0. */
export interface Pipeline {
  pipeline: GPUComputePipeline;
  layout: GPUBindGroupLayout;
  bindings: readonly Binding[];
}

function layoutEntry({ kind }: Binding, binding: number): GPUBindGroupLayoutEntry {
  const visibility = GPUShaderStage.COMPUTE;
  return kind === "read-only-storage" || kind === "storage"
    ? { binding, visibility, buffer: { type: kind } }
    : { binding, visibility, texture: { sampleType: kind, viewDimension: "2d-array" } };
}

/** The browser's adapter, or a `NoWebGpuError`. */
export async function findAdapter(): Promise<GPUAdapter> {
  if (!globalThis.isSecureContext) {
    throw new NoWebGpuError("WebGPU needs a secure page: open it by https, or from localhost.");
  }
  if (typeof navigator === "undefined" || !("gpu" in navigator)) {
    throw new NoWebGpuError("This browser has no WebGPU.");
  }
  // Some browsers reject where they should answer null.
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" }).catch(() => null);
  if (adapter === null) {
    throw new NoWebGpuError("This browser has WebGPU, but no graphics device that it may use.");
  }
  return adapter;
}

function nameOf({ info: { vendor, architecture } }: GPUAdapter): string {
  return [vendor, architecture].filter((part) => part !== "").join(" ") || "graphics device";
}

/** Whether a device is a program on the processor: such ones cannot compile the kernel of secondary rays. */
export function isSoftware(adapter: GPUAdapter): boolean {
  return /swiftshader|llvmpipe|lavapipe|software|basic render/iu.test(nameOf(adapter));
}

export class Gpu {
  readonly device: GPUDevice;
  readonly queue: GPUQueue;
  /** Vendor and architecture, where the browser tells. */
  readonly name: string;
  /** See {@link isSoftware}. */
  readonly isSoftware: boolean;
  /** Bytes of a buffer that a kernel can be given. */
  readonly maxBindingBytes: number;
  /** Whether passes can be timed. */
  readonly hasTimestamps: boolean;
  /** Resolves once the device is lost, with the reason. */
  readonly lost: Promise<string>;
  /** Called with errors that no caller waits for. */
  onError: (message: string) => void = () => undefined;
  #bytes = 0;
  #scratch: GPUBuffer | undefined;
  readonly #pipelines = new Map<KernelName, Promise<Pipeline>>();

  private constructor(device: GPUDevice, adapter: GPUAdapter) {
    const { maxStorageBufferBindingSize, maxBufferSize } = device.limits;
    const largest = Math.min(maxStorageBufferBindingSize, maxBufferSize, MAX_BUFFER_BYTES);
    this.device = device;
    this.queue = device.queue;
    this.name = nameOf(adapter);
    this.isSoftware = isSoftware(adapter);
    this.maxBindingBytes = Math.floor(largest / 16) * 16;
    this.hasTimestamps = device.features.has("timestamp-query");
    this.lost = device.lost.then(({ reason, message }) => message || reason || "unknown");
    device.addEventListener("uncapturederror", (event) => this.onError(event.error.message));
  }

  /** Opens a device, by default the browser's, or throws `NoWebGpuError`. */
  static async open(found?: GPUAdapter): Promise<Gpu> {
    const adapter = found ?? (await findAdapter());
    if (adapter.limits.maxStorageBuffersPerShaderStage < STORAGE_BUFFERS) {
      throw new NoWebGpuError(`The graphics device gives a kernel fewer than ${STORAGE_BUFFERS} buffers.`);
    }
    const requiredFeatures: GPUFeatureName[] = adapter.features.has("timestamp-query") ? ["timestamp-query"] : [];
    const requiredLimits = Object.fromEntries(LIMITS.map((name) => [name, adapter.limits[name]]));
    const descriptor = { label: "lightfold", requiredFeatures, requiredLimits };
    const device = await adapter.requestDevice(descriptor).catch((error: unknown) => {
      throw new NoWebGpuError(`The graphics device cannot be opened: ${String(error)}.`);
    });
    return new Gpu(device, adapter);
  }

  /** Bytes of all buffers of `buffer` that were not released. */
  get bytes(): number {
    return this.#bytes;
  }

  /** The pipeline of a kernel, compiled at its first use. */
  pipeline(name: KernelName): Promise<Pipeline> {
    const known = this.#pipelines.get(name) ?? this.#compile(name);
    this.#pipelines.set(name, known);
    return known;
  }

  async #compile(name: KernelName): Promise<Pipeline> {
    const { entry, bindings } = kernel(name);
    const module = this.device.createShaderModule({ label: name, code: kernelSource(name) });
    const layout = this.device.createBindGroupLayout({ label: name, entries: bindings.map(layoutEntry) });
    const pipeline = await this.device.createComputePipelineAsync({
      label: name,
      layout: this.device.createPipelineLayout({ label: name, bindGroupLayouts: [layout] }),
      compute: { module, entryPoint: entry },
    });
    return { pipeline, layout, bindings };
  }

  /** The group 0 of a kernel: its resources by the names of its bindings. */
  bind({ layout, bindings }: Pipeline, resource: (name: string) => GPUBindingResource): GPUBindGroup {
    const entries = bindings.map(({ name }, binding) => ({ binding, resource: resource(name) }));
    return this.device.createBindGroup({ layout, entries });
  }

  /** Throws if a buffer of so many words is more than the device allows. */
  check(label: string, words: number): void {
    if (4 * words > this.maxBindingBytes) {
      throw new DeviceError(`${label} takes ${4 * words} bytes; the graphics device allows ${this.maxBindingBytes}.`);
    }
  }

  /** A zeroed storage buffer of at least `words` words, with further usages. */
  buffer(label: string, words: number, usage: GPUBufferUsageFlags = 0): GPUBuffer {
    this.check(label, words);
    const size = Math.max(words, 4) * 4;
    const storage = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC;
    const made = this.device.createBuffer({ label, size, usage: storage | usage });
    this.#bytes += size;
    return made;
  }

  /** Scratch memory of at least so many words, which all decoders share: a submission leaves it to the next as it found it. A new one is
   *  zeroed. */
  scratch(words: number): GPUBuffer {
    const held = this.#scratch;
    if (held !== undefined && 4 * words <= held.size) {
      return held;
    }
    this.#scratch = this.buffer("scratch", words);
    if (held !== undefined) {
      this.release(held);
    }
    return this.#scratch;
  }

  /** A buffer of these words. */
  filled(label: string, words: Uint32Array): GPUBuffer {
    const made = this.buffer(label, words.length);
    this.write(made, 0, words);
    return made;
  }

  /** Frees a buffer of `buffer` once submitted work is done with it. */
  release(buffer: GPUBuffer): void {
    this.#bytes -= buffer.size;
    buffer.destroy();
  }

  /** Writes words at a multiple of 4 bytes, after all submitted work. */
  write(buffer: GPUBuffer, offsetBytes: number, words: Uint32Array): void {
    this.queue.writeBuffer(buffer, offsetBytes, words.buffer, words.byteOffset, words.byteLength);
  }

  /** Words of a buffer from a multiple of 4 bytes on, after all submitted work. */
  async read(buffer: GPUBuffer, offsetBytes: number, words: number): Promise<Uint32Array> {
    if (words === 0) {
      return new Uint32Array();
    }
    const usage = GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST;
    const target = this.device.createBuffer({ label: "reading back", size: 4 * words, usage });
    try {
      this.submit((encoder) => encoder.copyBufferToBuffer(buffer, offsetBytes, target, 0, 4 * words));
      await target.mapAsync(GPUMapMode.READ);
      return new Uint32Array(target.getMappedRange().slice(0));
    } finally {
      target.destroy();
    }
  }

  submit(record: (encoder: GPUCommandEncoder) => void): void {
    const encoder = this.device.createCommandEncoder();
    record(encoder);
    this.queue.submit([encoder.finish()]);
  }

  /** Gives the device and all that is on it back. */
  destroy(): void {
    this.device.destroy();
  }
}
