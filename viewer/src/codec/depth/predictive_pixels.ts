// Pixels of predictive depth: their prediction, and what a symbol makes of it (formats/depth.md 15.4 and 15.5).
//
// Numbers have 32 bits and wrap where a file was made so that they overflow. A pixel is four words: its value, both slopes, and its
// state.

import { depthModel } from "../entropy.ts";
import type { RansDecoder } from "../rans.ts";
import { FAR_CODE } from "./domain.ts";

/** Words of a pixel: its value in 256ths of a code, then these. */
export const WORDS = 4;
/** Slope to the right, in 256ths of a code for each pixel. */
export const GX = 1;
/** Slope down. */
export const GY = 2;
/** State: class, confidence and magnitude (depth.md 15.2). */
export const STATE = 3;
/** Bits of a state that are the class, 0 to 8. */
export const CLASS = 0xf;
/** Lowest bit of the two of a state that are the confidence, 0 to 2. */
export const CONFIDENCE_SHIFT = 4;
/** Lowest bit of a state's magnitude. */
const MAGNITUDE_SHIFT = 8;
/** Class of a residual of 0. */
export const AS_PREDICTED = 2;
const ESCAPED = 5;
const OTHER_SURFACE = 6;
const KEPT = 7;
/** Class, and state, of background. */
export const BACKGROUND = 8;
/** State of a pixel of a plane: as predicted, with most confidence. */
export const SETTLED = AS_PREDICTED | (2 << CONFIDENCE_SHIFT);

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
const ESCAPE_MIN = Uint16Array.of(3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 321, 833);
const CANDIDATE_BITS = Uint8Array.of(0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 8, 9, 16);
const CANDIDATE_MIN = Uint16Array.of(0, 1, 2, 3, 5, 7, 11, 15, 23, 31, 47, 79, 143, 271, 527, 1039);
/** Bounds from which an escape starts a surface of its own, and magnitudes from which one does at any bound. */
const MIN_COARSE_BOUND = 50;
const MIN_EDGE = 64;

/** Half of the codes in 256ths: what is predicted where nothing is known. */
export const MIDDLE = 32768 * 256;
const FAR = FAR_CODE * 256;

/** Where a prediction comes from, and so which slopes its residual corrects. */
const ORIGIN_BOTH = 0;
const ORIGIN_LEFT = 1;
const ORIGIN_ABOVE = 2;

/** Decodes single pixels of a unit, from those around them. */
export class PixelDecoder {
  readonly #pixels: Int32Array;
  readonly #rowWords: number;
  readonly #bound: number;
  /** 2E + 1 in 256ths of a code, and in codes. */
  readonly #step: number;
  readonly #stepCodes: number;
  /** Predictions from both sides that differ by at most this are of one surface; another one is further off than `#apart`. */
  readonly #same: number;
  readonly #apart: number;
  readonly #first = depthModel().firstContext;

  // The prediction of the pixel that is being decoded.
  #value = 0;
  #gx = 0;
  #gy = 0;
  #confidence = 0;
  #origin = ORIGIN_BOTH;
  // Other surfaces beside it: their values, and where their pixels are.
  readonly #candidateValues = new Int32Array(3);
  readonly #candidatePixels = new Int32Array(3);

  /** `pixels` has rows of `rowWords` words, and background around those that are decoded; `bound` is that of the stream. */
  constructor(pixels: Int32Array, rowWords: number, bound: number) {
    this.#pixels = pixels;
    this.#rowWords = rowWords;
    this.#bound = bound;
    this.#stepCodes = 2 * bound + 1;
    this.#step = this.#stepCodes * 256;
    this.#same = (3 * bound + 2) * 256;
    this.#apart = this.#stepCodes * 640;
  }

  /** Decodes the pixel at word `at`, of this correction, in a frame that is the first of its chunk (`later` is 0) or not (1). */
  decode(at: number, correction: number, stream: RansDecoder, later: number): void {
    const pixels = this.#pixels;
    const above = at - this.#rowWords;
    const left = pixels[at - WORDS + STATE] & CLASS;
    const group = RIGHT_GROUPS[pixels[above + WORDS + STATE] & CLASS];
    const context = ((left * 9 + (pixels[above + STATE] & CLASS)) * 5 + group) * 2 + later;
    const symbol = stream.symbol(this.#first.pixel + context);
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
        this.#otherSurface(at, correction, stream, symbol - SYMBOL_CANDIDATE);
      } else {
        this.#escape(at, stream, symbol === SYMBOL_ABOVE);
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
    this.#predictAtEdge(at, fromLeft, fromAbove, correction);
  }

  /** From the left or from above, which are of different surfaces. */
  #predictAtEdge(at: number, fromLeft: number, fromAbove: number, correction: number): void {
    const pixels = this.#pixels;
    const left = at - WORDS;
    const above = at - this.#rowWords;
    const corner = above - WORDS;
    const value = pixels[corner];
    // Where the corner leads down to the left pixel but not to the one above, the edge runs between left and here.
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
  #escape(at: number, stream: RansDecoder, isAbove: boolean): void {
    const pixels = this.#pixels;
    const kind = stream.symbol(this.#first.escape + this.#escapeContext(at));
    const magnitude = ESCAPE_MIN[kind] + stream.bits(ESCAPE_BITS[kind]);
    const residual = isAbove ? magnitude : -magnitude;
    pixels[at] = this.#value + Math.imul(residual, this.#step);
    let confidence = 0;
    if (this.#bound < MIN_COARSE_BOUND && magnitude < MIN_EDGE) {
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
  #otherSurface(at: number, correction: number, stream: RansDecoder, which: number): void {
    const pixels = this.#pixels;
    const kind = stream.symbol(this.#first.candidate + which);
    const magnitude = CANDIDATE_MIN[kind] + stream.bits(CANDIDATE_BITS[kind]);
    const residual = magnitude > 0 && stream.bits(1) === 1 ? -magnitude : magnitude;
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
