// Reading by ranges from a web server, which may misbehave.

import assert from "node:assert/strict";
import { createServer, type IncomingMessage, type ServerResponse } from "node:http";
import type { AddressInfo } from "node:net";
import { test } from "node:test";
import { Container } from "../src/format/container.ts";
import { FileChangedError, HttpSource, TransportError } from "../src/format/http.ts";
import { FormatError, UnsupportedError } from "../src/format/types.ts";
import { valid } from "./vectors.ts";

const FILE = valid("material");
const TAG = '"first"';

interface Asked {
  range: string | undefined;
  ifRange: string | undefined;
}

/** Answers as a good server does; what is given takes the place of a part of the answer. */
interface Answer {
  file?: Uint8Array;
  tag?: string | undefined;
  modified?: string;
  status?: number;
  range?: string;
  body?: Uint8Array;
  /** Bytes after which the connection is cut. */
  cut?: number;
  /** No answer ever. */
  silent?: boolean;
}

function answer(request: IncomingMessage, response: ServerResponse, given: Answer): void {
  const { file = FILE, status, silent = false } = given;
  const tag = "tag" in given ? given.tag : TAG;
  if (silent) {
    return;
  }
  const [, from, to] = /^bytes=(\d+)-(\d+)$/u.exec(request.headers.range ?? "") ?? [];
  const ifRange = request.headers["if-range"];
  const isRange = from !== undefined && (ifRange === undefined || ifRange === tag);
  const first = isRange ? Number(from) : 0;
  const last = isRange ? Math.min(Number(to), file.length - 1) : file.length - 1;
  const isBeyond = isRange && first >= file.length;
  const body = given.body ?? (isBeyond ? new Uint8Array(0) : file.subarray(first, last + 1));
  const headers: Record<string, string> = { "Content-Length": String(body.length) };
  if (isRange) {
    headers["Content-Range"] = given.range ?? `bytes ${isBeyond ? "*" : `${first}-${last}`}/${file.length}`;
  }
  if (tag !== undefined) {
    headers.ETag = tag;
  }
  if (given.modified !== undefined) {
    headers["Last-Modified"] = given.modified;
  }
  response.writeHead(status ?? (isBeyond ? 416 : isRange ? 206 : 200), headers);
  if (given.cut === undefined) {
    response.end(body);
  } else {
    response.write(body.subarray(0, given.cut), () => response.destroy());
  }
}

/** Runs with a server whose answers are given one by one, the last again and again. */
async function withServer(given: Answer[], run: (url: string, asked: Asked[]) => Promise<void>): Promise<void> {
  const asked: Asked[] = [];
  const server = createServer((request, response) => {
    const at = Math.min(asked.length, given.length - 1);
    asked.push({ range: request.headers.range, ifRange: request.headers["if-range"] as string | undefined });
    answer(request, response, given[at]);
  });
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  try {
    await run(`http://127.0.0.1:${(server.address() as AddressInfo).port}/film.lfold`, asked);
  } finally {
    server.closeAllConnections();
    await new Promise((resolve) => server.close(resolve));
  }
}

/** Opens with a good answer, then reads 100 bytes from byte 50 on with another. */
function readWith(given: Answer, opening: Answer = {}): Promise<unknown> {
  return new Promise((resolve, reject) => {
    void withServer([opening, given], async (url) => {
      const source = await HttpSource.open(url);
      await source.read(50, 100).then(resolve, reject);
    }).catch(reject);
  });
}

void test("a file is read by ranges, its first bytes once", () =>
  withServer([{}], async (url, asked) => {
    const source = await HttpSource.open(url);
    assert.equal(source.byteCount, FILE.length);
    assert.deepEqual(await source.read(0, 16), FILE.slice(0, 16));
    assert.deepEqual(await source.read(10, 20), FILE.slice(10, 30));
    assert.deepEqual(await source.read(30, 0), new Uint8Array(0));
    assert.deepEqual(await source.read(FILE.length - 1, 1), FILE.slice(-1));
    assert.deepEqual(asked, [
      { range: "bytes=0-15", ifRange: undefined },
      { range: "bytes=10-29", ifRange: TAG },
      { range: `bytes=${FILE.length - 1}-${FILE.length - 1}`, ifRange: TAG },
    ]);
    await assert.rejects(source.read(FILE.length, 1), RangeError);
  }));

void test("a container opens with three requests", () =>
  withServer([{}], async (url, asked) => {
    const container = await Container.open(await HttpSource.open(url));
    assert.equal(container.streams[0].kind, "material");
    assert.equal(asked.length, 3);
  }));

void test("a large body comes in parts", async () => {
  const large = Uint8Array.from({ length: 3_000_000 }, (_, at) => at * 7);
  await withServer([{ file: large }], async (url) => {
    const source = await HttpSource.open(url);
    assert.deepEqual(await source.read(100, 2_900_000), large.slice(100, 2_900_100));
  });
});

void test("short and empty files open, and are no containers", async () => {
  for (const file of [FILE.subarray(0, 5), new Uint8Array(0)]) {
    await withServer([{ file }], async (url) => {
      const source = await HttpSource.open(url);
      assert.equal(source.byteCount, file.length);
      await assert.rejects(Container.open(source), FormatError);
    });
  }
});

void test("a server without ranges is told at once", () =>
  withServer([{ status: 200 }], async (url) => {
    await assert.rejects(HttpSource.open(url), UnsupportedError);
  }));

void test("a server that does not open the file may be asked again", async () => {
  const answers: Answer[] = [{ status: 500 }, { status: 404 }, { range: "bytes 0-15/*" }, { range: "bytes 1-16/868" }];
  answers.push({ cut: 3 }, { body: FILE.slice(0, 17) }, { range: "" });
  for (const given of answers) {
    await withServer([given], async (url) => {
      await assert.rejects(HttpSource.open(url), TransportError, JSON.stringify(given));
    });
  }
});

void test("failures of the network and the server may be tried again", async () => {
  const answers: [Answer, RegExp][] = [
    [{ status: 500 }, /answered 500/u],
    [{ status: 503 }, /answered 503/u],
    [{ status: 404 }, /answered 404/u],
    [{ cut: 0 }, /was cut/u],
    [{ cut: 40 }, /was cut/u],
    [{ body: FILE.slice(50, 149) }, /sent 99 bytes where 100/u],
    [{ body: FILE.slice(50, 151) }, /sent more bytes where 100/u],
    [{ body: FILE }, /sent more bytes where 100/u],
    [{ body: new Uint8Array(0) }, /sent 0 bytes where 100/u],
    [{ range: `bytes 51-150/${FILE.length}` }, /bytes 51 to 150 where bytes 50 to 149/u],
    [{ range: `bytes 50-148/${FILE.length}` }, /bytes 50 to 148/u],
    [{ range: "bytes none" }, /no range/u],
    [{ status: 200 }, /answered 200/u],
  ];
  for (const [given, message] of answers) {
    await assert.rejects(readWith(given), (error) => {
      assert.ok(error instanceof TransportError, String(error));
      assert.match(error.message, message);
      return true;
    });
  }
});

void test("after a failure the same source reads on", () =>
  withServer([{}, { status: 500 }, {}], async (url) => {
    const source = await HttpSource.open(url);
    await assert.rejects(source.read(50, 10), (error) => error instanceof TransportError && error.status === 500);
    assert.deepEqual(await source.read(50, 10), FILE.slice(50, 60));
  }));

void test("a file that changed is not mixed with the one before", async () => {
  const changed = FILE.slice();
  changed.fill(7, 60);
  const longer = Uint8Array.from([...FILE, 0]);
  const [monday, tuesday] = ["Mon, 02 Jun 2025 10:00:00 GMT", "Tue, 03 Jun 2025 10:00:00 GMT"];
  const answers: [Answer, Answer][] = [
    [{}, { file: changed, tag: '"second"' }],
    [{}, { status: 206, tag: '"second"', range: `bytes 50-149/${FILE.length}`, body: changed.slice(50, 150) }],
    [{}, { file: changed, tag: undefined }],
    [{}, { status: 412 }],
    [{ tag: 'W/"1"' }, { file: changed, tag: 'W/"2"' }],
    [
      { tag: undefined, modified: monday },
      { file: changed, tag: undefined, modified: tuesday },
    ],
    [{ tag: undefined }, { file: longer, tag: undefined }],
    [{ tag: undefined }, { file: FILE.slice(0, 100), tag: undefined }],
    [{ tag: undefined }, { file: FILE.slice(0, 20), tag: undefined }],
  ];
  for (const [opening, given] of answers) {
    await assert.rejects(readWith(given, opening), FileChangedError, JSON.stringify([opening, { ...given, file: 0 }]));
  }
  await assert.doesNotReject(readWith({ tag: 'W/"1"' }, { tag: 'W/"1"' }));
  await assert.doesNotReject(readWith({ tag: undefined, modified: monday }, { tag: undefined, modified: monday }));
});

void test("a weak ETag is no condition of a range", () =>
  withServer([{ tag: 'W/"1"' }], async (url, asked) => {
    await (await HttpSource.open(url)).read(50, 10);
    assert.equal(asked[1].ifRange, undefined);
  }));

void test("a read that is given up has the reason that was given", () =>
  withServer([{}, { silent: true }], async (url) => {
    const source = await HttpSource.open(url);
    const abort = new AbortController();
    const reason = new Error("no longer in sight");
    setTimeout(() => abort.abort(reason), 20);
    await assert.rejects(source.read(50, 10, abort.signal), (error) => error === reason);
  }));

void test("a server that is not there may be there later", async () => {
  let url = "";
  await withServer([{}], (address) => {
    url = address;
    return Promise.resolve();
  });
  await assert.rejects(HttpSource.open(url), TransportError);
});
