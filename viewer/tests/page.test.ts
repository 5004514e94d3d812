// The page as `lightfold view` serves it, in headless Chromium.

import assert from "node:assert/strict";
import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdirSync } from "node:fs";
import { after, before, describe, test } from "node:test";
import type { Page } from "playwright-core";
import { inPage, withoutBrowser } from "./browser.ts";
import { capture, type Films, lightfold, withoutProgram } from "./films.ts";

const skip = withoutBrowser || withoutProgram;
/** Pictures of the page, to look at. */
const PICTURES = "target/pictures";

/** `lightfold view`, and the address of its page. */
async function serveFilm(film: string): Promise<{ address: string; end: () => void }> {
  const server: ChildProcess = spawn(process.env["LIGHTFOLD"]!, ["view", film], {
    stdio: ["ignore", "pipe", "ignore"],
  });
  const [line] = (await once(server.stdout!, "data")) as [Buffer];
  return { address: line.toString().trim(), end: () => server.kill() };
}

/** Opens a page; answers what `use` does, with its complaints and the addresses that it asked for. */
async function visit(
  address: string,
  use: (page: Page) => Promise<void>,
): Promise<{ complaints: string[]; asked: string[] }> {
  const [complaints, asked]: [string[], string[]] = [[], []];
  await inPage(async (page) => {
    page.on("console", (message) => complaints.push(message.text()));
    page.on("pageerror", (error) => complaints.push(error.message));
    page.on("request", (request) => asked.push(request.url()));
    await page.setViewportSize({ width: 480, height: 320 });
    await page.goto(address);
    await use(page);
  });
  return { complaints, asked };
}

/** Waits until the picture of the present view is complete. */
async function settled(page: Page): Promise<void> {
  await page.waitForFunction(() => document.getElementById("stage")!.ariaBusy === "false", undefined, {
    timeout: 120_000,
  });
}

/** Opens a page whose film does not come until the returned function is called, and waits for the poster. */
async function heldFilm(page: Page, address: string, name: string): Promise<() => void> {
  let release: () => void = () => undefined;
  const held = new Promise<void>((resolve) => (release = resolve));
  await page.route(`**/${name}`, (route) => held.then(() => route.continue()));
  await page.goto(address);
  await page.locator("img.poster").waitFor({ state: "visible", timeout: 60_000 });
  await page.waitForFunction(() => document.querySelector<HTMLImageElement>("img.poster")!.naturalWidth > 0);
  return release;
}

/** Keeps a picture of the stage, and answers how many colors it has. */
async function colorsOf(page: Page, name: string): Promise<number> {
  const png = await page.locator("#stage").screenshot({ path: `${PICTURES}/${name}.png` });
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d")!;
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }, png.toString("base64"));
}

describe("The page of lightfold view", { skip }, () => {
  let films: Films;
  before(() => {
    mkdirSync(PICTURES, { recursive: true });
    films = capture("interior", 64);
    films.encode("film.lfold", "--clip");
  });
  after(() => films.remove());

  for (const renderer of ["gpu", "cpu"]) {
    test(`shows a film, asks its own server alone, and complains of nothing: ${renderer}`, async () => {
      const { address, end } = await serveFilm(films.path("film.lfold"));
      try {
        const { complaints, asked } = await visit(
          `${address}#eye=0.05,1.55,0.05&look=0,0&renderer=${renderer}`,
          async (page) => {
            await settled(page);
            assert.ok((await colorsOf(page, `film-${renderer}`)) > 100);
            // The keyboard alone: forward, then the next frame.
            const before = await page.evaluate(() => location.hash);
            await page.keyboard.down("w");
            await page.waitForTimeout(300);
            await page.keyboard.up("w");
            await page.keyboard.press(".");
            await settled(page);
            await page.waitForFunction((hash) => location.hash !== hash, before);
            assert.match(await page.evaluate(() => location.hash), /frame=1/u);
          },
        );
        assert.deepEqual(complaints, []);
        assert.deepEqual(
          asked.filter((url) => !url.startsWith(address) && !url.startsWith(`blob:${address}`)),
          [],
        );
      } finally {
        end();
      }
    });
  }

  test("draws on the processor at once where a device is missing or fails", async () => {
    const { address, end } = await serveFilm(films.path("film.lfold"));
    const faults = [
      ["delete Navigator.prototype.gpu", "This browser has no WebGPU"],
      ["GPU.prototype.requestAdapter = () => Promise.resolve(null)", "no graphics device that it may use"],
      ["GPUAdapter.prototype.requestDevice = () => Promise.reject('busy')", "cannot be opened: busy"],
      ["GPUDevice.prototype.createRenderPipelineAsync = () => Promise.reject('none')", "cannot draw the film: none"],
      // The kernel of the first picture.
      [
        `const { createComputePipelineAsync: make } = GPUDevice.prototype;
        GPUDevice.prototype.createComputePipelineAsync = function (asked) {
          return asked.label === "render-pyramid" ? Promise.reject("no kernel") : make.call(this, asked);
        }`,
        "no kernel",
      ],
    ];
    try {
      for (const [fault, why] of faults) {
        const { complaints } = await visit("about:blank", async (page) => {
          await page.addInitScript(fault);
          await page.goto(`${address}#renderer=gpu`);
          await settled(page);
          const said = await page.locator(".message span").allInnerTexts();
          assert.equal(said.length, 1, fault);
          assert.ok(said[0].endsWith(`${why}; the processor draws small pictures.`), said[0]);
          assert.ok((await colorsOf(page, "fallback")) > 100);
        });
        assert.deepEqual(complaints, [], fault);
      }
    } finally {
      end();
    }
  });

  test("shows a simplified scene", async () => {
    const scene = films.path("scene.glb");
    lightfold("simplify", films.path("images"), "--triangles", "400", "--effort", "fast", "-o", scene, "-q");
    const { address, end } = await serveFilm(scene);
    try {
      const { complaints } = await visit("about:blank", async (page) => {
        const release = await heldFilm(page, address, "film.glb");
        assert.ok((await colorsOf(page, "scene-poster")) > 100);
        release();
        await settled(page);
        await page.locator("img.poster").waitFor({ state: "detached" });
        assert.ok((await colorsOf(page, "scene")) > 100);
      });
      assert.deepEqual(complaints, []);
    } finally {
      end();
    }
  });

  test("opens at the start of the film, of which a poster is there first", async () => {
    const { address, end } = await serveFilm(films.path("film.lfold"));
    try {
      const { complaints } = await visit("about:blank", async (page) => {
        const release = await heldFilm(page, address, "film.lfold");
        assert.ok((await colorsOf(page, "poster")) > 100);
        release();
        await settled(page);
        await page.locator("img.poster").waitFor({ state: "detached" });
        const { start } = (await (await fetch(`${address}film.json`)).json()) as { start: Record<string, number[]> };
        await page.waitForFunction(() => location.hash !== "");
        const hash = new URLSearchParams((await page.evaluate(() => location.hash)).slice(1));
        assert.deepEqual(hash.get("eye")!.split(",").map(Number), start["eye"]);
        const [x, , z] = start["look_at"]!.map((value, axis) => value - start["eye"]![axis]!);
        const yaw = (Number(hash.get("look")!.split(",")[0]) * Math.PI) / 180;
        assert.ok(Math.hypot(-Math.sin(yaw) - x!, -Math.cos(yaw) - z!) < 1e-3, `${hash}`);
      });
      assert.deepEqual(complaints, []);
      // A link with a pose has no poster.
      await visit(`${address}#look=45,0`, async (page) => {
        await settled(page);
        assert.equal(await page.locator("img.poster").count(), 0);
        assert.match(await page.evaluate(() => location.hash), /look=45,0/u);
      });
    } finally {
      end();
    }
  });

  test("opens without a server where it is one file, and says so where it is not", async () => {
    const [page, folder] = [films.path("film.html"), films.path("site")];
    lightfold("view", films.path("film.lfold"), "--export", page, "-q");
    lightfold("view", films.path("film.lfold"), "--export", folder, "-q");
    for (const renderer of ["gpu", "cpu"]) {
      const { complaints, asked } = await visit(`file://${page}#renderer=${renderer}&scale=0.25`, async (tab) => {
        await settled(tab);
        assert.ok((await colorsOf(tab, `file-${renderer}`)) > 100);
      });
      assert.deepEqual(complaints, []);
      assert.deepEqual(
        asked.filter((url) => !/^(blob|data):/u.test(url)),
        [`file://${page}`],
      );
    }
    await visit(`file://${folder}/index.html`, async (tab) => {
      await tab.locator("#notice-text").waitFor({ state: "visible" });
      assert.match(await tab.innerText("#notice"), /web server.*--export film\.html/su);
    });
  });

  test("says what a file that is no film is", async () => {
    const { address, end } = await serveFilm(films.path("film.lfold"));
    try {
      await visit(address, async (page) => {
        await page.route("**/film.json", (route) => route.fulfill({ body: "{", contentType: "application/json" }));
        await page.reload();
        await page.locator("#notice").waitFor({ state: "visible" });
        assert.match(await page.locator("#notice").innerText(), /film\.json/u);
      });
    } finally {
      end();
    }
  });
});
