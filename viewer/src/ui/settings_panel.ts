// The panel of view settings.

import { byId, onPress, setText } from "./dom.ts";
import { shortNumber } from "./link.ts";
import { DEFAULTS, inRange, RENDERERS, STEREO_LAYOUTS, TONE_MAPS } from "./settings.ts";
import type { NumberName, Settings } from "./settings.ts";

/** Sliders: setting, id, and the text of a value. */
const SLIDERS: readonly (readonly [NumberName, string, (value: number) => string])[] = [
  ["exposureEv", "exposure", (value) => `${value > 0 ? "+" : ""}${shortNumber(value, 2)}`],
  ["fovDeg", "fov", (value) => `${shortNumber(value, 1)}°`],
  ["eyeDistance", "eye-distance", (value) => `${shortNumber(value * 1000, 0)} mm`],
];

/** Lists of numbers: setting and id. */
const NUMBER_LISTS: readonly (readonly [NumberName, string])[] = [
  ["scale", "scale"],
  ["steps", "steps"],
  ["speed", "speed"],
];

/** Chooses the value in a list; one that it lacks is added. */
function choose(list: HTMLSelectElement, value: string): void {
  if (![...list.options].some((option) => option.value === value)) {
    list.add(new Option(value, value));
  }
  list.value = value;
}

/** Calls `onChange` with what the viewer chooses of a list of words. */
function listOf<T extends string>(id: string, words: readonly T[], onChange: (word: T) => void): void {
  const list = byId(id, HTMLSelectElement);
  list.addEventListener("change", () => {
    const word = words.find((known) => known === list.value);
    if (word !== undefined) {
      onChange(word);
    }
  });
}

export class SettingsPanel {
  /** `onChange` is called with what the viewer set. */
  constructor(onChange: (change: Partial<Settings>) => void) {
    for (const [name, id] of SLIDERS) {
      const slider = byId(id, HTMLInputElement);
      slider.addEventListener("input", () => onChange({ [name]: inRange(name, Number(slider.value)) }));
    }
    for (const [name, id] of NUMBER_LISTS) {
      const list = byId(id, HTMLSelectElement);
      list.addEventListener("change", () => onChange({ [name]: inRange(name, Number(list.value)) }));
    }
    listOf("tone-map", TONE_MAPS, (toneMap) => onChange({ toneMap }));
    listOf("stereo", STEREO_LAYOUTS, (stereo) => onChange({ stereo }));
    listOf("renderer", RENDERERS, (renderer) => onChange({ renderer }));
    onPress("reset-settings", () => {
      const { exposureEv, toneMap, fovDeg, stereo, eyeDistance, steps, scale } = DEFAULTS;
      onChange({ exposureEv, toneMap, fovDeg, stereo, eyeDistance, steps, scale });
    });
  }

  show(settings: Settings): void {
    for (const [name, id, text] of SLIDERS) {
      byId(id, HTMLInputElement).value = String(settings[name]);
      byId(id, HTMLInputElement).setAttribute("aria-valuetext", text(settings[name]));
      setText(byId(`${id}-value`, HTMLOutputElement), text(settings[name]));
    }
    for (const [name, id] of NUMBER_LISTS) {
      choose(byId(id, HTMLSelectElement), String(settings[name]));
    }
    byId("tone-map", HTMLSelectElement).value = settings.toneMap;
    byId("stereo", HTMLSelectElement).value = settings.stereo;
    byId("renderer", HTMLSelectElement).value = settings.renderer;
    byId("eye-distance", HTMLInputElement).disabled = settings.stereo === "mono";
    byId("loop", HTMLButtonElement).setAttribute("aria-pressed", String(settings.isLooped));
  }
}
