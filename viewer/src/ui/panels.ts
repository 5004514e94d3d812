// The panels at the side, of which one is open at a time.

import { byId } from "./dom.ts";

/** Ids of sections in index.html; the button of each is `open-` and its id, its heading its id and `-title`. */
export type PanelName = "settings" | "inspector" | "help";

const NAMES: readonly PanelName[] = ["settings", "inspector", "help"];

export class Panels {
  readonly #side = byId("side", HTMLElement);
  readonly #stage = byId("stage", HTMLElement);
  readonly #onChange: () => void;
  #open: PanelName | undefined;
  /** Had the focus before a panel took it; the picture where nothing had. */
  #before: HTMLElement | undefined;

  /** `onChange` is called when another panel is open. Escape closes the one that has the focus. */
  constructor(onChange: () => void) {
    this.#onChange = onChange;
    this.#side.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.#open !== undefined) {
        this.toggle(this.#open);
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

  /** Opens a panel and moves the focus to it, or closes it and gives the focus back. Does nothing where the panel has no
   *  button. */
  toggle(name: PanelName): void {
    if (byId(`open-${name}`, HTMLButtonElement).hidden) {
      return;
    }
    const focused = document.activeElement;
    const isInside = this.#side.contains(focused);
    if (!isInside) {
      this.#before = focused instanceof HTMLElement && focused !== document.body ? focused : this.#stage;
    }
    this.#open = this.#open === name ? undefined : name;
    this.restore();
    for (const other of NAMES) {
      byId(other, HTMLElement).hidden = other !== this.#open;
      byId(`open-${other}`, HTMLButtonElement).setAttribute("aria-expanded", String(other === this.#open));
    }
    if (this.#open !== undefined) {
      this.#side.setAttribute("aria-labelledby", `${name}-title`);
      byId(name, HTMLElement).focus({ preventScroll: true });
      this.#side.scrollTop = 0;
    } else if (isInside) {
      this.#before?.focus();
    }
    this.#onChange();
  }
}
