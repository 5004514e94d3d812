// Cameras, visible units, active views, and texels: the parts of rendering that the processor does.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { Probe, Quaternion, Rect, Stream, StreamKind, Vec3 } from "../src/format/types.ts";
import { UnsupportedError } from "../src/format/types.ts";
import { above, pyramidSizes } from "../src/views/pyramid.ts";
import { decoder } from "../src/decoder/module.ts";
import { tileGrid, tilePlace } from "../src/gpu/tile_grid.ts";
import { add, cross, dot, inverse, length, rotate, rotation, scale, subtract } from "../src/math.ts";
import type { Axes } from "../src/math.ts";
import { activeViews } from "../src/views/active.ts";
import type { Camera } from "../src/views/camera.ts";
import { cameraOf, stereoEyes } from "../src/views/camera.ts";
import { catalogueOf, hasFrame } from "../src/views/catalogue.ts";
import { rayLength, texelMap, VIEW_FACE } from "../src/views/face.ts";
import { joined, overlap } from "../src/views/rects.ts";
import { selectViews } from "../src/views/selection.ts";
import { colorTexels } from "../src/views/straight.ts";
import { VisibleUnits } from "../src/views/visible.ts";
import { halfBits } from "./exr.ts";
import { atLength } from "./films.ts";
import "./use_decoder.ts";

const [X, Y, Z]: Axes = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const [NEGATIVE_X, NEGATIVE_Y, NEGATIVE_Z]: Axes = [
  [-1, 0, 0],
  [0, -1, 0],
  [0, 0, -1],
];

/** Forward, right and down of faces 0 to 6, in the axes of the probe. */
const FACE_AXES: readonly Axes[] = [
  [X, NEGATIVE_Z, NEGATIVE_Y],
  [NEGATIVE_X, Z, NEGATIVE_Y],
  [Y, X, Z],
  [NEGATIVE_Y, X, NEGATIVE_Z],
  [Z, X, NEGATIVE_Y],
  [NEGATIVE_Z, NEGATIVE_X, NEGATIVE_Y],
  [NEGATIVE_Z, X, NEGATIVE_Y],
];

/** The vector with length 1; not finite where it has none. */
function normalize(a: Vec3): Vec3 {
  return scale(a, 1 / length(a));
}

/** The number of a half float's bit pattern. */
function halfValue(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const [exponent, fraction] = [(bits >> 10) & 31, bits & 1023];
  if (exponent === 31) {
    return fraction === 0 ? sign * Infinity : NaN;
  }
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1024 + fraction) * 2 ** (exponent - 25));
}

/** Numbers from 0 to 1, the same in each run. */
function randoms(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function near(found: readonly number[], wanted: readonly number[], within = 1e-12): void {
  assert.equal(found.length, wanted.length);
  found.forEach((value, at) => assert.ok(Math.abs(value - wanted[at]) <= within, `${found} is not ${wanted}`));
}

const STRAIGHT: Quaternion = [0, 0, 0, 1];

function probe(name: string, position: Vec3, orientation = STRAIGHT): Probe {
  return { name, position, orientation, frames: [0, 0], intrinsics: [40, 50, 30, 20] };
}

/** A stream of 64x48 pixels in units of 16x12. */
function stream(index: number, of: number, face: number, kind: StreamKind): Stream {
  const shape = { width: 64, height: 48, unitWidth: 16, unitHeight: 12, firstFrame: 4, frameCount: 2 };
  const place = { index, kind, face, probe: of, codec: "", headerBytes: new Uint8Array(), ...shape };
  if (kind === "color") {
    const coding = { name: "cells" } as const;
    return {
      ...place,
      header: { kind, isHalf: false, transfer: "srgb", exposureEv: 1, coding },
    };
  }
  const range = { nearM: 0.5, farM: 20 };
  return { ...place, header: { kind: "depth", range, isDistance: true, coding: { name: "blocks" } } };
}

/** What a container says of probes that have images of these faces. */
function layout(probes: Probe[], faces: readonly number[], moving = ""): ConstructorParameters<typeof VisibleUnits>[0] {
  const kinds: readonly StreamKind[] = ["depth", "color"];
  const places = probes.flatMap((_, of) => faces.flatMap((face) => kinds.map((kind) => ({ of, face, kind }))));
  const pose = { frame: 0, position: [0, 0, 0] as Vec3, orientation: STRAIGHT };
  const poses = new Map(moving === "" ? [] : [[moving, [pose]]]);
  return {
    probes,
    streams: places.map(({ of, face, kind }, index) => stream(index, of, face, kind)),
    footage: { chromaticities: [], clippedPixels: undefined, missingFrames: [], poses, view: undefined },
    unitCount: () => 16,
  };
}

test("Quaternions turn as rotations do, and back", () => {
  const half = Math.SQRT1_2;
  near(rotate([0, half, 0, half], [0, 0, -1]), [-1, 0, 0]);
  near(rotate([half, 0, 0, half], [0, 1, 0]), [0, 0, 1]);
  const turn = rotation([0.1, -0.5, 0.7, 0.5])!;
  near(rotate(inverse(turn), rotate(turn, [1, 2, 3])), [1, 2, 3], 1e-14);
  assert.equal(rotation([0, 0, 0, 0.9]), undefined);
});

/** Direction, of length 1, of a position in the picture: 0 to 1 from left to right, and from top to bottom. */
function directionAt({ axes: [forward, right, down], half }: Camera, [x, y]: readonly [number, number]): Vec3 {
  const [u, v] = [(2 * x - 1) * half[0], (2 * y - 1) * half[1]];
  return normalize(add(add(forward, scale(right, u)), scale(down, v)));
}

test("A camera looks where its pose says", () => {
  const pose = { eye: [1, 2, 3] as Vec3, yaw: 0, pitch: 0 };
  const [forward, right, down] = cameraOf(pose, 90, 2).axes;
  near([...forward, ...right, ...down], [0, 0, -1, 1, 0, 0, 0, -1, 0]);
  near(cameraOf({ ...pose, yaw: Math.PI / 2 }, 90, 2).axes[0], [-1, 0, 0]);
  near(cameraOf({ ...pose, pitch: Math.PI / 2 }, 90, 2).axes[0], [0, 1, 0]);
  const turned = cameraOf({ ...pose, yaw: 0.7, pitch: -0.4 }, 90, 2);
  turned.axes.forEach((axis, at) => turned.axes.forEach((other, to) => near([dot(axis, other)], [at === to ? 1 : 0])));
  near(cross(turned.axes[0], turned.axes[1]), turned.axes[2]);
  // 45 degrees up in the middle of the upper edge; twice as far to the right.
  near(directionAt(cameraOf(pose, 90, 2), [0.5, 0]), normalize([0, 1, -1]));
  near(directionAt(cameraOf(pose, 90, 2), [1, 0.5]), normalize([2, 0, -1]));
  const [left, other] = stereoEyes(turned, 0.06);
  near(subtract(other.eye, left.eye), scale(turned.axes[1], 0.06));
  near(scale(add(other.eye, left.eye), 0.5), pose.eye);
});

/** Column and row of a point, from the probe in its own axes, in the images of faces. */
function project(faces: readonly number[], at: Vec3): { face: number; plane: [number, number] } | undefined {
  const isView = faces.includes(VIEW_FACE);
  const forwards = FACE_AXES.map(([forward]) => dot(forward, at));
  const face = isView ? VIEW_FACE : forwards.indexOf(Math.max(...forwards.slice(0, VIEW_FACE)));
  const [forward, right, down] = FACE_AXES[face];
  const depth = dot(forward, at);
  return depth > 0 ? { face, plane: [dot(right, at) / depth, dot(down, at) / depth] } : undefined;
}

/** Texels that a ray looks up at points of all distances, with those beside them; each must lie in a unit that is seen. */
function countLookups(camera: Camera, container: ReturnType<typeof layout>, faces: readonly number[]): number {
  const visible = new VisibleUnits(container);
  visible.look([camera]);
  let lookups = 0;
  for (let at = 0; at < 64; at += 1) {
    const direction = directionAt(camera, [(at % 8) / 7, Math.floor(at / 8) / 7]);
    for (let distanceM = 0.01; distanceM < 1e6; distanceM *= 1.1) {
      const point = add(camera.eye, scale(direction, distanceM));
      container.probes.forEach((from, of) => {
        const local = rotate(inverse(rotation(from.orientation)!), subtract(point, from.position));
        const found = project(faces, local);
        if (found === undefined || length(local) < 0.5) {
          return;
        }
        const map = texelMap(found.face, [64, 48], from.intrinsics);
        const places = found.plane.map((value, axis) => value * map.scale[axis] + map.center[axis]);
        for (const [right, down] of [-1, 1].flatMap((x) => [-1, 1].map((y) => [x, y]))) {
          const [column, row] = [Math.floor(places[0] + right), Math.floor(places[1] + down)];
          if (column < 0 || row < 0 || column >= 64 || row >= 48) {
            continue;
          }
          lookups += 1;
          const unit = Math.floor(row / 12) * 4 + Math.floor(column / 16);
          const of_ = container.streams.filter(({ probe, face }) => probe === of && face === found.face);
          of_.forEach((one) => assert.ok(visible.sees(one, unit), `${camera.eye}: ${found.face} ${column} ${row}`));
        }
      });
    }
  }
  return lookups;
}

test("Every unit that a ray looks up is visible", { skip: atLength }, () => {
  const next = randoms(7);
  const between = (): number => 2 * next() - 1;
  const anywhere = (by: number): Vec3 => [by * between(), by * between(), by * between()];
  let lookups = 0;
  for (let run = 0; run < 24; run += 1) {
    const faces = run % 3 === 2 ? [VIEW_FACE] : [0, 1, 2, 3, 4, 5];
    const probes = [0, 1, 2].map((at) => {
      const [x, y, z, w] = [between(), between(), between(), between()];
      const by = 1 / Math.hypot(x, y, z, w);
      return probe(`${at}`, anywhere(1), [x * by, y * by, z * by, w * by]);
    });
    // Sometimes in a probe, where only directions decide; sometimes narrow, along a ray that passes the near plane of a probe.
    const eye: Vec3 = run % 4 === 3 ? [...probes[0].position] : anywhere(1.5);
    const ahead = subtract(add(probes[1].position, scale(normalize(anywhere(1)), 0.55)), eye);
    const isNarrow = run % 2 === 0;
    const pose = isNarrow
      ? { eye, yaw: Math.atan2(-ahead[0], -ahead[2]), pitch: Math.atan2(ahead[1], Math.hypot(ahead[0], ahead[2])) }
      : { eye, yaw: 4 * between(), pitch: 1.5 * between() };
    const camera = cameraOf(pose, isNarrow ? 0.5 : 20 + 70 * next(), 0.5 + next());
    lookups += countLookups(camera, layout(probes, faces), faces);
  }
  assert.ok(lookups > 100_000, `${lookups}`);
});

test("Units behind the eye and beside the picture are not visible", () => {
  const container = layout([probe("a", [0, 0, 0])], [0, 1, 2, 3, 4, 5]);
  const visible = new VisibleUnits(container);
  visible.look([cameraOf({ eye: [0, 0, 0], yaw: 0, pitch: 0 }, 40, 1)]);
  const depth = (face: number): Stream => container.streams.find((one) => one.face === face && one.kind === "depth")!;
  // 64x48 pixels from -1 to 1: 20 degrees reach columns 20 to 44 and rows 15 to 33, and margins of two pixels more.
  const middle = [0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0];
  assert.deepEqual([...visible.units(depth(5))], middle);
  [0, 1, 2, 3, 4].forEach((face) => assert.deepEqual([...visible.units(depth(face))], new Array(16).fill(0)));
  // A second eye adds to what the first sees, and other cameras replace it.
  const behind = cameraOf({ eye: [0, 0, 0], yaw: Math.PI, pitch: 0 }, 40, 1);
  visible.look([cameraOf({ eye: [0, 0, 0], yaw: 0, pitch: 0 }, 40, 1), behind]);
  assert.deepEqual([visible.sees(depth(5), 5), visible.sees(depth(4), 5)], [true, true]);
  visible.look([behind]);
  assert.deepEqual([visible.sees(depth(5), 5), visible.sees(depth(4), 5)], [false, true]);
});

test("All units of a moving probe are visible", () => {
  const container = layout([probe("still", [0, 0, 0]), probe("moving", [0, 0, 0])], [5], "moving");
  const visible = new VisibleUnits(container);
  visible.look([cameraOf({ eye: [0, 0, 0], yaw: Math.PI, pitch: 0 }, 40, 1)]);
  const counts = container.streams.map((one) => visible.units(one).reduce((sum, seen) => sum + seen, 0));
  assert.deepEqual(counts, [0, 0, 16, 16]);
});

test("The nearest views are active, in their order", () => {
  const candidates = ([-3, 1, 2, -1] as const).map((x, view) => ({ view, position: [x, 0, 0] as Vec3 }));
  assert.deepEqual(selectViews(candidates, [0, 0, 0], 9), [1, 3, 2, 0]);
  assert.deepEqual(selectViews(candidates, [-2, 0, 0], 2), [0, 3]);
  assert.deepEqual(selectViews(candidates, [0, 0, 0], 0), [1]);
});

test("The catalogue has probes with both color and depth", () => {
  const container = layout([probe("a", [0, 0, 0]), probe("b", [1, 0, 0])], [0, 5]);
  const streams = container.streams.filter(({ probe: of, kind, face }) => of === 0 || kind === "depth" || face === 0);
  const { views, coding } = catalogueOf({ ...container, streams });
  assert.deepEqual(
    views.map(({ faces, nearM, farM }) => [faces.map(({ face }) => face), nearM, farM]),
    [
      [[0, 5], 0.5, 20],
      [[0], 0.5, 20],
    ],
  );
  assert.deepEqual(coding, { name: "codes", transfer: "srgb", exposureEv: 1 });
  assert.deepEqual(
    [3, 4, 5, 6].map((frame) => hasFrame(views[0], frame)),
    [false, true, true, false],
  );
  const odd = streams.map((one) => (one.kind === "color" ? { ...one, width: 32 } : one));
  assert.throws(() => catalogueOf({ ...container, streams: odd }), UnsupportedError);
  assert.throws(
    () => catalogueOf({ ...container, streams: streams.filter((one) => one.kind === "color") }),
    UnsupportedError,
  );
  const unturned = [{ ...container.probes[0], orientation: [0, 0, 0, 2] as Quaternion }, container.probes[1]];
  assert.throws(() => catalogueOf({ probes: unturned, streams }), UnsupportedError);
});

test("Active views are placed relative to the eye", () => {
  const half = Math.SQRT1_2;
  const probes = [probe("a", [2, 0, 0], [0, half, 0, half]), probe("b", [1e6, 0, 1])];
  const catalogue = catalogueOf(layout(probes, [0, 1, 2, 3, 4, 5]));
  const active = activeViews(catalogue, [1, 0], [1e6, 0, 0], (of) => probes[of]);
  near(active.views[0].fromEye, [0, 0, 1]);
  assert.equal(active.nearest, 0);
  assert.equal(active.nearM, 0.5);
  near([active.views[0].cameraWeight, active.views[1].cameraWeight], [1 / 0.010001, 1 / 1.01], 1e-3);
  // A cube face reaches farther in its corners, up to the middle of a texel there.
  near([active.farM - (1e6 - 2)], [20 * Math.sqrt(1 + (63 / 64) ** 2 + (47 / 48) ** 2)], 1e-4);
  // What the world has along x, a probe turned to the left by 90 degrees has along z.
  near(active.views[1].turn.flat(), [0, 0, 1, 0, 1, 0, -1, 0, 0]);
});

test("Steps are even in the logarithm of distance, from near to far", () => {
  const { distancesM, logStep, uncertainty } = decoder().raySteps(4, 0.5, 8, 3);
  near([...distancesM], [0.5, 1, 2, 4, 8], 1e-6);
  near([logStep], [Math.LN2], 1e-6);
  // An interval from 4 to 8 that was halved three times ends at 7.5 or behind it.
  near([uncertainty], [Math.log(8 / 7.5)], 1e-6);
  assert.deepEqual([...decoder().raySteps(4, 2, 1, 3).distancesM], [2]);
});

test("Depth codes become inverse depths", () => {
  const bits = decoder().inverseDepths({ nearM: 0.25, farM: 16 });
  const inverse = new Float32Array(bits.buffer);
  assert.deepEqual([inverse.length, inverse[0], inverse[65534], inverse[65535]], [65536, 4, 1 / 16, 0]);
  near([inverse[32767]], [0.5], 1e-6);
  assert.ok(inverse.every((value, code) => code === 0 || value <= inverse[code - 1]));
  const map = texelMap(0, [4, 2], [0, 0, 0, 0]);
  near([rayLength(map, 3, 0)], [Math.sqrt(1 + 0.75 ** 2 + 0.5 ** 2)], 1e-6);
});

test("Half floats round to nearest, and colors are finite and straight", () => {
  for (let bits = 0; bits < 0x7c00; bits += 1) {
    assert.equal(halfBits(halfValue(bits)), bits);
    assert.equal(halfBits(-halfValue(bits)), bits === 0 ? 0 : bits | 0x8000);
  }
  assert.deepEqual([1 + 2 ** -11, 1 + 3 * 2 ** -11, 1e9, -1e9].map(halfBits), [0x3c00, 0x3c02, 0x7bff, 0xfbff]);
  const rect: Rect = [4, 6, 2, 1];
  const light = { pixels: Uint16Array.of(0x7c00, 0xfc00, 0x7e00, 0x3800, 0x3400, 0), rect };
  const halves = { name: "light" } as const;
  assert.deepEqual([...colorTexels(halves, light, rect)], [0x7bff, 0xfbff, 0, 0x3c00, 0x3800, 0x3400, 0, 0x3c00]);
  const alpha = { pixels: Uint8Array.of(0, 0, 0, 0, 51, 255), rect: [3, 5, 3, 2] as Rect };
  const [, , , , ...second] = colorTexels(halves, light, rect, alpha);
  assert.deepEqual(second, [0x3800, 0x3400, 0, 0x3c00]);
  assert.deepEqual([...colorTexels(halves, light, [4, 6, 1, 1], alpha)].slice(3), [halfBits(0.2)]);
  const codes = { name: "codes", transfer: "linear", exposureEv: 0 } as const;
  const bytes = { pixels: Uint8Array.of(10, 20, 200, 1, 2, 3), rect };
  assert.deepEqual([...colorTexels(codes, bytes, rect, alpha)], [50, 100, 255, 51, 1, 2, 3, 255]);
});

test("Rectangles are joined, and cover the same texels", () => {
  const grid = Array.from({ length: 12 }, (_, at): Rect => [(at % 4) * 8, Math.floor(at / 4) * 8, 8, 8]);
  assert.deepEqual(joined(grid), [[0, 0, 32, 24]]);
  const parts = joined(grid.filter((_, at) => at !== 5));
  assert.ok(parts.length < 6);
  for (let at = 0; at < 12; at += 1) {
    const covered = parts.filter((part) => overlap(part, grid[at]) !== undefined).length;
    assert.equal(covered, at === 5 ? 0 : 1);
  }
});

test("Pyramids end in one square, and parts of levels cover what changed", () => {
  assert.deepEqual(pyramidSizes([5, 2]), [
    [3, 1],
    [2, 1],
    [1, 1],
  ]);
  assert.deepEqual(pyramidSizes([1, 1]), [[1, 1]]);
  assert.deepEqual(above([3, 4, 2, 1], 0), [1, 2, 2, 1]);
  assert.deepEqual(above([3, 4, 2, 1], 2), [0, 0, 1, 1]);
});

test("Tiles take layers first, and none overlaps another", () => {
  const limits = { side: 100, layers: 4 };
  const grid = (count: number): number[] => Object.values(tileGrid([30, 20], count, limits));
  assert.deepEqual(
    [grid(4), grid(5), grid(60)],
    [
      [1, 1, 4],
      [2, 1, 3],
      [3, 5, 4],
    ],
  );
  assert.throws(() => grid(61), UnsupportedError);
  assert.throws(() => tileGrid([101, 20], 1, limits), UnsupportedError);
  const places = Array.from({ length: 60 }, (_, tile) => tilePlace(tileGrid([30, 20], 60, limits), tile));
  assert.equal(new Set(places.map((place) => Object.values(place).join())).size, 60);
  assert.ok(places.every(({ column, row, layer }) => column < 3 && row < 5 && layer < 4));
});

test("Faces of a cube are mirrored, as they are seen from outside", () => {
  FACE_AXES.slice(0, VIEW_FACE).forEach(([forward, right, down]: Axes) => near(cross(right, down), scale(forward, -1)));
});
