// Shades winners, as `Shader` of src/epipolar/interpolate.rs does, without highlights. An invocation shades a pixel. Needs
// `unpack`, `pack`, `between` and `beside_of`.

@group(0) @binding(0) var<storage, read> block: SliceBlock;
// First line of each scanline, then the end of the last scanline.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> lights: array<LineLight>;
@group(0) @binding(3) var<storage, read> winners: array<vec2u>;
// Half floats, and SHOWN_… in the high half of the second word.
@group(0) @binding(4) var<storage, read_write> pixels: array<vec2u>;
// One bit per line: set if a pixel needs its highlight.
@group(0) @binding(5) var<storage, read_write> wanted: array<atomic<u32>>;

fn want(line: u32, kind: u32) {
    let bit = 1u << (line % 32u);
    if (kind == LIGHT_GLOSS && (atomicLoad(&wanted[line / 32u]) & bit) == 0u) {
        atomicOr(&wanted[line / 32u], bit);
    }
}

fn light_of(winner: vec2u, start: u32) -> vec2u {
    if (winner.x == NONE) {
        return vec2u(0u, SHOWN_HOLE << 16u);
    }
    let at = start + winner.x;
    let light = lights[at];
    if ((winner.y & WINNER_OWN) != 0u) {
        return vec2u(light.own_rg, light.own_b);
    }
    let kind = light.steady_b >> 16u;
    if (kind == LIGHT_TRACED) {
        return vec2u(0u, SHOWN_OPTICAL << 16u);
    }
    let beside = beside_of(at, winner.y);
    let other = lights[beside];
    let other_kind = other.steady_b >> 16u;
    let weight = select(winner.y & 0xffu, 0u, other_kind == LIGHT_TRACED);
    let colors = array<vec3u, 2>(
        unpack(vec2u(light.steady_rg, light.steady_b)),
        unpack(vec2u(other.steady_rg, other.steady_b)),
    );
    let color = pack(between(colors[0], colors[1], weight));
    want(at, kind);
    want(beside, other_kind);
    let is_glossy = kind == LIGHT_GLOSS || other_kind == LIGHT_GLOSS;
    return vec2u(color.x, color.y | (select(0u, SHOWN_GLOSS, is_glossy) << 16u));
}

@compute @workgroup_size(WORKGROUP)
fn shade(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let pixel = id.x + id.y * groups.x * WORKGROUP;
    if (pixel >= block.width * block.rows * block.views) {
        return;
    }
    pixels[pixel] = light_of(winners[pixel], starts[pixel / (block.width * block.views)]);
}
