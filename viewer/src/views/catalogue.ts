// The probes of a container that can be rendered: those with a face that has both depth and color. Mirrors src/render/views/catalogue.rs.

import type { Container } from "../format/container.ts";
import type { ColorHeader, DepthHeader, Stream, StreamKind } from "../format/types.ts";
import { UnsupportedError } from "../format/types.ts";
import { rotation } from "../math.ts";
import type { TexelMap } from "./face.ts";
import { texelMap } from "./face.ts";

/** How colors are coded: 8-bit codes behind a curve and an exposure in stops, or half floats of linear light. */
export type ColorCoding = { name: "codes"; transfer: ColorHeader["transfer"]; exposureEv: number } | { name: "light" };

/** The number of a coding for functions of src/wasm. */
export function codingNumber(coding: ColorCoding): number {
  return coding.name === "light" ? 0 : coding.transfer === "linear" ? 1 : 2;
}

/** The streams of a face; all of its images have the same size. */
export interface FaceStreams {
  /** Number of the face: 0 to 5 px nx py ny pz nz, or 6. */
  face: number;
  /** Width and height in pixels. */
  size: [number, number];
  map: TexelMap;
  depth: Stream;
  header: DepthHeader;
  color: Stream;
  alpha: Stream | undefined;
  material: Stream | undefined;
}

/** A probe that can be rendered. */
export interface ProbeStreams {
  /** Its row in the probe table. */
  probe: number;
  faces: FaceStreams[];
  /** No surface of it is nearer than `nearM`, or has a greater depth than `farM`; metres. */
  nearM: number;
  farM: number;
}

export interface Catalogue {
  /** In the order of their first depth streams. */
  views: ProbeStreams[];
  coding: ColorCoding;
}

/** All streams of a face. */
export function streamsOf({ depth, color, alpha, material }: FaceStreams): Stream[] {
  return [depth, color, alpha, material].filter((stream) => stream !== undefined);
}

/** First and last frame that all streams of a face have, of each face that has such. */
export function frameRanges({ faces }: ProbeStreams): [number, number][] {
  const ranges = faces.map((face): [number, number] => {
    const streams = streamsOf(face);
    const lasts = streams.map(({ firstFrame, frameCount }) => firstFrame + frameCount - 1);
    return [Math.max(...streams.map(({ firstFrame }) => firstFrame)), Math.min(...lasts)];
  });
  return ranges.filter(([first, last]) => first <= last);
}

/** Whether a probe has a face of which all streams have a frame. */
export function hasFrame(streams: ProbeStreams, frame: number): boolean {
  return frameRanges(streams).some(([first, last]) => first <= frame && frame <= last);
}

function codingOf({ isHalf, transfer, exposureEv }: ColorHeader): ColorCoding {
  return isHalf ? { name: "light" } : { name: "codes", transfer, exposureEv };
}

function checkSizes(name: string, face: FaceStreams): void {
  const [width, height] = face.size;
  const other = streamsOf(face).find((stream) => stream.width !== width || stream.height !== height);
  if (other !== undefined) {
    throw new UnsupportedError(
      `Probe ${name}, face ${face.face}: ${other.kind} has ${other.width}x${other.height} pixels and depth ${width}x${height}; ` +
        "rendering takes images of one size.",
    );
  }
}

/** The probes of a container that can be rendered, at least one. */
export function catalogueOf({ streams, probes }: Pick<Container, "streams" | "probes">): Catalogue {
  const byPlace = new Map(streams.map((stream) => [`${stream.probe} ${stream.face} ${stream.kind}`, stream]));
  const views = new Map<number, ProbeStreams>();
  let coding: ColorCoding | undefined;
  for (const depth of streams) {
    const { header, probe, face, width, height } = depth;
    const of = (kind: StreamKind): Stream | undefined => byPlace.get(`${probe} ${face} ${kind}`);
    const color = of("color");
    if (header.kind !== "depth" || color?.header.kind !== "color") {
      continue;
    }
    const coded = codingOf(color.header);
    coding ??= coded;
    if (JSON.stringify(coding) !== JSON.stringify(coded)) {
      throw new UnsupportedError("Colors of this container are coded in more than one way; the player takes one.");
    }
    const { name, orientation, intrinsics } = probes[probe];
    const size: [number, number] = [width, height];
    const map = texelMap(face, size, intrinsics);
    const found = { face, size, map, depth, header, color, alpha: of("alpha"), material: of("material") };
    checkSizes(name, found);
    if (rotation(orientation) === undefined) {
      throw new UnsupportedError(`Probe ${name}: its orientation is no rotation.`);
    }
    const view = views.get(probe) ?? { probe, faces: [], ...rangeOf(streams, probe) };
    view.faces.push(found);
    views.set(probe, view);
  }
  if (coding === undefined) {
    throw new UnsupportedError("No probe of this container has both color and depth, which rendering takes.");
  }
  return { views: [...views.values()], coding };
}

function rangeOf(streams: readonly Stream[], probe: number): { nearM: number; farM: number } {
  let [nearM, farM] = [Infinity, 0];
  for (const { header, probe: other } of streams) {
    if (other === probe && header.kind === "depth") {
      nearM = Math.min(nearM, header.range.nearM);
      farM = Math.max(farM, header.range.farM);
    }
  }
  return { nearM, farM };
}
