// Decoding on the graphics device of a browser: software WebGPU of headless Chromium.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { inPageOf, withoutBrowser } from "./browser.ts";

const VECTORS = "../tests/vectors/valid";
const PAGE = "tests/gpu_decode.page.ts";

const NAMES = readdirSync(VECTORS)
  .filter((name) => name.endsWith(".lfold"))
  .map((name) => name.slice(0, -".lfold".length));

const FILES = new Map([
  ["/lightfold.wasm", readFileSync("src/decoder/lightfold.wasm")],
  ...NAMES.map((name) => [`/${name}.lfold`, readFileSync(`${VECTORS}/${name}.lfold`)] as const),
]);

/** The lines of a vector. */
function expected(name: string): string[] {
  const lines = readFileSync(`${VECTORS}/${name}.crc`, "utf8").split("\n");
  return lines.filter((line) => line !== "");
}

test("The graphics device", { skip: withoutBrowser, timeout: 300_000 }, (context) =>
  inPageOf(PAGE, FILES, async (call) => {
    await context.test("compiles all kernels without a message", async () => {
      assert.deepEqual(await call("messages"), []);
    });
    await context.test("shares the layouts of the kernel table", async () => {
      assert.deepEqual(await call("layout"), {
        words: [24, 36, 16, 4, 11],
        offsets: [0, 3, 4, 15, 16],
        middle: 28,
        values: [0x3f800000, 0x3f000000, 0xc0000000, 0xffffffff],
      });
    });
    await context.test("says what fails, and that it is lost", async () => {
      const { uncaught, tooLarge, lost } = await call<{ uncaught: boolean; tooLarge: string; lost: string }>("failing");
      assert.ok(uncaught && lost !== "");
      assert.equal(tooLarge, "pictures takes 4398046511104 bytes; the graphics device allows MOST.");
    });
    await context.test("reaches far frames in several calls, and none that are too far", async () => {
      const all = (code: number): number[] => [code, code, code, code];
      const found = await call("rounds");
      assert.deepEqual(found, { codes: [all(63), all(127), all(150)], pixels: [256, 256, 92], refused: 1 });
    });
    await context.test("does without dropped chunks, and takes them again", async () => {
      assert.deepEqual(await call("dropping"), {
        absent: 1,
        decoded: 3,
        isDropped: [false, true, 4],
        missing: 1,
        kept: [3, true, false],
        again: 5,
        words: 16,
        leftBytes: 0,
      });
    });
    for (const name of NAMES) {
      await context.test(`decodes ${name} as the CPU does`, async () => {
        for (const backward of [false, true]) {
          const { lines, alpha } = await call<{ lines: string[]; alpha: string[] }>("vector", { name, backward });
          const wanted = expected(name).filter((line) => !alpha.includes(line.split(" ")[0] ?? ""));
          assert.deepEqual(lines, wanted, backward ? "backward" : "forward");
        }
      });
    }
    assert.deepEqual(await call("uncaught"), []);
  }),
);
