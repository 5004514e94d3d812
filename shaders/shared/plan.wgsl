// What planning kernels share: the size of the dispatch that follows. Needs `items`, `jobs` and `dispatch`.

// Workgroups along x and y for so many in all.
fn groups_of(count: u32) -> vec2u {
    let across = clamp(count, 1u, MAX_GROUPS);
    return vec2u(across, (count + across - 1u) / across);
}

// Says how much work there is; one invocation calls it.
fn finish_plan(total: u32) {
    jobs.total = total;
    jobs.count = items.count;
    let invocation_groups = groups_of((total + WORKGROUP - 1u) / WORKGROUP);
    let part_groups = groups_of(total);
    dispatch = Dispatch(invocation_groups.x, invocation_groups.y, 1u, part_groups.x, part_groups.y, 1u);
}
