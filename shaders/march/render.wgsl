// Rendering from any eye: Main of algorithm 4 (CALF 6). Mirrors src/march/render.rs.
//
// An invocation makes a pixel. Counts are summed over a workgroup. Needs `follow`.

@group(0) @binding(6) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

// Rows and columns of pixels of a workgroup.
const TILE = 8u;

var<workgroup> group_counts: array<atomic<u32>, COUNTERS>;

fn render_pixel(x: u32, y: u32) -> vec4<f32> {
    var color = vec3(0.0);
    var colored = 0u;
    var opaque = 0u;
    let samples = scene.samples;
    for (var at = 0u; at < samples * samples; at++) {
        let sample = (vec2(f32(at % samples), f32(at / samples)) + 0.5) / f32(samples);
        let window = 2.0 * (vec2(f32(x), f32(y)) + sample) / vec2(f32(scene.width), f32(scene.height)) - 1.0;
        let plane = window + scene.middle;
        let direction = normalize(scene.forward + plane.x * scene.right + plane.y * scene.down);
        counted[PRIMARY_RAYS]++;
        is_around = (scene.refinements & REFINE_EDGES) != 0u;
        let found = follow(Ray(vec3(0.0), direction));
        counted[HOLE_RAYS] += select(0u, 1u, found.is_hole);
        if (found.is_colored && (!found.is_hole || scene.holes != HOLES_BLANK)) {
            color += found.light;
            colored++;
            opaque += select(0u, 1u, !found.is_hole || scene.holes == HOLES_BEHIND);
        }
    }
    return vec4(color / f32(max(colored, 1u)), f32(opaque) / f32(samples * samples));
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
        pixels[y * scene.width + id.x] = render_pixel(id.x, y);
        // Devices that end loops which take long, as software ones do, end this one too: no ray of the pixel counts then.
        var turns = 0u;
        while (turns < scene.samples) {
            turns++;
        }
        counted[PRIMARY_RAYS] = select(0u, counted[PRIMARY_RAYS], turns == scene.samples);
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
