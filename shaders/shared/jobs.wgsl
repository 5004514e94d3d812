// Which job an invocation works on, and which part of it (GDC 5, algorithm 2). Needs `jobs`.

// Number of an invocation among all of a dispatch, whose workgroups may lie in two directions.
fn invocation_of(id: vec3u, groups: vec3u) -> u32 {
    return id.x + id.y * groups.x * WORKGROUP;
}

// The first job whose end lies behind an invocation; `jobs.total` is larger than its number.
fn job_of(invocation: u32) -> u32 {
    var low = 0u;
    var high = jobs.count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (jobs.list[middle].end <= invocation) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// The first invocation of a job.
fn job_begin(job: u32) -> u32 {
    if (job == 0u) {
        return 0u;
    }
    return jobs.list[job - 1u].end;
}
