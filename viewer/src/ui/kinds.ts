// Parts and words of the page that only some kinds of films have.

import type { FilmKind } from "./film_file.ts";

/** Shows the parts of index.html for this kind of film, and hides those for others. */
export function showPartsFor(kind: FilmKind): void {
  document.querySelectorAll<HTMLElement>("[data-kinds]").forEach((part) => {
    part.hidden = !(part.dataset.kinds ?? "").split(" ").includes(kind);
  });
}

/** Help text about headsets. */
export function headsetHelp(kind: FilmKind, hasHeadset: boolean): string {
  if (kind === "glb") {
    return hasHeadset
      ? "The button Headset shows this scene in WebXR."
      : "This scene plays in WebXR, by a button that appears where the browser finds a headset.";
  }
  const films = "lightfold render --projection vr180 --stereo side-by-side makes pictures for headsets";
  const scenes = "lightfold simplify makes a scene (.glb) of a frame, which this page shows in WebXR";
  return kind === "quilt"
    ? "Quilts are for displays of Looking Glass; headsets show other forms of light fields."
    : `This page does not show light fields in headsets: WebXR takes pictures of WebGL in most browsers, and these are made by WebGPU. ${films}; ${scenes}.`;
}
