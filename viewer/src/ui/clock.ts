// Film time: which frame is due, whatever the drawing takes.

/** Frames of a film that plays. */
export interface FilmTiming {
  firstFrame: number;
  frameCount: number;
  framesPerSecond: number;
}

/** Least and greatest frames per second: an image an hour, and more than displays show. */
const RATES: readonly [number, number] = [1 / 3600, 10_000];

/** A rate within {@link RATES}: others would leave no frame that is due. */
function usableRate(framesPerSecond: number): number {
  return Math.min(Math.max(framesPerSecond || 0, RATES[0]), RATES[1]);
}

/** Runs with the clock of the page and never waits for pictures. Times in milliseconds. */
export class FilmClock {
  readonly #timing: FilmTiming;
  /** Frames since the first, at `#sinceMs`. */
  #at = 0;
  #sinceMs = 0;
  #isPlaying = false;
  #speed = 1;
  isLooped = true;

  constructor(timing: FilmTiming) {
    this.#timing = { ...timing, framesPerSecond: usableRate(timing.framesPerSecond) };
  }

  get isPlaying(): boolean {
    return this.#isPlaying;
  }

  get lastFrame(): number {
    return this.#timing.firstFrame + this.#timing.frameCount - 1;
  }

  /** The frame that is due. At the end of a film without loop the clock stops. */
  frame(nowMs: number): number {
    const { firstFrame, frameCount } = this.#timing;
    let at = this.#position(nowMs);
    if (at >= frameCount) {
      if (this.isLooped) {
        at %= frameCount;
      } else {
        at = frameCount - 1;
        this.#isPlaying = false;
      }
      this.#at = at;
      this.#sinceMs = nowMs;
    }
    return firstFrame + Math.floor(at);
  }

  /** From the beginning where the last frame is shown and nothing loops. */
  play(nowMs: number): void {
    const isAtEnd = !this.isLooped && this.frame(nowMs) === this.lastFrame;
    this.#start(isAtEnd ? 0 : this.#position(nowMs), nowMs);
    this.#isPlaying = this.#timing.frameCount > 1;
  }

  pause(nowMs: number): void {
    this.#start(this.frame(nowMs) - this.#timing.firstFrame, nowMs);
    this.#isPlaying = false;
  }

  /** Shows a frame, the nearest there is; whether it plays stays. */
  seek(frame: number, nowMs: number): void {
    const at = Math.round(frame) - this.#timing.firstFrame;
    this.#start(Math.min(Math.max(at, 0), this.#timing.frameCount - 1), nowMs);
  }

  /** Steps by frames, around the ends in a loop, and pauses. */
  step(frames: number, nowMs: number): void {
    this.pause(nowMs);
    const { frameCount } = this.#timing;
    const at = this.#at + frames;
    const around = ((at % frameCount) + frameCount) % frameCount;
    this.#at = this.isLooped ? around : Math.min(Math.max(at, 0), frameCount - 1);
  }

  /** Seconds of the film in a second, above 0. */
  setSpeed(speed: number, nowMs: number): void {
    this.#start(this.#position(nowMs), nowMs);
    this.#speed = speed;
  }

  #start(at: number, nowMs: number): void {
    this.#at = at;
    this.#sinceMs = nowMs;
  }

  #position(nowMs: number): number {
    const passedMs = this.#isPlaying ? Math.max(nowMs - this.#sinceMs, 0) : 0;
    return this.#at + (passedMs / 1000) * this.#speed * this.#timing.framesPerSecond;
  }
}
