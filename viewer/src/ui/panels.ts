// The panels at the side, of which one is open at a time.

import { byId } from "./dom.ts";

/** Ids of sections in index.html; the button of each is `open-` and its id. */
export type PanelName = "settings" | "inspector" | "help";

const NAMES: readonly PanelName[] = ["settings", "inspector", "help"];

export class Panels {
  readonly #side = byId("side", HTMLElement);
  readonly #onChange: () => void;
  #open: PanelName | undefined;

  /** `onChange` is called when another panel is open. Escape closes the one that has the focus. */
  constructor(onChange: () => void) {
    this.#onChange = onChange;
    this.#side.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.#open !== undefined) {
        const button = byId(`open-${this.#open}`, HTMLButtonElement);
        this.toggle(this.#open);
        button.focus();
      }
    });
  }

  /** The panel that is open. */
  get open(): PanelName | undefined {
    return this.#open;
  }

  /** Shows what is open, after the page hid all panels. */
  restore(): void {
    this.#side.hidden = this.#open === undefined;
  }

  /** Opens a panel, or closes it. */
  toggle(name: PanelName): void {
    this.#open = this.#open === name ? undefined : name;
    this.restore();
    for (const other of NAMES) {
      byId(other, HTMLElement).hidden = other !== this.#open;
      byId(`open-${other}`, HTMLButtonElement).setAttribute("aria-expanded", String(other === this.#open));
    }
    this.#onChange();
  }
}
