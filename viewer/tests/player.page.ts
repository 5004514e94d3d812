// The player of containers, for player.test.ts.

import { HttpSource } from "../src/format/http.ts";
import { openPlayer } from "../src/player/player.ts";
import type { Player, PlayerStats, Problem, View } from "../src/player/types.ts";

let player: Player;
let problems: Problem[] = [];

function viewOf(view: Partial<View>): View {
  const plain: View = {
    pose: player.film.start,
    frame: player.film.firstFrame,
    size: [64, 64],
    fovDeg: 90,
    stereo: "mono",
    eyeDistance: 0.063,
    exposureEv: 0,
    toneMap: "none",
    overlays: new Set(),
    steps: 1024,
  };
  return { ...plain, ...view };
}

/** The last picture as 32-bit words of floats in base 64. */
async function picture(): Promise<{ size: [number, number]; words: number[] }> {
  const { size, rgba } = await player.pixels();
  return { size, words: [...new Uint32Array(rgba.buffer)] };
}

Object.assign(globalThis, {
  functions: {
    open: async (url: string) => {
      problems = [];
      const canvas = document.createElement("canvas");
      document.body.replaceChildren(canvas);
      player = await openPlayer(await HttpSource.open(url), canvas);
      player.onProblem = (problem) => problems.push(problem);
      return player.film;
    },
    draw: (view: Partial<View>): Promise<PlayerStats> => player.draw(viewOf(view)),
    settle: async (view: Partial<View>): Promise<PlayerStats> => {
      await player.settle(viewOf(view));
      return player.draw(viewOf(view));
    },
    picture,
    fetched: () => player.fetched(),
    problems: () => problems,
    close: () => player.close(),
  },
});
