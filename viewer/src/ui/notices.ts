// What the viewer must know: messages over the picture, and a notice in its place.

import { byId, messageOf, onPress, sentence, setText } from "./dom.ts";

/** Messages at a time; older ones make room. */
const MAX_MESSAGES = 4;

/** Messages over the picture, which screen readers speak. Each can be dismissed. */
export class Messages {
  readonly #log = byId("messages", HTMLElement);
  /** That end messages. */
  readonly #timers = new WeakMap<Element, ReturnType<typeof setTimeout>>();

  /** Shows a sentence, unless it is there already, for so many milliseconds. */
  say(text: string, ms = Infinity): void {
    const said = sentence(text);
    const shown = [...this.#log.children];
    const known = shown.find((message) => message.firstChild?.textContent === said);
    if (known !== undefined) {
      this.#keep(known, ms);
      return;
    }
    shown.slice(0, Math.max(0, shown.length - MAX_MESSAGES + 1)).forEach((message) => message.remove());
    const message = document.createElement("div");
    message.className = "message";
    message.appendChild(document.createElement("span")).textContent = said;
    const dismiss = message.appendChild(document.createElement("button"));
    dismiss.type = "button";
    dismiss.textContent = "Dismiss";
    dismiss.addEventListener("click", () => message.remove());
    this.#log.appendChild(message);
    this.#keep(message, ms);
  }

  /** Removes a message after so many milliseconds from now. */
  #keep(message: Element, ms: number): void {
    clearTimeout(this.#timers.get(message));
    if (ms !== Infinity) {
      this.#timers.set(
        message,
        setTimeout(() => message.remove(), ms),
      );
    }
  }

  clear(): void {
    this.#log.replaceChildren();
  }
}

/** A notice in place of the picture: while a film opens, and where it cannot be shown. */
export class Notice {
  readonly #section = byId("notice", HTMLElement);
  readonly #title = byId("notice-title", HTMLElement);
  readonly #text = byId("notice-text", HTMLElement);
  readonly #retry: HTMLButtonElement;
  readonly #stage = byId("stage", HTMLElement);
  readonly #tools = byId("tools", HTMLElement);
  /** What needs a film. */
  readonly #parts = [
    this.#tools,
    byId("side", HTMLElement),
    byId("transport", HTMLElement),
    byId("state", HTMLElement),
  ];

  /** Called when the viewer wants the film to be loaded again. */
  constructor(onRetry: () => void) {
    this.#retry = onPress("notice-retry", onRetry);
  }

  /** A film is being opened. */
  opening(name: string): void {
    this.#show("Opening", name);
    this.#retry.hidden = true;
  }

  /** The film cannot be shown. */
  failed(error: unknown): void {
    this.#show("The film cannot be shown", sentence(messageOf(error)));
    this.#retry.hidden = false;
    this.#section.focus();
  }

  /** A film is there. */
  hide(): void {
    this.#section.hidden = true;
    this.#tools.hidden = false;
    this.#stage.inert = false;
  }

  #show(title: string, text: string): void {
    setText(this.#title, title);
    setText(this.#text, text);
    [this.#title, this.#text].forEach((part) => part.classList.remove("unopened"));
    this.#section.hidden = false;
    this.#parts.forEach((part) => (part.hidden = true));
    this.#stage.inert = true;
  }
}
