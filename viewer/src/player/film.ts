// What the page shows of a container.

import type { Container } from "../format/container.ts";
import type { Quaternion, Vec3 } from "../format/types.ts";
import { rangeKey } from "./store.ts";
import type { Film, Pose } from "./types.ts";

/** First and last frame of all streams. */
function frameRange({ streams }: Container): [number, number] {
  const first = streams.reduce((least, { firstFrame }) => Math.min(least, firstFrame), Infinity);
  const last = streams.reduce(
    (most, { firstFrame, frameCount }) => Math.max(most, firstFrame + frameCount - 1),
    -Infinity,
  );
  return streams.length === 0 ? [0, 0] : [first, last];
}

/** Yaw and pitch of -Z turned by an orientation. */
function directionOf([x, y, z, w]: Quaternion): { yaw: number; pitch: number } {
  const forward: Vec3 = [-2 * (x * z + w * y), 2 * (w * x - y * z), 2 * (x * x + y * y) - 1];
  const pitch = Math.asin(Math.max(-1, Math.min(1, forward[1])));
  return { yaw: Math.atan2(-forward[0], -forward[2]), pitch };
}

function boxOf(points: readonly Vec3[]): Film["headBox"] {
  const axes = [0, 1, 2] as const;
  const along = (axis: 0 | 1 | 2): number[] => points.map((point) => point[axis]);
  const least = axes.map((axis) => along(axis).reduce((a, b) => Math.min(a, b), Infinity)) as Vec3;
  const greatest = axes.map((axis) => along(axis).reduce((a, b) => Math.max(a, b), -Infinity)) as Vec3;
  return { least, greatest };
}

function squaredDistance(one: Vec3, other: Vec3): number {
  return one.reduce((sum, part, axis) => sum + (part - other[axis]) ** 2, 0);
}

/** Describes a container. Probes without streams of depth and color count for nothing; there is at least one other. */
export function filmOf(container: Container, probes: readonly number[]): Film {
  const [firstFrame, lastFrame] = frameRange(container);
  const at = (frame: number) => probes.map((probe) => container.probeAt(probe, frame));
  const first = at(firstFrame);
  const poses = container.footage.poses;
  const moving = probes.flatMap((probe) => poses.get(container.probes[probe].name) ?? []);
  const headBox = boxOf([...first, ...moving].map(({ position }) => position));
  const middle = headBox.least.map((least, axis) => (least + headBox.greatest[axis]) / 2) as Vec3;
  const nearest = first.reduce((best, probe) =>
    squaredDistance(probe.position, middle) < squaredDistance(best.position, middle) ? probe : best,
  );
  const start: Pose = { eye: [...nearest.position], ...directionOf(nearest.orientation) };
  return {
    name: container.name,
    fileBytes: container.source.byteCount,
    framesPerSecond: container.fps,
    firstFrame,
    frameCount: lastFrame - firstFrame + 1,
    headBox,
    probes: first.map(({ name, position }) => ({ name, position })),
    nearM: nearestOf(container, probes),
    start,
    streams: streamRows(container),
  };
}

function nearestOf({ streams }: Container, probes: readonly number[]): number {
  const nears = streams.flatMap(({ probe, header }) =>
    header.kind === "depth" && probes.includes(probe) ? [header.range.nearM] : [],
  );
  return nears.reduce((least, near) => Math.min(least, near), Infinity);
}

function streamRows({ streams, chunks }: Container): Film["streams"] {
  const bytes = new Float64Array(streams.length);
  const seen = new Set<string>();
  for (const chunk of chunks) {
    // Chunks of the same bytes lie in one place, and count for the first of them.
    const key = rangeKey(chunk);
    bytes[chunk.stream] += seen.has(key) ? 0 : chunk.storedBytes;
    seen.add(key);
  }
  const rows = new Map<string, Film["streams"][number]>();
  for (const { index, kind, codec } of streams) {
    const key = `${kind} ${codec}`;
    const row = rows.get(key) ?? { kind, codec, count: 0, bytes: 0 };
    rows.set(key, { ...row, count: row.count + 1, bytes: row.bytes + bytes[index] });
  }
  return [...rows.values()];
}
