// Renders from any eye: Main of algorithm 4 (CALF 6). Mirrors src/render/march/render.rs.
//
// An invocation renders a pixel. Counters are summed over a workgroup. Needs `follow`.

@group(0) @binding(6) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

// Width and height of a workgroup in pixels.
const TILE = 8u;

var<workgroup> group_counts: array<atomic<u32>, COUNTERS>;

// Alpha of a pixel whose loops were terminated by the device.
const GIVEN_UP: f32 = -1.0;
const EDGE_CONTRAST: f32 = 0.1;
const EDGE_BLACK: f32 = 0.02;

// True if a ray of a pixel belongs to the first pass: the corners and the centre of the grid; all rays of a grid of at most two
// rows. Mirrors src/render/march/samples.rs.
fn is_first(place: vec2<u32>) -> bool {
    let last = scene.samples - 1u;
    let is_corner = (place.x == 0u || place.x == last) && (place.y == 0u || place.y == last);
    return scene.samples <= 2u || is_corner || all(place == vec2(scene.samples / 2u));
}

fn render_pixel(x: u32, y: u32) -> vec4<f32> {
    // Sum, minimum and maximum of RGB and alpha.
    var sum = vec4(0.0);
    var least = vec4(1e30);
    var greatest = vec4(-1e30);
    var share = 0.0;
    var rays = 0u;
    let samples = scene.samples;
    let count = samples * samples;
    for (var turn = 0u; turn < 2u * count; turn++) {
        let place = vec2(turn % count % samples, turn % count / samples);
        if (turn == count && !any(greatest - least > EDGE_CONTRAST * (least + greatest + 2.0 * EDGE_BLACK))) {
            // The first rays show no edge.
            break;
        }
        if (is_first(place) != (turn < count)) {
            continue;
        }
        let sample = (vec2<f32>(place) + 0.5) / f32(samples);
        let window = 2.0 * (vec2(f32(x), f32(y)) + sample) / vec2(f32(scene.width), f32(scene.height)) - 1.0;
        let plane = window + scene.middle;
        let direction = normalize(scene.forward + plane.x * scene.right + plane.y * scene.down);
        counted[PRIMARY_RAYS]++;
        is_around = (scene.refinements & REFINE_EDGES) != 0u;
        var found = follow(Ray(vec3(0.0), direction));
        if (found.is_hole && scene.holes == HOLES_BLANK) {
            found = RaySample(vec3(0.0), 0.0, true);
        }
        counted[HOLE_RAYS] += select(0u, 1u, found.is_hole);
        let alpha = select(found.share, 0.0, found.is_hole && scene.holes != HOLES_BEHIND);
        let shown = vec4(found.light, alpha);
        sum += shown;
        least = min(least, shown);
        greatest = max(greatest, shown);
        share += found.share;
        rays++;
    }
    return vec4(select(vec3(0.0), sum.rgb / share, share > 0.0), sum.a / f32(rays));
}

@compute @workgroup_size(TILE, TILE)
fn render(
    @builtin(local_invocation_index) local: u32,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let y = scene.first_row + id.y;
    if (id.x < scene.width && id.y < scene.rows) {
        let pixel = render_pixel(id.x, y);
        // Detects devices that terminate long loops, as software devices do: they terminate this loop too.
        var turns = 0u;
        while (turns < scene.samples) {
            turns++;
        }
        pixels[y * scene.width + id.x] = select(vec4(GIVEN_UP), pixel, turns == scene.samples);
    }
    for (var at = 0u; at < COUNTERS; at++) {
        atomicAdd(&group_counts[at], counted[at]);
    }
    workgroupBarrier();
    if (local < COUNTERS) {
        let row = scene.first_row / TILE + group.y;
        counts[(row * groups.x + group.x) * COUNTERS + local] = atomicLoad(&group_counts[local]);
    }
}
