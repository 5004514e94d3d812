// Opens the film that film.json names.

import { assetUrl, embeddedFile } from "../assets.ts";
import { HttpSource } from "../format/http.ts";
import { MemorySource } from "../format/memory.ts";
import type { ByteSource } from "../format/types.ts";
import { openPlayer } from "../player/player.ts";
import { withRetries } from "../player/retries.ts";
import type { Player, Pose, RendererChoice } from "../player/types.ts";
import { openQuilt } from "../quilt.ts";
import type { FilmFile } from "./film_file.ts";
import { FilmFileError } from "./film_file.ts";
import type { OverlayName } from "./settings.ts";

/** A film on the page. */
export interface OpenFilm {
  player: Player;
  /** Overlays that it has. */
  marks: readonly OverlayName[];
  /** The picture has a shape of its own; else it fills the stage. */
  isFixed: boolean;
  /** Of a scene: whether the overdraw is shown in place of the picture. */
  showOverdraw?: (isOn: boolean) => void;
  /** Of a scene, where a headset can be had: shows it there from a pose on, until the viewer takes it off. */
  enterHeadset?: (pose: Pose) => Promise<void>;
}

/** Overlays of containers. */
const CONTAINER_MARKS: readonly OverlayName[] = ["probes", "nodes", "holes", "units", "keyframes", "fetched"];

/** The bundle of scenes, beside this one; three.js is in it alone. */
const SCENES = "glb.js";

/** The film: inside the page, or on its server. */
async function sourceOf({ url }: FilmFile): Promise<ByteSource> {
  const bytes = embeddedFile(new URL(url).pathname.split("/").pop() ?? "");
  return bytes === undefined ? withRetries(() => HttpSource.open(url)) : new MemorySource(bytes);
}

async function openScene(file: FilmFile, canvas: HTMLCanvasElement): Promise<OpenFilm> {
  const source = await sourceOf(file);
  const { openScene } = (await import(assetUrl(SCENES, import.meta.url))) as typeof import("../glb/main.ts");
  const scene = await openScene(source, canvas, file.name);
  const opened: OpenFilm = {
    player: scene,
    marks: ["overdraw"],
    isFixed: false,
    showOverdraw: (isOn) => scene.showOverdraw(isOn),
  };
  if (await scene.hasHeadset()) {
    opened.enterHeadset = (pose) => scene.enterHeadset(pose);
  }
  return opened;
}

/** Opens a film to be drawn into a new canvas. */
export async function openFilm(file: FilmFile, canvas: HTMLCanvasElement, renderer: RendererChoice): Promise<OpenFilm> {
  if (file.kind === "glb") {
    return openScene(file, canvas);
  }
  const source = await sourceOf(file);
  if (file.kind === "lfold") {
    return { player: await openPlayer(source, canvas, renderer), marks: CONTAINER_MARKS, isFixed: false };
  }
  if (file.quilt === undefined) {
    throw new FilmFileError("film.json, quilt: columns and rows were expected.");
  }
  const player = await openQuilt(source, canvas, { name: file.name, layout: file.quilt });
  return { player, marks: [], isFixed: true };
}
