// The player of containers, for player.test.ts.

import { HttpSource } from "../src/format/http.ts";
import { openPlayer } from "../src/player/player.ts";
import type { Job } from "../src/player/jobs.ts";
import type { Film, Overlay, Player, PlayerStats, Problem, RendererChoice, View } from "../src/player/types.ts";

let player: Player;
let problems: Problem[] = [];
/** The canvas as it was shown last. */
let shown: ImageData | undefined;
/** Jobs of coding maps that workers were asked for. */
let codingJobs = 0;

/** Workers that were started and not ended. */
let workers = 0;

globalThis.Worker = class extends Worker {
  constructor(...options: ConstructorParameters<typeof Worker>) {
    super(...options);
    workers += 1;
  }

  override terminate(): void {
    workers -= 1;
    super.terminate();
  }
};

const { postMessage } = Worker.prototype;
Worker.prototype.postMessage = function (this: Worker, message: Job, ...others: unknown[]): void {
  codingJobs += Number(message.asksCodings ?? false);
  Reflect.apply(postMessage, this, [message, ...others]);
};

function copyOf(canvas: HTMLCanvasElement): ImageData {
  const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d")!;
  context.drawImage(canvas, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

/** A view in the form in which it comes from the test. */
type Asked = Partial<Omit<View, "overlays">> & { overlays?: string[] };

function viewOf({ overlays, ...view }: Asked): View {
  const plain: View = {
    pose: player.film.start,
    frame: player.film.firstFrame,
    playing: false,
    size: [64, 64],
    fovDeg: 90,
    stereo: "mono",
    eyeDistance: 0.063,
    exposureEv: 0,
    toneMap: "none",
    overlays: new Set(),
    steps: 1024,
  };
  return { ...plain, ...view, overlays: new Set(overlays as Overlay[]) };
}

/** The last picture as 32-bit words of floats. */
async function picture(): Promise<{ size: [number, number]; words: number[] }> {
  const { size, rgba } = await player.pixels();
  return { size, words: [...new Uint32Array(rgba.buffer)] };
}

async function open([url, renderer]: [string, RendererChoice]): Promise<Film> {
  problems = [];
  const canvas = document.createElement("canvas");
  document.body.replaceChildren(canvas);
  player = await openPlayer(await HttpSource.open(url), canvas, renderer);
  player.onProblem = (problem) => problems.push(problem);
  player.onShown = () => (shown = copyOf(canvas));
  return player.film;
}

Object.assign(globalThis, {
  functions: {
    open,
    /** Opens a film that may be hostile, draws it, and answers what was said. */
    survive: async ([url, renderer, view]: [string, RendererChoice, Asked]): Promise<string[]> => {
      let opened: Player | undefined;
      try {
        await open([url, renderer]);
        opened = player;
        const failed = new Promise((resolve) => (player.onProblem = (problem) => resolve(problems.push(problem))));
        await Promise.race([player.settle(viewOf({ ...view, frame: player.film.firstFrame })), failed]);
        await player.draw(viewOf({ ...view, frame: player.film.firstFrame }));
      } catch (error) {
        return [error instanceof Error ? `${error.name}: ${error.message}` : String(error)];
      } finally {
        opened?.close();
      }
      return problems.map(({ message }) => message);
    },
    draw: (view: Asked): Promise<PlayerStats> => player.draw(viewOf(view)),
    settle: async (view: Asked): Promise<PlayerStats> => {
      await player.settle(viewOf(view));
      return player.draw(viewOf(view));
    },
    picture,
    /** Red, green, blue and alpha of the canvas. */
    shown: () => [...shown!.data],
    codingJobs: () => codingJobs,
    fetched: () => player.fetched(),
    problems: () => problems,
    renderer: () => player.renderer,
    workers: () => workers,
    close: () => player.close(),
  },
});
