// Texture blocks and color codecs against the examples of formats/ and the vectors of tests/vectors.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeBc1Block } from "../src/codec/block/bc1.ts";
import { decodeBc4Block, decodeBc5Block } from "../src/codec/block/bc4.ts";
import { decodeBc6hBlock } from "../src/codec/block/bc6h.ts";
import { decodeBc7Block } from "../src/codec/block/bc7.ts";

const BLOCKS = readFileSync("../formats/blocks.md", "utf8");

/** Cells of the rows of a table behind a comment of blocks.md. */
function examples(name: string): string[][] {
  const [, table] = BLOCKS.split(`<!-- examples: ${name} -->\n\n`);
  const lines = table.slice(0, table.indexOf("\n\n")).split("\n").slice(2);
  assert.ok(lines.length > 0);
  return lines.map((line) =>
    line
      .split("|")
      .slice(1, -1)
      .map((cell) => cell.trim()),
  );
}

/** The bytes of a cell such as `e0 fb`, with others around them. */
function blockOf(cell: string): Uint8Array {
  const bytes = cell
    .replaceAll("`", "")
    .split(" ")
    .map((byte) => parseInt(byte, 16));
  return Uint8Array.from([0xa5, ...bytes, 0xa5]);
}

test("blocks of BC1, BC4 and BC5 decode as blocks.md says", () => {
  for (const [block, ...colors] of examples("bc1")) {
    const out = new Uint8Array(48);
    decodeBc1Block(blockOf(block), 1, out);
    for (let texel = 0; texel < 16; texel++) {
      assert.equal(out.subarray(3 * texel, 3 * texel + 3).join(" "), colors[texel % 4], `${block}, pixel ${texel}`);
    }
  }
  for (const [block, values] of examples("bc4")) {
    const out = new Uint8Array(16);
    decodeBc4Block(blockOf(block), 1, out);
    assert.equal(out.join(" "), `${values} ${values}`, block);
  }
  for (const [block, pixels] of examples("bc5")) {
    const out = new Uint8Array(32);
    decodeBc5Block(blockOf(block), 1, out);
    assert.equal(out.subarray(0, 16).join(" "), pixels.replaceAll(",", ""), block);
  }
});

test("blocks of BC6H and BC7 decode as blocks.md says", () => {
  for (const [code, block, ...pixels] of examples("bc6h")) {
    const out = new Uint16Array(48).fill(1);
    decodeBc6hBlock(blockOf(block), 1, out);
    for (const [at, texel] of [0, 6, 15].entries()) {
      const shown = Array.from(out.subarray(3 * texel, 3 * texel + 3), (half) => half.toString(16).padStart(4, "0"));
      assert.equal(shown.join(" "), pixels[at], `code ${code}, pixel ${texel}`);
    }
  }
  for (const [mode, block, ...pixels] of examples("bc7")) {
    const out = new Uint8Array(48).fill(1);
    decodeBc7Block(blockOf(block), 1, out);
    for (const [at, texel] of [0, 6, 15].entries()) {
      // Alpha, the last number, is dropped.
      const color = pixels[at].split(" ").slice(0, 3).join(" ");
      assert.equal(out.subarray(3 * texel, 3 * texel + 3).join(" "), color, `mode ${mode}, pixel ${texel}`);
    }
  }
});
