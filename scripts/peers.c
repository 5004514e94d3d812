/* What scripts/peers does to every pixel, compiled by cc when it runs: RVL (ours, after A. D. Wilson, "Fast lossless depth
 * image compression", 2017), the mapping of CALF 7.1, rows of PNG and EXR files, and errors that are measured.
 * Codes are 16 bits, or 24 bits in 32 where `wide` is set; the largest code is the background, the one below it is far. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* RVL: runs of empty pixels (0) and of others in turn; others as zigzag differences from the other before. Numbers are
 * groups of 3 bits, the lowest first, in nibbles whose top bit says that more follow; 8 nibbles fill a word from its top. */
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

/* Codes one further round: the background, the largest, becomes 0, which is empty for RVL; `back` undoes it. */
void rotate(const uint16_t *in, size_t pixels, uint32_t codes, int back, uint16_t *out) {
    for (size_t i = 0; i < pixels; i++) out[i] = (uint16_t)((in[i] + (back ? codes - 1 : 1)) % codes);
}

/* CALF 7.1: bit i goes to channel i mod 3 (red, green, blue), place i div 3. Planes as ffmpeg's gbrp: green, blue, red. */
static const int PLANE_OF_CHANNEL[3] = {2, 0, 1};

static uint32_t code_at(const void *codes, int wide, size_t i) {
    return wide ? ((const uint32_t *)codes)[i] : ((const uint16_t *)codes)[i];
}

void swizzle(const void *codes, int wide, size_t pixels, uint8_t *planes) {
    for (size_t i = 0; i < pixels; i++) {
        uint32_t code = code_at(codes, wide, i), channels[3] = {0, 0, 0};
        for (int bit = 0; bit < 24; bit++) channels[bit % 3] |= (code >> bit & 1) << bit / 3;
        for (int channel = 0; channel < 3; channel++)
            planes[PLANE_OF_CHANNEL[channel] * pixels + i] = (uint8_t)channels[channel];
    }
}

/* A lossy codec may set bits that 16-bit codes do not have: such a pixel gets the largest code. */
void unswizzle(const uint8_t *planes, int wide, size_t pixels, void *codes) {
    for (size_t i = 0; i < pixels; i++) {
        uint32_t code = 0;
        for (int bit = 0; bit < 24; bit++)
            code |= (uint32_t)(planes[PLANE_OF_CHANNEL[bit % 3] * pixels + i] >> bit / 3 & 1) << bit;
        if (wide) ((uint32_t *)codes)[i] = code;
        else ((uint16_t *)codes)[i] = (uint16_t)(code > 65535 ? 65535 : code);
    }
}

/* Codes of metres after equation 13, as formats/depth.md 2 has it, of 24 bits; `background` are codes of 16 bits that say
 * where there is none. */
void codes24(const float *metres, const uint16_t *background, size_t pixels, double near_m, double far_m, uint32_t *out) {
    const uint32_t top = (1u << 24) - 2;
    double span = log1p((far_m - near_m) / near_m);
    for (size_t i = 0; i < pixels; i++) {
        if (background[i] == 65535) { out[i] = top + 1; continue; }
        double place = span > 0 ? log1p((metres[i] - near_m) / near_m) / span : 0;
        out[i] = (uint32_t)floor(fmin(fmax(place, 0), 1) * top + 0.5);
    }
}

/* Where background agrees, errors in units of 16-bit codes and in metres; `source` holds the metres that were coded, or is
 * null, and then those of the reference codes are. out: largest and sum of squares in codes, the same in metres, pixels
 * that were compared, pixels where one alone is background. */
void compare(const void *reference, const void *got, int wide, size_t pixels, double near_m, double far_m,
             const float *source, double out[6]) {
    const uint32_t top = wide ? (1u << 24) - 2 : 65534;
    double span = log1p((far_m - near_m) / near_m), unit = 65534.0 / top;
    for (int i = 0; i < 6; i++) out[i] = 0;
    for (size_t i = 0; i < pixels; i++) {
        uint32_t a = code_at(reference, wide, i), b = code_at(got, wide, i);
        if (a > top || b > top) { out[5] += (a > top) != (b > top); continue; }
        double codes = fabs((double)a - (double)b) * unit, metres = 0;
        if (source || a != b) {
            double wanted = source ? source[i] : near_m * exp(span * a / top);
            metres = fabs(near_m * exp(span * b / top) - wanted);
        }
        out[0] = fmax(out[0], codes);
        out[1] += codes * codes;
        out[2] = fmax(out[2], metres);
        out[3] += metres * metres;
        out[4] += 1;
    }
}

static uint8_t paeth(int left, int above, int corner) {
    int guess = left + above - corner;
    int a = abs(guess - left), b = abs(guess - above), c = abs(guess - corner);
    return (uint8_t)(a <= b && a <= c ? left : b <= c ? above : corner);
}

/* Rows of a PNG, each behind its filter's byte, to plain rows. `step`: bytes of a pixel. 0 at an unknown filter. */
int png_rows(const uint8_t *in, size_t rows, size_t row_bytes, size_t step, uint8_t *out) {
    for (size_t y = 0; y < rows; y++) {
        int filter = *in++;
        uint8_t *row = out + y * row_bytes;
        const uint8_t *above = y ? row - row_bytes : NULL;
        if (filter > 4) return 0;
        for (size_t x = 0; x < row_bytes; x++) {
            int left = x >= step ? row[x - step] : 0, up = above ? above[x] : 0;
            int corner = above && x >= step ? above[x - step] : 0;
            int guesses[5] = {0, left, up, (left + up) / 2, paeth(left, up, corner)};
            row[x] = (uint8_t)(*in++ + guesses[filter]);
        }
    }
    return 1;
}

/* The last two steps of EXR's ZIP: running sums, then two halves that interleave. */
void exr_unpredict(uint8_t *data, size_t count, uint8_t *out) {
    for (size_t i = 1; i < count; i++) data[i] = (uint8_t)(data[i - 1] + data[i] - 128);
    for (size_t i = 0; i < count; i++) out[i] = data[i / 2 + (i % 2 ? (count + 1) / 2 : 0)];
}
