// Directions of a pose, and its changes: player/types.ts has the conventions.

import type { Vec3 } from "../format/types.ts";
import type { Pose } from "../player/types.ts";

/** Greatest pitch in radians: straight up and down have no upright picture. */
export const MAX_PITCH = (89 * Math.PI) / 180;

/** Unit vector along which the pose looks. */
export function forwardOf({ yaw, pitch }: Pose): Vec3 {
  return [-Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)];
}

/** The upright pose at an eye that looks along a direction of any length above 0. */
export function poseOf(eye: Vec3, [x, y, z]: Vec3): Pose {
  const pitch = Math.atan2(y, Math.hypot(x, z));
  const yaw = x === 0 && z === 0 ? 0 : Math.atan2(-x, -z);
  return { eye, yaw, pitch: Math.min(Math.max(pitch, -MAX_PITCH), MAX_PITCH) };
}

/** Unit vector to the right of the picture; it is level. */
export function rightOf({ yaw }: Pose): Vec3 {
  return [Math.cos(yaw), 0, -Math.sin(yaw)];
}

/** An angle in radians brought to -pi..pi. */
export function wrapAngle(angle: number): number {
  const turns = Math.round(angle / (2 * Math.PI));
  return angle - turns * 2 * Math.PI;
}

/** The pose turned by radians to the left and up. Pitch stays within `MAX_PITCH`. */
export function turned(pose: Pose, left: number, up: number): Pose {
  const pitch = Math.min(Math.max(pose.pitch + up, -MAX_PITCH), MAX_PITCH);
  return { eye: pose.eye, yaw: wrapAngle(pose.yaw + left), pitch };
}

/** Metres of the world for a step of metres to the right of the picture, straight up, and along the view. */
export function stepOf(pose: Pose, [right, up, ahead]: Vec3): Vec3 {
  const toRight = rightOf(pose);
  const forward = forwardOf(pose);
  return [
    right * toRight[0] + ahead * forward[0],
    right * toRight[1] + up + ahead * forward[1],
    right * toRight[2] + ahead * forward[2],
  ];
}
