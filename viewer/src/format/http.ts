// A file of a web server, read by ranges (RFC 9110, 14), which may not change while it is read.

import { type ByteSource, UnsupportedError } from "./types.ts";

/** The file is another than the one that was opened: what was read and what would be read may not be mixed. The message is a sentence
 *  without its full stop. */
export class FileChangedError extends Error {
  override name = "FileChangedError";
}

/** A request failed that may succeed when it is tried again: a cut connection, an error of the server, an answer of another length. The
 *  message is a sentence without its full stop. */
export class TransportError extends Error {
  override name = "TransportError";

  /** `status` is that of the answer, if there was one. */
  constructor(
    message: string,
    readonly status?: number,
  ) {
    super(message);
  }
}

/** Bytes of the first request: the head of a container, which is then not asked for again. */
const FIRST_BYTES = 16;

/** By what a file is known again: only a strong ETag tells each change. */
interface Version {
  etag: string | null;
  lastModified: string | null;
}

/** First and last byte of an answer, none where it has none, and the size of the file. */
interface ContentRange {
  range: [number, number] | undefined;
  size: number | undefined;
}

/** A file of a web server. Each read is one request, which is not tried again. */
export class HttpSource implements ByteSource {
  private constructor(
    private readonly url: string,
    /** Size of the file. */
    readonly byteCount: number,
    private readonly version: Version,
    private readonly first: Uint8Array,
  ) {}

  /** Asks for the first 16 bytes, with which the size comes: a TransportError, or an UnsupportedError where the server does not answer
   *  requests for ranges. */
  static async open(url: string, signal?: AbortSignal): Promise<HttpSource> {
    const response = await request(url, { Range: `bytes=0-${FIRST_BYTES - 1}` }, signal);
    const { range, size } = contentRangeOf(response);
    if (response.status === 416 && size === 0) {
      await discard(response);
      return new HttpSource(url, 0, versionOf(response), new Uint8Array(0));
    }
    if (response.status === 200) {
      await discard(response);
      throw new UnsupportedError(
        "The server does not answer requests for ranges of a file, which the player needs: nginx and Apache do, python3 -m http.server does not.",
      );
    }
    try {
      checkStatus(response);
      if (size === undefined || !range || range[0] !== 0 || range[1] !== Math.min(FIRST_BYTES, size) - 1) {
        throw new TransportError("The server does not tell the size of the file, or answered with another range", 206);
      }
    } catch (error) {
      await discard(response);
      throw error;
    }
    const first = await bodyOf(response, range[1] + 1, signal);
    return new HttpSource(url, size, versionOf(response), first);
  }

  /** Exactly `count` bytes at `offset`: a FileChangedError, a TransportError, or the reason of `signal`. */
  async read(offset: number, count: number, signal?: AbortSignal): Promise<Uint8Array> {
    const last = offset + count - 1;
    if (!(offset >= 0 && count >= 0 && last < this.byteCount)) {
      throw new RangeError(`bytes ${offset} to ${last} of a file of ${this.byteCount}`);
    }
    if (last < this.first.length) {
      return this.first.slice(offset, offset + count);
    }
    if (count === 0) {
      return new Uint8Array(0);
    }
    const condition = isStrong(this.version.etag) ? { "If-Range": this.version.etag } : undefined;
    const response = await request(this.url, { Range: `bytes=${offset}-${last}`, ...condition }, signal);
    try {
      this.checkVersion(response);
      checkStatus(response);
      this.checkRange(response, offset, last);
    } catch (error) {
      await discard(response);
      throw error;
    }
    return bodyOf(response, count, signal);
  }

  /** Refuses an answer that is not of the file that was opened. */
  private checkVersion(response: Response): void {
    const { status } = response;
    if (status !== 200 && status !== 206 && status !== 412 && status !== 416) {
      return;
    }
    const { etag, lastModified } = versionOf(response);
    const { size } = contentRangeOf(response);
    const isOther =
      (etag !== null && etag !== this.version.etag) ||
      (lastModified !== null && this.version.lastModified !== null && lastModified !== this.version.lastModified) ||
      (size !== undefined && size !== this.byteCount);
    // An answer of the whole file with the same ETag is of a server that ignores ranges.
    const isWhole = status === 200 && isStrong(this.version.etag) && etag !== this.version.etag;
    // A range that lay within the file does so no more.
    const isCut = status === 412 || status === 416;
    if (isOther || isWhole || isCut) {
      throw new FileChangedError("The file on the server has changed since it was opened");
    }
  }

  private checkRange(response: Response, first: number, last: number): void {
    const { range } = contentRangeOf(response);
    if (range?.[0] !== first || range[1] !== last) {
      const found = range ? `bytes ${range[0]} to ${range[1]}` : "no range";
      throw new TransportError(`The server answered with ${found} where bytes ${first} to ${last} were asked for`, 206);
    }
  }
}

function isStrong(etag: string | null): etag is string {
  return etag !== null && etag.startsWith('"');
}

function versionOf({ headers }: Response): Version {
  return { etag: headers.get("ETag"), lastModified: headers.get("Last-Modified") };
}

/** `bytes FIRST-LAST/SIZE`, or an asterisk in the place of the range or the size. */
function contentRangeOf({ headers }: Response): ContentRange {
  const parts = /^bytes (?:(\d{1,15})-(\d{1,15})|\*)\/(?:(\d{1,15})|\*)$/u.exec(headers.get("Content-Range") ?? "");
  return {
    range: parts?.[1] === undefined ? undefined : [Number(parts[1]), Number(parts[2])],
    size: parts?.[3] === undefined ? undefined : Number(parts[3]),
  };
}

/** One request, which no cache answers: its parts could be of another version of the file. */
async function request(url: string, headers: Record<string, string>, signal?: AbortSignal): Promise<Response> {
  try {
    return await fetch(url, { headers, cache: "no-store", signal: signal ?? null });
  } catch {
    throw cutError(signal);
  }
}

/** What a failure of the network becomes: the reason of an abort, or a TransportError. */
function cutError(signal?: AbortSignal): unknown {
  return signal?.aborted ? signal.reason : new TransportError("The connection to the server failed or was cut");
}

function checkStatus({ status }: Response): void {
  if (status !== 206) {
    throw new TransportError(`The server answered ${status} where a part of the file was asked for`, status);
  }
}

async function discard(response: Response): Promise<void> {
  await response.body?.cancel().catch(() => undefined);
}

/** A body of exactly `count` bytes. */
async function bodyOf(response: Response, count: number, signal?: AbortSignal): Promise<Uint8Array> {
  const bytes = await readBody(response, count).catch(() => {
    throw cutError(signal);
  });
  if (bytes.length !== count) {
    const found = bytes.length > count ? "more" : bytes.length;
    throw new TransportError(`The server sent ${found} bytes where ${count} were asked for`);
  }
  return bytes;
}

/** The body of an answer, or its beginning, which is longer than `limit` bytes. Memory grows with what comes, and no more is read. */
export async function readBody(response: Response, limit: number): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  let length = 0;
  const reader = response.body?.getReader();
  for (let part = await reader?.read(); part && !part.done; part = await reader?.read()) {
    parts.push(part.value);
    length += part.value.length;
    if (length > limit) {
      await reader?.cancel().catch(() => undefined);
      break;
    }
  }
  if (parts.length === 1) {
    return parts[0];
  }
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
