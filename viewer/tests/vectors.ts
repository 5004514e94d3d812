// The files of tests/vectors, and small changes to them.

import { readdirSync, readFileSync } from "node:fs";
import { decoder } from "../src/decoder/module.ts";
import type { StoredChunk } from "../src/decoder/types.ts";
import type { Container } from "../src/format/container.ts";
import type { ByteSource } from "../src/format/types.ts";
import "./use_decoder.ts";

const FOLDER = "../tests/vectors";
const FOOT_BYTES = 40;

export interface Vector {
  name: string;
  bytes: Uint8Array;
  /** Lines of the file beside it. */
  lines: string[];
}

/** Vectors of a folder, by name. */
export function vectors(folder: "valid" | "invalid" | "limits"): Vector[] {
  const files = readdirSync(`${FOLDER}/${folder}`).sort();
  const names = files.filter((file) => file.endsWith(".lfold")).map((file) => file.slice(0, -".lfold".length));
  return names.map((name) => {
    const beside = `${FOLDER}/${folder}/${name}.${folder === "valid" ? "crc" : "txt"}`;
    const lines = readFileSync(beside, "utf8").split("\n");
    const bytes = new Uint8Array(readFileSync(`${FOLDER}/${folder}/${name}.lfold`));
    return { name, bytes, lines: lines.filter((line) => line !== "") };
  });
}

/** A valid vector. */
export function valid(name: string): Uint8Array {
  return new Uint8Array(readFileSync(`${FOLDER}/valid/${name}.lfold`));
}

/** A chunk of a file with its stored bytes. */
export function storedChunk(container: Container, file: Uint8Array, at: number): StoredChunk {
  const chunk = container.chunks[at];
  const stored = file.subarray(chunk.offset, chunk.offset + chunk.storedBytes);
  return { chunk, stored, area: container.areaOf(at) };
}

/** The payload of a chunk. */
export function payloadOf({ chunk, stored }: StoredChunk): Uint8Array {
  return decoder().decompress(chunk.storage, stored, chunk.rawBytes);
}

/** A chunk with another payload, which is stored raw. */
export function withPayload({ chunk, area }: StoredChunk, payload: Uint8Array): StoredChunk {
  const [rawBytes, storedBytes] = [payload.length, payload.length];
  const stored = { ...chunk, storage: "raw" as const, rawBytes, storedBytes, crc32: decoder().crc32(payload) };
  return { chunk: stored, stored: payload, area };
}

/** A source that notes its reads as [offset, count]. */
export class NotedSource implements ByteSource {
  readonly reads: [number, number][] = [];

  constructor(private readonly source: ByteSource) {}

  get byteCount(): number {
    return this.source.byteCount;
  }

  read(offset: number, count: number): Promise<Uint8Array> {
    this.reads.push([offset, count]);
    return this.source.read(offset, count);
  }
}

/** Numbers by chance, the same for the same seed: below `most`, which is at most 2^24. */
export function chance(seed: number): (most: number) => number {
  let state = seed >>> 0;
  return (most) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor(((state >>> 8) / 2 ** 24) * most);
  };
}

/** A copy with one to three bytes that are other. */
export function spoiled(bytes: Uint8Array, random: (most: number) => number): Uint8Array {
  const copy = bytes.slice();
  for (let left = 1 + random(3); left > 0 && copy.length > 0; left -= 1) {
    copy[random(copy.length)] = random(2) === 0 ? random(256) : [0, 1, 0x7f, 0x80, 0xff][random(5)];
  }
  return copy;
}

/** Where the index of a file with a whole foot lies: its first byte, and the one behind it. */
export function indexRange(file: Uint8Array): [number, number] {
  const foot = file.length - FOOT_BYTES;
  return [Number(new DataView(file.buffer, file.byteOffset).getBigUint64(foot, true)), foot];
}

/** Changes the CRC-32s of the index and the foot to those of their bytes. */
export function seal(file: Uint8Array): Uint8Array {
  const [start, foot] = indexRange(file);
  const view = new DataView(file.buffer, file.byteOffset);
  view.setUint32(foot + 16, decoder().crc32(file.subarray(start, foot)), true);
  view.setUint32(foot + 32, decoder().crc32(file.subarray(foot, foot + 32)), true);
  return file;
}

/** A file of other chunks and another index, with a foot. */
export function fileOf(stored: Uint8Array, index: Uint8Array): Uint8Array {
  const head = [0x89, 0x4c, 0x46, 0x4c, 0x44, 0x0d, 0x0a, 0x1a, 1, 0, 0, 0, 0, 0, 0, 0];
  const foot = new Uint8Array(FOOT_BYTES);
  const file = Uint8Array.from([...head, ...stored, ...index, ...foot]);
  const view = new DataView(file.buffer);
  const start = file.length - FOOT_BYTES;
  view.setBigUint64(start, BigInt(head.length + stored.length), true);
  view.setBigUint64(start + 8, BigInt(index.length), true);
  view.setBigUint64(start + 24, BigInt(file.length), true);
  file.set([0x4c, 0x46, 0x4e, 0x44], start + 36);
  return seal(file);
}
