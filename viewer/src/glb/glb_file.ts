// The head of a binary glTF file that `lightfold simplify` wrote (src/simplify/export/glb.rs), checked before it is given to a loader.

import { FormatError, UnsupportedError } from "../format/types.ts";
import type { Vec3 } from "../format/types.ts";
import { pngSize } from "../quilt.ts";

const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;
const MAX_JSON_BYTES = 2 ** 24;
/** simplify writes one. */
const MAX_NODES = 16;

/** What the player needs to know of a scene besides its mesh. */
export interface SceneHead {
  /** Where eyes see it rightly, in metres. */
  region: { least: Vec3; greatest: Vec3 };
  /** Frame of the dataset that it shows. */
  frame: number;
  triangles: number;
  textureBytes: number;
  textureSize: [number, number];
}

type Json = Record<string, unknown>;

function objectOf(value: unknown): Json {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Json) : {};
}

function listOf(value: unknown): Json[] {
  return Array.isArray(value) ? value.map(objectOf) : [];
}

function wholeOf(value: unknown): number | undefined {
  return typeof value === "number" && Number.isSafeInteger(value) && value >= 0 ? value : undefined;
}

function foreign(why: string): never {
  throw new UnsupportedError(`${why}: a scene of lightfold simplify was expected.`);
}

/** The JSON chunk, and the bytes of the binary chunk behind it. */
function chunksOf(bytes: Uint8Array): { json: Json; binary: Uint8Array } {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 20 || view.getUint32(0, true) !== MAGIC || view.getUint32(4, true) !== 2) {
    foreign("It is no binary glTF 2.0");
  }
  const jsonBytes = view.getUint32(12, true);
  if (view.getUint32(8, true) !== bytes.length || view.getUint32(16, true) !== JSON_CHUNK) {
    throw new FormatError("The glTF file is cut, or begins with another chunk than JSON.");
  }
  if (jsonBytes > Math.min(bytes.length - 20, MAX_JSON_BYTES)) {
    throw new FormatError(`The JSON of the glTF file has ${jsonBytes} bytes, more than fit.`);
  }
  const rest = 20 + jsonBytes;
  const hasBinary = bytes.length >= rest + 8 && view.getUint32(rest + 4, true) === BINARY_CHUNK;
  const binary = hasBinary ? bytes.subarray(rest + 8, rest + 8 + view.getUint32(rest, true)) : new Uint8Array(0);
  try {
    const text = new TextDecoder("utf-8", { fatal: true }).decode(bytes.subarray(20, rest));
    return { json: objectOf(JSON.parse(text)), binary };
  } catch {
    throw new FormatError("The JSON of the glTF file cannot be read.");
  }
}

/** Bytes of a buffer view. */
function viewOf(json: Json, index: unknown, binary: Uint8Array): Uint8Array {
  const view = listOf(json.bufferViews)[wholeOf(index) ?? -1];
  const [offset, length] = [wholeOf(view?.byteOffset ?? 0), wholeOf(view?.byteLength)];
  if (view === undefined || offset === undefined || length === undefined || offset + length > binary.length) {
    throw new FormatError("A buffer view of the glTF file lies outside of its bytes.");
  }
  return binary.subarray(offset, offset + length);
}

/** Nothing may be loaded from elsewhere, and no accessor may ask for more memory than the file has. */
function checkSizes(json: Json, binary: Uint8Array): void {
  if ([...listOf(json.buffers), ...listOf(json.images)].some(({ uri }) => uri !== undefined)) {
    foreign("It names other files");
  }
  const nodes = listOf(json.nodes);
  if (nodes.length > MAX_NODES || nodes.some(({ children }) => children !== undefined)) {
    foreign("It has nodes within nodes, or many");
  }
  listOf(json.bufferViews).forEach((_, index) => viewOf(json, index, binary));
  for (const accessor of listOf(json.accessors)) {
    const count = wholeOf(accessor.count);
    const bytes = viewOf(json, accessor.bufferView, binary);
    if (count === undefined || count > bytes.length || accessor.sparse !== undefined) {
      throw new FormatError("An accessor of the glTF file names more values than there are.");
    }
  }
}

function regionOf(extras: Json): SceneHead["region"] {
  const corners: unknown = extras.viewing_region_m;
  const isPoint = (value: unknown): value is Vec3 =>
    Array.isArray(value) &&
    value.length === 3 &&
    value.every((part) => typeof part === "number" && Math.abs(part) < 1e9);
  if (!Array.isArray(corners) || corners.length !== 2 || !isPoint(corners[0]) || !isPoint(corners[1])) {
    throw new FormatError("extras.lightfold.viewing_region_m of the glTF file: two corners were expected.");
  }
  const [a, b] = [corners[0], corners[1]];
  const each = (choose: (x: number, y: number) => number): Vec3 => [0, 1, 2].map((at) => choose(a[at], b[at])) as Vec3;
  return { least: each(Math.min), greatest: each(Math.max) };
}

/** Reads and checks the head of a scene. */
export function parseSceneHead(bytes: Uint8Array): SceneHead {
  const { json, binary } = chunksOf(bytes);
  const extras = objectOf(json.extras).lightfold;
  if (typeof extras !== "object" || extras === null) {
    foreign("Its extras do not name lightfold");
  }
  checkSizes(json, binary);
  const images = listOf(json.images);
  if (images.length !== 1) {
    foreign(`It has ${images.length} textures`);
  }
  const texture = viewOf(json, images[0].bufferView, binary);
  const primitives = listOf(json.meshes).flatMap((mesh) => listOf(mesh.primitives));
  const accessors = listOf(json.accessors);
  const corners = primitives.map(({ indices }) => wholeOf(accessors[wholeOf(indices) ?? -1]?.count) ?? 0);
  return {
    region: regionOf(objectOf(extras)),
    frame: wholeOf(objectOf(extras).frame) ?? 0,
    triangles: Math.floor(corners.reduce((sum, count) => sum + count, 0) / 3),
    textureBytes: texture.length,
    textureSize: pngSize(texture.subarray(0, 24), "The texture of the scene"),
  };
}
