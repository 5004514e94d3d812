// From the value of a modelling function to a code: as it is, or through a logarithm in integers (formats/arithmetic.md 6 and 7).

import type { DepthDomain } from "../../format/types.ts";

/** Code of the background (depth.md 2). */
export const BACKGROUND_CODE = 65535;
/** Code of a surface at far. */
export const FAR_CODE = 65534;

/** `DepthDomain.kind` of codes as they are: `DOMAIN_LOG` of shaders/kernels.json. */
export const DOMAIN_LOG = 0;
const DOMAIN_LINEAR = 1;
/** `DepthDomain.kind` of inverse depth, the greatest one: `DOMAIN_INVERSE` of shaders/kernels.json. */
export const DOMAIN_INVERSE = 2;

/** Logarithms of 24-bit values with 8 fraction bits lie below this. */
export const MAX_LOG = 24 * 0x1000000;
/** First value beyond those of a domain, with 8 fraction bits. */
const VALUE_END = 0x1000000;

// prettier-ignore
/** log2(1 + i/256) with 24 fraction bits, to nearest, i = 0 to 256: part of the format (arithmetic.md 7). */
export const LOG2_TABLE = Uint32Array.of(
  0, 94364, 188362, 281996, 375270, 468185, 560745, 652952, 744810, 836320,
  927485, 1018309, 1108793, 1198939, 1288752, 1378232, 1467383, 1556207, 1644705, 1732882,
  1820738, 1908277, 1995500, 2082410, 2169009, 2255299, 2341283, 2426963, 2512340, 2597417,
  2682196, 2766679, 2850868, 2934766, 3018374, 3101694, 3184728, 3267478, 3349946, 3432134,
  3514044, 3595678, 3677038, 3758124, 3838941, 3919488, 3999768, 4079782, 4159533, 4239023,
  4318251, 4397222, 4475935, 4554394, 4632599, 4710552, 4788255, 4865709, 4942916, 5019878,
  5096595, 5173071, 5249305, 5325300, 5401057, 5476578, 5551864, 5626916, 5701737, 5776327,
  5850688, 5924821, 5998727, 6072409, 6145867, 6219103, 6292118, 6364913, 6437490, 6509850,
  6581994, 6653924, 6725641, 6797146, 6868440, 6939525, 7010402, 7081072, 7151536, 7221795,
  7291852, 7361706, 7431359, 7500812, 7570066, 7639123, 7707984, 7776649, 7845119, 7913397,
  7981483, 8049377, 8117082, 8184598, 8251926, 8319067, 8386022, 8452793, 8519380, 8585785,
  8652008, 8718050, 8783912, 8849596, 8915102, 8980431, 9045584, 9110562, 9175366, 9239998,
  9304457, 9368745, 9432863, 9496811, 9560591, 9624203, 9687648, 9750928, 9814042, 9876993,
  9939780, 10002404, 10064867, 10127170, 10189312, 10251295, 10313120, 10374787, 10436298, 10497652,
  10558852, 10619897, 10680789, 10741528, 10802114, 10862550, 10922835, 10982970, 11042956, 11102794,
  11162484, 11222028, 11281425, 11340677, 11399784, 11458748, 11517568, 11576245, 11634780, 11693175,
  11751428, 11809542, 11867517, 11925353, 11983051, 12040612, 12098037, 12155325, 12212479, 12269497,
  12326382, 12383133, 12439752, 12496238, 12552593, 12608817, 12664911, 12720875, 12776710, 12832416,
  12887994, 12943445, 12998770, 13053968, 13109041, 13163988, 13218811, 13273511, 13328087, 13382540,
  13436871, 13491080, 13545168, 13599135, 13652983, 13706711, 13760320, 13813810, 13867183, 13920438,
  13973576, 14026597, 14079503, 14132294, 14184969, 14237530, 14289978, 14342312, 14394532, 14446641,
  14498638, 14550523, 14602297, 14653961, 14705514, 14756958, 14808293, 14859519, 14910637, 14961648,
  15012551, 15063347, 15114037, 15164621, 15215099, 15265473, 15315742, 15365906, 15415967, 15465925,
  15515779, 15565531, 15615181, 15664730, 15714177, 15763523, 15812769, 15861915, 15910962, 15959909,
  16008758, 16057508, 16106160, 16154714, 16203172, 16251532, 16299796, 16347964, 16396036, 16444013,
  16491896, 16539683, 16587377, 16634976, 16682482, 16729896, 16777216,
);

/** log2 of a whole number, 1 to 2³⁰, with 24 fraction bits (arithmetic.md 7). */
export function integerLog2(value: number): number {
  const exponent = 31 - Math.clz32(value);
  const fraction = ((value << (31 - exponent)) << 1) >>> 9;
  const low = LOG2_TABLE[fraction >>> 15];
  const slope = LOG2_TABLE[(fraction >>> 15) + 1] - low;
  return exponent * 0x1000000 + low + ((slope * (fraction & 0x7fff) + 0x4000) >>> 15);
}

/** The code of `r`, the value of a function with 14 fraction bits, in the log domain (arithmetic.md 6). */
function logCode(r: number): number {
  const code = ((r + 0x2000) | 0) >> 14;
  return code < 0 ? 0 : code > 0xffff ? 0xffff : code;
}

/** The code of the value of a function with 14 fraction bits, 32 bits with a sign, in a domain. */
export function codeIn(domain: DepthDomain): (r: number) => number {
  const { kind, base, scale } = domain;
  if (kind === DOMAIN_LOG) {
    return logCode;
  }
  if (kind === DOMAIN_LINEAR) {
    return (r) => {
      const value = ((r + 32) | 0) >> 6;
      return value >= VALUE_END ? BACKGROUND_CODE : scaled(integerLog2(Math.max(value, 1)) - base, scale);
    };
  }
  return (r) => {
    const value = ((r + 32) | 0) >> 6;
    return value <= 0 ? BACKGROUND_CODE : scaled(base - integerLog2(Math.min(value, VALUE_END - 1)), scale);
  };
}

/** (log · scale + 2³¹) >> 32 of 64 bits, at most 65534. Both parts of the product, and their sums, are below 2⁵³. */
function scaled(log: number, scale: number): number {
  if (log <= 0) {
    return 0;
  }
  const high = log * (scale >>> 16);
  const low = log * (scale & 0xffff) + 0x80000000;
  return Math.min(Math.floor((high + Math.floor(low / 0x10000)) / 0x10000), FAR_CODE);
}
