// The page in headless Chromium, around a player of the tests; scenes and quilts on a canvas.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { Page as Tab } from "playwright-core";
import type { Film, View } from "../src/player/types.ts";
import { inPageOf, withoutBrowser } from "./browser.ts";
import { png, sceneFile } from "./ui_scene.ts";
import { drawn, type Fake, lastView, onPage, read, until } from "./ui_tab.ts";

const skip = withoutBrowser;

async function violations(tab: Tab): Promise<string[]> {
  await tab.evaluate(readFileSync("node_modules/axe-core/axe.min.js", "utf8"));
  const result = (await tab.evaluate("axe.run()")) as { violations: { id: string; nodes: { target: unknown[] }[] }[] };
  return result.violations.map(({ id, nodes }) => `${id} ${nodes.map(({ target }) => String(target)).join(" ")}`);
}

test("the page has no faults that axe finds, in any state", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    for (const key of ["", "v", "i", "h"]) {
      if (key !== "") {
        await tab.keyboard.press(key);
      }
      assert.deepEqual(await violations(tab), [], key);
    }
  });
  await onPage("?no-webgpu", async (tab) => {
    await until(tab, drawn);
    assert.deepEqual(await violations(tab), []);
  });
  await onPage("?format", async (tab) => {
    await tab.waitForSelector("#notice-retry:not([hidden])");
    assert.deepEqual(await violations(tab), []);
  });
});

test("the keyboard moves, looks, plays and steps", { skip }, async () => {
  await onPage("#eye=0,1.5,0&look=0,0&frame=20", async (tab) => {
    await until(tab, drawn);
    assert.deepEqual((await lastView(tab)).pose, { eye: [0, 1.5, 0], yaw: 0, pitch: 0 });
    assert.equal((await lastView(tab)).frame, 20);
    await tab.keyboard.down("w");
    await until(tab, (fake) => fake.views.some((view) => view.pose.eye[2] < -0.05));
    await tab.keyboard.up("w");
    await tab.keyboard.down("ArrowLeft");
    await until(tab, (fake) => fake.views.some((view) => view.pose.yaw > 0.1));
    await tab.keyboard.up("ArrowLeft");
    await tab.keyboard.press(".");
    await until(tab, (fake) => fake.views.some((view) => view.frame === 21));
    await tab.keyboard.press("End");
    await until(tab, (fake) => fake.views.some((view) => view.frame === 105));
    await tab.keyboard.press("Home");
    await tab.keyboard.press("Space");
    await until(tab, (fake) => fake.views.some((view) => view.frame > 12 && view.frame < 20));
    await tab.keyboard.press("Space");
    await tab.keyboard.press("0");
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.pose.yaw === 0);
    // All buttons are reached by Tab, and Space presses the one that has the focus.
    const reached = new Set<string>();
    for (let at = 0; at < 30; at += 1) {
      await tab.keyboard.press("Tab");
      reached.add(await tab.evaluate(() => document.activeElement?.id ?? ""));
    }
    const buttons = await tab.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>("button")]
        .filter((button) => button.checkVisibility())
        .map((button) => button.id),
    );
    assert.deepEqual(
      buttons.filter((id) => !reached.has(id)),
      [],
    );
    await tab.focus("#open-help");
    await tab.keyboard.press("Space");
    assert.ok(await tab.isVisible("#help"));
    await tab.focus("#side");
    await tab.keyboard.press("Escape");
    assert.ok(!(await tab.isVisible("#side")));
    assert.equal(await read(tab, (fake) => fake.greatestActive), 1);
  });
});

test("what was pressed by a pointer leaves the keyboard to the picture", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.click("#open-settings");
    await tab.keyboard.press("Space");
    await until(tab, (fake) => fake.views.some((view) => view.frame > 12));
    assert.ok(await tab.isVisible("#settings"));
    await tab.selectOption("#stereo", "anaglyph");
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.stereo === "anaglyph");
    await tab.fill("#exposure", "-2");
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.exposureEv === -2);
    await tab.click("#reset-settings");
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.exposureEv === 0);
  });
});

test("a panel that opens takes the focus, and gives it back", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    const focused = (): Promise<string> => tab.evaluate(() => document.activeElement?.id ?? "");
    for (const [key, name] of [
      ["v", "settings"],
      ["i", "inspector"],
      ["h", "help"],
    ]) {
      await tab.focus(`#open-${name}`);
      await tab.keyboard.press("Enter");
      assert.equal(await focused(), name);
      assert.equal(await tab.getAttribute("#side", "aria-labelledby"), `${name}-title`);
      await tab.keyboard.press("Escape");
      assert.equal(await focused(), `open-${name}`);
      await tab.focus("#stage");
      await tab.keyboard.press(key!);
      assert.equal(await focused(), name);
      await tab.keyboard.press(key!);
      assert.equal(await focused(), "stage");
      assert.ok(!(await tab.isVisible("#side")));
    }
    // From panel to panel, and back to where it was.
    await tab.keyboard.press("v");
    await tab.keyboard.press("i");
    assert.equal(await focused(), "inspector");
    await tab.keyboard.press("Escape");
    assert.equal(await focused(), "stage");
    // By pointer.
    await tab.click("#open-settings");
    assert.equal(await focused(), "settings");
    // Headings are text: neither fields nor buttons.
    assert.equal(await tab.locator("#side :is(h2, h3)[tabindex], #side :is(h2, h3) *").count(), 0);
  });
});

test("the eye circles where it is asked to, until the first input", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    const eyes = (): Promise<number> =>
      read(tab, (fake) => new Set(fake.views.map(({ pose }) => pose.eye.join())).size);
    // Motion is to be reduced.
    await tab.waitForTimeout(500);
    assert.equal(await eyes(), 1);
    await tab.click("#open-settings");
    assert.equal(await tab.isChecked("#orbit"), false);
    await tab.check("#orbit");
    await until(tab, (fake) => new Set(fake.views.map(({ pose }) => pose.eye.join())).size > 5);
    await tab.mouse.click(200, 300);
    await tab.waitForSelector("#orbit:not(:checked)");
    await tab.waitForTimeout(300);
    const still = await eyes();
    await tab.waitForTimeout(300);
    assert.equal(await eyes(), still);
    // By the keyboard, and off by the field itself.
    await tab.focus("#orbit");
    await tab.keyboard.press("Space");
    await until(tab, (fake) => fake.views.length > 0);
    assert.equal(await tab.isChecked("#orbit"), true);
    await tab.keyboard.press("Space");
    assert.equal(await tab.isChecked("#orbit"), false);
  });
});

test("small windows keep most of their height for the picture, and panels lie over it", { skip }, async () => {
  for (const [width, height] of [
    [480, 320],
    [320, 640],
    [720, 480],
  ] as const) {
    await onPage("", async (tab) => {
      await tab.setViewportSize({ width, height });
      await until(tab, drawn);
      const sides = (selector: string): Promise<number[]> =>
        tab.evaluate((wanted) => {
          const { left, right, top, bottom } = document.querySelector(wanted)!.getBoundingClientRect();
          return [left, right, top, bottom];
        }, selector);
      const stage = await sides("#stage");
      assert.ok(stage[2]! <= 40 && height - stage[3]! <= 66, `${stage.join()} of ${width}x${height}`);
      assert.deepEqual(stage.slice(0, 2), [0, width]);
      const parts = await tab.evaluate(() =>
        [...document.querySelectorAll("header button, #transport button, #transport select, .track, #frame-label")]
          .filter((part) => part.checkVisibility())
          .map((part) => [part.getBoundingClientRect().left, part.getBoundingClientRect().right]),
      );
      assert.ok(parts.length > 13 && parts.every(([left, right]) => left! >= 0 && right! <= width), String(parts));
      await tab.keyboard.press("v");
      assert.deepEqual(await sides("#stage"), stage);
      const side = await sides("#side");
      assert.ok(side[0]! > 150 || side[2]! > 250, `${side.join()} hides the picture`);
      assert.deepEqual(await violations(tab), []);
    });
  }
});

test("a quilt has views, and nothing that needs a pose", { skip }, async () => {
  await onPage("?quilt", async (tab) => {
    await until(tab, drawn);
    await tab.keyboard.press("End");
    await tab.waitForFunction(() => document.querySelector("#frame-label")?.textContent === "View 105 of 10–105");
    assert.equal(await tab.getAttribute("#timeline", "aria-label"), "View");
    assert.ok(!(await tab.isVisible("#time-code")));
    assert.match((await tab.textContent("#film-facts")) ?? "", /· 96 views ·/);
    // There are no settings to open.
    await tab.keyboard.press("v");
    assert.ok(!(await tab.isVisible("#open-settings")) && !(await tab.isVisible("#side")));
    await tab.keyboard.press("h");
    assert.ok(!/head box|look around|view settings/.test(await tab.innerText("#help")));
    await tab.keyboard.press("i");
    assert.ok(!(await tab.isVisible("#map")));
    await tab.waitForSelector("#figures td");
    const rows = await tab.evaluate(() =>
      [...document.querySelectorAll("#figures th")].map((cell) => cell.textContent),
    );
    assert.deepEqual(rows, ["Picture", "Decoding", "Size", "Fetched", "Cache"]);
  });
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.waitForFunction(
      () => document.querySelector("#frame-label")?.parentElement?.textContent === "Frame 10 of 10–105 · 00:00:00:00",
    );
  });
});

test("letters act on the page while a list, a button or a checkbox has the focus", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.keyboard.press("i");
    for (const [at, selector] of ["#speed", "#marks input[value=holes]", "#copy-link", "#inspector"].entries()) {
      await tab.focus(selector);
      await tab.keyboard.press(".");
      await until(
        tab,
        new Function("fake", `return fake.views.at(-1).frame === ${11 + at}`) as (fake: Fake) => boolean,
      );
      await tab.evaluate("fake.views = []");
      await tab.keyboard.down("w");
      await until(tab, (fake) => fake.views.length > 1);
      await tab.keyboard.up("w");
      await tab.keyboard.press("0");
    }
    // A list keeps the keys that choose.
    await tab.focus("#speed");
    await tab.keyboard.press("ArrowDown");
    assert.equal(await tab.inputValue("#speed"), "1.5");
    await tab.keyboard.press("ArrowUp");
    assert.equal(await tab.inputValue("#speed"), "1");
    // One that shows its choices keeps all.
    await tab.keyboard.press("Space");
    await tab.keyboard.press("i");
    assert.ok(await tab.isVisible("#inspector"));
  });
});

test("dragging turns, and the eye stays near the head box", { skip }, async () => {
  await onPage("#eye=99,1.5,-99&look=0,0", async (tab) => {
    await until(tab, drawn);
    const { pose } = await lastView(tab);
    assert.ok(pose.eye[0] <= 0.6001 && pose.eye[2] >= -0.6001);
    await tab.mouse.move(600, 300);
    await tab.mouse.down();
    await tab.mouse.move(700, 320, { steps: 4 });
    await tab.mouse.up();
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.pose.yaw > 0.1);
    assert.ok((await lastView(tab)).pose.pitch > 0.02);
  });
});

test("fingers turn and move, without scrolling the page", { skip }, async () => {
  await onPage("#eye=0,1.5,0&look=0,0", async (tab) => {
    await until(tab, drawn);
    const devtools = await tab.context().newCDPSession(tab);
    await devtools.send("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 2 });
    const box = (await tab.locator("#stage").boundingBox())!;
    const touch = (type: "touchStart" | "touchMove" | "touchEnd", fingers: [number, number][]): Promise<void> =>
      devtools
        .send("Input.dispatchTouchEvent", {
          type,
          touchPoints: fingers.map(([x, y], id) => ({ x: box.x + x * box.width, y: box.y + y * box.height, id })),
        })
        .then(() => undefined);
    await touch("touchStart", [[0.4, 0.5]]);
    await touch("touchMove", [[0.5, 0.5]]);
    await touch("touchMove", [[0.6, 0.5]]);
    // The picture follows the finger: what is on the left comes into sight.
    await until(tab, (fake) => fake.views.some((view) => view.pose.yaw > 0.1));
    await touch("touchEnd", []);
    const { yaw } = (await lastView(tab)).pose;
    await touch("touchStart", [
      [0.45, 0.5],
      [0.55, 0.5],
    ]);
    for (const spread of [0.1, 0.2]) {
      await touch("touchMove", [
        [0.45 - spread, 0.5],
        [0.55 + spread, 0.5],
      ]);
    }
    // Fingers that part go ahead, and do not turn.
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.pose.eye[2] < -0.02);
    await touch("touchEnd", []);
    assert.equal((await lastView(tab)).pose.yaw, yaw);
  });
});

test("a gamepad moves, turns and plays", { skip }, async () => {
  await onPage("#eye=0,1.5,0&look=0,0", async (tab) => {
    await until(tab, drawn);
    const hold = (axes: number[], pressed: number[]): Promise<void> =>
      tab.evaluate(
        ([sticks, down]) => {
          const buttons = Array.from({ length: 17 }, (_, at) => ({
            pressed: down.includes(at),
            touched: down.includes(at),
            value: Number(down.includes(at)),
          }));
          const pad = { connected: true, mapping: "standard", id: "pad", index: 0, axes: sticks, buttons };
          Object.defineProperty(navigator, "getGamepads", { value: () => [pad], configurable: true });
        },
        [axes, pressed] as const,
      );
    await hold([0, -1, 0, 0], []);
    await until(tab, (fake) => fake.views.some((view) => view.pose.eye[2] < -0.05));
    await hold([0, 0, -1, 0], []);
    await until(tab, (fake) => fake.views.some((view) => view.pose.yaw > 0.1));
    await hold([0, 0, 0, 0], [0]);
    await until(tab, (fake) => fake.views.some((view) => view.playing));
    await hold([0, 0, 0, 0], []);
    // The page looks once a picture of the screen.
    await tab.waitForTimeout(100);
    await hold([0, 0, 0, 0], [0]);
    await until(tab, (fake) => !fake.views[fake.views.length - 1]!.playing);
  });
});

test("nothing is drawn while nothing changes, and data that arrive are drawn", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.waitForTimeout(600);
    const before = await read(tab, (fake) => fake.views.length);
    await tab.waitForTimeout(400);
    assert.equal(await read(tab, (fake) => fake.views.length), before);
    await tab.evaluate("fake.missing = 2");
    await tab.keyboard.press(".");
    await tab.waitForSelector("#state:not([hidden])");
    assert.equal(await tab.textContent("#state"), "2 tiles and cells not loaded yet");
    const during = await read(tab, (fake) => fake.views.length);
    await until(tab, new Function("fake", `return fake.views.length > ${during} + 2`) as (fake: Fake) => boolean);
    await tab.evaluate("fake.missing = 0");
    await tab.waitForSelector("#state", { state: "hidden" });
  });
});

test("the address follows the view, and the view the address", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.keyboard.press("End");
    await tab.waitForFunction(() => location.hash === "#eye=0,1.5,0&look=0,0&frame=105");
    assert.equal(await tab.evaluate(() => history.length), 2);
    await tab.evaluate(() => (location.hash = "#eye=0.2,1.4,0.1&look=90,10&frame=33&fov=80&show=holes"));
    await until(tab, (fake) => fake.views[fake.views.length - 1]!.frame === 33);
    const view = await lastView(tab);
    assert.deepEqual(view.pose.eye, [0.2, 1.4, 0.1]);
    assert.ok(Math.abs(view.pose.yaw - Math.PI / 2) < 1e-9);
    assert.equal(view.fovDeg, 80);
    await tab.keyboard.press("i");
    assert.ok(await tab.isChecked("#marks input[value=holes]"));
    await tab.waitForFunction(() => document.querySelector("#command")?.textContent?.includes("--frames 33"));
    const command = (await tab.textContent("#command")) ?? "";
    assert.match(
      command,
      /--eye 0\.2,1\.4,0\.1 --look-at -0\.78481,1\.57365,0\.1 --fov 80 --size \d+x\d+ --frames 33 -o view\.png$/,
    );
  });
});

test("a link with another renderer keeps its pose and frame, also while the film is opened", { skip }, async () => {
  await onPage("#eye=0,1.5,0&look=0,0&frame=20", async (tab) => {
    await until(tab, drawn);
    await tab.evaluate(() => (location.hash = "#eye=0.2,1.5,0&look=90,0&frame=31&renderer=cpu"));
    await until(tab, (fake) => fake.opened === 2 && fake.views[fake.views.length - 1]!.frame === 31);
    const { pose } = await lastView(tab);
    assert.deepEqual(pose.eye, [0.2, 1.5, 0]);
    assert.ok(Math.abs(pose.yaw - Math.PI / 2) < 1e-9);
    // Twice in a row: the first is being opened.
    await tab.evaluate(async () => {
      location.hash = "#eye=0,1.5,0&look=0,0&frame=40&renderer=gpu";
      await new Promise((resolve) => setTimeout(resolve, 10));
      location.hash = "#eye=0.1,1.5,0&look=0,0&frame=41&renderer=cpu";
    });
    await until(tab, (fake) => fake.opened === 4 && fake.views[fake.views.length - 1]!.frame === 41);
    assert.deepEqual((await lastView(tab)).pose.eye, [0.1, 1.5, 0]);
    assert.equal(await tab.inputValue("#renderer"), "cpu");
  });
});

test("a screenshot is saved as a PNG of the picture", { skip }, async () => {
  await onPage("", async (tab) => {
    await until(tab, drawn);
    await tab.evaluate("fake.isTransient = true");
    const [download] = await Promise.all([tab.waitForEvent("download"), tab.keyboard.press("c")]);
    assert.equal(download.suggestedFilename(), "atrium_img_src_x_onerror_globalThis.broken_1_quoted_0010.png");
    const bytes = readFileSync(await download.path());
    const { size } = await lastView(tab);
    assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], size);
    const middle = await tab.evaluate(
      async (codes) => {
        const picture = await createImageBitmap(new Blob([new Uint8Array(codes)]));
        const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d")!;
        context.drawImage(picture, 0, 0);
        return [...context.getImageData(picture.width / 2, picture.height / 2, 1, 1).data];
      },
      [...bytes],
    );
    assert.deepEqual(middle, [0x3a, 0x40, 0x46, 255]);
  });
});

const VIEW: Omit<View, "overlays"> = {
  pose: { eye: [0, 0, 0], yaw: 0, pitch: 0 },
  frame: 0,
  playing: false,
  size: [64, 64],
  fovDeg: 60,
  stereo: "mono",
  eyeDistance: 0.5,
  exposureEv: 0,
  toneMap: "none",
  steps: 1,
};

interface Picture {
  film: Film;
  counters: Record<string, number>;
  size: [number, number];
  rgba: number[];
  canvas: [number, number];
}

/** Light of a code of sRGB. */
function light(code: number): number {
  const part = code / 255;
  return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
}

function assertPixel({ size, rgba }: Picture, [x, y]: [number, number], expected: number[]): void {
  const at = 4 * (y * size[0] + x);
  expected.forEach((value, channel) => {
    const found = rgba[at + channel]!;
    assert.ok(
      Math.abs(found - value) < 0.003,
      `pixel ${x},${y}: ${rgba.slice(at, at + 4).join(" ")}, not ${expected.join(" ")}`,
    );
  });
}

test("a scene is drawn in the order of its file, blended in linear light", { skip }, async () => {
  const files = new Map([
    ["/opaque.glb", sceneFile([200, 0, 0, 255], [0, 100, 0, 255])],
    ["/thin.glb", sceneFile([200, 50, 0, 255], [0, 100, 250, 51])],
    ["/foreign.glb", sceneFile([0, 0, 0, 0], [0, 0, 0, 0], (json) => delete json.extras)],
  ]);
  await inPageOf("tests/ui_films.page.ts", files, async (call) => {
    const opaque: Picture = await call("scene", { path: "/opaque.glb", view: VIEW });
    assert.deepEqual(opaque.film.headBox, { least: [-0.5, -0.5, -0.5], greatest: [0.5, 0.5, 0.5] });
    // The farther square is later in the file, and hides the nearer one.
    assertPixel(opaque, [32, 32], [0, light(100), 0, 1]);
    assertPixel(opaque, [8, 32], [light(200), 0, 0, 1]);
    assertPixel(opaque, [1, 32], [0, 0, 0, 0]);
    const thin: Picture = await call("scene", { path: "/thin.glb", view: VIEW });
    const blended = [
      [0, 200],
      [100, 50],
      [250, 0],
    ].map(([over, under]) => 0.2 * light(over!) + 0.8 * light(under!));
    assertPixel(thin, [32, 32], [...blended, 1]);
    const count: Picture = await call("scene", { path: "/thin.glb", view: VIEW, isOverdraw: true });
    assert.equal(count.counters.overdraw_peak, 2);
    assertPixel(count, [8, 32], [1, 1, 1, 1]);
    // At a yaw to the left the left edge of the picture shows what was farther to the left; above is what was above.
    const turned: Picture = await call("scene", {
      path: "/opaque.glb",
      view: { ...VIEW, pose: { eye: [0, 0.9, 0], yaw: 0.3, pitch: 0 } },
    });
    assertPixel(turned, [4, 32], [0, 0, 0, 0]);
    assertPixel(turned, [50, 40], [0, light(100), 0, 1]);
    assertPixel(turned, [50, 4], [0, 0, 0, 0]);
    // Half of the width for each eye; the left eye is left of the middle.
    const both: Picture = await call("scene", {
      path: "/opaque.glb",
      view: { ...VIEW, size: [128, 64], stereo: "side-by-side" },
    });
    assert.deepEqual(
      [both.size, both.canvas],
      [
        [64, 64],
        [128, 64],
      ],
    );
    assertPixel(both, [61, 32], [light(200), 0, 0, 1]);
    assertPixel(both, [3, 32], [0, 0, 0, 0]);
    const sentence = await call("refusal", { path: "/foreign.glb", view: VIEW });
    assert.match(String(sentence), /^UnsupportedError: Its extras do not name lightfold: .*\.$/);
  });
});

test("a scene that is closed ends its headset session and releases its context", { skip }, async () => {
  const files = new Map([["/scene.glb", sceneFile([200, 0, 0, 255], [0, 100, 0, 255])]]);
  await inPageOf("tests/ui_films.page.ts", files, async (call) => {
    const shown = await call("headset", { path: "/scene.glb", isEarly: false });
    assert.deepEqual(shown, { sessions: [1, 0], isLost: true, problems: 0 });
    const asked = await call("headset", { path: "/scene.glb", isEarly: true });
    assert.deepEqual(asked, { sessions: [0, 0], isLost: true, problems: 0 });
  });
});

test("a quilt shows its views from left to right", { skip }, async () => {
  const shade = (view: number): number => 40 * view + 20;
  const picture = png(12, 4, (x, y) => [shade(Math.floor(x / 4) + (y < 2 ? 3 : 0)), 0, 0, 255]);
  await inPageOf("tests/ui_films.page.ts", new Map([["/quilt.png", picture]]), async (call) => {
    const layout = { columns: 3, rows: 2, aspect: 2 };
    for (const frame of [0, 2, 4, 5]) {
      const found: Picture = await call("quilt", { path: "/quilt.png", view: { ...VIEW, frame }, layout });
      assert.deepEqual(found.canvas, [64, 32]);
      assert.deepEqual([found.film.frameCount, found.film.startFrame], [6, 3]);
      assertPixel(found, [32, 16], [light(shade(frame)), 0, 0, 1]);
    }
  });
});
