// Scenes of `lightfold simplify`: a player of .glb files, in a bundle of its own with three.js.

import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { FormatError, UnsupportedError } from "../format/types.ts";
import type { ByteSource, Vec3 } from "../format/types.ts";
import type { Film, Player, PlayerStats, Pose } from "../player/types.ts";
import { Drawing } from "./drawing.ts";
import type { Overdraw } from "./drawing.ts";
import { parseSceneHead } from "./glb_file.ts";
import type { SceneHead } from "./glb_file.ts";
import { enterHeadset, hasHeadset } from "./headset.ts";

/** Bytes of a file, at most. */
const MAX_BYTES = 2 ** 29;

/** A still scene. Frames do not change its pictures. */
export interface ScenePlayer extends Player {
  /** Shows the number of triangles over each pixel in place of the picture. */
  showOverdraw(isOn: boolean): void;
  hasHeadset(): Promise<boolean>;
  /** Shows the scene in a headset from a pose on; resolves once it is shown. */
  enterHeadset(pose: Pose): Promise<void>;
}

function filmOf(name: string, fileBytes: number, head: SceneHead): Film {
  const { least, greatest } = head.region;
  const middle = least.map((value, axis) => (value + greatest[axis]) / 2) as Vec3;
  const texture = { kind: "texture", codec: `PNG ${head.textureSize.join("x")}`, count: 1, bytes: head.textureBytes };
  return {
    name,
    fileBytes,
    framesPerSecond: 1,
    firstFrame: head.frame,
    frameCount: 1,
    headBox: head.region,
    probes: [],
    start: { eye: middle, yaw: 0, pitch: 0 },
    streams: [
      texture,
      { kind: "triangles", codec: "glTF", count: head.triangles, bytes: fileBytes - head.textureBytes },
    ],
  };
}

/** Opens a scene of simplify to be drawn into a canvas: a FormatError, an UnsupportedError, or the error of `source`. */
export async function openScene(source: ByteSource, canvas: HTMLCanvasElement, name: string): Promise<ScenePlayer> {
  if (source.byteCount > MAX_BYTES) {
    throw new UnsupportedError(`The scene has ${source.byteCount} bytes; the player reads up to ${MAX_BYTES}.`);
  }
  const start = performance.now();
  const bytes = await source.read(0, source.byteCount);
  const head = parseSceneHead(bytes);
  const loaded = await new GLTFLoader().parseAsync(bytes.slice().buffer, "").catch((error: unknown) => {
    throw new FormatError(`The scene cannot be read: ${error instanceof Error ? error.message : String(error)}.`);
  });
  const drawing = new Drawing(canvas, loaded.scene);
  const decodeMs = performance.now() - start;
  let isOverdraw = false;
  let isInHeadset = false;
  const statsOf = (marchMs: number, overdraw: Overdraw | undefined): PlayerStats => ({
    counters: {
      triangles: head.triangles,
      ...(overdraw && { overdraw_mean: overdraw.mean, overdraw_peak: overdraw.peak }),
    },
    decodeMs,
    marchMs,
    fetchRate: 0,
    bytesFetched: bytes.length,
    requests: 1,
    chunksFetched: 1,
    chunksRefetched: 0,
    cacheBytes: bytes.length + 4 * head.textureSize[0] * head.textureSize[1],
    unitsMissing: 0,
    unitsBroken: 0,
    overlayMissing: 0,
    shownFrame: head.frame,
  });
  const player: ScenePlayer = {
    film: filmOf(name, source.byteCount, head),
    async draw(view) {
      const before = performance.now();
      if (!isInHeadset) {
        await drawing.draw(view, isOverdraw, () => player.onShown());
      }
      const marchMs = performance.now() - before;
      return statsOf(marchMs, isOverdraw && !isInHeadset ? drawing.overdraw() : undefined);
    },
    settle: () => Promise.resolve(),
    fetched: () => [[head.frame, head.frame]],
    pixels: () => Promise.resolve(drawing.pixels()),
    onProblem: () => undefined,
    onShown: () => undefined,
    close: () => drawing.close(),
    showOverdraw: (isOn) => (isOverdraw = isOn),
    hasHeadset,
    async enterHeadset(pose) {
      isInHeadset = true;
      await enterHeadset(drawing, pose, () => (isInHeadset = false)).catch((error: unknown) => {
        isInHeadset = false;
        throw error;
      });
    },
  };
  canvas.addEventListener("webglcontextlost", () => {
    if (!drawing.isClosed) {
      player.onProblem({ fatal: true, message: "The graphics device was lost." });
    }
  });
  return player;
}
