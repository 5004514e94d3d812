// Which frame a film shows while units are fetched and decoded. A film that plays goes from one whole frame to the next, and leaves out
// those that come due meanwhile: depth of one frame beside colors of another would show.

/** After so long a frame is shown as far as it is here. Milliseconds. */
const LONGEST_MS = 500;

/** The frame that is being completed. */
interface Pending {
  frame: number;
  sinceMs: number;
  isWhole: boolean;
}

export class FramePacing {
  #pending: Pending | undefined;
  #shown: number | undefined;

  /** The frame to be completed, where `due` is the one that the clock or the viewer asks for. */
  next(due: number, isPlaying: boolean, nowMs: number): number {
    const pending = this.#pending;
    const isKept =
      isPlaying && pending !== undefined && !pending.isWhole && due > pending.frame && !this.#isLate(pending, nowMs);
    if (pending === undefined || (pending.frame !== due && !isKept)) {
      this.#pending = { frame: due, sinceMs: nowMs, isWhole: false };
    }
    return this.#pending!.frame;
  }

  /** The last frame that was shown. */
  get shown(): number | undefined {
    return this.#shown;
  }

  /** The frame to be shown: that of the last call of {@link FramePacing.next} once it is whole, is late, or where the film stands. */
  show(isWhole: boolean, isPlaying: boolean, nowMs: number): number {
    const pending = this.#pending!;
    pending.isWhole = isWhole;
    if (isWhole || !isPlaying || this.#shown === undefined || this.#isLate(pending, nowMs)) {
      this.#shown = pending.frame;
    }
    return this.#shown;
  }

  #isLate({ sinceMs }: Pending, nowMs: number): boolean {
    return nowMs - sinceMs >= LONGEST_MS;
  }
}
