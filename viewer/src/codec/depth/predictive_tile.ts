// What a decoder of predictive depth holds of a unit, and how a frame's symbols change it (formats/depth.md 15.2 to 15.7).

import { depthModel } from "../entropy.ts";
import type { RansDecoder } from "../rans.ts";
import type { UnitArea } from "../types.ts";
import { BACKGROUND_CODE, FAR_CODE } from "./domain.ts";
import {
  AS_PREDICTED,
  BACKGROUND,
  CLASS,
  CONFIDENCE_SHIFT,
  GX,
  GY,
  MIDDLE,
  PixelDecoder,
  SETTLED,
  STATE,
  WORDS,
} from "./predictive_pixels.ts";
import { clampSlope, meanOf, moved, type Plane, PlaneSteps } from "./predictive_plane.ts";
import { correctionsOf, curvatureOf, type Curvature, type Projection } from "./projection.ts";

const BLOCK = 8;
const QUARTER = 4;

/** Modes of blocks (depth.md 15.2). Those from 4 on are planes. */
const MODE_PIXELS = 0;
const MODE_SAME = 1;
const MODE_BACKGROUND = 2;
const MODE_QUARTERS = 3;
const MODE_PLANES = 4;
/** Sources of planes: the left, above, the mean. */
const SOURCES = 3;
/** The mode of a block that does not exist. */
const OUTSIDE = 10;

/** What the header of a stream says that a tile depends on. `levels` has no codes where any may occur. */
export interface TileCoding {
  bound: number;
  projection: Projection;
  levels: Uint16Array;
}

/** A unit of predictive depth between two frames. */
export class PredictiveTile {
  readonly width: number;
  readonly height: number;
  /** Blocks of 8x8 pixels in a row. */
  readonly columns: number;
  /** Mode of each block in the frame that was decoded last; without meaning where that frame had none. */
  readonly modes: Uint8Array;
  /** Codes of the frame that was decoded last, row by row. */
  readonly picture: Uint16Array;

  /** Mode with which each block was coded last, and its plane where that is one: value and slopes. */
  readonly #contents: Uint8Array;
  readonly #planes: Int32Array;
  /** Words of a row of pixels: one of the background lies on the left of each row, one on the right, and a row above. */
  readonly #rowWords: number;
  readonly #pixels: Int32Array;
  readonly #corrections: Int32Array | undefined;
  readonly #curvature: Curvature;
  readonly #levels: Uint16Array;
  readonly #decoder: PixelDecoder;
  readonly #blockSteps: PlaneSteps;
  readonly #quarterSteps: PlaneSteps;
  readonly #first = depthModel().firstContext;

  #stream: RansDecoder;
  /** 0 in the first frame of a chunk, 1 in later ones. */
  #later = 0;

  /** The unit before its first frame, which `stream` starts with; at most 1024x1024 pixels. */
  constructor(coding: TileCoding, area: UnitArea, stream: RansDecoder) {
    [, , this.width, this.height] = area.rect;
    this.columns = Math.ceil(this.width / BLOCK);
    const blocks = this.columns * Math.ceil(this.height / BLOCK);
    this.modes = new Uint8Array(blocks);
    this.picture = new Uint16Array(this.width * this.height);
    this.#contents = new Uint8Array(blocks);
    this.#planes = new Int32Array(3 * blocks);
    this.#rowWords = WORDS * (this.width + 2);
    this.#pixels = new Int32Array(this.#rowWords * (this.height + 1));
    this.#corrections = correctionsOf(coding.projection, area);
    this.#curvature = curvatureOf(coding.projection);
    this.#levels = coding.levels;
    this.#decoder = new PixelDecoder(this.#pixels, this.#rowWords, coding.bound);
    this.#blockSteps = new PlaneSteps(coding.bound, false);
    this.#quarterSteps = new PlaneSteps(coding.bound, true);
    this.#stream = stream;
    this.restart(stream);
  }

  /** Back to before the first frame, which `stream` starts with. */
  restart(stream: RansDecoder): void {
    const pixels = this.#pixels.fill(0);
    for (let at = STATE; at < pixels.length; at += WORDS) {
      pixels[at] = BACKGROUND;
    }
    this.modes.fill(MODE_BACKGROUND);
    this.#contents.fill(MODE_BACKGROUND);
    this.#later = 0;
    this.#stream = stream;
  }

  /** Decodes the next frame; answers whether its blocks are coded. If not, it is as the one before, or background if it is the first. */
  decodeFrame(): boolean {
    const isCoded = this.#stream.symbol(this.#first.frame + this.#later) === 1;
    if (isCoded) {
      for (let block = 0; block < this.modes.length; block += 1) {
        this.#block(block);
      }
    } else if (this.#later === 0) {
      this.picture.fill(BACKGROUND_CODE);
    }
    this.#later = 1;
    return isCoded;
  }

  #block(block: number): void {
    const x = (block % this.columns) * BLOCK;
    const y = Math.floor(block / this.columns) * BLOCK;
    const mode = this.#stream.symbol(this.#modeContext(block, x, y));
    this.modes[block] = mode;
    if (mode === MODE_SAME) {
      if (this.#later === 0) {
        this.#show(x, y);
      }
      return;
    }
    if (mode === MODE_PIXELS) {
      this.#readPixels(x, y, BLOCK);
    } else if (mode === MODE_BACKGROUND) {
      this.#fillBackground(x, y);
    } else if (mode === MODE_QUARTERS) {
      this.#quarter(x, y);
      this.#quarter(x + QUARTER, y);
      this.#quarter(x, y + QUARTER);
      this.#quarter(x + QUARTER, y + QUARTER);
    } else {
      let plane = this.#planeFrom(block, x, y, (mode - MODE_PLANES) % SOURCES);
      if (mode >= MODE_PLANES + SOURCES) {
        plane = this.#blockSteps.changed(plane, this.#stream, this.#first.change);
      }
      this.#fillPlane(plane, x, y, BLOCK);
      this.#planes.set(plane, 3 * block);
    }
    this.#contents[block] = mode;
    this.#show(x, y);
  }

  #modeContext(block: number, x: number, y: number): number {
    const left = x === 0 ? OUTSIDE : this.modes[block - 1];
    const above = y === 0 ? OUTSIDE : this.modes[block - this.columns];
    const content = this.#contents[block];
    const past = this.#later === 0 ? 0 : content === MODE_PIXELS || content === MODE_QUARTERS ? 1 : 2;
    return this.#first.mode + (left * 11 + above) * 3 + past;
  }

  #quarter(x: number, y: number): void {
    if (x >= this.width || y >= this.height) {
      return;
    }
    const pixels = this.#pixels;
    const right = Math.min(x + QUARTER, this.width) - 1;
    const bottom = Math.min(y + QUARTER, this.height) - 1;
    const state = (column: number, row: number): number => pixels[this.#at(column, row) + STATE];
    const left = edge(state(x - 1, y), state(x - 1, bottom));
    const above = edge(state(x, y - 1), state(right, y - 1));
    const mode = this.#stream.symbol(this.#first.smallMode + (left * 4 + above) * 2 + this.#later);
    if (mode === 0) {
      this.#readPixels(x, y, QUARTER);
      return;
    }
    let plane = this.#quarterPlane(x, y, (mode - 1) % SOURCES);
    if (mode > SOURCES) {
      plane = this.#quarterSteps.changed(plane, this.#stream, this.#first.change);
    }
    this.#fillPlane(plane, x, y, QUARTER);
  }

  /** Where a pixel is; `x` and `y` may be -1, `x` also the width. */
  #at(x: number, y: number): number {
    return (y + 1) * this.#rowWords + (x + 1) * WORDS;
  }

  // Planes: depth.md 15.6.

  #planeFrom(block: number, x: number, y: number, source: number): Plane {
    const left = (): Plane => {
      if (x > 0 && this.#contents[block - 1] >= MODE_PLANES) {
        return moved(this.#planeOf(block - 1), [16, 0], this.#curvature);
      }
      return this.#planeOfPixel(x - 1, Math.min(y + 4, this.height - 1), [9, -1]);
    };
    const above = (): Plane => {
      if (y > 0 && this.#contents[block - this.columns] >= MODE_PLANES) {
        return moved(this.#planeOf(block - this.columns), [0, 16], this.#curvature);
      }
      return this.#planeOfPixel(Math.min(x + 4, this.width - 1), y - 1, [-1, 9]);
    };
    return source === 0 ? left() : source === 1 ? above() : meanOf(left(), above());
  }

  #planeOf(block: number): Plane {
    return [this.#planes[3 * block], this.#planes[3 * block + 1], this.#planes[3 * block + 2]];
  }

  #quarterPlane(x: number, y: number, source: number): Plane {
    const left = (): Plane => this.#planeOfPixel(x - 1, Math.min(y + 2, this.height - 1), [5, -1]);
    const above = (): Plane => this.#planeOfPixel(Math.min(x + 2, this.width - 1), y - 1, [-1, 5]);
    return source === 0 ? left() : source === 1 ? above() : meanOf(left(), above());
  }

  /** Beyond the unit all is background. */
  #planeOfPixel(x: number, y: number, by: readonly [number, number]): Plane {
    const pixels = this.#pixels;
    const at = this.#at(x, y);
    if ((pixels[at + STATE] & CLASS) === BACKGROUND) {
      return [MIDDLE, 0, 0];
    }
    return moved([pixels[at], clampSlope(pixels[at + GX]), clampSlope(pixels[at + GY])], by, this.#curvature);
  }

  #fillPlane([value, gx, gy]: Plane, x: number, y: number, side: number): void {
    const pixels = this.#pixels;
    const factor = this.#curvature.factor;
    const width = Math.min(side, this.width - x);
    const height = Math.min(side, this.height - y);
    for (let row = 0; row < height; row += 1) {
      const start = gy * (2 * row + 1 - side);
      let at = this.#at(x, y + row);
      for (let column = 0; column < width; column += 1) {
        const h = gx * (2 * column + 1 - side) + start;
        const u = Math.max(-32767, Math.min(32767, h >> 7));
        const bend = (((u * u) >>> 12) * factor) >>> 7;
        pixels[at] = value + (h >> 1) + bend;
        pixels[at + GX] = gx;
        pixels[at + GY] = gy;
        pixels[at + STATE] = SETTLED;
        at += WORDS;
      }
    }
  }

  #fillBackground(x: number, y: number): void {
    const width = Math.min(BLOCK, this.width - x);
    const height = Math.min(BLOCK, this.height - y);
    for (let row = 0; row < height; row += 1) {
      const start = this.#at(x, y + row);
      this.#pixels.fill(0, start, start + WORDS * width);
      for (let column = 0; column < width; column += 1) {
        this.#pixels[start + WORDS * column + STATE] = BACKGROUND;
      }
    }
  }

  /** Writes the codes of a block to the picture. */
  #show(x: number, y: number): void {
    const { picture } = this;
    const pixels = this.#pixels;
    const corrections = this.#corrections;
    const levels = this.#levels;
    const lastLevel = levels.length - 1;
    const width = Math.min(BLOCK, this.width - x);
    const height = Math.min(BLOCK, this.height - y);
    for (let row = 0; row < height; row += 1) {
      let at = this.#at(x, y + row);
      const start = (y + row) * this.width + x;
      for (let to = start; to < start + width; to += 1) {
        let code = BACKGROUND_CODE;
        if ((pixels[at + STATE] & CLASS) !== BACKGROUND) {
          const correction = corrections === undefined ? 0 : corrections[to];
          code = ((pixels[at] + correction + 128) | 0) >> 8;
          code = code < 0 ? 0 : code > FAR_CODE ? FAR_CODE : code;
          if (lastLevel >= 0) {
            code = levels[code < lastLevel ? code : lastLevel];
          }
        }
        picture[to] = code;
        at += WORDS;
      }
    }
  }

  #readPixels(x: number, y: number, side: number): void {
    const width = Math.min(side, this.width - x);
    const bottom = Math.min(y + side, this.height);
    const corrections = this.#corrections;
    for (let row = y; row < bottom; row += 1) {
      let at = this.#at(x, row);
      const start = row * this.width + x;
      for (let place = start; place < start + width; place += 1) {
        this.#decoder.decode(at, corrections === undefined ? 0 : corrections[place], this.#stream, this.#later);
        at += WORDS;
      }
    }
  }
}

/** Of the states of two pixels at both ends of an edge: 0, of a plane that goes on; 1, of other planes; 2, background; 3, all else. */
function edge(one: number, other: number): number {
  const first = one & CLASS;
  const last = other & CLASS;
  if (first === BACKGROUND || last === BACKGROUND) {
    return 2;
  }
  if (first !== AS_PREDICTED || last !== AS_PREDICTED) {
    return 3;
  }
  const most = 2 << CONFIDENCE_SHIFT;
  return (one & other & most) === most ? 0 : 1;
}
