// The head box from above: probes, margin, eye, and what it sees.

import type { Film, Pose } from "../player/types.ts";
import { clampEye, marginOf } from "./bounds.ts";

const SVG = "http://www.w3.org/2000/svg";
/** Probes that are drawn at most. */
const MAX_PROBES = 2000;
/** Radii of marks, and the length of the view's wedge, as parts of the map's side. */
const PROBE_RADIUS = 0.011;
const EYE_RADIUS = 0.02;
const WEDGE = 0.3;

function add(parent: Element, name: string, attributes: Record<string, string | number>): Element {
  const made = document.createElementNS(SVG, name);
  Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, String(value)));
  return parent.appendChild(made);
}

/** Draws into an `svg` element: +X to the right, -Z up. */
export class HeadMap {
  readonly #svg: SVGSVGElement;
  #side = 1;
  #box: Film["headBox"] = { least: [0, 0, 0], greatest: [0, 0, 0] };
  #cone: Element | undefined;
  #eye: Element | undefined;

  constructor(svg: SVGSVGElement) {
    this.#svg = svg;
  }

  setFilm({ headBox, probes }: Film): void {
    this.#box = headBox;
    const margin = marginOf(headBox);
    const [left, , top] = headBox.least;
    const [width, depth] = [headBox.greatest[0] - left, headBox.greatest[2] - top];
    const side = 1.15 * (Math.max(width, depth) + 2 * margin);
    const middle = [left + width / 2, top + depth / 2];
    this.#side = side;
    this.#svg.replaceChildren();
    // In units of the map's side, which is 100: widths of lines are the same for all films.
    const unit = 100 / side;
    this.#svg.setAttribute("viewBox", [-80, -50, 160, 100].join(" "));
    const plan = add(this.#svg, "g", { transform: `scale(${unit}) translate(${-middle[0]} ${-middle[1]})` });
    const rectangle = (by: number): Record<string, number> => ({
      x: left - by,
      y: top - by,
      width: width + 2 * by,
      height: depth + 2 * by,
    });
    add(plan, "rect", { ...rectangle(margin), class: "margin" });
    add(plan, "rect", { ...rectangle(0), class: "box" });
    for (const { position } of probes.slice(0, MAX_PROBES)) {
      add(plan, "circle", { cx: position[0], cy: position[2], r: side * PROBE_RADIUS, class: "probe" });
    }
    this.#cone = add(plan, "path", { class: "cone" });
    this.#eye = add(plan, "circle", { r: side * EYE_RADIUS, class: "eye" });
  }

  /** `fovDeg` is the horizontal field of view. */
  showPose({ eye, yaw }: Pose, fovDeg: number): void {
    const [x, , z] = clampEye(eye, this.#box);
    const half = (Math.min(fovDeg, 170) * Math.PI) / 360;
    const edge = (angle: number): string => {
      const length = this.#side * WEDGE;
      return `${x - Math.sin(angle) * length} ${z - Math.cos(angle) * length}`;
    };
    this.#cone?.setAttribute("d", `M${x} ${z}L${edge(yaw + half)}L${edge(yaw - half)}Z`);
    this.#eye?.setAttribute("cx", String(x));
    this.#eye?.setAttribute("cy", String(z));
  }
}
