// Prefix sums over the invocations of a workgroup.

const SUM_WORKGROUP: u32 = 256u;

var<workgroup> sums: array<u32, SUM_WORKGROUP>;

// The sum of the values of all invocations up to this one; all of them call it together.
fn running_sum(local: u32, value: u32) -> u32 {
    // Nobody may still read the sums of the call before.
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
