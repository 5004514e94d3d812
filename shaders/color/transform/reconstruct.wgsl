// Inverse transform of one frame of a region (color.md 6.3), one workgroup per region: all invocations transform one block at a
// time. Mirrors src/codec/color/transform/reconstruct.rs.

// Coefficients after the column transform, 32 per row.
var<workgroup> columns: array<i32, 1024>;
var<workgroup> leaf_count: u32;
var<workgroup> next: u32;
var<workgroup> leaves: array<Leaf, 64>;

// Luma and green chroma of this invocation's pixels.
var<private> luma: array<i32, 16>;
var<private> green: array<i32, 16>;

// Returns the number of columns and rows of a channel's coefficients.
fn extent_of(leaf: Leaf, channel: u32) -> vec2u {
    return ((vec2u(leaf.extents) >> vec2u(10u * channel, 10u * channel + 5u)) & vec2u(31u)) + 1u;
}

fn transform_columns(local: u32, level: u32, first: u32, extent: vec2u) {
    let side = 4u << level;
    let functions = basis_at(side);
    let columns_bits = firstLeadingBit(2u * extent.x - 1u);
    for (var at = local; at < (side << columns_bits); at += WORKGROUP) {
        let x = at & ((1u << columns_bits) - 1u);
        let y = at >> columns_bits;
        var sum = 128;
        for (var k = 0u; k < extent.y; k++) {
            let coefficient = scratch[region_slot].coefficients[first + 32u * k + x];
            sum += ((coefficient + 128) >> 8u) * i32(tables[functions + side * k + y]);
        }
        columns[32u * y + x] = sum >> 8u;
    }
}

fn transform_rows(local: u32, place: vec2u, level: u32, channel: u32, column_count: u32) {
    let side = 4u << level;
    let functions = basis_at(side);
    let fraction = pixel_fraction();
    let shift = 10u + FRACTION_BITS - fraction + level;
    for (var turn = 0u; turn * WORKGROUP + local < side * side; turn++) {
        let at = turn * WORKGROUP + local;
        let x = at & (side - 1u);
        let y = at >> (2u + level);
        var sum = 1 << (shift - 1u);
        for (var k = 0u; k < column_count; k++) {
            sum += columns[32u * y + k] * i32(tables[functions + side * k + x]);
        }
        let value = sum >> shift;
        if (channel == 0u) {
            luma[turn] = value;
        } else if (channel == 1u) {
            green[turn] = value;
        } else {
            let fine = keys_of_channels(vec3i(luma[turn], green[turn], value), fraction);
            let keys = (fine + ((1 << fraction) >> 1u)) >> vec3u(fraction);
            put(4u * place.x + x, 4u * place.y + y, clamp(keys, vec3i(MIN_KEY), vec3i(MAX_KEY)));
        }
    }
}

fn clear_coefficients(local: u32, first: u32, extent: vec2u) {
    let columns_bits = firstLeadingBit(2u * extent.x - 1u);
    for (var at = local; at < (extent.y << columns_bits); at += WORKGROUP) {
        scratch[region_slot].coefficients[first + 32u * (at >> columns_bits) + (at & ((1u << columns_bits) - 1u))] = 0;
    }
}

// Resets the fields that must be 0 before the next frame.
fn clear_scratch(local: u32) {
    for (var at = local; at < 1088u; at += WORKGROUP) {
        scratch[region_slot].magnitudes[at] = 0u;
    }
    if (local == 0u) {
        scratch[region_slot].reader = Reader();
        scratch[region_slot].leaf_count = 0u;
    }
}

@compute @workgroup_size(WORKGROUP)
fn show_regions(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = group.x + group.y * groups.x;
    if (number >= jobs.total) {
        return;
    }
    _ = find_region(number);
    leaves[local] = scratch[region_slot].leaves[local];
    if (local == 0u) {
        leaf_count = scratch[region_slot].leaf_count;
        next = scratch[region_slot].reader.next;
    }
    let count = workgroupUniformLoad(&leaf_count);
    for (var at = 0u; at < count; at++) {
        let leaf = workgroupUniformLoad(&leaves[at]);
        let place = vec2u(leaf.place & 7u, (leaf.place >> 3u) & 7u);
        let level = leaf.place >> 6u;
        for (var channel = 0u; channel < 3u; channel++) {
            let first = coefficients_at(channel, place.x, place.y);
            let extent = extent_of(leaf, channel);
            transform_columns(local, level, first, extent);
            workgroupBarrier();
            transform_rows(local, place, level, channel, extent.x);
            clear_coefficients(local, first, extent);
            workgroupBarrier();
        }
    }
    if (workgroupUniformLoad(&next) != NEXT_END) {
        // Reading stopped early: the block that was being read has coefficients but is not in `leaves`.
        for (var at = local; at < 3072u; at += WORKGROUP) {
            scratch[region_slot].coefficients[at] = 0;
        }
    }
    clear_scratch(local);
}
