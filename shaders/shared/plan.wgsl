// What planning kernels share: the size of the dispatch that follows. Needs `items`, `jobs` and `dispatch`.

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
