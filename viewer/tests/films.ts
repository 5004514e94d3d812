// Films that the program makes for tests, and pictures that it renders of them. LIGHTFOLD names the program.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import type { Pose } from "../src/player/types.ts";
import { exrHalves, halfBits } from "./exr.ts";
import { png } from "./ui_scene.ts";

const PROGRAM = process.env["LIGHTFOLD"];

/** Reason to skip a long test whose subject shorter ones have too. */
export const atLength: string | false =
  process.env.LIGHTFOLD_TESTS === "all" ? false : "long: scripts/test all runs it";

/** Why tests that need the program cannot run here, for `skip` of node:test; `false` where they can. */
export const withoutProgram: string | false = PROGRAM === undefined ? "not run: LIGHTFOLD names no program" : false;

/** Runs the program and answers its standard output. */
export function lightfold(...args: string[]): Buffer {
  return execFileSync(PROGRAM!, args, { maxBuffer: 2 ** 28, stdio: ["ignore", "pipe", "pipe"] });
}

export interface Films {
  /** Path of a container encoded with these options, from the same images. */
  encode(name: string, ...options: string[]): string;
  /** The same with a manifest that is changed for it. */
  encodeWith(name: string, change: (manifest: Manifest, images: string) => void, ...options: string[]): string;
  path(name: string): string;
  remove(): void;
}

/** Options of a capture with materials. */
export const WITH_MATERIALS = ["--aov", "depth,material"] as const;

/** Three probes in a scene of the program, three frames each, with further options. */
export function capture(scene: string, size: number | string, ...options: string[]): Films {
  const folder = mkdtempSync(join(tmpdir(), "lightfold-viewer-"));
  const images = join(folder, "images");
  const positions = ["-0.3,1.5,0", "0.3,1.5,0", "0,1.7,0.2"].map((position) => `--position=${position}`);
  lightfold("capture", scene, ...positions, "--size", String(size), "--frames", "0-2", ...options, "-o", images, "-q");
  const path = (name: string): string => join(folder, name);
  return {
    encode: (name, ...options) => {
      lightfold("encode", images, ...options, "-o", path(name), "-q");
      return path(name);
    },
    encodeWith: (name, change, ...options) => {
      const file = join(images, "lightfield.json");
      const before = readFileSync(file, "utf8");
      const manifest = JSON.parse(before) as Manifest;
      change(manifest, images);
      writeFileSync(file, JSON.stringify(manifest));
      try {
        lightfold("encode", images, ...options, "-o", path(name), "-q");
      } finally {
        writeFileSync(file, before);
      }
      return path(name);
    },
    path,
    remove: () => rmSync(folder, { recursive: true, force: true }),
  };
}

/** What a change of a manifest sees of it. */
export interface Manifest {
  files: Record<string, string>;
  probes: Record<string, unknown>[];
}

/** Lets the first probe move to the side and turn in each frame. */
export function moving({ probes }: Manifest): void {
  const [{ position, ...probe }] = probes;
  const [x, y, z] = position as number[];
  const poses = [0, 1, 2].map((frame) => {
    const orientation = [0, Math.sin(0.05 * frame), 0, Math.cos(0.05 * frame)];
    return { frame, position: [x + 0.1 * frame, y, z], orientation };
  });
  probes[0] = { ...probe, poses };
}

/** Gives all images of `size` pixels squares of alpha, which go on in each frame. */
export function withMattes(size: number): (manifest: Manifest, images: string) => void {
  return ({ files, probes }, images) => {
    files["alpha"] = "probe_{probe}/face_{face}/matte.%04d.png";
    for (const { name } of probes) {
      for (const face of ["px", "nx", "py", "ny", "pz", "nz"]) {
        for (const frame of [0, 1, 2]) {
          const alpha = (x: number, y: number): number => [255, 128, 255, 0][((x >> 3) + (y >> 3) + frame) % 4];
          const matte = png(size, size, (x, y) => [0, 0, 0, alpha(x, y)]);
          writeFileSync(join(images, `probe_${String(name)}`, `face_${face}`, `matte.000${frame}.png`), matte);
        }
      }
    }
  };
}

/** A view for both, the page and the program. */
export interface Shot {
  pose: Pose;
  frame: number;
  size: [number, number];
  fovDeg: number;
  steps: number;
}

/** Options of `lightfold render` for a view. */
export function shotOptions({ pose: { eye, yaw, pitch }, frame, size, fovDeg, steps }: Shot): string[] {
  const forward = [-Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)];
  const target = eye.map((part, axis) => part + forward[axis]);
  const place = [`--eye=${eye.join()}`, `--look-at=${target.join()}`, "--fov", String(fovDeg)];
  return [...place, "--size", size.join("x"), "--frames", String(frame), "--steps", String(steps)];
}

/** Red, green and blue codes of a picture of the program, row by row. */
export function rendered(film: string, shot: Shot, ...options: string[]): Uint8Array {
  const output = lightfold("render", film, ...shotOptions(shot), ...options, "-o", "-", "--stream-format", "raw", "-q");
  return output.subarray(output.indexOf("\n") + 1);
}

/** Bits of the half floats of a picture of the program: linear light times alpha, and alpha, row by row. */
export function renderedHalves(film: string, shot: Shot): Uint16Array {
  const folder = mkdtempSync(join(tmpdir(), "lightfold-picture-"));
  try {
    const path = join(folder, "picture.exr");
    lightfold("render", film, ...shotOptions(shot), "-o", path, "-q");
    return exrHalves(bytesOf(path), shot.size);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

/** The same of a picture of the page. */
export function halvesOf(rgba: Float32Array): Uint16Array {
  return Uint16Array.from(rgba, (value, at) => halfBits(at % 4 === 3 ? value : Math.fround(value * rgba[at | 3])));
}

/** Stored bytes that the program reads for a picture, and its tiles and cells. */
export function readFor(film: string, shot: Shot): { bytes_read: number; cells_decoded: number } {
  const report = lightfold("render", film, ...shotOptions(shot), "--null", "--stats", "--json", "-q").toString();
  return JSON.parse(report) as { bytes_read: number; cells_decoded: number };
}

/** Codes of linear light behind the curve of sRGB. */
export function codesOf(rgba: Float32Array): Uint8Array {
  const code = (light: number): number => {
    const value = light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055;
    return Math.max(0, Math.min(255, Math.round(255 * value)));
  };
  return Uint8Array.from({ length: (rgba.length / 4) * 3 }, (_, at) => code(rgba[4 * Math.floor(at / 3) + (at % 3)]));
}

/** Peak signal to noise of 8-bit codes in dB. */
export function psnr(one: Uint8Array, other: Uint8Array): number {
  if (one.length !== other.length) {
    throw new Error(`${one.length} codes beside ${other.length}`);
  }
  const sum = one.reduce((total, code, at) => total + (code - other[at]) ** 2, 0);
  return 10 * Math.log10((255 ** 2 * one.length) / sum);
}

/** The bytes of a file. */
export function bytesOf(path: string): Uint8Array {
  return new Uint8Array(readFileSync(path));
}
