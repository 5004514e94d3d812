// Which frame a film shows while frames are completed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { FramePacing } from "../src/player/frame_pacing.ts";

test("a film that plays completes a frame before the next one, and leaves out those that came due", () => {
  const pacing = new FramePacing();
  assert.equal(pacing.next(0, true, 0), 0);
  // Nothing else can be shown.
  assert.equal(pacing.show(false, true, 0), 0);
  assert.equal(pacing.next(0, true, 10), 0);
  assert.equal(pacing.show(true, true, 10), 0);
  assert.deepEqual([pacing.next(1, true, 40), pacing.show(false, true, 40)], [1, 0]);
  assert.deepEqual([pacing.next(2, true, 80), pacing.show(false, true, 80)], [1, 0]);
  assert.deepEqual([pacing.next(3, true, 120), pacing.show(true, true, 120)], [1, 1]);
  assert.deepEqual([pacing.next(4, true, 160), pacing.show(true, true, 160)], [4, 4]);
});

test("a late frame is shown as far as it is here, and the next one begun", () => {
  const pacing = new FramePacing();
  pacing.next(0, true, 0);
  pacing.show(true, true, 0);
  assert.deepEqual([pacing.next(1, true, 100), pacing.show(false, true, 100)], [1, 0]);
  assert.deepEqual([pacing.next(9, true, 599), pacing.show(false, true, 599)], [1, 0]);
  assert.deepEqual([pacing.next(9, true, 599), pacing.show(false, true, 600)], [1, 1]);
  assert.deepEqual([pacing.next(10, true, 640), pacing.show(false, true, 640)], [10, 1]);
});

test("a film that stands, and one that begins anew, show what is asked for", () => {
  const pacing = new FramePacing();
  pacing.next(7, true, 0);
  pacing.show(true, true, 0);
  assert.deepEqual([pacing.next(8, true, 10), pacing.show(false, true, 10)], [8, 7]);
  assert.deepEqual([pacing.next(0, true, 20), pacing.show(false, true, 20)], [0, 7]);
  assert.deepEqual([pacing.next(5, false, 30), pacing.show(false, false, 30)], [5, 5]);
});
