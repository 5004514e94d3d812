// Decodes nodes in the runtime form (depth.md 10; GDC 4, 5). Mirrors src/codec/depth/runtime.rs and src/codec/depth/nodes.rs.
//
// An invocation decodes a part of 4x4 pixels. The parts of a record are numbered by level, then by node, then row by row inside
// a node. The node of a part follows from the node counts in the header.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read> log2_table: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<u32>;

// Writes four codes of a row; skips those outside the picture.
fn write_row(unit: Unit, x: u32, y: u32, codes: vec4u) {
    if (y >= unit.height) {
        return;
    }
    let inside = select(vec4u(0u), codes, vec4u(x, x + 1u, x + 2u, x + 3u) < vec4u(unit.width));
    let at = unit.picture + y * unit.stride + x / 2u;
    if (x < unit.width) {
        pictures[at] = inside.x | (inside.y << 16u);
    }
    if (x + 2u < unit.width) {
        pictures[at + 1u] = inside.z | (inside.w << 16u);
    }
}

// Decodes the 4x4 pixels at `corner` of the node whose first pixel is `origin` and whose coefficients start at word `at`.
fn decode_part(unit: Unit, level: u32, at: u32, origin: vec2u, corner: vec2u) {
    let p = origin + corner;
    if (level == 0u) {
        for (var y = 0u; y < 4u; y++) {
            let pairs = vec2u(stream[at + 2u * y], stream[at + 2u * y + 1u]);
            write_row(unit, p.x, p.y + y, vec4u(pairs.x & 0xffffu, pairs.x >> 16u, pairs.y & 0xffffu, pairs.y >> 16u));
        }
        return;
    }
    if (stream[at + 7u] != NONE) {
        let block = bc4w_at(at);
        for (var y = 0u; y < 4u; y++) {
            var codes: vec4u;
            for (var x = 0u; x < 4u; x++) {
                codes[x] = bc4w_code(block, at, corner.x + x, corner.y + y);
            }
            write_row(unit, p.x, p.y + y, codes);
        }
        return;
    }
    if (stream[at + 6u] != NONE) {
        let platelet = platelet_at(at, level);
        for (var y = 0u; y < 4u; y++) {
            var codes: vec4u;
            for (var x = 0u; x < 4u; x++) {
                codes[x] = code_of(unit, platelet_value(platelet, i32(corner.x + x), i32(corner.y + y)));
            }
            write_row(unit, p.x, p.y + y, codes);
        }
        return;
    }
    let surface = biquadratic_at(at);
    for (var y = 0u; y < 4u; y++) {
        var codes: vec4u;
        for (var x = 0u; x < 4u; x++) {
            codes[x] = code_of(unit, biquadratic_value(surface, i32(corner.x + x), i32(corner.y + y)));
        }
        write_row(unit, p.x, p.y + y, codes);
    }
}

@compute @workgroup_size(WORKGROUP)
fn decode_nodes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let header = records[job.record].at;
    var part = invocation - job_begin(number);
    var node = 0u;
    var level = 0u;
    while (level + 1u < LEVELS) {
        let nodes = stream[header + 1u + level];
        let parts = nodes << (2u * level);
        if (part < parts) {
            break;
        }
        part -= parts;
        node += nodes;
        level++;
    }
    node += part >> (2u * level);
    part &= (1u << (2u * level)) - 1u;
    let places_at = header + NODE_HEADER_WORDS;
    let place = stream[places_at + node / 2u] >> (16u * (node & 1u));
    // Positions take two bytes each and are padded to a multiple of 16 bytes.
    let coefficients_at = places_at + (2u * stream[header] + 15u) / 16u * 4u + 8u * node;
    let origin = vec2u(place & 255u, (place >> 8u) & 255u) << vec2u(level + 2u);
    let corner = vec2u(part & ((1u << level) - 1u), part >> level) * 4u;
    decode_part(unit, level, coefficients_at, origin, corner);
}
