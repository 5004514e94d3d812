// Maps an invocation to its job and its part of the job (GDC 5, algorithm 2). Needs `jobs`.

// Returns the index of an invocation in a dispatch whose workgroups may extend in x and y.
fn invocation_of(id: vec3u, groups: vec3u) -> u32 {
    return id.x + id.y * groups.x * WORKGROUP;
}

// Returns the first job that ends after an invocation; requires invocation < `jobs.total`.
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

// Returns the first invocation of a job.
fn job_begin(job: u32) -> u32 {
    if (job == 0u) {
        return 0u;
    }
    return jobs.list[job - 1u].end;
}
