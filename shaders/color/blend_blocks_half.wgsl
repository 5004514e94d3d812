// Cells of half floats whose keyframes may be in blocks (color.md 4): `impl Sample for HalfKey` of src/color/blend.rs. An
// invocation writes the 4x4 pixels of a block. Needs `keyframe_block` and `sample_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

fn unpack(pixel: vec2u) -> vec3u {
    return vec3u(pixel.x & 0xffffu, pixel.x >> 16u, pixel.y & 0xffffu);
}

fn pack(color: vec3u) -> vec2u {
    return vec2u(color.x | (color.y << 16u), color.z);
}

// The first pixel of a block.
fn corner_of(unit: Unit, block: u32) -> vec2u {
    let columns = (unit.width + 3u) / 4u;
    return 4u * vec2u(block % columns, block / columns);
}

// The pixels of a block of a keyframe of samples; those outside of the cell repeat others and mean nothing.
fn sample_block(keyframe: Record, unit: Unit, block: u32, out: ptr<function, array<vec2u, 16>>) {
    let corner = corner_of(unit, block);
    for (var texel = 0u; texel < 16u; texel++) {
        let x = min(corner.x + texel % 4u, unit.width - 1u);
        let y = min(corner.y + texel / 4u, unit.height - 1u);
        (*out)[texel] = pack(sample_pixel(keyframe, y * unit.width + x));
    }
}

@compute @workgroup_size(WORKGROUP)
fn decode_blocks_half(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let block = invocation - job_begin(number);
    var pixels: array<vec2u, 16>;
    var next: array<vec2u, 16>;
    keyframe_block(records[job.record], unit, block, &pixels);
    if (job.weight > 0u) {
        keyframe_block(records[job.next], unit, block, &next);
    }
    let corner = corner_of(unit, block);
    for (var texel = 0u; texel < 16u; texel++) {
        let x = corner.x + texel % 4u;
        let y = corner.y + texel / 4u;
        if (x >= unit.width || y >= unit.height) {
            continue;
        }
        var color = unpack(pixels[texel]);
        if (job.weight > 0u) {
            let next_color = unpack(next[texel]);
            color = bits_of(lerp(keys_of(color), keys_of(next_color), job.weight));
        }
        let at = unit.picture + y * unit.stride + 2u * x;
        let words = pack(color);
        pictures[at] = words.x;
        pictures[at + 1u] = words.y;
    }
}
