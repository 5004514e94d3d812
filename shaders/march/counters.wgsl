// Counters of rendering. Mirrors src/render/march/counters.rs.

const PRIMARY_RAYS = 0u;
const MARCH_STEPS = 1u;
const REFINE_STEPS = 2u;
const SECONDARY_RAYS = 3u;
const NORMAL_EVALS = 4u;
const MATERIAL_SAMPLES = 5u;
const HOLE_RAYS = 6u;
const BACKGROUND_RAYS = 7u;
const COUNTERS = 8u;

// Counts of this invocation.
var<private> counted: array<u32, COUNTERS>;
