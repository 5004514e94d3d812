// The light field of the worker that renders: the program's renderer as WebAssembly, and what its functions take and give
// (src/wasm/picture.rs, src/wasm/exports.rs).

import { cameraNumbers, Instance } from "../decoder/instance.ts";
import { type ColorCoding, codingNumber } from "../views/catalogue.ts";
import { COUNTS, type Counts } from "../views/counts.ts";
import type { FaceArea, Order, PictureRequest } from "./messages.ts";
import type { PlacedView, Rendered } from "./messages.ts";

/** Functions of src/wasm/exports.rs. */
interface Functions {
  open_field(coding: number, exposureEv: number): number;
  load_view(view: number): number;
  unload_view(view: number): number;
  write_depth(...area: AreaNumbers): number;
  write_color(...area: AreaNumbers): number;
  write_material(...area: AreaNumbers): number;
  write_overlay(...area: AreaNumbers): number;
  render_picture(width: number, height: number, steps: number, marksHoles: number, showsOverlay: number): number;
}

type AreaNumbers = [view: number, face: number, left: number, top: number, width: number, height: number];

const NOTHING = new Uint8Array();

export class Field {
  readonly #wasm: Instance<Functions>;

  /** A field without views; `coding` is that of colors. */
  constructor(instance: WebAssembly.Instance, coding: ColorCoding) {
    this.#wasm = new Instance(instance);
    const exposureEv = coding.name === "light" ? 0 : coding.exposureEv;
    this.#wasm.call((wasm) => wasm.open_field(codingNumber(coding), exposureEv));
  }

  /** Does what the page orders; answers a picture where that was ordered. */
  run(order: Order): Rendered | undefined {
    const wasm = this.#wasm;
    switch (order.kind) {
      case "load":
        wasm.write(order.numbers);
        wasm.call(({ load_view }) => load_view(order.view));
        return undefined;
      case "unload":
        wasm.call(({ unload_view }) => unload_view(order.view));
        return undefined;
      case "depth":
        wasm.write(order.codes ?? NOTHING);
        wasm.call(({ write_depth }) => write_depth(...numbersOf(order.area)));
        return undefined;
      case "color":
      case "material":
      case "overlay":
        wasm.write(order.texels);
        wasm.call((functions) => functions[`write_${order.kind}`](...numbersOf(order.area)));
        return undefined;
      case "render":
        return this.#render(order.request, order.views);
    }
  }

  #render({ camera, size, steps, marksHoles, showsOverlay }: PictureRequest, views: readonly PlacedView[]): Rendered {
    const begun = performance.now();
    const places = views.flatMap(({ view, position, orientation }) => [view, ...position, ...orientation]);
    this.#wasm.write(Float64Array.of(...cameraNumbers(camera), ...places));
    this.#wasm.call(({ render_picture }) => render_picture(...size, steps, Number(marksHoles), Number(showsOverlay)));
    const words = this.#wasm.words();
    const pixels = 4 * size[0] * size[1];
    const counts = Object.fromEntries(COUNTS.map((name, at) => [name, words[pixels + at]])) as Counts;
    return { rgba: new Float32Array(words.slice(0, pixels).buffer), counts, ms: performance.now() - begun };
  }
}

function numbersOf({ view, face, rect }: FaceArea): AreaNumbers {
  return [view, face, ...rect];
}
