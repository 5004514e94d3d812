// Pinhole cameras in the world: right-handed, +Y up, metres. Mirrors src/codec/math/camera.rs.

import type { Vec3 } from "../format/types.ts";
import type { Axes } from "../math.ts";
import { add, cross, scale } from "../math.ts";

/** Where the viewer is and looks: right-handed, +Y up, metres; angles in radians. At yaw and pitch 0 it looks along -Z; yaw turns to the
 *  left (around +Y), pitch up. */
export interface Pose {
  eye: Vec3;
  yaw: number;
  pitch: number;
}

export interface Camera {
  /** Metres. */
  eye: Vec3;
  /** Forward, right, down: of length 1, each at right angles to the others. */
  axes: Axes;
  /** Half the width and half the height of the picture at distance 1. */
  half: readonly [number, number];
}

/** The camera of a pose: vertical field of view in degrees, above 0 and below 180, and width over height of the picture. */
export function cameraOf({ eye, yaw, pitch }: Pose, fovDeg: number, aspect: number): Camera {
  const forward: Vec3 = [-Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)];
  const right: Vec3 = [Math.cos(yaw), 0, -Math.sin(yaw)];
  const tangent = Math.tan((fovDeg * Math.PI) / 360);
  return { eye, axes: [forward, right, cross(forward, right)], half: [tangent * aspect, tangent] };
}

/** The left and the right eye of a camera, so many metres apart, that look in parallel. */
export function stereoEyes(camera: Camera, eyeDistance: number): [Camera, Camera] {
  const moved = (by: number): Camera => ({ ...camera, eye: add(camera.eye, scale(camera.axes[1], by)) });
  return [moved(-eyeDistance / 2), moved(eyeDistance / 2)];
}

/** Whether two cameras see the same. */
export function isSameCamera(one: Camera, other: Camera): boolean {
  const numbers = ({ eye, axes, half }: Camera): number[] => [...eye, ...axes.flat(), ...half];
  const others = numbers(other);
  return numbers(one).every((value, at) => value === others[at]);
}
