// Chunks of color cells: their frames by the processor, and their form on the device (formats/color.md).

export { colorDecoder } from "./decoder.ts";
export { parseColorHeader } from "./header.ts";
export { prepareColor } from "./prepare.ts";
export { blendOf, changedPixels } from "./timeline.ts";
export { transformTables } from "./transform_tables.ts";
