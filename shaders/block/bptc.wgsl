// Functions and tables shared by BC6H and BC7 (blocks.md 6). Mirrors src/codec/block/bptc.rs.

// Partitions into two subsets: bit t is the subset of pixel t; bits 16 to 19 are the anchor of subset 1.
const BPTC_TWO = array<u32, 64>(
    0xfccccu, 0xf8888u, 0xfeeeeu, 0xfecc8u, 0xfc880u, 0xffeecu, 0xffec8u, 0xfec80u,
    0xfc800u, 0xfffecu, 0xffe80u, 0xfe800u, 0xfffe8u, 0xfff00u, 0xffff0u, 0xff000u,
    0xff710u, 0x2008eu, 0x87100u, 0x208ceu, 0x2008cu, 0x87310u, 0x83100u, 0xf8cceu,
    0x2088cu, 0x83110u, 0x26666u, 0x2366cu, 0x817e8u, 0x80ff0u, 0x2718eu, 0x2399cu,
    0xfaaaau, 0xff0f0u, 0x65a5au, 0x833ccu, 0x23c3cu, 0x855aau, 0xf9696u, 0xfa55au,
    0x273ceu, 0x813c8u, 0x2324cu, 0x23bdcu, 0x26996u, 0xfc33cu, 0xf9966u, 0x60660u,
    0x60272u, 0x204e4u, 0x64e40u, 0x82720u, 0xfc936u, 0xf936cu, 0x239c6u, 0x2639cu,
    0xf9336u, 0xf9cc6u, 0xf817eu, 0xfe718u, 0xfccf0u, 0x20fccu, 0x27744u, 0xfee22u,
);

// Partitions into three subsets: bits 2t and 2t + 1 are the subset of pixel t.
const BPTC_THREE = array<u32, 64>(
    0xaa685050u, 0x6a5a5040u, 0x5a5a4200u, 0x5450a0a8u, 0xa5a50000u, 0xa0a05050u, 0x5555a0a0u, 0x5a5a5050u,
    0xaa550000u, 0xaa555500u, 0xaaaa5500u, 0x90909090u, 0x94949494u, 0xa4a4a4a4u, 0xa9a59450u, 0x2a0a4250u,
    0xa5945040u, 0x0a425054u, 0xa5a5a500u, 0x55a0a0a0u, 0xa8a85454u, 0x6a6a4040u, 0xa4a45000u, 0x1a1a0500u,
    0x0050a4a4u, 0xaaa59090u, 0x14696914u, 0x69691400u, 0xa08585a0u, 0xaa821414u, 0x50a4a450u, 0x6a5a0200u,
    0xa9a58000u, 0x5090a0a8u, 0xa8a09050u, 0x24242424u, 0x00aa5500u, 0x24924924u, 0x24499224u, 0x50a50a50u,
    0x500aa550u, 0xaaaa4444u, 0x66660000u, 0xa5a0a5a0u, 0x50a050a0u, 0x69286928u, 0x44aaaa44u, 0x66666600u,
    0xaa444444u, 0x54a854a8u, 0x95809580u, 0x96969600u, 0xa85454a8u, 0x80959580u, 0xaa141414u, 0x96960000u,
    0xaaaa1414u, 0xa05050a0u, 0xa0a5a5a0u, 0x96000000u, 0x40804080u, 0xa9a8a9a8u, 0xaaaaaa44u, 0x2a4a5254u,
);

// Anchors of subsets 1 and 2 of the partitions into three subsets: four bits each, four partitions per word.
const BPTC_ANCHORS_OF_THREE = array<u32, 16>(
    0x3f8f83f3u, 0x8f3ff3f8u, 0xf6f6f8f8u, 0x83f3f5f6u, 0x3ff883f3u, 0x8af683f3u, 0xa668f835u, 0x8faff5f8u,
    0xa5f33ff8u, 0xaf988aa6u, 0xf58ff36fu, 0x8f6f6f3fu, 0xf5f53ff3u, 0xfaf5f8f5u, 0xfdf8faf5u, 0x83f3fc3fu,
);

// Returns `count` bits of a block, at most 32, starting at bit `at`.
fn bptc_bits(words: vec4u, at: u32, count: u32) -> u32 {
    let shift = at & 31u;
    var bits = words[at >> 5u] >> shift;
    if (shift + count > 32u) {
        bits |= words[(at >> 5u) + 1u] << (32u - shift);
    }
    return bits & ((1u << count) - 1u);
}

struct BptcPartition {
    // Bits 2t and 2t + 1: the subset of pixel t.
    map: u32,
    // Bit t: pixel t is the anchor of its subset.
    anchors: u32,
}

// Returns partition `number` into `subsets` (1, 2 or 3) subsets.
fn bptc_partition(subsets: u32, number: u32) -> BptcPartition {
    if (subsets == 2u) {
        let row = BPTC_TWO[number];
        var map = row & 0xffffu;
        map = (map | (map << 8u)) & 0x00ff00ffu;
        map = (map | (map << 4u)) & 0x0f0f0f0fu;
        map = (map | (map << 2u)) & 0x33333333u;
        map = (map | (map << 1u)) & 0x55555555u;
        return BptcPartition(map, 1u | (1u << (row >> 16u)));
    }
    if (subsets == 3u) {
        let anchors = BPTC_ANCHORS_OF_THREE[number >> 2u] >> ((number & 3u) * 8u);
        return BptcPartition(BPTC_THREE[number], 1u | (1u << (anchors & 15u)) | (1u << ((anchors >> 4u) & 15u)));
    }
    return BptcPartition(0u, 1u);
}

fn bptc_subset(parts: BptcPartition, texel: u32) -> u32 {
    return (parts.map >> (2u * texel)) & 3u;
}

// Returns the index of a pixel. The indices start at bit `at` and have `count` bits each, those of anchor pixels one bit less.
fn bptc_index(words: vec4u, at: u32, count: u32, parts: BptcPartition, texel: u32) -> u32 {
    let anchors_before = countOneBits(parts.anchors & ((1u << texel) - 1u));
    return bptc_bits(words, at + texel * count - anchors_before, count - ((parts.anchors >> texel) & 1u));
}

// Returns the weight of an index of 2, 3 or 4 bits, in 64ths. The formula yields the rows of the table in blocks.md 6.
fn bptc_weight(index: u32, count: u32) -> u32 {
    let last = (1u << count) - 1u;
    return (64u * index + last / 2u) / last;
}

// Interpolates between two endpoints by an index of `count` bits.
fn bptc_mix(a: vec3u, b: vec3u, index: u32, count: u32) -> vec3u {
    let weight = bptc_weight(index, count);
    return (a * (64u - weight) + b * weight + 32u) >> vec3u(6u);
}
