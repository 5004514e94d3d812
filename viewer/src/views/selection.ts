// Selection of active views (CALF 6.3), as src/render/march/playback/selection.rs does by default: the nearest ones. The order is a function of the
// eye alone.

import type { Vec3 } from "../format/types.ts";
import { distance } from "../math.ts";

/** A view that may take part in a picture. */
export interface Candidate {
  /** Its place in the catalogue. */
  view: number;
  /** Where its probe stands in the frame, in metres. */
  position: Vec3;
}

/** The views nearest to an eye, at most `most`, by distance and then by number. */
export function selectViews(candidates: readonly Candidate[], eye: Vec3, most: number): number[] {
  const all = candidates.map(({ view, position }) => ({ view, distanceM: distance(position, eye) }));
  all.sort((one, other) => one.distanceM - other.distanceM || one.view - other.view);
  return all.slice(0, Math.max(most, 1)).map(({ view }) => view);
}
