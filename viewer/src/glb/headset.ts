// A scene in a headset, by WebXR of three.js.

import { Group, PerspectiveCamera } from "three";
import type { Pose } from "../player/types.ts";
import { type Drawing, endSession } from "./drawing.ts";

/** Whether the browser can show pictures in a headset now. */
export async function hasHeadset(): Promise<boolean> {
  try {
    return (await navigator.xr?.isSessionSupported("immersive-vr")) ?? false;
  } catch {
    // Forbidden to this page.
    return false;
  }
}

/** Shows the scene in the headset, whose middle begins at the pose, level; resolves once it is shown. `onEnd` is called when the
 *  viewer has taken the headset off. Must be called from a press of a button. */
export async function enterHeadset(drawing: Drawing, pose: Pose, onEnd: () => void): Promise<void> {
  if (navigator.xr === undefined) {
    throw new Error("This browser has no WebXR.");
  }
  const { renderer, scene } = drawing;
  const session = await navigator.xr.requestSession("immersive-vr");
  if (drawing.isClosed) {
    endSession(session);
    throw new Error("The scene was closed meanwhile.");
  }
  const place = new Group();
  const camera = new PerspectiveCamera(60, 1, 0.01, 1e7);
  place.add(camera);
  place.position.set(...pose.eye);
  place.rotation.y = pose.yaw;
  scene.add(place);
  session.addEventListener("end", () => {
    renderer.setAnimationLoop(null);
    renderer.xr.enabled = false;
    scene.remove(place);
    onEnd();
  });
  renderer.xr.enabled = true;
  // Positions count from where the head is at the start.
  renderer.xr.setReferenceSpaceType("local");
  await renderer.xr.setSession(session).catch((error: unknown) => {
    endSession(session);
    throw error;
  });
  renderer.setAnimationLoop(() => {
    renderer.setClearColor(0x000000, 1);
    renderer.clear();
    renderer.render(scene, camera);
  });
}
