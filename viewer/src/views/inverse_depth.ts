// Depth codes to inverse depths. Mirrors src/render/views/inverse_depth.rs and src/codec/depth/quantise.rs (formats/depth.md 2).

import type { DepthRange } from "../format/types.ts";

const FAR_CODE = 65534;
const CODES = 65536;

/** The inverse depths of all codes in 1/m, as bits of floats; that of the background is 0. */
export function inverseDepths({ nearM, farM }: DepthRange): Uint32Array {
  const logSpan = Math.log(farM / nearM);
  const inverse = new Float32Array(CODES);
  for (let code = 0; code < FAR_CODE; code += 1) {
    inverse[code] = 1 / Math.fround(nearM * Math.exp((logSpan * code) / FAR_CODE));
  }
  inverse[0] = 1 / nearM;
  inverse[FAR_CODE] = 1 / farM;
  return new Uint32Array(inverse.buffer);
}
