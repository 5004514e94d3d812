// The player of containers in headless Chromium, beside the program: pictures, bytes, servers that fail, files that are hostile.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, describe, test } from "node:test";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "../src/format/memory.ts";
import type { PlayerStats, Problem, RendererChoice } from "../src/player/types.ts";
import { bundle, type Call, pageFiles, withFunctions, withoutBrowser } from "./browser.ts";
import { filmServer, type FilmServer } from "./film_server.ts";
import { bytesOf, capture, codesOf, type Films, moving, psnr, readFor } from "./films.ts";
import { atLength, rendered, type Shot, WITH_MATERIALS, withMattes, withoutProgram } from "./films.ts";
import { chance, spoiled, vectors } from "./vectors.ts";

const skip = withoutBrowser || withoutProgram;
const PAGE = "tests/player.page.ts";
/** What a picture of the device must equal that of the processor to. */
const MIN_DB = 50;
/** Pixels along a side of the images. */
const FACE = 64;
const SIZE: [number, number] = [64, 48];

function shot(yaw: number, more: Partial<Shot> = {}): Shot {
  const pose = { eye: [0.05, 1.55, 0.05] as [number, number, number], yaw, pitch: -0.1 };
  return { pose, frame: 0, size: SIZE, fovDeg: 90, steps: 256, ...more };
}

/** Five poses, and all frames. */
const SHOTS: Shot[] = [
  shot(0),
  shot(1.3, { frame: 1 }),
  shot(2.6, { frame: 2, pose: { eye: [-0.2, 1.5, 0.1], yaw: 2.6, pitch: 0.3 } }),
  shot(-2, { pose: { eye: [0.25, 1.6, 0], yaw: -2, pitch: -0.4 } }),
  shot(-0.7, { frame: 1, fovDeg: 60 }),
];

async function picture(call: Call): Promise<Float32Array> {
  const { words } = await call<{ words: number[] }>("picture");
  return new Float32Array(Uint32Array.from(words).buffer);
}

describe("The player", { skip }, () => {
  let films: Films;
  let files: Map<string, Uint8Array | string>;

  before(() => {
    films = capture("interior", FACE);
    films.encode("film.lfold", "--clip");
    files = pageFiles(
      PAGE,
      new Map<string, Uint8Array | string>([
        ["/worker.js", bundle("src/worker.ts")],
        ["/lightfold.wasm", readFileSync("src/decoder/lightfold.wasm")],
        ["/cpu_worker.js", bundle("src/cpu/worker.ts")],
      ]),
    );
  });
  after(() => films.remove());

  const inPage = async <T>(
    film: string,
    use: (call: Call, server: FilmServer) => Promise<T>,
    renderer: RendererChoice = "gpu",
  ): Promise<T> => {
    const server = filmServer(bytesOf(film), files);
    return withFunctions(server.answer, async (call) => {
      await call("open", ["/film.lfold", renderer]);
      return use(call, server);
    });
  };

  test("shows what lightfold render shows", async () => {
    await inPage(films.path("film.lfold"), async (call) => {
      for (const one of SHOTS) {
        await call("settle", one);
        const found = psnr(codesOf(await picture(call)), rendered(films.path("film.lfold"), one));
        assert.ok(found >= MIN_DB, `${found} dB at yaw ${one.pose.yaw}`);
      }
      assert.deepEqual(await call("problems"), []);
    });
  });

  for (const [name, ...options] of [
    ["cells of the device", "--clip", "--color-codec", "cells", "--depth-codec", "quadtree"],
    ["blocks of the device", "--clip", "--color-block", "bc7", "--depth-codec", "aabb"],
    ["half floats", "--hdr"],
  ]) {
    test(`shows the same of ${name}`, { skip: atLength }, async () => {
      const film = films.encode("other.lfold", ...options);
      await inPage(film, async (call) => {
        for (const one of SHOTS.slice(1, 3)) {
          await call("settle", one);
          const found = psnr(codesOf(await picture(call)), rendered(film, one));
          assert.ok(found >= MIN_DB, `${found} dB at yaw ${one.pose.yaw}`);
        }
      });
    });
  }

  test("fetches what is in sight, once, and nothing in a pause", async () => {
    const film = films.path("film.lfold");
    await inPage(film, async (call, server) => {
      const still = await call<PlayerStats>("settle", SHOTS[0]);
      const { bytes_read: bytesRead, cells_decoded: cells } = readFor(film, SHOTS[0]);
      assert.ok(
        still.bytesFetched <= 1.1 * bytesRead,
        `${still.bytesFetched} bytes, lightfold render reads ${bytesRead}`,
      );
      assert.equal(still.counters["cells_decoded"], cells);
      const requests = server.ranges.length;
      for (let at = 0; at < 5; at += 1) {
        await call("draw", SHOTS[0]);
      }
      assert.equal(server.ranges.length, requests);
      for (const one of [...SHOTS, ...SHOTS]) {
        await call("settle", one);
      }
      const all = server.ranges.map(String);
      assert.equal(new Set(all).size, all.length);
      assert.equal((await call<PlayerStats>("draw", SHOTS[0])).chunksRefetched, 0);
    });
  });

  test("has the next frames ready while the film plays, and completes them", async () => {
    await inPage(films.path("film.lfold"), async (call) => {
      await call("settle", { ...SHOTS[0], playing: true });
      for (let at = 0; at < 30; at += 1) {
        await call("draw", { ...SHOTS[0], playing: true });
      }
      for (const frame of [1, 2]) {
        const { unitsMissing, shownFrame } = await call<PlayerStats>("draw", { ...SHOTS[0], frame, playing: true });
        assert.deepEqual([unitsMissing, shownFrame], [0, frame]);
      }
      const played = psnr(codesOf(await picture(call)), rendered(films.path("film.lfold"), { ...SHOTS[0], frame: 2 }));
      assert.ok(played >= MIN_DB, `${played} dB`);
    });
  });

  test("goes from one whole frame to another while the film plays", { skip: atLength }, async () => {
    const film = films.encodeWith("squares.lfold", withMattes(FACE), "--clip");
    const [first, second] = [0, 1].map((frame) => rendered(film, { ...SHOTS[0], frame, steps: 128 }));
    assert.ok(psnr(first, second) < 30);
    for (const renderer of ["gpu", "cpu"] as const) {
      await inPage(
        film,
        async (call) => {
          const view = { ...SHOTS[0], steps: 128 };
          await call("settle", view);
          let [stats, seen] = [await call<PlayerStats>("draw", view), 0];
          for (let at = 0; at < 200 && stats.shownFrame < 1; at += 1) {
            stats = await call<PlayerStats>("draw", { ...view, frame: 1, playing: true });
            const codes = codesOf(await picture(call));
            const found = [psnr(codes, first), psnr(codes, second)];
            assert.ok(Math.max(...found) >= MIN_DB, `${found.join()} dB`);
            seen += Number(found[0] > found[1]);
          }
          assert.equal(stats.shownFrame, 1);
          assert.ok(psnr(codesOf(await picture(call)), second) >= MIN_DB);
          assert.ok(seen > 0, "no picture was drawn meanwhile");
        },
        renderer,
      );
    }
  });

  test("shows probes that move as they stand in each frame", async () => {
    const film = films.encodeWith("moving.lfold", moving, "--clip");
    await inPage(film, async (call, server) => {
      const [first, last] = [SHOTS[0], { ...SHOTS[0], frame: 2 }];
      for (const one of [first, last, first]) {
        await call("settle", one);
        const found = psnr(codesOf(await picture(call)), rendered(film, one));
        assert.ok(found >= MIN_DB, `${found} dB in frame ${one.frame}`);
      }
      // Away and back, while nothing more arrives.
      server.fault = () => "held";
      await call("draw", { ...last, frame: 1 });
      await call("settle", first);
      const found = psnr(codesOf(await picture(call)), rendered(film, first));
      assert.ok(found >= MIN_DB, `${found} dB after another frame`);
    });
  });

  for (const options of [["--clip"], ["--hdr"]]) {
    test(`shows alpha of ${options[0]}`, { skip: options[0] === "--hdr" && atLength }, async () => {
      const film = films.encodeWith("alpha.lfold", withMattes(FACE), ...options);
      await inPage(film, async (call) => {
        for (const one of SHOTS.slice(0, 3)) {
          await call("settle", one);
          const found = psnr(codesOf(await picture(call)), rendered(film, one));
          assert.ok(found >= MIN_DB, `${found} dB in frame ${one.frame}`);
        }
        assert.deepEqual(await call("problems"), []);
      });
    });
  }

  test("draws on the processor what lightfold render shows", async () => {
    for (const [name, change] of [
      ["film.lfold", undefined],
      ["moving.lfold", moving],
      ["alpha.lfold", withMattes(FACE)],
    ] as const) {
      const film = change === undefined ? films.path(name) : films.encodeWith(name, change, "--clip");
      // A device that is a program is slower.
      await inPage(
        film,
        async (call) => {
          assert.equal(await call("renderer"), "cpu");
          for (const pose of [SHOTS[0], SHOTS[2], SHOTS[4]]) {
            const one = { ...pose, steps: 128 };
            const { counters, unitsMissing } = await call<PlayerStats>("settle", one);
            assert.deepEqual([counters["primary_rays"], unitsMissing], [SIZE[0] * SIZE[1], 0]);
            const found = psnr(codesOf(await picture(call)), rendered(film, one));
            assert.ok(found >= MIN_DB, `${found} dB of ${name} at yaw ${pose.pose.yaw}`);
          }
          for (const stereo of ["side-by-side", "anaglyph"]) {
            await call("settle", { ...SHOTS[0], stereo, overlays: ["holes"] });
          }
          assert.deepEqual(await call("problems"), []);
        },
        "auto",
      );
    }
  });

  test("follows secondary rays on the processor", { skip: atLength }, async () => {
    const mirrors = capture("mirrors", FACE, ...WITH_MATERIALS);
    try {
      const film = mirrors.encode("film.lfold", "--clip");
      await inPage(
        film,
        async (call) => {
          const one = { ...SHOTS[0], steps: 128 };
          const { counters } = await call<PlayerStats>("settle", one);
          assert.ok(counters["secondary_rays"] > 0);
          const found = psnr(codesOf(await picture(call)), rendered(film, one));
          assert.ok(found >= MIN_DB, `${found} dB`);
        },
        "cpu",
      );
    } finally {
      mirrors.remove();
    }
  });

  test("does not wait for a slow server", async () => {
    await inPage(films.path("film.lfold"), async (call, server) => {
      server.fault = () => "held";
      for (const one of SHOTS) {
        assert.ok((await call<PlayerStats>("draw", one)).unitsMissing > 0);
        assert.deepEqual(await call("fetched"), []);
      }
      server.fault = () => "none";
      server.release();
      await call("settle", SHOTS[0]);
      const last = await call<PlayerStats>("draw", SHOTS[0]);
      assert.deepEqual([last.unitsMissing, last.shownFrame], [0, 0]);
      assert.equal((await call<[number, number][]>("fetched"))[0]?.[0], 0);
    });
  });

  test("shows the same through a server that fails", async () => {
    let whole: Float32Array | undefined;
    await inPage(films.path("film.lfold"), async (call) => {
      await call("settle", SHOTS[0]);
      whole = await picture(call);
    });
    await inPage(films.path("film.lfold"), async (call, server) => {
      const random = chance(7);
      server.fault = () => (["error", "cut", "short", "none", "none"] as const)[random(5)];
      await call("settle", SHOTS[0]);
      assert.deepEqual(await picture(call), whole);
      assert.ok((await call<Problem[]>("problems")).every(({ fatal }) => !fatal));
    });
  });

  test("tells of a file that changes, and mixes nothing", async () => {
    await inPage(films.path("film.lfold"), async (call, server) => {
      await call("settle", SHOTS[0]);
      server.replace(bytesOf(films.encode("later.lfold", "--clip", "--psnr", "36")));
      await call("draw", SHOTS[2]);
      for (let at = 0; at < 50 && (await call<Problem[]>("problems")).length === 0; at += 1) {
        await new Promise((resolve) => setTimeout(resolve, 20));
      }
      assert.deepEqual(await call("problems"), [
        { fatal: true, message: "The file on the server has changed since it was opened" },
      ]);
      const fetched = (await call<PlayerStats>("draw", SHOTS[2])).bytesFetched;
      await call("draw", SHOTS[3]);
      assert.equal((await call<PlayerStats>("draw", SHOTS[3])).bytesFetched, fetched);
    });
  });

  test("presents the same on device and processor: overlays, two eyes, tone maps", { skip: atLength }, async () => {
    const looks: Record<string, unknown>[] = [
      ...["probes", "nodes", "holes", "units", "keyframes", "fetched"].map((overlay) => ({ overlays: [overlay] })),
      ...["side-by-side", "anaglyph"].map((stereo) => ({ stereo, overlays: ["units"] })),
      ...["reinhard", "filmic"].map((toneMap) => ({ toneMap, exposureEv: 1 })),
    ];
    const show = (renderer: RendererChoice): Promise<number[][]> =>
      inPage(
        films.path("film.lfold"),
        async (call) => {
          const all: number[][] = [];
          for (const look of looks) {
            const view = { ...SHOTS[0], steps: 128, ...look };
            await call("settle", view);
            // What was fetched is no longer new, and maps of nodes are here.
            await new Promise((resolve) => setTimeout(resolve, 1200));
            for (let left = 100; left > 0; left -= 1) {
              left = (await call<PlayerStats>("draw", view)).overlayMissing > 0 ? left : 1;
            }
            all.push(await call<number[]>("shown"));
          }
          assert.deepEqual(await call("problems"), []);
          return all;
        },
        renderer,
      );
    const [device, processor] = [await show("gpu"), await show("cpu")];
    looks.forEach((look, at) => {
      const found = psnr(Uint8Array.from(device[at]), Uint8Array.from(processor[at]));
      assert.ok(found >= 40, `${found} dB with ${JSON.stringify(look)}`);
      const same = looks.findIndex((_, other) => device[other].join() === device[at].join());
      assert.ok(same === at || "fetched" === (look["overlays"] as string[])?.[0], JSON.stringify(look));
    });
  });

  test("shows overlays of films of light the same on device and processor", { skip: atLength }, async () => {
    const film = films.encode("light.lfold", "--hdr");
    const view = { ...SHOTS[0], steps: 128, overlays: ["probes"] };
    const show = (renderer: RendererChoice): Promise<number[]> =>
      inPage(
        film,
        async (call) => {
          await call("settle", view);
          return call<number[]>("shown");
        },
        renderer,
      );
    const found = psnr(Uint8Array.from(await show("gpu")), Uint8Array.from(await show("cpu")));
    assert.ok(found >= 40, `${found} dB`);
  });

  for (const codec of ["quadtree", "aabb", "predictive"]) {
    test(
      `shows how depth is coded by ${codec}, and asks for that only while it is shown`,
      { skip: codec !== "quadtree" && atLength },
      async () => {
        const film = films.encode("codings.lfold", "--clip", "--depth-codec", codec);
        await inPage(film, async (call) => {
          await call("settle", SHOTS[0]);
          const plain = await call<number[]>("shown");
          await call("settle", { ...SHOTS[0], frame: 1 });
          assert.equal(await call("codingJobs"), 0);
          const marked = { ...SHOTS[0], overlays: ["nodes"] };
          const draw = () => call<PlayerStats>("draw", marked);
          await call("settle", marked);
          let { overlayMissing } = await draw();
          for (let at = 0; at < 100 && overlayMissing > 0; at += 1) {
            ({ overlayMissing } = await draw());
          }
          assert.equal(overlayMissing, 0);
          const jobs = await call<number>("codingJobs");
          assert.ok(jobs > 0);
          await draw();
          const changed = (await call<number[]>("shown")).filter((code, at) => Math.abs(code - plain[at]) > 8).length;
          assert.ok(changed > plain.length / 4, `${changed} of ${plain.length}`);
          await call("settle", SHOTS[0]);
          await call("settle", { ...SHOTS[0], frame: 1 });
          // Nothing is asked for twice, nor where the overlay is off.
          assert.equal(await call("codingJobs"), jobs);
          await call("settle", SHOTS[0]);
          assert.deepEqual(await call("shown"), plain);
          assert.deepEqual(await call("problems"), []);
        });
      },
    );
  }

  test("ends hostile files in a sentence", async () => {
    const random = chance(11);
    const film = bytesOf(films.path("film.lfold"));
    const all = [
      ...[...vectors("invalid"), ...vectors("limits")].map(({ name, bytes }) => ({ name, bytes })),
      ...Array.from({ length: 40 }, (_, at) => ({ name: `change ${at}`, bytes: spoiled(film, random) })),
    ];
    // All are of vectors.test.ts; here are some that open, and a few that do not.
    const opens = await Promise.all(
      all.map(({ bytes }) =>
        Container.open(new MemorySource(bytes)).then(
          () => true,
          () => false,
        ),
      ),
    );
    const hostile = all.filter((_, at) => at % (opens[at] ? 6 : 40) === 0);
    const served = new Map([...files, ...hostile.map(({ bytes }, at) => [`/${at}.lfold`, bytes] as const)]);
    await withFunctions(filmServer(film, served).answer, async (call) => {
      for (const [at, { name }] of hostile.entries()) {
        const renderer = at % 2 === 0 ? "gpu" : "cpu";
        const view = { ...SHOTS[1], overlays: ["nodes"] };
        const said = await call<string[]>("survive", [`/${at}.lfold`, renderer, view]);
        assert.ok(said.length > 0 || name.startsWith("change"), name);
        said.forEach((sentence) => assert.doesNotMatch(sentence, /undefined|TypeError|RangeError|\bat .*:\d+/u, name));
      }
      assert.equal(await call("workers"), 0);
      // The page itself is well.
      await call("open", ["/film.lfold", "gpu"]);
      await call("settle", SHOTS[0]);
      assert.deepEqual(await call("problems"), []);
    });
  });
});
