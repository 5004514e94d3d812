// One frame of a region (color.md 6.3), a workgroup each: one invocation reads, all transform blocks. Mirrors
// src/color/transform/reconstruct.rs. A chunk is words: its table set, from the first of its stream's sets; slopes of chroma;
// number of colours; number of frames; set of frequency offsets; the colours, two words each. A region is the step indices of its
// channels and its substream. Needs `put_pixel` and `sample_of`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read> tables: array<u32>;
@group(0) @binding(6) var<storage, read_write> pictures: array<u32>;

const OFFSET_SET: u32 = 5u;
const COLORS: u32 = 6u;

// Columns transformed of `coefficients`, 32 a row; indices of palettes while these are read.
var<workgroup> scratch: array<i32, 1024>;
var<workgroup> stopped: Stop;

// First word of the chunk.
var<private> chunk: u32;
var<private> unit: Unit;
var<private> region: BoxRow;
// Luma and green chroma of this invocation's pixels.
var<private> luma: array<i32, 16>;
var<private> green: array<i32, 16>;

fn slope_of(channel: u32) -> i32 {
    return i32(stream[chunk + channel]);
}

// The step of a sum of spatial frequencies of blocks of a size and length.
fn step_of(channel: u32, length: u32, level: u32, frequency: u32) -> i32 {
    let table = 2u * stream[chunk + OFFSET_SET] + min(channel, 1u);
    let offset = tables[OFFSETS_AT + 64u * table + (((2u * frequency + 1u) << (3u - level)) >> 1u)];
    let index = u32(clamp(i32(stream[region.at / 4u + channel] + offset), 0, 255));
    let mantissa = (tables[OCTAVE_AT + (index & 15u)] * tables[ROOTS_AT + length] + 2048u) >> 12u;
    let shift = 11u - FRACTION_BITS;
    return i32(max(((mantissa << (index >> 4u)) + (1u << (shift - 1u))) >> shift, 1u));
}

// Bits of the fraction of the channels of pixels.
fn pixel_fraction() -> u32 {
    return select(0u, FINE_BITS, stream[chunk + OFFSET_SET] > 0u);
}

// Fills the cache with the chunk's colours, and answers their number.
fn open_cache() -> u32 {
    let count = stream[chunk + 3u];
    for (var at = 0u; at < count; at++) {
        let color = chunk + COLORS + 2u * at;
        cache[at] = vec2u(stream[color], stream[color + 1u]);
    }
    return count;
}

// Writes pixel (x, y) of the region, unless it lies outside.
fn put(x: u32, y: u32, keys: vec3i) {
    if (x < region.width && y < region.height) {
        put_pixel(unit, (region.y + y) * unit.width + region.x + x, sample_of(keys));
    }
}

fn transform_columns(local: u32, level: u32, columns_bits: u32, rows: u32) {
    let side = 4u << level;
    let functions = basis_at(side);
    for (var at = local; at < (side << columns_bits); at += WORKGROUP) {
        let x = at & ((1u << columns_bits) - 1u);
        let y = at >> columns_bits;
        var sum = 128;
        for (var k = 0u; k < rows; k++) {
            sum += ((coefficients[32u * k + x] + 128) >> 8u) * i32(tables[functions + side * k + y]);
        }
        scratch[32u * y + x] = sum >> 8u;
    }
}

fn transform_rows(local: u32, block: Block, channel: u32, columns: u32) {
    let side = 4u << block.level;
    let functions = basis_at(side);
    let fraction = pixel_fraction();
    let shift = 10u + FRACTION_BITS - fraction + block.level;
    for (var turn = 0u; turn * WORKGROUP + local < side * side; turn++) {
        let at = turn * WORKGROUP + local;
        let x = at & (side - 1u);
        let y = at >> (2u + block.level);
        var sum = 1 << (shift - 1u);
        for (var k = 0u; k < columns; k++) {
            sum += scratch[32u * y + k] * i32(tables[functions + side * k + x]);
        }
        let value = sum >> shift;
        if (channel == 0u) {
            luma[turn] = value;
        } else if (channel == 1u) {
            green[turn] = value;
        } else {
            let fine = keys_of_channels(vec3i(luma[turn], green[turn], value), fraction);
            let keys = (fine + ((1 << fraction) >> 1u)) >> vec3u(fraction);
            put(4u * block.x + x, 4u * block.y + y, clamp(keys, vec3i(LEAST_KEY), vec3i(MOST_KEY)));
        }
    }
}

fn clear_coefficients(local: u32, columns_bits: u32, rows: u32) {
    for (var at = local; at < (rows << columns_bits); at += WORKGROUP) {
        coefficients[32u * (at >> columns_bits) + (at & ((1u << columns_bits) - 1u))] = 0;
    }
}

fn show_palette(local: u32, now: Stop) {
    let side = 4u << now.block.level;
    for (var at = local; at < side * side; at += WORKGROUP) {
        let x = at & (side - 1u);
        let y = at >> (2u + now.block.level);
        put(4u * now.block.x + x, 4u * now.block.y + y, palette_keys(x, y, now.color_count, now.slot));
    }
}

@compute @workgroup_size(WORKGROUP)
fn decode_regions(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let invocation = WORKGROUP * (group.x + group.y * groups.x);
    if (invocation >= jobs.total) {
        return;
    }
    let place = job_of(invocation);
    let job = jobs.list[place];
    let record = records[job.record];
    unit = units[job.unit];
    region = boxes[record.first + (invocation - job_begin(place)) / WORKGROUP];
    chunk = record.at / 4u;
    distributions = unit.base + stream[chunk];
    wanted_frame = record.frame;
    if (local == 0u) {
        open_substream(region.at / 4u + 3u);
        open_region(vec2u(region.width, region.height), stream[chunk + 4u]);
    }
    var reading = 0u;
    loop {
        workgroupBarrier();
        if (local == reading) {
            stopped = read_region();
        }
        let now = workgroupUniformLoad(&stopped);
        reading = now.turn * TURN_INVOCATIONS % WORKGROUP;
        switch (now.reason) {
            case STOP_CHANNEL: {
                let columns_bits = firstLeadingBit(2u * now.extent.x - 1u);
                transform_columns(local, now.block.level, columns_bits, now.extent.y);
                workgroupBarrier();
                transform_rows(local, now.block, now.channel, now.extent.x);
                clear_coefficients(local, columns_bits, now.extent.y);
            }
            case STOP_PALETTE: {
                show_palette(local, now);
            }
            case STOP_MEANS: {
                // An invocation each.
                if (local < (1u << (2u * now.block.level))) {
                    let x = local & ((1u << now.block.level) - 1u);
                    note_palette(now.block, x, local >> now.block.level, now.color_count, now.slot);
                }
            }
            default: {
            }
        }
        if (now.reason == STOP_END) {
            break;
        }
    }
}
