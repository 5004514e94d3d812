// When a picture is drawn, and at what resolution: only where something changed, one at a time, and coarser while the eye moves.

import type { PlayerStats } from "../player/types.ts";

/** A picture that takes longer is too slow to move in; one that takes less leaves room for four times the pixels. Milliseconds. */
const SLOW_MS = 100;
const FAST_MS = 20;
/** Least part of the resolution along a side. */
const MIN_FACTOR = 0.125;
/** Without motion for so long the eye is still. */
const STILL_MS = 180;
/** Between pictures that only wait for data. */
const ARRIVAL_MS = 100;

/** Of the first picture. */
const FIRST_FACTOR = 0.25;

/** The resolution of pictures in motion, from the time that they take. */
export class Resolution {
  #moving = FIRST_FACTOR;

  /** Part of the full resolution along a side. */
  factor(isMoving: boolean): number {
    return isMoving ? this.#moving : 1;
  }

  /** A picture at `factor` took `ms`. */
  note(factor: number, ms: number): void {
    if (factor > this.#moving) {
      // A full picture while the eye was still.
      this.#moving = ms <= SLOW_MS ? factor : this.#moving;
    } else if (factor === this.#moving && ms > SLOW_MS) {
      this.#moving = Math.max(factor / 2, MIN_FACTOR);
    } else if (factor === this.#moving && ms < FAST_MS) {
      this.#moving = Math.min(factor * 2, 1);
    }
  }
}

export interface LoopHost {
  /** Draws the present view at a part of its resolution; resolves when it is drawn. */
  draw(factor: number): Promise<PlayerStats>;
  /** A picture is there; `ms` since it was asked for. */
  onDrawn(stats: PlayerStats, ms: number): void;
  /** Drawing failed; nothing is drawn until the loop is made anew. */
  onFailed(error: unknown): void;
  /** Milliseconds. */
  now(): number;
}

/** Decides at each tick whether to draw. */
export class DrawLoop {
  readonly #host: LoopHost;
  readonly #resolution = new Resolution();
  #isChanged = true;
  #isMissing = true;
  #isOverlayMissing = false;
  #isBusy = false;
  #hasFailed = false;
  #drawnFactor = 0;
  #drawnMs = -Infinity;
  #movedMs = -Infinity;

  constructor(host: LoopHost) {
    this.#host = host;
  }

  /** Something other than the eye changed. */
  change(): void {
    this.#isChanged = true;
  }

  /** The eye moved, or the film goes on. */
  move(): void {
    this.#isChanged = true;
    this.#movedMs = this.#host.now();
  }

  /** No motion for a while. */
  get isStill(): boolean {
    return this.#host.now() - this.#movedMs >= STILL_MS;
  }

  /** Pictures in full resolution are fast enough to move in. */
  get isFluent(): boolean {
    return this.#resolution.factor(true) === 1;
  }

  /** The present view is shown in full. */
  get isSettled(): boolean {
    return !this.#isBusy && !this.#isChanged && !this.#isMissing && this.#drawnFactor === 1;
  }

  /** Once a picture of the screen. */
  tick(): void {
    const now = this.#host.now();
    const factor = this.#resolution.factor(!this.isStill || this.#isMissing);
    const awaits = (this.#isMissing || this.#isOverlayMissing) && now - this.#drawnMs >= ARRIVAL_MS;
    if (this.#isBusy || this.#hasFailed || !(this.#isChanged || awaits || factor > this.#drawnFactor)) {
      return;
    }
    void this.#draw(factor, now);
  }

  async #draw(factor: number, start: number): Promise<void> {
    this.#isBusy = true;
    this.#isChanged = false;
    try {
      const stats = await this.#host.draw(factor);
      this.#drawnMs = this.#host.now();
      this.#drawnFactor = factor;
      this.#isMissing = stats.unitsMissing > 0;
      this.#isOverlayMissing = stats.overlayMissing > 0;
      if (stats.unitsMissing === 0 || stats.marchMs > 0) {
        this.#resolution.note(factor, this.#drawnMs - start);
      }
      this.#host.onDrawn(stats, this.#drawnMs - start);
    } catch (error) {
      this.#hasFailed = true;
      this.#host.onFailed(error);
    } finally {
      this.#isBusy = false;
    }
  }
}
