// A small picture of the first view, which is there before the film is: it covers the stage until the film shows the same.

import { assetUrl } from "../assets.ts";
import { byId } from "./dom.ts";
import type { FilmKind } from "./film_file.ts";

/** A picture over the stage, and over the notice that the film opens. */
export class Poster {
  readonly #image = document.createElement("img");

  /** Shows the picture at `url`, or that of its name inside the page, once it is loaded. One that fails to load is left out. */
  constructor(url: string, kind: FilmKind) {
    this.#image.className = kind === "quilt" ? "poster fits" : "poster";
    this.#image.alt = "";
    this.#image.addEventListener("error", () => this.remove());
    this.#image.src = assetUrl(url.split("/").pop() ?? "", url);
    byId("notice", HTMLElement).after(this.#image);
  }

  remove(): void {
    this.#image.remove();
  }
}
