// Bytes and half floats as keys, and their channels: YCoCg-R with chroma predicted from luma (formats/color.md 6 and 6.2).

/** What differs between samples of 8 bits and half floats (formats/color.md 6). */
export interface Domain {
  isHalf: boolean;
  /** Bits of the fraction of coefficients and means. */
  fractionBits: number;
  /** Bits of the fraction of the channels of pixels where steps follow the eye. */
  fineBits: number;
  keyBits: number;
  /** The key that luma counts from. */
  middle: number;
  /** Least and greatest key that transforms show. */
  least: number;
  most: number;
}

const BYTES: Domain = { isHalf: false, fractionBits: 6, fineBits: 4, keyBits: 8, middle: 128, least: 0, most: 255 };
const HALVES: Domain = {
  isHalf: true,
  fractionBits: 0,
  fineBits: 0,
  keyBits: 16,
  middle: 0xbc00,
  least: 0x0400,
  most: 0xfbff,
};

/** The domain of `CTRH`, or of `CTR8`. */
export function domainOf(isHalf: boolean): Domain {
  return isHalf ? HALVES : BYTES;
}

/** Bits of the fraction of the channels of pixels with a set of frequency offsets (formats/color.md 6.3). */
export function pixelFraction(domain: Domain, offsetSet: number): number {
  return offsetSet > 0 ? domain.fineBits : 0;
}

/** Luma, green chroma and orange chroma of a pixel. */
export const CHANNELS = 3;

/** Slopes of chroma from luma in 16ths, -128 to 127. */
export interface Slopes {
  green: number;
  orange: number;
}

/** Chroma that is predicted from luma (formats/color.md 6.2). */
export function predictChroma(slope: number, luma: number): number {
  return (Math.imul(slope, luma) + 8) >> 4;
}

/** Writes the channels of keys of red, green and blue, at the first three numbers of `out` (formats/color.md 6.2, the reverse). */
export function channelsOf(keys: Int32Array, slopes: Slopes, domain: Domain, out: Int32Array): void {
  const [red, green, blue] = keys;
  const orange = red - blue;
  const middle = blue + (orange >> 1);
  const chroma = green - middle;
  const luma = middle + (chroma >> 1) - domain.middle;
  out[0] = luma;
  out[1] = chroma - predictChroma(slopes.green, luma);
  out[2] = orange - predictChroma(slopes.orange, luma);
}
