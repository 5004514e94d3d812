// What a decoder of predictive depth holds of a unit, and how a frame's symbols change it (formats/depth.md 15.2 to 15.7).
//
// Numbers have 32 bits and wrap where a file was made so that they overflow. A pixel is four words: its value, both slopes, and its
// class, confidence and magnitude in one.

import { depthModel } from "../entropy.ts";
import type { RansDecoder } from "../rans.ts";
import type { UnitArea } from "../types.ts";
import { BACKGROUND_CODE, FAR_CODE } from "./domain.ts";
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

/** Words of a pixel, and where they are. */
const WORDS = 4;
const GX = 1;
const GY = 2;
const STATE = 3;
/** The state of a pixel: class in bits 0 to 3, confidence in bits 4 and 5, magnitude from bit 8 on. */
const CLASS = 0xf;
const CONFIDENCE_SHIFT = 4;
const MAGNITUDE_SHIFT = 8;
const AS_PREDICTED = 2;
const ESCAPED = 5;
const OTHER_SURFACE = 6;
const KEPT = 7;
const BACKGROUND = 8;
/** As predicted, with most confidence: pixels of planes. */
const SETTLED = AS_PREDICTED | (2 << CONFIDENCE_SHIFT);

const SYMBOL_KEEP = 5;
const SYMBOL_BACKGROUND = 6;
const SYMBOL_CANDIDATE = 7;
const SYMBOL_ABOVE = 10;
const RESIDUALS = Int8Array.of(0, 1, -1, 2, -2);
/** Groups of classes of the pixel above on the right. */
const RIGHT_GROUPS = Uint8Array.of(1, 1, 0, 1, 1, 2, 2, 3, 4);
/** Share of a residual that slopes take over, by confidence, and weights of the left prediction, by both; in 256ths. */
const GAINS = Int32Array.of(256, 128, 85);
const WEIGHTS = Int32Array.of(128, 85, 64, 171, 128, 102, 192, 154, 128);
/** Magnitudes: the raw bits of each class, and its least (depth.md 15.5). */
const ESCAPE_BITS = Uint8Array.of(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7, 9, 16);
const ESCAPE_LEAST = Uint16Array.of(3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 321, 833);
const CANDIDATE_BITS = Uint8Array.of(0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 8, 9, 16);
const CANDIDATE_LEAST = Uint16Array.of(0, 1, 2, 3, 5, 7, 11, 15, 23, 31, 47, 79, 143, 271, 527, 1039);
/** Bounds from which an escape starts a surface of its own, and magnitudes from which one does at any bound. */
const LEAST_COARSE_BOUND = 50;
const LEAST_EDGE = 64;

const MIDDLE = 32768 * 256;
const FAR = FAR_CODE * 256;

/** Where a prediction comes from, and so which slopes its residual corrects. */
const ORIGIN_BOTH = 0;
const ORIGIN_LEFT = 1;
const ORIGIN_ABOVE = 2;

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
  readonly #bound: number;
  /** 2E + 1 in 256ths of a code, and in codes. */
  readonly #step: number;
  readonly #stepCodes: number;
  /** Predictions from both sides that differ by at most this are of one surface; another one is further off than `#apart`. */
  readonly #same: number;
  readonly #apart: number;
  readonly #blockSteps: PlaneSteps;
  readonly #quarterSteps: PlaneSteps;
  readonly #first = depthModel().firstContext;

  #stream: RansDecoder;
  /** 0 in the first frame of a chunk, 1 in later ones. */
  #later = 0;

  // The prediction of the pixel that is being decoded.
  #value = 0;
  #gx = 0;
  #gy = 0;
  #confidence = 0;
  #origin = ORIGIN_BOTH;
  // Other surfaces beside it: their values, and where their pixels are.
  readonly #candidateValues = new Int32Array(3);
  readonly #candidatePixels = new Int32Array(3);

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
    this.#bound = coding.bound;
    this.#stepCodes = 2 * coding.bound + 1;
    this.#step = this.#stepCodes * 256;
    this.#same = (3 * coding.bound + 2) * 256;
    this.#apart = this.#stepCodes * 640;
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
    const width = Math.min(BLOCK, this.width - x);
    const height = Math.min(BLOCK, this.height - y);
    for (let row = 0; row < height; row += 1) {
      let at = this.#at(x, y + row);
      const start = (y + row) * this.width + x;
      for (let to = start; to < start + width; to += 1) {
        let code = BACKGROUND_CODE;
        if ((pixels[at + STATE] & CLASS) !== BACKGROUND) {
          const correction = corrections === undefined ? 0 : corrections[to];
          code = Math.max(0, Math.min(FAR_CODE, ((pixels[at] + correction + 128) | 0) >> 8));
          if (levels.length > 0) {
            code = levels[Math.min(code, levels.length - 1)];
          }
        }
        picture[to] = code;
        at += WORDS;
      }
    }
  }

  // Pixels: depth.md 15.4 and 15.5.

  #readPixels(x: number, y: number, side: number): void {
    const width = Math.min(side, this.width - x);
    const bottom = Math.min(y + side, this.height);
    const corrections = this.#corrections;
    for (let row = y; row < bottom; row += 1) {
      let at = this.#at(x, row);
      const start = row * this.width + x;
      for (let place = start; place < start + width; place += 1) {
        this.#pixel(at, corrections === undefined ? 0 : corrections[place]);
        at += WORDS;
      }
    }
  }

  #pixel(at: number, correction: number): void {
    const pixels = this.#pixels;
    const above = at - this.#rowWords;
    const left = pixels[at - WORDS + STATE] & CLASS;
    const group = RIGHT_GROUPS[pixels[above + WORDS + STATE] & CLASS];
    const context = ((left * 9 + (pixels[above + STATE] & CLASS)) * 5 + group) * 2 + this.#later;
    const symbol = this.#stream.symbol(this.#first.pixel + context);
    if (symbol < SYMBOL_KEEP) {
      this.#predict(at, correction);
      const residual = RESIDUALS[symbol];
      const confidence = this.#confidence;
      if (residual !== 0) {
        this.#correctSlopes(residual);
      }
      pixels[at] = this.#value + residual * this.#step;
      pixels[at + GX] = this.#gx;
      pixels[at + GY] = this.#gy;
      pixels[at + STATE] =
        (AS_PREDICTED + residual) |
        ((confidence === 0 ? 1 : 2) << CONFIDENCE_SHIFT) |
        (Math.abs(residual) << MAGNITUDE_SHIFT);
    } else if (symbol === SYMBOL_KEEP) {
      const state = pixels[at + STATE];
      if ((state & CLASS) !== BACKGROUND) {
        pixels[at + STATE] = (state & ~CLASS) | KEPT;
      }
    } else if (symbol === SYMBOL_BACKGROUND) {
      pixels[at] = 0;
      pixels[at + GX] = 0;
      pixels[at + GY] = 0;
      pixels[at + STATE] = BACKGROUND;
    } else {
      this.#predict(at, correction);
      if (symbol < SYMBOL_ABOVE) {
        this.#otherSurface(at, correction, symbol - SYMBOL_CANDIDATE);
      } else {
        this.#escape(at, symbol === SYMBOL_ABOVE);
      }
    }
  }

  /** Predicts the pixel at `at` from its neighbours. */
  #predict(at: number, correction: number): void {
    const pixels = this.#pixels;
    const left = at - WORDS;
    const above = at - this.#rowWords;
    const stateLeft = pixels[left + STATE];
    const stateAbove = pixels[above + STATE];
    if ((stateLeft & CLASS) === BACKGROUND || (stateAbove & CLASS) === BACKGROUND) {
      this.#predictBesideBackground(at, correction);
      return;
    }
    const fromLeft = (pixels[left] + pixels[left + GX]) | 0;
    const fromAbove = (pixels[above] + pixels[above + GY]) | 0;
    const difference = (fromLeft - fromAbove) | 0;
    if (within(difference, this.#same)) {
      const confidenceLeft = (stateLeft >> CONFIDENCE_SHIFT) & 3;
      const confidenceAbove = (stateAbove >> CONFIDENCE_SHIFT) & 3;
      const weight = WEIGHTS[confidenceLeft * 3 + confidenceAbove];
      const gx = pixels[above + GX];
      const gy = pixels[above + GY];
      this.#value = inside((fromAbove + part(difference, weight)) | 0, correction);
      this.#gx = (gx + part((pixels[left + GX] - gx) | 0, weight)) | 0;
      this.#gy = (gy + part((pixels[left + GY] - gy) | 0, weight)) | 0;
      this.#confidence = confidenceLeft > confidenceAbove ? confidenceLeft : confidenceAbove;
      this.#origin = ORIGIN_BOTH;
      return;
    }
    // Where the corner leads down to the left pixel but not to the one above, the edge runs between left and here.
    const corner = above - WORDS;
    const value = pixels[corner];
    if (
      (pixels[corner + STATE] & CLASS) !== BACKGROUND &&
      within((value + pixels[corner + GY] - pixels[left]) | 0, this.#same) &&
      !within((value + pixels[corner + GX] - pixels[above]) | 0, this.#same)
    ) {
      this.#predictFrom(above, inside(fromAbove, correction), ORIGIN_ABOVE);
    } else {
      this.#predictFrom(left, inside(fromLeft, correction), ORIGIN_LEFT);
    }
  }

  #predictFrom(pixel: number, value: number, origin: number): void {
    const pixels = this.#pixels;
    this.#value = value;
    this.#gx = pixels[pixel + GX];
    this.#gy = pixels[pixel + GY];
    this.#confidence = (pixels[pixel + STATE] >> CONFIDENCE_SHIFT) & 3;
    this.#origin = origin;
  }

  #predictBesideBackground(at: number, correction: number): void {
    const pixels = this.#pixels;
    const left = at - WORDS;
    const above = at - this.#rowWords;
    const isSurface = (pixel: number): boolean => (pixels[pixel + STATE] & CLASS) !== BACKGROUND;
    if (isSurface(left)) {
      this.#predictFrom(left, this.#extended(left, 1, 0, correction), ORIGIN_LEFT);
    } else if (isSurface(above)) {
      this.#predictFrom(above, this.#extended(above, 0, 1, correction), ORIGIN_ABOVE);
    } else if (isSurface(above + WORDS)) {
      this.#predictFrom(above + WORDS, this.#extended(above + WORDS, -1, 1, correction), ORIGIN_BOTH);
    } else if (isSurface(above - WORDS)) {
      this.#predictFrom(above - WORDS, this.#extended(above - WORDS, 1, 1, correction), ORIGIN_BOTH);
    } else if (isSurface(at)) {
      this.#predictFrom(at, inside(pixels[at], correction), ORIGIN_BOTH);
    } else {
      // Slopes and confidence of background are 0.
      this.#predictFrom(at, MIDDLE - correction, ORIGIN_BOTH);
    }
  }

  /** The value of a pixel carried on by its slopes, `dx` and `dy` of -1, 0 or 1 pixel. */
  #extended(pixel: number, dx: number, dy: number, correction: number): number {
    const pixels = this.#pixels;
    return inside((pixels[pixel] + dx * pixels[pixel + GX] + dy * pixels[pixel + GY]) | 0, correction);
  }

  #correctSlopes(residual: number): void {
    const gain = Math.imul(GAINS[this.#confidence] * residual, this.#stepCodes);
    if (this.#origin === ORIGIN_BOTH) {
      this.#gx = (this.#gx + (gain >> 1)) | 0;
      this.#gy = (this.#gy + (gain >> 1)) | 0;
    } else if (this.#origin === ORIGIN_LEFT) {
      this.#gx = (this.#gx + gain) | 0;
    } else {
      this.#gy = (this.#gy + gain) | 0;
    }
  }

  /** A residual of three steps or more. */
  #escape(at: number, isAbove: boolean): void {
    const pixels = this.#pixels;
    const kind = this.#stream.symbol(this.#first.escape + this.#escapeContext(at));
    const magnitude = ESCAPE_LEAST[kind] + this.#stream.bits(ESCAPE_BITS[kind]);
    const residual = isAbove ? magnitude : -magnitude;
    pixels[at] = this.#value + Math.imul(residual, this.#step);
    let confidence = 0;
    if (this.#bound < LEAST_COARSE_BOUND && magnitude < LEAST_EDGE) {
      confidence = Math.min(this.#confidence + 1, 2);
      this.#correctSlopes(residual);
      pixels[at + GX] = this.#gx;
      pixels[at + GY] = this.#gy;
    } else {
      pixels[at + GX] = 0;
      pixels[at + GY] = 0;
    }
    pixels[at + STATE] = ESCAPED | (confidence << CONFIDENCE_SHIFT) | (Math.min(magnitude, 255) << MAGNITUDE_SHIFT);
  }

  #escapeContext(at: number): number {
    const pixels = this.#pixels;
    const above = at - this.#rowWords;
    const magnitudeLeft = pixels[at - WORDS + STATE] >> MAGNITUDE_SHIFT;
    const magnitudeAbove = pixels[above + STATE] >> MAGNITUDE_SHIFT;
    const most = Math.max(magnitudeLeft, magnitudeAbove);
    const least = Math.min(magnitudeLeft, magnitudeAbove);
    const isMoreRight = pixels[above + WORDS + STATE] >> MAGNITUDE_SHIFT > most;
    const level = most === 0 ? 0 : Math.min(11, 32 - Math.clz32(most) + (isMoreRight ? 1 : 0));
    return 3 * level + (2 * least > most ? 2 : 8 * least > most ? 1 : 0);
  }

  /** A pixel on another surface than the predicted one: entry `which` of the list of neighbours' surfaces. */
  #otherSurface(at: number, correction: number, which: number): void {
    const pixels = this.#pixels;
    const kind = this.#stream.symbol(this.#first.candidate + which);
    const magnitude = CANDIDATE_LEAST[kind] + this.#stream.bits(CANDIDATE_BITS[kind]);
    const residual = magnitude > 0 && this.#stream.bits(1) === 1 ? -magnitude : magnitude;
    const isFound = which < this.#findSurfaces(at, correction);
    const surface = isFound ? this.#candidatePixels[which] : at - WORDS;
    const value = isFound ? this.#candidateValues[which] : this.#value;
    pixels[at] = value + Math.imul(residual, this.#step);
    pixels[at + GX] = pixels[surface + GX];
    pixels[at + GY] = pixels[surface + GY];
    const confidence = pixels[surface + STATE] & (3 << CONFIDENCE_SHIFT);
    pixels[at + STATE] = OTHER_SURFACE | confidence | (Math.min(magnitude, 255) << MAGNITUDE_SHIFT);
  }

  /** Lists neighbours, carried on to here, that are apart from the prediction and from each other; answers how many. */
  #findSurfaces(at: number, correction: number): number {
    const above = at - this.#rowWords;
    let count = this.#addSurface(0, at - WORDS, this.#extended(at - WORDS, 1, 0, correction));
    count = this.#addSurface(count, above, this.#extended(above, 0, 1, correction));
    count = this.#addSurface(count, above + WORDS, this.#extended(above + WORDS, -1, 1, correction));
    return this.#addSurface(count, above - WORDS, this.#extended(above - WORDS, 1, 1, correction));
  }

  #addSurface(count: number, pixel: number, value: number): number {
    const isBackground = (this.#pixels[pixel + STATE] & CLASS) === BACKGROUND;
    if (count === 3 || isBackground || within((value - this.#value) | 0, this.#apart)) {
      return count;
    }
    for (let other = 0; other < count; other += 1) {
      if (within((value - this.#candidateValues[other]) | 0, this.#apart >> 1)) {
        return count;
      }
    }
    this.#candidateValues[count] = value;
    this.#candidatePixels[count] = pixel;
    return count + 1;
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

/** Whether |difference| ≤ limit, of differences that may have wrapped. */
function within(difference: number, limit: number): boolean {
  return (difference + limit) >>> 0 <= 2 * limit;
}

/** The share of a difference in 256ths. */
function part(difference: number, weight: number): number {
  return Math.imul(difference >> 4, weight) >> 4;
}

/** Clamps a value to those of codes 0 to 65534. */
function inside(value: number, correction: number): number {
  if (value + correction < 0) {
    return 0 - correction;
  }
  return value + correction > FAR ? FAR - correction : value;
}
