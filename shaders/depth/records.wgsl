// Records of boxes (depth.md 4). Mirrors src/codec/depth/records.rs. Needs `units`, `records`, `jobs` and `boxes`.

// The part of a box that one invocation writes.
struct BoxPart {
    unit: u32,
    row: u32,
    // Index of the part in its box.
    part: u32,
}

fn box_part(invocation: u32) -> BoxPart {
    let number = job_of(invocation);
    let job = jobs.list[number];
    let record = records[job.record];
    let part = invocation - job_begin(number);
    var low = record.first;
    var high = record.first + record.count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (boxes[middle].end <= part) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var begin = 0u;
    if (low > record.first) {
        begin = boxes[low - 1u].end;
    }
    return BoxPart(job.unit, low, part - begin);
}
