// Rendering from any eye: Main of algorithm 4 (CALF 6). Mirrors src/march/render.rs.
//
// An invocation makes a pixel. Counts are summed over a workgroup. Needs `intersect`, `intersect_from`, `surface_color`, `background_color`,
// `surface_light` and `light_of`.

@group(0) @binding(6) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

// Rows and columns of pixels of a workgroup.
const TILE = 8u;

var<workgroup> group_counts: array<atomic<u32>, COUNTERS>;

// Result of a primary ray: a colour in linear light, if any, and whether a view saw it.
struct RayResult {
    color: vec3<f32>,
    is_colored: bool,
    is_seen: bool,
}

// The hit between the clip planes, where a primary ray first hits a surface at `met`. Mirrors src/march/clip.rs.
fn visible_hit(ray: Ray, met: Hit) -> Hit {
    let cosine = dot(ray.direction, scene.forward);
    var hit = met;
    if (met.found && met.distance_m * cosine < scene.near_m) {
        var first = 0u;
        while (first < scene.distance_count && distances_m[first] * cosine < scene.near_m) {
            first++;
        }
        while (first < scene.distance_count) {
            counted[MARCH_STEPS]++;
            if (!is_surface(point_at(ray, distances_m[first]))) {
                break;
            }
            first++;
        }
        hit = intersect_from(ray, first);
    }
    let depth_m = hit.distance_m * cosine;
    return Hit(hit.found && depth_m >= scene.near_m && depth_m <= scene.far_m, hit.distance_m);
}

fn primary_hit(ray: Ray) -> RayResult {
    let hit = visible_hit(ray, intersect(ray));
    if (hit.found) {
        let seen = surface_color(point_at(ray, hit.distance_m));
        if (seen.found && seen.difference <= scene.hole_difference) {
            return RayResult(surface_light(ray, hit.distance_m, seen), true, true);
        }
        return RayResult(light_of(seen.color), seen.found, false);
    }
    counted[BACKGROUND_RAYS]++;
    let seen = background_color(ray.direction);
    return RayResult(light_of(seen.color), seen.found, seen.found);
}

fn render_pixel(x: u32, y: u32) -> vec4<f32> {
    var color = vec3(0.0);
    var colored = 0u;
    var seen = 0u;
    let samples = scene.samples;
    for (var at = 0u; at < samples * samples; at++) {
        let sample = (vec2(f32(at % samples), f32(at / samples)) + 0.5) / f32(samples);
        let window = 2.0 * (vec2(f32(x), f32(y)) + sample) / vec2(f32(scene.width), f32(scene.height)) - 1.0;
        let plane = window + scene.middle;
        let direction = normalize(scene.forward + plane.x * scene.right + plane.y * scene.down);
        counted[PRIMARY_RAYS]++;
        let found = primary_hit(Ray(vec3(0.0), direction));
        if (found.is_seen) {
            seen++;
        } else {
            counted[HOLE_RAYS]++;
        }
        if (found.is_seen || (found.is_colored && scene.fill_holes == 1u)) {
            color += found.color;
            colored++;
        }
    }
    return vec4(color / f32(max(colored, 1u)), f32(seen) / f32(samples * samples));
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
