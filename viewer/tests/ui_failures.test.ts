// Failures of films and devices on the page, in headless Chromium, with a stand-in for the player.

import assert from "node:assert/strict";
import { test } from "node:test";
import { withoutBrowser } from "./browser.ts";
import { drawn, lastView, messages, onPage, read, until } from "./ui_tab.ts";

const skip = withoutBrowser;

test("a film that fails is loaded again: once at once, then by a button, with the same pose", { skip }, async () => {
  await onPage("#eye=0.3,1.5,0&look=45,0&frame=50", async (tab) => {
    await until(tab, drawn);
    await tab.evaluate("fake.player.onProblem({ fatal: false, message: 'The server answered <b>500</b>' })");
    await tab.evaluate("fake.views = []; fake.player.onProblem({ fatal: true, message: 'The worker failed.' })");
    await until(tab, (fake) => fake.opened === 2 && fake.views.length > 0);
    assert.equal(await read(tab, (fake) => fake.closed), 1);
    assert.deepEqual(await messages(tab), [
      "The server answered <b>500</b>.",
      "The worker failed; the film is loaded again.",
    ]);
    await tab.evaluate("fake.views = []; fake.player.onProblem({ fatal: true, message: 'The worker failed.' })");
    await tab.waitForSelector("#notice-retry:not([hidden])");
    assert.equal(await read(tab, (fake) => fake.opened), 2);
    assert.equal(await tab.textContent("#notice-text"), "The worker failed.");
    await tab.click("#notice-retry");
    await until(tab, (fake) => fake.opened === 3 && fake.views.length > 0);
    const { pose, frame } = await lastView(tab);
    assert.deepEqual([pose.eye, frame], [[0.3, 1.5, 0], 50]);
    assert.ok(Math.abs(pose.yaw - Math.PI / 4) < 1e-9);
  });
});

test("a lost device is opened again, and done without where it is lost once more", { skip }, async () => {
  await onPage("#eye=0.3,1.5,0&look=0,0&frame=50", async (tab) => {
    const lose = "fake.views = []; fake.player.onProblem({ fatal: true, isOfDevice: true, message: 'It was lost.' })";
    await until(tab, drawn);
    await tab.evaluate(lose);
    await until(tab, (fake) => fake.opened === 2 && fake.views.length > 0);
    assert.equal(await read(tab, (fake) => fake.player.renderer), "gpu");
    await tab.evaluate(lose);
    await until(tab, (fake) => fake.opened === 3 && fake.views.length > 0);
    assert.equal(await read(tab, (fake) => fake.player.renderer), "cpu");
    assert.deepEqual((await lastView(tab)).pose.eye, [0.3, 1.5, 0]);
    assert.deepEqual(await messages(tab), [
      "It was lost; the film is loaded again.",
      "It was lost; the processor draws small pictures.",
    ]);
  });
});

test("without a device, or with one that fails at once, the processor draws, and says so", { skip }, async () => {
  for (const [path, why] of [
    ["?no-webgpu", "This browser has no WebGPU"],
    ["?first-picture", "The device compiles nothing"],
  ]) {
    await onPage(`${path}#eye=0,1.5,0&look=0,0`, async (tab) => {
      const said = `${why}; the processor draws small pictures.`;
      await until(tab, drawn);
      assert.deepEqual(await messages(tab), [said]);
      assert.equal(await tab.isVisible("#notice"), false);
      assert.match((await tab.textContent("#film-facts")) ?? "", /drawn on the processor$/);
      // The choice stays with the viewer, and links open on devices elsewhere.
      await tab.waitForFunction(() => location.hash.includes("frame="));
      assert.ok(!(await tab.evaluate(() => location.hash)).includes("renderer"));
      await tab.click(".message button");
      await tab.click("#open-settings");
      assert.equal(await tab.inputValue("#renderer"), "auto");
      await tab.selectOption("#renderer", "gpu");
      await tab.waitForSelector(".message");
      await until(tab, (fake) => fake.opened === 4 && fake.player.renderer === "cpu");
      assert.deepEqual(await messages(tab), [said]);
    });
  }
});

test("nothing is said of the processor before it has drawn", { skip }, async () => {
  await onPage("?no-renderer", async (tab) => {
    await tab.waitForSelector("#notice-retry:not([hidden])");
    assert.equal(await tab.textContent("#notice-text"), "The worker failed.");
    assert.deepEqual(await messages(tab), ["The worker failed; the film is loaded again."]);
  });
});

test("a film that cannot be shown says why", { skip }, async () => {
  await onPage("?format", async (tab) => {
    await tab.waitForSelector("#notice-retry:not([hidden])");
    assert.match((await tab.textContent("#notice-text")) ?? "", /^index: chunk 3 of <b>.*lies outside of the file\.$/);
    assert.deepEqual(await messages(tab), []);
  });
});
