// Plans depth units: the record that each listed unit applies next, and its amount of work (depth.md 4). A dispatch plans one
// step per unit. Mirrors src/codec/depth/record_table.rs.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> chunks: array<Chunk>;
@group(0) @binding(2) var<storage, read> records: array<Record>;
@group(0) @binding(3) var<storage, read> items: Items;
@group(0) @binding(4) var<storage, read_write> states: array<State>;
@group(0) @binding(5) var<storage, read_write> jobs: Jobs;
@group(0) @binding(6) var<storage, read_write> dispatch: Dispatch;

// Frame on which a step ends, and the record of that frame; NONE if it has no record.
struct Landing {
    frame: u32,
    record: u32,
}

// Returns the index in the chunk of the first record whose frame is at or after `frame`.
fn records_below(chunk: Chunk, frame: u32) -> u32 {
    var low = 0u;
    var high = chunk.record_count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (records[chunk.first_record + middle].frame < frame) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Steps by at most `window` frames until a step ends on a record or on the target. A window of 0 goes directly to the target.
fn land(chunk: Chunk, start: u32, target_frame: u32, window: u32) -> Landing {
    var frame = start;
    while (frame < target_frame) {
        if (window == 0u) {
            frame = target_frame;
        } else {
            // Skips all steps that end on no record at once: they change nothing.
            let next = records_below(chunk, frame + 1u);
            var stop = target_frame;
            if (next < chunk.record_count) {
                stop = min(stop, records[chunk.first_record + next].frame);
            }
            frame += (stop - frame - 1u) / window * window;
            frame += min(window, target_frame - frame);
        }
        let found = records_below(chunk, frame);
        if (found < chunk.record_count && records[chunk.first_record + found].frame == frame) {
            return Landing(frame, chunk.first_record + found);
        }
    }
    return Landing(target_frame, NONE);
}

fn next_record(item: Item) -> u32 {
    let chunk = chunks[item.chunk];
    let window = units[item.unit].window;
    let state = states[item.unit];
    var landing: Landing;
    if (state.key == item.key && state.frame <= item.frame) {
        landing = land(chunk, state.frame, item.frame, window);
    } else if (window == 0u && item.frame > 0u) {
        landing = land(chunk, 0u, item.frame, window);
    } else {
        landing = Landing(0u, chunk.first_record);
    }
    // If no further record follows, the target frame is reached.
    let more = land(chunk, landing.frame, item.frame, window);
    let frame = select(landing.frame, item.frame, more.record == NONE);
    states[item.unit] = State(item.key, frame, 0u);
    return landing.record;
}

@compute @workgroup_size(SUM_WORKGROUP)
fn plan_records(@builtin(local_invocation_index) local: u32) {
    var before = 0u;
    for (var first = 0u; first < items.count; first += SUM_WORKGROUP) {
        let at = first + local;
        var record = NONE;
        var work = 0u;
        if (at < items.count) {
            record = next_record(items.list[at]);
            if (record != NONE) {
                work = records[record].work;
            }
        }
        let end = before + running_sum(local, work);
        if (at < items.count) {
            jobs.list[at] = Job(items.list[at].unit, end, record, NONE, 0u);
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
    if (local == 0u) {
        finish_plan(before);
    }
}
