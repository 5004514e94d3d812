// The decoder of this page or worker: lightfold.wasm, which lies beside its script or inside the page, compiled once.

import { assetUrl } from "../assets.ts";
import { TransportError } from "../format/http.ts";
import { Decoder } from "./decoder.ts";

let compiled: WebAssembly.Module | undefined;
let current: Decoder | undefined;

/** Loads the decoder, or another instance if it has stopped; a TransportError where the server fails. */
export async function loadDecoder(): Promise<void> {
  compiled ??= await compile(assetUrl("lightfold.wasm", import.meta.url));
  if (current === undefined || current.isStopped) {
    // A page may not do it without waiting.
    current = new Decoder(await WebAssembly.instantiate(compiled));
  }
}

async function compile(url: string): Promise<WebAssembly.Module> {
  const response = await fetch(url).catch((error: unknown) => {
    throw new TransportError(
      `The decoder cannot be loaded: ${error instanceof Error ? error.message : String(error)}.`,
    );
  });
  if (!response.ok) {
    throw new TransportError(`The decoder cannot be loaded: the server answered with status ${response.status}.`);
  }
  return WebAssembly.compile(await response.arrayBuffer());
}

/** The module, for workers; {@link loadDecoder} has loaded it. */
export function decoderModule(): WebAssembly.Module {
  if (compiled === undefined) {
    throw new Error("The decoder is not loaded.");
  }
  return compiled;
}

/** Takes a module that was compiled elsewhere. */
export function useModule(module: WebAssembly.Module): void {
  compiled = module;
}

/** A new instance, in a worker. */
export function newDecoder(): Decoder {
  return new Decoder(new WebAssembly.Instance(decoderModule()));
}

/** The decoder; {@link loadDecoder} has loaded it, or {@link useModule} has its module. */
export function decoder(): Decoder {
  return (current ??= newDecoder());
}
