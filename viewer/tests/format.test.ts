// Containers: fields, CRC-32, compression, index, attributes (formats/container.md).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decoder } from "../src/decoder/module.ts";
import { readFootage } from "../src/format/attributes.ts";
import { FileFields, quoted } from "../src/format/bytes.ts";
import { Container } from "../src/format/container.ts";
import { MemorySource } from "../src/format/memory.ts";
import { FormatError, UnsupportedError } from "../src/format/types.ts";
import { chance, NotedSource, seal, spoiled, storedChunk, valid, vectors } from "./vectors.ts";

const PLAIN_BYTES = 600;
const PLAIN_CRC32 = 1728409938;
/** The plain bytes by liblzma, with lc 3, lp 0, pb 2 and with lc 0, lp 4, pb 4. */
const LZMA2 = [
  "4AJXAJBdADgciiGV2CrbEs+YYGA7RQX8Ll51e7Jf4uSTB6Myc0+Z5mp9jD30oNka18Z8x8K4YCF2F2XVwdPv+q+KnPSuWgPZ9dbI2Jt6upRTcj+vhGiUyN4KzOD2Z" +
    "ir2yjGCzE+D+k0C/uodOBIcPUmgkW6EI93W1//MVGvbt4cMq/2z0OV8gu56Ux14oS+vkkRV4euVQAA=",
  "4AJXAJHYADgcieYjKIDMcjCbYBJjNB1Nxwo+3Ktb2UQuwAqFpEC7DqYbu4ayPURJSLy1f47xRY4oMJOb0h3UYB9eAeDUJtsY4FWavAFvUxlbD9XwAAQIAhpoOuNlp" +
    "ngW8mk09rfvDDWPXAmS9VsnqsXV6OgpsrLb4ohaKfqqYfDWaxuJW7jnyj4UtcUxgvGhvrgnkMgNm0AA",
].map(bytesOf);
/** The same by libzstd, levels 1 and 19. */
const ZSTD = [
  "KLUv/WBYAY0GAMQDcHJvYmUgZnJhbWUgY2h1bmt1bml0IAABAv8AAQL/NwABAv/64MgAAQL/TfQAAQL/7klW6ftzhGZyYW1lRyBAQqhaB/ULOw0SBh3nGhyGnUfIc" +
    "TnCfGB7YdsAHYdMNC9wBthzKIXAA8DCRsMXMBjkxhmxPiAxAJEBWRd27XQc+QCmgX9BmBu46EreiAENvALkDVgn9zfI3KCXA+Kcncte2W92MLZBQBIg56AbzimKOg" +
    "BQDxiQevCA2QCoGx6gD4AYZC3wA8DgwADJAWmcz/AS",
  "KLUv/WBYAZ0EAHQCcHJvYmUgZnJhbWUgY2h1bmt1bml0IAABAv83+uDITfTuSVbp+3OENagB9x7bARAQ4kyrDhFQFNIQoslFIlVB6UxG/lir02xBchdp7oeMvmGEi" +
    "j6E6PFECm57W9mmIBBJBGT4rdr2+CLr+5LC+DE9Wc8XLUE3K2gDGiAcw1Rgj/oflKAiv/LYPwRDPhIM9b1QBQ==",
].map(bytesOf);

function bytesOf(base64: string): Uint8Array {
  return Uint8Array.from(Buffer.from(base64, "base64"));
}

const crc32 = (bytes: Uint8Array): number => decoder().crc32(bytes);

function fieldsOf(...bytes: number[]): FileFields {
  return new FileFields(Uint8Array.from(bytes), "container.md 1", 100);
}

function open(bytes: Uint8Array): Promise<Container> {
  return Container.open(new MemorySource(bytes));
}

void test("the CRC-32 is that of the document, for any length", () => {
  const text = new TextEncoder().encode("123456789");
  assert.equal(crc32(text), 0xcbf43926);
  assert.equal(crc32(new Uint8Array(0)), 0);
  const moved = new Uint8Array(12);
  moved.set(text, 3);
  assert.equal(crc32(moved.subarray(3)), 0xcbf43926);
});

void test("fields have their values, and errors their place in the file", () => {
  const view = new DataView(new ArrayBuffer(24));
  view.setUint32(0, 7, true);
  view.setUint32(4, 0x1fffff, true);
  view.setUint32(12, 0x200000, true);
  view.setFloat64(16, Infinity, true);
  const fields = new FileFields(new Uint8Array(view.buffer), "container.md 6", 1000);
  assert.equal(fields.u64("An offset"), 0x1fffff * 2 ** 32 + 7);
  assert.throws(() => fields.u64("An offset"), /An offset is larger than any file, at byte 1008 \(container\.md 6\)/u);
  assert.throws(() => fields.finites(1, "A number"), /A number is Infinity, .* at byte 1016/u);
  assert.throws(() => fields.u8(), /at byte 1024/u);
  assert.equal(fieldsOf(0xff, 0xff, 0xff, 0xff, 0x0f).varint32(), 2 ** 32 - 1);
  assert.throws(() => fieldsOf(0xff, 0xff, 0xff, 0xff, 0x1f).varint32(), FormatError);
  assert.equal(fieldsOf(3, 0, 0xef, 0xbb, 0xbf).string("A name"), "\ufeff");
  assert.throws(() => fieldsOf(2, 0, 0xc0, 0x80).string("A name"), /A name is not UTF-8, at byte 102/u);
  assert.equal(quoted('a"\u202e\u{1f600}'), '"a"\\u{202e}\\u{1f600}"');
  assert.equal(quoted("x".repeat(50)), `"${"x".repeat(40)}..."`);
});

for (const [storage, streams] of [
  ["lzma2", LZMA2],
  ["zstd", ZSTD],
] as const) {
  void test(`${storage}: streams of another compressor decompress`, () => {
    const decompress = (stored: Uint8Array, bytes: number) => decoder().decompress(storage, stored, bytes);
    for (const stored of streams) {
      assert.equal(crc32(decompress(stored, PLAIN_BYTES)), PLAIN_CRC32);
      for (let length = 0; length < stored.length; length += 1) {
        assert.throws(() => decompress(stored.slice(0, length), PLAIN_BYTES), FormatError);
      }
      assert.throws(() => decompress(stored, PLAIN_BYTES - 1), FormatError);
      assert.throws(() => decompress(stored, PLAIN_BYTES + 1), FormatError);
      assert.throws(() => decompress(Uint8Array.from([...stored, 0]), PLAIN_BYTES), /1 bytes follow the end of .*\.$/u);
    }
  });
}

void test("changed streams decompress to as many bytes or are refused", () => {
  const random = chance(3);
  let refused = 0;
  for (let change = 0; change < 2000; change += 1) {
    const [stored, storage] = change % 2 === 0 ? [ZSTD, "zstd" as const] : [LZMA2, "lzma2" as const];
    try {
      const changed = spoiled(stored[random(2)], random);
      assert.equal(decoder().decompress(storage, changed, PLAIN_BYTES).length, PLAIN_BYTES);
    } catch (error) {
      assert.ok(error instanceof FormatError, String(error));
      refused += 1;
    }
  }
  assert.ok(refused > 1000);
});

void test("a container opens in three reads of head, foot and index", async () => {
  for (const { name, bytes } of vectors("valid")) {
    const source = new NotedSource(new MemorySource(bytes));
    const { indexBytes } = await Container.open(source);
    const foot = bytes.length - 40;
    assert.deepEqual(
      source.reads,
      [
        [0, 16],
        [foot, 40],
        [foot - indexBytes, indexBytes],
      ],
      name,
    );
  }
});

void test("the file of the document says what the document says", async () => {
  const [, block] = readFileSync("../formats/container.md", "utf8").split("```hex\n");
  const rows = block.slice(0, block.indexOf("```")).trim().split("\n");
  const bytes = Buffer.from(
    rows
      .map((row) => row.slice(row.indexOf(":") + 1, row.indexOf("|")))
      .join("")
      .replaceAll(" ", ""),
    "hex",
  );
  const container = await open(new Uint8Array(bytes));
  const { name, fps, projection, minorVersion, indexBytes } = container;
  assert.deepEqual([name, fps, projection, minorVersion, indexBytes], ["sample", 24, "cube", 0, 103]);
  const still = { position: [0, 1.5, 0], orientation: [0, 0, 0, 1], intrinsics: [0, 0, 0, 0] };
  assert.deepEqual(container.probes, [{ name: "p", frames: [0, 1], ...still }]);
  const [{ kind, codec, face, width, height, unitWidth, headerBytes }] = container.streams;
  assert.deepEqual(
    [kind, codec, face, width, height, unitWidth, headerBytes.length],
    ["depth", "DAAB", 0, 2, 1, 8, 28],
  );
  const [{ offset, storedBytes, rawBytes, frameCount, storage }] = container.chunks;
  assert.deepEqual([offset, storedBytes, rawBytes, frameCount, storage], [16, 42, 42, 2, "raw"]);
  assert.equal((await open(valid("perspective"))).projection, "perspective");
});

void test("each frame of each unit is in one chunk, and other frames are in none", async () => {
  for (const { bytes } of vectors("valid")) {
    const container = await open(bytes);
    for (const { index, firstFrame, frameCount, width, height } of container.streams) {
      let pixels = 0;
      for (let unit = 0; unit < container.unitCount(index); unit += 1) {
        const [start, end] = container.chunksOf(index, unit);
        for (let frame = firstFrame; frame < firstFrame + Math.min(frameCount, 200); frame += 1) {
          const at = container.chunkIndex(index, unit, frame);
          const chunk = container.chunks[at];
          assert.ok(at >= start && at < end && chunk.stream === index && chunk.unit === unit);
          assert.ok(frame >= chunk.firstFrame && frame < chunk.firstFrame + chunk.frameCount);
          assert.equal(container.placeOf(at), at === end - 1 ? "last" : "inner");
        }
        const last = firstFrame + frameCount - 1;
        for (const [from, to] of [
          [0, Infinity],
          [firstFrame + 1, firstFrame + 2],
          [last, last + 9],
          [last + 1, last + 9],
        ]) {
          const found = container.chunks.slice(...container.chunksAmong(index, unit, [from, to]));
          const all = container.chunks.slice(start, end);
          const wanted = all.filter((chunk) => chunk.firstFrame <= to && chunk.firstFrame + chunk.frameCount > from);
          assert.deepEqual(found, wanted);
        }
        assert.equal(container.chunkIndex(index, unit, firstFrame - 1), -1);
        assert.equal(container.chunkIndex(index, unit, firstFrame + frameCount), -1);
        const { rect } = container.areaOf(start);
        assert.deepEqual(rect, container.unitRect(index, unit));
        pixels += rect[2] * rect[3];
      }
      assert.equal(pixels, width * height);
    }
  }
});

void test("orders of the chunk table say the same", async () => {
  const [byTime, byUnit] = await Promise.all(["index-by-time", "index-by-unit"].map((at) => open(valid(at))));
  const keys = ({ chunks }: Container) => chunks.map(({ offset: _, ...rest }) => rest);
  assert.deepEqual(keys(byTime), keys(byUnit));
  assert.notDeepEqual(byTime.chunks, byUnit.chunks);
  assert.deepEqual(byTime.probes, byUnit.probes);
});

void test("bytes behind a container are told", async () => {
  const bytes = Uint8Array.from([...valid("material"), ...new Uint8Array(300)]);
  await assert.rejects(open(bytes), /ends at byte 561, and 300 bytes follow it/u);
});

void test("a refused file of a later minor version names it", async () => {
  const bytes = valid("minor-version-of-later");
  const { minorVersion } = await open(bytes);
  assert.ok(minorVersion > 0);
  const codec = Buffer.from(bytes).indexOf("DAAB", bytes.length / 4);
  const changed = bytes.slice();
  changed.set(new TextEncoder().encode("DZZZ"), codec);
  await assert.rejects(open(seal(changed)), (error) => {
    assert.ok(error instanceof UnsupportedError);
    assert.match(error.message, new RegExp(`format version 1\\.${minorVersion} is later.*DZZZ`, "u"));
    return true;
  });
});

void test("a damaged chunk is refused before it is decompressed", async () => {
  const bytes = valid("lzma2");
  const container = await open(bytes);
  const chunk = storedChunk(container, bytes.slice(), 0);
  const [stream] = container.streams;
  const opened = decoder().openStream(stream, stream.headerBytes);
  decoder().openChunk(opened, chunk).close();
  const cut = { ...chunk, stored: chunk.stored.subarray(1) };
  assert.throws(() => decoder().openChunk(opened, cut), /CRC-32/u);
  chunk.stored[0] ^= 1;
  assert.throws(() => decoder().openChunk(opened, chunk), /CRC-32 of stream 0, unit 0, .* at byte 16/u);
  decoder().closeStream(opened);
});

void test("codecs go with their kinds", () => {
  const stream = { face: 0, width: 8, height: 8, unitWidth: 8, unitHeight: 8 };
  const read = (kind: "color" | "alpha", codec: string) =>
    decoder().openStream({ ...stream, kind, codec }, Uint8Array.of(1, 0, 0, 0)).header;
  assert.deepEqual(read("alpha", "APRD"), { kind: "alpha" });
  assert.throws(() => read("color", "APRD"), UnsupportedError);
  assert.throws(() => read("alpha", '<"\u00ff\n'), /codec '<\\"\\xff\\n'/u);
});

/** Attributes of the footage; values are lists of texts, f32, f64, u8 and u32. */
function footageOf(name: string, ...values: ["s" | "f" | "d" | "b" | "u", string | number][]) {
  const bytes = values.flatMap(([type, value]) => {
    const view = new DataView(new ArrayBuffer(8));
    const part = (count: number) => [...new Uint8Array(view.buffer, 0, count)];
    if (type === "s") {
      return [String(value).length, 0, ...new TextEncoder().encode(String(value))];
    }
    if (type === "f") {
      view.setFloat32(0, Number(value), true);
    } else if (type === "d") {
      view.setFloat64(0, Number(value), true);
    } else {
      view.setUint32(0, Number(value), true);
    }
    return part({ f: 4, d: 8, b: 1, u: 4 }[type]);
  });
  return readFootage(new Map([[name, Uint8Array.from(bytes)]]));
}

function pose(probe: string, frame: number, x: number): ["s" | "u" | "d", string | number][] {
  return [
    ["s", probe],
    ["u", frame],
    ["d", x],
    ["d", 2],
    ["d", 3],
    ["d", 0],
    ["d", 0.6],
    ["d", 0],
    ["d", 0.8],
  ];
}

function doubles(...values: number[]): ["d", number][] {
  return values.map((value) => ["d", value]);
}

/** A row of frames.missing. */
function missing(probe: string, frame: number, held: number): ["s" | "b" | "u", string | number][] {
  return [
    ["s", probe],
    ["b", 1],
    ["b", 0],
    ["u", frame],
    ["u", held],
  ];
}

void test("attributes of the footage come back", () => {
  const usual = readFootage(new Map());
  assert.deepEqual([usual.chromaticities[0], usual.clippedPixels, usual.poses.size], [0.64, undefined, 0]);
  assert.equal(footageOf("color.clipped_pixels", ["u", 5], ["u", 2]).clippedPixels, 5 + 2 * 2 ** 32);
  const missing = footageOf(
    "frames.missing",
    ...([
      ["s", "a"],
      ["b", 1],
      ["b", 6],
      ["u", 3],
      ["u", 2],
    ] as ["s" | "b" | "u", string | number][]),
    ...([
      ["s", "a"],
      ["b", 3],
      ["b", 0],
      ["u", 1],
      ["u", 0xffffffff],
    ] as ["s" | "b" | "u", string | number][]),
  );
  assert.deepEqual(missing.missingFrames, [
    { probe: "a", kind: "depth", face: 6, frame: 3, held: 2 },
    { probe: "a", kind: "alpha", face: 0, frame: 1, held: undefined },
  ]);
  const wide = [0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329];
  const found = footageOf("color.chromaticities", ...wide.map((value): ["f", number] => ["f", value]));
  assert.deepEqual(found.chromaticities, wide.map(Math.fround));
  const { poses } = footageOf("probes.poses", ...pose("a", 7, 1), ...pose("a", 9, 4), ...pose("b", 0, 5));
  assert.deepEqual(
    poses.get("a")?.map(({ frame, position }) => [frame, position[0]]),
    [
      [7, 1],
      [9, 4],
    ],
  );
  assert.deepEqual(poses.get("b")?.[0].orientation, [0, 0.6, 0, 0.8]);
  assert.equal(usual.view, undefined);
  const { view } = footageOf("view", ...doubles(0, 1.5, 2, 0, 1, -3, 50));
  assert.deepEqual(view, { eye: [0, 1.5, 2], lookAt: [0, 1, -3], fovDeg: 50 });
});

void test("attributes that break a rule are refused", () => {
  const zeros = (count: number): ["b", number][] => Array.from({ length: count }, () => ["b", 0]);
  const refused: [string, () => unknown][] = [
    ["chromaticities, cut", () => footageOf("color.chromaticities", ...zeros(31))],
    ["chromaticities of no colors", () => footageOf("color.chromaticities", ...zeros(32))],
    [
      "primaries on a line",
      () => footageOf("color.chromaticities", ...[1, 1, 2, 2, 3, 3, 4, 4].map((v): ["f", number] => ["f", v / 10])),
    ],
    ["clipped pixels, longer", () => footageOf("color.clipped_pixels", ...zeros(9))],
    ["missing frames, cut", () => footageOf("frames.missing", ...zeros(11))],
    ["kind unknown", () => footageOf("frames.missing", ["s", "a"], ["b", 4], ["b", 0], ["u", 0], ["u", 0])],
    ["face unknown", () => footageOf("frames.missing", ["s", "a"], ["b", 0], ["b", 7], ["u", 0], ["u", 0])],
    ["a missing frame twice", () => footageOf("frames.missing", ...missing("a", 3, 2), ...missing("a", 3, 1))],
    ["missing frames that descend", () => footageOf("frames.missing", ...missing("a", 3, 2), ...missing("a", 2, 1))],
    ["a missing frame of no number", () => footageOf("frames.missing", ...missing("a", 2 ** 31, 2))],
    ["a frame of no number in its place", () => footageOf("frames.missing", ...missing("a", 3, 2 ** 31))],
    ["a missing frame of no probe", () => footageOf("frames.missing", ...missing("a/b", 3, 2))],
    ["a pose in a frame of no number", () => footageOf("probes.poses", ...pose("a", 2 ** 31, 0))],
    ["poses, cut", () => footageOf("probes.poses", ...zeros(61))],
    ["poses twice", () => footageOf("probes.poses", ...pose("a", 1, 0), ...pose("a", 1, 1))],
    ["poses that descend", () => footageOf("probes.poses", ...pose("b", 1, 0), ...pose("a", 2, 0))],
    ["a view of its own eye", () => footageOf("view", ...doubles(1, 2, 3, 1, 2, 3, 50))],
    ["a view of no field", () => footageOf("view", ...doubles(1, 2, 3, 1, 2, 4, 0))],
    ["a view of all around", () => footageOf("view", ...doubles(1, 2, 3, 1, 2, 4, 180))],
    ["a view, longer", () => footageOf("view", ...doubles(1, 2, 3, 1, 2, 4, 50, 0))],
    ["a view from nowhere", () => footageOf("view", ...doubles(1, NaN, 3, 1, 2, 4, 50))],
    ["a position that is none", () => footageOf("probes.poses", ...pose("a", 1, NaN))],
  ];
  for (const [what, read] of refused) {
    assert.throws(read, FormatError, what);
  }
});

void test("probes that move stand where their poses say", async () => {
  const container = await open(valid("material"));
  const [still] = container.probes;
  const moving = footageOf("probes.poses", ...pose(still.name, 2, 7), ...pose(still.name, 5, 8));
  Object.assign(container, { footage: moving });
  assert.deepEqual(
    [1, 2, 3, 5, 6].map((frame) => container.probeAt(0, frame).position[0]),
    [still.position[0], 7, still.position[0], 8, still.position[0]],
  );
  assert.deepEqual(container.probeAt(0, 2), { ...still, position: [7, 2, 3], orientation: [0, 0.6, 0, 0.8] });
});
