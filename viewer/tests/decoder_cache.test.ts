// Decoders that a worker keeps.

import assert from "node:assert/strict";
import { test } from "node:test";
import { DecoderCache } from "../src/decoder_cache.ts";

/** Asks for keys in turn; answers those whose decoders were made. */
function madeOf(cache: DecoderCache, keys: readonly string[], bytes = 10): string[] {
  const made: string[] = [];
  for (const key of keys) {
    const decoder = cache.of(key, bytes, () => {
      made.push(key);
      return { frame: () => new Uint8Array() };
    });
    assert.equal(typeof decoder.frame, "function");
  }
  return made;
}

test("a film that has more decoders than there is room for keeps as many as fit", () => {
  let now = 0;
  const cache = new DecoderCache(30, () => now);
  const all = ["a", "b", "c", "d", "e"];
  assert.deepEqual(madeOf(cache, all), all);
  for (let frame = 1; frame < 5; frame += 1) {
    now += 40;
    assert.deepEqual(madeOf(cache, all), ["d", "e"]);
  }
  // Those of another view take their places once they are no longer used.
  now += 1000;
  assert.deepEqual(madeOf(cache, ["x", "y", "x"]), ["x", "y", "x"]);
  now += 1500;
  assert.deepEqual(madeOf(cache, ["x", "y", "x", "y", "z", "z"]), ["x", "y", "z"]);
  assert.deepEqual(madeOf(cache, ["a"]), ["a"]);
});

test("what is larger than all room is not kept, and drops nothing that is in use", () => {
  const cache = new DecoderCache(30, () => 0);
  madeOf(cache, ["a", "b"]);
  assert.deepEqual(madeOf(cache, ["large", "large"], 31), ["large", "large"]);
  assert.deepEqual(madeOf(cache, ["a", "b"]), []);
});
