// A quilt: views of a scene as the tiles of one PNG picture, shown as a film of its views. src/footage/image_files/quilt.rs has the layout.

import { FormatError, UnsupportedError } from "./format/types.ts";
import type { ByteSource } from "./format/types.ts";
import type { Player, PlayerStats } from "./player/types.ts";
import type { QuiltLayout } from "./ui/film_file.ts";

/** Pixels of a picture, at most: 1 GiB of memory. */
const MAX_PIXELS = 2 ** 28;
/** Bytes of a file, at most. */
const MAX_BYTES = 2 ** 30;
/** Views a second. */
const VIEW_RATE = 12;
const PNG_HEAD_BYTES = 24;
const PNG_SIGNATURE = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];

/** Linear light of a value behind the curve of sRGB. */
function lightOf(value: number): number {
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

/** Width and height of a PNG file by its first 24 bytes. `what` begins the sentence of an error. */
export function pngSize(head: Uint8Array, what: string): [number, number] {
  const view = new DataView(head.buffer, head.byteOffset, head.byteLength);
  const isPng = head.length >= PNG_HEAD_BYTES && PNG_SIGNATURE.every((byte, at) => head[at] === byte);
  if (!isPng || view.getUint32(12) !== 0x49484452) {
    throw new FormatError(`${what} is no PNG picture.`);
  }
  const size: [number, number] = [view.getUint32(16), view.getUint32(20)];
  if (size[0] === 0 || size[1] === 0 || size[0] * size[1] > MAX_PIXELS) {
    throw new UnsupportedError(`${what} has ${size[0]}x${size[1]} pixels; the player shows up to ${MAX_PIXELS}.`);
  }
  return size;
}

/** Left, top, width and height in pixels of the tile of a view: view 0 is at the bottom left, views go right, then rows go up. */
export function tileOf(view: number, layout: QuiltLayout, size: [number, number]): [number, number, number, number] {
  const width = Math.floor(size[0] / layout.columns);
  const height = Math.floor(size[1] / layout.rows);
  const row = layout.rows - 1 - Math.floor(view / layout.columns);
  return [(view % layout.columns) * width, row * height, width, height];
}

/** Width and height within a space, of the aspect of a view. */
export function fitted(space: [number, number], aspect: number): [number, number] {
  const width = Math.min(space[0], space[1] * aspect);
  return [Math.max(1, Math.round(width)), Math.max(1, Math.round(width / aspect))];
}

/** Opens a quilt as a film with a frame for each view, the leftmost first. Poses and settings do not change its pictures. */
export async function openQuilt(
  source: ByteSource,
  canvas: HTMLCanvasElement,
  { name, layout }: { name: string; layout: QuiltLayout },
): Promise<Player> {
  if (source.byteCount > MAX_BYTES) {
    throw new UnsupportedError(`The quilt has ${source.byteCount} bytes; the player reads up to ${MAX_BYTES}.`);
  }
  const start = performance.now();
  const bytes = await source.read(0, source.byteCount);
  const size = pngSize(bytes.subarray(0, PNG_HEAD_BYTES), "The quilt");
  if (size[0] < layout.columns || size[1] < layout.rows) {
    throw new FormatError(`The quilt has fewer pixels than its ${layout.columns}x${layout.rows} tiles.`);
  }
  const picture = await createImageBitmap(new Blob([bytes as BlobPart], { type: "image/png" })).catch(() => {
    throw new FormatError("The quilt is a damaged PNG picture, or one that this browser does not read.");
  });
  // A view by itself: filters would reach into its neighbors.
  const tile = document.createElement("canvas");
  [, , tile.width, tile.height] = tileOf(0, layout, size);
  const [context, tileContext] = [canvas.getContext("2d"), tile.getContext("2d")];
  if (context === null || tileContext === null) {
    throw new UnsupportedError("The browser has no memory for a picture.");
  }
  const decodeMs = performance.now() - start;
  const count = layout.columns * layout.rows;
  const origin = { eye: [0, 0, 0], yaw: 0, pitch: 0 } as const;
  const stats = (shownFrame: number): PlayerStats => ({
    counters: { views: count, width: size[0], height: size[1] },
    decodeMs,
    marchMs: 0,
    fetchRate: 0,
    bytesFetched: bytes.length,
    requests: 1,
    chunksFetched: 1,
    chunksRefetched: 0,
    cacheBytes: 4 * size[0] * size[1],
    unitsMissing: 0,
    unitsBroken: 0,
    overlayMissing: 0,
    shownFrame,
  });
  const player: Player = {
    film: {
      name,
      fileBytes: source.byteCount,
      framesPerSecond: VIEW_RATE,
      firstFrame: 0,
      frameCount: count,
      startFrame: Math.floor(count / 2),
      headBox: { least: [0, 0, 0], greatest: [0, 0, 0] },
      probes: [],
      start: { ...origin, eye: [0, 0, 0] },
      streams: [{ kind: "quilt", codec: "PNG", count, bytes: bytes.length }],
    },
    draw(view) {
      const [width, height] = fitted(view.size, layout.aspect);
      [canvas.width, canvas.height] = [width, height];
      const [left, top] = tileOf(view.frame, layout, size);
      tileContext.clearRect(0, 0, tile.width, tile.height);
      tileContext.drawImage(picture, -left, -top);
      context.imageSmoothingQuality = "high";
      context.drawImage(tile, 0, 0, width, height);
      player.onShown();
      return Promise.resolve(stats(view.frame));
    },
    settle: () => Promise.resolve(),
    fetched: () => [[0, count - 1]],
    pixels() {
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      const rgba = Float32Array.from(data, (code, at) => (at % 4 === 3 ? code / 255 : lightOf(code / 255)));
      return Promise.resolve({ size: [canvas.width, canvas.height], rgba });
    },
    onProblem: () => undefined,
    onShown: () => undefined,
    close: () => picture.close(),
  };
  return player;
}
