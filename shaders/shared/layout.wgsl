// Structs and constants that src/gpu/layout.rs knows too; a test compares them.

struct Unit {
    picture: u32,
    width: u32,
    height: u32,
    stride: u32,
    window: u32,
    domain: u32,
    base: u32,
    scale: u32,
}

struct Chunk {
    first_record: u32,
    record_count: u32,
    weights_at: u32,
    weight_count: u32,
}

struct Record {
    frame: u32,
    at: u32,
    first: u32,
    count: u32,
    work: u32,
    coding: u32,
}

struct BoxRow {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    at: u32,
    coding: u32,
    end: u32,
}

struct Item {
    unit: u32,
    chunk: u32,
    next: u32,
    frame: u32,
    key: u32,
}

struct State {
    key: u32,
    frame: u32,
    weight: u32,
}

struct Job {
    unit: u32,
    end: u32,
    record: u32,
    next: u32,
    weight: u32,
}

struct Dispatch {
    x: u32,
    y: u32,
    z: u32,
}

struct DepthJob {
    picture: u32,
    stride: u32,
    left: u32,
    top: u32,
    width: u32,
    table: u32,
    stretch: u32,
    stretch_pitch: u32,
    place: u32,
    pitch: u32,
    end: u32,
}

struct SquareJob {
    below: u32,
    below_pitch: u32,
    below_width: u32,
    below_height: u32,
    left: u32,
    top: u32,
    width: u32,
    place: u32,
    pitch: u32,
    most: u32,
    end: u32,
}

// Lists: two words before the rows.

struct Items {
    count: u32,
    spare: u32,
    list: array<Item>,
}

struct Jobs {
    total: u32,
    count: u32,
    list: array<Job>,
}

struct DepthJobs {
    total: u32,
    count: u32,
    list: array<DepthJob>,
}

struct SquareJobs {
    total: u32,
    count: u32,
    list: array<SquareJob>,
}

const NONE: u32 = 0xffffffffu;
const WORKGROUP: u32 = 64u;
const PLAN_WORKGROUP: u32 = 256u;
const MAX_GROUPS: u32 = 65535u;
const NODE_HEADER_WORDS: u32 = 12u;
const LEVELS: u32 = 9u;
const BOX_VALUES: u32 = 0u;
const BOX_CONSTANT: u32 = 1u;
const BOX_BLOCKS: u32 = 2u;
const KEYFRAME_SAMPLES: u32 = 0u;
const KEYFRAME_BLOCKS: u32 = 1u;
const DOMAIN_LOG: u32 = 0u;
const DOMAIN_LINEAR: u32 = 1u;
const DOMAIN_INVERSE: u32 = 2u;
