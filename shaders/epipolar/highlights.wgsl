// Adds highlights to the pixels marked SHOWN_GLOSS (Epipolar 3.5, 7.3), as src/epipolar/highlights.rs does: linear
// interpolation between splits along the line of eyes. An invocation shades a pixel. Needs `beside_of`.

// A position along the line of eyes at which the highlight of a line is known.
struct LineSplit {
    // Radiance of the highlight.
    light: vec3f,
    // Position along the line of eyes: 0 at the first view, 1 at the last.
    place: f32,
}

@group(0) @binding(0) var<storage, read> block: SliceBlock;
// First line of each scanline, then the end of the last scanline.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> winners: array<vec2u>;
// First split of each line, then the end of the last line. A line without highlights has no splits.
@group(0) @binding(3) var<storage, read> split_starts: array<u32>;
@group(0) @binding(4) var<storage, read> splits: array<LineSplit>;
// Positions of the views: 0 for the first of all views, 1 for the last.
@group(0) @binding(5) var<storage, read> eyes: array<f32>;
// Half floats, and SHOWN_… in the high half of the second word.
@group(0) @binding(6) var<storage, read_write> pixels: array<vec2u>;

// Returns the radiance of a line's highlight at a position. The last component is unused.
fn highlight(line: u32, place: f32) -> vec4f {
    let begin = split_starts[line];
    let end = split_starts[line + 1u];
    if (begin == end) {
        return vec4f();
    }
    var after = begin;
    while (after < end && splits[after].place <= place) {
        after++;
    }
    let near = splits[max(after, begin + 1u) - 1u];
    let next = splits[min(after, end - 1u)];
    // Before the first split and after the last one, `near` and `next` are the same split.
    var part = 0.0;
    if (next.place > near.place) {
        part = (place - near.place) / (next.place - near.place);
    }
    return mix(vec4f(near.light, 0.0), vec4f(next.light, 0.0), part);
}

// Converts the bits of a half float to a number; infinity becomes 65536.
fn number_of(half: u32) -> f32 {
    let size = half & 0x7fffu;
    // Subnormals are multiples of 2^-24.
    var number = f32(size) / 16777216.0;
    if (size >= 0x400u) {
        number = bitcast<f32>((min(size, 0x7c00u) << 13u) + 0x38000000u);
    }
    return select(number, -number, (half & 0x8000u) != 0u);
}

// Converts a number to the bits of the nearest half float, ties to even. Clamps to 0 … 65504.
fn half_of(number: f32) -> u32 {
    let light = clamp(number, 0.0, 65504.0);
    // Below this value half floats are subnormal: multiples of 2^-24.
    if (light < 6.103515625e-5) {
        return u32(round(light * 16777216.0));
    }
    let bits = bitcast<u32>(light);
    return (bits + 0xfffu + ((bits >> 13u) & 1u) - 0x38000000u) >> 13u;
}

@compute @workgroup_size(WORKGROUP)
fn add_highlights(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = id.x + id.y * groups.x * WORKGROUP;
    if (at >= block.width * block.rows * block.views) {
        return;
    }
    let pixel = pixels[at];
    if (pixel.y >> 16u != SHOWN_GLOSS) {
        return;
    }
    let winner = winners[at];
    let line = starts[at / (block.width * block.views)] + winner.x;
    let place = eyes[(at / block.width) % block.views];
    let lights = array<vec4f, 2>(highlight(line, place), highlight(beside_of(line, winner.y), place));
    let halves = vec3u(pixel.x & 0xffffu, pixel.x >> 16u, pixel.y & 0xffffu);
    let steady = vec4f(number_of(halves.x), number_of(halves.y), number_of(halves.z), 0.0);
    let light = steady + mix(lights[0], lights[1], f32(winner.y & 0xffu) / 255.0);
    pixels[at] = vec2u(half_of(light.x) | (half_of(light.y) << 16u), half_of(light.z));
}
