// The timeline: a slider over the frames, with the fetched ones drawn on its track.

import type { FilmTiming } from "./clock.ts";

/** Half the width of the slider's thumb in CSS pixels, as in style.css: the thumb's middle stays so far from both ends. */
const THUMB_HALF_PX = 7;

/** Where a frame is on the track, 0..1: the first at 0, the last at 1. */
function partOfFrame(frame: number, first: number, count: number): number {
  return count > 1 ? (frame - first) / (count - 1) : 0;
}

/** Spans of fetched frames along a track of `width` pixels: left end and width of each, in pixels. A frame reaches half way to its
 *  neighbours. Ranges outside of the film are cut off. */
export function fetchedSpans(
  ranges: readonly (readonly [number, number])[],
  [first, count]: [number, number],
  width: number,
): [number, number][] {
  const track = width - 2 * THUMB_HALF_PX;
  const spans: [number, number][] = [];
  for (const [from, to] of ranges) {
    const least = Math.max(from, first);
    const greatest = Math.min(to, first + count - 1);
    if (least <= greatest) {
      const left = THUMB_HALF_PX + track * Math.max(partOfFrame(least - 0.5, first, count), 0);
      const right = THUMB_HALF_PX + track * Math.min(partOfFrame(greatest + 0.5, first, count), 1);
      spans.push(count > 1 ? [left, right - left] : [THUMB_HALF_PX, track]);
    }
  }
  return spans;
}

/** Hours:minutes:seconds:frames, the way of film editing. `at` counts from the first frame. */
export function timeCode(at: number, framesPerSecond: number): string {
  const rate = Math.max(1, Math.round(framesPerSecond));
  const seconds = Math.floor(at / rate);
  const two = (value: number): string => String(value).padStart(2, "0");
  const minutes = Math.floor(seconds / 60);
  return [Math.floor(minutes / 60), minutes % 60, seconds % 60, at % rate].map(two).join(":");
}

/** What the timeline counts. Views of a quilt have no time. */
export type TimelineUnit = "Frame" | "View";

export interface TimelineParts {
  slider: HTMLInputElement;
  canvas: HTMLCanvasElement;
  /** Shows the frame. */
  label: HTMLElement;
  /** Shows its time. */
  time: HTMLElement;
}

/** The widget. */
export class Timeline {
  readonly #parts: TimelineParts;
  #first = 0;
  #count = 1;
  #framesPerSecond = 24;
  #unit: TimelineUnit = "Frame";
  #drawn = "";

  /** `onSeek` is called with the frame that the viewer chose. */
  constructor(parts: TimelineParts, onSeek: (frame: number) => void) {
    this.#parts = parts;
    parts.slider.addEventListener("input", () => onSeek(Number(parts.slider.value)));
  }

  setFilm({ firstFrame, frameCount, framesPerSecond }: FilmTiming, unit: TimelineUnit): void {
    [this.#first, this.#count, this.#framesPerSecond] = [firstFrame, frameCount, framesPerSecond];
    this.#unit = unit;
    const { slider, time } = this.#parts;
    slider.min = String(firstFrame);
    slider.max = String(firstFrame + frameCount - 1);
    slider.disabled = frameCount < 2;
    slider.ariaLabel = unit;
    time.hidden = unit === "View";
    this.#drawn = "";
  }

  /** The wanted frame, and the one of the picture where it is another. */
  showFrame(frame: number, shown: number): void {
    const { slider, label, time } = this.#parts;
    const behind = shown === frame ? "" : ` (shown: ${shown})`;
    const text = `${this.#unit} ${frame} of ${this.#first}–${this.#first + this.#count - 1}`;
    if (label.textContent !== text) {
      slider.value = String(frame);
      label.textContent = text;
      time.textContent = ` · ${timeCode(frame - this.#first, this.#framesPerSecond)}`;
    }
    slider.setAttribute("aria-valuetext", `${this.#unit} ${frame}${behind}`);
  }

  showFetched(ranges: readonly (readonly [number, number])[]): void {
    const { canvas } = this.#parts;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = window.devicePixelRatio;
    const state = JSON.stringify([ranges, width, height, ratio]);
    const context = canvas.getContext("2d");
    if (state === this.#drawn || context === null) {
      return;
    }
    this.#drawn = state;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    context.fillStyle = getComputedStyle(canvas).color;
    for (const [left, span] of fetchedSpans(ranges, [this.#first, this.#count], width)) {
      context.fillRect(left, 0, span, height);
    }
  }
}
