// Orders a picture from the worker that renders.

import { type ActiveViews } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import type { Order } from "./messages.ts";
import type { MarchRequest } from "./marcher.ts";

/** What an order adds to views and camera. */
export type OrderOptions = Pick<MarchRequest, "size" | "steps" | "showsOverlay" | "looksBehindHoles">;

/** How often the interval before a hit is halved. */
const REFINE = 8;

/** The order of a picture of loaded views. */
export function renderOrder(active: ActiveViews, { axes, half }: Camera, options: OrderOptions): Order {
  const { views, coding, nearest, nearM, farM } = active;
  return {
    kind: "render",
    request: { camera: { axes, half }, coding, nearM, farM, refine: REFINE, ...options },
    views: views.map(({ view, streams, fromEye, turn, cameraWeight }) => ({
      view,
      fromEye,
      turn,
      cameraWeight,
      nearM: streams.nearM,
    })),
    nearest,
  };
}
