// Levels of transformed blocks: channel by channel, plane by plane, from the last one back (formats/color.md 6.6).

import { colorModel } from "../../entropy.ts";
import type { RansDecoder } from "../../rans.ts";
import { CHANNELS } from "./domain.ts";
import { lengthIndex, LENGTHS } from "./basis.ts";
import type { Leaves } from "./leaves.ts";
import { MAGNITUDE_ROW, SCANS } from "./scan.ts";

/** Magnitudes are counted up to this. */
const MAX_MAGNITUDE = 15;
/** Classes of sums of five magnitudes, q of formats/color.md 6.6; that of greater sums is the last. */
export const SUM_CLASSES: Readonly<Uint8Array> = Uint8Array.of(0, 1, 2, 3, 4, 5, 5, 6, 6, 6, 6, 7);
const MAX_SUM = SUM_CLASSES.length - 1;
/** Contexts of levels at last positions, which come before those of all others. */
const LAST_LEVELS = 144;

/** Reads a number from a symbol that is above 11 and raw bits (formats/color.md 6.6, numbers). */
function largeNumber(stream: RansDecoder, symbol: number): number {
  if (symbol < 15) {
    const count = symbol - 11;
    return (1 << count) + 10 + stream.bits(count);
  }
  const count = Math.min(stream.bits(5), 22);
  return (1 << count) + 25 + stream.bits(count);
}

/** Magnitudes of a plane, of which those from `end` of the scan on are 0. */
class Magnitudes {
  readonly of = new Uint8Array(MAGNITUDE_ROW * MAGNITUDE_ROW);
  end = 0;

  clear(scan: Uint16Array): void {
    const { of, end } = this;
    for (let at = 0; at < end; at++) {
      of[scan[at]] = 0;
    }
    this.end = 0;
  }
}

/** Reads the levels of blocks into `Leaves`, and sums them up for each channel of the last block. */
export class LevelReader {
  /** Of each channel, where its levels start; then where the last ones end. */
  readonly starts = new Int32Array(CHANNELS + 1);
  /** Columns less 1 | rows less 1 << 5 of frequencies that have levels, 10 bits for each channel. */
  extents = 0;
  /** Whether no plane but the first has levels. */
  isStill = true;
  #size = 0;
  #plane = new Magnitudes();
  /** Of the plane before. */
  #before = new Magnitudes();
  /** The greatest of the first planes of the channels. */
  readonly #channels = new Magnitudes();
  readonly #contexts = colorModel().firstContext;

  /** Reads a block of a size, 0 to 3, and a legal number of frames. */
  read(stream: RansDecoder, size: number, frames: number, leaves: Leaves): void {
    this.#clear(size);
    const { planes: planesAt, coded: codedAt } = this.#contexts;
    const length = lengthIndex(frames);
    let before = 0;
    let firstClass = 0;
    for (let channel = 0; channel < CHANNELS; channel++) {
      this.starts[channel] = leaves.levelCount;
      const symbol = stream.symbol(planesAt + ((channel * 4 + size) * LENGTHS.length + length) * 3 + before);
      const planes = Math.min(symbol > 11 ? largeNumber(stream, symbol) : symbol, frames);
      if (channel === 0 || planes > 0) {
        before = Math.min(planes, 2);
      }
      let coded = 0;
      let classBefore = firstClass;
      for (let plane = 0; plane < planes; plane++) {
        const kind = frames === 1 ? 3 : Math.min(plane, 2);
        this.#nextPlane(size);
        coded = plane + 1 === planes ? 1 : stream.symbol(codedAt + ((channel * 4 + kind) * 4 + size) * 2 + coded);
        classBefore = coded === 1 ? this.#readPlane(stream, channel, [plane, kind, classBefore], leaves) : 0;
        if (plane === 0) {
          firstClass = Math.max(firstClass, classBefore);
        }
      }
    }
    this.starts[CHANNELS] = leaves.levelCount;
  }

  #clear(size: number): void {
    const { magnitudes } = SCANS[this.#size];
    this.#plane.clear(magnitudes);
    this.#before.clear(magnitudes);
    this.#channels.clear(magnitudes);
    this.#size = size;
    this.extents = 0;
    this.isStill = true;
  }

  #nextPlane(size: number): void {
    const plane = this.#before;
    this.#before = this.#plane;
    this.#plane = plane;
    plane.clear(SCANS[size].magnitudes);
  }

  /** Reads the levels of plane `plane` of kind `kind`. Returns the class of its last position; `classBefore` is that in the plane before. */
  #readPlane(stream: RansDecoder, channel: number, [plane, kind, classBefore]: number[], leaves: Leaves): number {
    const { places, magnitudes, classes } = SCANS[this.#size];
    const chroma = channel > 0 ? 1 : 0;
    const last = this.#readLast(stream, [chroma, kind, classBefore], places.length - 1);
    leaves.reserveLevels(last + 1);
    const { levels, places: levelPlaces } = leaves;
    let count = leaves.levelCount;
    const first = this.#contexts.levels + 72 * chroma + 18 * kind;
    const others = this.#contexts.levels + LAST_LEVELS + 24 * (24 * chroma + 6 * kind);
    const held = this.#plane.of;
    const channels = this.#channels.of;
    const other = plane === 0 ? channels : this.#before.of;
    let [right, bottom] = [(this.extents >> (10 * channel)) & 31, (this.extents >> (10 * channel + 5)) & 31];
    for (let at = last; at >= 0; at--) {
      const place = magnitudes[at];
      const beside = other[place] > 2 ? 2 : other[place];
      let magnitude = 0;
      if (at === last) {
        const symbol = stream.symbol(first + 3 * classes[at] + beside);
        magnitude = 1 + (symbol > 11 ? largeNumber(stream, symbol) : symbol);
      } else {
        const near = held[place + 1] + held[place + 2] + held[place + MAGNITUDE_ROW];
        const sum = near + held[place + MAGNITUDE_ROW + 1] + held[place + 2 * MAGNITUDE_ROW];
        const around = SUM_CLASSES[sum > MAX_SUM ? MAX_SUM : sum];
        const symbol = stream.symbol(others + 24 * classes[at] + 3 * around + beside);
        if (symbol === 0) {
          continue;
        }
        magnitude = symbol > 11 ? largeNumber(stream, symbol) : symbol;
      }
      const level = stream.bits(1) === 1 ? -magnitude : magnitude;
      const position = places[at];
      levels[count] = level;
      levelPlaces[count] = position | (plane << 10);
      count += 1;
      right = Math.max(right, position & 31);
      bottom = Math.max(bottom, position >> 5);
      const counted = magnitude > MAX_MAGNITUDE ? MAX_MAGNITUDE : magnitude;
      held[place] = counted;
      if (plane === 0 && channels[place] < counted) {
        channels[place] = counted;
      }
    }
    leaves.levelCount = count;
    this.#plane.end = last + 1;
    if (plane === 0) {
      this.#channels.end = Math.max(this.#channels.end, last + 1);
    } else {
      this.isStill = false;
    }
    this.extents |= (right | (bottom << 5)) << (10 * channel);
    return 32 - Math.clz32(last + 1);
  }

  /** The index in the scan of a plane's last level other than 0, at most `most`. */
  #readLast(stream: RansDecoder, [chroma, kind, classBefore]: number[], most: number): number {
    const e = stream.symbol(this.#contexts.last + 12 * (16 * chroma + 4 * this.#size + kind) + classBefore);
    if (e === 0) {
      return 0;
    }
    const a = Math.min(e, 2);
    const high = stream.symbol(this.#contexts.lastBits + 11 * chroma + e) & ((1 << a) - 1);
    const low = stream.bits(e - a);
    return Math.min((1 << e) + (high << (e - a)) + low - 1, most);
  }
}
