// The page's own thinking: motion, links, commands, time, drawing, and the files that it opens.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { test } from "node:test";
import { bytesOfBase64 } from "../src/assets.ts";
import type { Vec3 } from "../src/format/types.ts";
import { parseSceneHead } from "../src/glb/glb_file.ts";
import type { PlayerStats } from "../src/player/types.ts";
import { fitted, pngSize, tileOf } from "../src/quilt.ts";
import { clampEye, marginOf, moveEye, moveWithin } from "../src/ui/bounds.ts";
import { FilmClock } from "../src/ui/clock.ts";
import { renderCommand, shellWord } from "../src/ui/command.ts";
import { byteText, sentence } from "../src/ui/dom.ts";
import { fetchFilmFile, FilmFileError, parseFilmFile } from "../src/ui/film_file.ts";
import { actionOf, isForPage, motionOf, motionOfPad } from "../src/ui/keys.ts";
import type { KeyPress } from "../src/ui/keys.ts";
import { formatLink, parseLink } from "../src/ui/link.ts";
import { DrawLoop, Resolution } from "../src/ui/loop.ts";
import { orbitEye, orbitRadius } from "../src/ui/orbit.ts";
import { forwardOf, MAX_PITCH, poseOf, rightOf, stepOf, turned } from "../src/ui/pose.ts";
import { screenshotName } from "../src/ui/screenshot.ts";
import { DEFAULTS } from "../src/ui/settings.ts";
import type { Settings } from "../src/ui/settings.ts";
import { fetchedSpans, timeCode } from "../src/ui/timeline.ts";
import { png, sceneFile } from "./ui_scene.ts";

function near(actual: number, expected: number, tolerance = 1e-9): void {
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);
}

test("a coordinate is free in the box, slowed beyond it, and never at the end of the margin", () => {
  const walls: [number, number] = [-1, 2];
  near(moveWithin(0, 1.5, walls, 0.2), 1.5);
  near(moveWithin(0, -0.5, walls, 0.2), -0.5);
  // The first part of a step in the margin is nearly whole, later ones fade.
  near(moveWithin(2, 0.001, walls, 0.2), 2.001, 1e-5);
  const [once, twice] = [moveWithin(2, 0.2, walls, 0.2), moveWithin(2, 0.4, walls, 0.2)];
  assert.ok(once - 2 < 0.2 && once - 2 > twice - once);
  near(moveWithin(once, 0.2, walls, 0.2), twice);
  near(moveWithin(1.9, 0.5, walls, 0.2), moveWithin(moveWithin(1.9, 0.25, walls, 0.2), 0.25, walls, 0.2));
  for (const step of [10, 1e6, Number.MAX_VALUE]) {
    assert.ok(moveWithin(0, step, walls, 0.2) <= 2.2 && moveWithin(0, -step, walls, 0.2) >= -1.2);
  }
  // The way back is not slowed.
  near(moveWithin(2.15, -0.5, walls, 0.2), 1.65);
});

test("an eye moves by axis, and a flat box has a margin", () => {
  const box = { least: [0, 1, 0] as Vec3, greatest: [4, 1, 2] as Vec3 };
  near(marginOf(box), 0.4);
  near(marginOf({ least: [0, 0, 0], greatest: [0, 0, 0] }), 0.1);
  const eye = moveEye([2, 1, 1], [1, 5, -9], box);
  near(eye[0], 3);
  assert.ok(eye[1] > 1.3 && eye[1] <= 1.4 && eye[2] < -0.3 && eye[2] >= -0.4);
  assert.deepEqual(clampEye([9, 1, -9], box), [4.4, 1, -0.4]);
});

test("directions and turns of poses", () => {
  const pose = { eye: [0, 0, 0] as Vec3, yaw: 0, pitch: 0 };
  forwardOf(pose).forEach((value, axis) => near(value, [0, 0, -1][axis]!));
  const left = turned(pose, Math.PI / 2, 0);
  forwardOf(left).forEach((value, axis) => near(value, [-1, 0, 0][axis]!));
  rightOf(left).forEach((value, axis) => near(value, [0, 0, -1][axis]!));
  stepOf(left, [1, 2, 3]).forEach((value, axis) => near(value, [-3, 2, -1][axis]!));
  assert.equal(turned(pose, 0, 9).pitch, MAX_PITCH);
  near(Math.abs(turned(pose, 7 * Math.PI, 0).yaw), Math.PI, 1e-6);
  near(turned(pose, 6.5 * Math.PI, 0).yaw, Math.PI / 2, 1e-6);
});

test("a link gives back what it was made of", () => {
  const settings: Settings = {
    exposureEv: -1.25,
    toneMap: "filmic",
    fovDeg: 75,
    stereo: "anaglyph",
    eyeDistance: 0.07,
    steps: 512,
    scale: 0.5,
    speed: 1.5,
    isLooped: false,
    renderer: "cpu" as const,
    marks: new Set(["holes", "fetched"]),
  };
  const pose = { eye: [0.125, 1.5, -3] as Vec3, yaw: (-120 * Math.PI) / 180, pitch: (15.5 * Math.PI) / 180 };
  const hash = formatLink(pose, 42, settings);
  const link = parseLink(hash);
  assert.deepEqual(link.eye, pose.eye);
  near(link.look![0], pose.yaw);
  near(link.look![1], pose.pitch);
  assert.equal(link.frame, 42);
  assert.deepEqual(link.settings, settings);
  const plain = formatLink({ eye: [0, 1.5, 0], yaw: 0, pitch: 0 }, 0, DEFAULTS);
  assert.equal(plain, "#eye=0,1.5,0&look=0,0&frame=0");
  assert.equal(formatLink({ eye: [-1e-9, 0, 0], yaw: -1e-9, pitch: 0 }, 0, DEFAULTS), "#eye=0,0,0&look=0,0&frame=0");
});

test("what is wrong in a link is left out or brought into range", () => {
  const wrong = [
    "#eye=1,2&look=1&frame=-1",
    "#eye=1,2,3,4&look=1,2,3&frame=1.5",
    "#eye=NaN,0,0&look=Infinity,0&frame=1e99",
    "#eye=1e30,0,0&look=0x10,0&frame=0b1",
    "#eye=,,&look=,&frame=",
    "#eye=__proto__&constructor=1&frame=%00",
    `#eye=${"1".repeat(1900)},0,0`,
    `#eye=0,0,0&frame=1&${"x".repeat(2000)}`,
    "#%E0%A4%A&fov=abc&tone=__proto__&stereo=toString",
    "#<script>alert(1)</script>",
  ];
  for (const hash of wrong) {
    assert.deepEqual(parseLink(hash), { settings: {} }, hash);
  }
  const far = parseLink("#look=720,500&fov=1e9&steps=0.1&scale=-4&eyes=9&ev=-99&speed=100&show=holes,evil&loop=0");
  near(far.look![0], 0);
  assert.equal(far.look![1], MAX_PITCH);
  const { marks, ...others } = far.settings;
  const expected = {
    fovDeg: 120,
    steps: 32,
    scale: 0.125,
    eyeDistance: 0.5,
    exposureEv: -10,
    speed: 2,
    isLooped: false,
  };
  assert.deepEqual(others, expected);
  assert.deepEqual([...marks!], ["holes"]);
});

test("names of files are one word of a shell", () => {
  const names = [
    "film.lfold",
    "a b.lfold",
    "it's.lfold",
    '$(id) `id` \\ "x" *.lfold',
    "-o",
    "--help",
    "''",
    "été 漢.lfold",
    "!x",
  ];
  for (const name of names) {
    const said = execFileSync("/bin/sh", ["-c", `printf %s ${shellWord(name)}`], { encoding: "utf8" });
    assert.equal(said, name.startsWith("-") ? `./${name}` : name);
  }
  assert.equal(shellWord("film.lfold"), "'film.lfold'");
  for (const name of ["line\nbreak 'x' \\n.lfold", "\u001b[201~; rm x\r", "tab\t\u0085\u007f"]) {
    const word = shellWord(name);
    // Nothing of it can end a paste.
    assert.ok(!/[\u0000-\u001f\u007f-\u009f]/.test(word), word);
    assert.equal(execFileSync("/bin/bash", ["-c", `printf %s ${word}`], { encoding: "utf8" }), name);
  }
});

test("a view as a command has the options of the man page", () => {
  const pose = { eye: [0, 1.5, -0.25] as Vec3, yaw: Math.PI / 2, pitch: 0 };
  const shot = { pose, fovDeg: 70, size: [1280, 720] as [number, number], eyeDistance: 0.063, frame: 12 };
  const mono = renderCommand("film.lfold", { ...shot, stereo: "mono" });
  const expected = "--eye 0,1.5,-0.25 --look-at -1,1.5,-0.25 --fov 70 --size 1280x720 --frames 12 -o view.png";
  assert.equal(mono, `lightfold render 'film.lfold' ${expected}`);
  const both = renderCommand("film.lfold", { ...shot, stereo: "side-by-side" });
  assert.match(both, / --size 640x720 --stereo side-by-side --eye-distance 0.063 /);
  assert.match(renderCommand("it's", { ...shot, stereo: "mono" }), /^lightfold render 'it'\\''s' --eye /);
  const manual = readFileSync("../man/lightfold-render.1", "utf8").replaceAll("\\-", "-");
  for (const [, option] of both.matchAll(/ (--?[a-z-]+)/g)) {
    assert.ok(manual.includes(`\\fB${option}\\fR`), option);
  }
});

test("spans of fetched frames and time codes", () => {
  // A track of 100 pixels between the middles of the thumb at both ends, a frame each pixel.
  assert.deepEqual(fetchedSpans([[0, 100]], [0, 101], 114), [[7, 100]]);
  assert.deepEqual(fetchedSpans([[20, 29]], [10, 101], 114), [[16.5, 10]]);
  assert.deepEqual(
    fetchedSpans(
      [
        [0, 9],
        [111, 400],
      ],
      [10, 101],
      114,
    ),
    [],
  );
  assert.deepEqual(
    fetchedSpans(
      [
        [-5, 10],
        [110, 999],
      ],
      [10, 101],
      114,
    ),
    [
      [7, 0.5],
      [106.5, 0.5],
    ],
  );
  assert.deepEqual(fetchedSpans([[3, 3]], [3, 1], 114), [[7, 100]]);
  assert.equal(timeCode(0, 24), "00:00:00:00");
  assert.equal(timeCode(24 * 61 + 5, 24), "00:01:01:05");
  assert.equal(timeCode(30, 29.97), "00:00:01:00");
});

const BASE = "https://example.org/films/film.json";

function film(change: Record<string, unknown>): string {
  return JSON.stringify({ kind: "lfold", url: "film.lfold", name: "film.lfold", bytes: 10, ...change });
}

test("film.json names a film of the page's own server", () => {
  assert.deepEqual(parseFilmFile(film({}), BASE), {
    kind: "lfold",
    url: "https://example.org/films/film.lfold",
    name: "film.lfold",
    bytes: 10,
  });
  assert.equal(parseFilmFile(film({ url: "../a%20b?x=1#y" }), BASE).url, "https://example.org/a%20b?x=1");
  const quilt = { columns: 8, rows: 6, aspect: 0.75 };
  assert.deepEqual(parseFilmFile(film({ kind: "quilt", quilt }), BASE).quilt, quilt);
  assert.equal(parseFilmFile(film({ quilt }), BASE).quilt, undefined);
  const start = { eye: [1, 2, 3], look_at: [0, 2, 3], fov_y_deg: 50 };
  const started = parseFilmFile(film({ start, poster: "poster.jpg" }), BASE);
  assert.equal(started.poster, "https://example.org/films/poster.jpg");
  assert.deepEqual(started.start, { pose: { eye: [1, 2, 3], yaw: Math.PI / 2, pitch: 0 }, fovDeg: 50 });
});

test("a pose looks at a point, upright", () => {
  const forward: Vec3 = [0.48, -0.6, -0.64];
  forwardOf(poseOf([1, 2, 3], forward)).forEach((value, axis) => near(value, forward[axis]!));
  assert.deepEqual(poseOf([0, 0, 0], [0, -2, 0]), { eye: [0, 0, 0], yaw: 0, pitch: -MAX_PITCH });
});

test("the eye circles among the probes, near to where it was, and is there at first", () => {
  const headBox = { least: [-0.3, 1.5, 0] as Vec3, greatest: [0.3, 1.5, 0] as Vec3 };
  near(orbitRadius({ headBox, nearM: 1.2 }), 0.06);
  near(orbitRadius({ headBox, nearM: 100 }), 0.15);
  near(orbitRadius({ headBox }), 0.15);
  assert.equal(orbitRadius({ headBox: { least: [1, 2, 3], greatest: [1, 2, 3] }, nearM: 1 }), 0);
  const pose = { eye: [0, 1.5, 0] as Vec3, yaw: Math.PI / 2, pitch: 0 };
  const away = (seconds: number): number =>
    Math.hypot(...orbitEye(pose, 0.06, seconds).map((value, axis) => value - pose.eye[axis]!));
  near(away(0), 0);
  assert.ok(away(0.1) < 0.001, String(away(0.1)));
  for (let seconds = 0; seconds < 30; seconds += 0.25) {
    assert.ok(away(seconds) <= 0.06, String(away(seconds)));
  }
  near(away(15), 0.06);
  // Across the picture, which looks along -X.
  near(orbitEye(pose, 0.06, 15)[2], -0.06, 1e-6);
});

test("base64 becomes bytes, in pieces", () => {
  for (const length of [0, 1, 2, 3, 4, 786_431, 786_432, 786_433, 2_000_000]) {
    const bytes = Uint8Array.from({ length }, (_, at) => (at * 7919) >> 3);
    assert.ok(Buffer.from(bytes).equals(bytesOfBase64(Buffer.from(bytes).toString("base64"))), String(length));
  }
  assert.throws(() => bytesOfBase64("a$=="));
});

test("a film.json that is wrong, or of another origin, is refused with a sentence", () => {
  const urls = [
    "https://evil.example/x",
    "//evil.example/x",
    "/\\evil.example/x",
    "\\\\evil.example/x",
    " //evil.example/x",
    "/\t/evil.example/x",
    "javascript:alert(1)",
    "data:,x",
    "blob:https://example.org/x",
    "https://example.org/films/film.lfold",
    "",
    7,
    "x".repeat(5000),
  ];
  const tiles = [undefined, null, [], { columns: 0, rows: 1, aspect: 1 }, { columns: 1, rows: 5000, aspect: 1 }];
  const faulty = [
    "",
    "[]",
    "null",
    "{",
    '{"__proto__": {"kind": "lfold"}}',
    ...urls.map((url) => film({ url })),
    ...["exe", undefined, 1].map((kind) => film({ kind })),
    ...[-1, 1.5, 2 ** 60, "1", null].map((bytes) => film({ bytes })),
    ...["", 1, "x".repeat(2000)].map((name) => film({ name })),
    ...tiles.map((quilt) => film({ kind: "quilt", quilt })),
    ...["//evil.example/x", "", 1, null].map((poster) => film({ poster })),
    ...[null, [], {}, { eye: [0, 0, 0], look_at: [0, 0, 0], fov_y_deg: 60 }].map((start) => film({ start })),
    ...[0, 180, "60", null].map((fov) => film({ start: { eye: [0, 0, 0], look_at: [0, 0, 1], fov_y_deg: fov } })),
    ...[
      [0, 0],
      [0, 0, "1"],
      [0, 0, null],
    ].map((eye) => film({ start: { eye, look_at: [0, 0, 1], fov_y_deg: 60 } })),
    ...[0, -1, "1", 1e9].map((aspect) => film({ kind: "quilt", quilt: { columns: 1, rows: 1, aspect } })),
  ];
  for (const json of faulty) {
    assert.throws(
      () => parseFilmFile(json, BASE),
      (error) => error instanceof FilmFileError && /^film\.json.*\.$/.test(error.message),
      json.slice(0, 100),
    );
  }
});

test("of a film.json that does not end, no more is read than any has", async () => {
  let sent = 0;
  const server = createServer((request, response) => {
    if (request.url === "/film.json") {
      response.end(film({}));
      return;
    }
    const timer = setInterval(() => {
      response.write(" ".repeat(10_000));
      sent += 10_000;
    }, 1);
    response.on("close", () => clearInterval(timer));
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  const origin = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
  try {
    assert.equal((await fetchFilmFile(`${origin}/film.json`)).url, `${origin}/film.lfold`);
    await assert.rejects(fetchFilmFile(`${origin}/endless`), /^FilmFileError: film\.json is longer than any/);
    assert.ok(sent < 10_000_000);
  } finally {
    server.closeAllConnections();
    server.close();
  }
  await assert.rejects(fetchFilmFile(`${origin}/film.json`), /^FilmFileError: film\.json.* cannot be reached\.$/);
});

test("film time goes on while pictures are slow", () => {
  const clock = new FilmClock({ firstFrame: 10, frameCount: 48, framesPerSecond: 24 });
  assert.equal(clock.frame(0), 10);
  clock.play(1000);
  assert.equal(clock.frame(1000 + 500), 22);
  assert.equal(clock.frame(1000 + 1990), 57);
  assert.equal(clock.frame(1000 + 2010), 10);
  clock.setSpeed(0.5, 3000);
  assert.equal(clock.frame(4000), 22);
  clock.pause(4000);
  assert.equal(clock.frame(9000), 22);
  clock.step(-13, 9000);
  assert.equal(clock.frame(9000), 57);
  clock.isLooped = false;
  clock.step(5, 9000);
  assert.equal(clock.frame(9000), 57);
  clock.play(10_000);
  assert.equal(clock.frame(10_000), 10);
  assert.equal(clock.frame(99_000), 57);
  assert.equal(clock.isPlaying, false);
  clock.seek(1e9, 99_000);
  assert.equal(clock.frame(99_000), 57);
});

test("film time has a frame at any rate", () => {
  for (const framesPerSecond of [0, 1e-300, 1e300, Infinity, -24, NaN]) {
    const clock = new FilmClock({ firstFrame: 10, frameCount: 48, framesPerSecond });
    for (const isLooped of [true, false]) {
      clock.isLooped = isLooped;
      clock.play(0);
      for (const ms of [0, 1, 40, 1e6, 1e12]) {
        const frame = clock.frame(ms);
        assert.ok(Number.isInteger(frame) && frame >= 10 && frame <= 57, `${frame} at ${framesPerSecond}/s, ${ms} ms`);
      }
    }
  }
});

function statsWith(unitsMissing: number, overlayMissing: number): PlayerStats {
  const none = {
    decodeMs: 0,
    marchMs: 1,
    fetchRate: 0,
    bytesFetched: 0,
    requests: 0,
    chunksFetched: 0,
    unitsBroken: 0,
  };
  return { ...none, counters: {}, chunksRefetched: 0, cacheBytes: 0, unitsMissing, overlayMissing, shownFrame: 0 };
}

test("pictures are drawn one at a time, where something changed or is to come, and coarser in motion", async () => {
  let now = 0;
  let [missing, overlayMissing] = [0, 0];
  const factors: number[] = [];
  const waiting: (() => void)[] = [];
  const loop = new DrawLoop({
    draw: (factor) => {
      factors.push(factor);
      return new Promise((resolve) => waiting.push(() => resolve(statsWith(missing, overlayMissing))));
    },
    onDrawn: () => undefined,
    onFailed: () => assert.fail("drawing does not fail"),
    now: () => now,
  });
  const finish = async (ms: number): Promise<void> => {
    now += ms;
    waiting.shift()!();
    await new Promise((resolve) => setImmediate(resolve));
  };
  const taken = (): number[] => factors.splice(0);
  // The first picture is coarse, so that it is there soon.
  loop.tick();
  loop.tick();
  assert.deepEqual(taken(), [0.25]);
  await finish(10);
  loop.tick();
  assert.deepEqual(taken(), [1]);
  await finish(10);
  loop.tick();
  assert.deepEqual(taken(), []);
  // A move during a picture is drawn after it; a slow picture makes the next one coarser.
  loop.move();
  loop.tick();
  loop.move();
  loop.tick();
  assert.deepEqual(taken(), [1]);
  await finish(150);
  loop.tick();
  assert.deepEqual(taken(), [0.5]);
  await finish(150);
  loop.move();
  loop.tick();
  assert.deepEqual(taken(), [0.25]);
  await finish(50);
  now += 100;
  loop.tick();
  assert.deepEqual(taken(), []);
  now += 200;
  loop.tick();
  assert.deepEqual(taken(), [1]);
  missing = 3;
  await finish(50);
  loop.tick();
  assert.deepEqual(taken(), []);
  now += 100;
  loop.tick();
  assert.deepEqual(taken(), [1]);
  // A picture whose overlay is to come is drawn again, at its full resolution.
  [missing, overlayMissing] = [0, 5];
  await finish(10);
  now += 100;
  loop.tick();
  assert.deepEqual(taken(), [1]);
  overlayMissing = 0;
  await finish(10);
  now += 1000;
  loop.tick();
  assert.deepEqual(taken(), []);
});

test("a loop whose drawing fails says so once and rests", async () => {
  const errors: unknown[] = [];
  const loop = new DrawLoop({
    draw: () => Promise.reject(new Error("lost")),
    onDrawn: () => assert.fail("nothing can be drawn"),
    onFailed: (error) => errors.push(error),
    now: () => 0,
  });
  for (let at = 0; at < 3; at += 1) {
    loop.change();
    loop.tick();
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.equal(errors.length, 1);
});

test("the resolution in motion follows the time of pictures", () => {
  const resolution = new Resolution();
  resolution.note(1, 400);
  assert.equal(resolution.factor(true), 0.25);
  assert.equal(resolution.factor(false), 1);
  for (let at = 0; at < 9; at += 1) {
    resolution.note(resolution.factor(true), 400);
  }
  assert.equal(resolution.factor(true), 0.125);
  resolution.note(0.125, 10);
  assert.equal(resolution.factor(true), 0.25);
  resolution.note(1, 60);
  assert.equal(resolution.factor(true), 1);
});

function press(key: string, more: Partial<KeyPress> = {}): KeyPress {
  return { key, code: "", ctrlKey: false, altKey: false, metaKey: false, ...more };
}

test("keys act on the page only where they are not needed elsewhere", () => {
  assert.equal(actionOf(press(" "), "picture"), "play");
  assert.equal(actionOf(press(" "), "widget"), undefined);
  assert.equal(actionOf(press(" "), "slider"), "play");
  assert.equal(actionOf(press("Home"), "slider"), undefined);
  assert.equal(actionOf(press("."), "widget"), "step-forward");
  assert.equal(actionOf(press("R"), "picture"), "reset");
  assert.equal(actionOf(press("r", { ctrlKey: true }), "picture"), undefined);
  assert.equal(actionOf(press("i"), "text"), undefined);
  assert.equal(actionOf(press("toString"), "picture"), undefined);
  assert.equal(isForPage(press("ArrowLeft"), "widget"), false);
  assert.deepEqual(motionOf(["KeyW", "KeyD", "KeyA", "ArrowUp", "constructor"]), { step: [0, 0, 1], turn: [0, 1] });
  const buttons = Array.from({ length: 17 }, (_, at) => ({ pressed: false, value: at === 7 ? 1 : 0 }));
  const { step, turn } = motionOfPad({ axes: [0.1, -1, 0.05, 1], buttons });
  assert.deepEqual(
    [step.map((value) => value + 0), turn.map((value) => value + 0)],
    [
      [0, 1, 1],
      [0, -1],
    ],
  );
});

test("small texts", () => {
  assert.equal(byteText(999), "999 B");
  assert.equal(byteText(184_320_112), "184 MB");
  assert.equal(byteText(999_600), "1.00 MB");
  assert.equal(sentence("It failed"), "It failed.");
  assert.equal(sentence("It failed."), "It failed.");
  assert.equal(screenshotName("atrium day.lfold", 12), "atrium_day_0012.png");
  assert.equal(screenshotName('../../<x>"\n.glb', 0), "x_0000.png");
  assert.equal(screenshotName(".lfold", 123456), "film_123456.png");
});

test("tiles of a quilt start at the bottom left", () => {
  const layout = { columns: 4, rows: 3, aspect: 2 };
  assert.deepEqual(tileOf(0, layout, [400, 150]), [0, 100, 100, 50]);
  assert.deepEqual(tileOf(5, layout, [400, 150]), [100, 50, 100, 50]);
  assert.deepEqual(tileOf(11, layout, [401, 152]), [300, 0, 100, 50]);
  assert.deepEqual(fitted([800, 600], 2), [800, 400]);
  assert.deepEqual(fitted([800, 100], 2), [200, 100]);
  assert.deepEqual(
    pngSize(
      png(3, 2, () => [0, 0, 0, 255]),
      "It",
    ),
    [3, 2],
  );
  const huge = png(1, 1, () => [0, 0, 0, 255]);
  huge.writeUInt32BE(2 ** 31, 16);
  assert.throws(() => pngSize(huge, "It"), /^UnsupportedError: It has 2147483648x1 pixels/);
  assert.throws(() => pngSize(Buffer.from("GIF89a"), "It"), /^FormatError: It is no PNG picture\.$/);
});

test("the head of a scene is checked before a loader sees it", () => {
  const head = parseSceneHead(sceneFile([255, 0, 0, 255], [0, 255, 0, 255]));
  assert.deepEqual(head.region, { least: [-0.5, -0.5, -0.5], greatest: [0.5, 0.5, 0.5] });
  assert.deepEqual([head.frame, head.triangles, head.textureSize], [7, 4, [8, 4]]);
  const refused = (change: Parameters<typeof sceneFile>[2], message: RegExp): void => {
    assert.throws(() => parseSceneHead(sceneFile([0, 0, 0, 0], [0, 0, 0, 0], change)), message);
  };
  refused((json) => delete json.extras, /do not name lightfold/);
  refused((json) => (json.images[0]!.uri = "https://evil.example/x.png"), /names other files/);
  refused((json) => (json.accessors[0]!.count = 2 ** 31), /more values than there are/);
  refused((json) => delete json.accessors[1]!.bufferView, /outside of its bytes/);
  refused((json) => (json.nodes = [{ children: [0] }]), /nodes within nodes/);
  refused((json) => (json.bufferViews = [{ byteLength: 2 ** 31 }]), /outside of its bytes/);
  refused(
    (json) =>
      (json.extras = {
        lightfold: {
          viewing_region_m: [
            [0, 0, "x"],
            [0, 0, 0],
          ],
        },
      }),
    /two corners/,
  );
  refused((json) => (json.images = []), /0 textures/);
  const whole = sceneFile([0, 0, 0, 0], [0, 0, 0, 0]);
  for (let length = 0; length < whole.length; length += 37) {
    assert.throws(() => parseSceneHead(whole.subarray(0, length)), /^(FormatError|UnsupportedError): .*\.$/);
  }
});

test("the page has no inline code or style, and its policy lets nothing else in", () => {
  const html = readFileSync("src/ui/index.html", "utf8");
  assert.ok(!/<style|\sstyle=|\son[a-z]+=|javascript:/i.test(html));
  assert.deepEqual([...html.matchAll(/<script[^>]*>[^<]*<\/script>/g)].map(String), [
    '<script type="module" src="viewer.js"></script>',
  ]);
  const policy = /content="(default-src[^"]*)"/.exec(html)?.[1];
  const expected =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; " +
    "img-src 'self' blob: data:; connect-src 'self' blob:; base-uri 'none'; form-action 'none'";
  assert.equal(policy, expected);
  assert.ok(
    !/https?:/.test(html + readFileSync("src/ui/style.css", "utf8") + readFileSync("src/ui/narrow.css", "utf8")),
  );
});
