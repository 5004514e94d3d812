// A server of films that misbehaves as it is told.

import type { IncomingMessage, RequestListener, ServerResponse } from "node:http";
import { type Files, serve } from "./browser.ts";

export type Fault = "error" | "cut" | "short" | "held" | "none";

export interface FilmServer {
  answer: RequestListener;
  /** Bytes of the film that were asked for, first and last. */
  ranges: [number, number][];
  /** The fault of a request for a range, by its number. */
  fault: (request: number) => Fault;
  /** Puts another film in the place of the first. */
  replace: (bytes: Uint8Array) => void;
  /** Sends what was held. */
  release: () => void;
}

/** Serves `film` at /film.lfold beside other files. */
export function filmServer(film: Uint8Array, files: Files): FilmServer {
  const others = serve(files);
  let bytes = film;
  let version = 1;
  let held: (() => void)[] = [];
  const server: FilmServer = {
    ranges: [],
    fault: () => "none",
    replace: (other) => {
      bytes = other;
      version += 1;
    },
    release: () => {
      held.forEach((send) => send());
      held = [];
    },
    answer: (request: IncomingMessage, response: ServerResponse) => {
      const range = /^bytes=(\d+)-(\d+)$/u.exec(request.headers.range ?? "");
      if (request.url !== "/film.lfold" || range === null) {
        others(request, response);
        return;
      }
      const [first, last] = [Number(range[1]), Math.min(Number(range[2]), bytes.length - 1)];
      const fault = server.fault(server.ranges.length);
      server.ranges.push([first, last]);
      const part = bytes.subarray(first, last + 1);
      const etag = `"${version}"`;
      const isOther = request.headers["if-range"] !== undefined && request.headers["if-range"] !== etag;
      const head = { etag, "content-type": "application/octet-stream" };
      const partial = { ...head, "content-range": `bytes ${first}-${last}/${bytes.length}` };
      if (fault === "error") {
        response.writeHead(500).end("no");
      } else if (fault === "cut") {
        response.writeHead(206, { ...partial, "content-length": part.length });
        response.write(part.subarray(0, part.length >> 1), () => response.destroy());
      } else if (fault === "short") {
        response.writeHead(206, partial).end(part.subarray(0, part.length >> 1));
      } else if (isOther) {
        response.writeHead(200, head).end(bytes);
      } else if (fault === "held") {
        held.push(() => response.writeHead(206, partial).end(part));
      } else {
        response.writeHead(206, partial).end(part);
      }
    },
  };
  return server;
}
