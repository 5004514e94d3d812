// Runs modules in headless Chromium with software WebGPU. Nothing is written to disk.

import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { createServer } from "node:http";
import type { IncomingMessage, RequestListener, Server, ServerResponse } from "node:http";
import type { AddressInfo } from "node:net";
import { chromium } from "playwright-core";
import type { Page } from "playwright-core";

const CHROMIUM = "/usr/bin/chromium";

/** Why tests in a browser cannot run here, for `skip` of node:test; `false` where they can. */
export const withoutBrowser: string | false = existsSync(CHROMIUM) ? false : `not run: there is no ${CHROMIUM}`;

const FLAGS = [
  "--no-sandbox",
  "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader",
  // Without it drawing to a canvas loses the device.
  "--use-vulkan=swiftshader",
  "--enable-features=Vulkan",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-gpu-watchdog",
];

/** A module of tests/ with all that it imports, as one text. Paths count from the working folder, which is viewer/. */
export function bundle(entry: string): string {
  const options = ["--bundle", "--format=esm", "--target=es2022", "--loader:.wgsl=text", "--charset=utf8"];
  return execFileSync("node_modules/.bin/esbuild", [entry, ...options], { encoding: "utf8", maxBuffer: 2 ** 26 });
}

/** Paths of a server, each with its bytes or text. */
export type Files = ReadonlyMap<string, Uint8Array | string>;

const TYPES: Readonly<Record<string, string>> = { html: "text/html", js: "text/javascript", css: "text/css" };

/** Answers requests from memory; of bytes also those for one range. */
export function serve(files: Files): RequestListener {
  return (request: IncomingMessage, response: ServerResponse) => {
    const path = request.url?.split("?")[0] ?? "";
    const body = files.get(path);
    if (body === undefined) {
      response.writeHead(404).end();
      return;
    }
    const type = TYPES[path.split(".").pop() ?? ""] ?? "application/octet-stream";
    const headers = { "content-type": `${type}; charset=utf-8`, etag: '"1"' };
    const range = /^bytes=(\d+)-(\d+)$/u.exec(request.headers.range ?? "");
    if (range === null || typeof body === "string") {
      response.writeHead(200, headers).end(body);
      return;
    }
    const [first, last] = [Number(range[1]), Math.min(Number(range[2]), body.length - 1)];
    const part = body.subarray(first, last + 1);
    response.writeHead(206, { ...headers, "content-range": `bytes ${first}-${last}/${body.length}` }).end(part);
  };
}

async function listen(server: Server): Promise<string> {
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  // An address of TCP, as no other was asked for.
  const { port } = server.address() as AddressInfo;
  return `http://127.0.0.1:${port}`;
}

/** Opens an empty page, runs `use` on it, and closes the browser. Errors of the page's script are thrown. */
export async function inPage<T>(use: (page: Page) => Promise<T>): Promise<T> {
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
  try {
    // The eye does not circle by itself.
    const page = await browser.newPage({ reducedMotion: "reduce" });
    const broken = new Promise<never>((_, reject) => page.on("pageerror", reject));
    return await Promise.race([use(page), broken]);
  } finally {
    await browser.close();
  }
}

/** Opens `path` of a server of its own, and runs `use` on the page. */
export async function inBrowser<T>(answer: RequestListener, path: string, use: (page: Page) => Promise<T>): Promise<T> {
  const server = createServer(answer);
  const origin = await listen(server);
  try {
    return await inPage(async (page) => {
      await page.goto(origin + path);
      return use(page);
    });
  } finally {
    server.closeAllConnections();
    server.close();
  }
}

/** Calls a function that a page module of tests/ gives, by its name. */
export type Call = <T>(name: string, argument?: unknown) => Promise<T>;

/** A page with a module of tests/, which puts its functions into `globalThis.functions`, beside other files. */
export function pageFiles(entry: string, files: Files): Map<string, Uint8Array | string> {
  const html = `<!doctype html><title>test</title><script type="module" src="/page.js"></script>`;
  return new Map([["/index.html", html], ["/page.js", bundle(entry)], ...files]);
}

/** Opens a page of {@link pageFiles}. */
export function inPageOf<T>(entry: string, files: Files, use: (call: Call, page: Page) => Promise<T>): Promise<T> {
  return withFunctions(serve(pageFiles(entry, files)), use);
}

/** Opens /index.html of a server with the files of {@link pageFiles}. */
export function withFunctions<T>(answer: RequestListener, use: (call: Call, page: Page) => Promise<T>): Promise<T> {
  return inBrowser(answer, "/index.html", async (page) => {
    await page.waitForFunction(() => "functions" in globalThis);
    const call = <R>(name: string, argument: unknown = null): Promise<R> =>
      page.evaluate(
        ([key, value]) => {
          const { functions } = globalThis as unknown as { functions: Record<string, (argument: unknown) => R> };
          return functions[key]!(value);
        },
        [name, argument] as const,
      );
    return use(call, page);
  });
}
