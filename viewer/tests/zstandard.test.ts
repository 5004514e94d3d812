// One-bit changes of Zstandard frames: the module accepts those that are listed, as the program does
// (tests/vectors/README.md).

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { decoder } from "../src/decoder/module.ts";
import { FormatError } from "../src/format/types.ts";
import "./use_decoder.ts";

const FOLDER = "../tests/vectors/zstandard";
const NAMES = readdirSync(FOLDER).filter((name) => name.endsWith(".zst"));

function decoded(stored: Uint8Array, rawBytes: number): Uint8Array | undefined {
  try {
    return decoder().decompress("zstd", stored, rawBytes);
  } catch (error) {
    assert.ok(error instanceof FormatError, error instanceof Error ? error.stack : String(error));
    return undefined;
  }
}

assert.ok(NAMES.length > 0);
for (const name of NAMES.map((file) => file.slice(0, -".zst".length))) {
  void test(`changes of the frame ${name} decode as listed`, () => {
    const stored = new Uint8Array(readFileSync(`${FOLDER}/${name}.zst`));
    const raw = new Uint8Array(readFileSync(`${FOLDER}/${name}.raw`));
    assert.deepEqual(decoded(stored, raw.length), raw);
    let lines = "";
    for (let at = 0; at < stored.length; at += 1) {
      for (let bit = 0; bit < 8; bit += 1) {
        const changed = stored.slice();
        changed[at] ^= 1 << bit;
        const found = decoded(changed, raw.length);
        if (found) {
          lines += `${at} ${bit} ${decoder().crc32(found).toString(16).padStart(8, "0")}\n`;
        }
      }
    }
    assert.equal(lines, readFileSync(`${FOLDER}/${name}.txt`, "utf8"));
  });
}
