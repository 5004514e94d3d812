// The page around a player without container and device, for ui.test.ts: it draws a room of lines by canvas 2D.

import { NoWebGpuError } from "../src/gpu/device.ts";
import type { Vec3 } from "../src/format/types.ts";
import type { Film, Player, PlayerStats, View, RendererChoice } from "../src/player/types.ts";
import type { FilmFile } from "../src/ui/film_file.ts";
import type { OpenFilm } from "../src/ui/opening.ts";
import { Page } from "../src/ui/page.ts";
import { forwardOf, rightOf } from "../src/ui/pose.ts";

/** A name as of a hostile file. */
const NAME = `atrium <img src=x onerror="globalThis.broken=1"> 'quoted'.lfold`;

const FILM: Film = {
  name: NAME,
  fileBytes: 184_320_112,
  framesPerSecond: 24,
  firstFrame: 10,
  frameCount: 96,
  headBox: { least: [-0.5, 1.2, -0.5], greatest: [0.5, 1.8, 0.5] },
  probes: [0, 1, 2, 3, 4, 5, 6, 7].map((at) => ({
    name: `0${at}`,
    position: [at % 2 ? 0.5 : -0.5, at & 4 ? 1.8 : 1.2, at & 2 ? 0.5 : -0.5] as Vec3,
  })),
  start: { eye: [0, 1.5, 0], yaw: 0, pitch: 0 },
  streams: [
    { kind: "color", codec: "CTR8", count: 48, bytes: 141_000_000 },
    { kind: "depth", codec: "DGD2", count: 48, bytes: 43_000_000 },
  ],
};

/** What tests read, and how the player behaves. */
interface Fake {
  views: View[];
  /** Draws in progress; never more than one. */
  active: number;
  greatestActive: number;
  drawMs: number;
  /** The canvas can be copied in `onShown` alone, as that of a device. */
  isTransient: boolean;
  missing: number;
  opened: number;
  closed: number;
  player: Player | undefined;
  /** No device can be had, or it or the processor fails at the first picture; or the file is at fault. */
  failure: "none" | (typeof FAILURES)[number];
}

const FAILURES = ["no-webgpu", "first-picture", "no-renderer", "format"] as const;

const fake: Fake = {
  views: [],
  active: 0,
  greatestActive: 0,
  drawMs: 5,
  isTransient: false,
  missing: 0,
  opened: 0,
  closed: 0,
  player: undefined,
  failure: FAILURES.find((failure) => location.search === `?${failure}`) ?? "none",
};

function line(view: View, from: Vec3, to: Vec3): [number, number][] {
  const { pose, size, fovDeg } = view;
  const [forward, right] = [forwardOf(pose), rightOf(pose)];
  const up: Vec3 = [
    right[1] * forward[2] - right[2] * forward[1],
    right[2] * forward[0] - right[0] * forward[2],
    right[0] * forward[1] - right[1] * forward[0],
  ];
  const focal = size[1] / 2 / Math.tan((fovDeg * Math.PI) / 360);
  const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const points: [number, number][] = [];
  for (let part = 0; part <= 32; part += 1) {
    const at = from.map((value, axis) => value + ((to[axis] - value) * part) / 32 - pose.eye[axis]) as Vec3;
    const depth = dot(at, forward);
    if (depth > 0.05) {
      points.push([size[0] / 2 + (focal * dot(at, right)) / depth, size[1] / 2 - (focal * dot(at, up)) / depth]);
    }
  }
  return points;
}

function paint(canvas: HTMLCanvasElement, view: View): void {
  const context = canvas.getContext("2d")!;
  [canvas.width, canvas.height] = view.size;
  context.fillStyle = "#3a4046";
  context.fillRect(0, 0, ...view.size);
  context.strokeStyle = "#cfd6dc";
  context.lineWidth = Math.max(1, view.size[1] / 500);
  for (let at = -4; at <= 4; at += 1) {
    for (const height of [0, 3]) {
      for (const ends of [
        [
          [at, height, -4],
          [at, height, 4],
        ],
        [
          [-4, height, at],
          [4, height, at],
        ],
      ] as [Vec3, Vec3][]) {
        context.beginPath();
        line(view, ...ends).forEach(([x, y]) => context.lineTo(x, y));
        context.stroke();
      }
    }
  }
  context.fillStyle = "#e0a050";
  const [x] = line(view, [Math.sin(view.frame / 15), 1.4, -3], [0, 1.4, -3]);
  if (x !== undefined) {
    context.fillRect(x[0] - 9, x[1] - 9, 18, 18);
  }
}

function statsOf(view: View): PlayerStats {
  return {
    counters: {
      primary_rays: view.size[0] * view.size[1],
      march_steps: 18_331_200,
      cells_decoded: 412,
      cells_skipped: 1508,
    },
    decodeMs: 3.2,
    marchMs: 8.75,
    fetchRate: 4_210_000,
    bytesFetched: 21_300_000,
    requests: 37,
    chunksFetched: 412,
    chunksRefetched: 0,
    cacheBytes: 21_000_000,
    unitsBroken: 0,
    overlayMissing: 0,
    unitsMissing: fake.missing,
    shownFrame: view.frame,
  };
}

async function openFake(_file: FilmFile, canvas: HTMLCanvasElement, renderer: RendererChoice): Promise<OpenFilm> {
  fake.opened += 1;
  await new Promise((resolve) => setTimeout(resolve, 30));
  if ((fake.failure === "no-webgpu" || fake.failure === "no-renderer") && renderer !== "cpu") {
    throw new NoWebGpuError("This browser has no WebGPU.");
  }
  if (fake.failure === "format") {
    throw new Error(`index: chunk 3 of <b>${NAME}</b> lies outside of the file`);
  }
  const player: Player = {
    film: FILM,
    renderer: renderer === "cpu" ? "cpu" : "gpu",
    async draw(view) {
      if (fake.failure === "first-picture" && renderer !== "cpu") {
        throw new Error("The device compiles nothing.");
      }
      if (fake.failure === "no-renderer") {
        throw new Error("The worker failed.");
      }
      fake.active += 1;
      fake.greatestActive = Math.max(fake.greatestActive, fake.active);
      fake.views.push(view);
      await new Promise((resolve) => setTimeout(resolve, fake.drawMs));
      paint(canvas, view);
      player.onShown();
      if (fake.isTransient) {
        canvas.getContext("2d")!.clearRect(0, 0, ...view.size);
      }
      fake.active -= 1;
      return statsOf(view);
    },
    settle: () => Promise.resolve(),
    fetched: () => [
      [10, 41],
      [60, 65],
    ],
    pixels: () => Promise.resolve({ size: [1, 1], rgba: new Float32Array(4) }),
    onProblem: () => undefined,
    onShown: () => undefined,
    close: () => {
      fake.closed += 1;
    },
  };
  fake.player = player;
  return { player, marks: ["probes", "nodes", "holes", "units", "keyframes", "fetched"], isFixed: false };
}

Object.assign(globalThis, { fake });
const kind = location.search === "?quilt" ? "quilt" : "lfold";
const file: FilmFile = { kind, url: `${location.origin}/film.lfold`, name: NAME, bytes: FILM.fileBytes };
void new Page(file, openFake).load();
