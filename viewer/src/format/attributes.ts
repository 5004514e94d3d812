// Attributes of a container, and what those of the footage say (formats/container.md 6.3 to 6.5).

import { FileFields, quoted } from "./bytes.ts";
import { MAX_FRAME, PROBE_NAME, readOrientation, readPosition } from "./index_tables.ts";
import { FormatError, type Quaternion, type StreamKind, type Vec3 } from "./types.ts";

const ATTRIBUTE_NAME = /^[a-z0-9_.]{1,64}$/u;
/** In place of a frame: black light, background, no material, an alpha of 0. */
const NO_FRAME = 2 ** 32 - 1;
/** Rec. 709: x and y of red, green, blue and white. */
const REC_709: readonly number[] = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329];
/** Determinants below it are those of primaries on one line. */
const MIN_DETERMINANT = 1e-9;

/** Kinds of streams by number (container.md 5). */
export const STREAM_KINDS: readonly StreamKind[] = ["color", "depth", "material", "alpha"];

/** A frame whose file was missing (container.md 6.5). */
export interface MissingFrame {
  probe: string;
  kind: StreamKind;
  /** 0 to 6. */
  face: number;
  frame: number;
  /** The frame in its place, none for black light and background. */
  held: number | undefined;
}

/** Where a moving probe stands in a frame (container.md 6.5). */
export interface FramePose {
  frame: number;
  /** Metres. */
  position: Vec3;
  orientation: Quaternion;
}

/** The camera with which players open a film (container.md 6.5). */
export interface StartView {
  /** Metres. */
  eye: Vec3;
  /** A point straight ahead. */
  lookAt: Vec3;
  /** Vertical field of view in degrees. */
  fovDeg: number;
}

/** How the footage was made (container.md 6.5). */
export interface Footage {
  /** CIE 1931 x and y of red, green, blue and white, of which color is linear light. */
  chromaticities: readonly number[];
  /** Pixels of 8-bit color that were clipped, exact up to 2^53; none where nothing is known. */
  clippedPixels: number | undefined;
  missingFrames: MissingFrame[];
  /** Poses of probes that move, by name, ascending by frame. */
  poses: ReadonlyMap<string, readonly FramePose[]>;
  /** None where the footage states none. */
  view: StartView | undefined;
}

/** Reads the attributes, which fill the rest of an index (container.md 6.3). Values are not read. */
export function readAttributes(fields: FileFields): ReadonlyMap<string, Uint8Array> {
  fields.section = "container.md 6.3";
  const attributes = new Map<string, Uint8Array>();
  let before = "";
  while (fields.remaining > 0) {
    const start = fields.at;
    const name = fields.string("An attribute's name");
    if (!ATTRIBUTE_NAME.test(name)) {
      throw fields.error(`${quoted(name)} is no name of an attribute`, start);
    }
    if (name <= before) {
      throw fields.error(`The attribute ${name} does not ascend by name`, start);
    }
    before = name;
    attributes.set(name, fields.take(fields.varint32()));
  }
  return attributes;
}

/** Reads the attributes of the footage; a value that breaks a rule is a FormatError. */
export function readFootage(attributes: ReadonlyMap<string, Uint8Array>): Footage {
  const footage: Footage = {
    chromaticities: REC_709,
    clippedPixels: undefined,
    missingFrames: [],
    poses: new Map(),
    view: undefined,
  };
  const value = (name: string) => {
    const bytes = attributes.get(name);
    return bytes && new FileFields(bytes, `container.md 6.5, ${name}`, 0);
  };
  const chromaticities = value("color.chromaticities");
  if (chromaticities) {
    footage.chromaticities = readChromaticities(chromaticities);
  }
  const clipped = value("color.clipped_pixels");
  if (clipped) {
    footage.clippedPixels = clipped.u32() + clipped.u32() * 2 ** 32;
    clipped.finish();
  }
  const missing = value("frames.missing");
  while (missing && missing.remaining > 0) {
    footage.missingFrames.push(readMissingFrame(missing, footage.missingFrames.at(-1)));
  }
  const poses = value("probes.poses");
  if (poses) {
    footage.poses = readPoses(poses);
  }
  const view = value("view");
  if (view) {
    footage.view = readView(view);
  }
  return footage;
}

function readChromaticities(fields: FileFields): number[] {
  const values = Array.from({ length: 8 }, () => fields.f32());
  fields.finish();
  const [red, green, blue, white] = [0, 2, 4, 6].map((at) => {
    const [x, y] = [values[at], values[at + 1]];
    return [x / y, 1, (1 - x - y) / y];
  });
  const isFinite = [red, green, blue, white].flat().every((value) => Number.isFinite(value));
  const determinant = tripleProduct(red, green, blue);
  const parts = [tripleProduct(white, green, blue), tripleProduct(red, white, blue), tripleProduct(red, green, white)];
  const spans = parts.every((part) => Number.isFinite(part / determinant) && part !== 0);
  if (!isFinite || !(Math.abs(determinant) >= MIN_DETERMINANT) || !spans) {
    throw new FormatError(`The chromaticities ${values.join(", ")} span no colors (${fields.section}).`);
  }
  return values;
}

/** The determinant of a matrix of three columns. */
function tripleProduct(a: number[], b: number[], c: number[]): number {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/** Reads a probe's name (container.md 4). */
function readProbeName(fields: FileFields): string {
  const start = fields.at;
  const name = fields.string("A probe's name");
  if (!PROBE_NAME.test(name)) {
    throw fields.error(`${quoted(name)} is no name of a probe`, start);
  }
  return name;
}

function checkFrame(fields: FileFields, start: number, frame: number): void {
  if (frame >= MAX_FRAME) {
    throw fields.error(`A row names frame ${frame}, frames are numbered below ${MAX_FRAME}`, start);
  }
}

/** Reads a row after `before`; rows ascend by probe, kind, face and frame. */
function readMissingFrame(fields: FileFields, before: MissingFrame | undefined): MissingFrame {
  const start = fields.at;
  const probe = readProbeName(fields);
  const [kind, face, frame, held] = [fields.u8(), fields.u8(), fields.u32(), fields.u32()];
  if (kind >= STREAM_KINDS.length || face > 6) {
    throw fields.error(`A missing frame is of kind ${kind} and face ${face}, which is unknown`, start);
  }
  const row = { probe, kind: STREAM_KINDS[kind], face, frame, held: held === NO_FRAME ? undefined : held };
  checkFrame(fields, start, frame);
  checkFrame(fields, start, row.held ?? 0);
  if (before && !ascends(keyOf(before), keyOf(row))) {
    throw fields.error("Rows of missing frames do not ascend", start);
  }
  return row;
}

function keyOf({ probe, kind, face, frame }: MissingFrame): (string | number)[] {
  return [probe, STREAM_KINDS.indexOf(kind), face, frame];
}

/** Whether a list of the same types stands before another. Names of probes are ASCII, whose order is that of their bytes. */
function ascends(before: (string | number)[], after: (string | number)[]): boolean {
  const at = before.findIndex((value, place) => value !== after[place]);
  return at >= 0 && before[at] < after[at];
}

function readPoses(fields: FileFields): ReadonlyMap<string, readonly FramePose[]> {
  const poses = new Map<string, FramePose[]>();
  let before: [string, number] | undefined;
  while (fields.remaining > 0) {
    const start = fields.at;
    const probe = readProbeName(fields);
    const frame = fields.u32();
    checkFrame(fields, start, frame);
    const position = readPosition(fields, "A position");
    const orientation = readOrientation(fields, "An orientation");
    if (before && !ascends(before, [probe, frame])) {
      throw fields.error("Rows of poses do not ascend by probe and frame", start);
    }
    before = [probe, frame];
    const known = poses.get(probe);
    if (known) {
      known.push({ frame, position, orientation });
    } else {
      poses.set(probe, [{ frame, position, orientation }]);
    }
  }
  return poses;
}

function readView(fields: FileFields): StartView {
  const eye = readPosition(fields, "An eye");
  const lookAt = readPosition(fields, "A point");
  const fovDeg = fields.f64();
  fields.finish();
  if (eye.join() === lookAt.join()) {
    throw new FormatError(`The view looks at its own eye (${fields.section}).`);
  }
  if (!(fovDeg > 0 && fovDeg < 180)) {
    throw new FormatError(`The view has a field of view of ${fovDeg} degrees (${fields.section}).`);
  }
  return { eye, lookAt, fovDeg };
}
