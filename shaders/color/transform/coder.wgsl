// Reads symbols and raw bits of a region's substream (color.md 6.6, 7). Mirrors src/codec/color/transform/coder.rs and
// src/codec/entropy/rans.rs. The host has checked that the substream is long enough for everything that is read. Needs `reader`,
// `stream` and `tables`.

// Index in `tables` of the first word of the chunk's distributions.
var<private> distributions: u32;

// A substream is a list of words: its initial state, then pairs of 16-bit words.
fn open_substream(word: u32) {
    reader.state = stream[word];
    reader.next_half = 2u * word + 2u;
}

fn renormalise() {
    if (reader.state < 0x10000u) {
        let half = (stream[reader.next_half >> 1u] >> ((reader.next_half & 1u) * 16u)) & 0xffffu;
        reader.state = (reader.state << 16u) | half;
        reader.next_half++;
    }
}

// Returns the first slot of a symbol.
fn start_at(symbol: u32) -> u32 {
    return tables[symbol] & 0xffffu;
}

fn symbol(context: u32) -> u32 {
    let first = distributions + tables[CLUSTERS_AT + context];
    let slot = reader.state & 4095u;
    // Finds the last symbol whose start is at or before the slot. A symbol without slots has the same start as the next one.
    var at = first + select(0u, 8u, start_at(first + 8u) <= slot);
    at += select(0u, 4u, start_at(at + 4u) <= slot);
    at += select(0u, 2u, start_at(at + 2u) <= slot);
    at += select(0u, 1u, start_at(at + 1u) <= slot);
    let slots = tables[at];
    let start = slots & 0xffffu;
    reader.state = ((slots >> 16u) - start) * (reader.state >> 12u) + slot - start;
    renormalise();
    return at - first;
}

fn flag(context: u32) -> bool {
    return symbol(context) == 1u;
}

// Reads at most 12 raw bits.
fn few_bits(count: u32) -> u32 {
    let value = reader.state & ((1u << count) - 1u);
    reader.state >>= count;
    renormalise();
    return value;
}

// Reads at most 24 raw bits.
fn bits(count: u32) -> u32 {
    var high = 0u;
    if (count > 12u) {
        high = few_bits(count - 12u);
    }
    let low = min(count, 12u);
    return (high << low) | few_bits(low);
}

fn number(context: u32) -> u32 {
    let kind = symbol(context);
    if (kind < 12u) {
        return kind;
    }
    var count = kind - 11u;
    var base = 10u;
    if (kind == 15u) {
        count = min(few_bits(5u), 22u);
        base = 25u;
    }
    return (1u << count) + base + bits(count);
}
