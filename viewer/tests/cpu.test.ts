// Rendering on the processor, beside the program's.

import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import type { Order, Rendered } from "../src/cpu/messages.ts";
import type { Container } from "../src/format/container.ts";
import { CpuRenderer } from "../src/player/cpu_renderer.ts";
import type { DrawRequest } from "../src/player/renderer.ts";
import { cameraOf } from "../src/views/camera.ts";
import type { Catalogue } from "../src/views/catalogue.ts";
import { bytesOf, capture, codesOf, type Films, halvesOf, psnr, renderedHalves, WITH_MATERIALS } from "./films.ts";
import { lightfold, rendered, type Shot, shotOptions, withMattes, withoutProgram } from "./films.ts";
import { MemoryFilm } from "./memory_film.ts";

const SIZE: [number, number] = [64, 48];
const MIN_DB = 50;

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

/** Rays of a kind that the program counts. */
function raysOf(film: string, one: Shot): Record<string, number> {
  const report = lightfold("render", film, ...shotOptions(one), "--null", "--stats", "--json", "-q").toString();
  return JSON.parse(report) as Record<string, number>;
}

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
        const { rgba, counts } = (await MemoryFilm.open(bytesOf(film), one.frame)).render(one);
        const found = psnr(codesOf(rgba), rendered(film, one));
        assert.ok(found >= MIN_DB, `${found} dB at yaw ${one.pose.yaw}`);
        assert.deepEqual(halvesOf(rgba), renderedHalves(film, one));
        assert.equal(counts.primary_rays, SIZE[0] * SIZE[1]);
        const rays = raysOf(film, one);
        for (const kind of ["hole_rays", "background_rays"] as const) {
          assert.ok(Math.abs(counts[kind] - rays[kind]) <= 2, `${kind}: ${counts[kind]}, and ${rays[kind]}`);
        }
      }
    });
  }

  test("shows what is behind panes with alpha", async () => {
    const film = films.encodeWith("alpha.lfold", withMattes(64), "--clip");
    const { rgba } = (await MemoryFilm.open(bytesOf(film), SHOTS[1].frame)).render(SHOTS[1]);
    const found = psnr(codesOf(rgba), rendered(film, SHOTS[1]));
    assert.ok(found >= MIN_DB, `${found} dB`);
    assert.deepEqual(halvesOf(rgba), renderedHalves(film, SHOTS[1]));
  });

  test("follows secondary rays of mirrors and glass", async () => {
    const mirrors = capture("mirrors", 64, ...WITH_MATERIALS);
    try {
      const film = mirrors.encode("film.lfold", "--clip");
      let followed = 0;
      for (const one of SHOTS) {
        const { rgba, counts } = (await MemoryFilm.open(bytesOf(film), one.frame)).render(one);
        const found = psnr(codesOf(rgba), rendered(film, one));
        assert.ok(found >= MIN_DB, `${found} dB at yaw ${one.pose.yaw}`);
        assert.deepEqual(halvesOf(rgba), renderedHalves(film, one));
        assert.equal(counts.secondary_rays, raysOf(film, one)["secondary_rays"]);
        followed += counts.secondary_rays;
      }
      assert.ok(followed > 100, `${followed}`);
    } finally {
      mirrors.remove();
    }
  });

  for (const depth of ["planar", "distance"]) {
    test(`shows what perspective probes of ${depth} see, and nothing beside it`, async () => {
      const views = capture("interior", "67x45", "--look-at=0,1.2,-3", "--fov", "70", "--depth", depth);
      try {
        const film = views.encode("film.lfold", "--clip");
        for (const one of [shot(0.1), shot(0.9, { frame: 1 })]) {
          const { rgba, counts } = (await MemoryFilm.open(bytesOf(film), one.frame)).render(one);
          const found = psnr(codesOf(rgba), rendered(film, one));
          assert.ok(found >= MIN_DB, `${found} dB at yaw ${one.pose.yaw}`);
          assert.deepEqual(halvesOf(rgba), renderedHalves(film, one));
          assert.ok(Math.abs(counts.hole_rays - raysOf(film, one)["hole_rays"]) <= 2);
          assert.ok(counts.hole_rays > 0);
        }
      } finally {
        views.remove();
      }
    });
  }

  test("does not know tiles that are forgotten, until they are written again", async () => {
    const film = await MemoryFilm.open(bytesOf(films.encode("film.lfold", "--clip")), 0);
    const before = film.render(SHOTS[0]);
    const units = film.catalogue.views.flatMap(({ faces }) => faces.flatMap((face) => [...film.unitsOf(face)]));
    const tiles = units.filter(([{ kind }]) => kind === "depth");
    tiles.slice(0, tiles.length / 2).forEach(([{ index }, unit]) => film.texels.forget(index, unit));
    film.texels.update();
    assert.ok(film.render(SHOTS[0]).rgba.some((value, at) => value !== before.rgba[at]));
    tiles.slice(tiles.length / 2).forEach(([{ index }, unit]) => film.texels.forget(index, unit));
    film.texels.update();
    const marked = film.render(SHOTS[0], { marksHoles: true });
    assert.equal(marked.counts.hole_rays, SIZE[0] * SIZE[1]);
    assert.ok(marked.rgba.every((value) => value === 0));
    tiles.forEach(([{ index }, unit]) => film.texels.written(index, unit));
    film.texels.update();
    assert.deepEqual(film.render(SHOTS[0]).rgba, before.rgba);
  });

  test("ends a picture in an error where its worker fails, or the film is closed", async () => {
    const { container, catalogue } = await MemoryFilm.open(bytesOf(films.encode("film.lfold", "--clip")), 0);
    const workers: FakeWorker[] = [];
    class FakeWorker {
      onmessage: ((event: { data: Rendered }) => void) | undefined;
      onerror: ((event: { message: string }) => void) | undefined;
      readonly orders: Order[] = [];
      isEnded = false;
      constructor() {
        workers.push(this);
      }
      postMessage(order: Order): void {
        this.orders.push(order);
      }
      terminate(): void {
        this.isEnded = true;
      }
    }
    const real = globalThis.Worker;
    globalThis.Worker = FakeWorker as unknown as typeof Worker;
    try {
      for (const end of ["error", "close"] as const) {
        const renderer = newRenderer(container, catalogue);
        const failures: string[] = [];
        renderer.onFailed = (message) => failures.push(message);
        const picture = renderer.draw(requestOf(catalogue), () => assert.fail("shown"));
        const worker = workers.at(-1)!;
        assert.equal(worker.orders.at(-1)!.kind, "render");
        if (end === "error") {
          worker.onerror!({ message: "out of memory" });
        } else {
          renderer.close();
        }
        await assert.rejects(picture, end === "error" ? /failed: out of memory/u : /closed/u);
        await assert.rejects(
          renderer.draw(requestOf(catalogue), () => assert.fail("shown")),
          /failed|closed/u,
        );
        assert.deepEqual([failures.length, worker.isEnded], end === "error" ? [1, false] : [0, true]);
      }
    } finally {
      globalThis.Worker = real;
    }
  });
});

function newRenderer(container: Container, catalogue: Catalogue): CpuRenderer {
  const canvas = {} as HTMLCanvasElement;
  const decoding = {} as never;
  return new CpuRenderer({ container, catalogue, canvas, decoding, mostViews: 3, mostImages: 18 });
}

function requestOf(catalogue: Catalogue): DrawRequest {
  const pose = SHOTS[0].pose;
  const view = {
    pose,
    frame: 0,
    playing: false,
    size: SIZE,
    fovDeg: 90,
    stereo: "mono",
    eyeDistance: 0.063,
    exposureEv: 0,
    toneMap: "none",
    overlays: new Set<never>(),
    steps: 128,
  } as const;
  const views = catalogue.views.map((_, place) => place);
  const cameras = [cameraOf(pose, 90, 4 / 3)];
  return { view, cameras, views, isFresh: () => false, codings: () => undefined };
}
