// Prefix sums over the invocations of a workgroup.

const SUM_WORKGROUP: u32 = 256u;

var<workgroup> sums: array<u32, SUM_WORKGROUP>;

// Returns the inclusive prefix sum of the values up to this invocation. All invocations of the workgroup must call it.
fn running_sum(local: u32, value: u32) -> u32 {
    // Waits until all invocations have read the sums of the previous call.
    workgroupBarrier();
    sums[local] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < SUM_WORKGROUP; reach *= 2u) {
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
