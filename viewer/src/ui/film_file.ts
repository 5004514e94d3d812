// film.json, which lies beside the page and names the film.

import { embeddedFile } from "../assets.ts";
import { readBody } from "../format/http.ts";
import type { Vec3 } from "../format/types.ts";
import { length, subtract } from "../math.ts";
import type { Pose } from "../player/types.ts";
import { poseOf } from "./pose.ts";
import { inRange } from "./settings.ts";

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
  /** Where to begin, unless the link has a pose; else the film says. */
  start?: Start;
  /** Absolute, of the page's origin: a small picture of the start in the first frame. */
  poster?: string;
}

/** A pose and its vertical field of view in degrees. */
export interface Start {
  pose: Pose;
  fovDeg: number;
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

function point(value: unknown, what: string): Vec3 {
  const isPoint = Array.isArray(value) && value.length === 3 && value.every((part) => Number.isFinite(part));
  if (!isPoint) {
    throw new FilmFileError(`${what}: three numbers were expected.`);
  }
  return [...value] as Vec3;
}

function startOf(value: unknown): Start {
  const start = asObject(value, "film.json, start");
  const eye = point(start.eye, "film.json, start.eye");
  const forward = subtract(point(start.look_at, "film.json, start.look_at"), eye);
  const fovDeg = start.fov_y_deg;
  if (typeof fovDeg !== "number" || !(fovDeg > 0 && fovDeg < 180)) {
    throw new FilmFileError("film.json, start.fov_y_deg: a number above 0 and below 180 was expected.");
  }
  if (!(length(forward) > 0)) {
    throw new FilmFileError("film.json, start.look_at: another point than the eye was expected.");
  }
  return { pose: poseOf(eye, forward), fovDeg: inRange("fovDeg", fovDeg) };
}

/** A path of the page's own origin, relative to the page. */
function ownUrl(value: unknown, what: string, base: string): string {
  const path = text(value, what, MAX_URL);
  const page = new URL(base);
  const isRelative =
    !/^[a-z][a-z0-9+.-]*:/i.test(path) && !/^\s|[\\\u0000-\u001f]/.test(path) && !path.startsWith("//");
  if (!isRelative || !URL.canParse(path, page)) {
    throw new FilmFileError(`${what}: a path relative to the page was expected.`);
  }
  const url = new URL(path, page);
  if (url.origin !== page.origin || url.username !== page.username || url.password !== page.password) {
    throw new FilmFileError(`${what}: the file must come from the page's own server.`);
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
    url: ownUrl(value.url, "film.json, url", base),
    name: text(value.name, "film.json, name", MAX_NAME),
    bytes: whole(value.bytes, "film.json, bytes", [0, Number.MAX_SAFE_INTEGER]),
  };
  if (value.start !== undefined) {
    film.start = startOf(value.start);
  }
  if (value.poster !== undefined) {
    film.poster = ownUrl(value.poster, "film.json, poster", base);
  }
  return kind === "quilt" ? { ...film, quilt: quiltOf(value.quilt) } : film;
}

/** Reads film.json at an address, or the one inside the page: what it says, or a FilmFileError. */
export async function fetchFilmFile(url: string): Promise<FilmFile> {
  const own = embeddedFile("film.json");
  if (own !== undefined) {
    return parseFilmFile(new TextDecoder().decode(own), url);
  }
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
