// Plans colour cells: the two keyframes that each listed cell blends, and their weight (color.md 4). Mirrors
// src/codec/color/cells.rs.

@group(0) @binding(0) var<storage, read> chunks: array<Chunk>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> items: Items;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> states: array<State>;
@group(0) @binding(5) var<storage, read_write> jobs: Jobs;
@group(0) @binding(6) var<storage, read_write> dispatch: Dispatch;

// Returns the index in the chunk of the last keyframe at or before a frame.
fn keyframe_of(chunk: Chunk, frame: u32) -> u32 {
    var low = 0u;
    var high = chunk.record_count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (records[chunk.first_record + middle].frame <= frame) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low - 1u;
}

// Returns the job that blends an item's frame; an empty job if the cell already shows that frame.
fn blend_of(item: Item) -> Job {
    let chunk = chunks[item.chunk];
    let keyframe = keyframe_of(chunk, item.frame);
    var weight = 0u;
    if (item.frame < chunk.weight_count) {
        weight = byte_at(chunk.weights_at + item.frame);
    }
    let wanted = State(item.key, keyframe, weight);
    let shown = states[item.unit];
    if (shown.key == wanted.key && shown.frame == wanted.frame && shown.weight == wanted.weight) {
        return Job(item.unit, 0u, NONE, NONE, 0u);
    }
    states[item.unit] = wanted;
    let first = chunk.first_record + keyframe;
    var next = first;
    if (weight > 0u) {
        next = first + 1u;
        if (keyframe + 1u == chunk.record_count) {
            next = chunks[item.next].first_record;
        }
    }
    return Job(item.unit, 0u, first, next, weight);
}

@compute @workgroup_size(SUM_WORKGROUP)
fn plan_cells(@builtin(local_invocation_index) local: u32) {
    var before = 0u;
    for (var first = 0u; first < items.count; first += SUM_WORKGROUP) {
        let at = first + local;
        var job: Job;
        var work = 0u;
        if (at < items.count) {
            job = blend_of(items.list[at]);
            if (job.record != NONE) {
                work = records[job.record].work;
            }
        }
        job.end = before + running_sum(local, work);
        if (at < items.count) {
            jobs.list[at] = job;
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
    if (local == 0u) {
        finish_plan(before);
    }
}
