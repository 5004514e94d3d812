// Computes the size of the next dispatch; shared by the planning kernels. Needs `items`, `jobs` and `dispatch`.

// Returns the number of workgroups along x and y for `count` workgroups in total.
fn groups_of(count: u32) -> vec2u {
    let across = clamp(count, 1u, MAX_GROUPS);
    return vec2u(across, (count + across - 1u) / across);
}

// Writes the totals of the plan and the size of the next dispatch. Called by one invocation.
fn finish_plan(total: u32) {
    jobs.total = total;
    jobs.count = items.count;
    let invocation_groups = groups_of((total + WORKGROUP - 1u) / WORKGROUP);
    let part_groups = groups_of(total);
    dispatch = Dispatch(invocation_groups.x, invocation_groups.y, 1u, part_groups.x, part_groups.y, 1u);
}
