// The probes of a container that can be rendered: their streams by face. Mirrors src/views/catalogue.rs.

import type { Container } from "../format/container.ts";
import { type DepthHeader, type Stream, type StreamKind, UnsupportedError } from "../format/types.ts";
import type { Coding } from "../render/scene.ts";

/** The streams of a face that has both depth and color. */
export interface FaceStreams {
  face: number;
  size: [number, number];
  header: DepthHeader;
  depth: Stream;
  color: Stream;
  alpha: Stream | undefined;
  material: Stream | undefined;
}

export interface ProbeStreams {
  /** Its place in the container's table. */
  probe: number;
  faces: FaceStreams[];
  /** Of all its depths, in metres. */
  nearM: number;
  farM: number;
}

export interface Catalogue {
  /** At least one. */
  probes: ProbeStreams[];
  coding: Coding;
  isHalf: boolean;
  hasMaterial: boolean;
  /** Width and height that hold any image. */
  largest: [number, number];
}

/** Finds the probes with a face that has both color and depth; an UnsupportedError where there are none, or they do not fit together. */
export function catalogueOf({ streams, probes }: Container): Catalogue {
  const byProbe = new Map<number, ProbeStreams>();
  const all = new Map(streams.map((stream) => [keyOf(stream, stream.kind), stream]));
  for (const depth of streams) {
    const color = all.get(keyOf(depth, "color"));
    if (depth.header.kind !== "depth" || color === undefined) {
      continue;
    }
    const { header, face, width, height } = depth;
    const [alpha, material] = [all.get(keyOf(depth, "alpha")), all.get(keyOf(depth, "material"))];
    const one: FaceStreams = { face, size: [width, height], header, depth, color, alpha, material };
    for (const other of [color, alpha, material]) {
      if (other !== undefined && (other.width !== width || other.height !== height)) {
        throw new UnsupportedError(
          `Probe ${probes[depth.probe].name}: ${other.kind} has ${other.width}x${other.height} pixels and depth ${width}x${height}; ` +
            "rendering takes images of one size.",
        );
      }
    }
    const { nearM, farM } = header.range;
    const known = byProbe.get(depth.probe) ?? { probe: depth.probe, faces: [], nearM, farM };
    known.faces.push(one);
    known.nearM = Math.min(known.nearM, nearM);
    known.farM = Math.max(known.farM, farM);
    byProbe.set(depth.probe, known);
  }
  const faces = [...byProbe.values()].flatMap((probe) => probe.faces);
  if (faces.length === 0) {
    throw new UnsupportedError("No probe of this container has both color and depth, which rendering takes.");
  }
  const coding = codingOf(faces);
  return {
    probes: [...byProbe.values()],
    coding,
    isHalf: coding.transfer === "light",
    hasMaterial: faces.some(({ material }) => material !== undefined),
    largest: [Math.max(...faces.map(({ size }) => size[0])), Math.max(...faces.map(({ size }) => size[1]))],
  };
}

function keyOf({ probe, face }: Stream, kind: StreamKind): string {
  return `${probe} ${face} ${kind}`;
}

function codingOf(faces: readonly FaceStreams[]): Coding {
  const codings = faces.map(({ color: { header } }): Coding => {
    if (header.kind !== "color" || header.isHalf) {
      return { transfer: "light", exposureEv: 0 };
    }
    return { transfer: header.transfer, exposureEv: header.exposureEv };
  });
  const [first] = codings;
  if (codings.some((coding) => coding.transfer !== first.transfer || coding.exposureEv !== first.exposureEv)) {
    throw new UnsupportedError(
      "Colors of one light field are coded in more than one way, which cannot be rendered together.",
    );
  }
  return first;
}
