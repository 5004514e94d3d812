// What planning kernels share: sums along the list of items, and the size of the dispatch that follows. Needs `items`,
// `jobs` and `dispatch`.

var<workgroup> sums: array<u32, PLAN_WORKGROUP>;

// The sum of the values of all invocations up to this one; all of them call it together.
fn running_sum(local: u32, value: u32) -> u32 {
    // Nobody may still read the sums of the call before.
    workgroupBarrier();
    sums[local] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < PLAN_WORKGROUP; reach *= 2u) {
        var more = 0u;
        if (local >= reach) {
            more = sums[local - reach];
        }
        workgroupBarrier();
        sums[local] += more;
        workgroupBarrier();
    }
    return sums[local];
}

// Says how much work there is; one invocation calls it.
fn finish_plan(total: u32) {
    jobs.total = total;
    jobs.count = items.count;
    let groups = (total + WORKGROUP - 1u) / WORKGROUP;
    let across = clamp(groups, 1u, MAX_GROUPS);
    dispatch.x = across;
    dispatch.y = (groups + across - 1u) / across;
    dispatch.z = 1u;
}
