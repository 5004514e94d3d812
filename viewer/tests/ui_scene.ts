// A small scene as `lightfold simplify` writes it, and PNG files, for ui.test.ts.

import { crc32, deflateSync } from "node:zlib";

/** Red, green, blue, alpha, as 8-bit codes. */
export type Rgba = [number, number, number, number];

function pngChunk(name: string, data: Uint8Array): Buffer {
  const chunk = Buffer.alloc(12 + data.length);
  chunk.writeUInt32BE(data.length, 0);
  chunk.write(name, 4, "latin1");
  chunk.set(data, 8);
  chunk.writeUInt32BE(crc32(chunk.subarray(4, 8 + data.length)) >>> 0, 8 + data.length);
  return chunk;
}

/** A PNG file of one color for each pixel, row by row. */
export function png(width: number, height: number, pixel: (x: number, y: number) => Rgba): Buffer {
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 6, 0, 0, 0], 8);
  const rows = Array.from({ length: height }, (_, y) => [
    0,
    ...Array.from({ length: width }, (_, x) => pixel(x, y)).flat(),
  ]);
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  const chunks = [
    pngChunk("IHDR", head),
    pngChunk("IDAT", deflateSync(Buffer.from(rows.flat()))),
    pngChunk("IEND", Buffer.alloc(0)),
  ];
  return Buffer.concat([signature, ...chunks]);
}

/** The JSON of a scene, to be changed by a test. */
export type SceneJson = Record<string, unknown> & {
  accessors: Record<string, unknown>[];
  images: Record<string, unknown>[];
};

/** Two squares of 2 m that cross the axis -Z at 2 m and, behind it in the file, at 3 m: the second hides the first, though it is
 *  farther. Their colors are the left and right half of the texture. `change` may edit the JSON. */
export function sceneFile(first: Rgba, second: Rgba, change: (json: SceneJson) => void = () => undefined): Buffer {
  const texture = png(8, 4, (x) => (x < 4 ? first : second));
  const square = (z: number): number[] => [-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z];
  const positions = Buffer.from(new Float32Array([...square(-2), ...square(-3)]).buffer);
  const coordinates = Buffer.from(
    new Float32Array([0.25, 0.75].flatMap((s) => [s, 0.5, s, 0.5, s, 0.5, s, 0.5])).buffer,
  );
  const indices = Buffer.from(new Uint16Array([0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6]).buffer);
  const padded = Buffer.concat([texture, Buffer.alloc((4 - (texture.length % 4)) % 4)]);
  const parts = [padded, positions, coordinates, indices];
  const offsets = parts.map((_, at) => parts.slice(0, at).reduce((sum, part) => sum + part.length, 0));
  const bytes = Buffer.concat(parts);
  const view = (at: number, byteLength: number): object => ({ buffer: 0, byteOffset: offsets[at], byteLength });
  const json: SceneJson = {
    asset: { version: "2.0" },
    extras: {
      lightfold: {
        frame: 7,
        viewing_region_m: [
          [-0.5, -0.5, -0.5],
          [0.5, 0.5, 0.5],
        ],
      },
    },
    extensionsUsed: ["KHR_materials_unlit"],
    buffers: [{ byteLength: bytes.length }],
    bufferViews: [
      view(0, texture.length),
      view(1, positions.length),
      view(2, coordinates.length),
      view(3, indices.length),
    ],
    accessors: [
      { bufferView: 1, componentType: 5126, count: 8, type: "VEC3", min: [-1, -1, -3], max: [1, 1, -2] },
      { bufferView: 2, componentType: 5126, count: 8, type: "VEC2" },
      { bufferView: 3, componentType: 5123, count: 12, type: "SCALAR" },
    ],
    images: [{ bufferView: 0, mimeType: "image/png" }],
    samplers: [{ magFilter: 9729, minFilter: 9729, wrapS: 33071, wrapT: 33071 }],
    textures: [{ sampler: 0, source: 0 }],
    materials: [
      {
        alphaMode: "BLEND",
        doubleSided: true,
        extensions: { KHR_materials_unlit: {} },
        pbrMetallicRoughness: { baseColorTexture: { index: 0 } },
      },
    ],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
    nodes: [{ mesh: 0 }],
    scenes: [{ nodes: [0] }],
    scene: 0,
  };
  change(json);
  const text = Buffer.from(JSON.stringify(json));
  const jsonBytes = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
  const head = Buffer.alloc(20);
  const total = 28 + jsonBytes.length + bytes.length;
  [0x46546c67, 2, total, jsonBytes.length, 0x4e4f534a].forEach((word, at) => head.writeUInt32LE(word, 4 * at));
  const between = Buffer.alloc(8);
  [bytes.length, 0x004e4942].forEach((word, at) => between.writeUInt32LE(word, 4 * at));
  return Buffer.concat([head, jsonBytes, between, bytes]);
}
