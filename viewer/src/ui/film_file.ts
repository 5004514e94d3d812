// film.json, which lies beside the page and names the film.

import { readBody } from "../format/http.ts";

/** Kinds of files that the page shows. */
export type FilmKind = "lfold" | "glb" | "quilt";

/** The tiles of a quilt: src/footage/image_files/quilt.rs. */
export interface QuiltLayout {
  columns: number;
  rows: number;
  /** Width over height of a view as a display shows it. */
  aspect: number;
}

export interface FilmFile {
  kind: FilmKind;
  /** Absolute, of the page's origin. */
  url: string;
  /** The file's name. Plain text. */
  name: string;
  bytes: number;
  quilt?: QuiltLayout;
}

/** film.json is not as it should be, or there is none. One sentence. */
export class FilmFileError extends Error {
  override name = "FilmFileError";
}

const KINDS: readonly FilmKind[] = ["lfold", "glb", "quilt"];
/** Bytes of film.json. */
const MAX_BYTES = 65_536;
const MAX_URL = 4096;
const MAX_NAME = 1024;
/** Columns or rows of a quilt. */
const MAX_TILES = 4096;

function asObject(value: unknown, what: string): Record<string, unknown> {
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw new FilmFileError(`${what}: an object was expected.`);
  }
  return value as Record<string, unknown>;
}

function text(value: unknown, what: string, longest: number): string {
  if (typeof value !== "string" || value === "" || value.length > longest) {
    throw new FilmFileError(`${what}: a text of 1 to ${longest} characters was expected.`);
  }
  return value;
}

function whole(value: unknown, what: string, [least, greatest]: [number, number]): number {
  if (typeof value !== "number" || !Number.isInteger(value) || value < least || value > greatest) {
    throw new FilmFileError(`${what}: a whole number of ${least} to ${greatest} was expected.`);
  }
  return value;
}

/** A path of the page's own origin, relative to the page. */
function ownUrl(value: unknown, base: string): string {
  const path = text(value, "film.json, url", MAX_URL);
  const page = new URL(base);
  const isRelative =
    !/^[a-z][a-z0-9+.-]*:/i.test(path) && !/^\s|[\\\u0000-\u001f]/.test(path) && !path.startsWith("//");
  if (!isRelative || !URL.canParse(path, page)) {
    throw new FilmFileError("film.json, url: a path relative to the page was expected.");
  }
  const url = new URL(path, page);
  if (url.origin !== page.origin || url.username !== page.username || url.password !== page.password) {
    throw new FilmFileError("film.json, url: the film must come from the page's own server.");
  }
  url.hash = "";
  return url.href;
}

function quiltOf(value: unknown): QuiltLayout {
  const quilt = asObject(value, "film.json, quilt");
  const aspect = quilt.aspect;
  if (typeof aspect !== "number" || !(aspect >= 0.01 && aspect <= 100)) {
    throw new FilmFileError("film.json, quilt.aspect: a number of 0.01 to 100 was expected.");
  }
  return {
    columns: whole(quilt.columns, "film.json, quilt.columns", [1, MAX_TILES]),
    rows: whole(quilt.rows, "film.json, quilt.rows", [1, MAX_TILES]),
    aspect,
  };
}

/** Checks what film.json says. `base` is the address of film.json. */
export function parseFilmFile(json: string, base: string): FilmFile {
  let parsed: unknown;
  try {
    parsed = JSON.parse(json);
  } catch {
    throw new FilmFileError("film.json: JSON was expected.");
  }
  const value = asObject(parsed, "film.json");
  const kind = KINDS.find((known) => known === value.kind);
  if (kind === undefined) {
    throw new FilmFileError("film.json, kind: lfold, glb or quilt was expected.");
  }
  const film: FilmFile = {
    kind,
    url: ownUrl(value.url, base),
    name: text(value.name, "film.json, name", MAX_NAME),
    bytes: whole(value.bytes, "film.json, bytes", [0, Number.MAX_SAFE_INTEGER]),
  };
  return kind === "quilt" ? { ...film, quilt: quiltOf(value.quilt) } : film;
}

/** Reads film.json at an address: what it says, or a FilmFileError. */
export async function fetchFilmFile(url: string): Promise<FilmFile> {
  const unreachable = (): never => {
    throw new FilmFileError("film.json, which names the film, cannot be reached.");
  };
  const response = await fetch(url, { cache: "no-store" }).catch(unreachable);
  if (!response.ok) {
    throw new FilmFileError(`film.json, which names the film: the server answered ${response.status}.`);
  }
  const bytes = await readBody(response, MAX_BYTES).catch(unreachable);
  if (bytes.length > MAX_BYTES) {
    throw new FilmFileError("film.json is longer than any that names a film.");
  }
  return parseFilmFile(new TextDecoder().decode(bytes), url);
}
