// The page around the player of ui.page.ts, in a tab of headless Chromium.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import type { Page as Tab } from "playwright-core";
import type { Player, View } from "../src/player/types.ts";
import { bundle, inBrowser, serve } from "./browser.ts";

/** What ui.page.ts gives to tests. */
export interface Fake {
  views: View[];
  greatestActive: number;
  missing: number;
  opened: number;
  closed: number;
  player: Player;
}

/** Opens the page, and checks that it asked its own server alone, kept its policy, and ran no text of the film as code. */
export async function onPage(path: string, use: (tab: Tab) => Promise<void>): Promise<void> {
  const files = new Map([
    ["/index.html", readFileSync("src/ui/index.html", "utf8")],
    ["/style.css", readFileSync("src/ui/style.css", "utf8")],
    ["/narrow.css", readFileSync("src/ui/narrow.css", "utf8")],
    ["/viewer.js", bundle("tests/ui.page.ts")],
  ]);
  await inBrowser(serve(files), `/index.html${path}`, async (tab) => {
    const foreign: string[] = [];
    const own = new URL(tab.url()).origin;
    tab.on("request", (request) => {
      if (!request.url().startsWith(own) && !/^(blob|data):/.test(request.url())) {
        foreign.push(request.url());
      }
    });
    const complaints: string[] = [];
    tab.on("console", (message) => complaints.push(message.text()));
    await tab.waitForFunction(
      () => document.querySelector<HTMLElement>("#notice-title")?.textContent !== "" && "fake" in globalThis,
    );
    await use(tab);
    assert.deepEqual([foreign, complaints], [[], []]);
    assert.equal(
      await tab.evaluate(() => "broken" in globalThis || document.querySelector("img, b[onclick]") !== null),
      false,
    );
  });
}

export function read<T>(tab: Tab, get: (fake: Fake) => T): Promise<T> {
  return tab.evaluate(`(${get.toString()})(globalThis.fake)`) as Promise<T>;
}

export async function until(tab: Tab, holds: (fake: Fake) => boolean): Promise<void> {
  for (let tries = 0; !(await read(tab, holds)); tries += 1) {
    assert.ok(tries < 200, `never: ${holds.toString()}`);
    await tab.waitForTimeout(25);
  }
}

export function lastView(tab: Tab): Promise<View> {
  return read(tab, (fake) => fake.views[fake.views.length - 1]!);
}

/** Waits for the first picture. */
export const drawn = (fake: Fake): boolean => fake.views.length > 0;

/** What messages say. */
export function messages(tab: Tab): Promise<(string | null)[]> {
  return tab.evaluate(() => [...document.querySelectorAll(".message span")].map((part) => part.textContent));
}
