// Rendering on the processor, beside the program's.

import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import { chunkDecoder } from "../src/codec/decode.ts";
import { parseCodecHeader } from "../src/codec/headers.ts";
import type { Pixels } from "../src/codec/types.ts";
import { Field } from "../src/cpu/field.ts";
import type { Rendered } from "../src/cpu/messages.ts";
import { WorkerTexels } from "../src/cpu/texels.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "./memory_source.ts";
import { unpack } from "../src/format/payload.ts";
import type { Stream } from "../src/format/types.ts";
import { renderOrder } from "../src/player/cpu_renderer.ts";
import { cameraOf } from "../src/views/camera.ts";
import { catalogueOf, streamsOf } from "../src/views/catalogue.ts";
import { unitsUnder } from "../src/views/rects.ts";
import { ColorTexels } from "../src/views/straight.ts";
import {
  bytesOf,
  capture,
  codesOf,
  type Films,
  psnr,
  rendered,
  type Shot,
  withMattes,
  withoutProgram,
} from "./films.ts";

const SIZE: [number, number] = [64, 48];
const LEAST_DB = 50;

/** Decodes a frame of a film and renders it, without workers and a page. */
async function picture(film: string, { pose, frame, size, fovDeg, steps }: Shot): Promise<Rendered> {
  const source = new MemorySource(bytesOf(film));
  const container = await Container.open(source);
  const catalogue = catalogueOf(container);
  const field = new Field();
  const pixels = new Map<string, Pixels>();
  const texels = new WorkerTexels(catalogue, (order) => field.run(structuredClone(order)));
  const hasAlpha = catalogue.views.some(({ faces }) => faces.some(({ alpha }) => alpha !== undefined));
  const colors = new ColorTexels(catalogue.coding, hasAlpha);

  const decode = async (stream: Stream, unit: number): Promise<Pixels> => {
    const at = container.chunkIndex(stream.index, unit, frame);
    const chunk = container.chunks[at];
    const payload = async (number: number): Promise<Uint8Array> => {
      const { offset, storedBytes } = container.chunks[number];
      return unpack(container.chunks[number], await source.read(offset, storedBytes));
    };
    const area = container.areaOf(at);
    const next = area.place === "last" ? undefined : await payload(at + 1);
    const decoder = chunkDecoder(parseCodecHeader(stream, stream.headerBytes), await payload(at), area);
    return decoder.frame(frame - chunk.firstFrame, () => next!).slice();
  };

  for (const [view, { faces }] of catalogue.views.entries()) {
    texels.load(view, (stream, tile) => pixels.get(`${stream} ${tile}`) as Uint16Array);
    for (const face of faces) {
      for (const stream of streamsOf(face)) {
        for (let unit = 0; unit < container.unitCount(stream.index); unit += 1) {
          pixels.set(`${stream.index} ${unit}`, await decode(stream, unit));
        }
      }
      const unitPixels = (stream: Stream, unit: number) => ({
        pixels: pixels.get(`${stream.index} ${unit}`)!,
        rect: container.unitRect(stream.index, unit),
      });
      for (let cell = 0; cell < container.unitCount(face.color.index); cell += 1) {
        const of = unitPixels(face.color, cell);
        const parts = face.alpha === undefined ? [] : [...unitsUnder(face.alpha, of.rect)];
        for (const [matte, part] of parts) {
          texels.uploadColor(face.color.index, part, colors.of(of, part, unitPixels(face.alpha!, matte)));
        }
        if (face.alpha === undefined) {
          texels.uploadColor(face.color.index, of.rect, colors.of(of, of.rect));
        }
      }
      for (const stream of streamsOf(face)) {
        for (let unit = 0; unit < container.unitCount(stream.index); unit += 1) {
          texels.written(stream.index, unit);
        }
      }
    }
  }
  texels.update();
  const camera = cameraOf(pose, fovDeg, size[0] / size[1]);
  const views = catalogue.views.map((_, view) => view);
  return field.run(
    renderOrder(
      { container, catalogue },
      { frame, steps, marksHoles: false, views, showsOverlay: false },
      camera,
      size,
    ),
  )!;
}

function shot(yaw: number, more: Partial<Shot> = {}): Shot {
  return { pose: { eye: [0.05, 1.55, 0.05], yaw, pitch: -0.1 }, frame: 0, size: SIZE, fovDeg: 90, steps: 256, ...more };
}

/** Five poses, and all frames. */
const SHOTS: Shot[] = [
  shot(0),
  shot(1.3, { frame: 1 }),
  shot(2.6, { frame: 2, pose: { eye: [-0.2, 1.5, 0.1], yaw: 2.6, pitch: 0.3 } }),
  shot(-2, { pose: { eye: [0.25, 1.6, 0], yaw: -2, pitch: -0.4 } }),
  // At a probe.
  shot(-0.7, { frame: 1, fovDeg: 60, pose: { eye: [0.3, 1.5, 0], yaw: -0.7, pitch: 0 } }),
];

describe("The processor", { skip: withoutProgram }, () => {
  let films: Films;

  before(() => {
    films = capture("interior", 64);
  });
  after(() => films.remove());

  for (const [name, shots, ...options] of [
    ["the default", SHOTS, "--clip"],
    ["quadtrees", SHOTS.slice(1, 3), "--clip", "--color-codec", "cells", "--depth-codec", "quadtree"],
    ["half floats", SHOTS.slice(1, 3), "--hdr"],
  ] as const) {
    test(`shows what lightfold render shows: ${name}`, async () => {
      const film = films.encode("film.lfold", ...options);
      for (const one of shots) {
        const { rgba, counts } = await picture(film, one);
        const found = psnr(codesOf(rgba), rendered(film, one));
        assert.ok(found >= LEAST_DB, `${found} dB at yaw ${one.pose.yaw}`);
        assert.equal(counts.primary_rays, SIZE[0] * SIZE[1]);
      }
    });
  }

  test("shows what is behind panes with alpha", async () => {
    const film = films.encodeWith("alpha.lfold", withMattes(64), "--clip");
    const { rgba } = await picture(film, SHOTS[1]);
    const found = psnr(codesOf(rgba), rendered(film, SHOTS[1]));
    assert.ok(found >= LEAST_DB, `${found} dB`);
  });
});
