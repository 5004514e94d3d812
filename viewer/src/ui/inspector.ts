// The inspector: overlays, counters, streams, the head box, and the view as a command line.

import { CODING_LEGEND } from "../player/coding_colors.ts";
import type { Film, PlayerStats, Pose } from "../player/types.ts";
import { byId, byteText, copyText, msText, onPress, setRows, setText, numberText } from "./dom.ts";
import type { FilmKind } from "./film_file.ts";
import { HeadMap } from "./head_map.ts";
import type { OverlayName } from "./settings.ts";

/** What the inspector shows of the last picture. */
export interface Reading {
  stats: PlayerStats;
  /** Milliseconds from asking for the picture until it was there. */
  pictureMs: number;
  /** Of the picture, in pixels. */
  size: [number, number];
  pose: Pose;
  /** Horizontal, in degrees. */
  fovDeg: number;
  command: string | undefined;
}

/** Rows of the table of figures. Scenes and quilts are fetched at once, as a whole. */
function figuresOf({ stats, pictureMs, size }: Reading, kind: FilmKind): [string, string][] {
  const rows: [string, string][] = [
    ["Picture", msText(pictureMs)],
    ["Decoding", msText(stats.decodeMs)],
  ];
  if (kind !== "quilt") {
    rows.push(["Rendering", msText(stats.marchMs)]);
  }
  rows.push(["Size", `${size[0]}×${size[1]}`]);
  if (kind === "lfold") {
    rows.push(
      ["Frame shown", String(stats.shownFrame)],
      ["Tiles and cells not loaded", numberText(stats.unitsMissing)],
      ["Tiles and cells damaged", numberText(stats.unitsBroken)],
      ["Rate", `${(stats.fetchRate / 1e6).toFixed(2)} MB/s`],
      ["Requests", numberText(stats.requests)],
      ["Chunks", numberText(stats.chunksFetched)],
      ["Chunks fetched again", numberText(stats.chunksRefetched)],
    );
  }
  rows.push(["Fetched", byteText(stats.bytesFetched)], ["Cache", byteText(stats.cacheBytes)]);
  return rows;
}

function bodyOf(id: string): HTMLTableSectionElement {
  const table = byId(id, HTMLTableElement);
  return table.tBodies[0] ?? table.createTBody();
}

/** The colors of the overlay of nodes, and what they stand for. */
function fillLegend(): void {
  const rows = CODING_LEGEND.map(({ color, name }) => {
    const row = document.createElement("li");
    const swatch = row.appendChild(document.createElement("span"));
    swatch.style.backgroundColor = `rgb(${color.join()})`;
    row.append(name);
    return row;
  });
  byId("nodes-legend", HTMLUListElement).prepend(...rows);
}

export class Inspector {
  readonly #map = new HeadMap(byId("map", SVGSVGElement));
  readonly #boxes = [...byId("marks", HTMLFieldSetElement).querySelectorAll<HTMLInputElement>("input")];
  readonly #command = byId("command", HTMLElement);
  readonly #kind: FilmKind;

  /** `onMark` is called when the viewer turns an overlay on or off. */
  constructor(kind: FilmKind, onMark: (mark: OverlayName, isOn: boolean) => void) {
    this.#kind = kind;
    for (const box of this.#boxes) {
      box.addEventListener("change", () => onMark(box.value as OverlayName, box.checked));
    }
    fillLegend();
    const copy = onPress("copy-command", () => {
      void copyText(this.#command.textContent ?? "", copy, this.#command);
    });
  }

  /** Shows the overlays that the film has, its streams, and its head box. */
  setFilm(film: Film, marks: readonly OverlayName[]): void {
    this.#map.setFilm(film);
    byId("marks", HTMLElement).hidden = marks.length === 0;
    for (const box of this.#boxes) {
      const label = box.closest("label");
      if (label !== null) {
        label.hidden = !marks.some((mark) => mark === box.value);
      }
    }
    const streams = film.streams.map(({ kind, codec, count, bytes }) => [
      kind,
      codec,
      numberText(count),
      byteText(bytes),
    ]);
    setRows(bodyOf("streams"), streams);
  }

  showMarks(marks: ReadonlySet<OverlayName>): void {
    for (const box of this.#boxes) {
      box.checked = [...marks].some((mark) => mark === box.value);
    }
  }

  show(reading: Reading): void {
    const { pose, stats } = reading;
    setRows(bodyOf("figures"), figuresOf(reading, this.#kind));
    const counters = Object.entries(stats.counters).map(([name, value]) => [name, numberText(value)]);
    setRows(bodyOf("counters"), counters);
    this.#map.showPose(pose, reading.fovDeg);
    const degrees = [pose.yaw, pose.pitch].map((angle) => `${((angle * 180) / Math.PI).toFixed(1)}°`);
    const eye = pose.eye.map((value) => (Number(value.toFixed(3)) + 0).toFixed(3)).join("  ");
    setText(byId("eye", HTMLElement), `Eye ${eye} m\nYaw ${degrees[0]}  Pitch ${degrees[1]}`);
    setText(this.#command, reading.command ?? "");
    byId("command-part", HTMLElement).hidden = reading.command === undefined;
  }
}
