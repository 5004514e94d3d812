/* RVL, compiled by cc when scripts/peers runs; ours, after A. D. Wilson, "Fast lossless depth image compression", 2017: runs of
 * empty pixels (0) and of others in turn; others as zigzag differences from the other before. Numbers are groups of 3 bits, the
 * lowest first, in nibbles whose top bit says that more follow; 8 nibbles fill a word from its top. */
#include <stddef.h>
#include <stdint.h>

typedef struct {
    uint32_t *words;
    size_t count, limit;
    uint32_t word;
    int free;
} Nibbles;

static void put(Nibbles *to, uint32_t value) {
    do {
        uint32_t nibble = value & 7;
        value >>= 3;
        to->word = to->word << 4 | (value ? nibble | 8 : nibble);
        if (--to->free == 0) {
            to->words[to->count++] = to->word;
            to->free = 8;
        }
    } while (value);
}

/* Bytes written; `out` has room for 4 * pixels + 16. */
size_t rvl_encode(const uint16_t *in, size_t pixels, uint32_t *out) {
    Nibbles to = {out, 0, 0, 0, 8};
    const uint16_t *end = in + pixels;
    int32_t previous = 0;
    while (in < end) {
        const uint16_t *start = in;
        while (in < end && *in == 0) in++;
        put(&to, (uint32_t)(in - start));
        for (start = in; in < end && *in != 0;) in++;
        put(&to, (uint32_t)(in - start));
        for (; start < in; start++) {
            int32_t delta = (int32_t)*start - previous;
            put(&to, (uint32_t)delta << 1 ^ (uint32_t)(delta >> 31));
            previous = *start;
        }
    }
    if (to.free < 8) out[to.count++] = to.word << 4 * to.free;
    return to.count * sizeof *out;
}

static int get(Nibbles *from, uint32_t *value) {
    uint32_t result = 0, nibble;
    int shift = 0;
    do {
        if (from->free == 0) {
            if (from->count == from->limit) return 0;
            from->word = from->words[from->count++];
            from->free = 8;
        }
        nibble = from->word >> 28;
        from->word <<= 4;
        from->free--;
        result |= (nibble & 7) << shift;
        shift += 3;
    } while (nibble & 8 && shift < 30);
    *value = result;
    return !(nibble & 8);
}

/* 1, or 0 where the bytes are not those of so many pixels. */
int rvl_decode(const uint32_t *in, size_t bytes, uint16_t *out, size_t pixels) {
    Nibbles from = {(uint32_t *)in, 0, bytes / sizeof *in, 0, 0};
    uint16_t *end = out + pixels;
    int32_t previous = 0;
    while (out < end) {
        uint32_t empty, others, code;
        if (!get(&from, &empty) || empty > (size_t)(end - out)) return 0;
        while (empty--) *out++ = 0;
        if (!get(&from, &others) || others > (size_t)(end - out)) return 0;
        while (others--) {
            if (!get(&from, &code)) return 0;
            previous += (int32_t)(code >> 1) ^ -(int32_t)(code & 1);
            *out++ = (uint16_t)previous;
        }
    }
    return 1;
}
