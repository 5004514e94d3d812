// Shaders of scenes. They are GLSL, as three.js draws by WebGL, whose renderer has WebXR.

import { STEREO_NUMBERS, TONE_MAP_NUMBERS } from "../views/presentation.ts";

/** Corners with homogeneous texture coordinates where the file has them (src/simplify/export/glb.rs), else affine ones. */
export const QUAD_VERTEX = /* glsl */ `
#ifdef PROJECTIVE
attribute vec3 _texcoord_stq;
#endif
varying vec3 stq;
void main() {
#ifdef PROJECTIVE
  stq = _texcoord_stq;
#else
  stq = vec3(uv, 1.0);
#endif
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

/** Light, not multiplied by alpha, and alpha; in a headset, codes of the light. */
export const QUAD_FRAGMENT = /* glsl */ `
uniform sampler2D atlas;
varying vec3 stq;
void main() {
  gl_FragColor = texture2D(atlas, stq.xy / stq.z);
  #include <colorspace_fragment>
}`;

/** One for each triangle over a pixel. */
export const OVERDRAW_FRAGMENT = /* glsl */ `
void main() {
  gl_FragColor = vec4(1.0);
}`;

/** A triangle that covers the picture. */
export const SCREEN_VERTEX = /* glsl */ `
varying vec2 at;
void main() {
  at = position.xy * 0.5 + 0.5;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

/** Joins the pictures of the eyes, and shows their light, or their overdraw. */
export const SCREEN_FRAGMENT = /* glsl */ `
uniform sampler2D leftEye;
uniform sampler2D rightEye;
uniform int stereo;
uniform float gain;
uniform int toneMap;
uniform bool isOverdraw;
varying vec2 at;

vec4 picture() {
  if (stereo == ${STEREO_NUMBERS["side-by-side"]}) {
    return at.x < 0.5 ? texture2D(leftEye, vec2(2.0 * at.x, at.y)) : texture2D(rightEye, vec2(2.0 * at.x - 1.0, at.y));
  }
  vec4 left = texture2D(leftEye, at);
  return stereo == ${STEREO_NUMBERS.anaglyph} ? vec4(left.r, texture2D(rightEye, at).gba) : left;
}

vec3 shown(vec3 light) {
  if (toneMap == ${TONE_MAP_NUMBERS.reinhard}) {
    return light / (1.0 + light);
  }
  if (toneMap == ${TONE_MAP_NUMBERS.filmic}) {
    // The fit of Narkowicz to the curve of ACES.
    return light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);
  }
  return light;
}

// Black, blue, green, yellow, red, white: two triangles more each.
vec3 heat(float count) {
  float part = min(count, 10.0) / 2.0;
  vec3 color = mix(vec3(0.0), vec3(0.05, 0.15, 0.6), min(part, 1.0));
  color = mix(color, vec3(0.05, 0.6, 0.25), clamp(part - 1.0, 0.0, 1.0));
  color = mix(color, vec3(0.9, 0.8, 0.1), clamp(part - 2.0, 0.0, 1.0));
  color = mix(color, vec3(0.8, 0.1, 0.05), clamp(part - 3.0, 0.0, 1.0));
  return mix(color, vec3(1.0), clamp(part - 4.0, 0.0, 1.0));
}

void main() {
  vec4 found = picture();
  vec3 light = isOverdraw ? heat(found.r) : shown(found.rgb * gain);
  gl_FragColor = vec4(clamp(light, 0.0, 1.0), 1.0);
  #include <colorspace_fragment>
}`;
