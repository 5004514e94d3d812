// Shows pictures of linear light on a canvas.

struct PresentOptions {
  // Columns and rows of the pictures, then of the canvas.
  picture: vec2<f32>,
  canvas: vec2<f32>,
  gain: f32,
  // TONE_...
  tone: u32,
  // EYES_...
  eyes: u32,
  // Whether what no probe saw is marked, by its alpha.
  marks_holes: u32,
  // How much of the overlay is shown, 0 to 1.
  overlay: f32,
}

// Numbers of views/presentation.ts.
override TONE_REINHARD: u32;
override TONE_FILMIC: u32;
override EYES_SIDE_BY_SIDE: u32;
override EYES_ANAGLYPH: u32;
const HOLE_COLOR = vec3(1.0, 0.0, 1.0);

@group(0) @binding(0) var<uniform> options: PresentOptions;
@group(0) @binding(1) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> right: array<vec4<f32>>;
// Of the size of the pictures.
@group(0) @binding(3) var<storage, read> overlay: array<vec4<f32>>;

@vertex
fn corner(@builtin(vertex_index) number: u32) -> @builtin(position) vec4<f32> {
  // A triangle that covers the canvas.
  return vec4(vec2(f32(number & 1u), f32(number >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// A pixel of an eye, over black or the mark of holes.
fn pixel(is_right: bool, at: vec2<i32>) -> vec3<f32> {
  let size = vec2<i32>(options.picture);
  let place = clamp(at, vec2(0), size - 1);
  let number = place.y * size.x + place.x;
  var rgba = left[number];
  if (is_right) {
    rgba = right[number];
  }
  let alpha = clamp(rgba.a, 0.0, 1.0);
  let behind = select(vec3(0.0), HOLE_COLOR, options.marks_holes != 0u);
  return mix(behind, rgba.rgb * options.gain, alpha);
}

// Light at a place of a picture, 0 to 1, between its four pixels.
fn light(is_right: bool, place: vec2<f32>) -> vec3<f32> {
  let at = place * options.picture - 0.5;
  let first = vec2<i32>(floor(at));
  let part = fract(at);
  let upper = mix(pixel(is_right, first), pixel(is_right, first + vec2(1, 0)), part.x);
  let lower = mix(pixel(is_right, first + vec2(0, 1)), pixel(is_right, first + vec2(1, 1)), part.x);
  return mix(upper, lower, part.y);
}

fn toned(color: vec3<f32>) -> vec3<f32> {
  let x = max(color, vec3(0.0));
  if (options.tone == TONE_REINHARD) {
    return x / (1.0 + x);
  }
  if (options.tone == TONE_FILMIC) {
    // A rational curve with a toe and a shoulder.
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  }
  return x;
}

// The curve of IEC 61966-2-1.
fn coded(color: vec3<f32>) -> vec3<f32> {
  let x = clamp(color, vec3(0.0), vec3(1.0));
  return select(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3(0.0031308));
}

@fragment
fn show(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
  let place = position.xy / options.canvas;
  var color: vec3<f32>;
  var mark = vec2<u32>(place * options.picture);
  if (options.eyes == EYES_SIDE_BY_SIDE) {
    let is_right = place.x >= 0.5;
    let part = vec2(2.0 * place.x - select(0.0, 1.0, is_right), place.y);
    color = light(is_right, part);
    mark = vec2<u32>(part * options.picture);
  } else {
    color = light(false, place);
    if (options.eyes == EYES_ANAGLYPH) {
      color = vec3(color.r, light(true, place).gb);
    }
  }
  let marked = overlay[min(mark.y * u32(options.picture.x) + mark.x, arrayLength(&overlay) - 1u)].rgb;
  return vec4(mix(coded(toned(color)), coded(marked), options.overlay), 1.0);
}
