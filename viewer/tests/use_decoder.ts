// The decoder under Node, which fetches no files: imported before a container is opened.

import { readFileSync } from "node:fs";
import { useModule } from "../src/decoder/module.ts";

/** Bytes of the module. */
export const MODULE = new Uint8Array(readFileSync("src/decoder/lightfold.wasm"));

useModule(new WebAssembly.Module(MODULE));
